//! Follow trajectory: goes to the first point, then along the others by their times.
//!
//! The timetable begins at the arrival at the first point. A leg begins when the point before is near; its
//! speed is its length by its time, and when the vessel is late or early by more than the tolerance, by the
//! time really left.

use super::behaviour::{Behaviour, Context, FailReason, Left};
use super::goto::path_to;
use crate::checks::Checks;
use crate::event::Event;
use crate::place::RawPlace;
use crate::problem::ProblemKind;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now};

/// Go along points by a timetable.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowTrajectory<P = LatLon> {
    /// The origin of the points' offsets.
    pub origin: P,
    /// The points, the first at time 0.
    pub points: Vec<TimedOffset>,
    /// How fast to go to the first point.
    pub speed: Speed,
}

/// An offset and when to be there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedOffset {
    /// Metres north and east of the origin.
    pub offset: LocalPoint,
    /// Time after the first point (s).
    pub time_s: f64,
}

/// Parameters of the behaviour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryConfig {
    /// Being this late or early changes no speed (s).
    pub tolerance_s: f64,
    /// A correction asks for no less (m/s), unless the plan itself is slower.
    pub corrected_min_mps: f64,
    /// A correction asks for no more (m/s), unless the plan itself is faster.
    pub corrected_max_mps: f64,
}

impl Default for TrajectoryConfig {
    fn default() -> Self {
        Self { tolerance_s: 2.0, corrected_min_mps: 1.0, corrected_max_mps: 2.0 }
    }
}

impl FollowTrajectory<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<FollowTrajectory> {
        checks.speed(self.speed);
        checks.points(self.points.len());
        self.points.iter().for_each(|point| checks.offset(point.offset));
        if self.points.first().is_some_and(|first| first.time_s != 0.0) {
            checks.problem(ProblemKind::Timetable { point: 0 });
        }
        for (index, leg) in self.points.windows(2).enumerate() {
            let [from, to] = leg else { continue };
            let time_s = to.time_s - from.time_s;
            if !(time_s > 0.0 && time_s.is_finite()) {
                checks.problem(ProblemKind::Timetable { point: index + 1 });
            } else if from.offset != to.offset {
                checks.timed_speed(from.offset.distance_m(to.offset) / time_s);
            }
        }
        let origin = checks.place(self.origin)?;
        Some(FollowTrajectory { origin, points: self.points.clone(), speed: self.speed })
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    frame: LocalFrame,
    points: Vec<TimedOffset>,
    speed: Speed,
    /// Index of the point under way.
    next: usize,
    /// When the first point was near.
    began: Option<MonoTime>,
    approach_m: Option<f64>,
}

impl Machine {
    pub(super) fn new(trajectory: &FollowTrajectory) -> Self {
        Self {
            frame: LocalFrame::new(trajectory.origin),
            points: trajectory.points.clone(),
            speed: trajectory.speed,
            next: 0,
            began: None,
            approach_m: None,
        }
    }

    fn go(&mut self, cx: &mut Context<'_>) {
        let Some(point) = self.points.get(self.next).copied() else {
            cx.done();
            return;
        };
        let before = self.next.checked_sub(1).and_then(|before| self.points.get(before).copied());
        let speed = before.map_or(self.speed, |before| self.leg_speed(cx, before, point));
        cx.follow(path_to(self.frame.to_place(point.offset), speed));
    }

    fn leg_speed(&self, cx: &Context<'_>, before: TimedOffset, point: TimedOffset) -> Speed {
        let config = &cx.config.trajectory;
        let (length_m, time_s) = (before.offset.distance_m(point.offset), point.time_s - before.time_s);
        let planned_mps = length_m / time_s;
        let gone_s = self.began.map_or(0.0, |began| cx.now.mono.since(began).as_secs_f64());
        let delay_s = gone_s - before.time_s;
        // Two points in one place leave no speed to go by; the slowest is good enough to wait for the next.
        let mps = if delay_s.abs() <= config.tolerance_s {
            planned_mps
        } else {
            let left_s = (time_s - delay_s).max(1e-3);
            let least_mps = config.corrected_min_mps.min(planned_mps);
            (length_m / left_s).clamp(least_mps, config.corrected_max_mps.max(planned_mps))
        };
        Speed::MetresPerSecond(if mps > 0.0 { mps } else { config.corrected_min_mps })
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        if let (Some(fix), Some(first)) = (cx.fix, self.points.first()) {
            self.approach_m = Some(self.frame.to_local(fix.place).distance_m(first.offset));
        }
        self.go(cx);
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Path(progress) if progress.near => {
                self.began.get_or_insert(cx.now.mono);
                self.next += 1;
                self.go(cx);
            }
            Event::Path(progress) if self.began.is_none() => {
                self.approach_m = Some(progress.left_m.max(0.0));
            }
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Path(_)
            | Event::Fix(_)
            | Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn left(&self, now: Now) -> Option<Left> {
        let total_s = self.points.last()?.time_s;
        match self.began {
            Some(began) => {
                let wait_s = (total_s - now.mono.since(began).as_secs_f64()).max(0.0);
                Some(Left { way_m: 0.0, wait_s })
            }
            None => Some(Left { way_m: self.approach_m?, wait_s: total_s }),
        }
    }
}
