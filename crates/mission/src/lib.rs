//! Plans and maneuvers of an autonomous vessel: what to do next, and when to stop doing it.
//!
//! Everything is a pure state machine: inputs and their times come in, commands and replies go out. It knows the water
//! by [`guard`] only, and neither IMC nor motors; `onboard` translates both ways. SI units and radians throughout;
//! headings and bearings turn clockwise from north.
//!
//! - A [`PlanDraft`] is a plan as received, a [`Plan`] one that can be sailed; [`check_plan`] checks it against the chart.
//! - The [`Engine`] carries plans out, maneuver by maneuver; the [`PlanDatabase`] keeps them.
//! - Supervisors such as [`LostComms`], [`BatteryReserve`] and [`OperationalLimits`] say when to step in.

mod chart_check;
mod checks;
mod command;
mod database;
mod engine;
mod event;
mod kind;
mod maneuver;
mod place;
mod plan;
mod plan_limits;
mod problem;
mod speed;
mod statistics;
mod supervisor;
#[cfg(test)]
mod testing;

pub use chart_check::check_plan;
pub use command::{Circle, Command, Drive, Operator, Path, PathStart};
pub use database::{
    Answer, Change, DatabaseError, DatabaseLimits, DatabaseOperation, DatabaseQuery, DatabaseReply,
    DatabaseRequest, DatabaseState, Digest, Effect, Kept, Outgoing, PlanDatabase, PlanInfo, Record, Ticket,
};
pub use engine::{
    ActionPoint, EndReason, Engine, EngineConfig, EntityCondition, Failure, Input, LastOutcome, ManeuverEnd,
    Mode, NoPlan, Note, NoteLevel, Operation, Origin, Output, PlanPhase, PlanState, Reply, Request,
    RequestKind, RunId, StartOptions, Success, VehicleState,
};
pub use event::{Event, Fix, Medium, PathProgress, Reference, Sighting, Way};
pub use kind::ManeuverKind;
pub use maneuver::{
    FailReason, FollowPath, FollowReference, FollowReferenceConfig, FollowSystem, FollowSystemConfig,
    FollowTrajectory, Goto, Idle, Late, Launch, Left, Loiter, LoiterShape, Maneuver, ManeuverConfig,
    ReferencePhase, ReferenceState, Rows, RowsCoverage, RowsPoints, ScheduledGoto, ScheduledGotoConfig,
    StationKeeping, Swath, Teleoperation, TimedOffset, TrajectoryConfig,
};
pub use place::{Offset, RawPlace};
pub use plan::{DraftBody, DraftNote, ManeuverDraft, Node, PLAN_END, Plan, PlanDraft, TransitionDraft};
pub use plan_limits::PlanLimits;
pub use problem::{PlanProblem, PlanProblems, PlanWarning, ProblemKind};
pub use speed::SpeedLimits;
pub use statistics::{Cost, ModelError, ModelPoint, PlanStatistics, VehicleModel};
pub use supervisor::{
    Activity, BatteryConfig, BatteryOutput, BatteryReserve, BatteryStage, LimitsConfig, LimitsOutput,
    LostComms, LostCommsConfig, LostCommsInput, LostCommsOutput, OperationalLimits, Outlook, Remedy, Step,
    Violation,
};
