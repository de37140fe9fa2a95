//! The grid with varying resolution: fine cells near land, coarse ones in open water.
//!
//! Squares of 2, 4, 8 ... cells a side that are wholly open are joined to one cell. Cells are neighbours if they touch, so it connects
//! exactly what the regular grid connects. There are far fewer of them, and ways are longer, as they lead from middle to middle.

use super::a_star::{Cells, search};
use super::{ClassicGrid, ClassicRoute, Neighbours, between};
use crate::Cancel;
use crate::plane::Point;
use crate::room::PlanError;
use units::LatLon;

/// Doublings from the finest cell to the coarsest.
const MOST_DOUBLINGS: u32 = 6;
/// A cell of the regular grid that is closed.
const CLOSED: u32 = u32::MAX;

/// A grid whose cells vary in size.
#[derive(Debug, Clone)]
pub struct VaryingGrid<'a> {
    grid: &'a ClassicGrid,
    pub(super) leaves: Vec<Leaf>,
    /// The number of the leaf that each cell of the regular grid is part of.
    leaf_of: Vec<u32>,
}

/// Open cells that are one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    /// Of its south-western cell.
    column: i64,
    row: i64,
    /// Cells a side.
    pub(super) side: i64,
}

impl<'a> VaryingGrid<'a> {
    /// Joins open cells of a regular grid, up to 64 a side.
    pub fn new(grid: &'a ClassicGrid) -> Self {
        let mut varying = Self { grid, leaves: Vec::new(), leaf_of: vec![CLOSED; grid.open.len()] };
        let mut levels = vec![(grid.open.clone(), [grid.columns, grid.rows])];
        for _ in 0..MOST_DOUBLINGS {
            let Some((finer, sides)) = levels.last() else { break };
            let coarser = halved(finer, *sides);
            levels.push(coarser);
        }
        for (doublings, (whole, [columns, _])) in levels.iter().enumerate().rev() {
            let side = 1_i64 << doublings;
            for (number, _) in (0_i64..).zip(whole).filter(|(_, whole)| **whole) {
                varying.join(Leaf { column: number % columns * side, row: number / columns * side, side });
            }
        }
        varying
    }

    /// Makes one of its cells, unless they are part of a larger one.
    fn join(&mut self, leaf: Leaf) {
        if self.leaf_of[self.cell(leaf.column, leaf.row)] != CLOSED {
            return;
        }
        // At most 40 million cells.
        let number = self.leaves.len() as u32;
        for row in leaf.row..leaf.row + leaf.side {
            let first = self.cell(leaf.column, row);
            self.leaf_of[first..first + leaf.side as usize].fill(number);
        }
        self.leaves.push(leaf);
    }

    fn cell(&self, column: i64, row: i64) -> usize {
        (row * self.grid.columns + column) as usize
    }

    /// Number of cells, all of them open.
    pub fn open_cells(&self) -> usize {
        self.leaves.len()
    }

    /// Sides of the finest and the coarsest cell (m).
    pub fn sides_m(&self) -> [f64; 2] {
        let sides = self.leaves.iter().map(|leaf| leaf.side);
        [sides.clone().min(), sides.max()].map(|side| side.unwrap_or(1) as f64 * self.grid.spacing_m)
    }

    /// As [`ClassicGrid::route`]; the way begins and ends in the middle of the finest cells of both places.
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
        let (Some(start), Some(goal)) = (self.grid.cell(from), self.grid.cell(to)) else { return Ok(None) };
        let ends = [start, goal].map(|cell| self.leaf_of[cell as usize]);
        let Some(found) = search(self, ends, (neighbours, weight), cancel)? else { return Ok(None) };
        let [first, last] = [start, goal].map(|cell| self.grid.middle(cell));
        // In one leaf all is open, so the straight way is too.
        let middles = if ends[0] == ends[1] { &[][..] } else { &found.nodes };
        let mut points: Vec<Point> = [first].into_iter().collect();
        points.extend(middles.iter().map(|leaf| self.middle(*leaf)));
        points.push(last);
        points.dedup();
        Ok(Some(self.grid.way(points.into_iter(), found.effort)))
    }

    /// The leaf with a cell, if that is open.
    fn leaf(&self, column: i64, row: i64) -> Option<(u32, Leaf)> {
        let cell = self.grid.open_cell(column, row)?;
        let number = self.leaf_of[cell as usize];
        Some((number, self.leaves[number as usize]))
    }

    /// Visits what lies along one side of a leaf: from a cell, so many to the east or to the north.
    fn along(&self, (column, row): (i64, i64), count: i64, is_eastward: bool, visit: &mut impl FnMut(u32)) {
        let mut step = 0;
        while step < count {
            let (column, row) = if is_eastward { (column + step, row) } else { (column, row + step) };
            let Some((number, leaf)) = self.leaf(column, row) else {
                step += 1;
                continue;
            };
            visit(number);
            step += if is_eastward { leaf.column + leaf.side - column } else { leaf.row + leaf.side - row };
        }
    }
}

impl Cells for VaryingGrid<'_> {
    fn count(&self) -> usize {
        self.leaves.len()
    }

    fn middle(&self, leaf: u32) -> Point {
        let Leaf { column, row, side } = self.leaves[leaf as usize];
        let half = 0.5 * side as f64;
        self.grid.inside(column as f64 + half, row as f64 + half)
    }

    fn around(&self, leaf: u32, neighbours: Neighbours, mut visit: impl FnMut(u32)) {
        let Leaf { column, row, side } = self.leaves[leaf as usize];
        self.along((column - 1, row - 1), side + 2, true, &mut visit);
        self.along((column - 1, row + side), side + 2, true, &mut visit);
        self.along((column - 1, row), side, false, &mut visit);
        self.along((column + side, row), side, false, &mut visit);
        // A knight's move of its own size leads to a cell of its size, between cells that are no smaller.
        let at = |(east, north): (i64, i64)| self.leaf(column + east * side, row + north * side);
        let is_wide = |step: (i64, i64)| at(step).is_some_and(|(_, leaf)| leaf.side >= side);
        for step in neighbours.knights() {
            if let Some((number, _)) = at(*step).filter(|(_, leaf)| leaf.side == side)
                && between(*step).into_iter().all(is_wide)
            {
                visit(number);
            }
        }
    }
}

/// Squares of two by two cells that are wholly open.
fn halved(open: &[bool], [columns, rows]: [i64; 2]) -> (Vec<bool>, [i64; 2]) {
    let sides = [columns / 2, rows / 2];
    let at = |column: i64, row: i64| open[(row * columns + column) as usize];
    let whole = |number: i64| {
        let (column, row) = (number % sides[0] * 2, number / sides[0] * 2);
        at(column, row) && at(column + 1, row) && at(column, row + 1) && at(column + 1, row + 1)
    };
    ((0..sides[0] * sides[1]).map(whole).collect(), sides)
}
