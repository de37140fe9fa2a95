//! Generated waters around one place, and questions to them.

use charts::depth_index::{DepthIndex, Leg};
use planner::{Needs, Request, Route, Router};
use proptest::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use testkit::sea::{Ground, Sea};
use units::{LatLon, LocalFrame, LocalPoint};

/// Half side of the sea (m).
pub(crate) const HALF_M: f64 = 2_000.0;

pub(crate) fn middle() -> LatLon {
    LatLon::from_deg(63.44, 10.35).unwrap()
}

pub(crate) fn at(north_m: f64, east_m: f64) -> LocalPoint {
    LocalPoint { north_m, east_m }
}

pub(crate) fn place(point: LocalPoint) -> LatLon {
    LocalFrame::new(middle()).to_place(point)
}

pub(crate) fn local(place: LatLon) -> LocalPoint {
    LocalFrame::new(middle()).to_local(place)
}

/// Without land or shoals, 30 m deep.
pub(crate) fn open_sea() -> Sea {
    Sea::new(middle(), HALF_M, 30.0)
}

pub(crate) fn router(sea: &Sea) -> Router {
    Router::new(Arc::new(sea.index()))
}

/// As the mathematician wants it: no corners joined, no ends moved.
pub(crate) fn exact_places(from: LatLon, to: LatLon) -> Request {
    Request { move_up_to_m: 0.0, least_leg_m: 0.0, ..Request::new(from, to) }
}

pub(crate) fn exact(from: LocalPoint, to: LocalPoint) -> Request {
    exact_places(place(from), place(to))
}

pub(crate) fn is_safe(route: &Route, index: &DepthIndex, needs: &Needs) -> bool {
    let places: Vec<LatLon> = route.places().collect();
    places.windows(2).all(|leg| {
        let leg = Leg { from: leg[0], to: leg[1] };
        index.shallowest_along(leg, needs.clearance_m, &needs.demand).navigable
    })
}

/// Land, by a depth below 0, or shallower water.
#[derive(Debug, Clone)]
pub(crate) struct Shoal {
    pub(crate) at: LocalPoint,
    pub(crate) radius_m: f64,
    pub(crate) corners: u32,
    pub(crate) depth_m: f64,
}

/// Fewer than so many, no farther from the middle than this each way (m), of such sizes and depths (m).
pub(crate) fn shoals(
    most: usize,
    off_m: f64,
    radius_m: Range<f64>,
    depth_m: Range<f64>,
) -> impl Strategy<Value = Vec<Shoal>> {
    let shoal = (point(off_m), radius_m, 3..9u32, depth_m)
        .prop_map(|(at, radius_m, corners, depth_m)| Shoal { at, radius_m, corners, depth_m });
    prop::collection::vec(shoal, 0..most)
}

pub(crate) fn sea(shoals: &[Shoal]) -> Sea {
    shoals.iter().fold(open_sea(), |sea, shoal| {
        let ground = if shoal.depth_m < 0.0 { Ground::Land } else { Ground::Depth(shoal.depth_m) };
        sea.with(ground, shoal.at, shoal.radius_m, shoal.corners)
    })
}

/// No farther from the middle than this each way (m).
pub(crate) fn point(off_m: f64) -> impl Strategy<Value = LocalPoint> {
    (-off_m..off_m, -off_m..off_m).prop_map(|(north_m, east_m)| at(north_m, east_m))
}
