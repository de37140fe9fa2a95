//! Parameters of the course and speed controller, their ranges, and the sets in use.
//!
//! Two units are set by [`Drive`]: the *demand* of the speed loop (rpm or newtons) and the *effort* shared
//! between the motors (actuation or newtons of the pair). Names in quotes are the DUNE parameters.

use crate::crab::CourseTracking;
use crate::pid::{ErrorKind, FirstDerivative, Integration, PidConfig};
use crate::range::{InvalidConfig, RangeCheck};
use crate::speed_table::SpeedTable;
use crate::thrust::{Sharing, ThrustMap};

/// All parameters of [`CourseSpeed`](super::CourseSpeed). The default is [`CourseSpeedConfig::fossen_force`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CourseSpeedConfig {
    /// Heading and course.
    pub yaw: YawConfig,
    /// Speed.
    pub speed: SpeedConfig,
    /// The actuation of the loops.
    pub drive: Drive,
    /// The output to the motors.
    pub output: OutputConfig,
}

/// Heading and course loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YawConfig {
    /// Gains from heading error (rad) to differential effort, "Yaw PID Gains".
    pub pid: PidConfig,
    /// Speed (m/s) at which the gains are doubled: they grow with 1 + (surge / this)², 0.5 to 100; `None` =
    /// constant, as the originals have them. The moment that turns a hull across its own drift grows alike.
    pub stiffening_speed_mps: Option<f64>,
    /// Differential effort per rad/s of the desired rate of turn, 0 to 1e4: what a steady turn needs.
    pub rate_feed_forward: f64,
    /// Where the derivative comes from.
    pub damping: Damping,
    /// How a desired course is steered.
    pub course_tracking: CourseTracking,
    /// Largest differential effort while going ahead, 0 to 1e4, "Maximum Thrust Differential Actuation".
    pub max_differential: f64,
    /// Largest differential effort while turning on the spot, 0 to 1e4; the original knows no limit there.
    pub max_differential_on_the_spot: f64,
    /// No thrust ahead beyond 1.2 times this heading error, again below it (rad), 0.05 to π,
    /// "Maximum Heading Error to Thrust".
    pub max_error_to_thrust_rad: f64,
}

/// Where the yaw loop's derivative comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damping {
    /// Difference of successive heading errors, as the originals do.
    Differenced,
    /// The measured rate of turn, so that a new desired heading gives no kick; the difference where no rate
    /// is measured.
    MeasuredRate,
}

/// Speed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedConfig {
    /// Gains from speed error (m/s) to demand, "MPS PID Gains" and "MPS Integral Limit".
    pub pid: PidConfig,
    /// Demand expected for a speed.
    pub feed_forward: FeedForward,
    /// Least demand while a speed is held, -1e4 to 1e4, "Minimum RPM Limit".
    pub min_demand: f64,
    /// Largest demand, 1 to 1e4, "Maximum RPM Limit".
    pub max_demand: f64,
    /// Largest change of the demand per second, 1 to 1e5, "Maximum RPM Acceleration".
    pub max_demand_rate_per_s: f64,
    /// Desired speeds below this stop the motors (m/s), 0 to 1; 0.1 in DUNE.
    pub stop_below_mps: f64,
}

/// Demand expected for a desired speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FeedForward {
    /// Demand per m/s, 0 to 1e4, "MPS Feedforward Gain".
    Gain(f64),
    /// Rpm by table; only with [`Drive::Rpm`].
    Table(SpeedTable),
}

/// The actuation of the loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Demand is rpm, effort is actuation (DUNE HeadingAndSpeed).
    Rpm {
        /// Rpm at actuation 1, 100 to 1e4, "RPMs at Maximum Thrust".
        rpm_at_max_thrust: f64,
        /// Where the rpm loop runs.
        governor: Governor,
    },
    /// Demand and effort are newtons of the pair (NTNU HeadingAndSpeedForce).
    Force {
        /// Force against actuation.
        map: ThrustMap,
        /// Rpm at actuation 1, 100 to 1e4, for desired speeds in rpm.
        rpm_at_max_thrust: f64,
    },
}

/// Where the rpm loop runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Governor {
    /// The motors themselves: actuation = rpm / rpm at maximum thrust, "Hardware RPMs Control".
    Hardware,
    /// A loop here, from the mean of the measured rpm.
    Software {
        /// Gains from rpm error to actuation, "RPMs PID Gains".
        pid: PidConfig,
        /// Actuation per desired rpm, 0 to 1, "RPMs Feedforward Gain".
        feed_forward: f64,
    },
}

