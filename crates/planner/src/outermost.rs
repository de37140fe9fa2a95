//! Which parts of lines decide where open water ends.
//!
//! What is cut out of the water for a wide clearance lies over itself many times where a harbour has much detail: a quay behind
//! another changes nothing. The border of all that is cut out consists of points so far from the nearest line as the
//! clearance; so a raster of distances (one pass along rows, one across) tells where that border can run, and only sides that
//! lie so far from such a place are needed. The others leave holes within what they would have cut out, apart from all open
//! water, of which the chart says that they are closed.

use crate::plane::Point;
use crate::region::Region;
use crate::{Cancel, PlanError};

/// Squares to a clearance, where there are not too many, and how many are needed to save anything.
const FINEST: f64 = 16.0;
const COARSEST: f64 = 4.0;
const MOST_SQUARES: f64 = 2e6;
/// More squares than this for each side take longer than they save.
const SQUARES_A_SIDE: f64 = 64.0;
/// A side is looked at in steps of this share of a square.
const STEP: f64 = 0.5;
/// By how much the distance between the middles of two squares differs from that of what lies in them, of which one is known by
/// the steps of its side (squares): half a diagonal for each, and half a step.
const OFF: f64 = 1.75;

/// Squares of a region, and whether the sides in them are needed.
pub(crate) struct Outermost {
    origin: Point,
    size_m: f64,
    columns: usize,
    rows: usize,
    needed: Vec<bool>,
}

