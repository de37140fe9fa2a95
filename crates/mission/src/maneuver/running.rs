//! The state machine of any maneuver.

use super::behaviour::{Behaviour, Context, Left};
use super::{
    Maneuver, follow_reference, follow_system, follow_trajectory, goto, idle, launch, loiter, scheduled_goto,
    station_keeping, teleoperation, waypoints,
};
use crate::event::Event;
use units::{MonoTime, Now};

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
