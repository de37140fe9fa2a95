//! What is wrong, for people to acknowledge or to put aside.

use super::error::ApiError;
use super::extract::{InBody, InPath};
use super::guard::Who;
use super::remote::Remote;
use crate::AppState;
use api::{Alarm, AlarmList, ShelveAsk};
use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use shore::Wanted;
use std::time::Duration;

/// `GET /api/v1/alarms`.
pub(crate) async fn list(State(state): State<AppState>, Who(who): Who) -> Result<Json<AlarmList>, ApiError> {
    let wanted = Wanted { grants: who.grants, ..Wanted::default() };
    Ok(Json(state.shore.alarms.list(wanted).await?))
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
    InBody(ShelveAsk { minutes, reason }): InBody<ShelveAsk>,
) -> Result<Json<Alarm>, ApiError> {
    let span = Duration::from_secs(u64::from(minutes) * 60);
    Ok(Json(state.shore.alarms.shelve(&who, remote.address.to_string(), id, span, reason).await?))
}
