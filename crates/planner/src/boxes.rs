//! A packed tree of boxes: which contain a point, which is nearest.
//!
//! Boxes are sorted along a curve that fills the plane (G. M. Morton 1966) and packed by eights, level by level
//! (I. Kamel and C. Faloutsos, "On packing R-trees", CIKM 1993).

use crate::plane::Point;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const FAN: usize = 8;

/// A box (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: Point,
    pub(crate) max: Point,
}

impl Bounds {
    const EMPTY: Self = Self {
        min: Point { x: f64::INFINITY, y: f64::INFINITY },
        max: Point { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY },
    };

    pub(crate) fn of(points: &[Point]) -> Self {
        points.iter().fold(Self::EMPTY, |all, point| all.with(Self { min: *point, max: *point }))
    }

    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            min: Point { x: self.min.x.min(other.min.x), y: self.min.y.min(other.min.y) },
            max: Point { x: self.max.x.max(other.max.x), y: self.max.y.max(other.max.y) },
        }
    }

    pub(crate) fn contains(&self, at: Point) -> bool {
        (self.min.x..=self.max.x).contains(&at.x) && (self.min.y..=self.max.y).contains(&at.y)
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.distance_m(other) == 0.0
    }

    /// Distance to another box (m), 0 where they meet.
    pub(crate) fn distance_m(&self, other: &Self) -> f64 {
        let dx = (other.min.x - self.max.x).max(self.min.x - other.max.x).max(0.0);
        let dy = (other.min.y - self.max.y).max(self.min.y - other.max.y).max(0.0);
        // Within some thousand kilometres no square is too large.
        (dx * dx + dy * dy).sqrt()
    }
}

/// The tree; what it holds is known by its number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Boxes {
    items: Vec<u32>,
    /// Boxes of the items, then of each higher level.
    bounds: Vec<Bounds>,
    levels: Vec<usize>,
}

/// By distance, a non-negative number, whose bits order like itself.
type Waiting = Reverse<(u64, usize, usize)>;

impl Boxes {
    /// About how much memory it takes (bytes).
    pub(crate) fn bytes(&self) -> usize {
        self.items.len() * size_of::<u32>() + self.bounds.len() * size_of::<Bounds>()
    }

    pub(crate) fn new(all: &[Bounds]) -> Self {
        let whole = all.iter().fold(Bounds::EMPTY, |whole, one| whole.with(*one));
        let key = |one: &Bounds| {
            let share = |min: f64, max: f64, low: f64, high: f64| {
                // Within 0 and 65535.
                ((f64::midpoint(min, max) - low) / (high - low).max(1e-9) * 65_535.0) as u32
            };
            let x = share(one.min.x, one.max.x, whole.min.x, whole.max.x);
            let y = share(one.min.y, one.max.y, whole.min.y, whole.max.y);
            spread(x) | spread(y) << 1
        };
        let mut items: Vec<u32> = (0..all.len() as u32).collect();
        items.sort_by_cached_key(|item| key(&all[*item as usize]));
        let mut boxes: Vec<Bounds> = items.iter().map(|item| all[*item as usize]).collect();
        let mut levels = Vec::new();
        let mut below = 0..boxes.len();
        while !below.is_empty() {
            levels.push(below.start);
            if below.len() == 1 {
                break;
            }
            for group in below.clone().step_by(FAN) {
                let group = &boxes[group..(group + FAN).min(below.end)];
                let over = group.iter().fold(Bounds::EMPTY, |all, one| all.with(*one));
                boxes.push(over);
            }
            below = below.end..boxes.len();
        }
        Self { items, bounds: boxes, levels }
    }

    /// The first item whose box holds a point and that is wanted.
    pub(crate) fn find(&self, at: Point, wanted: impl Fn(u32) -> bool) -> Option<u32> {
        let mut stack = vec![(self.levels.len().checked_sub(1)?, 0)];
        while let Some((level, index)) = stack.pop() {
            if !self.bounds[self.levels[level] + index].contains(at) {
                continue;
            }
            if level > 0 {
                stack.extend(self.children(level, index).map(|child| (level - 1, child)));
            } else if wanted(self.items[index]) {
                return Some(self.items[index]);
            }
        }
        None
    }

    /// Gives items by a growing lower bound of their distance to a box, until told to stop by the greatest distance (m)
    /// that is still of interest.
    pub(crate) fn nearest(&self, from: &Bounds, mut within_m: f64, mut visit: impl FnMut(u32) -> f64) {
        let Some(top) = self.levels.len().checked_sub(1) else { return };
        let mut heap: BinaryHeap<Waiting> = BinaryHeap::new();
        heap.push(Reverse((0, top, 0)));
        while let Some(Reverse((bits, level, index))) = heap.pop() {
            if f64::from_bits(bits) > within_m {
                return;
            }
            if level == 0 {
                within_m = within_m.min(visit(self.items[index]));
                continue;
            }
            for child in self.children(level, index) {
                let distance_m = self.bounds[self.levels[level - 1] + child].distance_m(from);
                if distance_m <= within_m {
                    heap.push(Reverse((distance_m.to_bits(), level - 1, child)));
                }
            }
        }
    }

    fn children(&self, level: usize, index: usize) -> std::ops::Range<usize> {
        let size = self.levels[level] - self.levels[level - 1];
        index * FAN..(index * FAN + FAN).min(size)
    }
}

/// Sixteen bits with a gap before each.
fn spread(value: u32) -> u32 {
    let mut bits = value & 0xffff;
    for (shift, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}
