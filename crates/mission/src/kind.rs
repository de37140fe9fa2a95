//! The kinds of maneuvers.

use std::fmt;

/// Which maneuver, without its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are those of `Maneuver`")]
pub enum ManeuverKind {
    Goto,
    Launch,
    Loiter,
    StationKeeping,
    FollowPath,
    FollowTrajectory,
    Rows,
    RowsCoverage,
    Idle,
    ScheduledGoto,
    FollowReference,
    FollowSystem,
    Teleoperation,
}

impl fmt::Display for ManeuverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}
