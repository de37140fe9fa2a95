//! Recorded missions, for programs and their pages.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who, extract};
use api::{Mission, MissionChange, MissionQuery, MissionRequest, MissionSummary, Missions, MissionsQuery};
use axum::Json;
use axum::extract::State;

/// `GET /api/v1/missions`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<MissionsQuery>,
) -> Result<Json<Missions>, ApiError> {
    let count = extract::number("limit", query.limit, 100, 1..=500)? as u32;
    let (withdrawn, before) = (query.withdrawn.unwrap_or(false), query.before.as_deref());
    Ok(Json(state.shore.missions.page(&who, withdrawn, before, count).await?))
}

/// `POST /api/v1/missions`.
pub(crate) async fn create(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(sent): QueryParams<MissionQuery>,
    InBody(ask): InBody<MissionRequest>,
) -> Result<Json<Mission>, ApiError> {
    Ok(Json(state.shore.missions.create(&who, remote.address.to_string(), ask, sent).await?))
}

/// `GET /api/v1/missions/{id}`.
pub(crate) async fn one(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
) -> Result<Json<Mission>, ApiError> {
    Ok(Json(state.shore.missions.one(&who, id).await?))
}

/// `PATCH /api/v1/missions/{id}`.
pub(crate) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(change): InBody<MissionChange>,
) -> Result<Json<Mission>, ApiError> {
    Ok(Json(state.shore.missions.change(&who, remote.address.to_string(), id, change).await?))
}

/// `DELETE /api/v1/missions/{id}`.
pub(crate) async fn withdraw(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<Json<Mission>, ApiError> {
    Ok(Json(state.shore.missions.withdraw(&who, remote.address.to_string(), id).await?))
}

/// `GET /api/v1/missions/{id}/summary`.
pub(crate) async fn summary(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
) -> Result<Json<MissionSummary>, ApiError> {
    Ok(Json(state.shore.missions.summary(&who, id).await?))
}
