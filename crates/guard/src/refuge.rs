//! Where to turn back to: the water with most room that a straight way leads to.

use crate::limits::GuardLimits;
use crate::water_around::WaterAround;
use charts::depth_index::{Demand, Leg};
use std::f64::consts::TAU;
use units::{LatLon, LocalFrame, LocalPoint};

const DIRECTIONS: u32 = 24;
const WAYS_M: [f64; 4] = [15.0, 30.0, 60.0, 100.0];
/// More room gives no advantage (m).
const ROOM_M: f64 = 40.0;
/// A metre of way is worth this much room (m).
const WAY_COST: f64 = 0.1;
/// Room of the place beyond hull and uncertainty so that it can be kept (m).
const LEAST_ROOM_M: f64 = 3.0;

/// Where to keep station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refuge {
    /// The middle.
    pub place: LatLon,
    /// How far it may drift there (m).
    pub radius_m: f64,
}

impl WaterAround<'_> {
    /// The place with most room that a straight way leads to; `radius_m` is how far the vessel may drift there at most.
    /// Way and place are deep enough for autonomous sailing; else the place alone is; else both are for manual steering.
    pub fn refuge(&self, limits: &GuardLimits, radius_m: f64) -> Option<Refuge> {
        let (alone, anybody) = (limits.autonomous_m, limits.navigable_m);
        [(alone, alone), (anybody, alone), (anybody, anybody)].into_iter().find_map(|(way_m, end_m)| {
            best(self, &self.needing(limits, way_m), &self.needing(limits, end_m), radius_m)
        })
    }
}

fn best(
    around: &WaterAround<'_>,
    way: &WaterAround<'_>,
    end: &WaterAround<'_>,
    radius_m: f64,
) -> Option<Refuge> {
    let own_m = around.reach_m();
    // In danger already, what room there is must do for the way out.
    let wide_m = own_m.min(0.8 * way.clear_radius_m(around.place, 2.0 * own_m));
    let demand = Demand { position_m: 0.0, ..way.demand };
    let frame = LocalFrame::new(around.place);
    let mut best: Option<(f64, Refuge)> = None;
    let here = end.clear_radius_m(around.place, ROOM_M);
    for way_m in [0.0].into_iter().chain(WAYS_M) {
        for n in 0..DIRECTIONS {
            let bearing_rad = TAU * f64::from(n) / f64::from(DIRECTIONS);
            let place = frame.to_place(LocalPoint::default().displaced(bearing_rad, way_m));
            let leg = Leg { from: around.place, to: place };
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