impl Outermost {
    /// Of lines in a region. Nothing is left out that lies between `least_m` and `most_m` from a point that is so far from all
    /// lines. `None` where squares would be too coarse for the distance to save anything.
    pub(crate) fn new(
        near: Region,
        lines: &[Vec<Point>],
        (least_m, most_m): (f64, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Option<Self>, PlanError> {
        let sides: usize = lines.iter().map(Vec::len).sum();
        // Infinite without sides.
        let most_squares = (SQUARES_A_SIDE * sides as f64).min(MOST_SQUARES);
        let size_m = (most_m / FINEST).max((near.area() / most_squares).sqrt());
        if size_m > most_m / COARSEST || least_m <= 0.0 {
            return Ok(None);
        }
        let count = |length_m: f64| (length_m / size_m) as usize + 1;
        let (columns, rows) = (count(near.max.x - near.min.x), count(near.max.y - near.min.y));
        let needed = vec![false; columns * rows];
        let mut all = Self { origin: near.min, size_m, columns, rows, needed };
        let mut taken = vec![false; columns * rows];
        for side in lines.iter().flat_map(|line| crate::plane::sides(line)) {
            if let Some((a, b)) = near.clip(side[0], side[1]) {
                all.along(a, b).for_each(|square| taken[square] = true);
            }
        }
        all.mark(&taken, [least_m, most_m].map(|distance_m| distance_m / size_m), cancel)?;
        Ok(Some(all))
    }

    /// Whether a side that lies in the region is needed.
    pub(crate) fn needs(&self, a: Point, b: Point) -> bool {
        self.along(a, b).any(|square| self.needed[square])
    }

    /// Squares along a side; some that it only touches may be missing, within half a step.
    fn along(&self, a: Point, b: Point) -> impl Iterator<Item = usize> + '_ {
        // Within the region, so that there are no more steps than some for each row and column.
        let steps = (a.distance_m(b) / (STEP * self.size_m)).ceil().max(1.0) as u32;
        (0..=steps).map(move |step| {
            let at = a.towards(b, f64::from(step) / f64::from(steps));
            // Saturate at 0.
            let column = (((at.x - self.origin.x) / self.size_m) as usize).min(self.columns - 1);
            let row = (((at.y - self.origin.y) / self.size_m) as usize).min(self.rows - 1);
            row * self.columns + column
        })
    }

    /// Marks the taken squares that lie within these distances (squares) of one that is so far from all taken ones.
    fn mark(
        &mut self,
        taken: &[bool],
        [least, most]: [f64; 2],
        cancel: &Cancel<'_>,
    ) -> Result<(), PlanError> {
        let (nearest, farthest) = ((least - OFF).max(0.0).powi(2), (most + OFF).powi(2));
        // No more than some tens.
        let reach = (most + OFF).ceil() as usize;
        let beside = self.beside(taken, reach);
        let ring: Vec<(isize, isize)> = ring(reach as isize, nearest, farthest);
        for row in 0..self.rows {
            cancel.check()?;
            for column in 0..self.columns {
                let square = self.square_distance(&beside, (column, row), reach);
                if square < nearest || square > farthest {
                    continue;
                }
                for (east, north) in &ring {
                    let (Some(column), Some(row)) =
                        (column.checked_add_signed(*east), row.checked_add_signed(*north))
                    else {
                        continue;
                    };
                    let at = row * self.columns + column;
                    if column < self.columns && row < self.rows && taken[at] {
                        self.needed[at] = true;
                    }
                }
            }
        }
        Ok(())
    }

    /// How many columns each square lies from the nearest taken one of its row, within a reach.
    fn beside(&self, taken: &[bool], reach: usize) -> Vec<u16> {
        let far = u16::try_from(reach + 1).unwrap_or(u16::MAX);
        let mut beside = vec![far; taken.len()];
        for (taken, beside) in taken.chunks(self.columns).zip(beside.chunks_mut(self.columns)) {
            for backward in [false, true] {
                let mut off = far;
                for step in 0..self.columns {
                    let at = if backward { self.columns - 1 - step } else { step };
                    off = if taken[at] { 0 } else { (off + 1).min(far) };
                    beside[at] = beside[at].min(off);
                }
            }
        }
        beside
    }

    /// The square of the distance to the nearest taken square, as far as it lies within reach.
    fn square_distance(&self, beside: &[u16], (column, row): (usize, usize), reach: usize) -> f64 {
        let mut best = f64::INFINITY;
        for other in row.saturating_sub(reach)..(row + reach + 1).min(self.rows) {
            let off = usize::from(beside[other * self.columns + column]);
            if off <= reach {
                let north = other.abs_diff(row);
                best = best.min((off * off + north * north) as f64);
            }
        }
        best
    }
}

/// Steps whose length's square lies between two figures.
fn ring(reach: isize, nearest: f64, farthest: f64) -> Vec<(isize, isize)> {
    let all = (-reach..=reach).flat_map(|north| (-reach..=reach).map(move |east| (east, north)));
    all.filter(|(east, north)| {
        let square = (east * east + north * north) as f64;
        (nearest..=farthest).contains(&square)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::obstacles::{Cut, Pieces, cut_out, metres};
    use testkit::Numbers;

    /// The same lines cut out as a whole, and without what is not needed.
    fn both(lines: &[Vec<Point>], clearance_m: f64, half_m: f64) -> [Pieces; 2] {
        let corner = |by_m: f64| Point { x: by_m, y: by_m };
        let region = Region { min: corner(-half_m), max: corner(half_m) };
        [None, Some(clearance_m)].map(|closed_m| {
            cut_out(region, &[Cut { lines, clearance_m, plane: None, closed_m }], &Cancel::never()).unwrap()
        })
    }

    fn area(piece: &[Vec<[i32; 2]>]) -> f64 {
        let twice = |ring: &[[i32; 2]]| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next).map(|(a, b)| Point::default().cross(metres(*a), metres(*b))).sum::<f64>()
        };
        piece.iter().map(|ring| twice(ring) / 2.0).sum()
    }

    /// Much detail in clumps, and some of it alone.
    fn harbours(numbers: &mut Numbers, half_m: f64) -> Vec<Vec<Point>> {
        let mut lines = Vec::new();
        for _ in 0..12 {
            let clump = numbers.point(half_m);
            let wide_m = numbers.within(20.0, 0.4 * half_m);
            for _ in 0..40 {
                let mut near = || {
                    let off = numbers.point(wide_m);
                    Point { x: clump.east_m + off.east_m, y: clump.north_m + off.north_m }
                };
                let (from, to) = (near(), near());
                lines.push(if from.x > to.x { vec![from] } else { vec![from, from.towards(to, 0.2), to] });
            }
        }
        lines
    }

    #[test]
    fn open_water_stays_what_it_was_and_what_is_more_is_closed() {
        let (mut fewer, mut holes) = (0, 0);
        for seed in 1..=testkit::so_many(4, 60) {
            let (mut numbers, half_m) = (Numbers(seed * 104_729), 3_000.0);
            let lines = harbours(&mut numbers, half_m);
            let clearance_m = numbers.within(250.0, 700.0);
            let [whole, less] = both(&lines, clearance_m, half_m);
            let mut left = less.clone();
            for piece in &whole {
                // The same border, but for where centimetres are rounded.
                let (size, corner) = (area(piece), metres(piece[0][0]));
                let at = left.iter().position(|other| {
                    let near = other[0].iter().any(|at| metres(*at).distance_m(corner) < 1.0);
                    near && (area(other) - size).abs() < 1.0 + 1e-6 * size
                });
                assert!(at.is_some() || size < 10.0, "seed {seed}: a piece of {size} m² is not the same");
                at.map(|at| left.remove(at));
            }
            for hole in left.iter().flatten().flatten() {
                let at = metres(*hole);
                let off_m = |side: [Point; 2]| at.distance_m(at.nearest_on(side[0], side[1]));
                let sides = lines.iter().flat_map(|line| crate::plane::sides(line));
                let nearest_m = sides.map(off_m).fold(f64::INFINITY, f64::min);
                assert!(nearest_m < clearance_m, "seed {seed}: a hole is open {nearest_m} m off");
            }
            holes += left.len();
            let near = Region { min: Point { x: -5e3, y: -5e3 }, max: Point { x: 5e3, y: 5e3 } };
            let bounds_m = (clearance_m - 2.0, 1.02 * clearance_m + 2.0);
            let outermost = Outermost::new(near, &lines, bounds_m, &Cancel::never()).unwrap().unwrap();
            let sides = lines.iter().flat_map(|line| crate::plane::sides(line));
            fewer += sides.filter(|side| !outermost.needs(side[0], side[1])).count();
        }
        assert!(fewer > 300 && holes > 0, "{fewer} sides fewer, {holes} holes");
    }

    #[test]
    fn a_narrow_clearance_is_not_looked_at_in_squares_coarser_than_itself() {
        let far = Region { min: Point { x: -1e5, y: -1e5 }, max: Point { x: 1e5, y: 1e5 } };
        assert!(Outermost::new(far, &[], (50.0, 52.0), &Cancel::never()).unwrap().is_none());
    }
}
