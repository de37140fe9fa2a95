//! Rows coverage: rows whose distance follows from a sensor's swath. Its machine is
//! [`waypoints`](super::waypoints).
//!
//! Rows are laid out with the full swath, 2·range·sin(aperture/2), alike at both ends. Where the water below
//! the vessel is measured, the sideways steps shrink to what the sensor sees there with the wanted overlap.

use super::rows::{LEAST_M, Rows, RowsPoints};
use crate::checks::Checks;
use crate::place::RawPlace;
use units::LatLon;
use units::Speed;

/// A step never shrinks below this part of the full one: shallow water must not make the rows endless.
const LEAST_SCALE: f64 = 0.1;

/// Sweep an area for a sensor's swath.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowsCoverage<P = LatLon> {
    /// Where the first row starts.
    pub origin: P,
    /// How fast.
    pub speed: Speed,
    /// Direction of the first row (rad).
    pub bearing_rad: f64,
    /// How far the sideways step is turned clockwise (rad).
    pub cross_angle_rad: f64,
    /// Extent across the rows (m).
    pub width_m: f64,
    /// Length of a row (m).
    pub length_m: f64,
    /// How far rows are overrun before turning (m).
    pub curve_offset_m: f64,
    /// The sensor's swath.
    pub swath: Swath,
    /// Turns are squares instead of diagonals.
    pub square_curve: bool,
    /// The first curve goes to the right.
    pub curve_right: bool,
}

/// The swath of a sensor on both sides of the vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swath {
    /// Range (m).
    pub range_m: f64,
    /// Angle of view (rad); 0 or less means all around.
    pub aperture_rad: f64,
    /// Part of the swath seen twice, 0 to 1.
    pub overlap: f64,
}

impl Swath {
    /// Full width (m).
    pub fn width_m(&self) -> f64 {
        if self.aperture_rad > 0.0 {
            2.0 * self.range_m * (self.aperture_rad / 2.0).sin()
        } else {
            2.0 * self.range_m
        }
    }

    /// The sideways step with so much water below, as a part of the full width.
    pub(super) fn step_scale(&self, water_below_m: Option<f64>) -> f64 {
        let Some(below_m) = water_below_m.filter(|below_m| *below_m > 0.0) else {
            return 1.0;
        };
        let seen_m = if self.aperture_rad > 0.0 {
            (2.0 * below_m * (self.aperture_rad / 2.0).tan()).min(self.width_m())
        } else {
            self.width_m()
        };
        (seen_m * (1.0 - self.overlap / 2.0) / self.width_m()).clamp(LEAST_SCALE, 1.0)
    }
}

impl<P: Copy> RowsCoverage<P> {
    /// The rows before any water is measured.
    pub fn rows(&self) -> Rows<P> {
        Rows {
            origin: self.origin,
            speed: self.speed,
            bearing_rad: self.bearing_rad,
            cross_angle_rad: self.cross_angle_rad,
            width_m: self.width_m,
            length_m: self.length_m,
            step_m: self.swath.width_m(),
            curve_offset_m: self.curve_offset_m,
            alternation: 1.0,
            square_curve: self.square_curve,
            curve_right: self.curve_right,
        }
    }
}

impl RowsCoverage<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<RowsCoverage> {
        checks.at_least("range", self.swath.range_m, LEAST_M);
        checks.within("aperture", self.swath.aperture_rad, -std::f64::consts::PI, std::f64::consts::PI);
        checks.within("overlap", self.swath.overlap, 0.0, 1.0);
        let rows = self.rows().check(checks)?;
        Some(RowsCoverage {
            origin: rows.origin,
            speed: self.speed,
            bearing_rad: self.bearing_rad,
            cross_angle_rad: self.cross_angle_rad,
            width_m: self.width_m,
            length_m: self.length_m,
            curve_offset_m: self.curve_offset_m,
            swath: self.swath,
            square_curve: self.square_curve,
            curve_right: self.curve_right,
        })
    }
}

impl RowsCoverage {
    /// The points before any water is measured, as metres north and east of the origin.
    pub fn points(&self) -> RowsPoints {
        self.rows().points()
    }
}
