//! A proportional, integral and derivative controller in the two forms in use on the vessels.
//!
//! output = Kp·e + Kd·ė + I, where I accumulates Ki·e·dt and already includes Ki (so that Ki may change
//! while running without a bump). The forms differ in when I grows:
//! - [`Integration::AfterOutput`]: the output uses the I of the step before (LSTS DUNE).
//! - [`Integration::BeforeOutput`]: I grows first (NTNU dune-otter-public).
//!
//! Beyond the originals: the derivative of an angle comes from the wrapped difference, so it does not jump
//! by 2π/dt where the error wraps; the first step after a reset may leave the derivative out; I stands still
//! while growing would only deepen a saturation (conditional integration; Åström & Hägglund, "Advanced PID
//! Control", ISA 2006, section 3.5).
//!
//! Units: the error's unit is the caller's; Kp is output per error, Ki output per error and second, Kd output
//! per error per second.

use crate::range::RangeCheck;
use units::wrap_pi;

/// Errors, rates and terms are cut here, so that no finite input overflows to infinity.
const MAGNITUDE_LIMIT: f64 = 1e12;
/// Largest gain allowed in a configuration.
const GAIN_LIMIT: f64 = 1e6;

/// When the integral grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Integration {
    /// After the output is formed: Ki acts one step late (LSTS DUNE).
    AfterOutput,
    /// Before the output is formed (NTNU).
    #[default]
    BeforeOutput,
}

/// How the difference of two errors is formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ErrorKind {
    /// Plain difference.
    #[default]
    Linear,
    /// Radians: the difference is wrapped to (-π, π].
    Angle,
}

/// The derivative's behaviour on the first step after a reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FirstDerivative {
    /// Nothing: no kick.
    #[default]
    Omitted,
    /// As if the error before had been 0 (LSTS DUNE and NTNU).
    FromZero,
}

/// Gains and limits of a [`Pid`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PidConfig {
    /// Proportional gain (output per error), 0 to 1e6.
    pub kp: f64,
    /// Integral gain (output per error and second), 0 to 1e6.
    pub ki: f64,
    /// Derivative gain (output per error per second), 0 to 1e6.
    pub kd: f64,
    /// Largest magnitude of the integral (output units); `None` = unlimited.
    pub integral_limit: Option<f64>,
    /// Largest magnitude of the output; `None` = unlimited.
    pub output_limit: Option<f64>,
    /// When the integral grows.
    pub integration: Integration,
    /// How errors are subtracted.
    pub error: ErrorKind,
    /// The derivative's behaviour on the first step.
    pub first_derivative: FirstDerivative,
}

impl PidConfig {
    /// The three gains, everything else at its default.
    pub const fn gains(kp: f64, ki: f64, kd: f64) -> Self {
        Self {
            kp,
            ki,
            kd,
            integral_limit: None,
            output_limit: None,
            integration: Integration::BeforeOutput,
            error: ErrorKind::Linear,
            first_derivative: FirstDerivative::Omitted,
        }
    }

    /// All three gains times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { kp: self.kp * factor, ki: self.ki * factor, kd: self.kd * factor, ..self }
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.number("kp", "output/error", self.kp, 0.0..=GAIN_LIMIT);
        check.number("ki", "output/(error s)", self.ki, 0.0..=GAIN_LIMIT);
        check.number("kd", "output s/error", self.kd, 0.0..=GAIN_LIMIT);
        check.optional("integral_limit", "output", self.integral_limit, 0.0..=GAIN_LIMIT);
        check.optional("output_limit", "output", self.output_limit, 0.0..=GAIN_LIMIT);
    }
}

/// A limit that the output, or what is made of it, ran into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Saturation {
    /// None.
    #[default]
    Free,
    /// More output has no effect.
    High,
    /// Less output has no effect.
    Low,
}

impl Saturation {
    /// Which limit turned `wanted` into `got`.
    pub fn between(wanted: f64, got: f64) -> Self {
        if wanted > got + 1e-9 {
            Self::High
        } else if wanted < got - 1e-9 {
            Self::Low
        } else {
            Self::Free
        }
    }

    /// `self`, or `other` where `self` is free.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if self == Self::Free { other } else { self }
    }

    fn blocks(self, growth: f64) -> bool {
        match self {
            Self::Free => false,
            Self::High => growth > 0.0,
            Self::Low => growth < 0.0,
        }
    }
}

/// The terms of an output, before its limit (all in output units).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PidTerms {
    /// Kp·e.
    pub proportional: f64,
    /// I as used in this output.
    pub integral: f64,
    /// Kd·ė.
    pub derivative: f64,
    /// Added by the caller; 0 from [`Pid`].
    pub feed_forward: f64,
}

