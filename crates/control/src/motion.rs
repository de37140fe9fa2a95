//! How the vessel moves: heading and velocity over ground, from which course, surge and sway follow.
//!
//! Radians, headings and courses clockwise from north in (-π, π]; metres per second. Keeping the velocity in
//! one form (north, east) leaves no room for a course that disagrees with the speeds, nor for a sway of the
//! wrong sign.

use units::wrap_pi;

/// Heading, yaw rate and velocity over ground at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Where the bow points (rad, clockwise from north).
    pub heading_rad: f64,
    /// Rate of turn, positive to starboard (rad/s); `None` where nothing measures it.
    pub yaw_rate_rad_s: Option<f64>,
    /// Velocity over ground to the north (m/s).
    pub north_mps: f64,
    /// Velocity over ground to the east (m/s).
    pub east_mps: f64,
}

impl Motion {
    /// From course and speed over ground.
    pub fn from_course(
        heading_rad: f64,
        yaw_rate_rad_s: Option<f64>,
        course_rad: f64,
        speed_over_ground_mps: f64,
    ) -> Self {
        let (sin, cos) = course_rad.sin_cos();
        Self {
            heading_rad,
            yaw_rate_rad_s,
            north_mps: speed_over_ground_mps * cos,
            east_mps: speed_over_ground_mps * sin,
        }
    }

    /// Direction of the velocity over ground (rad); the heading where the vessel lies still.
    pub fn course_rad(&self) -> f64 {
        if self.speed_over_ground_mps() > 0.0 {
            wrap_pi(self.east_mps.atan2(self.north_mps))
        } else {
            wrap_pi(self.heading_rad)
        }
    }

    /// Magnitude of the velocity over ground (m/s).
    pub fn speed_over_ground_mps(&self) -> f64 {
        self.north_mps.hypot(self.east_mps)
    }

    /// Velocity over ground along the hull, positive ahead (m/s).
    pub fn surge_mps(&self) -> f64 {
        let (sin, cos) = self.heading_rad.sin_cos();
        self.north_mps * cos + self.east_mps * sin
    }

    /// Velocity over ground across the hull, positive to starboard (m/s).
    pub fn sway_mps(&self) -> f64 {
        let (sin, cos) = self.heading_rad.sin_cos();
        self.east_mps * cos - self.north_mps * sin
    }

    /// Course minus heading in (-π, π] (rad): positive when the vessel is set to starboard of its bow.
    pub fn crab_rad(&self) -> f64 {
        wrap_pi(self.course_rad() - self.heading_rad)
    }

    /// Whether every value is a number.
    pub fn is_finite(&self) -> bool {
        self.heading_rad.is_finite()
            && self.yaw_rate_rad_s.is_none_or(f64::is_finite)
            && self.north_mps.is_finite()
            && self.east_mps.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn sway_is_positive_when_set_to_starboard() {
        // Bow north, set to the east: sway to starboard, crab positive.
        let motion = Motion::from_course(0.0, None, 0.3, 2.0);
        assert!((motion.sway_mps() - 2.0 * 0.3_f64.sin()).abs() < 1e-12);
        assert!((motion.surge_mps() - 2.0 * 0.3_f64.cos()).abs() < 1e-12);
        assert!((motion.crab_rad() - 0.3).abs() < 1e-12);
    }

    #[test]
    fn going_astern_the_course_is_opposite_to_the_heading() {
        let motion = Motion::from_course(FRAC_PI_2, None, -FRAC_PI_2, 0.5);
        assert!((motion.surge_mps() + 0.5).abs() < 1e-12);
        assert!((motion.crab_rad().abs() - std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn lying_still_the_course_is_the_heading() {
        let motion = Motion { heading_rad: 1.2, yaw_rate_rad_s: None, north_mps: 0.0, east_mps: 0.0 };
        assert!((motion.course_rad() - 1.2).abs() < 1e-15);
        assert!(motion.crab_rad().abs() < 1e-15);
    }
}
