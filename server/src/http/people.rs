//! People, tokens and sessions for programs.

use crate::AppState;
use crate::web::{ApiError, InBody, InPath, QueryParams, Remote, Who};
use api::{AuditEntry, Me, NewToken, Person, Role, Session, Token, TokenMade, say};
use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use shore::identity::{Via, audit, persons, sessions, tokens};
use utoipa::IntoParams;

/// `GET /api/v1/me`.
pub(crate) async fn me(State(state): State<AppState>, Who(who): Who) -> Result<Json<Me>, ApiError> {
    let person = who.person;
    let permissions = state.shore.people.ask(persons::Permissions(person)).await?;
    Ok(Json(Me { name: who.name, permissions }))
}

/// `GET /api/v1/people`.
pub(crate) async fn list(State(state): State<AppState>) -> Result<Json<Vec<Person>>, ApiError> {
    Ok(Json(state.shore.people.ask(persons::List).await?))
}

/// `GET /api/v1/tokens`: one's own, or for an admin all.
pub(crate) async fn token_list(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<Token>>, ApiError> {
    let person = (who.grants.everywhere() < Some(Role::Admin)).then_some(who.person);
    Ok(Json(state.shore.people.ask(tokens::List(person)).await?))
}

/// `POST /api/v1/tokens`.
pub(crate) async fn token_make(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    new: Result<InBody<NewToken>, ApiError>,
) -> Result<Json<TokenMade>, ApiError> {
    if matches!(who.via, Via::Token { .. }) {
        // Otherwise an expiring token could be extended by another.
        return Err(ApiError::forbidden(say("A token cannot make tokens: log in with a browser.")));
    }
    let InBody(new) = new?;
    let subject = new.label.clone();
    let make = tokens::Make { person: who.person, new, now: state.shore.clock.utc() };
    Ok(Json(state.shore.people.act(&who, remote.address.to_string(), "token.make", subject, make).await?))
}

/// `DELETE /api/v1/tokens/{id}`: one's own, or for an admin any.
pub(crate) async fn token_revoke(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<(), ApiError> {
    let person = (who.grants.everywhere() < Some(Role::Admin)).then_some(who.person);
    if let Via::Token { id: own, .. } = who.via
        && person.is_some()
        && own != id
    {
        return Err(ApiError::forbidden(say("A token can revoke itself alone: log in with a browser.")));
    }
    let revoke = tokens::Revoke { id, person };
    state.shore.people.act(&who, remote.address.to_string(), "token.revoke", id.to_string(), revoke).await?;
    Ok(())
}

/// `GET /api/v1/sessions`: one's own, or for an admin all.
pub(crate) async fn session_list(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<Session>>, ApiError> {
    let person = (who.grants.everywhere() < Some(Role::Admin)).then_some(who.person);
    Ok(Json(state.shore.people.ask(sessions::List(person)).await?))
}

/// `DELETE /api/v1/sessions/{id}`: one's own, or for an admin any.
pub(crate) async fn session_end(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    InPath(id): InPath<i64>,
) -> Result<(), ApiError> {
    let person = (who.grants.everywhere() < Some(Role::Admin)).then_some(who.person);
    if matches!(who.via, Via::Token { .. }) && person.is_some() {
        // A stolen token must not be able to lock its person out.
        return Err(ApiError::forbidden(say("A token cannot end sessions: log in with a browser.")));
    }
    let end = sessions::End { id, person };
    Ok(state.shore.people.act(&who, remote.address.to_string(), "session.end", id.to_string(), end).await?)
}

/// Which part of the audit log.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub(crate) struct AuditQuery {
    /// Entries before this one; without it, the newest.
    pub(crate) before: Option<i64>,
    /// At most this many, up to 1000.
    pub(crate) count: Option<u32>,
}

/// `GET /api/v1/audit`.
pub(crate) async fn audit_list(
    State(state): State<AppState>,
    QueryParams(query): QueryParams<AuditQuery>,
) -> Result<Json<Vec<AuditEntry>>, ApiError> {
    let count = query.count.unwrap_or(100).min(1_000);
    Ok(Json(
        state
            .shore
            .people
            .ask(audit::Entries { before: query.before, count, ..audit::Entries::default() })
            .await?,
    ))
}
