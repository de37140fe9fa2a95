//! A simulated hull, which moves up to the time of each poll.

use super::Hull;
use control::MotorPair;
use devices::Reading;
use onboard::{COMMAND_LIFE, Input};
use sim::Vessel;
use std::collections::VecDeque;
use std::sync::mpsc::Receiver;
use units::MonoTime;

/// How commands reach the simulated thrusters.
enum Thrusters {
    /// Directly: a virtual clock cannot be delayed.
    Direct,
    /// Through a watchdog with its own thread: its input, and its output.
    Watched(Box<dyn Fn(MotorPair)>, Receiver<MotorPair>),
}

/// A simulated hull.
pub(crate) struct Simulated {
    /// The simulation. Its readings come as values.
    pub(crate) vessel: Vessel,
    thrusters: Thrusters,
    /// Readings that waited in a serial port between polls.
    waited: VecDeque<(MonoTime, Reading)>,
}

impl std::fmt::Debug for Simulated {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Simulated").field("vessel", &self.vessel).finish_non_exhaustive()
    }
}

impl Simulated {
    /// A hull whose thrusters obey directly.
    pub(crate) fn new(vessel: Vessel) -> Self {
        Self { vessel, thrusters: Thrusters::Direct, waited: VecDeque::new() }
    }

    /// A hull behind a watchdog: `command` passes a command to it, `passed` receives its output, including its own stops.
    pub(crate) fn watched(
        vessel: Vessel,
        command: impl Fn(MotorPair) + 'static,
        passed: Receiver<MotorPair>,
    ) -> Self {
        Self { thrusters: Thrusters::Watched(Box::new(command), passed), ..Self::new(vessel) }
    }

    /// Bypasses the watchdog, whose clock is the computer's.
    #[cfg(test)]
    pub(crate) fn obey_at_once(&mut self) {
        self.thrusters = Thrusters::Direct;
    }

    /// Passes the watchdog's output to the thrusters.
    fn obey_watchdog(&mut self) {
        if let Thrusters::Watched(_, passed) = &self.thrusters {
            for motors in passed.try_iter() {
                obey(&mut self.vessel, motors);
            }
        }
    }

    /// Drifts until `until` without control: the motors run only for the life of the last command. Readings are lost except
    /// the hydrophone's, whose lines wait in its serial port.
    fn drift(&mut self, until: MonoTime) {
        let running = (self.vessel.now() + COMMAND_LIFE).min(until);
        self.vessel.step(running.since(self.vessel.now()));
        obey(&mut self.vessel, MotorPair::STOPPED);
        self.vessel.step(until.since(running));
        while let Some(reading) = self.reading() {
            if matches!(reading.1, Reading::Tag(_) | Reading::Water(_)) {
                self.waited.push_back(reading);
            }
        }
    }

    /// The next reading of the simulation, with its time; its bytes, for drivers, are ignored.
    fn reading(&mut self) -> Option<(MonoTime, Reading)> {
        loop {
            let sim::Timed { at, output, .. } = self.vessel.poll_output()?;
            if let sim::Output::Reading(reading) = output {
                return Some((at, reading));
            }
        }
    }
}

impl Hull for Simulated {
    fn poll(&mut self, until: MonoTime) -> Option<Input> {
        self.obey_watchdog();
        let behind = until.since(self.vessel.now());
        if behind > COMMAND_LIFE {
            self.drift(until);
        } else {
            self.vessel.step(behind);
        }
        let (at, reading) = self.waited.pop_front().or_else(|| self.reading())?;
        Some(Input::Reading(at, reading))
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        Some(self.vessel.poll_timeout())
    }

    fn command(&mut self, motors: MotorPair) {
        match &self.thrusters {
            Thrusters::Direct => obey(&mut self.vessel, motors),
            Thrusters::Watched(command, _) => {
                command(motors);
                self.obey_watchdog();
            }
        }
    }

    fn end(&mut self, _clean: bool) -> bool {
        true
    }
}

fn obey(vessel: &mut Vessel, motors: MotorPair) {
    // Commands are limited to -1 to 1 by the authority.
    vessel.command(motors.port, motors.starboard).ok();
}
