//! Where a maneuver leads, for checks, charts and statistics.

use super::{Maneuver, loiter};
use crate::place::Offset;
use units::{LatLon, LocalFrame};

impl Maneuver {
    /// The places it leads to, in order; empty for maneuvers that follow another system or stay where they are.
    ///
    /// The circles of a loiter are given as points around them; rows as laid out before any water is measured.
    pub fn places(&self) -> Vec<LatLon> {
        match self {
            Self::Goto(goto) => vec![goto.target],
            Self::Launch(launch) => vec![launch.target],
            Self::StationKeeping(station) => vec![station.centre],
            Self::ScheduledGoto(goto) => vec![goto.target],
            Self::Loiter(loiter) => loiter::outline(loiter),
            Self::FollowPath(path) => at(path.origin, path.points.iter().copied()),
            Self::FollowTrajectory(trajectory) => {
                at(trajectory.origin, trajectory.points.iter().map(|point| point.offset))
            }
            // The limits that `Plan::build` keeps bound these lists.
            Self::Rows(rows) => at(rows.origin, rows.points()),
            Self::RowsCoverage(rows) => at(rows.origin, rows.points()),
            Self::Idle(_) | Self::FollowReference(_) | Self::FollowSystem(_) | Self::Teleoperation(_) => {
                Vec::new()
            }
        }
    }
}

fn at(origin: LatLon, points: impl Iterator<Item = Offset>) -> Vec<LatLon> {
    let frame = LocalFrame::new(origin);
    points.map(|point| frame.to_place(point)).collect()
}
