//! Orders to vessels, from the asking to the end.
//!
//! A task of the server's carries each order, so that one is never left half done because whoever gave it went away. The
//! audit log holds that it was asked before it is sent; how far it gets (sent, received, its effect, or why not) is
//! written as it happens, by [`keep_log`], as is what happens to control by itself.

use super::error::ApiError;
use super::grounding;
use crate::people::{Fault, Line, People, Principal};
use crate::relay::Relay;
use crate::shore::{AppState, control};
use api::Command;
use axum::http::StatusCode;
use hub::{Change, Dispatched, Holder, Hub, LeaseEvent, LeaseRefused, Order};
use imc::messages::{Payload as _, PlanControlState, PlanControlStateState};
use imc::{Address, PacketView};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;

/// How long an order that is no stop waits for the audit log.
const AUDIT_PATIENCE: Duration = Duration::from_secs(5);
/// What happened is fetched at least so often; at once, when something did.
const LOG_EVERY: Duration = Duration::from_secs(1);

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
    /// As a command knows them.
    pub(super) fn asked(&self) -> hub::Asked {
        hub::Asked { name: self.who.name.clone(), actor: self.who.actor(), from: self.from.clone() }
    }

    /// As a lease knows them.
    pub(super) fn holder(&self) -> Holder {
        Holder { person: self.who.person, name: self.who.name.clone(), key: self.window.clone() }
    }
}

/// Gives a vessel an order: refused where the chart shows danger and without the lease, written into the audit log, sent by
/// the way that leads there. It is carried out whether anybody waits for this or not; what becomes of it is told by the
/// command's later stages.
///
/// # Errors
/// The order is none, somebody else has control, or the audit log cannot be written.
pub(crate) async fn issue(
    state: &AppState,
    vessel: Address,
    by: &Issuer,
    order: Order,
) -> Result<Command, ApiError> {
    let (told, outcome) = oneshot::channel();
    let (task, by) = (state.clone(), by.clone());
    state.tasks.spawn(async move {
        // Whoever asked may be gone.
        told.send(carry_out(&task, vessel, &by, order).await).ok();
    });
    outcome.await.unwrap_or_else(|_| Err(ApiError::internal(&"an order ended without a word")))
}

async fn carry_out(
    state: &AppState,
    vessel: Address,
    by: &Issuer,
    order: Order,
) -> Result<Command, ApiError> {
    let verb = order.verb();
    let stops = move |hub: &mut Hub, _| hub.commands().stops(vessel);
    let stops = state.relay.look(stops).await.map_err(|_| ApiError::stopping())?;
    let subjects = subjects(state, vessel, &order).await?;
    let refused = |text: &str| {
        for subject in &subjects {
            let (actor, address) = (by.who.actor(), by.from.clone());
            let (subject, outcome) = (subject.clone(), text.to_owned());
            state.people.note(Line { actor, address, action: verb, subject, outcome });
        }
    };
    if let Some(danger) = grounding::danger(state, vessel, &order).await? {
        refused(&danger.text);
        return Err(danger);
    }
    let (holder, asked) = (by.holder(), by.asked());
    let begin = move |hub: &mut Hub, now| {
        let epoch = if order.takes_lease() {
            hub.leases().epoch(now, vessel, &holder).map_err(|why| no_control(&why))?
        } else {
            0
        };
        if order.commands() && hub.commands().stops(vessel) != stops {
            return Err(unprocessable("a stop was ordered before it could be sent".to_owned()));
        }
        hub.commands_mut().begin(now, vessel, &asked, epoch, order).map_err(unprocessable)
    };
    let id = match state.relay.look(begin).await.map_err(|_| ApiError::stopping())? {
        Ok(id) => id,
        Err(error) => {
            refused(&error.text);
            return Err(error);
        }
    };
    if let Err(fault) = write_asked(state, by, verb, &subjects).await {
        tracing::error!(%vessel, verb, %fault, "an order is not sent: the audit log cannot be written");
        let why = "NOT SENT: the audit log cannot be written";
        let refuse = move |hub: &mut Hub, now| hub.commands_mut().refused(now, id, why.to_owned());
        state.relay.look(refuse).await.map_err(|_| ApiError::stopping())?;
        let error = ApiError::from(fault);
        let text = format!("{why}, and nothing is ordered without it. Try again; STOP works.");
        return Err(ApiError { text, ..error });
    }
    let holder = by.holder();
    let send = move |hub: &mut Hub, now| {
        dispatch(hub, now, id, vessel, Some(&holder));
        hub.commands().get(id).map(control::command)
    };
    let command = state.relay.look(send).await.map_err(|_| ApiError::stopping())?;
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

/// Writes into the audit log that an order was asked for.
async fn write_asked(
    state: &AppState,
    by: &Issuer,
    action: &'static str,
    subjects: &[String],
) -> Result<(), Fault> {
    let line = |subject: &String| {
        let (actor, address) = (by.who.actor(), by.from.clone());
        Line { actor, address, action, subject: subject.clone(), outcome: "asked".to_owned() }
    };
    state.people.record(subjects.iter().map(line).collect(), AUDIT_PATIENCE).await
}

/// Sends an order, if the lease that it was given under still holds; `None` for what takes none.
pub(super) fn dispatch(
    hub: &mut Hub,
    now: hub::Now,
    id: hub::CommandId,
    vessel: Address,
    holder: Option<&Holder>,
) -> Option<Dispatched> {
    let epoch = hub.commands().get(id).map_or(0, |command| command.epoch);
    if epoch != 0 && holder.is_none_or(|holder| hub.leases().epoch(now, vessel, holder) != Ok(epoch)) {
        hub.commands_mut().refused(now, id, "control was lost before it was sent".to_owned());
        return None;
    }
    let ran = running(hub, vessel);
    let order = hub.commands_mut().accepted(now, id, ran)?;
    let dispatched = hub.dispatch(now, order);
    hub.commands_mut().dispatched(now, id, &dispatched);
    Some(dispatched)
}

/// The plan that a vessel said it executes.
pub(super) fn running(hub: &Hub, vessel: Address) -> Option<String> {
    let (_, series) = hub.fleet().system(vessel)?.latest(PlanControlState::ID)?;
    let state: PlanControlState = imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()??;
    let runs = matches!(state.state, PlanControlStateState::Executing | PlanControlStateState::Initializing);
    runs.then(|| state.plan_id.to_str_lossy().into_owned())
}

/// What cannot be.
pub(super) fn unprocessable(text: String) -> ApiError {
    ApiError::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text)
}

