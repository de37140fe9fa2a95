//! The one owner of the thrusters.
//!
//! The controller in charge (the course and speed controller, or a remote operator) must be granted the thrusters
//! and must keep commanding: a command is valid for half a second and no longer. A command that is stale, not a
//! number, or not from the owner never reaches a motor. Every change of owner goes through a stop.
//!
//! Fresh commands go out at once and again at 4 Hz, because the motor card stops a motor that is not
//! commanded within a second; a stop is repeated at 1 Hz.

use control::MotorPair;
use std::time::Duration;
use units::MonoTime;

/// How long a command is good for.
pub const COMMAND_LIFE: Duration = Duration::from_millis(500);
const REPEAT_RUNNING: Duration = Duration::from_millis(250);
const REPEAT_STOPPED: Duration = Duration::from_secs(1);

/// The controllers that may command the thrusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// The course and speed controller.
    Autopilot,
    /// A remote operator.
    Remote,
}

/// Why a command was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Another controller owns the thrusters, or none does.
    #[error("another controller owns the thrusters")]
    NotOwner,
    /// A value is not a number within -1 to 1; the motors are stopped.
    #[error("a thruster command is not a number within -1 to 1")]
    NotFinite,
    /// The thrusters are inhibited.
    #[error("the thrusters are inhibited")]
    Inhibited,
}

/// The thrusters' gate.
#[derive(Debug, Clone, Default)]
pub struct Authority {
    owner: Option<Owner>,
    inhibited: bool,
    /// The command in force and when it was given.
    command: Option<(MonoTime, MotorPair)>,
    /// The last output, and when it must be repeated.
    sent: Option<MotorPair>,
    repeat: MonoTime,
}

impl Authority {
    /// Transfers the thrusters. The motors stop until the new owner commands.
    pub fn grant(&mut self, owner: Owner) {
        if self.owner != Some(owner) {
            self.owner = Some(owner);
            self.command = None;
        }
    }

    /// Takes the thrusters away from their owner.
    pub fn revoke(&mut self) {
        self.owner = None;
        self.command = None;
    }

    /// From here on nothing but a stop goes out.
    pub fn inhibit(&mut self) {
        self.inhibited = true;
        self.command = None;
    }

    /// The owner of the thrusters.
    pub fn owner(&self) -> Option<Owner> {
        self.owner
    }

    /// The motors' commands, as far as known here.
    pub fn motors(&self) -> MotorPair {
        self.sent.unwrap_or(MotorPair::STOPPED)
    }

    /// A command for both motors.
    ///
    /// # Errors
    /// When it is not taken; nonsense from the owner also stops the motors.
    pub fn command(&mut self, now: MonoTime, from: Owner, motors: MotorPair) -> Result<(), Refusal> {
        if self.inhibited {
            return Err(Refusal::Inhibited);
        }
        if self.owner != Some(from) {
            return Err(Refusal::NotOwner);
        }
        let sane = |value: f64| (-1.0..=1.0).contains(&value);
        if !(sane(motors.port) && sane(motors.starboard)) {
            self.command = None;
            return Err(Refusal::NotFinite);
        }
        self.command = Some((now, motors));
        Ok(())
    }

    /// The output to the motors at `now`.
    pub fn poll(&mut self, now: MonoTime) -> Option<MotorPair> {
        if self.command.is_some_and(|(given, _)| now.since(given) >= COMMAND_LIFE) {
            self.command = None;
        }
        let motors = self.command.map_or(MotorPair::STOPPED, |(_, motors)| motors);
        if self.sent == Some(motors) && now < self.repeat {
            return None;
        }
        self.sent = Some(motors);
        let period = if motors == MotorPair::STOPPED { REPEAT_STOPPED } else { REPEAT_RUNNING };
        self.repeat = now + period;
        Some(motors)
    }

    /// When [`Authority::poll`] must be called next.
    pub fn poll_timeout(&self) -> MonoTime {
        match self.command {
            Some((given, _)) => self.repeat.min(given + COMMAND_LIFE),
            None => self.repeat,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: MotorPair = MotorPair { port: 0.5, starboard: 0.5 };

    fn ms(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    #[test]
    fn a_command_lives_half_a_second() {
        let mut authority = Authority::default();
        authority.grant(Owner::Autopilot);
        assert_eq!(authority.poll(ms(0)), Some(MotorPair::STOPPED));
        authority.command(ms(10), Owner::Autopilot, AHEAD).unwrap();
        assert_eq!(authority.poll(ms(10)), Some(AHEAD));
        assert_eq!(authority.poll(ms(200)), None);
        assert_eq!(authority.poll_timeout(), ms(260));
        assert_eq!(authority.poll(ms(260)), Some(AHEAD));
        assert_eq!(authority.poll(ms(509)), None);
        assert_eq!(authority.poll_timeout(), ms(510));
        assert_eq!(authority.poll(ms(510)), Some(MotorPair::STOPPED));
    }

    #[test]
    fn only_the_owner_commands_and_a_new_owner_begins_stopped() {
        let mut authority = Authority::default();
        assert_eq!(authority.command(ms(0), Owner::Remote, AHEAD), Err(Refusal::NotOwner));
        authority.grant(Owner::Autopilot);
        authority.command(ms(0), Owner::Autopilot, AHEAD).unwrap();
        assert_eq!(authority.poll(ms(0)), Some(AHEAD));
        authority.grant(Owner::Remote);
        assert_eq!(authority.poll(ms(1)), Some(MotorPair::STOPPED));
        assert_eq!(authority.command(ms(2), Owner::Autopilot, AHEAD), Err(Refusal::NotOwner));
        assert_eq!(authority.poll(ms(2)), None);
    }

    #[test]
    fn nonsense_and_inhibition_stop() {
        let mut authority = Authority::default();
        authority.grant(Owner::Autopilot);
        authority.command(ms(0), Owner::Autopilot, AHEAD).unwrap();
        assert_eq!(authority.poll(ms(0)), Some(AHEAD));
        for bad in [f64::NAN, f64::INFINITY, 1.01] {
            let motors = MotorPair { port: bad, starboard: 0.0 };
            assert_eq!(authority.command(ms(1), Owner::Autopilot, motors), Err(Refusal::NotFinite));
        }
        assert_eq!(authority.poll(ms(1)), Some(MotorPair::STOPPED));
        authority.inhibit();
        assert_eq!(authority.command(ms(2), Owner::Autopilot, AHEAD), Err(Refusal::Inhibited));
        authority.grant(Owner::Remote);
        assert_eq!(authority.command(ms(3), Owner::Remote, AHEAD), Err(Refusal::Inhibited), "for good");
    }
}