/// The output to the motors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputConfig {
    /// Largest magnitude of actuation, 0.01 to 1, "Maximum Thrust Actuation".
    pub max_actuation: f64,
    /// Which effort yields at a limit, "Share Saturation".
    pub sharing: Sharing,
    /// Largest growth of an actuation's magnitude per second, 0.01 to 100; `None` = free,
    /// "Ramp Actuation Limit".
    pub ramp_per_s: Option<f64>,
    /// Time over which the motors move from where they are at enabling to the loops' output (s), 0 to 10.
    pub fade_s: f64,
    /// A longer pause between two updates starts the loops again from stopped motors (s), 0.1 to 10.
    pub max_gap_s: f64,
}

impl Default for CourseSpeedConfig {
    fn default() -> Self {
        Self::fossen_force()
    }
}

impl CourseSpeedConfig {
    /// Force variant tuned on Fossen's Otter for 1 to 10 updates a second and 0.5 to 2.5 m/s.
    ///
    /// The feed-forward is the hull's damping, 77.55 N per m/s. The yaw gains are stiff and stiffen with speed:
    /// the moment that turns a hull across its own drift (77 N m per m²/s²) makes softer ones meander along a
    /// leg, worse the faster it goes. Stiffer ones swing both motors for ever from 2.5 m/s on, by the delay of a
    /// compass of 5 Hz; these keep them still up to full speed with 0 to 45 kg aboard.
    pub fn fossen_force() -> Self {
        Self {
            yaw: YawConfig {
                pid: PidConfig { integral_limit: Some(40.0), ..angle(225.0, 10.0, 180.0) },
                stiffening_speed_mps: Some(2.5),
                rate_feed_forward: 150.0,
                damping: Damping::MeasuredRate,
                course_tracking: CourseTracking::Filtered { min_speed_mps: 0.4, time_constant_s: 3.0 },
                max_differential: 120.0,
                max_differential_on_the_spot: 130.0,
                max_error_to_thrust_rad: 45_f64.to_radians(),
            },
            speed: SpeedConfig {
                pid: PidConfig { integral_limit: Some(100.0), ..PidConfig::gains(80.0, 40.0, 0.0) },
                feed_forward: FeedForward::Gain(77.55),
                min_demand: -30.0,
                max_demand: 239.364,
                max_demand_rate_per_s: 150.0,
                stop_below_mps: 0.1,
            },
            drive: Drive::Force { map: ThrustMap::FOSSEN_OTTER, rpm_at_max_thrust: 992.47 },
            output: OutputConfig::STEADY,
        }
    }

    /// Rpm variant tuned on Fossen's Otter, with the speed table as feed-forward.
    ///
    /// The yaw gains stiffen less with speed than those of the force variant: the force of a propeller grows with
    /// the square of its speed, so a difference in rpm turns the more the faster both run.
    pub fn fossen_rpm() -> Self {
        Self {
            yaw: YawConfig {
                pid: PidConfig { integral_limit: Some(0.1), ..angle(1.0, 0.04, 0.7) },
                stiffening_speed_mps: Some(6.0),
                rate_feed_forward: 0.8,
                max_differential: 0.45,
                max_differential_on_the_spot: 0.9,
                ..Self::fossen_force().yaw
            },
            speed: SpeedConfig {
                pid: PidConfig { integral_limit: Some(300.0), ..PidConfig::gains(180.0, 100.0, 0.0) },
                feed_forward: FeedForward::Table(SpeedTable::FOSSEN_OTTER),
                min_demand: 0.0,
                max_demand: 992.47,
                max_demand_rate_per_s: 500.0,
                stop_below_mps: 0.1,
            },
            drive: Drive::Rpm { rpm_at_max_thrust: 992.47, governor: Governor::Hardware },
            output: OutputConfig::STEADY,
        }
    }

    /// The thesis' parameters (N. Lauvås, NTNU 2020, basic.ini). They cannot reach 2 m/s: feed-forward and
    /// integral limit together ask for 100·v + 200 rpm at most.
    pub fn thesis() -> Self {
        Self {
            yaw: YawConfig {
                pid: original_angle(1.5, 0.0, 0.0, Integration::AfterOutput),
                stiffening_speed_mps: None,
                rate_feed_forward: 0.0,
                damping: Damping::Differenced,
                course_tracking: CourseTracking::AsHeading,
                max_differential: 0.4,
                max_differential_on_the_spot: 1.0,
                max_error_to_thrust_rad: 30_f64.to_radians(),
            },
            speed: SpeedConfig {
                pid: PidConfig {
                    integral_limit: Some(200.0),
                    ..original(1.0, 25.0, 0.0, Integration::AfterOutput)
                },
                feed_forward: FeedForward::Gain(100.0),
                min_demand: 62.0,
                max_demand: 1100.0,
                max_demand_rate_per_s: 62.0,
                stop_below_mps: 0.1,
            },
            drive: Drive::Rpm { rpm_at_max_thrust: 1100.0, governor: Governor::Hardware },
            output: OutputConfig::STEADY,
        }
    }

