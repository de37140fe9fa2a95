//! The points that a weighed way may pass, and which lie near each other.
//!
//! A way of the least cost bends where conditions change, so anywhere. Its points are taken from a square grid over the
//! open water in reach, whose spacing follows from the area of that water and the number of points; from the corners
//! round which ways bend, of the water itself, of the water that is preferred and of areas with speed limits; and from the
//! ways that are known already. In reach is what lies in the ellipse around start and goal that a way must not leave to be
//! better.

use crate::boxes::Bounds;
use crate::mesh::Mesh;
use crate::plane::Point;
use crate::sailing::Sailing;
use crate::{Cancel, PlanError};
use std::collections::BTreeSet;

/// Points of the grid, about; corners, at most; points of each known way, about, beside its own corners.
const GRID_POINTS: f64 = 9_000.0;
const MOST_CORNERS: usize = 9_000;
const WAY_POINTS: f64 = 1_000.0;
/// The grid is no finer than this (m).
const FINEST_M: f64 = 10.0;
/// The area of open water in reach is measured at so many points each way.
const MEASURED: u32 = 96;
/// Squares of the box around what is in reach: the grid is coarser where there would be more.
const MOST_SQUARES: f64 = 250_000.0;
/// Points see each other within so many spacings: to the knight's move of chess.
pub(crate) const NEAR: f64 = 2.3;

/// The ellipse of places by which a way is not longer than a length.
#[derive(Debug, Clone, Copy)]
struct Reach {
    from: Point,
    to: Point,
    most_m: f64,
}

impl Reach {
    fn holds(&self, at: Point) -> bool {
        self.from.distance_m(at) + at.distance_m(self.to) <= self.most_m
    }

    fn bounds(&self) -> Bounds {
        let middle = self.from.towards(self.to, 0.5);
        let straight_m = self.from.distance_m(self.to);
        let (long_m, short_m) =
            (self.most_m / 2.0, (self.most_m.powi(2) - straight_m.powi(2)).max(0.0).sqrt() / 2.0);
        let along = if straight_m > 0.0 {
            Point { x: (self.to.x - self.from.x) / straight_m, y: (self.to.y - self.from.y) / straight_m }
        } else {
            Point { x: 1.0, y: 0.0 }
        };
        let half_x = (long_m * along.x).hypot(short_m * along.y);
        let half_y = (long_m * along.y).hypot(short_m * along.x);
        Bounds {
            min: Point { x: middle.x - half_x, y: middle.y - half_y },
            max: Point { x: middle.x + half_x, y: middle.y + half_y },
        }
    }
}

/// Points and their neighbourhoods.
#[derive(Debug)]
pub(crate) struct Lattice {
    /// The start is the first, the goal the second.
    pub(crate) points: Vec<Point>,
    /// Of a point of a known way the point before it on that way, and the one after it.
    pub(crate) on_way: Vec<[Option<u32>; 2]>,
    /// Spacing of the grid (m).
    pub(crate) spacing_m: f64,
    /// Around all that is in reach.
    pub(crate) bounds: Bounds,
    squares: Vec<Vec<u32>>,
    columns: usize,
}

impl Lattice {
    /// Between the ends of known ways, for ways not longer than a length.
    pub(crate) fn new(
        sailing: &Sailing<'_>,
        ways: &[Vec<Point>],
        most_m: f64,
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        let mesh = &sailing.room.mesh;
        let (from, to) = (ways[0][0], ways[0][ways[0].len() - 1]);
        let reach = Reach { from, to, most_m };
        let bounds = reach.bounds();
        let [wide_m, high_m] =
            [bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y].map(|side_m| side_m.max(1.0));
        let spacing_m = spacing_m(mesh, &reach, &bounds).max((wide_m * high_m / MOST_SQUARES).sqrt());
        cancel.check()?;
        let size_m = NEAR * spacing_m;
        let [columns, rows] = [wide_m, high_m].map(|side_m| (side_m / size_m) as usize + 1);
        let squares = vec![Vec::new(); columns * rows];
        let mut lattice =
            Self { points: Vec::new(), on_way: Vec::new(), spacing_m, bounds, squares, columns };
        lattice.add(from);
        lattice.add(to);
        for way in ways {
            lattice.add_way(way);
        }
        lattice.add_corners(sailing, &reach);
        cancel.check()?;
        lattice.add_grid(mesh, &reach);
        Ok(lattice)
    }

    fn add(&mut self, at: Point) -> u32 {
        let number = self.points.len() as u32;
        self.points.push(at);
        self.on_way.push([None; 2]);
        let square = self.square(at);
        self.squares[square].push(number);
        number
    }

