//! Leases of vessels, orders and commands.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, OfVessel, QueryParams, Remote, Who};
use api::{
    Command, LeaseAction, LeaseRequest, Order as OrderWanted, OrderRequest, Ordered, PlanUnderWay,
    PlansAboard, StopQuery, VesselParameters, VesselQuery, VesselQuerySent, say,
};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use operations::Order;
use serde::Deserialize;
use shore::commands::Issuer;
use units::LatLon;

/// `GET /api/v1/vessels/{vessel}/lease`.
pub(crate) async fn lease(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<api::Lease>, ApiError> {
    Ok(Json(state.shore.commands.lease(vessel).await?))
}

/// `POST /api/v1/vessels/{vessel}/lease`.
pub(crate) async fn ask_lease(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    remote: Remote,
    InBody(LeaseRequest { action, reason, window }): InBody<LeaseRequest>,
) -> Result<Json<api::Lease>, ApiError> {
    let by = Issuer { who, from: remote.address.to_string(), window };
    let ask = match action {
        LeaseAction::Request => operations::LeaseRequest::Request(reason.clone()),
        LeaseAction::Grant => operations::LeaseRequest::Grant,
        LeaseAction::Decline => operations::LeaseRequest::Decline,
        LeaseAction::Release => operations::LeaseRequest::Release,
        LeaseAction::Renew => operations::LeaseRequest::Renew,
        LeaseAction::Take => operations::LeaseRequest::Take(reason.clone()),
    };
    Ok(Json(state.shore.commands.ask_lease(vessel, by, ask, &reason).await?))
}

/// `POST /api/v1/vessels/{vessel}/abort`.
pub(crate) async fn abort(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    remote: Remote,
    QueryParams(StopQuery { window, key }): QueryParams<StopQuery>,
) -> Result<Json<Ordered>, ApiError> {
    let by = Issuer { who, from: remote.address.to_string(), window };
    Ok(Json(state.shore.commands.stop(vessel, by, &key).await?))
}

/// `POST /api/v1/vessels/{vessel}/commands`.
pub(crate) async fn order(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    remote: Remote,
    InBody(OrderRequest { order, window }): InBody<OrderRequest>,
) -> Result<(StatusCode, Json<Command>), ApiError> {
    let by = Issuer { who, from: remote.address.to_string(), window };
    let command = state.shore.commands.issue(vessel, &by, understood(order)?).await?;
    Ok((StatusCode::ACCEPTED, Json(command)))
}

/// `GET /api/v1/vessels/{vessel}/commands`.
pub(crate) async fn commands(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<Vec<Command>>, ApiError> {
    Ok(Json(state.shore.commands.latest(vessel).await?))
}

/// Path parameters of one command.
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
    let found = state.shore.commands.one(vessel, id).await?;
    found
        .map(Json)
        .ok_or_else(|| ApiError::not_found(say("No such command; the latest 100 of a vessel are kept.")))
}

/// `GET /api/v1/vessels/{vessel}/plans`.
pub(crate) async fn plans(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<PlansAboard>, ApiError> {
    Ok(Json(state.shore.commands.plans_aboard(vessel).await?))
}

/// `GET /api/v1/vessels/{vessel}/parameters`.
pub(crate) async fn parameters(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<VesselParameters>, ApiError> {
    Ok(Json(state.shore.reports.parameters(vessel).await?))
}

/// `POST /api/v1/vessels/{vessel}/ask`.
pub(crate) async fn ask(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    InBody(asked): InBody<VesselQuery>,
) -> Result<Json<VesselQuerySent>, ApiError> {
    Ok(Json(state.shore.reports.ask(vessel, asked).await?))
}

/// `GET /api/v1/vessels/{vessel}/plan`.
pub(crate) async fn plan(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
) -> Result<Json<PlanUnderWay>, ApiError> {
    Ok(Json(state.shore.reports.plan(vessel).await?))
}

/// Converts an order for the hub.
fn understood(order: OrderWanted) -> Result<Order, ApiError> {
    Ok(match order {
        OrderWanted::PlanStart { plan_id } => Order::StartPlan { plan_id },
        OrderWanted::PlanStop {} => Order::StopPlan,
        OrderWanted::Goto { lat_deg, lon_deg, speed_mps } => {
            let place = LatLon::from_deg(lat_deg, lon_deg).map_err(|error| {
                let text = say("{lat}, {lon} is not a place: {error}");
                shore::Error::refused(text.with("lat", lat_deg).with("lon", lon_deg).with("error", error))
            })?;
            Order::Goto { place, speed_mps }
        }
        OrderWanted::PlanDelete { plan_id } => Order::Delete { plan_id },
        OrderWanted::PlanList {} => Order::List,
        OrderWanted::PlanGet { plan_id } => Order::Get { plan_id },
        OrderWanted::ParametersQuery { entity } => Order::QueryParameters { entity },
        OrderWanted::ParametersSet { entity, values } => {
            let values = values.into_iter().map(|one| (one.name, one.value)).collect();
            Order::SetParameters { entity, values }
        }
        OrderWanted::ParametersSave { entity } => Order::SaveParameters { entity },
    })
}
