//! Positions between the vertices of the [grid](crate::grid), and metres round a place.
//!
//! A line of the chart is straight in longitude
//! and latitude. A local frame scales both axes by constants, so it keeps such lines straight, and distances
//! in it are exact up to how the scale of longitude changes over its reach; [`Frame::slack_m`] bounds that.

use crate::grid::{Bounds, PER_DEGREE, Vertex};
use units::{LatLon, WGS84_ECCENTRICITY_SQUARED, WGS84_SEMI_MAJOR_M};

/// Units around the Earth.
pub(super) const TURN: f64 = 3.6e9;
/// Rounding of coordinates (0.6 cm) and the step across a border by which its other side is found (3 units of
/// 1.1 cm), rounded up (m).
pub(super) const ROUNDING_M: f64 = 0.05;

/// A position in units, not rounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spot {
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Spot {
    pub(super) fn of(place: LatLon) -> Self {
        Self { x: place.lon_deg() * PER_DEGREE, y: place.lat_deg() * PER_DEGREE }
    }

    pub(super) fn of_vertex(vertex: Vertex) -> Self {
        Self { x: f64::from(vertex[0]), y: f64::from(vertex[1]) }
    }

    /// The same place with its longitude from -180° to below 180°.
    pub(super) fn wrapped(self) -> Self {
        let half = TURN / 2.0;
        let x = if self.x >= half {
            self.x - TURN
        } else if self.x < -half {
            self.x + TURN
        } else {
            self.x
        };
        Self { x, ..self }
    }

    pub(super) fn place(self) -> LatLon {
        let lat_deg = (self.y / PER_DEGREE).clamp(-90.0, 90.0);
        let lon_deg = (self.wrapped().x / PER_DEGREE).clamp(-180.0, 180.0);
        LatLon::from_deg(lat_deg, lon_deg).expect("invariant: clamped to the range")
    }
}

impl Bounds {
    /// Whether a point lies within, or on the border.
    pub(super) fn holds(&self, at: Spot) -> bool {
        let within = |value: f64, axis: usize| {
            f64::from(self.min[axis]) <= value && value <= f64::from(self.max[axis])
        };
        within(at.x, 0) && within(at.y, 1)
    }
}

/// Metres per unit round a latitude.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Metres per unit of longitude.
    pub(super) kx_m: f64,
    /// Metres per unit of latitude.
    pub(super) ky_m: f64,
    /// How fast the first changes: its relative change per metre north.
    pub(super) bend: f64,
}

impl Frame {
    pub(super) fn at(lat_units: f64) -> Self {
        let lat_rad = (lat_units / PER_DEGREE).to_radians();
        let (sin_lat, cos_lat) = lat_rad.sin_cos();
        let w2 = 1.0 - WGS84_ECCENTRICITY_SQUARED * sin_lat * sin_lat;
        let normal_m = WGS84_SEMI_MAJOR_M / w2.sqrt();
        let meridian_m = normal_m * (1.0 - WGS84_ECCENTRICITY_SQUARED) / w2;
        let per_unit = (1.0 / PER_DEGREE).to_radians();
        // At a pole every longitude is the same place; keep the divisions finite.
        let parallel_m = (normal_m * cos_lat).max(1e-3);
        Self {
            kx_m: parallel_m * per_unit,
            ky_m: meridian_m * per_unit,
            // d(ln parallel)/d(north) = tan(lat)/N; the meridian's own change is below 1 % of 1/N.
            bend: ((sin_lat.abs() / cos_lat.max(1e-6)) + 0.02) / 6.33e6,
        }
    }

    pub(super) fn distance_m(&self, a: Spot, b: Spot) -> f64 {
        ((b.x - a.x) * self.kx_m).hypot((b.y - a.y) * self.ky_m)
    }

    /// By how much a width must grow so that nothing within it on the ground is missed: rounding, the bow of
    /// the geodesic over a piece of that length, and the change of scale over the reach.
    pub(super) fn slack_m(&self, length_m: f64, half_width_m: f64) -> f64 {
        let bow_m = length_m * length_m * self.bend / 8.0;
        let scale = (length_m / 2.0 + half_width_m) * self.bend;
        ROUNDING_M + bow_m + half_width_m * scale
    }

    /// The longest piece of a leg whose bow stays within 5 cm (m).
    pub(super) fn piece_m(&self) -> f64 {
        (0.4 / self.bend).sqrt().clamp(50.0, 2_000.0)
    }
}

/// Distance of two near places (m): the frame halfway, whose error grows with the cube of the distance
/// (below 1 mm at 1 km and 1 m at 10 km at 63°N).
pub(super) fn distance_m(a: Spot, b: Spot) -> f64 {
    Frame::at(f64::midpoint(a.y, b.y)).distance_m(a, b)
}

/// The longitude of `x` that lies within half a turn of `near`.
pub(super) fn unwrap_near(x: f64, near: f64) -> f64 {
    if x - near > TURN / 2.0 {
        x - TURN
    } else if near - x > TURN / 2.0 {
        x + TURN
    } else {
        x
    }
}
