//! The guard against grounding before a vessel is ordered to go somewhere.
//!
//! A plan that is drawn, saved or goes aboard, one that is to be started and a place to go to are held against the chart
//! by the limits that the vessel told of its own guard, but never with less water than the server demands. A plan
//! aboard is known by its digest: drawn here, or told by the vessel. One that is neither is judged by the vessel alone, if
//! it has a guard; a DUNE vessel has none.

use super::error::ApiError;
use crate::charts::{Charts, Limits};
use crate::people::Principal;
use crate::plans;
use crate::shore::AppState;
use axum::http::StatusCode;
use hub::{Hub, Order};
use imc::Address;
use imc::messages::PlanSpecification;
use mission::Plan;
use mission::guard::{GuardLimits, Outcome};
use units::LatLon;

/// What a plan is judged by.
pub(super) struct Judge {
    charts: Charts,
    limits: Limits,
    from: Option<LatLon>,
}

impl Judge {
    /// For a plan that is to be sailed some day. The way to its first place counts from where the vessel is, if it is
    /// heard and in water deep enough: from a trailer or a quay an operator takes it out first.
    pub(super) async fn of_drawing(state: &AppState, vessel: Option<Address>) -> Self {
        let Some(vessel) = vessel else {
            let limits = Limits { demanded: *state.charts.limits(), of_vessel: false };
            return Self { charts: state.charts.clone(), limits, from: None };
        };
        let judge = Self::of(state, vessel).await;
        let from = state.fleet.place_now(vessel).await;
        Self { from: from.filter(|place| judge.charts.afloat(*place, &judge.limits.demanded)), ..judge }
    }

    /// For a plan that begins now, wherever the vessel said last to be.
    async fn of_start(state: &AppState, vessel: Address) -> Self {
        Self { from: state.fleet.place(vessel).await, ..Self::of(state, vessel).await }
    }

    async fn of(state: &AppState, vessel: Address) -> Self {
        let floor = state.charts.limits();
        let own = state.fleet.guard_limits(vessel, floor).await;
        let limits = Limits {
            demanded: own.map_or(*floor, |own| own.at_least(floor)),
            of_vessel: own.is_some_and(|own| own.autonomous_m >= floor.autonomous_m),
        };
        Self { charts: state.charts.clone(), limits, from: None }
    }

    /// What is demanded of the water for a vessel, of which its own limits count for who may see it.
    pub(super) async fn limits(state: &AppState, who: &Principal, vessel: Option<u16>) -> GuardLimits {
        match vessel.filter(|vessel| who.grants.on(*vessel).is_some()) {
            Some(vessel) => Self::of(state, Address(vessel)).await.limits.demanded,
            None => *state.charts.limits(),
        }
    }

    /// What the guard says; `None` where there is no chart.
    pub(super) fn guard(&self, plan: &Plan) -> Option<api::Guard> {
        self.charts.guard(plan, self.from, &self.limits)
    }
}

/// Why the order is not given, if it leads into danger by the chart.
///
/// # Errors
/// Plans cannot be read, or the server is stopping.
pub(crate) async fn danger(
    state: &AppState,
    vessel: Address,
    order: &Order,
) -> Result<Option<ApiError>, ApiError> {
    if state.charts.set().is_none() && state.charts.trouble().is_none() {
        return Ok(None);
    }
    let plan = match order {
        Order::StartPlan { plan_id } => match drawn_here(state, vessel, plan_id.clone()).await? {
            Some(plan) => Some(plan),
            None => told(state, vessel, plan_id.clone()).await?,
        },
        other => other.plan(),
    };
    let Some(plan) = plan else { return Ok(None) };
    let judge = match order {
        // It goes aboard today and is started another day.
        Order::Upload(_) => Judge::of_drawing(state, Some(vessel)).await,
        _ => Judge::of_start(state, vessel).await,
    };
    let judged = move || plans::understood(&plan).and_then(|plan| judge.guard(&plan));
    let guard = tokio::task::spawn_blocking(judged).await.map_err(|error| ApiError::internal(&error))?;
    Ok(guard.filter(|guard| guard.outcome == Outcome::Refused.code()).map(|guard| {
        let text = format!("The chart shows danger: {}", guard.text);
        ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "grounding", text)
    }))
}

/// The plan of that name as the vessel told it, if it is still the one aboard.
async fn told(
    state: &AppState,
    vessel: Address,
    plan_id: String,
) -> Result<Option<PlanSpecification>, ApiError> {
    let look = move |hub: &mut Hub, _| {
        let commands = hub.commands();
        let aboard = commands.aboard(vessel)?;
        let md5 = aboard.plans.iter().find(|plan| plan.plan_id == plan_id)?.md5.clone();
        Some((commands.told().plan(vessel, &plan_id)?.plan.clone(), md5))
    };
    let known = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    let same = |(plan, md5): &(PlanSpecification, Vec<u8>)| {
        imc::plan_digest::plan_md5(plan).is_ok_and(|digest| digest[..] == md5[..])
    };
    Ok(known.filter(same).map(|(plan, _)| plan))
}

/// The plan of that name aboard, if it is one of those kept here.
pub(super) async fn drawn_here(
    state: &AppState,
    vessel: Address,
    plan_id: String,
) -> Result<Option<PlanSpecification>, ApiError> {
    let wanted = plan_id.clone();
    let look = move |hub: &mut Hub, _| {
        let aboard = hub.commands().aboard(vessel)?;
        aboard.plans.iter().find(|plan| plan.plan_id == wanted).map(|plan| plan.md5.clone())
    };
    let Some(md5) = state.relay.look(look).await.map_err(|_| ApiError::stopping())? else { return Ok(None) };
    let mut rows = state.people.ask(plans::List).await?;
    rows.retain(|row| row.plan.name == plan_id);
    let same = move || {
        let specifications = rows.iter().filter_map(|row| plans::specification(&row.plan).ok());
        let digest = |plan: &PlanSpecification| imc::plan_digest::plan_md5(plan).ok();
        specifications.into_iter().find(|plan| digest(plan).is_some_and(|digest| digest[..] == md5[..]))
    };
    tokio::task::spawn_blocking(same).await.map_err(|error| ApiError::internal(&error))
}
