//! Manual control: the keys of an operator to thrust, and no thrust when the operator falls silent.
//!
//! After DUNE's RemoteOperation and NTNU's RemoteOperationOtter. While messages come, output follows at a
//! fixed rate; when none came for the connection timeout the motors are stopped once and output rests until
//! the next message, with the throttle at zero. Only messages of the source in control count: the caller states
//! whether a message is from that source; others neither steer nor keep the watchdog quiet.
//!
//! A message may say how long it is valid; it is not valid for longer, whatever the connection timeout. When a message
//! that moved the vessel has expired so, the sticks must pass neutral before the next such message moves it again.
//!
//! Differences from the originals: holding Accelerate or Decelerate changes the throttle by time rather than
//! by message, so the sender's rate does not matter (at 10 messages a second both give 0.05 each); Left and
//! Right step once per press.
//!
//! Units: actuation and axes -1 to 1, radians clockwise from north, m/s.

mod actions;

pub use actions::{REMOTE_ACTIONS, RemoteActions};

use crate::course_speed::{Setpoint, YawTarget};
use crate::range::{InvalidConfig, RangeCheck};
use crate::thrust::{EffortLimits, MotorPair, Sharing, ThrustMap, allocate};
use std::time::Duration;
use units::{MonoTime, Speed, wrap_pi};

/// A held button counts for no longer than this between two messages (s).
const LONGEST_PRESS_S: f64 = 0.2;
/// The first message of a press counts as this long (s).
const FIRST_PRESS_S: f64 = 0.1;

/// How throttle s and heading h become thrust.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mixing {
    /// port, starboard = s ± h (DUNE).
    Additive,
    /// s·(1 ± 2h) (the thesis, NTNU's mode 0): no turn without throttle.
    Scaled,
    /// As scaled, but the motor on the outer side of the turn gains only this share of what the inner one loses
    /// (NTNU's mode 2): s·(1 + 2h·share) outside, s·(1 - 2h) inside.
    Skewed {
        /// "Skewed Motor Force Factor", 0 to 10: 0 turns by slowing the inner motor alone, 1 is scaled.
        outer_share: f64,
    },
    /// As additive, but s and h are shares of the force rather than of the actuation (NTNU's mode 1).
    ForceLinear(ThrustMap),
    /// A heading and a speed for the course and speed controller (NTNU's mode 3): speed = s·max, heading =
    /// held heading + max·h.
    Autopilot {
        /// Speed at full throttle (m/s), 0.1 to 10; 2.3 at NTNU.
        max_speed_mps: f64,
        /// Turn at full deflection (rad), 0.01 to π; π at NTNU.
        max_turn_rad: f64,
    },
}

/// Parameters of [`Remote`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemoteConfig {
    /// How throttle and heading become thrust.
    pub mixing: Mixing,
    /// Actuation at full deflection, 0.01 to 1, "Thrust Scale".
    pub thrust_scale: f64,
    /// Silence after which the motors stop (s), 0.2 to 10, "Connection Timeout".
    pub connection_timeout_s: f64,
    /// Time between two outputs (s), 0.02 to 1.
    pub output_period_s: f64,
    /// Change of the held throttle per second of Accelerate or Decelerate, 0.05 to 5.
    pub throttle_per_s: f64,
    /// Step of Left and Right (rad), 0.01 to π.
    pub heading_step_rad: f64,
    /// Which effort yields when a motor saturates.
    pub sharing: Sharing,
}

impl Default for RemoteConfig {
    /// DUNE's mixing at 10 outputs a second with the thesis' timeout of 2 s; turning comes first.
    fn default() -> Self {
        Self {
            mixing: Mixing::Additive,
            thrust_scale: 1.0,
            connection_timeout_s: 2.0,
            output_period_s: 0.1,
            throttle_per_s: 0.5,
            heading_step_rad: 30_f64.to_radians(),
            sharing: Sharing::TurnFirst,
        }
    }
}

impl RemoteConfig {
    /// Whether every value is within its range.
    ///
    /// # Errors
    /// Names every value that is not.
    pub fn validate(&self) -> Result<(), InvalidConfig> {
        let mut check = RangeCheck::default();
        match &self.mixing {
            Mixing::ForceLinear(map) => check.within("map", |check| map.check(check)),
            Mixing::Autopilot { max_speed_mps, max_turn_rad } => {
                check.number("max_speed", "m/s", *max_speed_mps, 0.1..=10.0);
                check.number("max_turn", "rad", *max_turn_rad, 0.01..=std::f64::consts::PI);
            }
            Mixing::Skewed { outer_share } => check.number("outer_share", "1", *outer_share, 0.0..=10.0),
            Mixing::Additive | Mixing::Scaled => {}
        }
        check.number("thrust_scale", "1", self.thrust_scale, 0.01..=1.0);
        check.number("connection_timeout", "s", self.connection_timeout_s, 0.2..=10.0);
        check.number("output_period", "s", self.output_period_s, 0.02..=1.0);
        check.number("throttle_rate", "1/s", self.throttle_per_s, 0.05..=5.0);
        check.number("heading_step", "rad", self.heading_step_rad, 0.01..=std::f64::consts::PI);
        check.finish()
    }
}

