//! The interface of all behaviours: their inputs, their outputs, the work left.

use super::ManeuverConfig;
use super::reference_state::ReferenceState;
use crate::command::{Command, Path};
use crate::event::{Event, Fix, Medium};
use guard::Waters;
use std::time::Duration;
use thiserror::Error;
use units::{LatLon, MonoTime, Now};

/// Why a maneuver failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FailReason {
    /// Path control refused or gave up the path.
    #[error("path control: {0}")]
    Path(String),
    /// Path control says nothing about the path under way.
    #[error("path control is silent")]
    PathSilent,
    /// The commander of FollowReference is silent.
    #[error("reference source timed out")]
    ReferenceTimeout,
    /// The followed system is silent.
    #[error("no news of system {0:#06x}")]
    SystemSilent(u16),
    /// A scheduled arrival came too late.
    #[error("arrival is late")]
    Late,
}

/// How much of a maneuver is left, for progress and time to the end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Left {
    /// Way (m).
    pub way_m: f64,
    /// Time to spend without making way (s).
    pub wait_s: f64,
}

/// How a maneuver ended.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outcome {
    Done,
    Failed(FailReason),
}

/// An output of a behaviour.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Signal {
    Command(Command),
    Reference(ReferenceState),
    /// A way must be searched for, from a place to a place.
    Way(LatLon, LatLon),
    /// For the log book.
    Warning(String),
}

/// The context of a behaviour: its inputs and outputs.
#[derive(Debug)]
pub(crate) struct Context<'a> {
    pub(crate) now: Now,
    pub(crate) config: &'a ManeuverConfig,
    /// The last fix, if it is young enough.
    pub(crate) fix: Option<Fix>,
    pub(crate) medium: Medium,
    /// Where the vessel may go.
    pub(crate) waters: &'a Waters,
    pub(crate) signals: &'a mut Vec<Signal>,
    /// Number of the latest path.
    pub(crate) path_ref: &'a mut u32,
    pub(crate) outcome: Option<Outcome>,
}

impl Context<'_> {
    pub(crate) fn command(&mut self, command: Command) {
        self.signals.push(Signal::Command(command));
    }

    /// Follows `path` under the next number.
    pub(crate) fn follow(&mut self, path: Path) {
        *self.path_ref = self.path_ref.wrapping_add(1);
        self.command(Command::Follow(Path { path_ref: *self.path_ref, ..path }));
    }

    /// Asks for a way; [`Event::Way`] answers.
    pub(crate) fn look_for_way(&mut self, from: LatLon, to: LatLon) {
        self.signals.push(Signal::Way(from, to));
    }

    pub(crate) fn warn(&mut self, text: String) {
        self.signals.push(Signal::Warning(text));
    }

    pub(crate) fn drift(&mut self) {
        self.command(Command::Drift);
    }

    pub(crate) fn done(&mut self) {
        self.outcome.get_or_insert(Outcome::Done);
    }

    pub(crate) fn fail(&mut self, reason: FailReason) {
        self.outcome.get_or_insert(Outcome::Failed(reason));
    }
}

/// A maneuver's state machine.
pub(crate) trait Behaviour {
    /// The maneuver begins.
    fn start(&mut self, cx: &mut Context<'_>);
    /// Takes an event. Progress of older paths never comes here.
    fn event(&mut self, cx: &mut Context<'_>, event: &Event);
    /// The time of [`Behaviour::deadline`] came.
    fn timeout(&mut self, cx: &mut Context<'_>) {
        let _ = cx;
    }
    /// When it wants to be woken.
    fn deadline(&self) -> Option<MonoTime> {
        None
    }
    /// The work left, where that is known.
    fn left(&self, now: Now) -> Option<Left>;
}

/// The rest of a wait of `duration` that began at `since`, or has not begun (s); nothing for an endless one.
pub(super) fn wait_left_s(duration: Option<Duration>, since: Option<MonoTime>, now: Now) -> Option<f64> {
    let gone = since.map_or(Duration::ZERO, |since| now.mono.since(since));
    duration.map(|duration| duration.saturating_sub(gone).as_secs_f64())
}
