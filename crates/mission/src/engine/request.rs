//! Requests to the plan engine and its replies.
//!
//! One start is answered several times, all with its [`Origin`]: when the plan is loaded (with statistics),
//! when its first maneuver is commanded (not after a calibration), and when it ends, perhaps minutes later.
//! A client reads the running state from [`PlanState`](super::PlanState), not from replies.

use crate::maneuver::FailReason;
use crate::plan::Plan;
use crate::problem::PlanProblems;
use crate::statistics::PlanStatistics;
use thiserror::Error;

/// The requester, and its request number; carried through to every reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Origin {
    /// Address of the requester.
    pub system: u16,
    /// Entity of the requester.
    pub entity: u8,
    /// The requester's number.
    pub request: u16,
}

/// A request to the plan engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The requester.
    pub origin: Origin,
    /// Name of the plan it concerns; may be empty for a stop or get.
    pub plan_id: String,
    /// The request.
    pub ask: RequestKind,
}

/// A request to the plan engine.
#[derive(Debug, Clone, PartialEq)]
pub enum RequestKind {
    /// Run a plan, in place of the running one if any.
    Start {
        /// The plan, as found in the request or in the database, or why none was found.
        plan: Result<Box<Plan>, NoPlan>,
        /// How to run it.
        options: StartOptions,
    },
    /// End the running plan.
    Stop,
    /// Check a plan and report its statistics; nothing moves.
    Load {
        /// The plan, or why none was found.
        plan: Result<Box<Plan>, NoPlan>,
    },
    /// Report which plan runs.
    Get,
}

/// How to run a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StartOptions {
    /// Calibrate before the first maneuver (flag 1).
    pub calibrate: bool,
    /// Run on in spite of errors of entities that are not vital (flag 2).
    pub ignore_errors: bool,
}

/// Why a request comes without a plan.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoPlan {
    /// No plan of that name is stored.
    #[error("undefined plan")]
    Undefined,
    /// The plan is not possible.
    #[error("parse error: {0}")]
    Problems(#[from] PlanProblems),
    /// A condition for arming the motors is not met.
    #[error("the motors are not armed: {0}")]
    NotArmed(String),
    /// It leads where the chart has no water for it.
    #[error("refused by the sea chart: {0}")]
    Grounding(String),
    /// The plan could not even be read.
    #[error("parse error: {0}")]
    Unreadable(String),
}

/// The request, for the reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// [`RequestKind::Start`].
    Start,
    /// [`RequestKind::Stop`].
    Stop,
    /// [`RequestKind::Load`].
    Load,
    /// [`RequestKind::Get`].
    Get,
}

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    /// The receiver.
    pub origin: Origin,
    /// The request.
    pub operation: Operation,
    /// Which plan.
    pub plan_id: String,
    /// The result.
    pub result: Result<Success, Failure>,
}

/// A success.
#[derive(Debug, Clone, PartialEq)]
pub enum Success {
    /// The plan is loaded (start and load).
    Loaded(Box<PlanStatistics>),
    /// The first maneuver is commanded (start).
    Executing {
        /// Its name.
        maneuver: String,
    },
    /// The plan is over (start).
    Completed,
    /// The plan was stopped (stop).
    Stopped,
    /// This plan runs (get); the caller holds its specification under this number.
    Running(RunId),
}

impl std::fmt::Display for Success {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Loaded(_) => f.write_str("plan loaded"),
            Self::Executing { maneuver } => write!(f, "{maneuver}: executing maneuver"),
            Self::Completed => f.write_str("plan completed"),
            Self::Stopped | Self::Running(_) => f.write_str("OK"),
        }
    }
}

/// A failure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Failure {
    /// There is no plan to run or load.
    #[error("{0}")]
    NoPlan(#[from] NoPlan),
    /// The vehicle cannot run plans for the time being.
    #[error("vehicle is blocked: {0}")]
    Blocked(String),
    /// No plan can be loaded while one runs.
    #[error("cannot load while a plan is running")]
    Busy,
    /// No plan runs that could be stopped.
    #[error("no plan is running, request ignored")]
    NothingToStop,
    /// No plan runs that could be reported.
    #[error("no plan is running")]
    NothingRuns,
    /// The plan that this request had started ended badly.
    #[error("{0}")]
    Ended(EndReason),
}

/// Number of a start; it only grows. The caller keeps specification and actions of a run under it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct RunId(pub u32);

/// Why a plan ended. Every started plan ends once, by one of these.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EndReason {
    /// Its last maneuver is done.
    #[error("plan completed")]
    Completed,
    /// A system stopped it.
    #[error("plan stopped")]
    Stopped,
    /// Another plan was started.
    #[error("replaced by another plan")]
    Replaced,
    /// A maneuver failed.
    #[error("{maneuver}: maneuver error: {reason}")]
    Maneuver {
        /// Its name.
        maneuver: String,
        /// Why it failed.
        reason: FailReason,
    },
    /// An entity is in error.
    #[error("entity error: {0}")]
    Entities(String),
    /// The vessel did not know where it was for too long.
    #[error("the position was lost for too long")]
    PositionLost,
    /// The system of this address aborted.
    #[error("stopped by {0:#06x}")]
    Aborted(u16),
    /// Its maneuvers follow each other without ever taking time.
    #[error("maneuvers follow each other in a circle without taking time")]
    EmptyCycle,
}

impl EndReason {
    /// The `last_outcome` that it gives: only completion is a success.
    pub fn outcome(&self) -> LastOutcome {
        match self {
            Self::Completed => LastOutcome::Success,
            Self::Stopped
            | Self::Replaced
            | Self::Maneuver { .. }
            | Self::Entities(_)
            | Self::PositionLost
            | Self::Aborted(_)
            | Self::EmptyCycle => LastOutcome::Failure,
        }
    }

    /// Whether it ended by a fault, not by completion or order.
    pub fn is_failure(&self) -> bool {
        match self {
            Self::Completed | Self::Stopped | Self::Replaced | Self::Aborted(_) => false,
            Self::Maneuver { .. } | Self::Entities(_) | Self::PositionLost | Self::EmptyCycle => true,
        }
    }
}

/// How the last plan ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LastOutcome {
    /// None has ended.
    #[default]
    None,
    /// It completed.
    Success,
    /// It did not.
    Failure,
}