    /// NTNU's public parameters of the rpm variant (dune-otter-public, simulation).
    pub fn ntnu_rpm() -> Self {
        let thesis = Self::thesis();
        Self {
            yaw: YawConfig {
                pid: original_angle(3.0, 0.0, 0.0, Integration::BeforeOutput),
                max_differential: 1.0,
                ..thesis.yaw
            },
            speed: SpeedConfig {
                pid: PidConfig {
                    integral_limit: Some(300.0),
                    ..original(450.0, 25.0, 0.0, Integration::BeforeOutput)
                },
                feed_forward: FeedForward::Gain(0.0),
                min_demand: 0.0,
                ..thesis.speed
            },
            output: OutputConfig { sharing: Sharing::Independent, ..thesis.output },
            ..thesis
        }
    }

    /// The parameters of LSTS DUNE's own otter.ini.
    pub fn dune_rpm() -> Self {
        let thesis = Self::thesis();
        Self {
            yaw: YawConfig {
                pid: original_angle(1.9, 0.0, 0.85, Integration::AfterOutput),
                max_differential: 0.35,
                ..thesis.yaw
            },
            speed: SpeedConfig {
                pid: PidConfig {
                    integral_limit: Some(400.0),
                    ..original(1.25, 1.0, 0.5, Integration::AfterOutput)
                },
                feed_forward: FeedForward::Gain(120.0),
                min_demand: 250.0,
                max_demand: 1200.0,
                max_demand_rate_per_s: 300.0,
                stop_below_mps: 0.1,
            },
            drive: Drive::Rpm { rpm_at_max_thrust: 1200.0, governor: Governor::Hardware },
            ..thesis
        }
    }

    /// NTNU's public parameters of the force variant, used on the boats (dune-otter-public).
    pub fn ntnu_force() -> Self {
        Self {
            yaw: YawConfig {
                pid: original_angle(60.0, 0.0, 0.0, Integration::BeforeOutput),
                stiffening_speed_mps: None,
                rate_feed_forward: 0.0,
                damping: Damping::Differenced,
                course_tracking: CourseTracking::AsHeading,
                max_differential: 239.364,
                max_differential_on_the_spot: 239.364,
                max_error_to_thrust_rad: 30_f64.to_radians(),
            },
            speed: SpeedConfig {
                pid: PidConfig {
                    integral_limit: Some(240.0),
                    ..original(57.0, 2.83, 50.0, Integration::BeforeOutput)
                },
                feed_forward: FeedForward::Gain(0.0),
                min_demand: -30.0,
                max_demand: 239.364,
                max_demand_rate_per_s: 1e5,
                stop_below_mps: 0.1,
            },
            drive: Drive::Force { map: ThrustMap::NTNU_OTTER, rpm_at_max_thrust: 1100.0 },
            output: OutputConfig { max_gap_s: 0.5, ..OutputConfig::STEADY },
        }
    }

    /// The rpm loop of the thesis' files, "RPMs PID Gains", for motors that do not hold their rpm.
    pub fn thesis_governor() -> Governor {
        Governor::Software {
            pid: original(0.2e-3, 0.21e-3, 29e-6, Integration::AfterOutput),
            feed_forward: 0.46e-3,
        }
    }

    /// Whether every value is within its range.
    ///
    /// # Errors
    /// Names every value that is not.
    pub fn validate(&self) -> Result<(), InvalidConfig> {
        let mut check = RangeCheck::default();
        check.within("yaw", |check| self.yaw.check(check));
        check.within("speed", |check| self.speed.check(check));
        check.within("drive", |check| self.drive.check(check));
        check.within("output", |check| self.output.check(check));
        if let (FeedForward::Table(table), Drive::Force { .. }) = (&self.speed.feed_forward, &self.drive) {
            // A table answers rpm, which is not a force.
            check.within("speed", |check| {
                check.number("feed_forward_table", "rpm", table.rpm_for_percent(100.0), 0.0..=0.0);
            });
        }
        check.finish()
    }
}

impl OutputConfig {
    /// All of the motors' range, turning first, no ramp; a short fade at enabling.
    pub const STEADY: Self = Self {
        max_actuation: 1.0,
        sharing: Sharing::TurnFirst,
        ramp_per_s: None,
        fade_s: 0.5,
        max_gap_s: 2.0,
    };

