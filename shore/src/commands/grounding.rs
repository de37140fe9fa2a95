//! The grounding guard: checks orders against the chart before they are sent.
//!
//! A plan that is drawn, saved, uploaded or started, and the target of a goto, are checked against the chart with the
//! limits that the vessel reported of its own guard, but never with less depth than the server demands. A plan aboard is
//! identified by its digest: drawn here, or reported by the vessel. Any other plan is judged by the vessel alone, if it has
//! a guard; a DUNE vessel has none.

use crate::charts::{Charts, Limits};
use crate::error::{Error, Result, slow};
use crate::fleet::Fleet;
use crate::identity::{People, Principal};
use crate::plans;
use crate::router::Router;
use api::say;
use guard::{GuardLimits, Outcome};
use imc::Address;
use imc::messages::PlanSpecification;
use mission::Plan;
use operations::{Operations, Order};
use units::LatLon;

/// Farther from the vessel no place is gone to (m): it is more than a battery lasts for, and probably a slip of the finger.
const FARTHEST_M: f64 = 100_000.0;
/// Mean radius of the earth (m).
const MEAN_RADIUS_M: f64 = 6_371_008.8;

/// Handle of the guard; cheap to clone.
#[derive(Clone)]
pub struct Grounding {
    router: Router,
    people: People,
    fleet: Fleet,
    charts: Charts,
}

/// The limits and start position that a plan is judged by.
pub struct Judge {
    charts: Charts,
    limits: Limits,
    from: Option<LatLon>,
}

/// The refusal of a place that is too far from the vessel; says whether its coordinates may have been swapped.
fn too_far(from: LatLon, place: LatLon) -> Option<Error> {
    let km = |length_m: f64| (length_m / 1000.0).round();
    // About a metre, without what radians left behind the comma.
    let shown = |angle_deg: f64| (angle_deg * 1e5).round() / 1e5;
    let distance_m = far_m(from, place);
    if distance_m <= FARTHEST_M {
        return None;
    }
    let swapped = LatLon::from_deg(place.lon_deg(), place.lat_deg()).ok();
    let near = swapped.map(|swapped| (swapped, far_m(from, swapped))).filter(|(_, m)| *m <= FARTHEST_M);
    let text = match near {
        Some((swapped, near_m)) => say(
            "The place is {distance} km from the vessel, and Go there goes {most} km at most: nothing was sent. Are latitude and \
             longitude swapped? {lat}, {lon} is {near} km from it.",
        )
        .with("lat", shown(swapped.lat_deg()))
        .with("lon", shown(swapped.lon_deg()))
        .with("near", km(near_m)),
        None => say(
            "The place is {distance} km from the vessel, and Go there goes {most} km at most: nothing was sent. Look at the \
             coordinates, or send the vessel by a plan.",
        ),
    };
    Some(Error::refused(text.with("distance", km(distance_m)).with("most", km(FARTHEST_M))))
}

/// Distance on a sphere (m), to half a percent at any length: haversine formula, mean radius of the earth.
fn far_m(from: LatLon, to: LatLon) -> f64 {
    let half = |from_rad: f64, to_rad: f64| ((to_rad - from_rad) / 2.0).sin().powi(2);
    let across = from.lat_rad().cos() * to.lat_rad().cos() * half(from.lon_rad(), to.lon_rad());
    2.0 * MEAN_RADIUS_M * (half(from.lat_rad(), to.lat_rad()) + across).sqrt().min(1.0).asin()
}

impl Judge {
    /// The guard's verdict; `None` without a chart.
    pub fn guard(&self, plan: &Plan) -> Option<api::Guard> {
        self.charts.guard(plan, self.from, &self.limits)
    }
}

impl Grounding {
    pub(crate) fn new(router: Router, people: People, fleet: Fleet, charts: Charts) -> Self {
        Self { router, people, fleet, charts }
    }

    /// For a plan that is started later. The transit to its first waypoint is checked from the vessel's position if the
    /// vessel is heard and in deep enough water: from a trailer or a quay an operator drives it out first.
    pub async fn of_drawing(&self, vessel: Option<Address>) -> Judge {
        let Some(vessel) = vessel else {
            let limits = Limits { demanded: *self.charts.limits(), of_vessel: false };
            return Judge { charts: self.charts.clone(), limits, from: None };
        };
        let judge = self.of(vessel).await;
        let from = self.fleet.place_now(vessel).await;
        Judge { from: from.filter(|place| judge.charts.afloat(*place, &judge.limits.demanded)), ..judge }
    }

    /// For a plan that starts now, from the vessel's last reported position.
    async fn of_start(&self, vessel: Address) -> Judge {
        Judge { from: self.fleet.place(vessel).await, ..self.of(vessel).await }
    }

    async fn of(&self, vessel: Address) -> Judge {
        let floor = self.charts.limits();
        let own = self.fleet.guard_limits(vessel, floor).await;
        let limits = Limits {
            demanded: own.map_or(*floor, |own| own.at_least(floor)),
            of_vessel: own.is_some_and(|own| own.autonomous_m >= floor.autonomous_m),
        };
        Judge { charts: self.charts.clone(), limits, from: None }
    }

