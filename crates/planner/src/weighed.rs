//! The best route by an objective, beside the shortest one.

use crate::limits::Limits;
use crate::objective::{Aim, Toll};
use crate::plane::Point;
use crate::refusal::Refusal;
use crate::route::{Question, Route, Stand};
use crate::sailing::{Sailing, Wish};
use crate::search::Effort;
use crate::weighing;

/// A route must be better than the shortest one by this share of its cost: joining corners changes both by about as much.
const BETTER: f64 = 1e-3;
/// Lengths in unknown currents are equal within two of the pieces that ways are compared in (m).
const ROUNDING_M: f64 = 20.0;

impl Question<'_> {
    /// Of the shortest route, its alternatives, and the cheapest way that is found, the one that costs least; the shortest
    /// one where no other is better. Each is compared as it is given: in legs that the chart confirmed, at the speed that is
    /// best for it. Where time or energy counts, one that leads farther through water of an unknown current than the
    /// shortest is not taken: whether it is better is not known.
    pub(crate) fn weighed(
        &self,
        wish: &Wish,
        ways: &[Vec<Point>],
        mut shortest: Route,
        ends: (Stand, Stand),
    ) -> Result<Route, Refusal> {
        let objective = &wish.objective;
        let plane = self.room.plane();
        let limits = Limits::new(objective.limits.iter().map(|limit| (&limit.zone, limit.most_mps)), plane)
            .with_traffic(&objective.traffic, objective.traffic_factor, plane);
        let sailing =
            Sailing { room: self.room, wish, limits: &limits, pace_mps: objective.through_water_mps };
        let corners = |route: &Route| route.places().map(|place| plane.point(place)).collect::<Vec<_>>();
        let weigh = |route: &Route| sailing.best_pace(&corners(route), self.cancel);
        let (shortest_mps, Toll { cost: shortest_cost, unknown_m, .. }) = weigh(&shortest)?;
        let energy = objective.aim == Aim::Energy;
        shortest.through_water_mps = Some(shortest_mps).filter(|_| energy && shortest_cost.is_finite());
        if objective.is_uniform() {
            let at_mps = shortest.through_water_mps;
            shortest.alternatives.iter_mut().for_each(|other| other.through_water_mps = at_mps);
            return Ok(shortest);
        }
        if objective.minds_only_traffic() {
            let way = corners(&shortest);
            let length_m: f64 = way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
            // Out of all traffic no way is better than the shortest.
            if shortest_cost <= length_m * (1.0 + 1e-9) {
                return Ok(shortest);
            }
        }
        let mut best: Option<(f64, f64, Route)> = None;
        let mut offer = |pace_mps: f64, toll: Toll, route: &Route| {
            let cost = toll.cost;
            if toll.unknown_m > unknown_m + ROUNDING_M {
                return;
            }
            let held = best.as_ref().map_or(shortest_cost * (1.0 - BETTER), |best| best.1);
            // What the shortest way cannot do at all is better by any share.
            if cost < held {
                best = Some((pace_mps, cost, route.clone()));
            }
        };
        for other in &mut shortest.alternatives {
            let (pace_mps, toll) = weigh(other)?;
            other.through_water_mps = Some(pace_mps).filter(|_| energy && toll.cost.is_finite());
            offer(pace_mps, toll, other);
        }
        let mut pace_mps = shortest_mps;
        // The speed that is best on the cheapest way may be another one than on the shortest.
        for _ in 0..2 {
            self.cancel.check()?;
            let sailing = sailing.at(pace_mps);
            let Some(way) = weighing::cheapest(&sailing, ways, self.cancel)? else { break };
            let route = match self.confirmed(way, Effort::default(), ends) {
                Ok(route) => route,
                Err(Refusal::NotConfirmed { .. }) => break,
                Err(refusal) => return Err(refusal),
            };
            let (best_mps, toll) = weigh(&route)?;
            offer(best_mps, toll, &route);
            if (best_mps - pace_mps).abs() < f64::EPSILON {
                break;
            }
            pace_mps = best_mps;
        }
        let Some((pace_mps, _, mut route)) = best else { return Ok(shortest) };
        route.through_water_mps = energy.then_some(pace_mps);
        route.effort = shortest.effort;
        route.alternatives = std::mem::take(&mut shortest.alternatives);
        route.alternatives.retain(|other| other.legs != route.legs);
        route.shortest = Some(Box::new(shortest));
        Ok(route)
    }
}