    /// Points on a known way, its corners among them: at the spacing, or coarser where it is very long.
    fn add_way(&mut self, way: &[Point]) {
        let length_m: f64 = way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        let step_m = self.spacing_m.max(length_m / WAY_POINTS);
        let mut before = 0;
        for (number, leg) in way.windows(2).enumerate() {
            let parts = (leg[0].distance_m(leg[1]) / step_m).ceil().max(1.0) as u32;
            for part in 1..=parts {
                let is_goal = number + 2 == way.len() && part == parts;
                let at = leg[0].towards(leg[1], f64::from(part) / f64::from(parts));
                let next = if is_goal { 1 } else { self.add(at) };
                // At the ends ways meet: there the last one is noted, and the others start within sight.
                self.on_way[before as usize][1] = Some(next);
                self.on_way[next as usize][0] = Some(before);
                before = next;
            }
        }
    }

    /// Corners round which ways bend, one in each square of a raster that is made coarser until they are few enough.
    fn add_corners(&mut self, sailing: &Sailing<'_>, reach: &Reach) {
        let room = sailing.room;
        let mut corners = Vec::new();
        let of = |mesh: &Mesh, corners: &mut Vec<Point>| {
            let all = mesh.points.iter().zip(&mesh.bends);
            corners.extend(all.filter(|(at, bends)| **bends && reach.holds(**at)).map(|(at, _)| *at));
        };
        of(&room.mesh, &mut corners);
        for preferred in &sailing.wish.preferred {
            let known = corners.len();
            of(&preferred.mesh, &mut corners);
            let open: Vec<Point> =
                corners.drain(known..).filter(|at| room.mesh.locate(*at).is_some()).collect();
            corners.extend(open);
        }
        let limits = sailing.limits.corners();
        corners.extend(limits.filter(|at| reach.holds(*at) && room.mesh.locate(*at).is_some()));
        let mut size_m = 0.5 * self.spacing_m;
        let origin = self.bounds.min;
        loop {
            let mut taken = BTreeSet::new();
            let square =
                |at: &Point| [((at.x - origin.x) / size_m) as u32, ((at.y - origin.y) / size_m) as u32];
            let kept: Vec<Point> = corners.iter().filter(|at| taken.insert(square(at))).copied().collect();
            if kept.len() <= MOST_CORNERS {
                for at in kept {
                    self.add(at);
                }
                return;
            }
            size_m *= 1.5;
        }
    }

    fn add_grid(&mut self, mesh: &Mesh, reach: &Reach) {
        let Bounds { min, max } = self.bounds;
        let step_m = self.spacing_m;
        let [columns, rows] = [max.x - min.x, max.y - min.y].map(|side_m| (side_m / step_m) as u32);
        for row in 0..=rows {
            for column in 0..=columns {
                let at = Point { x: min.x + f64::from(column) * step_m, y: min.y + f64::from(row) * step_m };
                if reach.holds(at) && mesh.locate(at).is_some() {
                    self.add(at);
                }
            }
        }
    }

    /// Other points near one, and those beside it on a known way.
    pub(crate) fn near(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let at = self.points[point as usize];
        let within_m = NEAR * self.spacing_m;
        let rows = self.squares.len() / self.columns;
        let (column, row) = self.column_and_row(at);
        let rows = row.saturating_sub(1)..=(row + 1).min(rows - 1);
        let columns = column.saturating_sub(1)..=(column + 1).min(self.columns - 1);
        let squares =
            rows.flat_map(move |row| columns.clone().map(move |column| row * self.columns + column));
        let around = squares.flat_map(|square| self.squares[square].iter().copied());
        let around = around
            .filter(move |other| *other != point && self.points[*other as usize].distance_m(at) <= within_m);
        around.chain(self.on_way[point as usize].into_iter().flatten())
    }

    /// Whether two points follow each other on a known way.
    pub(crate) fn is_known(&self, one: u32, other: u32) -> bool {
        self.on_way[one as usize].contains(&Some(other)) || self.on_way[other as usize].contains(&Some(one))
    }

    // Saturate at 0.
    fn column_and_row(&self, at: Point) -> (usize, usize) {
        let size_m = NEAR * self.spacing_m;
        let rows = self.squares.len() / self.columns;
        let column = ((at.x - self.bounds.min.x) / size_m) as usize;
        let row = ((at.y - self.bounds.min.y) / size_m) as usize;
        (column.min(self.columns - 1), row.min(rows - 1))
    }

    fn square(&self, at: Point) -> usize {
        let (column, row) = self.column_and_row(at);
        row * self.columns + column
    }
}

/// The spacing at which the open water in reach holds as many points as are wanted (m).
fn spacing_m(mesh: &Mesh, reach: &Reach, bounds: &Bounds) -> f64 {
    let Bounds { min, max } = *bounds;
    let share = |n: u32| (f64::from(n) + 0.5) / f64::from(MEASURED);
    let places = (0..MEASURED * MEASURED).map(|n| Point {
        x: min.x + (max.x - min.x) * share(n % MEASURED),
        y: min.y + (max.y - min.y) * share(n / MEASURED),
    });
    let open = places.filter(|at| reach.holds(*at) && mesh.locate(*at).is_some()).count();
    let share = open.max(1) as f64 / f64::from(MEASURED * MEASURED);
    let area_m2 = (max.x - min.x) * (max.y - min.y) * share;
    (area_m2 / GRID_POINTS).sqrt().max(FINEST_M)
}
