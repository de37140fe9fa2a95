//! The yaw half: desired heading or course to differential effort, and whether the boat may go ahead.

use super::config::{Damping, YawConfig};
use crate::crab::CrabFilter;
use crate::motion::Motion;
use crate::pid::{Pid, PidTerms, Saturation};
use units::wrap_pi;

/// The setpoint of the yaw loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum YawTarget {
    /// Where the bow points (rad).
    Heading(f64),
    /// Where the boat goes over ground.
    Course {
        /// The course (rad).
        course_rad: f64,
        /// How fast that course turns, positive to starboard (rad/s); 0 on straight legs.
        turn_rate_rad_s: f64,
    },
}

impl YawTarget {
    pub(super) fn is_finite(self) -> bool {
        match self {
            Self::Heading(rad) => rad.is_finite(),
            Self::Course { course_rad, turn_rate_rad_s } => {
                course_rad.is_finite() && turn_rate_rad_s.is_finite()
            }
        }
    }
}

/// Memory of the yaw loop.
#[derive(Debug, Clone)]
pub(super) struct YawLoop {
    pid: Pid,
    crab: CrabFilter,
    may_go_ahead: bool,
}

/// The loop's output in one step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct YawStep {
    pub(super) differential: f64,
    pub(super) may_go_ahead: bool,
    pub(super) error_rad: f64,
    pub(super) crab_rad: f64,
    pub(super) terms: PidTerms,
}

impl YawLoop {
    pub(super) fn new(config: &YawConfig) -> Self {
        Self { pid: Pid::new(config.pid), crab: CrabFilter::default(), may_go_ahead: false }
    }

    pub(super) fn reconfigure(&mut self, config: &YawConfig) {
        self.pid.reconfigure(config.pid);
    }

    /// Forgets everything but the crab angle, which belongs to the water and not to the loop.
    pub(super) fn restart(&mut self) {
        self.pid.reset();
        self.may_go_ahead = false;
    }

    /// Reports that the motors were saturated.
    pub(super) fn saturated(&mut self, saturation: Saturation) {
        self.pid.saturated(saturation);
    }

    pub(super) fn update(
        &mut self,
        config: &YawConfig,
        target: Option<YawTarget>,
        motion: &Motion,
        dt_s: f64,
    ) -> YawStep {
        let crab_rad = self.crab.update(config.course_tracking, motion, dt_s);
        let (heading_rad, turn_rate_rad_s) = match target {
            Some(YawTarget::Heading(heading_rad)) => (heading_rad, 0.0),
            Some(YawTarget::Course { course_rad, turn_rate_rad_s }) => {
                (course_rad - crab_rad, turn_rate_rad_s)
            }
            None => {
                // Nothing to hold: no turning effort, and nothing in the way of going ahead.
                self.pid.reset();
                self.may_go_ahead = true;
                return YawStep { may_go_ahead: true, crab_rad, ..YawStep::default() };
            }
        };
        let error_rad = wrap_pi(heading_rad - motion.heading_rad);
        self.pid.reconfigure(config.pid.scaled(stiffness(config, motion)));
        let mut terms = match (config.damping, motion.yaw_rate_rad_s) {
            (Damping::MeasuredRate, Some(yaw_rate_rad_s)) => {
                self.pid.update_with_rate(error_rad, turn_rate_rad_s - yaw_rate_rad_s, dt_s).1
            }
            _ => self.pid.update(error_rad, dt_s).1,
        };
        terms.feed_forward = config.rate_feed_forward * turn_rate_rad_s;
        let gate_rad = config.max_error_to_thrust_rad;
        if error_rad.abs() > 1.2 * gate_rad {
            self.may_go_ahead = false;
        } else if error_rad.abs() < gate_rad {
            self.may_go_ahead = true;
        }
        let most =
            if self.may_go_ahead { config.max_differential } else { config.max_differential_on_the_spot };
        let wanted = terms.sum();
        let differential = wanted.clamp(-most, most);
        self.pid.saturated(Saturation::between(wanted, differential));
        YawStep { differential, may_go_ahead: self.may_go_ahead, error_rad, crab_rad, terms }
    }
}

/// How much stiffer the loop is at the vessel's speed than at rest.
fn stiffness(config: &YawConfig, motion: &Motion) -> f64 {
    config.stiffening_speed_mps.map_or(1.0, |doubling_mps| {
        // Beyond three times that speed nothing is tuned; a wild speed must not make wild gains.
        let relative = (motion.surge_mps() / doubling_mps).clamp(0.0, 3.0);
        1.0 + relative * relative
    })
}
