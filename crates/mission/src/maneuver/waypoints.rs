//! The machine of maneuvers that go from point to point: FollowPath, Rows and RowsCoverage.

use super::behaviour::{Behaviour, Context, FailReason, Left};
use super::goto::path_to;
use super::rows_coverage::Swath;
use super::{FollowPath, Rows, RowsCoverage, RowsPoints};
use crate::event::Event;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, Now};

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    frame: LocalFrame,
    speed: Speed,
    points: Points,
    target: Option<LocalPoint>,
    /// Way along the points not yet begun (m).
    rest_m: f64,
    /// Way to the point under way (m).
    leg_m: Option<f64>,
}

#[derive(Debug, Clone)]
enum Points {
    List(std::vec::IntoIter<LocalPoint>),
    Rows(RowsPoints),
    Coverage(RowsPoints, Swath),
}

impl Machine {
    pub(super) fn along(path: &FollowPath) -> Self {
        Self::new(path.origin, path.speed, Points::List(path.points.clone().into_iter()))
    }

    pub(super) fn rows(rows: &Rows) -> Self {
        Self::new(rows.origin, rows.speed, Points::Rows(rows.points()))
    }

    pub(super) fn coverage(rows: &RowsCoverage) -> Self {
        let points = Points::Coverage(rows.points(), rows.swath);
        Self::new(rows.origin, rows.speed, points)
    }

    fn new(origin: LatLon, speed: Speed, points: Points) -> Self {
        let frame = LocalFrame::new(origin);
        let mut machine = Self { frame, speed, points, target: None, rest_m: 0.0, leg_m: None };
        machine.rest_m = machine.way_ahead_m();
        machine
    }

    /// Way from the next point over all further ones (m).
    fn way_ahead_m(&self) -> f64 {
        match &self.points {
            Points::List(points) => length_m(points.as_slice().iter().copied()),
            Points::Rows(points) | Points::Coverage(points, _) => length_m(points.clone()),
        }
    }

    fn next_point(&mut self, cx: &mut Context<'_>) {
        let next = match &mut self.points {
            Points::List(points) => points.next(),
            Points::Rows(points) => points.next(),
            Points::Coverage(points, swath) => {
                points.scale_step(swath.step_scale(cx.fix.and_then(|fix| fix.water_below_m)));
                points.next()
            }
        };
        let Some(point) = next else {
            cx.done();
            return;
        };
        let from = self.target.or_else(|| cx.fix.map(|fix| self.frame.to_local(fix.place)));
        self.leg_m = from.map(|from| from.distance_m(point));
        self.target = Some(point);
        self.rest_m = self.way_ahead_m() + self.first_ahead().map_or(0.0, |ahead| point.distance_m(ahead));
        cx.follow(path_to(self.frame.to_place(point), self.speed));
    }

    fn first_ahead(&self) -> Option<LocalPoint> {
        match &self.points {
            Points::List(points) => points.as_slice().first().copied(),
            Points::Rows(points) | Points::Coverage(points, _) => points.clone().next(),
        }
    }
}

/// Length of the way over `points` (m).
pub(crate) fn length_m(points: impl Iterator<Item = LocalPoint>) -> f64 {
    let mut last: Option<LocalPoint> = None;
    points.fold(0.0, |sum, point| sum + last.replace(point).map_or(0.0, |last| last.distance_m(point)))
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.next_point(cx);
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Path(progress) if progress.near => self.next_point(cx),
            Event::Path(progress) => self.leg_m = Some(progress.left_m.max(0.0)),
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
        Some(Left { way_m: self.rest_m + self.leg_m?, wait_s: 0.0 })
    }
}
