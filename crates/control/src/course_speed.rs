//! Heading or course, and speed, with two motors.
//!
//! After DUNE's Control.ASV.HeadingAndSpeed and NTNU's HeadingAndSpeedForce, with their defects left out: the
//! derivative of the heading error does not jump where the angle wraps, the ramp has the dimension of a rate,
//! saturation is shared alike on both sides, integrals stop at every limit on the way to the motors, and
//! enabling starts from what the motors do.
//!
//! One step: heading error → differential effort; forward gate with hysteresis; speed error → demand (rpm or
//! newtons), limited in rate and range → common effort; both shared between the motors → actuation, faded in
//! after enabling, ramped, limited. The caller stops the motors on an error and on silence.
//!
//! Units: radians clockwise from north, m/s, actuation -1 to 1; positive differential turns to starboard.

mod config;
mod speed_loop;
mod yaw_loop;

pub use config::{
    CourseSpeedConfig, Damping, Drive, FeedForward, Governor, OutputConfig, SpeedConfig, YawConfig,
};
pub use yaw_loop::YawTarget;

use crate::motion::Motion;
use crate::pid::{PidTerms, Saturation};
use crate::ramp;
use crate::range::InvalidConfig;
use crate::thrust::{MotorPair, allocate};
use speed_loop::{SpeedInput, SpeedLoop};
use thiserror::Error;
use units::{MonoTime, Speed};
use yaw_loop::YawLoop;

/// The setpoint. An absent yaw target demands no turning effort, an absent speed no thrust.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setpoint {
    /// Heading or course.
    pub yaw: Option<YawTarget>,
    /// Speed.
    pub speed: Option<Speed>,
}

/// Why there is no output. The motors are to be stopped unless the next update comes in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ControlFault {
    /// The controller is not enabled.
    #[error("the course and speed controller is not enabled")]
    Disabled,
    /// The motion or the setpoint holds a value that is not a number; the loops did not see it.
    #[error("motion or setpoint is not a number")]
    NotFinite,
}

/// The result of one update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlOutput {
    /// For the motors.
    pub motors: MotorPair,
    /// Parts of the yaw loop's output (effort).
    pub yaw: PidTerms,
    /// Parts of the speed loop's output (demand); 0 while the speed is given in rpm or percent.
    pub speed: PidTerms,
    /// Parts of the rpm loop's output (actuation); 0 without one.
    pub rpm: PidTerms,
    /// Desired minus actual heading, the crab angle taken into account (rad).
    pub heading_error_rad: f64,
    /// Filtered course minus heading (rad).
    pub crab_rad: f64,
    /// Whether the heading error allows thrust ahead.
    pub ahead: bool,
    /// Whether this update started again after a pause longer than allowed.
    pub restarted: bool,
}

/// The controller.
#[derive(Debug, Clone)]
pub struct CourseSpeed {
    config: CourseSpeedConfig,
    yaw: YawLoop,
    speed: SpeedLoop,
    active: Option<Active>,
}

#[derive(Debug, Clone, Copy)]
struct Active {
    last: Option<MonoTime>,
    /// Actuation at enabling, and how long ago that is.
    start: MotorPair,
    age_s: f64,
    motors: MotorPair,
}

impl Active {
    fn from_motors(motors: MotorPair) -> Self {
        Self { last: None, start: motors, age_s: 0.0, motors }
    }
}

impl CourseSpeed {
    /// A controller that is not enabled.
    ///
    /// # Errors
    /// When values of `config` are out of range.
    pub fn new(config: CourseSpeedConfig) -> Result<Self, InvalidConfig> {
        config.validate()?;
        let (yaw, speed) = (YawLoop::new(&config.yaw), SpeedLoop::new(&config.speed, &config.drive));
        Ok(Self { config, yaw, speed, active: None })
    }

    /// The parameters in use.
    pub fn config(&self) -> &CourseSpeedConfig {
        &self.config
    }

    /// New parameters. Integrals stay, except that another kind of [`Drive`] stops the controller.
    ///
    /// # Errors
    /// When values of `config` are out of range; the old ones then stay in use.
    pub fn reconfigure(&mut self, config: CourseSpeedConfig) -> Result<(), InvalidConfig> {
        config.validate()?;
        if std::mem::discriminant(&config.drive) == std::mem::discriminant(&self.config.drive) {
            self.yaw.reconfigure(&config.yaw);
            self.speed.reconfigure(&config.speed, &config.drive);
            self.config = config;
        } else {
            *self = Self::new(config)?;
        }
        Ok(())
    }

    /// Takes over while the motors run at `motors`; does nothing when already enabled.
    pub fn enable(&mut self, motors: MotorPair) {
        if self.active.is_none() {
            self.start_from(motors.map(
                |actuation| {
                    if actuation.is_finite() { actuation.clamp(-1.0, 1.0) } else { 0.0 }
                },
            ));
        }
    }

