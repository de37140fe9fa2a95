//! Who commands a vessel, and what it is ordered to do.
//!
//! Everything that somebody asks for stands in the audit log before it is done; what happens by itself (a lease that
//! expires) is written by [`keep_log`].

use super::asked::InPath;
use super::caller::Caller;
use super::error::ApiError;
use super::grounding;
use super::guard::{OfVessel, Who};
use crate::people::{Fault, People, Principal};
use crate::relay::Relay;
use crate::shore::{AppState, control};
use api::{Command, LeaseAction, LeaseAsk, Order as Asked, OrderAsk, PlansAboard};
use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request, State};
use axum::http::StatusCode;
use hub::{Change, CommandId, Door, Holder, Hub, LeaseRefused, Order, Outgoing};
use imc::messages::{Payload as _, PlanControlState, PlanControlStateState};
use imc::{Address, PacketView};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use units::LatLon;

/// Commands that are told at once.
const TOLD: usize = 100;
/// How often what happened to leases by itself is written down.
const LOG_EVERY: Duration = Duration::from_secs(1);

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

/// Who orders, from where.
#[derive(Debug, Clone)]
pub(crate) struct Issuer {
    /// The person.
    pub(crate) who: Principal,
    /// The network address, for the audit log.
    pub(crate) from: String,
    /// Which of the person's windows.
    pub(crate) window: String,
}