/// The result of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RemoteReply {
    /// It steers.
    Taken,
    /// It ends manual control; the motors stop.
    Exit,
    /// It is not from the source in control and had no effect.
    NotInControl,
    /// Manual control is not active; it had no effect.
    Inactive,
}

/// The demand on the vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RemoteCommand {
    /// Thrust.
    Motors(MotorPair),
    /// Heading and speed for the course and speed controller.
    Autopilot(Setpoint),
}

/// Manual control.
#[derive(Debug, Clone)]
pub struct Remote {
    config: RemoteConfig,
    active: bool,
    session: Option<Session>,
    /// When a stop fell due that has not been put out.
    stop_due: Option<MonoTime>,
    /// The life of a message ran out while it moved the vessel: neutral comes first.
    locked: bool,
}

/// From the first message until silence.
#[derive(Debug, Clone, Copy)]
struct Session {
    actions: RemoteActions,
    throttle: f64,
    held_heading_rad: f64,
    heard: MonoTime,
    next_output: MonoTime,
}

impl Remote {
    /// Manual control that is not active.
    ///
    /// # Errors
    /// When values of `config` are out of range.
    pub fn new(config: RemoteConfig) -> Result<Self, InvalidConfig> {
        config.validate()?;
        Ok(Self { config, active: false, session: None, stop_due: None, locked: false })
    }

    /// New parameters.
    ///
    /// # Errors
    /// When values of `config` are out of range; the old ones then stay in use.
    pub fn reconfigure(&mut self, config: RemoteConfig) -> Result<(), InvalidConfig> {
        config.validate()?;
        self.config = config;
        Ok(())
    }

    /// Starts at `now`: the motors stop until the first message.
    pub fn activate(&mut self, now: MonoTime) {
        self.active = true;
        self.session = None;
        self.stop_due = Some(now);
        self.locked = false;
    }

    /// Ends at `now`: the motors stop once more.
    pub fn deactivate(&mut self, now: MonoTime) {
        if self.active {
            self.active = false;
            self.session = None;
            self.stop_due = Some(now);
        }
    }

    /// Whether manual control is active.
    pub fn is_active(&self) -> bool {
        self.active
    }

    /// Whether messages have come within the timeout, as far as [`Remote::poll`] has been asked.
    pub fn is_connected(&self) -> bool {
        self.session.is_some()
    }

    /// A message at `now`. `in_control`: whether its sender holds control of the vessel; `heading_rad`
    /// is where the bow points, for the autopilot to hold at first.
    pub fn handle(
        &mut self,
        now: MonoTime,
        actions: &RemoteActions,
        heading_rad: f64,
        in_control: bool,
    ) -> RemoteReply {
        if !self.active {
            return RemoteReply::Inactive;
        }
        if !in_control {
            return RemoteReply::NotInControl;
        }
        if actions.exit {
            self.deactivate(now);
            return RemoteReply::Exit;
        }
        let mut actions = actions.sane();
        let config = self.config;
        self.expire(now);
        if actions.life.is_some() {
            self.locked &= !actions.is_neutral();
            if self.locked {
                actions = RemoteActions { life: actions.life, stop: true, ..RemoteActions::default() };
            }
        }
        let before = self.session.unwrap_or(Session {
            actions: RemoteActions::default(),
            throttle: 0.0,
            held_heading_rad: if heading_rad.is_finite() { wrap_pi(heading_rad) } else { 0.0 },
            heard: now,
            next_output: now,
        });
        self.session = Some(before.after(&config, now, &actions));
        RemoteReply::Taken
    }

    /// The output due at `now`; to be called until it answers `None`.
    pub fn poll(&mut self, now: MonoTime) -> Option<RemoteCommand> {
        self.expire(now);
        if self.stop_due.take().is_some() {
            return Some(RemoteCommand::Motors(MotorPair::STOPPED));
        }
        let config = self.config;
        let session = self.session.as_mut().filter(|session| now >= session.next_output)?;
        session.next_output = now + Duration::from_secs_f64(config.output_period_s);
        Some(session.command(&config))
    }

