//! Throttles and how long they live.

use super::config::{MotorAssignment, MotorsConfig};
use devices::Pair;
use devices::torqeedo::{CanFrame, CardCommand, per_mille};
use std::time::Duration;
use units::MonoTime;

const STOPPED: Pair<i16> = Pair::new(0, 0);

/// A throttle is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotANumber;

/// A command on its way to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Throttle {
    pub(super) frame: CanFrame,
    /// It must not leave from then on; `None` for a stop.
    pub(super) until: Option<MonoTime>,
}

/// The commanded throttles.
#[derive(Debug, Clone)]
pub(super) struct Throttles {
    sides: Pair<MotorAssignment>,
    period: Duration,
    life: Duration,
    /// The command that lives, as the motors 0 and 1 get it (per mille), and when it was given.
    command: Option<(MonoTime, Pair<i16>)>,
    next_write: MonoTime,
}

impl Throttles {
    pub(super) fn new(config: &MotorsConfig) -> Self {
        Self {
            sides: config.sides,
            period: config.write_period,
            life: config.command_timeout,
            command: None,
            next_write: MonoTime::default(),
        }
    }

    /// Takes over a command that was given at `given`, for the next time one is sent; one that stops the motors is sent at once.
    pub(super) fn command(
        &mut self,
        now: MonoTime,
        given: MonoTime,
        throttle: Pair<f64>,
    ) -> Result<(), NotANumber> {
        let signed = Pair::new(
            per_mille(throttle.port * self.sides.port.sign()),
            per_mille(throttle.starboard * self.sides.starboard.sign()),
        );
        let (Some(port), Some(starboard)) = (signed.port, signed.starboard) else {
            self.stop(now);
            return Err(NotANumber);
        };
        let by_number =
            if self.sides.port.motor == 0 { Pair::new(port, starboard) } else { Pair::new(starboard, port) };
        let runs = self.command.is_some_and(|(_, before)| before != STOPPED);
        if runs && by_number == STOPPED {
            self.next_write = now;
        }
        self.command = Some((given.min(now), by_number));
        Ok(())
    }

    /// Stops the motors at once.
    pub(super) fn stop(&mut self, now: MonoTime) {
        self.command = None;
        self.next_write = now;
    }

    /// The command that is due. It is zero from the moment that the last one has lived its time.
    pub(super) fn due(&mut self, now: MonoTime) -> Option<Throttle> {
        if self.command.is_some_and(|(given, _)| now.since(given) >= self.life) {
            self.stop(now);
        }
        if now < self.next_write {
            return None;
        }
        // Where the loop was held up, missed commands are not made up for.
        let kept = self.next_write + self.period;
        self.next_write = if kept > now { kept } else { now + self.period };
        let by_number = self.command.map_or(STOPPED, |(_, by_number)| by_number);
        let until = self.command.filter(|_| by_number != STOPPED).map(|(given, _)| given + self.life);
        Some(Throttle { frame: CardCommand::MotorSet(by_number).frame(), until })
    }

    pub(super) fn poll_timeout(&self) -> MonoTime {
        let lapse = self.command.map(|(given, _)| given + self.life);
        lapse.map_or(self.next_write, |lapse| lapse.min(self.next_write))
    }
}
