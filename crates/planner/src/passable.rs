//! Which smaller demands would give a route where what was asked for gives none.
//!
//! Water that is prepared for a demand shows whether that one gives a route, but preparing is slow. So the clearance is
//! measured as the widest way in water prepared without any, and depths are tried only where the chart has some. A
//! figure is given only if water that was prepared for it has a route that the chart confirms.

use crate::Cancel;
use crate::needs::Needs;
use crate::obstacles::cut_out_m;
use crate::plane::Point;
use crate::room::{PlanError, SeaRoom};
use crate::route::Request;
use crate::widest::widest_m;
use charts::depth_index::Demand;

/// Trials for depths: enough for 63 different ones.
const DEPTH_TRIALS: u32 = 6;
/// Trials for a clearance that is less than the one measured, where ends must be moved too far for that.
const CLEARANCE_TRIALS: u32 = 3;
/// What thinned lines and the grid may take off the width that is measured (m).
const MEASURED_M: f64 = 0.15;
/// Nearer than this to a figure that gives no route, no other is looked for.
const NEAR_ENOUGH: f64 = 0.95;
/// How far from an end dangers are looked for (m): more than any clearance.
const FAR_M: f64 = 25_000.0;

/// Smaller demands that give a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passable {
    /// The greatest least depth (m), in tenths; `None` if 0 m is still too much.
    pub depth_m: Option<f64>,
    /// The greatest clearance (m), in whole metres or, below 10 m, tenths; `None` if no route exists even without
    /// clearance.
    pub clearance_m: Option<f64>,
    /// There is one through areas whose entry is prohibited or restricted: the rule of entry alone refuses it.
    pub by_rule_alone: bool,
}

/// What water is prepared for these needs, and whether it has a confirmed route.
pub(crate) type Trial<'a> = dyn FnMut(&Needs) -> Result<(SeaRoom, bool), PlanError> + 'a;

/// The greatest least depth below the one demanded that gives a route, of those at which the water changes.
pub(crate) fn depth_m(
    needs: &Needs,
    closing_m: &[f64],
    trial: &mut Trial<'_>,
) -> Result<Option<f64>, PlanError> {
    let wanted_m = needs.demand.needed_m();
    let mut gives_route = |depth_m: f64| {
        let demand = Demand { draught_m: depth_m, squat_m: 0.0, reserve_m: 0.0, ..needs.demand };
        trial(&Needs { demand, ..*needs }).map(|(_, found)| found)
    };
    if wanted_m <= 0.0 || !gives_route(0.0)? {
        return Ok(None);
    }
    let mut depths_m: Vec<f64> = closing_m.iter().map(|depth_m| tenths(*depth_m)).collect();
    depths_m.dedup();
    depths_m.retain(|depth_m| *depth_m > 0.0 && *depth_m < wanted_m);
    let (mut best_m, mut left) = (0.0, &depths_m[..]);
    for _ in 0..DEPTH_TRIALS {
        let middle = left.len() / 2;
        let Some(depth_m) = left.get(middle) else { break };
        if gives_route(*depth_m)? {
            (best_m, left) = (*depth_m, &left[middle + 1..]);
        } else {
            left = &left[..middle];
        }
    }
    Ok(Some(best_m))
}

/// The greatest clearance below the one demanded that gives a route.
pub(crate) fn clearance_m(
    request: &Request,
    needs: &Needs,
    cancel: &Cancel<'_>,
    trial: &mut Trial<'_>,
) -> Result<Option<f64>, PlanError> {
    let wanted_m = needs.clearance_m;
    if wanted_m <= 0.0 {
        return Ok(None);
    }
    let (room, found) = trial(&Needs { clearance_m: 0.0, ..*needs })?;
    if !found {
        return Ok(None);
    }
    let most_m = greatest_m(&room, request, cancel)?.min(NEAR_ENOUGH * wanted_m);
    let (mut best_m, mut too_much_m, mut next_m) = (0.0, f64::INFINITY, presentable(most_m));
    for _ in 0..=CLEARANCE_TRIALS {
        if next_m <= best_m || best_m > NEAR_ENOUGH * too_much_m {
            break;
        }
        if trial(&Needs { clearance_m: next_m, ..*needs })?.1 {
            best_m = next_m;
            if too_much_m.is_infinite() {
                break;
            }
        } else {
            too_much_m = next_m;
        }
        next_m = presentable(f64::midpoint(best_m, too_much_m));
    }
    Ok(Some(best_m))
}

/// No way in this room, which was prepared without clearance, can be widened to more clearance than this (m): as far as
/// it goes by the widest way, and as far as the ends may be moved.
fn greatest_m(room: &SeaRoom, request: &Request, cancel: &Cancel<'_>) -> Result<f64, PlanError> {
    let ends = [request.from, request.to].map(|place| room.plane().point(place));
    let near = ends.map(|end| room.mesh.within_reach(end, request.move_up_to_m));
    let width_m = widest_m(&room.mesh, &near[0], &near[1], cancel)?.unwrap_or(0.0);
    let open_m = |end: Point| room.clearance(end, end, FAR_M).map_or(FAR_M, |(open_m, _)| open_m);
    let half_m = width_m / 2.0 + cut_out_m(room.cut_m());
    let ends_m = ends.map(|end| open_m(end) + request.move_up_to_m);
    let half_m = ends_m.into_iter().fold(half_m, f64::min) - MEASURED_M;
    // What is cut out for a clearance must not be more than half the width; it grows evenly, by at least the clearance.
    let (mut least_m, mut most_m) = (0.0, half_m.max(0.0));
    for _ in 0..40 {
        let middle_m = f64::midpoint(least_m, most_m);
        if cut_out_m(room.cut_m() + middle_m) <= half_m {
            least_m = middle_m;
        } else {
            most_m = middle_m;
        }
    }
    Ok(least_m)
}

/// Rounded down to tenths.
fn tenths(value: f64) -> f64 {
    (value * 10.0 + 1e-6).floor() / 10.0
}

/// Rounded down to what is said of it: whole metres, or tenths below 10 m.
fn presentable(value_m: f64) -> f64 {
    if value_m < 10.0 { tenths(value_m) } else { value_m.floor() }
}
