//! Following a circle: the tangent, bent towards the circle by the distance from it.
//!
//! χ_d = tangent ± atan(2g·(e + κI)) with e the distance outside the circle, g = tan(entry angle)/width, and
//! plus for clockwise (DUNE's loiter law, for which κ = 0). The integrator is that of line of sight with lookahead
//! 1/2g; without it the lag of the yaw loop and a current leave the vessel beside the circle. The rate at
//! which the tangent turns is fed forward to the yaw loop.

use crate::corridor::Corridor;
use crate::ilos::{Ilos, IntegratorForm};
use crate::motion::Motion;
use crate::path::CirclePosition;
use crate::range::RangeCheck;
use crate::steering::Steering;
use units::wrap_pi;

/// Parameters of circle following.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleConfig {
    /// Where the entry angle would be met at half the slope; the integrator works within it.
    pub corridor: Corridor,
    /// Gain κ of the integrator (1/s), 0 to 4; 0 in DUNE.
    pub integrator_gain: f64,
}

impl CircleConfig {
    /// Tuned on Fossen's Otter.
    pub fn otter() -> Self {
        Self {
            corridor: Corridor { width_m: 4.0, entry_angle_rad: 30_f64.to_radians() },
            integrator_gain: 0.2,
        }
    }

    /// DUNE's law with the thesis' corridor.
    pub fn thesis() -> Self {
        Self {
            corridor: Corridor { width_m: 1.5, entry_angle_rad: 15_f64.to_radians() },
            integrator_gain: 0.0,
        }
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.within("corridor", |check| self.corridor.check(check));
        check.number("integrator_gain", "1/s", self.integrator_gain, 0.0..=4.0);
    }

    /// Desired course and its rate on a circle, `dt_s` after the step before.
    pub(crate) fn steer(
        &self,
        integrator: &mut Ilos,
        circle: &CirclePosition,
        motion: &Motion,
        dt_s: f64,
    ) -> Steering {
        let outside_m = circle.outside_m();
        let slope_per_m = 2.0 * self.corridor.slope_per_m();
        if outside_m.abs() > self.corridor.width_m {
            integrator.clear();
        } else {
            let form = IntegratorForm::Corrected;
            integrator.integrate(1.0 / slope_per_m, self.integrator_gain, form, outside_m, dt_s);
        }
        let error_m = outside_m + self.integrator_gain * integrator.integral();
        let sense = circle.loiter.turn.sign();
        let tangent_rad = circle.tangent_rad();
        let along_mps = motion.speed_over_ground_mps() * wrap_pi(motion.course_rad() - tangent_rad).cos();
        let radius_m = circle.range_m.max(circle.loiter.radius_m / 2.0);
        Steering {
            course_rad: wrap_pi(tangent_rad + sense * (slope_per_m * error_m).atan()),
            turn_rate_rad_s: sense * along_mps.max(0.0) / radius_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Loiter;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};
    use units::Turn;

    fn circle(range_m: f64, bearing_from_centre_rad: f64, turn: Turn) -> CirclePosition {
        let centre_bearing_rad = wrap_pi(bearing_from_centre_rad + PI);
        CirclePosition { range_m, centre_bearing_rad, loiter: Loiter { radius_m: 20.0, turn } }
    }

    fn still() -> Motion {
        Motion::from_course(0.0, None, 0.0, 0.0)
    }

    #[test]
    fn follows_the_tangent_and_turns_inward_when_outside() {
        let config = CircleConfig::thesis();
        let bend = (2.0 * 15_f64.to_radians().tan() / 1.5 * 3.0).atan();
        // West of the centre: clockwise is north.
        for (range_m, turn, course_rad) in [
            (20.0, Turn::Clockwise, 0.0),
            (23.0, Turn::Clockwise, bend),
            (17.0, Turn::Clockwise, -bend),
            (20.0, Turn::CounterClockwise, PI),
            (23.0, Turn::CounterClockwise, PI - bend),
        ] {
            let got = config.steer(&mut Ilos::default(), &circle(range_m, -FRAC_PI_2, turn), &still(), 0.1);
            assert!(wrap_pi(got.course_rad - course_rad).abs() < 1e-9, "{range_m} {turn:?}: {got:?}");
        }
    }

    #[test]
    fn tells_how_fast_the_tangent_turns() {
        let config = CircleConfig::otter();
        let motion = Motion::from_course(0.0, None, 0.0, 1.0);
        let got =
            config.steer(&mut Ilos::default(), &circle(20.0, -FRAC_PI_2, Turn::Clockwise), &motion, 0.1);
        assert!((got.turn_rate_rad_s - 0.05).abs() < 1e-9);
        let against = circle(20.0, -FRAC_PI_2, Turn::CounterClockwise);
        let got = config.steer(&mut Ilos::default(), &against, &motion, 0.1);
        assert!(got.turn_rate_rad_s.abs() < 1e-9, "going the wrong way round: {got:?}");
    }

    proptest! {
        #[test]
        fn senses_mirror_each_other(
            range_m in 0.0..1e6_f64, bearing_rad in -3.0..3.0_f64, course_rad in -3.0..3.0_f64, dt_s in 0.0..2.0_f64,
        ) {
            let config = CircleConfig::otter();
            let motion = |side: f64| Motion::from_course(0.0, None, side * course_rad, 1.0);
            let one = config.steer(
                &mut Ilos::default(), &circle(range_m, bearing_rad, Turn::Clockwise), &motion(1.0), dt_s);
            let other = config.steer(
                &mut Ilos::default(), &circle(range_m, -bearing_rad, Turn::CounterClockwise), &motion(-1.0), dt_s);
            prop_assert!(one.course_rad.is_finite() && one.turn_rate_rad_s.is_finite());
            prop_assert!(wrap_pi(one.course_rad + other.course_rad).abs() < 1e-9);
            prop_assert!((one.turn_rate_rad_s + other.turn_rate_rad_s).abs() < 1e-9);
        }
    }
}
