//! A packed Hilbert R-tree over runs of vertices: built once, flat, searched without allocation.
//!
//! I. Kamel and C. Faloutsos, "Hilbert R-tree: an improved R-tree using fractals", VLDB 1994; packed as in
//! "On packing R-trees", CIKM 1993. Each box also knows the least depth below it, so that a search for the
//! shallowest never opens what is deeper than what it has.

use crate::grid::{Bounds, Vertex};

/// Boxes per node.
const FAN: usize = 16;

/// Consecutive vertices of one object: a polyline, or a point where there is one vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Index of the object; [`NO_DATA`] for the border of what is charted or, of quality, assessed.
    pub(super) object: u32,
}

/// Segments per run.
const RUN_SEGMENTS: usize = 8;

/// Cuts a polyline into runs that share their end vertices.
pub(super) fn cut(object: u32, first: u32, count: u32) -> impl Iterator<Item = Run> {
    let segments = count.saturating_sub(1).max(1) as usize;
    (0..segments).step_by(RUN_SEGMENTS).map(move |from| {
        let from = from as u32;
        Run { first: first + from, count: (count - from).min(RUN_SEGMENTS as u32 + 1), object }
    })
}

/// The object that stands for the absence of any.
pub(super) const NO_DATA: u32 = u32::MAX;

/// A box of the tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) bounds: Bounds,
    /// Least depth below (mm); `i32::MIN` for anything that is not a depth.
    pub(super) least_mm: i32,
}

/// The tree.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Tree {
    pub(super) runs: Vec<Run>,
    /// Boxes of the runs, then of each higher level.
    pub(super) nodes: Vec<Node>,
    /// Where each level begins.
    levels: Vec<usize>,
}

impl Tree {
    /// Builds the tree; `least_mm` gives the depth of an object.
    pub(super) fn build(runs: Vec<Run>, vertices: &[Vertex], least_mm: impl Fn(u32) -> i32) -> Self {
        let of_run = |run: &Run| Bounds::of(&vertices[run.first as usize..(run.first + run.count) as usize]);
        let mut whole = Bounds::EMPTY;
        let mut keyed: Vec<(u32, Bounds, Run)> = runs.into_iter().map(|run| (0, of_run(&run), run)).collect();
        for (_, bounds, _) in &keyed {
            whole.add(*bounds);
        }
        for (key, bounds, _) in &mut keyed {
            *key = hilbert(middle(bounds, &whole, 0), middle(bounds, &whole, 1));
        }
        keyed.sort_by_key(|(key, _, _)| *key);
        let mut nodes = Vec::with_capacity(keyed.len() + keyed.len() / (FAN - 1) + 8);
        for (_, bounds, run) in &keyed {
            nodes.push(Node { bounds: *bounds, least_mm: least_mm(run.object) });
        }
        let mut tree =
            Self { runs: keyed.into_iter().map(|(_, _, run)| run).collect(), nodes, levels: Vec::new() };
        tree.levels = level_starts(tree.runs.len());
        for level in 1..tree.levels.len() {
            let below = tree.levels[level - 1]..tree.levels[level];
            for group in below.clone().step_by(FAN) {
                let mut node = Node { bounds: Bounds::EMPTY, least_mm: i32::MAX };
                for child in &tree.nodes[group..(group + FAN).min(below.end)] {
                    node.bounds.add(child.bounds);
                    node.least_mm = node.least_mm.min(child.least_mm);
                }
                tree.nodes.push(node);
            }
        }
        tree
    }

    /// From stored runs and boxes; `None` where their numbers do not fit together.
    pub(super) fn from_parts(runs: Vec<Run>, nodes: Vec<Node>) -> Option<Self> {
        let levels = level_starts(runs.len());
        let expected = levels.last().map_or(0, |start| start + 1);
        (nodes.len() == expected).then_some(Self { runs, nodes, levels })
    }

