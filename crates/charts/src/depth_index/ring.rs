//! Rings and whether a point lies within: exact, the same for both neighbours of a border, and in
//! logarithmic time.
//!
//! A ray towards growing longitude counts crossings under the half-open rule (a segment is crossed where
//! exactly one end lies above), upward ones as 1 and downward ones as -1: how often the ring runs round the point. Every
//! segment is tested from its lower end, so that both areas of a shared border decide alike: a point belongs to
//! exactly one of them. Boxes over runs of segments, and boxes over boxes, answer for everything that lies wholly to one
//! side: to the right of the point a run counts as the straight line between its two ends.

use super::coords::Spot;
use crate::grid::{Bounds, Vertex};

/// Segments per lowest box and boxes per higher box.
const FAN: usize = 8;

/// A closed ring: vertices `first..first + count`, the last equal to the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ring {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Where its boxes begin; they follow level by level, lowest first.
    pub(super) boxes: u32,
}

impl Ring {
    pub(super) fn segments(self) -> usize {
        (self.count as usize).saturating_sub(1)
    }

    pub(super) fn vertices(self, all: &[Vertex]) -> &[Vertex] {
        &all[self.first as usize..(self.first + self.count) as usize]
    }

    /// How many boxes a ring of so many segments has.
    pub(super) fn box_count(segments: usize) -> usize {
        let (mut level, mut sum) = (segments.div_ceil(FAN).max(1), 0);
        loop {
            sum += level;
            if level == 1 {
                return sum;
            }
            level = level.div_ceil(FAN);
        }
    }

    /// Appends the boxes of a ring.
    pub(super) fn push_boxes(vertices: &[Vertex], boxes: &mut Vec<Bounds>) {
        let segments = vertices.len().saturating_sub(1);
        let mut from = boxes.len();
        for at in 0..segments.div_ceil(FAN).max(1) {
            let end = (at * FAN + FAN).min(segments);
            boxes.push(Bounds::of(&vertices[at * FAN..=end]));
        }
        while boxes.len() - from > 1 {
            let level = from..boxes.len();
            for group in level.clone().step_by(FAN) {
                let mut bounds = Bounds::EMPTY;
                for child in &boxes[group..(group + FAN).min(level.end)] {
                    bounds.add(*child);
                }
                boxes.push(bounds);
            }
            from = level.end;
        }
    }

    /// How often the ring runs round a point, anticlockwise being positive.
    pub(super) fn turns(self, all: &[Vertex], boxes: &[Bounds], at: Spot) -> i32 {
        let vertices = self.vertices(all);
        let boxes = &boxes[self.boxes as usize..];
        // Starts and sizes of the levels, lowest first: eight levels hold 8^9 segments.
        let mut starts = [0_usize; 12];
        let (mut top, mut size) = (0, self.segments().div_ceil(FAN).max(1));
        while size > 1 && top < 11 {
            starts[top + 1] = starts[top] + size;
            size = size.div_ceil(FAN);
            top += 1;
        }
        let walk = Walk { vertices, boxes, starts, at };
        walk.turns(top, 0)
    }
}

struct Walk<'a> {
    vertices: &'a [Vertex],
    boxes: &'a [Bounds],
    starts: [usize; 12],
    at: Spot,
}

impl Walk<'_> {
    fn turns(&self, level: usize, index: usize) -> i32 {
        let bounds = &self.boxes[self.starts[level] + index];
        let Spot { x, y } = self.at;
        if f64::from(bounds.min[1]) > y || f64::from(bounds.max[1]) <= y || f64::from(bounds.max[0]) < x {
            return 0;
        }
        let span = FAN.pow(level as u32 + 1);
        let from = index * span;
        let to = (from + span).min(self.vertices.len() - 1);
        if f64::from(bounds.min[0]) > x {
            let above = |vertex: usize| i32::from(f64::from(self.vertices[vertex][1]) > y);
            return above(to) - above(from);
        }
        if level == 0 {
            return self.vertices[from..=to].windows(2).map(|pair| crossing(pair[0], pair[1], self.at)).sum();
        }
        let below = (self.starts[level] - self.starts[level - 1]).min(index * FAN + FAN);
        (index * FAN..below).map(|child| self.turns(level - 1, child)).sum()
    }
}

/// 1 where a segment crosses the ray from `at` towards growing longitude upward, -1 where downward, else 0.
fn crossing(a: Vertex, b: Vertex, at: Spot) -> i32 {
    let (low, high, sign) = if a[1] <= b[1] { (a, b, 1) } else { (b, a, -1) };
    if f64::from(low[1]) > at.y || f64::from(high[1]) <= at.y {
        return 0;
    }
    let (dx, dy) = (f64::from(high[0]) - f64::from(low[0]), f64::from(high[1]) - f64::from(low[1]));
    if dx * (at.y - f64::from(low[1])) - dy * (at.x - f64::from(low[0])) > 0.0 { sign } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn turns(vertices: &[Vertex], at: Spot) -> i32 {
        let mut boxes = Vec::new();
        Ring::push_boxes(vertices, &mut boxes);
        assert_eq!(boxes.len(), Ring::box_count(vertices.len() - 1));
        Ring { first: 0, count: vertices.len() as u32, boxes: 0 }.turns(vertices, &boxes, at)
    }

    proptest! {
        #[test]
        fn boxes_answer_as_all_segments_do(
            mut vertices in prop::collection::vec([-50..50_i32, -50..50_i32], 3..700),
            x in -60.0..60.0_f64, y in -60.0..60.0_f64, whole in any::<bool>(),
        ) {
            vertices.push(vertices[0]);
            let at = if whole { Spot { x: x.round(), y: y.round() } } else { Spot { x, y } };
            let plain: i32 = vertices.windows(2).map(|pair| crossing(pair[0], pair[1], at)).sum();
            prop_assert_eq!(turns(&vertices, at), plain);
        }
    }
}
