//! The classic way, for comparison and teaching: A* on a regular grid of the chart.
//!
//! This is the planner of a 2020 master's thesis on these vessels, on data structures that fit: a flat grid instead of
//! a table of points, a heap instead of a linear scan. A cell is open if its middle is deep enough; what lies between
//! middles is not looked at, and no clearance is kept. [`crate::Router`] is what vessels are sent by.

use crate::plane::{Plane, Point};
use charts::depth_index::{Demand, DepthIndex};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use units::LatLon;

/// More cells than this are not laid out.
const MOST_CELLS: usize = 40_000_000;

/// Which cells are neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighbours {
    /// The eight around.
    Eight,
    /// And the eight a knight's move away.
    Sixteen,
}

impl Neighbours {
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
}

/// A grid of open and closed cells.
#[derive(Debug, Clone)]
pub struct ClassicGrid {
    plane: Plane,
    spacing_m: f64,
    columns: i64,
    rows: i64,
    open: Vec<bool>,
}

/// What a search on the grid found.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassicRoute {
    /// Middles of the cells that the way goes through.
    pub places: Vec<LatLon>,
    /// Length in the plane (m).
    pub length_m: f64,
    /// Cells that were put in the open list.
    pub opened: usize,
    /// Cells that were closed.
    pub closed: usize,
}

impl ClassicGrid {
    /// Lays a grid over a square around a place: so far to each side, cells so large (m). `None` of more cells than fit.
    pub fn new(
        index: &DepthIndex,
        demand: &Demand,
        middle: LatLon,
        half_m: f64,
        spacing_m: f64,
    ) -> Option<Self> {
        let side = (2.0 * half_m / spacing_m).ceil();
        if !(side >= 1.0 && side * side <= MOST_CELLS as f64) {
            return None;
        }
        // Within the bound above.
        let side = side as i64;
        let mut grid =
            Self { plane: Plane::new(middle), spacing_m, columns: side, rows: side, open: Vec::new() };
        let deep = |at: i64| index.depth_at(grid.plane.place(grid.middle(at)), demand).navigable;
        grid.open = (0..side * side).map(deep).collect();
        Some(grid)
    }

    /// Columns from west to east and rows from south to north; which cells are open, row after row.
    pub fn cells(&self) -> ([usize; 2], &[bool]) {
        ([self.columns, self.rows].map(|side| usize::try_from(side).unwrap_or(0)), &self.open)
    }

    /// The cell of a place, counted from 0 in columns and rows; `None` outside.
    pub fn cell_of(&self, place: LatLon) -> Option<[usize; 2]> {
        let at = usize::try_from(self.cell(place)?).ok()?;
        let columns = usize::try_from(self.columns).ok()?;
        Some([at % columns, at / columns])
    }

    /// Number of open cells.
    pub fn open_cells(&self) -> usize {
        self.open.iter().filter(|open| **open).count()
    }

    /// A* with the straight distance, times a weight, as heuristic: above 1 it is faster and longer. `None` without a way
    /// between the cells of both places.
    pub fn route(
        &self,
        from: LatLon,
        to: LatLon,
        neighbours: Neighbours,
        weight: f64,
    ) -> Option<ClassicRoute> {
        let (start, goal) = (self.cell(from)?, self.cell(to)?);
        let mut best_m = vec![f32::INFINITY; self.open.len()];
        let mut before = vec![u32::MAX; self.open.len()];
        let mut is_closed = vec![false; self.open.len()];
        let mut heap = BinaryHeap::new();
        let (mut opened, mut closed) = (0, 0);
        best_m[start as usize] = 0.0;
        heap.push(Reverse((0_u32, start)));
        while let Some(Reverse((_, at))) = heap.pop() {
            if std::mem::replace(&mut is_closed[at as usize], true) {
                continue;
            }
            closed += 1;
            if at == goal {
                return Some(self.way(goal, &before, (opened, closed)));
            }
            let (column, row) = (at % self.columns, at / self.columns);
            for (east, north) in neighbours.steps() {
                let (column, row) = (column + east, row + north);
                if !(0..self.columns).contains(&column) || !(0..self.rows).contains(&row) {
                    continue;
                }
                let next = row * self.columns + column;
                let step_m = self.spacing_m * (*east as f64).hypot(*north as f64);
                let length_m = best_m[at as usize] + step_m as f32;
                if !self.open[next as usize] || length_m >= best_m[next as usize] {
                    continue;
                }
                best_m[next as usize] = length_m;
                // At most 40 million cells.
                before[next as usize] = at as u32;
                opened += 1;
                let rest_m = self.middle(next).distance_m(self.middle(goal)) * weight;
                // Positive floats order as their bits.
                heap.push(Reverse(((length_m + rest_m as f32).to_bits(), next)));
            }
        }
        None
    }

    fn way(&self, goal: i64, before: &[u32], (opened, closed): (usize, usize)) -> ClassicRoute {
        let mut cells = vec![goal];
        let mut at = before[goal as usize];
        while at != u32::MAX {
            cells.push(i64::from(at));
            at = before[at as usize];
        }
        cells.reverse();
        let points: Vec<Point> = cells.into_iter().map(|cell| self.middle(cell)).collect();
        let length_m = points.windows(2).map(|pair| pair[0].distance_m(pair[1])).sum();
        let places = points.into_iter().map(|point| self.plane.place(point)).collect();
        ClassicRoute { places, length_m, opened, closed }
    }

    /// The open cell of a place.
    fn cell(&self, place: LatLon) -> Option<i64> {
        let at = self.plane.point(place);
        let number = |value: f64, count: i64| ((value / self.spacing_m) + count as f64 / 2.0).floor() as i64;
        let (column, row) = (number(at.x, self.columns), number(at.y, self.rows));
        let inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        let cell = row * self.columns + column;
        (inside && self.open[cell as usize]).then_some(cell)
    }

    fn middle(&self, cell: i64) -> Point {
        let along = |number: i64, count: i64| (number as f64 + 0.5 - count as f64 / 2.0) * self.spacing_m;
        Point { x: along(cell % self.columns, self.columns), y: along(cell / self.columns, self.rows) }
    }
}