    /// The limits for a vessel: its own where the user may see it, else the server's.
    pub async fn limits(&self, who: &Principal, vessel: Option<u16>) -> GuardLimits {
        match vessel.filter(|vessel| who.grants.on(*vessel).is_some()) {
            Some(vessel) => self.of(Address(vessel)).await.limits.demanded,
            None => *self.charts.limits(),
        }
    }

    /// Why the order is refused, if the chart shows danger on its way, or the way cannot be laid out on the chart: what the guard
    /// cannot judge is never passed as safe.
    ///
    /// # Errors
    /// Plans cannot be read, or the server is stopping.
    pub async fn danger(&self, vessel: Address, order: &Order) -> Result<Option<Error>> {
        if let Order::Goto { place, .. } = order
            && let Some(from) = self.fleet.place(vessel).await
            && let Some(refused) = too_far(from, *place)
        {
            return Ok(Some(refused));
        }
        let nothing = self.charts.set().is_none() && self.charts.trouble().is_none();
        if nothing && self.charts.not_closed().is_none() {
            return Ok(None);
        }
        let plan = match order {
            Order::StartPlan { plan_id } => match self.drawn_here(vessel, plan_id.clone()).await? {
                Some(plan) => Some(plan),
                None => self.reported(vessel, plan_id.clone()).await?,
            },
            other => other.plan(),
        };
        let Some(plan) = plan else { return Ok(None) };
        let judge = match order {
            // It is uploaded now and started later.
            Order::Upload(_) => self.of_drawing(Some(vessel)).await,
            _ => self.of_start(vessel).await,
        };
        let judged = move || match plans::understood(&plan) {
            Ok(plan) => {
                let guard = judge.guard(&plan).filter(|guard| guard.outcome == Outcome::Refused.code());
                guard.map(Error::grounding)
            }
            Err(problem) => Some(Error::refused(
                say("It cannot be checked against the chart and was not sent: {problem}")
                    .with_said("problem", problem),
            )),
        };
        slow(judged).await
    }

    /// The plan of that name as the vessel reported it, if it is still the one aboard.
    async fn reported(&self, vessel: Address, plan_id: String) -> Result<Option<PlanSpecification>> {
        let ask = move |operations: &mut Operations, _| {
            let commands = operations.commands();
            let aboard = commands.aboard(vessel)?;
            let md5 = aboard.plans.iter().find(|plan| plan.plan_id == plan_id)?.md5.clone();
            Some((commands.reports().plan(vessel, &plan_id)?.plan.clone(), md5))
        };
        let known = self.router.ask(ask).await?;
        let same = |(plan, md5): &(PlanSpecification, Vec<u8>)| {
            imc::plan_digest::plan_md5(plan).is_ok_and(|digest| digest[..] == md5[..])
        };
        Ok(known.filter(same).map(|(plan, _)| plan))
    }

    /// The plan of that name aboard, if it is one of those kept here.
    ///
    /// # Errors
    /// The server is stopping, or app.db cannot be read.
    pub async fn drawn_here(&self, vessel: Address, plan_id: String) -> Result<Option<PlanSpecification>> {
        let wanted = plan_id.clone();
        let ask = move |operations: &mut Operations, _| {
            let aboard = operations.commands().aboard(vessel)?;
            aboard.plans.iter().find(|plan| plan.plan_id == wanted).map(|plan| plan.md5.clone())
        };
        let Some(md5) = self.router.ask(ask).await? else { return Ok(None) };
        let mut rows = self.people.ask(plans::List).await?;
        rows.retain(|row| row.plan.name == plan_id);
        let same = move || {
            let specifications = rows.iter().filter_map(|row| plans::specification(&row.plan).ok());
            let digest = |plan: &PlanSpecification| imc::plan_digest::plan_md5(plan).ok();
            specifications.into_iter().find(|plan| digest(plan).is_some_and(|digest| digest[..] == md5[..]))
        };
        slow(same).await
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_far_away_is_refused_with_its_distance_and_the_swapped_coordinates_where_they_are_near() {
        let place = |lat_deg, lon_deg| LatLon::from_deg(lat_deg, lon_deg).unwrap();
        let from = place(63.44, 10.4);
        assert_eq!(too_far(from, place(63.5, 10.5)), None);
        // Distances by an independent calculation, to a kilometre.
        let swapped = too_far(from, place(10.5, 63.5)).unwrap().text.to_string();
        assert!(
            swapped.starts_with("The place is 7197 km from the vessel") && swapped.contains("100 km at most"),
            "{swapped}"
        );
        assert!(
            swapped.ends_with("Are latitude and longitude swapped? 63.5, 10.5 is 8 km from it."),
            "{swapped}"
        );
        let far = too_far(from, place(60.0, 5.0)).unwrap().text.to_string();
        assert!(far.contains("476 km") && far.ends_with("or send the vessel by a plan."), "{far}");
    }
}
