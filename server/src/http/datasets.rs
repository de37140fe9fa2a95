//! Datasets, for programs and their pages.

use super::download::Download;
use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who};
use api::{
    Dataset, DatasetChange, DatasetCheck, DatasetDraft, DatasetFileQuery, DatasetShare, DatasetShareMade,
    DatasetShareRequest, DatasetStep, DatasetVersion, DatasetWithdrawal, ShareVisit,
};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse as _, Response};
use research::{Access, Described};
use serde_json::Value;
use shore::datasets::Frozen;
use std::sync::Arc;

/// `GET /api/v1/datasets`.
pub(crate) async fn list(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<Dataset>>, ApiError> {
    Ok(Json(state.shore.datasets.list(&who).await?))
}

/// `POST /api/v1/datasets`.
pub(crate) async fn create(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InBody(draft): InBody<DatasetDraft>,
) -> Result<Json<Dataset>, ApiError> {
    Ok(Json(state.shore.datasets.create(&who, remote.address.to_string(), draft).await?))
}

/// `GET /api/v1/datasets/{id}`.
pub(crate) async fn one(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
) -> Result<Json<Dataset>, ApiError> {
    Ok(Json(state.shore.datasets.one(&who, id).await?))
}

/// `PUT /api/v1/datasets/{id}`.
pub(crate) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(change): InBody<DatasetChange>,
) -> Result<Json<Dataset>, ApiError> {
    Ok(Json(state.shore.datasets.change(&who, remote.address.to_string(), id, change).await?))
}

/// `POST /api/v1/datasets/{id}/publish`.
pub(crate) async fn publish(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(step): InBody<DatasetStep>,
) -> Result<Json<Dataset>, ApiError> {
    let from = remote.address.to_string();
    Ok(Json(state.shore.datasets.publish(&who, from, id, step.revision).await?))
}

/// `POST /api/v1/datasets/{id}/versions`.
pub(crate) async fn new_version(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(step): InBody<DatasetStep>,
) -> Result<Json<Dataset>, ApiError> {
    let from = remote.address.to_string();
    Ok(Json(state.shore.datasets.new_version(&who, from, id, step.revision).await?))
}

/// `POST /api/v1/datasets/{id}/withdraw`.
pub(crate) async fn withdraw(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(asked): InBody<DatasetWithdrawal>,
) -> Result<Json<Dataset>, ApiError> {
    Ok(Json(state.shore.datasets.withdraw(&who, remote.address.to_string(), id, asked).await?))
}

/// `GET /api/v1/datasets/{id}/versions/{number}`.
pub(crate) async fn version(
    State(state): State<AppState>,
    Who(who): Who,
    InPath((id, number)): InPath<(i64, u32)>,
) -> Result<Json<DatasetVersion>, ApiError> {
    Ok(Json(state.shore.datasets.version(&who, id, number).await?))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/check`.
pub(crate) async fn check(
    State(state): State<AppState>,
    Who(who): Who,
    InPath((id, number)): InPath<(i64, u32)>,
) -> Result<Json<DatasetCheck>, ApiError> {
    Ok(Json(state.shore.datasets.check(&who, id, number).await?))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/detections.csv`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    Who(who): Who,
    InPath((id, number)): InPath<(i64, u32)>,
    asked: HeaderMap,
    QueryParams(query): QueryParams<DatasetFileQuery>,
) -> Result<Response, ApiError> {
    let frozen = state.shore.datasets.file(&who, id, number, query.format.as_deref()).await?;
    download(frozen, query.gzip.unwrap_or(false)).answer(&state, &asked).await
}

/// The download of a dataset's file.
pub(super) fn download(frozen: Frozen, gzip: bool) -> Download {
    let frozen = Arc::new(frozen);
    let (of_write, of_version) = (Arc::clone(&frozen), Arc::clone(&frozen));
    let name = format!("{}{}", frozen.name(), if gzip { ".gz" } else { "" });
    Download {
        question: format!("{name} {}", frozen.question()),
        name,
        media: frozen.media(),
        gzip,
        write: Arc::new(move |data, out| of_write.write(data, out).map(drop)),
        version: Arc::new(move |data| of_version.version(data)),
    }
}

