//! Where to turn back to: the roomiest water that a straight way leads to.

use super::settings::GroundingSettings;
use super::survey::Survey;
use charts::depth_index::{Demand, Leg};
use std::f64::consts::TAU;
use units::{LatLon, LocalFrame, LocalPoint};

const DIRECTIONS: u32 = 24;
const WAYS_M: [f64; 4] = [15.0, 30.0, 60.0, 100.0];
/// More room is no better (m).
const ROOM_M: f64 = 40.0;
/// A metre of way is worth this much room (m).
const WAY_COST: f64 = 0.1;
/// Room of the place beyond hull and uncertainty so that it can be kept (m).
const LEAST_ROOM_M: f64 = 3.0;

/// Where to keep station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Refuge {
    pub(crate) place: LatLon,
    /// How far it may drift there (m).
    pub(crate) radius_m: f64,
}

/// The best refuge that the chart knows: way and place deep enough for the vessel by itself, then the place, then
/// at least for anybody.
pub(crate) fn find(survey: &Survey<'_>, settings: &GroundingSettings, radius_m: f64) -> Option<Refuge> {
    let limits = &settings.limits;
    let (alone, anybody) = (limits.autonomous_m, limits.navigable_m);
    [(alone, alone), (anybody, alone), (anybody, anybody)].into_iter().find_map(|(way_m, end_m)| {
        best(survey, &survey.needing(settings, way_m), &survey.needing(settings, end_m), radius_m)
    })
}

fn best(survey: &Survey<'_>, way: &Survey<'_>, end: &Survey<'_>, radius_m: f64) -> Option<Refuge> {
    let own_m = survey.hull_m + survey.demand.position_m;
    // In danger already, what room there is must do for the way out.
    let wide_m = own_m.min(0.8 * way.clear_radius_m(survey.place, 2.0 * own_m));
    let demand = Demand { position_m: 0.0, ..way.demand };
    let frame = LocalFrame::new(survey.place);
    let mut best: Option<(f64, Refuge)> = None;
    let here = end.clear_radius_m(survey.place, ROOM_M);
    for way_m in [0.0].into_iter().chain(WAYS_M) {
        for n in 0..DIRECTIONS {
            let bearing_rad = TAU * f64::from(n) / f64::from(DIRECTIONS);
            let place = frame.to_place(LocalPoint::default().displaced(bearing_rad, way_m));
            let leg = Leg { from: survey.place, to: place };
            if way_m > 0.0 && !way.index.shallowest_along(leg, wide_m, &demand).navigable {
                continue;
            }
            let room_m = if way_m > 0.0 { end.clear_radius_m(place, ROOM_M) } else { here };
            let spare_m = room_m - own_m;
            let worth_m = room_m - WAY_COST * way_m;
            if spare_m < LEAST_ROOM_M || best.is_some_and(|(most_m, _)| worth_m <= most_m) {
                continue;
            }
            best = Some((worth_m, Refuge { place, radius_m: radius_m.min(spare_m - 1.0) }));
        }
    }
    best.map(|(_, refuge)| refuge)
}
