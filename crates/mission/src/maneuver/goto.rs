//! Goto: one path to a place; done when near.

use super::behaviour::{Behaviour, Context, FailReason, Left};
use crate::checks::Checks;
use crate::command::{Path, PathStart};
use crate::event::Event;
use crate::place::RawPlace;
use units::Speed;
use units::{LatLon, LocalFrame, Now};

/// Go to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goto<P = LatLon> {
    /// Where to.
    pub target: P,
    /// How fast.
    pub speed: Speed,
}

impl Goto<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<Goto> {
        checks.speed(self.speed);
        Some(Goto { target: checks.place(self.target)?, speed: self.speed })
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    goto: Goto,
    left_m: Option<f64>,
}

impl Machine {
    pub(super) fn new(goto: Goto) -> Self {
        Self { goto, left_m: None }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.left_m = cx.fix.map(|fix| distance_m(fix.place, self.goto.target));
        cx.follow(path_to(self.goto.target, self.goto.speed));
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Path(progress) => {
                self.left_m = Some(progress.left_m.max(0.0));
                if progress.near {
                    cx.done();
                }
            }
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Fix(_)
            | Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn left(&self, _: Now) -> Option<Left> {
        self.left_m.map(|way_m| Left { way_m, wait_s: 0.0 })
    }
}

/// A plain path; its number is set where it is sent.
pub(super) fn path_to(end: LatLon, speed: Speed) -> Path {
    Path { path_ref: 0, start: PathStart::Chained, end, speed, circle: None }
}

/// Distance between two places (m).
pub(crate) fn distance_m(from: LatLon, to: LatLon) -> f64 {
    let frame = LocalFrame::new(from);
    frame.to_local(from).distance_m(frame.to_local(to))
}