/// Addresses of a version's page and files, for users with an account.
fn addresses(origin: &str, id: i64, number: u32) -> (String, String) {
    let file = format!("{origin}/api/v1/datasets/{id}/versions/{number}/detections.csv");
    (format!("{origin}/datasets/{id}?version={number}"), file)
}

/// Metadata of a version, in one of several formats.
async fn described(
    state: &AppState,
    who: &shore::identity::Principal,
    (id, number): (i64, u32),
    origin: &str,
    describe: fn(&Described<'_>) -> Value,
) -> Result<Value, ApiError> {
    let version = state.shore.datasets.version(who, id, number).await?;
    let (page, file) = addresses(origin, id, number);
    let addresses = Some((&*page, &*file));
    Ok(describe(&Described { version: &version, content: &version.content, share: None, addresses }))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/datacite.json`.
pub(crate) async fn datacite(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    InPath(of): InPath<(i64, u32)>,
) -> Result<Json<Value>, ApiError> {
    Ok(Json(described(&state, &who, of, &remote.origin(&headers), research::datacite).await?))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/datapackage.json`.
pub(crate) async fn datapackage(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    InPath(of): InPath<(i64, u32)>,
) -> Result<Json<Value>, ApiError> {
    Ok(Json(described(&state, &who, of, &remote.origin(&headers), research::datapackage).await?))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/schema.jsonld`.
pub(crate) async fn json_ld(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    InPath(of): InPath<(i64, u32)>,
) -> Result<Response, ApiError> {
    let value = described(&state, &who, of, &remote.origin(&headers), research::json_ld).await?;
    Ok(([(header::CONTENT_TYPE, "application/ld+json")], value.to_string()).into_response())
}

/// `GET /api/v1/datasets/{id}/versions/{number}/notebook.py`.
pub(crate) async fn python(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    InPath((id, number)): InPath<(i64, u32)>,
) -> Result<Response, ApiError> {
    let version = state.shore.datasets.version(&who, id, number).await?;
    let (_, file) = addresses(&remote.origin(&headers), id, number);
    Ok(text(research::python(&version, &version.content, &file, Access::Token)))
}

/// `GET /api/v1/datasets/{id}/versions/{number}/notebook.R`.
pub(crate) async fn r(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    InPath((id, number)): InPath<(i64, u32)>,
) -> Result<Response, ApiError> {
    let version = state.shore.datasets.version(&who, id, number).await?;
    let (_, file) = addresses(&remote.origin(&headers), id, number);
    Ok(text(research::r(&version, &version.content, &file, Access::Token)))
}

fn text(text: String) -> Response {
    ([(header::CONTENT_TYPE, "text/plain; charset=utf-8")], text).into_response()
}

/// `GET /api/v1/datasets/{id}/shares`.
pub(crate) async fn shares(
    State(state): State<AppState>,
    Who(who): Who,
    InPath(id): InPath<i64>,
) -> Result<Json<Vec<DatasetShare>>, ApiError> {
    Ok(Json(state.shore.datasets.shares(&who, id).await?))
}

/// `POST /api/v1/datasets/{id}/shares`.
pub(crate) async fn share(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
    InBody(asked): InBody<DatasetShareRequest>,
) -> Result<Json<DatasetShareMade>, ApiError> {
    Ok(Json(state.shore.datasets.share(&who, remote.address.to_string(), id, asked).await?))
}

/// `DELETE /api/v1/datasets/{id}/shares/{share}`.
pub(crate) async fn revoke(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath((id, share)): InPath<(i64, i64)>,
) -> Result<(), ApiError> {
    Ok(state.shore.datasets.revoke(&who, remote.address.to_string(), id, share).await?)
}

/// `GET /api/v1/datasets/{id}/shares/{share}/visits`.
pub(crate) async fn visits(
    State(state): State<AppState>,
    Who(who): Who,
    InPath((id, share)): InPath<(i64, i64)>,
) -> Result<Json<Vec<ShareVisit>>, ApiError> {
    Ok(Json(state.shore.datasets.visits(&who, id, share).await?))
}
