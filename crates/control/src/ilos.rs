//! Integral line of sight: steer for a point ahead on the track, with an integrator for what sets the vessel
//! off it.
//!
//! χ_d = χ - atan((y + κI)/Δ), İ = Δ·y/((y + κI)² + Δ²), with y positive to starboard of the track, lookahead
//! Δ and gain κ (Børhaug, Pavlov & Pettersen, "Integral LOS control for path following of underactuated
//! marine surface vessels in the presence of constant ocean currents", CDC 2008; form of DUNE's
//! Control.Path.ILOS). Outside a corridor of width W the integrator is 0 and another law may lead back. Past
//! the end of the leg the vessel steers for the end.
//!
//! The integrator takes a fourth-order Runge-Kutta step with y held. The original leaves the time step out of
//! its inner stages; both forms are here. Unlike the original the integrator starts again on every path, which
//! avoids the overshoot behind sharp corners, and its angle is limited.

use crate::corridor::Corridor;
use crate::path::LegPosition;
use crate::range::RangeCheck;
use units::wrap_pi;

/// Largest angle that the integrator alone may ask for: tan 60°.
const LARGEST_INTEGRAL_SLOPE: f64 = 1.732;

/// Parameters of integral line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IlosConfig {
    /// Lookahead Δ (m), 1 to 50, "ILOS Lookahead Distance".
    pub lookahead_m: f64,
    /// Gain κ of the integrator (1/s), 0 to 4, "ILOS Integrator Gain".
    pub integrator_gain: f64,
    /// Integrator at the start of a path (m s), 0 to 10, "ILOS Integrator Initial Value".
    pub integrator_start: f64,
    /// Corridor within which the integrator works.
    pub corridor: Corridor,
    /// The law that leads back from outside the corridor.
    pub outside: OutsideCorridor,
    /// How the integrator steps.
    pub integrator: IntegratorForm,
    /// Whether the integrator starts again on every path.
    pub reset_on_new_path: bool,
}

/// The law outside the corridor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutsideCorridor {
    /// The same law, integrator at 0.
    Ilos,
    /// χ - atan(g·y) with the slope g of the corridor, "Out Vector Field".
    VectorField,
    /// χ - atan(y/Δ), "Out LOS".
    LineOfSight,
}

/// How the integrator steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntegratorForm {
    /// Inner stages without the time step, as DUNE computes it.
    Original,
    /// Fourth-order Runge-Kutta.
    Corrected,
}

impl IlosConfig {
    /// Tuned on Fossen's Otter with the crab angle steered by the yaw loop.
    pub fn otter() -> Self {
        Self {
            lookahead_m: 7.0,
            integrator_gain: 0.1,
            integrator_start: 0.0,
            corridor: Corridor { width_m: 5.0, entry_angle_rad: 45_f64.to_radians() },
            outside: OutsideCorridor::Ilos,
            integrator: IntegratorForm::Corrected,
            reset_on_new_path: true,
        }
    }

    /// The thesis' parameters (N. Lauvås, NTNU 2020), integrator kept from leg to leg.
    pub fn thesis() -> Self {
        Self {
            lookahead_m: 4.0,
            integrator_gain: 0.5,
            integrator_start: 0.0,
            corridor: Corridor { width_m: 1.5, entry_angle_rad: 15_f64.to_radians() },
            outside: OutsideCorridor::VectorField,
            integrator: IntegratorForm::Original,
            reset_on_new_path: false,
        }
    }

    /// NTNU's public parameters (dune-otter-public, ILOSOtter).
    pub fn ntnu() -> Self {
        Self {
            lookahead_m: 10.0,
            corridor: Corridor { width_m: 3.0, entry_angle_rad: 15_f64.to_radians() },
            reset_on_new_path: true,
            ..Self::thesis()
        }
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.number("lookahead", "m", self.lookahead_m, 1.0..=50.0);
        check.number("integrator_gain", "1/s", self.integrator_gain, 0.0..=4.0);
        check.number("integrator_start", "m s", self.integrator_start, 0.0..=10.0);
        check.within("corridor", |check| self.corridor.check(check));
    }
}

/// The integrator.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Ilos {
    integral: f64,
}

impl Ilos {
    /// At the start of a path.
    pub(crate) fn starting(config: &IlosConfig) -> Self {
        Self { integral: config.integrator_start }
    }

    /// The integrator's value (m s).
    pub(crate) fn integral(self) -> f64 {
        self.integral
    }

    /// Desired course (rad) on a leg, `dt_s` after the step before.
    pub(crate) fn course_rad(&mut self, config: &IlosConfig, leg: &LegPosition, dt_s: f64) -> f64 {
        let y = leg.cross_m;
        let lookahead_m = config.lookahead_m;
        let outside = y.abs() > config.corridor.width_m;
        if outside {
            self.integral = 0.0;
        } else {
            self.integrate(lookahead_m, config.integrator_gain, config.integrator, y, dt_s);
        }
        if leg.along_m > leg.length_m {
            return leg.end_bearing_rad;
        }
        let angle = match config.outside {
            OutsideCorridor::VectorField if outside => (config.corridor.slope_per_m() * y).atan(),
            OutsideCorridor::LineOfSight if outside => (y / lookahead_m).atan(),
            _ => ((y + config.integrator_gain * self.integral) / lookahead_m).atan(),
        };
        wrap_pi(leg.bearing_rad - angle)
    }

