//! The grid that positions of charts are rounded to: whole numbers of 1e-7 degrees.
//!
//! 1e-7 degrees are 11 mm or less. Real cells are written in that unit; others are rounded by half of it, the same way
//! for every object, so that shared borders stay shared.

/// Units in a degree.
pub(crate) const PER_DEGREE: f64 = 1e7;

/// A vertex: longitude and latitude (WGS 84) in whole numbers of 1e-7 degrees.
pub type Vertex = [i32; 2];

/// A vertex of degrees; `None` outside the globe.
pub(crate) fn vertex(lon_deg: f64, lat_deg: f64) -> Option<Vertex> {
    let inside = lon_deg.abs() <= 180.0 && lat_deg.abs() <= 90.0;
    // Within ±1.8e9, so within i32.
    inside.then(|| [(lon_deg * PER_DEGREE).round() as i32, (lat_deg * PER_DEGREE).round() as i32])
}

/// A box in units, borders included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub(crate) min: Vertex,
    pub(crate) max: Vertex,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { min: [i32::MAX; 2], max: [i32::MIN; 2] };

    pub(crate) fn of<'a>(vertices: impl IntoIterator<Item = &'a Vertex>) -> Self {
        let mut bounds = Self::EMPTY;
        for vertex in vertices {
            bounds.add(Self { min: *vertex, max: *vertex });
        }
        bounds
    }

    pub(crate) fn add(&mut self, other: Self) {
        for axis in 0..2 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// Whether a box lies within; an empty one does everywhere.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        other.min[0] > other.max[0]
            || (0..2).all(|axis| self.min[axis] <= other.min[axis] && other.max[axis] <= self.max[axis])
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }
}
