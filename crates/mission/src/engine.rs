//! The plan engine and the vehicle's modes.

mod request;
mod state;

pub use request::{
    Ask, EndReason, Failure, LastOutcome, NoPlan, Operation, Origin, Reply, Request, RunId, StartOptions,
    Success,
};
pub use state::{
    ActionPoint, ManeuverEnd, Mode, Note, NoteLevel, Output, PlanPhase, PlanState, VehicleState,
};

use crate::event::Event;
use std::collections::BTreeMap;

/// What the engine is told.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// Somebody asks something about plans.
    Request(Request),
    /// Something the active maneuver may care about.
    Event(Event),
    /// The conditions of all monitored entities, by label; in place of what was told before.
    Entities(BTreeMap<String, EntityCondition>),
    /// Somebody orders everything to stop.
    Abort {
        /// Who.
        by: u16,
    },
    /// Which loops somebody outside has on.
    ExternalLoops(ExternalLoops),
}

/// Condition of an entity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EntityCondition {
    /// Starting.
    Boot,
    /// Well.
    Normal,
    /// In a fault, an error or a failure; all count alike.
    Error,
}

/// Control loops that somebody other than the engine has on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExternalLoops {
    /// None.
    #[default]
    Off,
    /// Some.
    On,
    /// Some that entity errors must not override.
    NoOverride,
}
