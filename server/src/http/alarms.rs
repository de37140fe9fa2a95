//! Alarms, for people to acknowledge or shelve.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who, extract};
use api::{Alarm, AlarmHistory, AlarmHistoryQuery, AlarmList, Role, ShelveRequest, say};
use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use shore::Wanted;
use shore::alarms::Notes;
use shore::identity::Principal;
use std::time::Duration;

/// `GET /api/v1/alarms`.
pub(crate) async fn list(State(state): State<AppState>, Who(who): Who) -> Result<Json<AlarmList>, ApiError> {
    let wanted = Wanted { grants: who.grants, ..Wanted::default() };
    Ok(Json(state.shore.alarms.list(wanted).await?))
}

/// `GET /api/v1/alarms/history`.
pub(crate) async fn history(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<AlarmHistoryQuery>,
) -> Result<Json<AlarmHistory>, ApiError> {
    let count = extract::number("limit", query.limit, 200, 1..=1_000)?;
    if let Some(priority) = query.priority.as_deref().filter(|one| !PRIORITIES.contains(one)) {
        let text = say("priority: `{priority}` is not one of {all}")
            .with("priority", priority)
            .with("all", PRIORITIES.join(", "));
        return Err(ApiError::bad_request(text));
    }
    let vessel = extract::vessel(&state.shore, &who, ("vessel", query.vessel.as_deref())).await?;
    let wanted = Notes {
        vessels: seen(&who),
        vessel: vessel.map(|vessel| vessel.0),
        priority: query.priority,
        from_us: query.from_us,
        to_us: query.to_us,
        before: query.before,
        count: count as u32,
    };
    let found = state.shore.alarms.past(wanted).await?;
    let next = if found.len() == count { found.last().map(|(number, _)| *number) } else { None };
    Ok(Json(AlarmHistory { notes: found.into_iter().map(|(_, note)| note).collect(), next }))
}

/// From the least urgent.
pub(crate) const PRIORITIES: [&str; 4] = ["caution", "warning", "alarm", "emergency"];

/// The vessels that a user may see; `None` for all.
pub(crate) fn seen(who: &Principal) -> Option<Vec<u16>> {
    if who.grants.everywhere().is_some() {
        return None;
    }
    Some(who.grants.vessels_with(Role::Viewer).collect())
}

/// Path parameters of one alarm.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct OneAlarm {
    id: u64,
}

/// `POST /api/v1/alarms/{id}/acknowledge`.
pub(crate) async fn acknowledge(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(OneAlarm { id }): InPath<OneAlarm>,
) -> Result<Json<Alarm>, ApiError> {
    Ok(Json(state.shore.alarms.acknowledge(&who, remote.address.to_string(), id).await?))
}

/// `POST /api/v1/alarms/{id}/shelve`.
pub(crate) async fn shelve(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(OneAlarm { id }): InPath<OneAlarm>,
    InBody(ShelveRequest { minutes, reason }): InBody<ShelveRequest>,
) -> Result<Json<Alarm>, ApiError> {
    let span = Duration::from_secs(u64::from(minutes) * 60);
    Ok(Json(state.shore.alarms.shelve(&who, remote.address.to_string(), id, span, reason).await?))
}
