//! Helpers for the tests of several modules.

use crate::event::{Event, Fix, PathProgress};
use crate::maneuver::{Goto, Idle, Maneuver};
use crate::place::RawPlace;
use crate::plan::{DraftBody, ManeuverDraft, Plan, PlanDraft, TransitionDraft};
use crate::plan_limits::PlanLimits;
use std::time::Duration;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now, UtcTime};

pub(crate) const SPEED: Speed = Speed::MetresPerSecond(1.5);

pub(crate) fn frame() -> LocalFrame {
    LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap())
}

pub(crate) fn place(north_m: f64, east_m: f64) -> LatLon {
    frame().to_place(LocalPoint { north_m, east_m })
}

/// The time so many seconds after the start, on both clocks.
pub(crate) fn at(seconds: f64) -> Now {
    let us = (seconds * 1e6).round() as u64;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_700_000_000_000_000 + us as i64) }
}

pub(crate) fn fix(north_m: f64, east_m: f64) -> Fix {
    Fix { place: place(north_m, east_m), heading_rad: 0.0, speed_mps: 1.0, sigma_m: 0.0, water_below_m: None }
}

pub(crate) fn progress(path_ref: u32, left_m: f64) -> PathProgress {
    PathProgress { path_ref, near: false, loitering: false, left_m, cross_m: 0.0, eta_s: left_m / 1.5 }
}

pub(crate) fn near(path_ref: u32) -> Event {
    Event::Path(PathProgress { near: true, ..progress(path_ref, 0.0) })
}

pub(crate) fn goto(north_m: f64, east_m: f64) -> Maneuver<RawPlace> {
    Maneuver::Goto(Goto { target: place(north_m, east_m).into(), speed: SPEED })
}

pub(crate) fn idle(seconds: u64) -> Maneuver<RawPlace> {
    Maneuver::Idle(Idle { duration: (seconds > 0).then_some(Duration::from_secs(seconds)) })
}

/// Maneuvers `m0`, `m1`, ... one after the other.
pub(crate) fn draft(maneuvers: Vec<Maneuver<RawPlace>>) -> PlanDraft {
    let count = maneuvers.len();
    let transition =
        |index: usize| TransitionDraft { from: format!("m{index}"), to: format!("m{}", index + 1) };
    PlanDraft {
        id: "plan".to_owned(),
        start: "m0".to_owned(),
        maneuvers: maneuvers
            .into_iter()
            .enumerate()
            .map(|(index, maneuver)| ManeuverDraft {
                id: format!("m{index}"),
                depth_m: None,
                body: DraftBody::Maneuver(maneuver),
            })
            .collect(),
        transitions: (1..count).map(|next| transition(next - 1)).collect(),
        notes: Vec::new(),
    }
}

pub(crate) fn plan(maneuvers: Vec<Maneuver<RawPlace>>) -> Plan {
    Plan::build(&draft(maneuvers), &PlanLimits::default()).unwrap()
}
