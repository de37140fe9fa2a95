//! A plan checked against the sea chart: every maneuver is laid out as what it may sweep, and [`guard::Check`] judges it.

use crate::maneuver::{Loiter, LoiterShape, Maneuver};
use crate::plan::{Node, Plan};
use charts::depth_index::DepthIndex;
use guard::{Check, Disc, GuardLimits, Verdict, Warning};
use std::f64::consts::PI;
use units::{LatLon, LocalFrame, LocalPoint, Turn};

/// Checks a plan against the chart.
///
/// `from` is where the vessel is when the plan starts; without it the way to the first place is reported as unchecked. A
/// plan that repeats in a circle is checked with the way back to its beginning. Legs bear the names of their
/// maneuvers.
pub fn check_plan(plan: &Plan, from: Option<LatLon>, index: &DepthIndex, limits: &GuardLimits) -> Verdict {
    let mut check = Check::new(from, index, limits);
    let order = plan.order();
    for node in order.iter().filter_map(|index| plan.node(*index)) {
        if let Maneuver::ScheduledGoto(_) = node.maneuver() {
            // It does not start before it must, and drifts until then.
            check.warn(Warning::DriftsOn { label: node.id().to_owned() });
        }
        approach(&mut check, node, limits);
        carry_out(&mut check, node, limits);
        if check.is_over() {
            return check.verdict();
        }
    }
    // The way back to the beginning of a circle of maneuvers, and on to its first place.
    let mut next = order.last().and_then(|last| plan.node(*last)?.next());
    for _ in &order {
        let Some(node) = next.and_then(|next| plan.node(next)) else { break };
        approach(&mut check, node, limits);
        match node.maneuver() {
            Maneuver::Idle(idle) if idle.duration.is_some() && check.here().is_some() => {
                check.drift(node.id(), idle.duration);
            }
            Maneuver::Idle(_) => {}
            _ => break,
        }
        next = node.next();
    }
    check.verdict()
}

/// The way to the first place of a maneuver.
fn approach(check: &mut Check<'_>, node: &Node, limits: &GuardLimits) {
    let id = node.id();
    match node.maneuver() {
        Maneuver::Loiter(loiter) => match loiter.shape {
            LoiterShape::Circle(turn) | LoiterShape::Other(turn) => {
                check.approach(id, circle(loiter, limits), turn == Turn::Clockwise);
            }
            LoiterShape::Eight { length_m, bearing_rad } => {
                let Disc { centre, radius_m } = circle(loiter, limits);
                let (ends, _) = eight(centre, radius_m, length_m, bearing_rad);
                check.transit(id, Disc { centre: ends[0], radius_m });
            }
        },
        maneuver => {
            if let Some(first) = maneuver.places().first() {
                check.transit(id, Disc::at(*first));
            }
        }
    }
}

/// The area that a maneuver sweeps from its first place on.
fn carry_out(check: &mut Check<'_>, node: &Node, limits: &GuardLimits) {
    let (id, maneuver) = (node.id(), node.maneuver());
    match maneuver {
        Maneuver::Goto(_)
        | Maneuver::Launch(_)
        | Maneuver::FollowPath(_)
        | Maneuver::FollowTrajectory(_)
        | Maneuver::ScheduledGoto(_)
        | Maneuver::Rows(_) => check.track(id, &maneuver.places(), 0.0),
        // Rows move by up to a step when the sensor sees less than its full width.
        Maneuver::RowsCoverage(rows) => check.track(id, &maneuver.places(), rows.swath.width_m()),
        Maneuver::StationKeeping(station) => {
            let radius_m = station.radius_m.max(limits.least_station_m);
            check.station(id, Disc { centre: station.centre, radius_m });
        }
        Maneuver::Loiter(loiter) => {
            let disc = circle(loiter, limits);
            if let LoiterShape::Eight { length_m, bearing_rad } = loiter.shape {
                let (ends, all) = eight(disc.centre, disc.radius_m, length_m, bearing_rad);
                check.eight(id, ends, disc.radius_m);
                check.be_within(all);
            } else {
                check.circle(id, disc);
            }
        }
        Maneuver::Idle(idle) => check.drift(id, idle.duration),
        Maneuver::FollowReference(_) | Maneuver::FollowSystem(_) | Maneuver::Teleoperation(_) => {
            check.warn(Warning::Unchecked { label: id.to_owned(), kind: maneuver.kind().to_string() });
            check.be_anywhere();
        }
    }
}

/// The circle of a loiter; small ones are widened.
fn circle(loiter: &Loiter, limits: &GuardLimits) -> Disc {
    Disc { centre: loiter.centre, radius_m: loiter.radius_m.max(limits.least_loiter_m) }
}

/// The middles of an eight's circles, the first one first, and the disc round all of it.
fn eight(centre: LatLon, radius_m: f64, length_m: f64, bearing_rad: f64) -> ([LatLon; 2], Disc) {
    let half_m = length_m.max(2.0 * radius_m) / 2.0;
    let frame = LocalFrame::new(centre);
    let end = |bearing_rad| frame.to_place(LocalPoint::default().displaced(bearing_rad, half_m));
    let all = Disc { centre, radius_m: half_m + radius_m };
    ([end(bearing_rad + PI), end(bearing_rad)], all)
}

#[cfg(test)]
mod tests;