    /// Visits every run whose boxes are all accepted.
    pub(super) fn search(&self, accept: impl Fn(&Node) -> bool, mut visit: impl FnMut(&Run)) {
        let Some(top) = self.levels.len().checked_sub(1) else { return };
        // Sixteen per level and at most eight levels: indices are u32.
        let mut stack = [(0_u8, 0_u32); FAN * 8];
        let mut depth = 1;
        stack[0] = (top as u8, 0);
        while depth > 0 {
            depth -= 1;
            let (level, index) = stack[depth];
            let (level, index) = (usize::from(level), index as usize);
            if !accept(&self.nodes[self.levels[level] + index]) {
                continue;
            }
            if level == 0 {
                visit(&self.runs[index]);
                continue;
            }
            for child in self.children(level, index) {
                stack[depth] = ((level - 1) as u8, child as u32);
                depth += 1;
            }
        }
    }

    /// The topmost node, if there is any: level, index and box.
    pub(super) fn top(&self) -> Option<(usize, usize)> {
        Some((self.levels.len().checked_sub(1)?, 0))
    }

    /// The box of all runs.
    pub(super) fn bounds(&self) -> Bounds {
        self.top().map_or(Bounds::EMPTY, |(level, index)| self.node(level, index).bounds)
    }

    pub(super) fn node(&self, level: usize, index: usize) -> &Node {
        &self.nodes[self.levels[level] + index]
    }

    /// Indices of a node's children on the level below.
    pub(super) fn children(&self, level: usize, index: usize) -> std::ops::Range<usize> {
        let size = self.levels[level] - self.levels[level - 1];
        index * FAN..(index * FAN + FAN).min(size)
    }
}

/// Where the levels of a tree of so many runs begin.
fn level_starts(runs: usize) -> Vec<usize> {
    let mut starts = Vec::new();
    let (mut start, mut size) = (0, runs);
    while size > 0 {
        starts.push(start);
        if size == 1 {
            break;
        }
        start += size;
        size = size.div_ceil(FAN);
    }
    starts
}

/// The middle of a box on an axis of the whole, in 16 bits.
fn middle(bounds: &Bounds, whole: &Bounds, axis: usize) -> u32 {
    let span = (i64::from(whole.max[axis]) - i64::from(whole.min[axis])).max(1);
    let twice = i64::from(bounds.min[axis]) + i64::from(bounds.max[axis]) - 2 * i64::from(whole.min[axis]);
    // Within 0 and 65535.
    (twice * 65_535 / (2 * span)) as u32
}

/// Position along a Hilbert curve of order 16 (J. Skilling's form for two axes).
fn hilbert(x: u32, y: u32) -> u32 {
    let (mut x, mut y, mut key) = (x, y, 0);
    let mut side = 1_u32 << 15;
    while side > 0 {
        let (rx, ry) = (u32::from(x & side > 0), u32::from(y & side > 0));
        key = (key << 2) | ((3 * rx) ^ ry);
        if ry == 0 {
            if rx == 1 {
                x = 65_535 - x;
                y = 65_535 - y;
            }
            std::mem::swap(&mut x, &mut y);
        }
        side >>= 1;
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_search_finds_what_a_scan_finds(
            vertices in prop::collection::vec([-99..99_i32, -99..99_i32], 1..900),
            corner in [-99..99_i32, -99..99_i32], size in 0..60_i32,
        ) {
            let runs: Vec<Run> = (0..vertices.len() as u32).map(|at| Run { first: at, count: 1, object: at }).collect();
            let tree = Tree::build(runs.clone(), &vertices, |object| object as i32);
            prop_assert_eq!(&Tree::from_parts(tree.runs.clone(), tree.nodes.clone()).unwrap(), &tree);
            let window = Bounds { min: corner, max: [corner[0] + size, corner[1] + size] };
            let mut found = Vec::new();
            tree.search(|node| node.bounds.overlaps(&window) && node.least_mm < 500, |run| found.push(run.object));
            found.sort_unstable();
            let inside = |run: &&Run| Bounds::of(&vertices[run.first as usize..=run.first as usize]).overlaps(&window);
            let scan: Vec<u32> = runs.iter().filter(inside).map(|run| run.object).filter(|at| *at < 500).collect();
            prop_assert_eq!(found, scan);
        }
    }
}