    /// Disables the controller. The motors must be stopped.
    pub fn disable(&mut self) {
        self.active = None;
    }

    /// Whether updates are acted upon.
    pub fn is_enabled(&self) -> bool {
        self.active.is_some()
    }

    /// One step at `now`, at every new state of the vessel. `measured_rpm` is the mean of both motors, for a
    /// [`Governor::Software`].
    ///
    /// # Errors
    /// When not enabled, or when an input is not a number.
    pub fn update(
        &mut self,
        now: MonoTime,
        motion: &Motion,
        setpoint: &Setpoint,
        measured_rpm: Option<f64>,
    ) -> Result<ControlOutput, ControlFault> {
        if self.active.is_none() {
            return Err(ControlFault::Disabled);
        }
        let measured_rpm = measured_rpm.filter(|rpm| rpm.is_finite());
        if !motion.is_finite()
            || !setpoint.yaw.is_none_or(YawTarget::is_finite)
            || !setpoint.speed.is_none_or(|speed| speed.value().is_finite())
        {
            return Err(ControlFault::NotFinite);
        }
        let (dt_s, restarted) = self.advance(now);
        let yaw = self.yaw.update(&self.config.yaw, setpoint.yaw, motion, dt_s);
        let speed = match setpoint.speed {
            Some(target) if yaw.may_go_ahead => {
                let max_actuation = self.config.output.max_actuation;
                let input =
                    SpeedInput { target, surge_mps: motion.surge_mps(), measured_rpm, max_actuation, dt_s };
                self.speed.update(&self.config.speed, &self.config.drive, &input)
            }
            _ => {
                self.speed.pause();
                speed_loop::SpeedStep::default()
            }
        };
        let motors = self.share(speed.effort, yaw.differential);
        Ok(ControlOutput {
            motors: self.send(motors, dt_s),
            yaw: yaw.terms,
            speed: speed.speed_terms,
            rpm: speed.rpm_terms,
            heading_error_rad: yaw.error_rad,
            crab_rad: yaw.crab_rad,
            ahead: yaw.may_go_ahead,
            restarted,
        })
    }

    /// Seconds since the last update, and whether the pause was too long to continue from there.
    fn advance(&mut self, now: MonoTime) -> (f64, bool) {
        let last = self.active.and_then(|active| active.last);
        let gap_s = last.map_or(0.0, |last| now.since(last).as_secs_f64());
        let restarted = gap_s > self.config.output.max_gap_s;
        if restarted {
            self.start_from(MotorPair::STOPPED);
        }
        let dt_s = if restarted { 0.0 } else { gap_s };
        if let Some(active) = &mut self.active {
            active.last = Some(now);
            active.age_s += dt_s;
        }
        (dt_s, restarted)
    }

    fn start_from(&mut self, motors: MotorPair) {
        self.yaw.restart();
        self.speed.start_at(motors.common(), &self.config.drive);
        self.active = Some(Active::from_motors(motors));
    }

    /// Common and differential effort to actuation; reports to the loops what was beyond the motors' limits.
    fn share(&mut self, common: f64, differential: f64) -> MotorPair {
        let CourseSpeedConfig { drive, output, .. } = &self.config;
        let limits = speed_loop::effort_limits(drive, output.max_actuation);
        let shared = allocate(common, differential, limits, output.sharing);
        for (saturation, tell_speed) in [
            (Saturation::between(common, shared.common), true),
            (Saturation::between(differential, shared.differential), false),
        ] {
            if saturation != Saturation::Free {
                if tell_speed {
                    self.speed.saturated(saturation);
                } else {
                    self.yaw.saturated(saturation);
                }
            }
        }
        shared.motors.map(|effort| speed_loop::actuation_for(drive, effort))
    }

    /// Fade after enabling, ramp and limit.
    fn send(&mut self, wanted: MotorPair, dt_s: f64) -> MotorPair {
        let OutputConfig { max_actuation, ramp_per_s, fade_s, .. } = self.config.output;
        let Some(active) = &mut self.active else { return MotorPair::STOPPED };
        let share = if active.age_s < fade_s { active.age_s / fade_s } else { 1.0 };
        let faded = active.start.zip(wanted, |start, wanted| start + share * (wanted - start));
        let ramped = match ramp_per_s {
            // The first update has no time to move in; it continues from the present motor commands.
            Some(limit) => active.motors.zip(faded, |last, wanted| ramp::rising(last, wanted, limit * dt_s)),
            None => faded,
        };
        active.motors = ramped.map(|actuation| actuation.clamp(-max_actuation, max_actuation));
        active.motors
    }
}

#[cfg(test)]
mod tests;
