//! Checks of one maneuver's parameters: every problem is noted, none stops the others.

use crate::place::{Offset, RawPlace};
use crate::plan_limits::PlanLimits;
use crate::problem::{PlanProblem, ProblemKind};
use crate::speed::SpeedLimits;
use units::LatLon;
use units::Speed;

#[derive(Debug)]
pub(crate) struct Checks<'a> {
    limits: &'a PlanLimits,
    maneuver: &'a str,
    problems: &'a mut Vec<PlanProblem>,
    /// Problems there were before.
    before: usize,
}

impl<'a> Checks<'a> {
    pub(crate) fn new(limits: &'a PlanLimits, maneuver: &'a str, problems: &'a mut Vec<PlanProblem>) -> Self {
        let before = problems.len();
        Self { limits, maneuver, problems, before }
    }

    pub(crate) fn problem(&mut self, kind: ProblemKind) {
        self.problems.push(PlanProblem::of(self.maneuver, kind));
    }

    pub(crate) fn place(&mut self, raw: RawPlace) -> Option<LatLon> {
        if raw.lat_rad == 0.0 && raw.lon_rad == 0.0 {
            self.problem(ProblemKind::NullIsland);
            return None;
        }
        match LatLon::from_rad(raw.lat_rad, raw.lon_rad) {
            Ok(place) => Some(place),
            Err(error) => {
                self.problem(error.into());
                None
            }
        }
    }

    /// Whether no check of this maneuver has found a problem.
    pub(crate) fn are_passed(&self) -> bool {
        self.problems.len() == self.before
    }

    /// All places of the maneuver must lie in the area of operation.
    pub(crate) fn area(&mut self, places: &[LatLon]) {
        if let Some(area) = &self.limits.area {
            let outside_m = places.iter().map(|place| area.outside_m(*place)).fold(0.0, f64::max);
            if outside_m > 0.0 {
                self.problem(ProblemKind::OutsideArea(outside_m));
            }
        }
    }

    pub(crate) fn speed(&mut self, speed: Speed) {
        if !self.limits.speed.allows(speed) {
            self.problem(ProblemKind::Speed(speed));
        }
    }

    /// A speed that follows from a timetable.
    pub(crate) fn timed_speed(&mut self, mps: f64) {
        let speed = Speed::MetresPerSecond(mps);
        let limit_mps = self.limits.max_timed_mps.min(self.limits.speed.max_mps);
        if !(SpeedLimits { max_mps: limit_mps, ..self.limits.speed }).allows(speed) {
            self.problem(ProblemKind::Speed(speed));
        }
    }

    pub(crate) fn within(&mut self, what: &'static str, value: f64, min: f64, max: f64) {
        if !(min..=max).contains(&value) {
            self.problem(ProblemKind::Range { what, value, min, max });
        }
    }

    pub(crate) fn finite(&mut self, what: &'static str, value: f64) {
        self.within(what, value, f64::MIN, f64::MAX);
    }

    /// A length from `min_m` to the farthest offset.
    pub(crate) fn at_least(&mut self, what: &'static str, value_m: f64, min_m: f64) {
        self.within(what, value_m, min_m, self.limits.max_offset_m);
    }

    pub(crate) fn radius(&mut self, radius_m: f64) {
        self.within("radius", radius_m, 0.0, self.limits.max_radius_m);
    }

    pub(crate) fn offset(&mut self, offset: Offset) {
        let limit_m = self.limits.max_offset_m;
        self.within("offset north", offset.north_m, -limit_m, limit_m);
        self.within("offset east", offset.east_m, -limit_m, limit_m);
    }

    pub(crate) fn points(&mut self, count: usize) {
        let limit = self.limits.max_points;
        if count > limit {
            self.problem(ProblemKind::TooManyPoints { count, limit });
        }
    }

    pub(crate) fn depth(&mut self, depth_m: f64) {
        let limit_m = self.limits.max_depth_m;
        if depth_m.is_nan() || depth_m > limit_m {
            self.problem(ProblemKind::Depth { depth_m, limit_m });
        }
    }
}
