//! The route that an objective likes best, beside the shortest one.

use crate::objective::Aim;
use crate::plane::Point;
use crate::route::{Question, Refusal, Route, Stand};
use crate::sailing::{Sailing, Wish};
use crate::search::Effort;
use crate::weighing;

/// A route must be better than the shortest one by this share of its cost: joining corners changes both by about as much.
const BETTER: f64 = 1e-3;

impl Question<'_> {
    /// Of the shortest route, its alternatives, and the cheapest way that is found, the one that costs least; the shortest
    /// one where no other is better. Each is compared as it is given: in legs that the chart confirmed.
    pub(crate) fn weighed(
        &self,
        wish: &Wish,
        ways: &[Vec<Point>],
        mut shortest: Route,
        ends: (Stand, Stand),
    ) -> Result<Route, Refusal> {
        let objective = &wish.objective;
        let sailing = Sailing { room: self.room, wish, pace_mps: objective.through_water_mps };
        let plane = self.room.plane();
        let corners = |route: &Route| route.places().map(|place| plane.point(place)).collect::<Vec<_>>();
        let weigh = |route: &Route| sailing.best_pace(&corners(route));
        let (shortest_mps, shortest_cost) = weigh(&shortest);
        let energy = objective.aim == Aim::Energy;
        if objective.is_uniform() {
            shortest.through_water_mps = energy.then_some(shortest_mps);
            return Ok(shortest);
        }
        let mut best: Option<(f64, f64, Route)> = None;
        let mut offer = |pace_mps: f64, cost: f64, route: &Route| {
            let held = best.as_ref().map_or(shortest_cost * (1.0 - BETTER), |best| best.1);
            // What the shortest way cannot do at all is better by any share.
            if cost < held {
                best = Some((pace_mps, cost, route.clone()));
            }
        };
        for other in &shortest.alternatives {
            let (pace_mps, cost) = weigh(other);
            offer(pace_mps, cost, other);
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
            let (best_mps, cost) = weigh(&route);
            offer(best_mps, cost, &route);
            if best_mps == pace_mps {
                break;
            }
            pace_mps = best_mps;
        }
        let Some((pace_mps, _, mut route)) = best else {
            shortest.through_water_mps = Some(shortest_mps).filter(|_| energy && shortest_cost.is_finite());
            return Ok(shortest);
        };
        route.through_water_mps = energy.then_some(pace_mps);
        route.effort = shortest.effort;
        route.alternatives = std::mem::take(&mut shortest.alternatives);
        route.alternatives.retain(|other| other.legs != route.legs);
        route.shortest = Some(Box::new(shortest));
        Ok(route)
    }
}
