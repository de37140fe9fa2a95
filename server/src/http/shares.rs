//! Files for clients that have the address of a link. Logging in matters only for a link that is for one account.

use super::datasets::download;
use crate::AppState;
use crate::web::{ApiError, InPath, MaybeWho, QueryParams, Remote, Who, cookie_name, plain_cookie};
use api::{DatasetFileQuery, ShareVisitKind, SharedDataset, say};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use research::Described;
use serde_json::Value;
use shore::datasets::{OpenShare, ShareClosed};
use shore::identity::Principal;

/// The header by which scripts give the password of a link.
const PASSWORD: &str = "lutra-link-password";

impl From<ShareClosed> for ApiError {
    fn from(closed: ShareClosed) -> Self {
        let text = closed.said();
        match closed {
            ShareClosed::Unknown => Self::not_found(text),
            ShareClosed::LogIn => Self { text, ..Self::not_logged_in() },
            ShareClosed::Revoked => Self::new(StatusCode::GONE, "revoked", text),
            ShareClosed::Expired => Self::new(StatusCode::GONE, "expired", text),
            ShareClosed::Withdrawn(_) | ShareClosed::WithdrawnUntold => {
                Self::new(StatusCode::GONE, "withdrawn", text)
            }
            ShareClosed::Wait(wait) => Self {
                wait_s: Some(wait.as_secs() + 1),
                ..Self::new(StatusCode::TOO_MANY_REQUESTS, "too_many_attempts", text)
            },
        }
    }
}

/// `GET /api/v1/shared`.
pub(crate) async fn mine(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<SharedDataset>>, ApiError> {
    Ok(Json(state.shore.datasets.shared_with(&who).await?))
}

/// Checks that a link's data may be sent: the link is valid, the client may open it, and there is no embargo.
async fn given(
    state: &AppState,
    token: &str,
    remote: Remote,
    who: Option<&Principal>,
    headers: &HeaderMap,
) -> Result<OpenShare, ApiError> {
    let datasets = &state.shore.datasets;
    let open = datasets.open(token, remote.address, who).await??;
    if !datasets.is_unlocked(&open, plain_cookie(headers, &cookie_name(&open.cookie_name(), remote))) {
        let password =
            headers.get(PASSWORD).map(|given| String::from_utf8_lossy(given.as_bytes()).into_owned());
        let password = password.ok_or_else(|| {
            let text =
                say("This link has a password: open its page and give it there, or send it in the header \
                        Lutra-Link-Password.");
            ApiError::new(StatusCode::FORBIDDEN, "password_needed", text)
        })?;
        datasets.unlock(&open, password, remote.address).await?;
    }
    if open.embargo_us.is_some() {
        let text = say("The data are under embargo until {day}, 00:00 UTC. Come back then.")
            .with("day", &open.version.embargo_until);
        return Err(ApiError::new(StatusCode::FORBIDDEN, "embargo", text));
    }
    Ok(open)
}

/// `GET /s/{token}/detections.csv`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    headers: HeaderMap,
    InPath(token): InPath<String>,
    QueryParams(query): QueryParams<DatasetFileQuery>,
) -> Result<Response, ApiError> {
    let open = given(&state, &token, remote, who.as_ref(), &headers).await?;
    let datasets = &state.shore.datasets;
    let frozen = datasets.shared_file(&open, query.format.as_deref()).await?;
    let place = datasets.place(&open)?;
    let what = ShareVisitKind::Download;
    datasets.note(&open, what, remote.address, &frozen.name()).await?;
    download(frozen, query.gzip.unwrap_or(false)).answer_in(Box::new(place), &state, &headers).await
}

/// Metadata of what a link gives.
async fn described(
    state: &AppState,
    token: &str,
    (remote, who): (Remote, Option<Principal>),
    headers: &HeaderMap,
    (file, describe): (&str, fn(&Described<'_>) -> Value),
) -> Result<Value, ApiError> {
    let open = given(state, token, remote, who.as_ref(), headers).await?;
    state.shore.datasets.note(&open, ShareVisitKind::Download, remote.address, file).await?;
    let OpenShare { share, version, .. } = &open;
    Ok(describe(&Described { version, content: &share.content, share: Some(share), addresses: None }))
}

/// `GET /s/{token}/datacite.json`.
pub(crate) async fn datacite(
    State(state): State<AppState>,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    headers: HeaderMap,
    InPath(token): InPath<String>,
) -> Result<Json<Value>, ApiError> {
    let how = ("datacite.json", research::datacite as fn(&Described<'_>) -> Value);
    Ok(Json(described(&state, &token, (remote, who), &headers, how).await?))
}

/// `GET /s/{token}/datapackage.json`.
pub(crate) async fn datapackage(
    State(state): State<AppState>,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    headers: HeaderMap,
    InPath(token): InPath<String>,
) -> Result<Json<Value>, ApiError> {
    let how = ("datapackage.json", research::datapackage as fn(&Described<'_>) -> Value);
    Ok(Json(described(&state, &token, (remote, who), &headers, how).await?))
}

/// `GET /s/{token}/schema.jsonld`.
pub(crate) async fn json_ld(
    State(state): State<AppState>,
    remote: Remote,
    MaybeWho(who): MaybeWho,
    headers: HeaderMap,
    InPath(token): InPath<String>,
) -> Result<Response, ApiError> {
    let how = ("schema.jsonld", research::json_ld as fn(&Described<'_>) -> Value);
    let value = described(&state, &token, (remote, who), &headers, how).await?;
    Ok(([(header::CONTENT_TYPE, "application/ld+json")], value.to_string()).into_response())
}