    fn check(&self, check: &mut RangeCheck) {
        check.number("max_actuation", "1", self.max_actuation, 0.01..=1.0);
        check.optional("ramp", "1/s", self.ramp_per_s, 0.01..=100.0);
        check.number("fade", "s", self.fade_s, 0.0..=10.0);
        check.number("max_gap", "s", self.max_gap_s, 0.1..=10.0);
    }
}

impl YawConfig {
    fn check(&self, check: &mut RangeCheck) {
        check.within("pid", |check| self.pid.check(check));
        check.within("course_tracking", |check| self.course_tracking.check(check));
        check.optional("stiffening_speed", "m/s", self.stiffening_speed_mps, 0.5..=100.0);
        check.number("rate_feed_forward", "effort s/rad", self.rate_feed_forward, 0.0..=1e4);
        check.number("max_differential", "effort", self.max_differential, 0.0..=1e4);
        check.number("max_differential_on_the_spot", "effort", self.max_differential_on_the_spot, 0.0..=1e4);
        check.number("max_error_to_thrust", "rad", self.max_error_to_thrust_rad, 0.05..=std::f64::consts::PI);
    }
}

impl SpeedConfig {
    fn check(&self, check: &mut RangeCheck) {
        check.within("pid", |check| self.pid.check(check));
        match &self.feed_forward {
            FeedForward::Gain(gain) => check.number("feed_forward", "demand s/m", *gain, 0.0..=1e4),
            FeedForward::Table(table) => check.within("feed_forward", |check| table.check(check)),
        }
        check.number("max_demand", "demand", self.max_demand, 1.0..=1e4);
        check.number("min_demand", "demand", self.min_demand, -1e4..=self.max_demand.clamp(1.0, 1e4));
        check.number("max_demand_rate", "demand/s", self.max_demand_rate_per_s, 1.0..=1e5);
        check.number("stop_below", "m/s", self.stop_below_mps, 0.0..=1.0);
    }
}

impl Drive {
    fn check(&self, check: &mut RangeCheck) {
        match self {
            Self::Rpm { rpm_at_max_thrust, governor } => {
                check.number("rpm_at_max_thrust", "rpm", *rpm_at_max_thrust, 100.0..=1e4);
                if let Governor::Software { pid, feed_forward } = governor {
                    check.within("governor.pid", |check| pid.check(check));
                    check.number("governor.feed_forward", "1/rpm", *feed_forward, 0.0..=1.0);
                }
            }
            Self::Force { map, rpm_at_max_thrust } => {
                check.within("map", |check| map.check(check));
                check.number("rpm_at_max_thrust", "rpm", *rpm_at_max_thrust, 100.0..=1e4);
            }
        }
    }
}

fn angle(kp: f64, ki: f64, kd: f64) -> PidConfig {
    PidConfig { error: ErrorKind::Angle, ..PidConfig::gains(kp, ki, kd) }
}

fn original(kp: f64, ki: f64, kd: f64, integration: Integration) -> PidConfig {
    // The first derivative stays omitted: the original's kick is a defect.
    PidConfig { integration, first_derivative: FirstDerivative::Omitted, ..PidConfig::gains(kp, ki, kd) }
}

fn original_angle(kp: f64, ki: f64, kd: f64, integration: Integration) -> PidConfig {
    PidConfig { error: ErrorKind::Angle, ..original(kp, ki, kd, integration) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_in_use_is_within_its_ranges() {
        for config in [
            CourseSpeedConfig::default(),
            CourseSpeedConfig::fossen_rpm(),
            CourseSpeedConfig::thesis(),
            CourseSpeedConfig::ntnu_rpm(),
            CourseSpeedConfig::dune_rpm(),
            CourseSpeedConfig::ntnu_force(),
        ] {
            config.validate().unwrap();
        }
        let mut governed = CourseSpeedConfig::thesis();
        governed.drive =
            Drive::Rpm { rpm_at_max_thrust: 1100.0, governor: CourseSpeedConfig::thesis_governor() };
        governed.validate().unwrap();
    }

    #[test]
    fn all_mistakes_are_reported_at_once() {
        let mut config = CourseSpeedConfig::thesis();
        config.yaw.pid.kp = -1.0;
        config.output.max_actuation = f64::NAN;
        config.speed.min_demand = 2000.0;
        let problems = config.validate().unwrap_err().problems;
        let names: Vec<_> = problems.iter().map(|problem| problem.parameter.as_str()).collect();
        assert_eq!(names, ["yaw.pid.kp", "speed.min_demand", "output.max_actuation"]);
    }

    #[test]
    fn a_table_of_rpm_cannot_feed_a_force() {
        let mut config = CourseSpeedConfig::fossen_force();
        config.speed.feed_forward = FeedForward::Table(SpeedTable::FOSSEN_OTTER);
        assert!(config.validate().is_err());
    }
}
