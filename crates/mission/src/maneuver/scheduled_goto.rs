//! Scheduled goto: is at a place at a time, starting as late as its speed allows.
//!
//! Every two seconds the speed is the way left by the time left. Below a least speed the vessel does not start
//! yet; it drifts, before the start and after an early arrival, and starts (again) when the speed it needs
//! gets high enough. Done when the time is there and the vessel near.

use super::behaviour::{Behaviour, Context, FailReason, Left};
use super::goto::{distance_m, path_to};
use crate::checks::Checks;
use crate::command::Command;
use crate::event::Event;
use crate::place::RawPlace;
use std::time::Duration;
use units::Speed;
use units::{LatLon, MonoTime, Now, UtcTime};

/// How often the speed is reckoned again.
const PERIOD: Duration = Duration::from_secs(2);

/// Be at a place at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduledGoto<P = LatLon> {
    /// Where to be.
    pub target: P,
    /// When to be there.
    pub arrival: UtcTime,
    /// What to do when late.
    pub late: Late,
}

/// What to do when the time has come and the vessel is not near.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Late {
    /// Continue.
    Resume,
    /// Leave it; the maneuver is done.
    Skip,
    /// The maneuver fails.
    Fail,
}

/// Parameters of the behaviour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduledGotoConfig {
    /// The vessel does not start before it needs this speed (m/s).
    pub min_mps: f64,
    /// It never goes faster (m/s).
    pub max_mps: f64,
}

impl Default for ScheduledGotoConfig {
    fn default() -> Self {
        Self { min_mps: 0.7, max_mps: 1.6 }
    }
}

impl ScheduledGoto<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<ScheduledGoto> {
        Some(ScheduledGoto { target: checks.place(self.target)?, arrival: self.arrival, late: self.late })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Drifting, not near.
    Waiting,
    Underway,
    /// Drifting, the place reached.
    Arrived,
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    goto: ScheduledGoto,
    state: State,
    next_look: Option<MonoTime>,
}

impl Machine {
    pub(super) fn new(goto: ScheduledGoto) -> Self {
        Self { goto, state: State::Waiting, next_look: None }
    }

    /// Time left until the arrival (s); negative when it is over.
    fn time_left_s(&self, now: Now) -> f64 {
        (self.goto.arrival - now.utc) as f64 / 1e6
    }

    fn look(&mut self, cx: &mut Context<'_>) {
        self.next_look = Some(cx.now.mono + PERIOD);
        let left_s = self.time_left_s(cx.now);
        if left_s <= 0.0 {
            self.time_is_up(cx);
            return;
        }
        let Some(fix) = cx.fix else { return };
        let needed_mps = distance_m(fix.place, self.goto.target) / left_s;
        let config = &cx.config.scheduled;
        if self.state != State::Underway && needed_mps < config.min_mps {
            return;
        }
        // Once under way the speed may fall below the least one: the arrival is early then, and waits.
        let mps = needed_mps.clamp(config.min_mps.min(config.max_mps), config.max_mps);
        self.sail(cx, mps);
    }

    fn sail(&mut self, cx: &mut Context<'_>, mps: f64) {
        let speed = Speed::MetresPerSecond(mps);
        if self.state == State::Underway {
            cx.command(Command::ChangeSpeed(speed));
        } else {
            self.state = State::Underway;
            cx.follow(path_to(self.goto.target, speed));
        }
    }

    fn time_is_up(&mut self, cx: &mut Context<'_>) {
        match (self.state, self.goto.late) {
            (State::Arrived, _) | (_, Late::Skip) => cx.done(),
            (_, Late::Fail) => cx.fail(FailReason::Late),
            (_, Late::Resume) => self.sail(cx, cx.config.scheduled.max_mps),
        }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        cx.drift();
        self.look(cx);
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Path(progress) if progress.near && self.state == State::Underway => {
                if self.time_left_s(cx.now) <= 0.0 {
                    cx.done();
                } else {
                    self.state = State::Arrived;
                    cx.drift();
                }
            }
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Path(_)
            | Event::Fix(_)
            | Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn timeout(&mut self, cx: &mut Context<'_>) {
        self.look(cx);
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.next_look
    }

    fn left(&self, now: Now) -> Option<Left> {
        Some(Left { way_m: 0.0, wait_s: self.time_left_s(now).max(0.0) })
    }
}