    /// Ends what has had its time.
    fn expire(&mut self, now: MonoTime) {
        let Some(over) = self.session.take_if(|session| now >= session.silent_at(&self.config)) else {
            return;
        };
        self.stop_due = Some(now);
        self.locked |= over.actions.life.is_some() && !over.actions.is_neutral();
    }

    /// Whether sticks have no effect until they pass neutral.
    pub fn is_locked(&self) -> bool {
        self.locked
    }

    /// When [`Remote::poll`] must be called next.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        let session = self.session.map(|session| session.next_output.min(session.silent_at(&self.config)));
        match (self.stop_due, session) {
            (Some(stop), Some(output)) => Some(stop.min(output)),
            (stop, output) => stop.or(output),
        }
    }
}

impl Session {
    fn silent_at(&self, config: &RemoteConfig) -> MonoTime {
        let timeout = Duration::from_secs_f64(config.connection_timeout_s);
        self.heard + self.actions.life.map_or(timeout, |life| life.min(timeout))
    }

    /// The session after a message.
    fn after(self, config: &RemoteConfig, now: MonoTime, actions: &RemoteActions) -> Self {
        let mut session = Self { actions: *actions, heard: now, ..self };
        let was = self.actions;
        let direct = actions.port_motor != 0.0 || actions.starboard_motor != 0.0;
        if actions.stop || direct {
            session.throttle = 0.0;
        } else if let Some(throttle) = actions.throttle {
            session.throttle = throttle;
        } else {
            let press_s = |held_before: bool| {
                let since_s = now.since(self.heard).as_secs_f64().min(LONGEST_PRESS_S);
                if held_before { since_s } else { FIRST_PRESS_S }
            };
            if actions.accelerate {
                session.throttle += config.throttle_per_s * press_s(was.accelerate);
            }
            if actions.decelerate {
                session.throttle -= config.throttle_per_s * press_s(was.decelerate);
            }
            session.throttle = session.throttle.clamp(-1.0, 1.0);
        }
        let steps = f64::from(i8::from(actions.right && !was.right) - i8::from(actions.left && !was.left));
        session.held_heading_rad = wrap_pi(self.held_heading_rad + steps * config.heading_step_rad);
        if actions.stop {
            // A stop waits for no tick.
            session.next_output = now;
        }
        session
    }

    fn command(&self, config: &RemoteConfig) -> RemoteCommand {
        let RemoteActions { port_motor, starboard_motor, heading, stop, .. } = self.actions;
        if stop {
            return RemoteCommand::Motors(MotorPair::STOPPED);
        }
        if port_motor != 0.0 || starboard_motor != 0.0 {
            let motors = MotorPair { port: port_motor, starboard: starboard_motor };
            return RemoteCommand::Motors(motors.map(|axis| axis * config.thrust_scale));
        }
        let throttle = self.throttle;
        let unit = EffortLimits { astern: -1.0, ahead: 1.0 };
        let motors = match config.mixing {
            Mixing::Additive => allocate(throttle, heading, unit, config.sharing).motors,
            Mixing::Scaled => allocate(throttle, 2.0 * throttle * heading, unit, Sharing::Independent).motors,
            Mixing::Skewed { outer_share } => {
                let turn = 2.0 * heading;
                let (port, starboard) = if heading >= 0.0 {
                    (1.0 + turn * outer_share, 1.0 - turn)
                } else {
                    (1.0 + turn, 1.0 - turn * outer_share)
                };
                MotorPair { port, starboard }.map(|share| (throttle * share).clamp(-1.0, 1.0))
            }
            Mixing::ForceLinear(map) => {
                let limits = map.limits();
                let common_n = throttle * if throttle < 0.0 { -limits.astern } else { limits.ahead };
                let differential_n = heading * limits.ahead.min(-limits.astern);
                let shared = allocate(common_n, differential_n, limits, config.sharing);
                shared.motors.map(|force_n| map.actuation_for(force_n))
            }
            Mixing::Autopilot { max_speed_mps, max_turn_rad } => {
                let heading_rad = wrap_pi(self.held_heading_rad + max_turn_rad * heading);
                return RemoteCommand::Autopilot(Setpoint {
                    yaw: Some(YawTarget::Heading(heading_rad)),
                    speed: Some(Speed::MetresPerSecond(max_speed_mps * throttle.max(0.0))),
                });
            }
        };
        RemoteCommand::Motors(motors.map(|actuation| actuation * config.thrust_scale))
    }
}

#[cfg(test)]
mod tests;
