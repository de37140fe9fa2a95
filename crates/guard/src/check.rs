//! The guard against grounding: does a plan keep to deep water?
//!
//! [`check_plan`] lays out all that a plan may sweep (transits, tracks, circles, stations, drifting) as
//! corridors and asks the [depth index](charts::depth_index) for the worst in each. Corridors are swept
//! exactly; where a shape is no corridor (an arc, the fan of ways out of a circle) it is covered by wider ones,
//! so that a plan may be refused for something just outside, never accepted over something inside.
//!
//! The same function runs ashore and aboard; equal charts, limits and plans give equal verdicts.

mod layout;
mod limits;
mod verdict;

pub use limits::{GuardLimits, LimitsError};
pub use verdict::{LegCheck, Outcome, Part, Reason, Spot, Verdict, Warning};

use crate::maneuver::distance_m;
use crate::plan::Plan;
use charts::depth_index::{DepthAnswer, DepthIndex, Leg, Water};
use layout::{Layout, Stroke};
use units::LatLon;

/// Most corridors that a plan may be made of. More would hold the vessel's loop up.
pub const MOST_CORRIDORS: usize = 20_000;
/// Longest way that is checked, all corridors together (m).
pub const LONGEST_WAY_M: f64 = 1e6;

/// Holds a plan against the chart.
///
/// `from` is where the vessel is when the plan starts; without it the way to the first place is told to be
/// unchecked. A plan that follows itself in a circle is checked with the way back to its beginning.
pub fn check_plan(plan: &Plan, from: Option<LatLon>, index: &DepthIndex, limits: &GuardLimits) -> Verdict {
    let demand = limits.demand(limits.autonomous_m);
    let mut legs = Vec::new();
    let mut layout = Layout::new(plan, limits);
    let mut spent = Budget { corridors: 0, way_m: 0.0 };
    layout.run(from, |stroke| {
        if !spent.take(stroke) {
            return false;
        }
        let answers = stroke.corridors.iter().map(|corridor| {
            let leg = Leg { from: corridor.from, to: corridor.to };
            (*corridor, index.shallowest_along(leg, corridor.half_width_m, &demand))
        });
        let worst =
            answers.reduce(|worst, one| if gravity(&worst.1) <= gravity(&one.1) { worst } else { one });
        if let Some((corridor, answer)) = worst {
            legs.push(LegCheck {
                maneuver: stroke.maneuver.to_owned(),
                part: stroke.part,
                number: stroke.number,
                from: stroke.corridors.first().map_or(corridor.from, |first| first.from),
                to: stroke.corridors.last().map_or(corridor.to, |last| last.to),
                half_width_m: answer.half_width_m,
                reason: reason(&answer, limits),
                spot: Spot::of(&answer, index),
            });
        }
        true
    });
    let mut warnings = layout.into_warnings();
    warnings.extend(legs.iter().filter_map(Warning::of_quality));
    warnings.dedup();
    Verdict { legs, warnings, too_much: spent.is_over() }
}

/// Whether the straight way between two places keeps to deep water, wherever the vessel strays from it.
///
/// # Errors
/// Why not, with the place.
pub fn check_way(from: LatLon, to: LatLon, index: &DepthIndex, limits: &GuardLimits) -> Result<(), String> {
    let demand = limits.demand(limits.autonomous_m);
    let answer = index.shallowest_along(Leg { from, to }, limits.half_width_m(), &demand);
    let Some(reason) = reason(&answer, limits) else { return Ok(()) };
    let leg = LegCheck {
        maneuver: "the way".to_owned(),
        part: Part::Transit,
        number: 0,
        from,
        to,
        half_width_m: answer.half_width_m,
        reason: Some(reason),
        spot: Spot::of(&answer, index),
    };
    Err(leg.to_string())
}

/// What checking may take.
struct Budget {
    corridors: usize,
    way_m: f64,
}

impl Budget {
    fn take(&mut self, stroke: &Stroke<'_>) -> bool {
        self.corridors += stroke.corridors.len();
        self.way_m += stroke.corridors.iter().map(|one| distance_m(one.from, one.to)).sum::<f64>();
        !self.is_over()
    }

    fn is_over(&self) -> bool {
        self.corridors > MOST_CORRIDORS || self.way_m > LONGEST_WAY_M
    }
}

/// Less is worse.
fn gravity(answer: &DepthAnswer) -> f64 {
    const NO_WATER: f64 = -1e9;
    match answer.water {
        Water::Land => NO_WATER,
        Water::Obstacle => NO_WATER + 1.0,
        Water::UnknownDepth => NO_WATER + 2.0,
        Water::NoData => NO_WATER + 3.0,
        Water::TooLow { .. } => NO_WATER + 4.0,
        Water::Depth { .. } => answer.margin_m.unwrap_or(NO_WATER),
    }
}

/// Why the vessel may not be there by itself, if so.
fn reason(answer: &DepthAnswer, limits: &GuardLimits) -> Option<Reason> {
    if answer.navigable {
        return None;
    }
    Some(match answer.water {
        Water::Land => Reason::Land,
        Water::Obstacle => Reason::Obstacle,
        Water::UnknownDepth => Reason::UnknownDepth,
        Water::NoData => Reason::NoData,
        Water::TooLow { .. } => Reason::TooLow,
        Water::Depth { .. } => {
            let relief_m = limits.needed_m(limits.autonomous_m) - limits.needed_m(limits.navigable_m);
            match answer.margin_m {
                Some(margin_m) if margin_m + relief_m >= 0.0 => Reason::TooShallowAlone,
                _ => Reason::TooShallow,
            }
        }
    })
}

#[cfg(test)]
mod tests;
