//! The register of studies, for programs and its page.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who, WholeBody};
use api::{
    RegisterAnswer, RegisterChange, RegisterDeleteQuery, RegisterEntry, RegisterImport, RegisterImportQuery,
    RegisterQuery, RegisterRecord, say,
};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use shore::register::Register;

/// `GET /api/v1/register`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<RegisterQuery>,
) -> Result<Json<RegisterAnswer>, ApiError> {
    let kind = query.kind.as_deref().map(Register::kind).transpose()?;
    Ok(Json(state.shore.register.entries(&who, kind).await?))
}

/// `POST /api/v1/register`.
pub(crate) async fn create(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InBody(record): InBody<RegisterRecord>,
) -> Result<Json<RegisterEntry>, ApiError> {
    Ok(Json(state.shore.register.create(&who, remote.address.to_string(), record).await?))
}

/// `PUT /api/v1/register/{id}`.
pub(crate) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(change): InBody<RegisterChange>,
) -> Result<Json<RegisterEntry>, ApiError> {
    Ok(Json(state.shore.register.change(&who, remote.address.to_string(), id, change).await?))
}

/// `DELETE /api/v1/register/{id}`.
pub(crate) async fn delete(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    QueryParams(query): QueryParams<RegisterDeleteQuery>,
) -> Result<(), ApiError> {
    Ok(state.shore.register.delete(&who, remote.address.to_string(), id, query.revision).await?)
}

/// `GET /api/v1/register.csv`.
pub(crate) async fn csv(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<RegisterQuery>,
) -> Result<Response, ApiError> {
    let kind = Register::kind(query.kind.as_deref().unwrap_or_default())?;
    let bytes = state.shore.register.csv(&who, kind).await?;
    let disposition = format!("attachment; filename=\"{}s.csv\"", research::kind_word(kind));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/csv; charset=utf-8")),
        (
            header::CONTENT_DISPOSITION,
            HeaderValue::from_str(&disposition).unwrap_or(HeaderValue::from_static("attachment")),
        ),
    ];
    Ok((headers, bytes).into_response())
}

/// `POST /api/v1/register/import`.
pub(crate) async fn import(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    QueryParams(query): QueryParams<RegisterImportQuery>,
    file: Result<WholeBody, ApiError>,
) -> Result<Json<RegisterImport>, ApiError> {
    let WholeBody(file) = file.map_err(|error| match error.status {
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::malformed(
            StatusCode::PAYLOAD_TOO_LARGE,
            say("file: it has more than 4 MiB. Divide it and send the parts."),
        ),
        _ => error,
    })?;
    let from = remote.address.to_string();
    Ok(Json(state.shore.register.import(&who, from, file.to_vec(), query).await?))
}
