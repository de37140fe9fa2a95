//! The slowly varying angle between bow and course, so that a course can be steered by the compass.
//!
//! Course is not heading: current and wind set the boat sideways by the crab angle β = course - heading. To
//! hold a desired course χ the yaw loop holds the heading χ - β with β low-pass filtered: the compass closes
//! the fast loop, the noisy course over ground only the slow one. β fades out towards the minimum speed, below
//! which the course of a GNSS receiver is noise, and while the boat goes astern.

use crate::motion::Motion;
use crate::range::RangeCheck;
use std::f64::consts::FRAC_PI_2;

/// How a desired course is steered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CourseTracking {
    /// The desired course is held as a heading; the guidance's integrator must find the crab angle.
    AsHeading,
    /// By the filtered crab angle.
    Filtered {
        /// No crab angle is used below this speed over ground (m/s), 0.05 to 5; all of it above 1.5 times.
        min_speed_mps: f64,
        /// Time constant of the filter (s), 0.1 to 60.
        time_constant_s: f64,
    },
}

impl CourseTracking {
    pub(crate) fn check(&self, check: &mut RangeCheck) {
        if let Self::Filtered { min_speed_mps, time_constant_s } = *self {
            check.number("min_speed", "m/s", min_speed_mps, 0.05..=5.0);
            check.number("time_constant", "s", time_constant_s, 0.1..=60.0);
        }
    }
}

/// The filter's memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CrabFilter {
    crab_rad: f64,
}

impl CrabFilter {
    /// One step of `dt_s` seconds: the crab angle to subtract from a desired course (rad), within ±π/2.
    pub(crate) fn update(&mut self, tracking: CourseTracking, motion: &Motion, dt_s: f64) -> f64 {
        let CourseTracking::Filtered { min_speed_mps, time_constant_s } = tracking else {
            self.crab_rad = 0.0;
            return 0.0;
        };
        let speed = motion.speed_over_ground_mps();
        let raw_rad = motion.crab_rad();
        let weight = if raw_rad.abs() >= FRAC_PI_2 {
            0.0
        } else {
            ((speed - min_speed_mps) / (0.5 * min_speed_mps)).clamp(0.0, 1.0)
        };
        let gain = 1.0 - (-dt_s.max(0.0) / time_constant_s).exp();
        self.crab_rad += gain * (weight * raw_rad - self.crab_rad);
        self.crab_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRACKING: CourseTracking = CourseTracking::Filtered { min_speed_mps: 0.4, time_constant_s: 2.0 };

    #[test]
    fn finds_a_steady_crab_angle_above_the_minimum_speed_only() {
        for (speed_mps, expected_rad) in [(1.0, 0.2), (0.5, 0.1), (0.3, 0.0)] {
            let mut filter = CrabFilter::default();
            let motion = Motion::from_course(1.0, None, 1.2, speed_mps);
            for _ in 0..300 {
                filter.update(TRACKING, &motion, 0.1);
            }
            let got = filter.update(TRACKING, &motion, 0.1);
            assert!((got - expected_rad).abs() < 1e-3, "{speed_mps} m/s: {got}");
        }
    }

    #[test]
    fn ignores_the_course_while_going_astern() {
        let mut filter = CrabFilter::default();
        let motion = Motion::from_course(0.0, None, 3.0, 1.0);
        assert!(filter.update(TRACKING, &motion, 10.0).abs() < 1e-12);
    }
}