    /// Forgets what was integrated.
    pub(crate) fn clear(&mut self) {
        self.integral = 0.0;
    }

    /// One step of the integrator for an error `y` (m).
    pub(crate) fn integrate(&mut self, lookahead_m: f64, gain: f64, form: IntegratorForm, y: f64, dt_s: f64) {
        let rate = |ahead: f64| {
            let offset = y + gain * (self.integral + ahead);
            lookahead_m * y / (offset * offset + lookahead_m * lookahead_m)
        };
        let stage_s = match form {
            IntegratorForm::Original => 1.0,
            IntegratorForm::Corrected => dt_s,
        };
        let k1 = rate(0.0);
        let k2 = rate(stage_s * k1 / 2.0);
        let k3 = rate(stage_s * k2 / 2.0);
        let k4 = rate(stage_s * k3);
        let grown = self.integral + dt_s * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
        let limit = if gain > 0.0 { LARGEST_INTEGRAL_SLOPE * lookahead_m / gain } else { f64::MAX };
        self.integral = grown.clamp(-limit, limit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn leg(cross_m: f64, bearing_rad: f64) -> LegPosition {
        LegPosition { along_m: 10.0, cross_m, length_m: 500.0, bearing_rad, end_bearing_rad: 2.0 }
    }

    #[test]
    fn reproduces_the_recorded_steps() {
        let Some(path) = testkit::shared("data/onboard/ilos_vectors.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut rows = 0;
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let n = |i: usize| fields[i].parse::<f64>().unwrap();
            let config = IlosConfig {
                lookahead_m: n(1),
                integrator_gain: n(2),
                corridor: Corridor { width_m: n(3), entry_angle_rad: n(4).to_radians() },
                outside: match (fields[5], fields[6]) {
                    ("1", "0") => OutsideCorridor::VectorField,
                    ("0", "1") => OutsideCorridor::LineOfSight,
                    _ => OutsideCorridor::Ilos,
                },
                ..IlosConfig::thesis()
            };
            // The file holds the original's steps; a true Runge-Kutta step differs by dt times a change of the
            // rate, below 1e-3 here.
            for (integrator, integral_tolerance, course_tolerance) in
                [(IntegratorForm::Original, 2e-8, 1e-6), (IntegratorForm::Corrected, 1e-3, 1e-4)]
            {
                let config = IlosConfig { integrator, ..config };
                let mut ilos = Ilos { integral: n(10) };
                let course = ilos.course_rad(&config, &leg(n(9), n(8)), n(11));
                assert!((ilos.integral() - n(13)).abs() < integral_tolerance, "{line}: {ilos:?}");
                assert!(wrap_pi(course - n(12)).abs() < course_tolerance, "{line}: {course}");
            }
            rows += 1;
        }
        assert_eq!(rows, 100);
    }

    #[test]
    fn corrected_step_converges_to_the_integral() {
        // One long step against a thousand short ones.
        let integrate = |form, steps: u32| {
            let mut ilos = Ilos { integral: 1.0 };
            for _ in 0..steps {
                ilos.integrate(4.0, 0.5, form, 1.2, 2.0 / f64::from(steps));
            }
            ilos.integral()
        };
        let exact = integrate(IntegratorForm::Corrected, 1000);
        assert!((integrate(IntegratorForm::Corrected, 1) - exact).abs() < 1e-5);
        assert!((integrate(IntegratorForm::Original, 1000) - exact).abs() > 1e-3);
    }

    #[test]
    fn steers_for_the_end_once_past_it() {
        let mut ilos = Ilos::default();
        let past = LegPosition { along_m: 501.0, ..leg(1.0, 0.0) };
        assert!((ilos.course_rad(&IlosConfig::otter(), &past, 0.1) - 2.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn course_is_a_number_turned_towards_the_track(
            y in any::<f64>(), integral in -50.0..50.0_f64, dt_s in 0.0..2.0_f64, bearing_rad in -3.1..3.1_f64,
        ) {
            for config in [IlosConfig::otter(), IlosConfig::thesis(), IlosConfig::ntnu()] {
                let mut one = Ilos { integral };
                let mut other = Ilos { integral: -integral };
                let a = wrap_pi(one.course_rad(&config, &leg(y, bearing_rad), dt_s) - bearing_rad);
                let b = wrap_pi(other.course_rad(&config, &leg(-y, bearing_rad), dt_s) - bearing_rad);
                prop_assert!(a.is_finite() && a.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9);
                prop_assert!((a + b).abs() < 1e-9, "starboard and port alike");
                prop_assert!(one.integral().is_finite());
            }
        }
    }
}