impl PidTerms {
    /// The sum of all terms.
    pub fn sum(&self) -> f64 {
        self.proportional + self.derivative + self.integral + self.feed_forward
    }
}

/// The controller: gains and memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Pid {
    config: PidConfig,
    integral: f64,
    previous_error: Option<f64>,
    saturation: Saturation,
}

impl Pid {
    /// A controller at rest.
    pub fn new(config: PidConfig) -> Self {
        Self { config, integral: 0.0, previous_error: None, saturation: Saturation::Free }
    }

    /// New gains and limits; the memory stays, so the output does not jump by Ki.
    pub fn reconfigure(&mut self, config: PidConfig) {
        self.config = config;
        self.integral = limit(self.integral, config.integral_limit);
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        *self = Self::new(self.config);
    }

    /// Starts so that the next output for `error` is `output`, as far as the integral may make it so.
    /// Without an integral gain nothing could take the offset away again, so the integral stays 0.
    pub fn start_at(&mut self, output: f64, error: f64) {
        self.reset();
        let error = bounded(error);
        self.previous_error = Some(error);
        if self.config.ki > 0.0 {
            let wanted = bounded(output) - bounded(self.config.kp * error);
            self.integral = limit(wanted, self.config.integral_limit);
        }
    }

    /// Reports which limit the last output was clipped at; it holds for the next step only.
    pub fn saturated(&mut self, saturation: Saturation) {
        self.saturation = saturation;
    }

    /// The integral, Ki included (output units).
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// One step of `dt_s` seconds: the limited output and its parts. Without a positive `dt_s` neither
    /// integral nor derivative act. An error that is not a number counts as 0.
    pub fn update(&mut self, error: f64, dt_s: f64) -> (f64, PidTerms) {
        let error = bounded(error);
        let previous = match self.config.first_derivative {
            FirstDerivative::Omitted => self.previous_error,
            FirstDerivative::FromZero => Some(self.previous_error.unwrap_or(0.0)),
        };
        let rate = match previous {
            Some(previous) if dt_s > 0.0 => self.difference(error, previous) / dt_s,
            _ => 0.0,
        };
        self.update_with_rate(error, rate, dt_s)
    }

    /// The same with the rate of the error (per second) measured rather than differenced.
    pub fn update_with_rate(&mut self, error: f64, error_rate: f64, dt_s: f64) -> (f64, PidTerms) {
        let error = bounded(error);
        self.previous_error = Some(error);
        let mut terms = PidTerms {
            proportional: bounded(self.config.kp * error),
            integral: self.integral,
            derivative: bounded(self.config.kd * bounded(error_rate)),
            feed_forward: 0.0,
        };
        let step_s = if dt_s > 0.0 { dt_s } else { 0.0 };
        let growth = bounded(self.config.ki * error * step_s);
        let grown = limit(bounded(self.integral + growth), self.config.integral_limit);
        let early = self.config.integration == Integration::BeforeOutput;
        if early && !self.saturation.blocks(growth) {
            terms.integral = grown;
        }
        let own = Saturation::between(terms.sum(), limit(terms.sum(), self.config.output_limit));
        if own.blocks(growth) {
            terms.integral = self.integral;
        } else if !self.saturation.blocks(growth) {
            self.integral = grown;
        }
        self.saturation = Saturation::Free;
        (limit(terms.sum(), self.config.output_limit), terms)
    }

    fn difference(&self, error: f64, previous: f64) -> f64 {
        match self.config.error {
            ErrorKind::Linear => error - previous,
            ErrorKind::Angle => wrap_pi(error - previous),
        }
    }
}

fn bounded(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-MAGNITUDE_LIMIT, MAGNITUDE_LIMIT) }
}

