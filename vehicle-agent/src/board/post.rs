//! The two machines at the pins: each with its pins, which may be absent, and what it wants told of itself.

use super::pins::{Access, Open};
use crate::io::Report;
use drivers::light::{Activity, Light, Patterns, Situation};
use drivers::watchdog::{Pin, Watchdog, WatchdogConfig, WatchdogOutput};
use drivers::{Note, State};
use mission::Mode;
use onboard::Vitals;
use units::MonoTime;

/// What the posts are shown of the brain.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shown {
    pub(super) vitals: Vitals,
    /// A part that the light counts among the critical ones is in error.
    pub(super) critical_failed: bool,
}

/// What attends to pins.
pub(super) trait Post: Send {
    /// Does what is due at `now`; answers what there is to tell.
    fn turn(&mut self, now: MonoTime, shown: &Shown) -> Vec<Report>;

    /// When to come back at the latest; `None` when nothing is due by itself.
    fn due(&self) -> Option<MonoTime>;

    /// The program ends; cleanly, or after a fault of its own.
    fn end(&mut self, clean: bool);
}

/// The watchdog of the board.
pub(super) struct WatchdogPost {
    access: Access,
    config: WatchdogConfig,
    /// Begins when the pins are ours.
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
        // After a fault the board is to start the computer again.
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
        // A light that cannot be seen goes on too: what is latched stays latched.
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
            // All lamps are to be set again once there are some.
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
