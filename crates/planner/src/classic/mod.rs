//! The classic way, for comparison and teaching: A* on a regular grid of the chart.
//!
//! This is the planner of a 2020 master's thesis on these vessels, on data structures that fit: a flat grid instead of
//! a table of points, a heap instead of a linear scan. A cell is open if its middle is deep enough; what lies between
//! middles is not looked at, and no clearance is kept. [`VaryingGrid`] joins open cells to larger ones away from land.
//! [`crate::Router`] is what vessels are sent by.

mod a_star;
#[cfg(test)]
mod tests;
mod varying;

use crate::Cancel;
use crate::boxes::Bounds;
use crate::plane::{Plane, Point};
use crate::room::PlanError;
use a_star::{Cells, search};
use charts::depth_index::{Demand, DepthIndex};
use units::LatLon;

pub use varying::VaryingGrid;

/// More cells than this are not laid out.
pub const MOST_CELLS: usize = 40_000_000;
/// Cells are no smaller and no larger (m).
pub const RESOLUTIONS_M: [f64; 2] = [0.1, 100_000.0];

/// Why no grid is laid out, or not searched to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClassicError {
    /// Cells of a size that makes no sense (m).
    #[error("cells of {0} m: give a resolution between {least} m and {most} m", least = RESOLUTIONS_M[0], most = RESOLUTIONS_M[1])]
    Resolution(f64),
    /// More cells than are laid out.
    #[error(
        "cells of {spacing_m} m would be {cells:.0} on this water, and at most {most} are laid out: give a resolution of \
         {enough_m:.0} m or more",
        most = MOST_CELLS
    )]
    TooMany {
        /// Their size (m).
        spacing_m: f64,
        /// Their number.
        cells: f64,
        /// A size of which there are not too many (m).
        enough_m: f64,
    },
    /// The search was cancelled, or its time is over.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Which cells are neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighbours {
    /// The eight around.
    Eight,
    /// And the eight a knight's move away, where both cells between are open.
    Sixteen,
}

impl Neighbours {
    /// Columns to the east and rows to the north.
    fn steps(self) -> &'static [(i64, i64)] {
        const ALL: [(i64, i64); 16] = [
            (1, 0),
            (0, 1),
            (-1, 0),
            (0, -1),
            (1, 1),
            (-1, 1),
            (-1, -1),
            (1, -1),
            (2, 1),
            (1, 2),
            (-1, 2),
            (-2, 1),
            (-2, -1),
            (-1, -2),
            (1, -2),
            (2, -1),
        ];
        match self {
            Self::Eight => &ALL[..8],
            Self::Sixteen => &ALL,
        }
    }

    /// The knight's moves among them.
    fn knights(self) -> &'static [(i64, i64)] {
        &self.steps()[8..]
    }
}

/// The two cells that a knight's move passes between.
fn between((east, north): (i64, i64)) -> [(i64, i64); 2] {
    [(east / 2, north / 2), (east.signum(), north.signum())]
}

/// A grid of open and closed cells, with square cells of one size.
#[derive(Debug, Clone)]
pub struct ClassicGrid {
    plane: Plane,
    /// Its south-western corner.
    corner: Point,
    spacing_m: f64,
    columns: i64,
    rows: i64,
    open: Vec<bool>,
}

/// What a search on a grid found.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassicRoute {
    /// Middles of the cells that the way goes through.
    pub places: Vec<LatLon>,
    /// Length in the plane of the grid (m).
    pub length_m: f64,
    /// Times that a cell was put in the open list.
    pub opened: usize,
    /// Cells that were closed.
    pub closed: usize,
}

