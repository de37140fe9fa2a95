//! Vector field: a course for every distance from the track.
//!
//! χ_d = χ - atan(g·y) with y positive to starboard and g = tan(entry angle)/width, so that the entry angle α
//! is met at the corridor's edge. The extended form acts inside the corridor: χ_d = χ - (y/W)ⁿ·α·(1 +
//! n·V·sin(γ - χ)/(m·y)), with odd powers of y, and χ itself within W/20 of the track (D. R. Nelson, D. B.
//! Barber, T. W. McLain & R. W. Beard, "Vector field path following for miniature air vehicles", IEEE Trans.
//! Robotics 23(3), 2007, straight-line law; form of DUNE's Control.Path.VectorField).

use crate::corridor::Corridor;
use crate::motion::Motion;
use crate::path::LegPosition;
use crate::range::RangeCheck;
use std::f64::consts::FRAC_PI_2;
use units::wrap_pi;

/// Parameters of the vector field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorFieldConfig {
    /// Where the entry angle is met.
    pub corridor: Corridor,
    /// The extended form inside the corridor; `None` = the same law everywhere.
    pub extended: Option<ExtendedField>,
}

/// Parameters of the extended form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedField {
    /// Exponent n, 1 to 10, "Extended Control -- Gain".
    pub exponent: f64,
    /// Turn-rate gain m (rad/s per rad), 0.01 to 100, "Extended Control -- Turn Rate Gain".
    pub turn_rate_gain: f64,
}

impl VectorFieldConfig {
    /// Plain field, for Fossen's Otter.
    pub fn otter() -> Self {
        Self { corridor: Corridor { width_m: 5.0, entry_angle_rad: 45_f64.to_radians() }, extended: None }
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.within("corridor", |check| self.corridor.check(check));
        if let Some(ExtendedField { exponent, turn_rate_gain }) = self.extended {
            check.number("extended.exponent", "1", exponent, 1.0..=10.0);
            check.number("extended.turn_rate_gain", "1/s", turn_rate_gain, 0.01..=100.0);
        }
    }

    /// Desired course (rad) on a leg.
    pub(crate) fn course_rad(&self, leg: &LegPosition, motion: &Motion) -> f64 {
        let Corridor { width_m, entry_angle_rad } = self.corridor;
        let y = leg.cross_m;
        let angle = match self.extended {
            Some(field) if y.abs() <= width_m => {
                if y.abs() <= 0.05 * width_m {
                    0.0
                } else {
                    let ExtendedField { exponent, turn_rate_gain } = field;
                    let aside = (y.abs() / width_m).powf(exponent).copysign(y);
                    let towards =
                        motion.speed_over_ground_mps() * (motion.course_rad() - leg.bearing_rad).sin();
                    let factor = 1.0 + exponent * towards / (turn_rate_gain * y);
                    (aside * entry_angle_rad * factor).clamp(-FRAC_PI_2, FRAC_PI_2)
                }
            }
            _ => (self.corridor.slope_per_m() * y).atan(),
        };
        wrap_pi(leg.bearing_rad - angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn leg(cross_m: f64) -> LegPosition {
        LegPosition { along_m: 10.0, cross_m, length_m: 500.0, bearing_rad: 0.4, end_bearing_rad: 2.0 }
    }

    fn along_track() -> Motion {
        Motion::from_course(0.4, None, 0.4, 1.5)
    }

    #[test]
    fn meets_the_entry_angle_at_the_edge_in_both_forms() {
        let plain =
            VectorFieldConfig { corridor: Corridor { width_m: 4.0, entry_angle_rad: 0.5 }, extended: None };
        let extended = VectorFieldConfig {
            extended: Some(ExtendedField { exponent: 2.0, turn_rate_gain: 1.0 }),
            ..plain
        };
        for config in [plain, extended] {
            assert!((config.course_rad(&leg(4.0), &along_track()) - (0.4 - 0.5)).abs() < 1e-9);
            assert!((config.course_rad(&leg(-4.0), &along_track()) - (0.4 + 0.5)).abs() < 1e-9);
            assert!((config.course_rad(&leg(0.0), &along_track()) - 0.4).abs() < 1e-9);
        }
        // Half way, squared: a quarter of the angle.
        assert!((extended.course_rad(&leg(2.0), &along_track()) - (0.4 - 0.125)).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn course_is_a_number_on_the_side_of_the_track(
            y in any::<f64>(), course_rad in -3.1..3.1_f64, speed_mps in 0.0..3.0_f64, wide in any::<bool>(),
        ) {
            let extended = wide.then_some(ExtendedField { exponent: 1.5, turn_rate_gain: 0.5 });
            let config = VectorFieldConfig { extended, ..VectorFieldConfig::otter() };
            let motion = Motion::from_course(course_rad, None, course_rad, speed_mps);
            let got = wrap_pi(config.course_rad(&leg(y), &motion) - 0.4);
            prop_assert!(got.is_finite() && got.abs() <= FRAC_PI_2 + 1e-9);
            let mirrored = Motion::from_course(0.8 - course_rad, None, 0.8 - course_rad, speed_mps);
            let other = wrap_pi(config.course_rad(&leg(-y), &mirrored) - 0.4);
            prop_assert!((got + other).abs() < 1e-9);
        }
    }
}
