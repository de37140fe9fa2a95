//! Routes that the vessel searches for on its own: its requests, and their answers.
//!
//! Water is prepared in up to a second, so the brain does not plan: it asks by [`Output::Route`](crate::Output::Route)
//! and continues, and gets it by [`Input::Route`](crate::Input::Route). Both bear a number, so that an answer to
//! what is not asked any more is known as such, and both are recorded. [`Routes`] answers, aboard on a thread of its own, in
//! simulations at once. The guard judges each route from where the vessel is by then.

use crate::grounding::Chart;
use guard::{Area, GuardLimits};
use planner::{Cancel, Needs, PlanError, Refusal, Request, Router, Zone, Zones};
use std::sync::Arc;
use units::LatLon;

/// Rooms of prepared water that are kept: the last one. Preparing another takes most of the memory that routes may have
/// aboard, and what is kept stays beside it until it is ready; where the first clearance finds nothing, water is prepared
/// twice.
const ROOMS: usize = 1;
/// Turning radius that routes are planned for (m): an Otter's at full speed.
const TURN_RADIUS_M: f64 = 8.0;
/// Shorter legs are joined (m).
const LEAST_LEG_M: f64 = 15.0;
/// A vessel that was steered into water where it may not sail on its own searches for open water this far off (m).
const MOVE_UP_TO_M: f64 = 300.0;

/// Routes keep so far from the border of the area of operation (m), and half as far as an end that is nearer to it than twice
/// that.
const AREA_MARGIN_M: f64 = 5.0;
/// A place no farther inside than this (m) is on the border.
const ON_BORDER_M: f64 = 0.5;

/// Routes that the vessel searches for on its own. Set in the files only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RouteSettings {
    /// Whether it searches for any.
    pub around: bool,
    /// How far they keep from danger where the water allows it (m); never less than the guard demands.
    pub clearance_m: f64,
    /// Longer ones are not taken (m).
    pub longest_m: f64,
}

impl Default for RouteSettings {
    fn default() -> Self {
        Self { around: true, clearance_m: 25.0, longest_m: 20_000.0 }
    }
}

impl RouteSettings {
    /// The clearances to ask for, one after the other: as set, then what the guard demands.
    pub(crate) fn clearances_m(&self, limits: &GuardLimits) -> Vec<f64> {
        let least_m = limits.half_width_m();
        if self.clearance_m > least_m { vec![self.clearance_m, least_m] } else { vec![least_m] }
    }
}

/// A route to look for on the chart in force.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteRequest {
    /// Its number; the answer bears it too.
    pub number: u32,
    /// Start.
    pub from: LatLon,
    /// Goal.
    pub to: LatLon,
    /// The water around it.
    pub needs: Needs,
    /// The area of operation, if the way is to stay inside it. It is not part of recordings, whose settings have it.
    pub zones: Zones,
    /// A longer one is of no use (m).
    pub longest_m: f64,
}

impl RouteRequest {
    /// For a vessel with these limits, this far from danger (m), inside its area if it is well inside. It gets its number
    /// when it is asked.
    pub(crate) fn new(
        (from, to): (LatLon, LatLon),
        limits: &GuardLimits,
        area: Option<&Area>,
        clearance_m: f64,
        longest_m: f64,
    ) -> Self {
        let needs = Needs { demand: limits.demand(limits.autonomous_m), clearance_m };
        Self { number: 0, from, to, needs, zones: zones(area, from, to), longest_m }
    }
}

/// The result of a request.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteAnswer {
    /// Whose.
    pub number: u32,
    /// The route, or the obstacle.
    pub outcome: Result<FoundRoute, String>,
}

/// A route.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRoute {
    /// Its corners, ends included.
    pub places: Vec<LatLon>,
    /// Its length (m).
    pub length_m: f64,
    /// It does not begin where it was asked for but in the nearest open water.
    pub start_moved: bool,
}

/// Answers requests, and keeps prepared water for those that come.
#[derive(Debug, Default)]
pub struct Routes {
    router: Option<Router>,
}

impl Routes {
    /// Lets go of another chart than this and of the water prepared on it.
    pub fn keep_to(&mut self, chart: &Chart) {
        let index = match chart {
            Chart::Loaded(file) => Some(file.shared_index()),
            Chart::Off | Chart::Unreadable { .. } => None,
        };
        let same = |router: &Router| index.is_some_and(|index| Arc::ptr_eq(router.index(), &index));
        self.router = self.router.take().filter(same);
    }

    /// The answer by a chart; none when it was cancelled.
    pub fn answer(
        &mut self,
        chart: &Chart,
        request: &RouteRequest,
        cancel: &Cancel<'_>,
    ) -> Option<RouteAnswer> {
        let outcome = match chart {
            Chart::Loaded(file) => {
                self.keep_to(chart);
                // The water of a long way would take more memory than routes may have aboard.
                let fresh = || Router::by_regions(file.shared_index()).keeping(ROOMS).looking_at(0);
                let outcome = find(self.router.get_or_insert_with(fresh), request, cancel);
                if outcome == Err(Refusal::Plan(PlanError::Cancelled)) {
                    return None;
                }
                outcome.map_err(|refusal| refusal.to_string())
            }
            Chart::Off | Chart::Unreadable { .. } => Err("there is no chart to find one on".to_owned()),
        };
        Some(RouteAnswer { number: request.number, outcome })
    }
}

/// The area of operation as a zone to stay in, with the margin that both ends leave. A vessel outside of it, or on its border,
/// is led back by what is judged afterwards.
fn zones(area: Option<&Area>, from: LatLon, to: LatLon) -> Zones {
    let inside_m = |area: &&Area| area.depth_m(from).min(area.depth_m(to));
    let area = area.filter(|area| inside_m(area) > ON_BORDER_M);
    let zone = area.and_then(|area| Some((Zone::new(area.corners().collect()).ok()?, inside_m(&area))));
    let margined = |(zone, inside_m): (Zone, f64)| {
        Zones::new(Some(zone), Vec::new(), AREA_MARGIN_M.min(inside_m / 2.0)).ok()
    };
    zone.and_then(margined).unwrap_or_default()
}

fn find(router: &Router, request: &RouteRequest, cancel: &Cancel<'_>) -> Result<FoundRoute, Refusal> {
    let RouteRequest { from, to, needs, zones, longest_m, .. } = request;
    let ask = Request {
        move_up_to_m: MOVE_UP_TO_M,
        least_leg_m: LEAST_LEG_M,
        turn_radius_m: Some(TURN_RADIUS_M),
        longest_m: Some(*longest_m),
        ..Request::new(*from, *to)
    };
    let route = router.in_zones(zones.clone()).route(&ask, needs, cancel)?;
    Ok(FoundRoute {
        places: route.places().collect(),
        length_m: route.length_m,
        start_moved: route.moved_start.is_some(),
    })
}
