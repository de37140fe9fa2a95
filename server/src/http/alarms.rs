//! What is wrong, for people to acknowledge or to put aside.

use super::asked::InPath;
use super::caller::Caller;
use super::control::InBody;
use super::error::ApiError;
use super::guard::Who;
use crate::people::{ASK_PATIENCE, Fault, Line, Principal};
use crate::shore::{AppState, Wanted, alarms};
use api::{Alarm, AlarmList, Role, ShelveAsk};
use axum::Json;
use axum::extract::State;
use hub::alarm::{AlarmId, AlarmRefused};
use hub::{Hub, Now};
use serde::Deserialize;
use std::time::Duration;

/// `GET /api/v1/alarms`.
pub(crate) async fn list(State(state): State<AppState>, Who(who): Who) -> Result<Json<AlarmList>, ApiError> {
    let wanted = Wanted { grants: who.grants, ..Wanted::default() };
    let look = move |hub: &mut Hub, _: Now| {
        let standing = hub.alarms().standing().filter(|one| alarms::admits(&wanted, &one.key));
        let mut standing: Vec<_> = standing.collect();
        standing.sort_by_key(|one| std::cmp::Reverse((one.priority, one.since)));
        let history = hub.alarms().notes().rev().filter(|one| alarms::admits(&wanted, &one.key));
        AlarmList {
            standing: standing.into_iter().map(|one| alarms::alarm(hub.fleet(), one)).collect(),
            history: history.map(alarms::note).collect(),
        }
    };
    let mut list = state.relay.look(look).await.map_err(|_| ApiError::stopping())?;
    alarms::name(&state.people, &mut list.standing);
    Ok(Json(list))
}

/// What stands in the path of one alarm.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct OneAlarm {
    id: u64,
}

/// `POST /api/v1/alarms/{id}/acknowledge`.
pub(crate) async fn acknowledge(
    State(state): State<AppState>,
    Who(who): Who,
    caller: Caller,
    InPath(OneAlarm { id }): InPath<OneAlarm>,
) -> Result<Json<Alarm>, ApiError> {
    let by = who.name.clone();
    let act = move |hub: &mut Hub, now: Now| hub.alarms_mut().acknowledge(now, AlarmId(id), &by);
    change(&state, &who, &caller, AlarmId(id), "alarm.acknowledge", act).await
}

/// `POST /api/v1/alarms/{id}/shelve`.
pub(crate) async fn shelve(
    State(state): State<AppState>,
    Who(who): Who,
    caller: Caller,
    InPath(OneAlarm { id }): InPath<OneAlarm>,
    InBody(ShelveAsk { minutes, reason }): InBody<ShelveAsk>,
) -> Result<Json<Alarm>, ApiError> {
    let (by, span) = (who.name.clone(), Duration::from_secs(u64::from(minutes) * 60));
    let act = move |hub: &mut Hub, now: Now| hub.alarms_mut().shelve(now, AlarmId(id), &by, span, &reason);
    change(&state, &who, &caller, AlarmId(id), "alarm.shelve", act).await
}

/// Does something to an alarm in somebody's name: an operator on its vessel, or anywhere where it is the server's own.
async fn change(
    state: &AppState,
    who: &Principal,
    caller: &Caller,
    id: AlarmId,
    action: &'static str,
    act: impl FnOnce(&mut Hub, Now) -> Result<(), AlarmRefused> + Send + 'static,
) -> Result<Json<Alarm>, ApiError> {
    let find = move |hub: &mut Hub, _: Now| hub.alarms().get(id).map(|one| alarms::alarm(hub.fleet(), one));
    let known = state.relay.look(find).await.map_err(|_| ApiError::stopping())?;
    let seen = |vessel: Option<u16>| vessel.is_none_or(|vessel| who.grants.on(vessel).is_some());
    let known = known.filter(|known| seen(known.vessel));
    let known = known.ok_or_else(|| ApiError::not_found("There is no such alarm any more."))?;
    let role = known.vessel.map_or_else(|| who.grants.somewhere(), |vessel| who.grants.on(vessel));
    if role < Some(Role::Operator) {
        let place = known.vessel.map_or("a vessel".to_owned(), |vessel| format!("vessel {vessel}"));
        let text =
            format!("{} may not do this: it takes the role operator on {place}. Ask an admin.", who.name);
        return Err(ApiError::forbidden(text));
    }
    let place = known.vessel.map_or("server".to_owned(), |vessel| imc::Address(vessel).to_string());
    let subject = format!("{place} {} {}: {}", known.kind, known.part, known.text);
    let from = caller.address.to_string();
    // The word counts even where it cannot be written down: an alarm must not sound for want of a disk.
    let done = move |hub: &mut Hub, now: Now| {
        act(hub, now)?;
        let known = hub.alarms().get(id).map(|one| alarms::alarm(hub.fleet(), one));
        known.ok_or(AlarmRefused::Gone)
    };
    let mut outcome = state.relay.look(done).await.map_err(|_| ApiError::stopping())?;
    if let Ok(known) = &mut outcome {
        alarms::name(&state.people, std::slice::from_mut(known));
    }
    let told = outcome.as_ref().err().map_or_else(|| "done".to_owned(), ToString::to_string);
    let line = Line { actor: who.actor(), address: from, action, subject, outcome: told };
    if let Err(error) = state.people.record(vec![line], ASK_PATIENCE).await {
        tracing::error!(%error, action, "is not in the audit log");
    }
    outcome.map(Json).map_err(|why| Fault::Refused(why.to_string()).into())
}
