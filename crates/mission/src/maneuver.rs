//! The maneuvers a plan is made of: their parameters and, one file each, their behaviour.
//!
//! Parameters come as drafts with raw places (`Goto<RawPlace>`) and leave [`Plan::build`](crate::Plan::build)
//! checked (`Goto<LatLon>`). Behaviours are small state machines: events in, [`Command`](crate::Command)s out.
//! Depths play no part: the vessel stays on the surface.

mod behaviour;
mod detour;
mod drift;
mod follow_path;
mod follow_reference;
mod follow_system;
mod follow_trajectory;
mod goto;
mod idle;
mod launch;
mod loiter;
mod places;
mod reference_state;
mod reported;
mod rows;
mod rows_coverage;
mod running;
mod scheduled_goto;
mod search;
mod station_keeping;
mod teleoperation;
mod waypoints;

pub(crate) use behaviour::{Context, Outcome, Signal};
pub use behaviour::{FailReason, Left};
pub use follow_path::FollowPath;
pub use follow_reference::{FollowReference, FollowReferenceConfig};
pub use follow_system::{FollowSystem, FollowSystemConfig};
pub use follow_trajectory::{FollowTrajectory, TimedOffset, TrajectoryConfig};
pub use goto::Goto;
pub(crate) use goto::distance_m;
pub use idle::Idle;
pub use launch::Launch;
pub use loiter::{Loiter, LoiterShape};
pub use reference_state::{ReferencePhase, ReferenceState};
pub use rows::{Rows, RowsPoints};
pub use rows_coverage::{RowsCoverage, Swath};
pub(crate) use running::Running;
pub use scheduled_goto::{Late, ScheduledGoto, ScheduledGotoConfig};
pub use station_keeping::StationKeeping;
pub use teleoperation::Teleoperation;

use crate::kind::ManeuverKind;
use crate::speed::SpeedLimits;
use std::time::Duration;
use units::LatLon;

/// A maneuver with its parameters, places being of type `P`.
#[derive(Debug, Clone, PartialEq)]
pub enum Maneuver<P = LatLon> {
    /// Go to a place.
    Goto(Goto<P>),
    /// Wait for the water, then go to a place.
    Launch(Launch<P>),
    /// Circle a place.
    Loiter(Loiter<P>),
    /// Drift near a place.
    StationKeeping(StationKeeping<P>),
    /// Go along points.
    FollowPath(FollowPath<P>),
    /// Go along points by a timetable.
    FollowTrajectory(FollowTrajectory<P>),
    /// Sweep an area in parallel lines.
    Rows(Rows<P>),
    /// Sweep an area for a sensor's swath.
    RowsCoverage(RowsCoverage<P>),
    /// Drift.
    Idle(Idle),
    /// Be at a place at a time.
    ScheduledGoto(ScheduledGoto<P>),
    /// Do as a commander says.
    FollowReference(FollowReference),
    /// Keep beside another system.
    FollowSystem(FollowSystem),
    /// Let an operator steer.
    Teleoperation(Teleoperation),
}

impl<P> Maneuver<P> {
    /// Which maneuver this is.
    pub fn kind(&self) -> ManeuverKind {
        match self {
            Self::Goto(_) => ManeuverKind::Goto,
            Self::Launch(_) => ManeuverKind::Launch,
            Self::Loiter(_) => ManeuverKind::Loiter,
            Self::StationKeeping(_) => ManeuverKind::StationKeeping,
            Self::FollowPath(_) => ManeuverKind::FollowPath,
            Self::FollowTrajectory(_) => ManeuverKind::FollowTrajectory,
            Self::Rows(_) => ManeuverKind::Rows,
            Self::RowsCoverage(_) => ManeuverKind::RowsCoverage,
            Self::Idle(_) => ManeuverKind::Idle,
            Self::ScheduledGoto(_) => ManeuverKind::ScheduledGoto,
            Self::FollowReference(_) => ManeuverKind::FollowReference,
            Self::FollowSystem(_) => ManeuverKind::FollowSystem,
            Self::Teleoperation(_) => ManeuverKind::Teleoperation,
        }
    }
}

/// Parameters of the behaviours; the vessel's, not the plan's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManeuverConfig {
    /// Commanders get no more than these speeds.
    pub speed: SpeedLimits,
    /// Least radius of a loiter circle (m); smaller ones are widened.
    pub loiter_min_radius_m: f64,
    /// Least radius of station keeping (m); smaller ones are widened.
    pub station_min_radius_m: f64,
    /// A fix older than this no longer gives the vessel's place.
    pub fix_max_age: Duration,
    /// No report of the path under way for this long fails the maneuver.
    pub path_silence: Duration,
    /// For [`FollowTrajectory`].
    pub trajectory: TrajectoryConfig,
    /// For [`ScheduledGoto`].
    pub scheduled: ScheduledGotoConfig,
    /// For [`FollowReference`].
    pub reference: FollowReferenceConfig,
    /// For [`FollowSystem`].
    pub system: FollowSystemConfig,
}

impl Default for ManeuverConfig {
    /// As the original has them, with the least radii of its otter configuration.
    fn default() -> Self {
        Self {
            speed: SpeedLimits::default(),
            loiter_min_radius_m: 1.0,
            station_min_radius_m: 2.0,
            fix_max_age: Duration::from_secs(2),
            path_silence: Duration::from_secs(10),
            trajectory: TrajectoryConfig::default(),
            scheduled: ScheduledGotoConfig::default(),
            reference: FollowReferenceConfig::default(),
            system: FollowSystemConfig::default(),
        }
    }
}

#[cfg(test)]
mod tests;
