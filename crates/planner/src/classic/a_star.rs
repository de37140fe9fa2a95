//! A* over the cells of a grid, whatever their sizes.

use super::Neighbours;
use crate::Cancel;
use crate::plane::Point;
use crate::room::PlanError;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cells that are closed between two looks at whether the answer is still wanted.
const CELLS_BETWEEN_LOOKS: usize = 4_096;
/// The cell before the start.
const NONE: u32 = u32::MAX;

/// Cells by number, and which lie beside each other.
pub(super) trait Cells {
    /// How many numbers there are.
    fn count(&self) -> usize;
    fn middle(&self, cell: u32) -> Point;
    /// Visits the open neighbours of a cell; one may be visited twice.
    fn around(&self, cell: u32, neighbours: Neighbours, visit: impl FnMut(u32));
}

/// A way from cell to cell.
pub(super) struct Found {
    pub(super) nodes: Vec<u32>,
    /// Times that a cell was put in the open list, and cells that were closed.
    pub(super) effort: [usize; 2],
}

/// From start to goal by the straight distance, times a weight, as heuristic. A closed cell stays closed.
pub(super) fn search(
    cells: &impl Cells,
    [start, goal]: [u32; 2],
    (neighbours, weight): (Neighbours, f64),
    cancel: &Cancel<'_>,
) -> Result<Option<Found>, PlanError> {
    let goal_at = cells.middle(goal);
    let mut best_m = vec![f32::INFINITY; cells.count()];
    let mut before = vec![NONE; cells.count()];
    let mut is_closed = vec![false; cells.count()];
    let mut heap = BinaryHeap::new();
    let [mut opened, mut closed] = [1, 0];
    best_m[start as usize] = 0.0;
    heap.push(Reverse((0_u32, start)));
    while let Some(Reverse((_, cell))) = heap.pop() {
        if std::mem::replace(&mut is_closed[cell as usize], true) {
            continue;
        }
        if closed % CELLS_BETWEEN_LOOKS == 0 {
            cancel.check()?;
        }
        closed += 1;
        if cell == goal {
            return Ok(Some(Found { nodes: back(goal, &before), effort: [opened, closed] }));
        }
        let at = cells.middle(cell);
        cells.around(cell, neighbours, |next| {
            let to = cells.middle(next);
            let length_m = best_m[cell as usize] + at.distance_m(to) as f32;
            if is_closed[next as usize] || length_m >= best_m[next as usize] {
                return;
            }
            best_m[next as usize] = length_m;
            before[next as usize] = cell;
            opened += 1;
            let rest_m = to.distance_m(goal_at) * weight;
            // Positive floats order as their bits.
            heap.push(Reverse(((length_m + rest_m as f32).to_bits(), next)));
        });
    }
    Ok(None)
}

fn back(goal: u32, before: &[u32]) -> Vec<u32> {
    let mut nodes = vec![goal];
    let mut at = before[goal as usize];
    while at != NONE {
        nodes.push(at);
        at = before[at as usize];
    }
    nodes.reverse();
    nodes
}
