//! A part of a plane between two corners.

use crate::boxes::Bounds;
use crate::plane::Point;

/// Corners of what is cut out of a region are rounded to centimetres: what lies so near its border is on it (m).
const ROUNDED_M: f64 = 0.02;

/// A region as its corners: least and greatest (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Region {
    pub(crate) min: Point,
    pub(crate) max: Point,
}

impl Region {
    /// The smallest that holds some points.
    pub(crate) fn of(points: &[Point]) -> Self {
        let Bounds { min, max } = Bounds::of(points);
        Self { min, max }
    }

    /// What it has in common with another that it meets.
    pub(crate) fn common(&self, other: Self) -> Self {
        Self {
            min: Point { x: self.min.x.max(other.min.x), y: self.min.y.max(other.min.y) },
            max: Point { x: self.max.x.min(other.max.x), y: self.max.y.min(other.max.y) },
        }
    }

    /// Whether a point lies in it or on its border.
    pub(crate) fn holds(&self, at: Point) -> bool {
        (self.min.x..=self.max.x).contains(&at.x) && (self.min.y..=self.max.y).contains(&at.y)
    }

    /// How far a point lies from it (m); 0 within.
    pub(crate) fn distance_m(&self, at: Point) -> f64 {
        let off_m = |at: f64, min: f64, max: f64| (min - at).max(at - max).max(0.0);
        off_m(at.x, self.min.x, self.max.x).hypot(off_m(at.y, self.min.y, self.max.y))
    }

    /// Whether a corner of what was cut out of it lies on its border.
    pub(crate) fn is_at_border(&self, at: Point) -> bool {
        let off_m = [at.x - self.min.x, self.max.x - at.x, at.y - self.min.y, self.max.y - at.y];
        off_m.into_iter().any(|off_m| off_m < ROUNDED_M)
    }

    /// Its border, closed.
    pub(crate) fn ring(&self) -> [Point; 5] {
        let Self { min, max } = *self;
        [min, Point { x: max.x, y: min.y }, max, Point { x: min.x, y: max.y }, min]
    }

    /// In square metres.
    pub(crate) fn area(&self) -> f64 {
        (self.max.x - self.min.x) * (self.max.y - self.min.y)
    }

    /// With so much more around it (m).
    pub(crate) fn wider(&self, by_m: f64) -> Self {
        let Self { min, max } = self;
        Self {
            min: Point { x: min.x - by_m, y: min.y - by_m },
            max: Point { x: max.x + by_m, y: max.y + by_m },
        }
    }

    /// The part of a segment that lies within (Y.-D. Liang and B. A. Barsky 1984).
    pub(crate) fn clip(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        let sides = [
            (-dx, a.x - self.min.x),
            (dx, self.max.x - a.x),
            (-dy, a.y - self.min.y),
            (dy, self.max.y - a.y),
        ];
        for (outward, room) in sides {
            if outward == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if outward < 0.0 {
                enters = enters.max(room / outward);
            } else {
                leaves = leaves.min(room / outward);
            }
        }
        (enters <= leaves).then(|| (a.towards(b, enters), a.towards(b, leaves)))
    }
}
