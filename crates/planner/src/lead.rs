//! Where a way between two points may lead, found among the chart's lines on a coarse grid, so that only the water along it
//! needs to be prepared.
//!
//! Squares count by how far their middles lie from the lines: those that lie wholly within the reach are closed, those wholly
//! beyond it open, and the others, whose squares the border of open water runs through, are doubtful and avoided where that is
//! not far. It proves nothing: what it finds is prepared exactly and asked of the chart.

use crate::boxes::{Bounds, Boxes};
use crate::plane::Point;
use crate::region::Region;
use crate::side::{Reach, Side};
use crate::walls::Walls;
use crate::{Cancel, PlanError};
use std::collections::BinaryHeap;
use std::collections::btree_map::{BTreeMap, Entry};

/// Squares to a reach: closed ones along a line are wide enough then that no step passes between them.
const SQUARES: f64 = 2.0;
/// No square is smaller (m).
const LEAST_SQUARE_M: f64 = 5.0;
/// More squares are not looked at: where the way is that long, more water is prepared instead.
const MOST_SQUARES: usize = 40_000;
/// How many times as far a step through a doubtful square counts.
const DOUBTFUL: f64 = 8.0;
/// By how much more than it is the distance that is left counts: fewer squares are looked at then.
const GREEDY: f64 = 1.2;
const BETWEEN_LOOKS: usize = 1_024;

type Square = (i32, i32);

/// Squares between some lines.
struct Squares<'a> {
    sides: Vec<&'a Side>,
    tree: Boxes,
    region: Region,
    reach: Reach,
    size_m: f64,
}

/// A square that was reached.
#[derive(Debug, Clone, Copy)]
struct Reached {
    so_far_m: f64,
    before: Square,
    done: bool,
}

/// A square to go on from, the one with the least way first.
#[derive(Debug, PartialEq)]
struct Next {
    whole_m: f64,
    square: Square,
}

impl Eq for Next {}

impl Ord for Next {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.whole_m.total_cmp(&self.whole_m).then_with(|| self.square.cmp(&other.square))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A way that may lead from one end to the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lead {
    /// Middles of the squares along it, from the first end to the second, each with whether it is open for sure.
    pub(crate) squares: Vec<(Point, bool)>,
}

/// Squares along which a way from one end to the other may lead, within a region, between the lines that close it to
/// a vessel that needs this depth (m). `None` if no squares lead there, or too many would have to be looked at.
pub(crate) fn lead(
    walls: &Walls,
    region: Region,
    (ends, reach, depth_m): ([Point; 2], Reach, f64),
    cancel: &Cancel<'_>,
) -> Result<Option<Lead>, PlanError> {
    let size_m = (reach.chart_m / SQUARES).max(LEAST_SQUARE_M);
    let apart_m = ends[0].distance_m(ends[1]);
    if apart_m / size_m > MOST_SQUARES as f64 / 8.0 {
        return Ok(None);
    }
    let near = region.wider(reach.most_m());
    let sides: Vec<&Side> =
        walls.closing(depth_m).filter(|side| near.clip(side.ends[0], side.ends[1]).is_some()).collect();
    cancel.check()?;
    let tree = Boxes::new(&sides.iter().map(|side| Bounds::of(&side.ends)).collect::<Vec<_>>());
    Squares { sides, tree, region, reach, size_m }.way(ends, cancel)
}

impl Squares<'_> {
    fn way(&self, [from, to]: [Point; 2], cancel: &Cancel<'_>) -> Result<Option<Lead>, PlanError> {
        let (start, goal) = (self.square(from), self.square(to));
        let left_m = |square: Square| GREEDY * self.middle(square).distance_m(self.middle(goal));
        let mut reached = BTreeMap::from([(start, Reached { so_far_m: 0.0, before: start, done: false })]);
        let mut open = BinaryHeap::from([Next { whole_m: left_m(start), square: start }]);
        // What each square counts; no number where it is closed.
        let mut factors: BTreeMap<Square, f64> = BTreeMap::new();
        let mut looks = 0;
        while let Some(Next { square, .. }) = open.pop() {
            if square == goal {
                return Ok(Some(self.traced(&reached, &factors, goal)));
            }
            let Some(here) = reached.get_mut(&square).filter(|here| !here.done) else { continue };
            here.done = true;
            let so_far_m = here.so_far_m;
            looks += 1;
            if looks % BETWEEN_LOOKS == 0 {
                cancel.check()?;
            }
            if looks > MOST_SQUARES {
                return Ok(None);
            }
            for (next, step_m) in self.beside(square) {
                let factor = *factors.entry(next).or_insert_with(|| self.factor(next));
                // An end lies in open water, in a square that may be doubtful.
                let factor = if next == goal && factor.is_infinite() { DOUBTFUL } else { factor };
                if factor.is_infinite() {
                    continue;
                }
                let way_m = so_far_m + factor * step_m;
                match reached.entry(next) {
                    Entry::Occupied(held) if held.get().so_far_m <= way_m => continue,
                    Entry::Occupied(mut held) => {
                        *held.get_mut() = Reached { so_far_m: way_m, before: square, done: false };
                    }
                    Entry::Vacant(new) => {
                        new.insert(Reached { so_far_m: way_m, before: square, done: false });
                    }
                }
                open.push(Next { whole_m: way_m + left_m(next), square: next });
            }
        }
        Ok(None)
    }

