//! What the engine reports about itself and the vehicle.

use super::request::{EndReason, LastOutcome, Reply, RunId};
use crate::command::{Command, Drive};
use crate::kind::ManeuverKind;
use crate::maneuver::ReferenceState;
use std::time::Duration;
use units::{LatLon, UtcTime};

/// An output of the engine, to be carried out or reported in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Control does this from here on.
    Command(Command),
    /// An answer to a request.
    Reply(Reply),
    /// A plan begins: log, broadcast its specification, keep it under this number.
    PlanBegins {
        /// Number of the run.
        run: RunId,
        /// Its name.
        plan_id: String,
    },
    /// A plan ended; comes exactly once for each [`Output::PlanBegins`].
    PlanEnded {
        /// Number of the run.
        run: RunId,
        /// Its name.
        plan_id: String,
        /// Why it ended.
        reason: EndReason,
    },
    /// Carry out the actions that the plan of `run` has here.
    Actions {
        /// Number of the run.
        run: RunId,
        /// Where in the plan.
        point: ActionPoint,
    },
    /// Calibrate sensors for so long.
    Calibrate(Duration),
    /// A maneuver begins; its command follows.
    ManeuverBegins {
        /// Number of the run.
        run: RunId,
        /// Its name.
        id: String,
        /// Its kind.
        kind: ManeuverKind,
    },
    /// A maneuver ended.
    ManeuverEnded {
        /// Number of the run.
        run: RunId,
        /// Its name.
        id: String,
        /// How.
        end: ManeuverEnd,
    },
    /// State of FollowReference, for its commander.
    Reference(ReferenceState),
    /// A way to a place must be searched for, in place of the previous one; [`Event::Way`](crate::Event::Way) answers.
    LookForWay {
        /// Where the vessel is.
        from: LatLon,
        /// The place.
        to: LatLon,
    },
    /// The state of plans changed.
    PlanState(Box<PlanState>),
    /// The state of the vehicle changed.
    VehicleState(Box<VehicleState>),
    /// An abort by this system was carried out.
    Aborted {
        /// IMC id of the system that asked.
        by: u16,
    },
    /// For the log book.
    Note(Note),
}

/// How a maneuver ended.
#[derive(Debug, Clone, PartialEq)]
pub enum ManeuverEnd {
    /// By itself.
    Done,
    /// In error, with a text for people.
    Failed(String),
    /// It was stopped.
    Stopped,
}

/// Places of actions in a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ActionPoint {
    /// Before the first maneuver.
    PlanStart,
    /// After the last, however the plan ended.
    PlanEnd,
    /// Before a maneuver.
    ManeuverStart(String),
    /// After a maneuver, however it ended.
    ManeuverEnd(String),
    /// Between two maneuvers.
    Transition {
        /// The one that ended.
        from: String,
        /// The one that begins.
        to: String,
    },
}

/// A line for the log book.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// How bad it is.
    pub level: NoteLevel,
    /// For people.
    pub text: String,
}

/// How bad a note is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoteLevel {
    /// Normal events.
    Info,
    /// Odd.
    Warning,
    /// A failure.
    Error,
}

/// Whether plans can run and whether one does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlanPhase {
    /// The vehicle cannot run plans.
    #[default]
    Blocked,
    /// It can.
    Ready,
    /// A plan was asked for and is on its way to its first maneuver.
    Initializing,
    /// A plan runs.
    Executing,
}

/// The state of plans, to be reported about three times per second.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanState {
    /// The state of the plan engine.
    pub phase: PlanPhase,
    /// The running plan, or the last one.
    pub plan_id: String,
    /// Number of the running plan.
    pub run: Option<RunId>,
    /// Time to its end (s), where that is known.
    pub plan_eta_s: Option<f64>,
    /// How much of it is done, 0 to 1, where that is known.
    pub progress: Option<f64>,
    /// The maneuver under way, and its kind.
    pub maneuver: Option<(String, ManeuverKind)>,
    /// Time to the end of the maneuver (s), where that is known.
    pub maneuver_eta_s: Option<f64>,
    /// How the last plan ended.
    pub last_outcome: LastOutcome,
}

/// The mode of the whole vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Mode {
    /// Entities are starting.
    #[default]
    Boot,
    /// Ready, doing nothing.
    Service,
    /// Calibrating before a plan.
    Calibration,
    /// An entity is in error, or the vessel was aborted.
    Error,
    /// A maneuver is under way.
    Maneuver,
}

/// The state of the vehicle, to be reported about twice per second.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VehicleState {
    /// Its mode.
    pub mode: Mode,
    /// Labels of the entities in error.
    pub errors: Vec<String>,
    /// The maneuver under way.
    pub maneuver: Option<ManeuverKind>,
    /// When it began.
    pub maneuver_began: Option<UtcTime>,
    /// Time to its end (s), where that is known.
    pub maneuver_eta_s: Option<f64>,
    /// Which control is on.
    pub drive: Drive,
    /// The maneuver is done and the next one not begun.
    pub maneuver_done: bool,
    /// The last error, and when.
    pub last_error: Option<(String, UtcTime)>,
}
