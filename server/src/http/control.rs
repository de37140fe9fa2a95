//! Who commands a vessel, and what it is ordered to do: the doors for browsers and scripts.
//!
//! Control is taken and given back without waiting for anything: it is in memory, and is written down afterwards. How
//! orders are carried out stands in [`super::orders`].

use super::asked::InPath;
use super::caller::Caller;
use super::error::ApiError;
use super::guard::{OfVessel, Who};
use super::orders::{Issuer, issue, no_control, unprocessable};
use crate::people::Line;
use crate::shore::{AppState, control};
use api::{Command, LeaseAction, LeaseAsk, Order as Asked, OrderAsk, PlansAboard};
use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request, State};
use axum::http::StatusCode;
use hub::{CommandId, Hub, LeaseRefused, Order};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use units::LatLon;

/// Commands that are told at once.
const TOLD: usize = 100;

/// JSON in the body; a refusal says what is wrong with it.
pub(crate) struct InBody<T>(pub(crate) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for InBody<T> {
    type Rejection = ApiError;
    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let body = Json::<T>::from_request(request, state).await;
        body.map(|Json(body)| Self(body)).map_err(|error: JsonRejection| {
            ApiError::malformed(
                error.status(),
                format!("{}; /api/v1/openapi.json tells all", error.body_text()),
            )
        })
    }
}

/// `GET /api/v1/vessels/{vessel}/lease`.
pub(crate) async fn lease(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<api::Lease>, ApiError> {
    let look = move |hub: &mut Hub, _| control::lease(vessel, hub.leases().of(vessel));
    Ok(Json(state.relay.look(look).await.map_err(|_| ApiError::stopping())?))
}

/// `POST /api/v1/vessels/{vessel}/lease`.
pub(crate) async fn ask_lease(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    caller: Caller,
    InBody(LeaseAsk { action, reason, window }): InBody<LeaseAsk>,
) -> Result<Json<api::Lease>, ApiError> {
    let by = Issuer { who, from: caller.address.to_string(), window };
    let subject = if reason.is_empty() { vessel.to_string() } else { format!("{vessel}: {reason}") };
    let (name, ask) = match action {
        LeaseAction::Request => ("lease.request", hub::LeaseAsk::Request(reason)),
        LeaseAction::Grant => ("lease.grant", hub::LeaseAsk::Grant),
        LeaseAction::Decline => ("lease.decline", hub::LeaseAsk::Decline),
        LeaseAction::Release => ("lease.release", hub::LeaseAsk::Release),
        LeaseAction::Renew => ("", hub::LeaseAsk::Renew),
        LeaseAction::Take => ("lease.take", hub::LeaseAsk::Take(reason)),
    };
    let holder = by.holder();
    let change = move |hub: &mut Hub, now| {
        hub.leases_mut().ask(now, vessel, &holder, ask)?;
        Ok::<_, LeaseRefused>(control::lease(vessel, hub.leases().of(vessel)))
    };
    let changed = state.relay.look(change).await.map_err(|_| ApiError::stopping())?;
    // That a page is still there is no act of anybody. All else is written down once it is so, and nobody waits for that:
    // control of a boat is taken and given back also while the disk hangs.
    if !name.is_empty() {
        let outcome = changed.as_ref().map_or_else(ToString::to_string, |_| "done".to_owned());
        state.people.note(Line { actor: by.who.actor(), address: by.from, action: name, subject, outcome });
    }
    changed.map(Json).map_err(|why| no_control(&why))
}

/// `POST /api/v1/vessels/{vessel}/commands`.
pub(crate) async fn order(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    caller: Caller,
    InBody(OrderAsk { order, window }): InBody<OrderAsk>,
) -> Result<(StatusCode, Json<Command>), ApiError> {
    let by = Issuer { who, from: caller.address.to_string(), window };
    let command = issue(&state, vessel, &by, understood(order)?).await?;
    Ok((StatusCode::ACCEPTED, Json(command)))
}

/// `GET /api/v1/vessels/{vessel}/commands`.
pub(crate) async fn commands(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<Vec<Command>>, ApiError> {
    let look = move |hub: &mut Hub, _| hub.commands().of(vessel).take(TOLD).map(control::command).collect();
    Ok(Json(state.relay.look(look).await.map_err(|_| ApiError::stopping())?))
}

/// What stands in the path of one command.
#[derive(Debug, Deserialize)]
pub(crate) struct OneCommand {
    id: u64,
}

/// `GET /api/v1/vessels/{vessel}/commands/{id}`.
pub(crate) async fn one(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    InPath(OneCommand { id }): InPath<OneCommand>,
) -> Result<Json<Command>, ApiError> {
    let look = move |hub: &mut Hub, _| {
        hub.commands().get(CommandId(id)).filter(|one| one.vessel == vessel).map(control::whole)
    };
    let found = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    found
        .map(Json)
        .ok_or_else(|| ApiError::not_found("No such command; the latest 100 of a vessel are kept."))
}

/// `GET /api/v1/vessels/{vessel}/plans`.
pub(crate) async fn plans(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<PlansAboard>, ApiError> {
    let look = move |hub: &mut Hub, _| control::aboard(hub.commands().aboard(vessel));
    Ok(Json(state.relay.look(look).await.map_err(|_| ApiError::stopping())?))
}

/// An order as the hub has it.
fn understood(order: Asked) -> Result<Order, ApiError> {
    Ok(match order {
        Asked::PlanStart { plan_id } => Order::StartPlan { plan_id },
        Asked::PlanStop {} => Order::StopPlan,
        Asked::Goto { lat_deg, lon_deg, speed_mps } => {
            let place =
                LatLon::from_deg(lat_deg, lon_deg).map_err(|error| unprocessable(error.to_string()))?;
            Order::Goto { place, speed_mps }
        }
        Asked::PlanDelete { plan_id } => Order::Delete { plan_id },
        Asked::PlanList {} => Order::List,
        Asked::PlanGet { plan_id } => Order::Get { plan_id },
        Asked::ParametersQuery { entity } => Order::QueryParameters { entity },
        Asked::ParametersSet { entity, values } => {
            let values = values.into_iter().map(|one| (one.name, one.value)).collect();
            Order::SetParameters { entity, values }
        }
        Asked::ParametersSave { entity } => Order::SaveParameters { entity },
    })
}