impl Issuer {
    /// As a lease knows them.
    pub(super) fn holder(&self) -> Holder {
        Holder { person: self.who.person, name: self.who.name.clone(), key: self.window.clone() }
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
    // That a page is still there is no act of anybody.
    if !name.is_empty() {
        state.people.act(&by.who, by.from.clone(), name, subject.clone(), |_| Ok(())).await?;
    }
    let holder = by.holder();
    let change = move |hub: &mut Hub, now| {
        hub.leases_mut().ask(now, vessel, &holder, ask)?;
        Ok::<_, LeaseRefused>(control::lease(vessel, hub.leases().of(vessel)))
    };
    match state.relay.look(change).await.map_err(|_| ApiError::stopping())? {
        Ok(lease) => Ok(Json(lease)),
        Err(why) => {
            if !name.is_empty() {
                let refused = Fault::Refused(why.to_string());
                state.people.act(&by.who, by.from, name, subject, |_| Err::<(), _>(refused)).await.ok();
            }
            Err(no_control(&why))
        }
    }
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

/// Gives a vessel an order: refused where the chart shows danger and without the lease, written into the audit log, sent by the door that leads there.
/// What becomes of it is told by the command's later stages.
///
/// # Errors
/// The order is none, somebody else has control, or the audit log cannot be written.
pub(crate) async fn issue(
    state: &AppState,
    vessel: Address,
    by: &Issuer,
    order: Order,
) -> Result<Command, ApiError> {
    let verb = order.verb();
    let subjects = subjects(state, vessel, &order).await?;
    if let Some(danger) = grounding::danger(state, vessel, &order).await? {
        write_down(state, by, verb, &subjects, Some(&danger.text)).await.ok();
        return Err(danger);
    }
    let holder = by.holder();
    let begin = move |hub: &mut Hub, now| {
        let epoch = if order.commands() {
            hub.leases().epoch(now, vessel, &holder).map_err(|why| no_control(&why))?
        } else {
            0
        };
        hub.commands_mut().begin(now, vessel, &holder.name, epoch, order).map_err(refused)
    };
    let begun = state.relay.look(begin).await.map_err(|_| ApiError::stopping())?;
    let id = match begun {
        Ok(id) => id,
        Err(error) => {
            write_down(state, by, verb, &subjects, Some(&error.text)).await.ok();
            return Err(error);
        }
    };
    if let Err(fault) = write_down(state, by, verb, &subjects, None).await {
        let why = format!("the audit log cannot be written: {fault}");
        let refuse = move |hub: &mut Hub, now| hub.commands_mut().refused(now, id, why);
        state.relay.look(refuse).await.map_err(|_| ApiError::stopping())?;
        return Err(fault.into());
    }
    let link = state.links.is_up(vessel);
    let holder = by.holder();
    let send = move |hub: &mut Hub, now| dispatch(hub, now, (id, vessel), &holder, link);
    if let Some(order) = state.relay.look(send).await.map_err(|_| ApiError::stopping())?
        && !state.links.order(vessel, id, order)
    {
        let refuse = move |hub: &mut Hub, now| {
            hub.commands_mut().refused(now, id, "too much waits for this vessel's link".to_owned());
        };
        state.relay.look(refuse).await.map_err(|_| ApiError::stopping())?;
    }
    let look = move |hub: &mut Hub, _| hub.commands().get(id).map(control::command);
    let command = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    command.ok_or_else(|| ApiError::internal(&"a command was forgotten while it was open"))
}

/// What an order is about, as the audit log has it: each parameter by itself, with its value before.
async fn subjects(state: &AppState, vessel: Address, order: &Order) -> Result<Vec<String>, ApiError> {
    let subjects = if let Order::SetParameters { .. } = order {
        let order = order.clone();
        let look = move |hub: &mut Hub, _| hub.commands().subjects(vessel, &order);
        state.relay.look(look).await.map_err(|_| ApiError::stopping())?
    } else {
        vec![order.subject()]
    };
    Ok(subjects.into_iter().map(|subject| format!("{vessel} {subject}")).collect())
}

/// Writes an order into the audit log: as done, or why it is refused.
async fn write_down(
    state: &AppState,
    by: &Issuer,
    verb: &'static str,
    subjects: &[String],
    refused: Option<&str>,
) -> Result<(), Fault> {
    for subject in subjects {
        let outcome = refused.map_or(Ok(()), |why| Err(Fault::Refused(why.to_owned())));
        let written =
            state.people.act(&by.who, by.from.clone(), verb, subject.clone(), move |_| outcome).await;
        // A refusal comes back when it stands in the log.
        if refused.is_none() {
            written?;
        }
    }
    Ok(())
}

/// Sends an order that is in the audit log, if its lease still holds. What has to go by the link is given back.
fn dispatch(
    hub: &mut Hub,
    now: hub::Now,
    (id, vessel): (CommandId, Address),
    holder: &Holder,
    link: Option<bool>,
) -> Option<Outgoing> {
    let epoch = hub.commands().get(id)?.epoch;
    if epoch != 0 && hub.leases().epoch(now, vessel, holder) != Ok(epoch) {
        hub.commands_mut().refused(now, id, "control was lost before it was sent".to_owned());
        return None;
    }
    let ran = running(hub, vessel);
    let order = hub.commands_mut().accepted(now, id, ran)?;
    let elsewhere = hub.doors_to(now.mono, vessel).any(|door| door != Door::Link);
    match link {
        Some(up) if up || !elsewhere => {
            hub.record_own(now, &order.packet);
            if up {
                hub.commands_mut().sent(now, id, "by the link");
            }
            Some(order)
        }
        _ => {
            if hub.send(now, &order.packet) {
                hub.commands_mut().sent(now, id, "");
            } else {
                hub.commands_mut().refused(now, id, "no door leads to the vessel at present".to_owned());
            }
            None
        }
    }
}

/// The plan that a vessel said it executes.
pub(super) fn running(hub: &Hub, vessel: Address) -> Option<String> {
    let (_, series) = hub.fleet().system(vessel)?.latest(PlanControlState::ID)?;
    let state: PlanControlState = imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()??;
    let runs = matches!(state.state, PlanControlStateState::Executing | PlanControlStateState::Initializing);
    runs.then(|| state.plan_id.to_str_lossy().into_owned())
}

/// An order as the hub has it.
fn understood(order: Asked) -> Result<Order, ApiError> {
    Ok(match order {
        Asked::PlanStart { plan_id } => Order::StartPlan { plan_id },
        Asked::PlanStop {} => Order::StopPlan,
        Asked::Goto { lat_deg, lon_deg, speed_mps } => {
            let place = LatLon::from_deg(lat_deg, lon_deg).map_err(|error| refused(error.to_string()))?;
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

fn refused(text: String) -> ApiError {
    ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text)
}

fn no_control(why: &LeaseRefused) -> ApiError {
    ApiError::new(StatusCode::CONFLICT, "no_control", why.to_string())
}

/// Writes down what happens to leases by itself, until the server ends.
pub(crate) async fn keep_log(relay: Relay, people: People, stop: CancellationToken) {
    let mut every = tokio::time::interval(LOG_EVERY);
    while stop.run_until_cancelled(every.tick()).await.is_some() {
        let Ok((events, forgotten)) = relay.look(|hub, _| hub.leases_mut().drain()).await else { return };
        if forgotten > 0 {
            tracing::error!(forgotten, "changes of control are not in the audit log");
        }
        for event in events {
            tracing::info!(vessel = %event.vessel, change = event.change.name(), who = event.who, "control");
            let action = match event.change {
                Change::Expired => "lease.expired",
                Change::Unanswered => "lease.unanswered",
                Change::Granted => "lease.granted",
                Change::Requested
                | Change::HandedOver
                | Change::Declined
                | Change::Withdrawn
                | Change::Released
                | Change::TakenOver => continue,
            };
            let subject = event.vessel.to_string();
            if let Err(error) = people.write_down(event.who, action, subject, "done".to_owned()).await {
                tracing::error!(%error, "a change of control is not in the audit log");
            }
        }
    }
}
