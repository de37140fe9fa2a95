//! Length, duration and energy of a plan, estimated before it starts.
//!
//! Legs are flat and straight and sailed at the planned speed; what the sea adds shows in the progress
//! ([`Progress`]), not here. What cannot be known (an operator's way, a loiter without end) is absent and makes
//! the totals absent.

mod model;
mod progress;

pub use model::{ModelError, ModelPoint, VehicleModel};
pub(crate) use progress::{Progress, Standing};

use crate::maneuver::{LoiterShape, Maneuver, distance_m};
use crate::plan::Plan;
use std::time::Duration;
use units::Speed;
use units::{LatLon, Now};

/// The duration, length and energy of a plan, as far as known before it starts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanStatistics {
    /// Name of the plan.
    pub plan_id: String,
    /// All maneuvers together; a cyclic plan has no total.
    pub total: Cost,
    /// By maneuver, in the order they are sailed.
    pub maneuvers: Vec<(String, Cost)>,
}

/// The duration, length and energy of a plan or maneuver; unknown values are absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Way (m).
    pub length_m: Option<f64>,
    /// Time (s).
    pub duration_s: Option<f64>,
    /// Energy from the battery (J).
    pub energy_j: Option<f64>,
}

/// The needs of a maneuver, its time split into making way and waiting.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Span {
    length_m: f64,
    pub(crate) moving_s: f64,
    pub(crate) waiting_s: f64,
    energy_j: f64,
}

impl Span {
    fn moving(length_m: f64, mps: f64, model: &VehicleModel) -> Self {
        // A model may know no speed for a small percentage; such a way takes for ever, nearly.
        let moving_s = length_m / mps.max(1e-3);
        Self { length_m, moving_s, waiting_s: 0.0, energy_j: moving_s * model.power_w(mps) }
    }

    fn waiting(waiting_s: f64, model: &VehicleModel) -> Self {
        Self { waiting_s, energy_j: waiting_s * model.power_w(0.0), ..Self::default() }
    }

    fn and(self, other: Self) -> Self {
        Self {
            length_m: self.length_m + other.length_m,
            moving_s: self.moving_s + other.moving_s,
            waiting_s: self.waiting_s + other.waiting_s,
            energy_j: self.energy_j + other.energy_j,
        }
    }

    pub(crate) fn duration_s(&self) -> f64 {
        self.moving_s + self.waiting_s
    }

    fn cost(&self) -> Cost {
        Cost {
            length_m: Some(self.length_m),
            duration_s: Some(self.duration_s()),
            energy_j: Some(self.energy_j),
        }
    }
}

impl PlanStatistics {
    /// Of a plan that starts at `from`, if that is known, at `now`.
    pub fn of(plan: &Plan, from: Option<LatLon>, now: Now, model: &VehicleModel) -> Self {
        let spans = spans(plan, from, now, model);
        let named = spans.iter().filter_map(|(index, span)| {
            let cost = span.map_or_else(Cost::default, |span| span.cost());
            Some((plan.node(*index)?.id().to_owned(), cost))
        });
        let whole = if plan.is_cyclic() { None } else { sum(&spans) };
        Self {
            plan_id: plan.id().to_owned(),
            total: whole.map_or_else(Cost::default, |span| span.cost()),
            maneuvers: named.collect(),
        }
    }
}

fn sum(spans: &[(usize, Option<Span>)]) -> Option<Span> {
    spans.iter().try_fold(Span::default(), |sum, (_, span)| Some(sum.and((*span)?)))
}

/// The needs of each maneuver, in the order they are sailed, by its index.
pub(crate) fn spans(
    plan: &Plan,
    from: Option<LatLon>,
    now: Now,
    model: &VehicleModel,
) -> Vec<(usize, Option<Span>)> {
    let mut here = from;
    let mut gone_s = Some(0.0);
    let mut spans = Vec::new();
    for index in plan.order() {
        let Some(node) = plan.node(index) else { continue };
        let maneuver = node.maneuver();
        // An arrival by the clock depends on when its turn comes.
        let gone = Duration::try_from_secs_f64(gone_s.unwrap_or(0.0)).unwrap_or(Duration::MAX);
        let span = span(maneuver, here, now, gone, model);
        gone_s = gone_s.zip(span).map(|(gone_s, span)| gone_s + span.duration_s());
        here = end(maneuver, here);
        spans.push((index, span));
    }
    spans
}

/// Where a maneuver leaves the vessel.
fn end(maneuver: &Maneuver, from: Option<LatLon>) -> Option<LatLon> {
    match maneuver {
        Maneuver::Idle(_) => from,
        Maneuver::FollowReference(_) | Maneuver::FollowSystem(_) | Maneuver::Teleoperation(_) => None,
        Maneuver::Loiter(loiter) => Some(loiter.centre),
        Maneuver::FollowPath(_)
        | Maneuver::FollowTrajectory(_)
        | Maneuver::Goto(_)
        | Maneuver::Launch(_)
        | Maneuver::Rows(_)
        | Maneuver::RowsCoverage(_)
        | Maneuver::ScheduledGoto(_)
        | Maneuver::StationKeeping(_) => maneuver.places().last().copied().or(from),
    }
}

