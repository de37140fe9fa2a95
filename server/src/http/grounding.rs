//! The guard against grounding before a vessel is ordered to go somewhere.
//!
//! A plan that goes aboard, one that is to be started and a place to go to are held against the chart with the way
//! from where the vessel said last to be. A plan aboard is known by its digest: one that nobody drew here is judged
//! by the vessel alone, which has the same guard.

use super::error::ApiError;
use crate::plans;
use crate::shore::AppState;
use axum::http::StatusCode;
use hub::{Hub, Order};
use imc::Address;
use imc::messages::PlanSpecification;
use mission::guard::Outcome;

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
        Order::StartPlan { plan_id } => drawn_here(state, vessel, plan_id.clone()).await?,
        other => other.plan(),
    };
    let Some(plan) = plan else { return Ok(None) };
    let from = state.fleet.place(vessel).await;
    let charts = state.charts.clone();
    let judge = move || plans::understood(&plan).and_then(|plan| charts.guard(&plan, from));
    let guard = tokio::task::spawn_blocking(judge).await.map_err(|error| ApiError::internal(&error))?;
    Ok(guard.filter(|guard| guard.outcome == Outcome::Refused.code()).map(|guard| {
        let text = format!("The chart shows danger: {}", guard.text);
        ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "grounding", text)
    }))
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
    let mut rows = state.people.ask(plans::list).await?;
    rows.retain(|row| row.plan.name == plan_id);
    let same = move || {
        let specifications = rows.iter().filter_map(|row| plans::specification(&row.plan).ok());
        let digest = |plan: &PlanSpecification| imc::plan_digest::plan_md5(plan).ok();
        specifications.into_iter().find(|plan| digest(plan).is_some_and(|digest| digest[..] == md5[..]))
    };
    tokio::task::spawn_blocking(same).await.map_err(|error| ApiError::internal(&error))
}
