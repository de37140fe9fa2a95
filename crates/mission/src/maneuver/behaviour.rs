//! What all behaviours share: what they see, what they answer, how much is left.

use super::{
    Maneuver, ManeuverConfig, ReferenceState, follow_reference, follow_system, follow_trajectory, goto, idle,
    launch, loiter, scheduled_goto, station_keeping, teleoperation, waypoints,
};
use crate::command::{Command, Path};
use crate::event::{Event, Fix, Medium, Now};
use guard::Waters;
use std::time::Duration;
use thiserror::Error;
use units::MonoTime;

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

/// What a behaviour says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Signal {
    Command(Command),
    Reference(ReferenceState),
    /// For the log book.
    Warning(String),
}

/// What a behaviour sees and answers through.
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
    /// Something happened. Progress of older paths never comes here.
    fn event(&mut self, cx: &mut Context<'_>, event: &Event);
    /// The time of [`Behaviour::deadline`] came.
    fn timeout(&mut self, cx: &mut Context<'_>) {
        let _ = cx;
    }
    /// When it wants to be woken.
    fn deadline(&self) -> Option<MonoTime> {
        None
    }
    /// What is left, where that can be told.
    fn left(&self, now: Now) -> Option<Left>;
}

/// The state machine of any maneuver.
#[derive(Debug, Clone)]
pub(crate) enum Running {
    Goto(goto::Machine),
    Launch(launch::Machine),
    Loiter(loiter::Machine),
    StationKeeping(station_keeping::Machine),
    Waypoints(waypoints::Machine),
    FollowTrajectory(follow_trajectory::Machine),
    Idle(idle::Machine),
    ScheduledGoto(scheduled_goto::Machine),
    FollowReference(Box<follow_reference::Machine>),
    FollowSystem(follow_system::Machine),
    Teleoperation(teleoperation::Machine),
}

impl Running {
    pub(crate) fn new(maneuver: &Maneuver) -> Self {
        match maneuver {
            Maneuver::Goto(goto) => Self::Goto(goto::Machine::new(*goto)),
            Maneuver::Launch(launch) => Self::Launch(launch::Machine::new(*launch)),
            Maneuver::Loiter(loiter) => Self::Loiter(loiter::Machine::new(*loiter)),
            Maneuver::StationKeeping(station) => {
                Self::StationKeeping(station_keeping::Machine::new(*station))
            }
            Maneuver::FollowPath(path) => Self::Waypoints(waypoints::Machine::along(path)),
            Maneuver::Rows(rows) => Self::Waypoints(waypoints::Machine::rows(rows)),
            Maneuver::RowsCoverage(rows) => Self::Waypoints(waypoints::Machine::coverage(rows)),
            Maneuver::FollowTrajectory(trajectory) => {
                Self::FollowTrajectory(follow_trajectory::Machine::new(trajectory))
            }
            Maneuver::Idle(idle) => Self::Idle(idle::Machine::new(*idle)),
            Maneuver::ScheduledGoto(goto) => Self::ScheduledGoto(scheduled_goto::Machine::new(*goto)),
            Maneuver::FollowReference(follow) => {
                Self::FollowReference(Box::new(follow_reference::Machine::new(*follow)))
            }
            Maneuver::FollowSystem(follow) => Self::FollowSystem(follow_system::Machine::new(*follow)),
            Maneuver::Teleoperation(teleoperation) => {
                Self::Teleoperation(teleoperation::Machine::new(*teleoperation))
            }
        }
    }

    fn behaviour(&mut self) -> &mut dyn Behaviour {
        match self {
            Self::Goto(machine) => machine,
            Self::Launch(machine) => machine,
            Self::Loiter(machine) => machine,
            Self::StationKeeping(machine) => machine,
            Self::Waypoints(machine) => machine,
            Self::FollowTrajectory(machine) => machine,
            Self::Idle(machine) => machine,
            Self::ScheduledGoto(machine) => machine,
            Self::FollowReference(machine) => machine.as_mut(),
            Self::FollowSystem(machine) => machine,
            Self::Teleoperation(machine) => machine,
        }
    }

    fn look(&self) -> &dyn Behaviour {
        match self {
            Self::Goto(machine) => machine,
            Self::Launch(machine) => machine,
            Self::Loiter(machine) => machine,
            Self::StationKeeping(machine) => machine,
            Self::Waypoints(machine) => machine,
            Self::FollowTrajectory(machine) => machine,
            Self::Idle(machine) => machine,
            Self::ScheduledGoto(machine) => machine,
            Self::FollowReference(machine) => machine.as_ref(),
            Self::FollowSystem(machine) => machine,
            Self::Teleoperation(machine) => machine,
        }
    }

    pub(crate) fn start(&mut self, cx: &mut Context<'_>) {
        self.behaviour().start(cx);
    }

    pub(crate) fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        self.behaviour().event(cx, event);
    }

    pub(crate) fn timeout(&mut self, cx: &mut Context<'_>) {
        self.behaviour().timeout(cx);
    }

    pub(crate) fn deadline(&self) -> Option<MonoTime> {
        self.look().deadline()
    }

    pub(crate) fn left(&self, now: Now) -> Option<Left> {
        self.look().left(now)
    }
}

/// What is left of a wait of `duration` that began at `since`, or has not begun (s); nothing for an endless one.
pub(super) fn wait_left_s(duration: Option<Duration>, since: Option<MonoTime>, now: Now) -> Option<f64> {
    let gone = since.map_or(Duration::ZERO, |since| now.mono.since(since));
    duration.map(|duration| duration.saturating_sub(gone).as_secs_f64())
}
