//! No-go areas, for programs and their pages.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who};
use api::{
    NoGoArea, NoGoAreaChange, NoGoAreaQuery, NoGoAreaRequest, NoGoAreas, NoGoAreasQuery, NoGoAreasRequest,
};
use axum::Json;
use axum::extract::State;

/// `GET /api/v1/no-go-areas`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<NoGoAreasQuery>,
) -> Result<Json<NoGoAreas>, ApiError> {
    Ok(Json(state.shore.areas.list(&who, query.lifted.unwrap_or(false)).await?))
}

/// `POST /api/v1/no-go-areas`.
pub(crate) async fn create(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(sent): QueryParams<NoGoAreaQuery>,
    InBody(ask): InBody<NoGoAreaRequest>,
) -> Result<Json<NoGoArea>, ApiError> {
    Ok(Json(state.shore.areas.create(&who, remote.address.to_string(), ask, sent).await?))
}

/// `POST /api/v1/no-go-areas/batch`.
pub(crate) async fn create_all(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(sent): QueryParams<NoGoAreaQuery>,
    InBody(ask): InBody<NoGoAreasRequest>,
) -> Result<Json<NoGoAreas>, ApiError> {
    Ok(Json(state.shore.areas.create_all(&who, remote.address.to_string(), ask, sent).await?))
}

/// `PATCH /api/v1/no-go-areas/{id}`.
pub(crate) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(change): InBody<NoGoAreaChange>,
) -> Result<Json<NoGoArea>, ApiError> {
    Ok(Json(state.shore.areas.change(&who, remote.address.to_string(), id, change).await?))
}