fn span(
    maneuver: &Maneuver,
    from: Option<LatLon>,
    now: Now,
    gone: Duration,
    model: &VehicleModel,
) -> Option<Span> {
    let way = |speed: Speed| -> Option<Span> {
        let way_m = way_m(from, &maneuver.places())?;
        Some(Span::moving(way_m, model.mps(speed), model))
    };
    match maneuver {
        Maneuver::Goto(goto) => way(goto.speed),
        Maneuver::Launch(launch) => way(launch.speed),
        Maneuver::FollowPath(path) => way(path.speed),
        Maneuver::Rows(rows) => way(rows.speed),
        Maneuver::RowsCoverage(rows) => way(rows.speed),
        Maneuver::StationKeeping(station) => {
            Some(way(station.speed)?.and(Span::waiting(station.duration?.as_secs_f64(), model)))
        }
        Maneuver::Idle(idle) => Some(Span::waiting(idle.duration?.as_secs_f64(), model)),
        Maneuver::Loiter(loiter) => {
            let mps = model.mps(loiter.speed);
            let lead_m = match loiter.shape {
                LoiterShape::Circle(_) | LoiterShape::Other(_) => loiter.radius_m,
                LoiterShape::Eight { .. } => 0.0,
            };
            let approach_m = (way_m(from, &[loiter.centre])? - lead_m).abs();
            let circling_s = loiter.duration?.as_secs_f64();
            let circling = Span {
                length_m: circling_s * mps,
                moving_s: 0.0,
                waiting_s: circling_s,
                energy_j: circling_s * model.power_w(mps),
            };
            Some(Span::moving(approach_m, mps, model).and(circling))
        }
        Maneuver::FollowTrajectory(trajectory) => {
            let places = maneuver.places();
            let approach_m = way_m(from, places.get(..1).unwrap_or_default())?;
            let approach = Span::moving(approach_m, model.mps(trajectory.speed), model);
            let time_s = trajectory.points.last().map_or(0.0, |last| last.time_s);
            let way_m = way_m(None, &places)?;
            let mps = if time_s > 0.0 { way_m / time_s } else { 0.0 };
            let energy_j = time_s * model.power_w(mps);
            Some(approach.and(Span { length_m: way_m, moving_s: 0.0, waiting_s: time_s, energy_j }))
        }
        Maneuver::ScheduledGoto(goto) => {
            let length_m = way_m(from, &[goto.target])?;
            let left_s = (goto.arrival - now.utc) as f64 / 1e6 - gone.as_secs_f64();
            let moving = Span::moving(length_m, length_m / left_s.max(1.0), model);
            Some(Span { moving_s: 0.0, waiting_s: left_s.max(0.0), ..moving })
        }
        Maneuver::FollowReference(_) | Maneuver::FollowSystem(_) | Maneuver::Teleoperation(_) => None,
    }
}

/// Way from `from`, if given, over `places` (m); unknown when it starts nowhere.
fn way_m(from: Option<LatLon>, places: &[LatLon]) -> Option<f64> {
    let legs_m: f64 = places.windows(2).map(|leg| distance_m(leg[0], leg[1])).sum();
    match (from, places) {
        (_, []) => Some(0.0),
        (Some(from), [first, ..]) => Some(distance_m(from, *first) + legs_m),
        (None, [_, _, ..]) => Some(legs_m),
        (None, [_]) => None,
    }
}

/// The speed a maneuver makes way with (m/s); for those that have none, something above 0.
pub(crate) fn planned_mps(maneuver: &Maneuver, model: &VehicleModel) -> f64 {
    let speed = match maneuver {
        Maneuver::Goto(goto) => goto.speed,
        Maneuver::Launch(launch) => launch.speed,
        Maneuver::Loiter(loiter) => loiter.speed,
        Maneuver::StationKeeping(station) => station.speed,
        Maneuver::FollowPath(path) => path.speed,
        Maneuver::FollowTrajectory(trajectory) => trajectory.speed,
        Maneuver::Rows(rows) => rows.speed,
        Maneuver::RowsCoverage(rows) => rows.speed,
        Maneuver::FollowSystem(follow) => follow.speed,
        Maneuver::Idle(_)
        | Maneuver::ScheduledGoto(_)
        | Maneuver::FollowReference(_)
        | Maneuver::Teleoperation(_) => Speed::MetresPerSecond(1.0),
    };
    model.mps(speed).max(1e-3)
}

#[cfg(test)]
mod tests;