impl ClassicGrid {
    /// Lays a grid over a square around a place: so far to each side, cells so large (m).
    ///
    /// # Errors
    /// Cells of no size, or too many; or if the answer is no longer wanted.
    pub fn new(
        index: &DepthIndex,
        demand: &Demand,
        middle: LatLon,
        (half_m, spacing_m): (f64, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Self, ClassicError> {
        let plane = Plane::new(middle);
        Self::lay(plane, [half_m, half_m], spacing_m)?.sounded(index, demand, cancel)
    }

    /// Lays a grid over a place and others, and so far beyond them (m), cells so large (m).
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn covering(
        index: &DepthIndex,
        demand: &Demand,
        (first, others): (LatLon, &[LatLon]),
        (beyond_m, spacing_m): (f64, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Self, ClassicError> {
        let (plane, halves_m) = around(first, others, beyond_m);
        Self::lay(plane, halves_m, spacing_m)?.sounded(index, demand, cancel)
    }

    /// The least of some sizes of cells (m) of which no more than so many cover the places; the greatest where all are too many.
    pub fn fitting(
        (first, others): (LatLon, &[LatLon]),
        beyond_m: f64,
        sizes_m: &[f64],
        most_cells: usize,
    ) -> Option<f64> {
        let [x, y] = around(first, others, beyond_m).1;
        let fits = |size_m: &&f64| (2.0 * x / **size_m) * (2.0 * y / **size_m) <= most_cells as f64;
        sizes_m.iter().find(fits).or_else(|| sizes_m.last()).copied()
    }

    /// A grid without open cells.
    fn lay(plane: Plane, halves_m: [f64; 2], spacing_m: f64) -> Result<Self, ClassicError> {
        if !(RESOLUTIONS_M[0]..=RESOLUTIONS_M[1]).contains(&spacing_m) {
            return Err(ClassicError::Resolution(spacing_m));
        }
        let [columns, rows] = halves_m.map(|half_m| (2.0 * half_m / spacing_m).ceil().max(1.0));
        let cells = columns * rows;
        if cells.is_nan() || cells > MOST_CELLS as f64 {
            // A hundredth more for the parts of cells at the borders.
            let enough_m = 1.01 * spacing_m * (cells / MOST_CELLS as f64).sqrt();
            return Err(ClassicError::TooMany { spacing_m, cells, enough_m: enough_m.ceil() });
        }
        let [x, y] = [columns, rows].map(|count| -0.5 * count * spacing_m);
        // Within the bound above.
        let (columns, rows) = (columns as i64, rows as i64);
        Ok(Self { plane, corner: Point { x, y }, spacing_m, columns, rows, open: Vec::new() })
    }

    /// With the cells open whose middles are as deep as demanded.
    fn sounded(
        mut self,
        index: &DepthIndex,
        demand: &Demand,
        cancel: &Cancel<'_>,
    ) -> Result<Self, ClassicError> {
        let mut open = Vec::with_capacity((self.columns * self.rows) as usize);
        for row in 0..self.rows {
            cancel.check()?;
            let place = |column| self.plane.place(self.middle_of(column, row));
            open.extend((0..self.columns).map(|column| index.depth_at(place(column), demand).navigable));
        }
        self.open = open;
        Ok(self)
    }

    /// Columns from west to east and rows from south to north; which cells are open, row after row.
    pub fn cells(&self) -> ([usize; 2], &[bool]) {
        ([self.columns, self.rows].map(|side| usize::try_from(side).unwrap_or(0)), &self.open)
    }

    /// The open cell of a place, counted from 0 in columns and rows; `None` outside and in closed cells.
    pub fn cell_of(&self, place: LatLon) -> Option<[usize; 2]> {
        let at = usize::try_from(self.cell(place)?).ok()?;
        let columns = usize::try_from(self.columns).ok()?;
        Some([at % columns, at / columns])
    }

    /// Number of open cells.
    pub fn open_cells(&self) -> usize {
        self.open.iter().filter(|open| **open).count()
    }

    /// A* with the straight distance, times a weight, as heuristic: at 1 it finds the shortest way, above 1 it is faster and the
    /// way longer by that factor at most, at 0 it is Dijkstra's search. `None` without a way between the cells of both places.
    ///
    /// # Errors
    /// If the answer is no longer wanted.
    pub fn route(
        &self,
        from: LatLon,
        to: LatLon,
        (neighbours, weight): (Neighbours, f64),
        cancel: &Cancel<'_>,
    ) -> Result<Option<ClassicRoute>, PlanError> {
        let (Some(start), Some(goal)) = (self.cell(from), self.cell(to)) else { return Ok(None) };
        let found = search(self, [start, goal], (neighbours, weight), cancel)?;
        Ok(found.map(|found| self.way(found.nodes.iter().map(|cell| self.middle(*cell)), found.effort)))
    }

    /// A way by some points.
    fn way(&self, points: impl Iterator<Item = Point>, [opened, closed]: [usize; 2]) -> ClassicRoute {
        let points: Vec<Point> = points.collect();
        let length_m = points.windows(2).map(|pair| pair[0].distance_m(pair[1])).sum();
        let places = points.into_iter().map(|point| self.plane.place(point)).collect();
        ClassicRoute { places, length_m, opened, closed }
    }

    /// The open cell of a place.
    fn cell(&self, place: LatLon) -> Option<u32> {
        let at = self.plane.point(place);
        let number = |along_m: f64| (along_m / self.spacing_m).floor() as i64;
        self.open_cell(number(at.x - self.corner.x), number(at.y - self.corner.y))
    }

    /// The cell of a column and row, if there is one and it is open.
    fn open_cell(&self, column: i64, row: i64) -> Option<u32> {
        if !(0..self.columns).contains(&column) || !(0..self.rows).contains(&row) {
            return None;
        }
        let cell = row * self.columns + column;
        // At most 40 million cells.
        self.open[cell as usize].then_some(cell as u32)
    }

    fn middle_of(&self, column: i64, row: i64) -> Point {
        self.inside(column as f64 + 0.5, row as f64 + 0.5)
    }

    /// The point so many columns and rows from the south-western corner.
    fn inside(&self, columns: f64, rows: f64) -> Point {
        Point { x: self.corner.x + columns * self.spacing_m, y: self.corner.y + rows * self.spacing_m }
    }
}

impl Cells for ClassicGrid {
    fn count(&self) -> usize {
        self.open.len()
    }

    fn middle(&self, cell: u32) -> Point {
        let cell = i64::from(cell);
        self.middle_of(cell % self.columns, cell / self.columns)
    }

    fn around(&self, cell: u32, neighbours: Neighbours, mut visit: impl FnMut(u32)) {
        let cell = i64::from(cell);
        let (column, row) = (cell % self.columns, cell / self.columns);
        let open = |(east, north): (i64, i64)| self.open_cell(column + east, row + north);
        let knights = neighbours.knights().iter();
        let knights = knights.filter(|step| between(**step).into_iter().all(|cell| open(cell).is_some()));
        for step in Neighbours::Eight.steps().iter().chain(knights) {
            if let Some(next) = open(*step) {
                visit(next);
            }
        }
    }
}

/// A plane around the middle of a place and others, and how far they and what lies so far beyond them reach to the sides (m).
fn around(first: LatLon, others: &[LatLon], beyond_m: f64) -> (Plane, [f64; 2]) {
    let bounds = |plane: Plane| {
        let places = others.iter().copied().chain([first]);
        Bounds::of(&places.map(|place| plane.point(place)).collect::<Vec<Point>>())
    };
    let plane = Plane::new(first);
    let Bounds { min, max } = bounds(plane);
    let plane = Plane::new(plane.place(min.towards(max, 0.5)));
    let Bounds { min, max } = bounds(plane);
    let half_m = |least_m: f64, most_m: f64| least_m.abs().max(most_m.abs()) + beyond_m;
    (plane, [half_m(min.x, max.x), half_m(min.y, max.y)])
}