/// Somebody else has control.
pub(super) fn no_control(why: &LeaseRefused) -> ApiError {
    ApiError::new(StatusCode::CONFLICT, "no_control", why.to_string())
}

/// Writes down how far commands get and what happens to leases by itself, until the server ends.
pub(crate) async fn keep_log(relay: Relay, people: People, stop: CancellationToken) {
    let mut changed = relay.revision();
    loop {
        let happened = async {
            // Without a hub nothing happens any more.
            if changed.changed().await.is_err() {
                std::future::pending::<()>().await;
            }
        };
        let ends = tokio::select! {
            () = stop.cancelled() => true,
            () = happened => false,
            () = tokio::time::sleep(LOG_EVERY) => false,
        };
        let drain = |hub: &mut Hub, _| (hub.leases_mut().drain(), hub.commands_mut().drain());
        let Ok(((leases, leases_lost), (commands, commands_lost))) = relay.look(drain).await else { return };
        if leases_lost + commands_lost > 0 {
            tracing::error!(leases_lost, commands_lost, "what happened is not all in the audit log");
        }
        for event in leases {
            tracing::info!(vessel = %event.vessel, change = event.change.name(), who = event.who, "control");
            if let Some(line) = of_lease(event) {
                people.note(line);
            }
        }
        for hub::CommandEvent { vessel, by, verb, subject, step } in commands {
            let stage = step.stage.name();
            tracing::info!(%vessel, actor = by.actor, verb, subject, stage, text = step.text, "command");
            let outcome =
                if step.text.is_empty() { stage.to_owned() } else { format!("{stage}: {}", step.text) };
            let subject = format!("{vessel} {subject}");
            people.note(Line { actor: by.actor, address: by.from, action: verb, subject, outcome });
        }
        if ends {
            return;
        }
    }
}

/// What happened to a lease by itself; what somebody asked for is written down where they ask.
fn of_lease(event: LeaseEvent) -> Option<Line> {
    let action = match event.change {
        Change::Expired => "lease.expired",
        Change::Unanswered => "lease.unanswered",
        Change::Granted => "lease.granted",
        Change::Requested
        | Change::HandedOver
        | Change::Declined
        | Change::Withdrawn
        | Change::Released
        | Change::TakenOver => return None,
    };
    let (subject, outcome) = (event.vessel.to_string(), "done".to_owned());
    Some(Line { actor: event.who, address: String::new(), action, subject, outcome })
}