fn limit(value: f64, magnitude: Option<f64>) -> f64 {
    magnitude.map_or(value, |magnitude| value.clamp(-magnitude, magnitude))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn reproduces_the_recorded_steps_of_both_forms() {
        let Some(path) = testkit::shared("data/onboard/pid_vectors.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut case = String::new();
        let (mut lsts, mut ntnu) = (Pid::new(PidConfig::default()), Pid::new(PidConfig::default()));
        let mut rows = 0;
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let n = |i: usize| fields[i].parse::<f64>().unwrap();
            if fields[0] != case {
                fields[0].clone_into(&mut case);
                let config = PidConfig {
                    integral_limit: (n(4) > 0.0).then(|| n(4)),
                    first_derivative: FirstDerivative::FromZero,
                    ..PidConfig::gains(n(1), n(2), n(3))
                };
                lsts = Pid::new(PidConfig { integration: Integration::AfterOutput, ..config });
                ntnu = Pid::new(PidConfig { integration: Integration::BeforeOutput, ..config });
            }
            for (pid, out, integral) in [(&mut lsts, n(8), n(9)), (&mut ntnu, n(10), n(11))] {
                let (got, _) = pid.update(n(7), n(6));
                // The file rounds to 1e-6.
                assert!((got - out).abs() < 1e-6, "{line}: output {got}");
                assert!((pid.integral() - integral).abs() < 1e-6, "{line}: integral {}", pid.integral());
            }
            rows += 1;
        }
        assert_eq!(rows, 60);
    }

    #[test]
    fn derivative_does_not_jump_where_an_angle_wraps() {
        let config = PidConfig { error: ErrorKind::Angle, ..PidConfig::gains(0.0, 0.0, 1.0) };
        let mut pid = Pid::new(config);
        pid.update(PI - 0.01, 0.1);
        let (out, _) = pid.update(-PI + 0.01, 0.1);
        assert!((out - 0.2).abs() < 1e-9, "{out}");
    }

    #[test]
    fn first_step_has_no_derivative_kick() {
        let mut pid = Pid::new(PidConfig::gains(1.0, 0.0, 5.0));
        assert!((pid.update(2.0, 0.1).0 - 2.0).abs() < 1e-12);
    }

    #[test]
    fn starts_where_the_output_stands() {
        for integration in [Integration::AfterOutput, Integration::BeforeOutput] {
            let mut pid = Pid::new(PidConfig { integration, ..PidConfig::gains(3.0, 1.0, 2.0) });
            pid.start_at(0.7, 0.2);
            assert!((pid.update(0.2, 0.0).0 - 0.7).abs() < 1e-12);
        }
        let mut without_integral = Pid::new(PidConfig::gains(3.0, 0.0, 0.0));
        without_integral.start_at(0.7, 0.0);
        assert!(without_integral.update(0.0, 0.1).0.abs() < 1e-12);
    }

    #[test]
    fn integral_stands_still_while_the_output_is_limited() {
        for integration in [Integration::AfterOutput, Integration::BeforeOutput] {
            let config =
                PidConfig { output_limit: Some(1.0), integration, ..PidConfig::gains(1.0, 1.0, 0.0) };
            let mut pid = Pid::new(config);
            for _ in 0..100 {
                assert!((pid.update(5.0, 0.1).0 - 1.0).abs() < 1e-12);
            }
            assert!(pid.integral().abs() < 1e-12);
            pid.update(-0.5, 0.1);
            assert!(pid.integral() < 0.0, "it may still leave the limit");
        }
    }

    #[test]
    fn integral_stands_still_for_one_step_after_a_saturation_downstream() {
        let mut pid = Pid::new(PidConfig::gains(0.0, 1.0, 0.0));
        pid.saturated(Saturation::High);
        pid.update(1.0, 1.0);
        assert!(pid.integral().abs() < 1e-12);
        pid.update(1.0, 1.0);
        assert!((pid.integral() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn changing_the_integral_gain_causes_no_bump() {
        let mut pid = Pid::new(PidConfig::gains(0.0, 1.0, 0.0));
        pid.update(1.0, 1.0);
        pid.reconfigure(PidConfig::gains(0.0, 50.0, 0.0));
        assert!((pid.update(0.0, 1.0).0 - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn any_input_gives_a_number_within_the_limit(
            kp in 0.0..1e6_f64, ki in 0.0..1e6_f64, kd in 0.0..1e6_f64, limit in 0.0..1e3_f64,
            steps in proptest::collection::vec((any::<f64>(), any::<f64>()), 1..50),
            angle in any::<bool>(), early in any::<bool>(),
        ) {
            let mut pid = Pid::new(PidConfig {
                output_limit: Some(limit),
                error: if angle { ErrorKind::Angle } else { ErrorKind::Linear },
                integration: if early { Integration::BeforeOutput } else { Integration::AfterOutput },
                ..PidConfig::gains(kp, ki, kd)
            });
            for (error, dt_s) in steps {
                let (out, _) = pid.update(error, dt_s);
                prop_assert!(out.abs() <= limit);
                prop_assert!(pid.integral().is_finite());
            }
        }

        #[test]
        fn opposite_errors_give_opposite_outputs(
            steps in proptest::collection::vec((-3.0..3.0_f64, 0.01..1.0_f64), 1..30),
        ) {
            let config = PidConfig { output_limit: Some(2.0), ..PidConfig::gains(1.2, 0.4, 0.3) };
            let (mut one, mut other) = (Pid::new(config), Pid::new(config));
            for (error, dt_s) in steps {
                prop_assert!((one.update(error, dt_s).0 + other.update(-error, dt_s).0).abs() < 1e-12);
            }
        }
    }
}
