//! Time and energy along legs that were found already, for choosing one speed and for knowing when the next stretch begins.
//!
//! Unlike what is answered, these are estimates: where the current is not known, time goes on as in still water, and the
//! cost is that of weighing.

use crate::limits::{Limits, Piece};
use crate::objective::{Objective, Spot, Toll};
use crate::plane::{Plane, Point};
use charts::depth_index::Leg;

/// Legs are sampled in pieces so long (m), but all of them together in about so many.
const PIECE_M: f64 = 25.0;
const MOST_PIECES: f64 = 20_000.0;

impl Objective {
    /// The speed through the water, of those that are tried, at which all legs together cost least; the asked speed where no
    /// speed is enough against the current (m/s).
    pub(crate) fn best_pace_mps(&self, legs: &[(Leg, f64)]) -> f64 {
        let limits = self.limits_of(legs);
        let mut best = (self.through_water_mps, f64::INFINITY);
        for pace_mps in self.paces_mps() {
            let cost = self.sailed(legs, &limits, pace_mps).map_or(f64::INFINITY, |toll| toll.cost);
            if cost <= best.1 {
                best = (pace_mps, cost);
            }
        }
        best.0
    }

    /// About how long legs take (s); as in still water where the current is too strong somewhere.
    pub(crate) fn estimate_s(&self, legs: &[(Leg, f64)], pace_mps: f64) -> f64 {
        let still_s = || length_m(legs) / pace_mps;
        self.sailed(legs, &self.limits_of(legs), pace_mps).map_or_else(still_s, |toll| toll.duration_s)
    }

    /// A plane around the begin of each leg, with the limits that hold on it: they are the same at all speeds.
    fn limits_of(&self, legs: &[(Leg, f64)]) -> Vec<(Plane, Limits)> {
        let of = |(leg, _): &(Leg, f64)| {
            let plane = Plane::new(leg.from);
            (plane, self.limits_on(*leg, &plane))
        };
        legs.iter().map(of).collect()
    }

    /// What legs cost, one after the other from the time of departure, without preferences; `None` where the current is too
    /// strong, or the power is not known and counts.
    fn sailed(&self, legs: &[(Leg, f64)], limits: &[(Plane, Limits)], pace_mps: f64) -> Option<Toll> {
        let piece_m = PIECE_M.max(length_m(legs) / MOST_PIECES);
        let mut toll = Toll::default();
        for ((leg, _), (plane, limits)) in legs.iter().zip(limits) {
            let (from, to) = (Point::default(), plane.point(leg.to));
            for Piece { begin, end, most_mps, .. } in limits.pieces((from, to), piece_m) {
                let spot = Spot::of(plane, begin.towards(end, 0.5));
                toll = toll.and(self.piece(&spot, (begin, end), toll.duration_s, pace_mps.min(most_mps))?);
            }
        }
        Some(toll)
    }
}

fn length_m(legs: &[(Leg, f64)]) -> f64 {
    legs.iter().map(|(_, leg_m)| leg_m).sum()
}