    fn traced(
        &self,
        reached: &BTreeMap<Square, Reached>,
        factors: &BTreeMap<Square, f64>,
        goal: Square,
    ) -> Lead {
        let told = |square: Square| {
            let is_open = factors.get(&square).is_some_and(|factor| *factor <= 1.0);
            (self.middle(square), is_open)
        };
        let mut squares = vec![told(goal)];
        let mut square = goal;
        while let Some(Reached { before, .. }) = reached.get(&square).filter(|here| here.before != square) {
            square = *before;
            squares.push(told(square));
        }
        squares.reverse();
        Lead { squares }
    }

    /// The eight squares around one that lie in the region, and how far they are (m).
    fn beside(&self, (column, row): Square) -> impl Iterator<Item = (Square, f64)> {
        let all = (-1..=1).flat_map(|east: i32| (-1..=1).map(move |north: i32| (east, north)));
        all.filter(|step| *step != (0, 0)).filter_map(move |(east, north)| {
            let next = (column + east, row + north);
            let step_m = self.size_m * if east != 0 && north != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
            self.region.holds(self.middle(next)).then_some((next, step_m))
        })
    }

    /// How many times as far a step into a square counts; no number where it is closed.
    fn factor(&self, square: Square) -> f64 {
        let middle = self.middle(square);
        let half_m = self.size_m * std::f64::consts::FRAC_1_SQRT_2;
        // How much farther than the reach it lies from all lines.
        let mut beyond_m = half_m;
        self.tree.nearest(&Bounds::of(&[middle]), self.reach.most_m() + half_m, |number| {
            let side = self.sides[number as usize];
            let off_m = middle.distance_m(middle.nearest_on(side.ends[0], side.ends[1]));
            beyond_m = beyond_m.min(off_m - self.reach.of(side.kind));
            self.reach.most_m() + beyond_m.max(-half_m)
        });
        if beyond_m <= -half_m {
            f64::INFINITY
        } else if beyond_m < half_m {
            DOUBTFUL
        } else {
            1.0
        }
    }

    fn square(&self, at: Point) -> Square {
        // Saturates far beyond any region.
        let number = |off_m: f64| (off_m / self.size_m).floor() as i32;
        (number(at.x - self.region.min.x), number(at.y - self.region.min.y))
    }

    fn middle(&self, (column, row): Square) -> Point {
        let at = |least_m: f64, number: i32| least_m + (f64::from(number) + 0.5) * self.size_m;
        Point { x: at(self.region.min.x, column), y: at(self.region.min.y, row) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::side::Kind;

    fn at(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    /// A wall from south to north with a gap in the north, and a bar in the gap.
    fn walls() -> Walls {
        let side = |ends, deeper_than_m| Side { ends, deeper_than_m, kind: Kind::Chart };
        let region = Region { min: at(-2_000.0, -2_000.0), max: at(2_000.0, 2_000.0) };
        let sides = vec![
            side([at(0.0, -2_000.0), at(0.0, 1_000.0)], f64::NEG_INFINITY),
            side([at(0.0, 1_500.0), at(0.0, 2_000.0)], f64::NEG_INFINITY),
            side([at(0.0, 1_000.0), at(0.0, 1_500.0)], 3.0),
        ];
        Walls::of_sides(region, sides)
    }

    #[test]
    fn a_way_leads_through_the_gap_that_is_wide_and_deep_enough() {
        let walls = walls();
        let ends = [at(-1_000.0, -500.0), at(1_000.0, -500.0)];
        let ask = |chart_m: f64, depth_m: f64| {
            let reach = Reach { chart_m, zone_m: 0.0 };
            lead(&walls, walls.region(), (ends, reach, depth_m), &Cancel::never()).unwrap()
        };
        let Lead { squares } = ask(100.0, 3.0).unwrap();
        let last = squares[squares.len() - 1].0;
        assert!(squares[0].0.distance_m(ends[0]) < 50.0 && last.distance_m(ends[1]) < 50.0);
        let across: Vec<&(Point, bool)> = squares.iter().filter(|(at, _)| at.x.abs() < 30.0).collect();
        assert!(!across.is_empty());
        for (at, is_open) in across {
            assert!((1_060.0..1_440.0).contains(&at.y) && (!is_open || (1_135.0..1_365.0).contains(&at.y)));
        }
        assert!(squares.windows(2).all(|pair| pair[0].0.distance_m(pair[1].0) < 75.0), "no step is left out");
        assert_eq!(ask(500.0, 3.0), None, "too narrow");
        assert_eq!(ask(100.0, 3.1), None, "not deep enough");
        let called_off = lead(
            &walls,
            walls.region(),
            (ends, Reach { chart_m: 100.0, zone_m: 0.0 }, 3.0),
            &Cancel::unless(&|| false),
        );
        assert_eq!(called_off, Err(PlanError::Cancelled));
    }
}
