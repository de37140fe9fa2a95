//! The devices at the pins, watchdog and light: each with its pins, which may be missing, and its reports.

use super::pins::{Access, Open};
use crate::io::Report;
use drivers::light::{Activity, Light, Patterns, Situation};
use drivers::watchdog::{Pin, Watchdog, WatchdogConfig, WatchdogOutput};
use drivers::{Note, State};
use mission::Mode;
use onboard::Vitals;
use units::MonoTime;

/// The state of the brain that posts use.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shown {
    pub(super) vitals: Vitals,
    /// An entity that the light treats as critical is in error.
    pub(super) critical_failed: bool,
}

/// A device that is served by the board's thread.
pub(super) trait Post: Send {
    /// Does what is due at `now`; returns its reports.
    fn turn(&mut self, now: MonoTime, shown: &Shown) -> Vec<Report>;

    /// When to be called next at the latest; `None` if nothing is scheduled.
    fn due(&self) -> Option<MonoTime>;

    /// The program ends: cleanly, or after a panic.
    fn end(&mut self, clean: bool);
}

/// The watchdog of the board.
pub(super) struct WatchdogPost {
    access: Access,
    config: WatchdogConfig,
    /// Started when the pins are granted.
    watchdog: Option<Watchdog>,
}

impl WatchdogPost {
    pub(super) fn new(open: Open, config: WatchdogConfig) -> Self {
        Self { access: Access::new(open), config, watchdog: None }
    }

    fn try_turn(&mut self, now: MonoTime, shown: &Shown) -> anyhow::Result<Vec<Report>> {
        if self.access.open(now)? {
            self.watchdog = Some(Watchdog::new(now, self.config));
        }
        let (Some(pins), Some(watchdog)) = (self.access.pins(), &mut self.watchdog) else {
            return Ok(Vec::new());
        };
        watchdog.expiry(now, pins.is_high(Pin::Expiry.bcm())?);
        watchdog.alive(now, shown.vitals.steps);
        self.carry_out()
    }

    fn carry_out(&mut self) -> anyhow::Result<Vec<Report>> {
        let mut reports = Vec::new();
        let (Some(pins), Some(watchdog)) = (self.access.pins(), &mut self.watchdog) else {
            return Ok(reports);
        };
        while let Some(output) = watchdog.poll_output() {
            match output {
                WatchdogOutput::Set { pin, high } => pins.set(pin.bcm(), high)?,
                WatchdogOutput::State(state) => reports.push(Report::State(state)),
                WatchdogOutput::Note(note) => reports.push(Report::Note(note)),
            }
        }
        Ok(reports)
    }
}

impl Post for WatchdogPost {
    fn turn(&mut self, now: MonoTime, shown: &Shown) -> Vec<Report> {
        self.try_turn(now, shown).unwrap_or_else(|error| {
            self.access.close();
            self.watchdog = None;
            failing(&error)
        })
    }

    fn due(&self) -> Option<MonoTime> {
        self.watchdog.as_ref()?.poll_timeout()
    }

    fn end(&mut self, clean: bool) {
        // After a panic the board must restart the computer.
        if clean && let Some(watchdog) = &mut self.watchdog {
            watchdog.shut_down();
            if let Err(error) = self.carry_out() {
                tracing::error!(
                    "the board's watchdog cannot be turned off and will restart the computer: {error:#}"
                );
            }
        }
    }
}

/// The signal light.
pub(super) struct LightPost {
    access: Access,
    light: Light,
    /// The pin of each lamp.
    lamps: Vec<u8>,
    patterns: Patterns,
}

impl LightPost {
    /// Lamps at these pins.
    pub(super) fn new(open: Open, lamps: Vec<u8>, patterns: Patterns) -> Self {
        Self { access: Access::new(open), light: Light::new(lamps.len(), patterns.clone()), lamps, patterns }
    }

    fn try_turn(&mut self, now: MonoTime, shown: &Shown) -> anyhow::Result<Vec<Report>> {
        let mut reports = Vec::new();
        if self.access.open(now)? {
            reports.push(Report::State(State::Working));
        }
        // The pattern is kept even without pins: latched errors stay latched.
        self.light.show(now, situation(shown));
        self.light.tick(now);
        self.switch()?;
        Ok(reports)
    }

    fn switch(&mut self) -> anyhow::Result<()> {
        let Some(pins) = self.access.pins() else { return Ok(()) };
        while let Some((lamp, on)) = self.light.poll_output() {
            if let Some(pin) = self.lamps.get(usize::from(lamp)) {
                pins.set(*pin, on)?;
            }
        }
        Ok(())
    }
}

impl Post for LightPost {
    fn turn(&mut self, now: MonoTime, shown: &Shown) -> Vec<Report> {
        self.try_turn(now, shown).unwrap_or_else(|error| {
            self.access.close();
            // Set all lamps again once the pins are there.
            let fatal = self.light.is_fatal();
            self.light = Light::new(self.lamps.len(), self.patterns.clone());
            if fatal {
                self.light.show(now, Situation { critical_failed: true, ..situation(shown) });
            }
            failing(&error)
        })
    }

    fn due(&self) -> Option<MonoTime> {
        self.light.poll_timeout()
    }

    fn end(&mut self, _clean: bool) {
        self.light.end();
        if let Err(error) = self.switch() {
            tracing::warn!("the signal light cannot be turned off: {error:#}");
        }
    }
}

fn failing(error: &anyhow::Error) -> Vec<Report> {
    let text = format!("{error:#}");
    vec![Report::State(State::Failing(text.clone())), Report::Note(Note { warning: true, text })]
}

fn situation(shown: &Shown) -> Situation {
    let Vitals { mode, fuel_low, powering_off, .. } = shown.vitals;
    let activity = match mode {
        Mode::Boot => Activity::Boot,
        Mode::Service => Activity::Service,
        Mode::Calibration => Activity::Calibration,
        Mode::Error => Activity::Error,
        Mode::Maneuver => Activity::Maneuver,
    };
    Situation { activity, fuel_low, critical_failed: shown.critical_failed, powering_off }
}
