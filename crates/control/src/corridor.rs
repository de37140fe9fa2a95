//! The band around a track within which a law steers to it; outside, the vessel crosses its edge at an angle.

use crate::range::RangeCheck;

/// A band around the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corridor {
    /// Half its width (m), 1 to 50, "Corridor -- Width".
    pub width_m: f64,
    /// Angle to the track at which its edge is crossed (rad), 2° to 45°, "Corridor -- Entry Angle".
    pub entry_angle_rad: f64,
}

impl Corridor {
    /// tan(entry angle) / width (1/m).
    pub(crate) fn slope_per_m(&self) -> f64 {
        self.entry_angle_rad.tan() / self.width_m
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.number("width", "m", self.width_m, 1.0..=50.0);
        let (least, most) = (2_f64.to_radians() - 1e-9, 45_f64.to_radians() + 1e-9);
        check.number("entry_angle", "rad", self.entry_angle_rad, least..=most);
    }
}
