//! Loiter: circles a place, or sails a figure of eight around it, for a while.
//!
//! The figure of eight is two circles, the first turned clockwise, whose centres lie on the bearing, `length`
//! apart (at least two radii). A circle is left for the other when, having been on its outer side, the vessel
//! comes abeam of its centre: it then heads across to the other circle, which turns the other way.

use super::behaviour::{Behaviour, Context, FailReason, Left, wait_left_s};
use super::goto::{distance_m, path_to};
use crate::checks::Checks;
use crate::command::{Circle, Path, PathStart};
use crate::event::{Event, Fix, PathProgress};
use crate::place::RawPlace;
use std::f64::consts::{FRAC_PI_4, PI};
use std::time::Duration;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now, Turn};

/// Circle a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loiter<P = LatLon> {
    /// Around where.
    pub centre: P,
    /// Radius of the circle (m), or of each circle of an eight.
    pub radius_m: f64,
    /// How fast.
    pub speed: Speed,
    /// How long on the circle; `None` until stopped.
    pub duration: Option<Duration>,
    /// The shape to sail.
    pub shape: LoiterShape,
}

/// The shape of a loiter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoiterShape {
    /// A circle.
    Circle(Turn),
    /// Two circles in turn, the first clockwise.
    Eight {
        /// Distance between the centres (m).
        length_m: f64,
        /// Direction from the first centre to the second (rad).
        bearing_rad: f64,
    },
    /// Some shape that is not sailed here (race track, hover): a circle takes its place and the plan warns.
    Other(Turn),
}

impl Loiter<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<Loiter> {
        checks.speed(self.speed);
        checks.radius(self.radius_m);
        if let LoiterShape::Eight { length_m, bearing_rad } = self.shape {
            checks.at_least("length", length_m, 0.0);
            checks.finite("bearing", bearing_rad);
        }
        let Self { radius_m, speed, duration, shape, .. } = *self;
        Some(Loiter { centre: checks.place(self.centre)?, radius_m, speed, duration, shape })
    }
}

/// Eight points on each circle.
pub(super) fn outline(loiter: &Loiter) -> Vec<LatLon> {
    let mut machine = Machine::new(*loiter);
    let mut places = Vec::new();
    for second in [false, true] {
        machine.second = second;
        let (centre, _, outward) = machine.circle(loiter.radius_m);
        let frame = LocalFrame::new(centre);
        let bearings_rad = (0..8).map(|eighth| f64::from(eighth) * FRAC_PI_4);
        places.extend(bearings_rad.map(|bearing_rad| {
            frame.to_place(LocalPoint::default().displaced(bearing_rad, loiter.radius_m))
        }));
        if outward.is_none() {
            break;
        }
    }
    places
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    loiter: Loiter,
    /// Whether the second circle of an eight is on.
    second: bool,
    /// Whether the vessel has been on the outer side of the circle under way.
    outer: bool,
    loitering: bool,
    since: Option<MonoTime>,
    left_m: Option<f64>,
}

impl Machine {
    pub(super) fn new(loiter: Loiter) -> Self {
        Self { loiter, second: false, outer: false, loitering: false, since: None, left_m: None }
    }

    /// Centre and sense of the circle under way, and the direction away from the other circle, if any.
    fn circle(&self, radius_m: f64) -> (LatLon, Turn, Option<f64>) {
        match self.loiter.shape {
            LoiterShape::Circle(turn) | LoiterShape::Other(turn) => (self.loiter.centre, turn, None),
            LoiterShape::Eight { length_m, bearing_rad } => {
                let outward_rad = if self.second { bearing_rad } else { bearing_rad + PI };
                let offset = LocalPoint::default().displaced(outward_rad, length_m.max(2.0 * radius_m) / 2.0);
                let centre = LocalFrame::new(self.loiter.centre).to_place(offset);
                let turn = if self.second { Turn::CounterClockwise } else { Turn::Clockwise };
                (centre, turn, Some(outward_rad))
            }
        }
    }

    fn sail(&mut self, cx: &mut Context<'_>, start: PathStart) {
        let radius_m = self.loiter.radius_m.max(cx.config.loiter_min_radius_m);
        let (centre, turn, _) = self.circle(radius_m);
        (self.outer, self.loitering) = (false, false);
        let circle = Some(Circle { radius_m, turn });
        cx.follow(Path { start, circle, ..path_to(centre, self.loiter.speed) });
    }

    fn progress(&mut self, cx: &mut Context<'_>, progress: &PathProgress) {
        self.loitering = progress.loitering;
        self.left_m = Some(progress.left_m.max(0.0));
        if progress.loitering {
            self.since.get_or_insert(cx.now.mono);
        }
    }

    fn fix(&mut self, cx: &mut Context<'_>, fix: &Fix) {
        let (centre, _, outward) = self.circle(self.loiter.radius_m.max(cx.config.loiter_min_radius_m));
        if let (Some(outward_rad), true) = (outward, self.loitering) {
            let frame = LocalFrame::new(centre);
            let here = frame.to_local(fix.place);
            let outer = here.north_m * outward_rad.cos() + here.east_m * outward_rad.sin() > 0.0;
            if self.outer && !outer {
                self.second = !self.second;
                self.sail(cx, PathStart::Here);
            } else {
                self.outer |= outer;
            }
        }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.left_m = cx.fix.map(|fix| distance_m(fix.place, self.loiter.centre));
        self.sail(cx, PathStart::Chained);
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Fix(fix) => self.fix(cx, fix),
            Event::Path(progress) => self.progress(cx, progress),
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn timeout(&mut self, cx: &mut Context<'_>) {
        cx.done();
    }

    fn deadline(&self) -> Option<MonoTime> {
        Some(self.since? + self.loiter.duration?)
    }

    fn left(&self, now: Now) -> Option<Left> {
        let wait_s = wait_left_s(self.loiter.duration, self.since, now)?;
        let way_m = if self.since.is_some() { 0.0 } else { self.left_m? };
        Some(Left { way_m, wait_s })
    }
}
