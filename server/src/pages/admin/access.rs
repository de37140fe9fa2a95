//! Everybody's tokens and sessions, and the audit log.

use super::act;
use crate::AppState;
use crate::pages::actions::ACTIONS;
use crate::pages::form::Sent;
use crate::pages::frame::{Frame, PageError, html};
use crate::pages::rows::{self, AuditRow, SessionRow, TokenRow};
use crate::web::{Remote, Who};
use askama::Template;
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use serde::Deserialize;
use shore::identity::{Via, audit as log, sessions as session, tokens as token, vessels};

/// Entries on one page of the audit log.
const PAGE: u32 = 100;

#[derive(Template)]
#[template(path = "admin_tokens.html")]
struct TokensPage {
    frame: Frame,
    tokens: Vec<TokenRow>,
}

/// `GET /admin/tokens`.
pub(in crate::pages) async fn tokens(
    State(state): State<AppState>,
    frame: Frame,
) -> Result<Response, PageError> {
    let (tokens, vessels) = state.shore.people.ask((token::List(None), vessels::List)).await?;
    let tokens = tokens.into_iter().map(|token| rows::token(frame.language, token, &vessels)).collect();
    Ok(html(&TokensPage { frame, tokens }))
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct ById {
    id: i64,
}

/// `POST /admin/token/revoke`.
pub(in crate::pages) async fn token_revoke(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    // Revoked by somebody else already is as good.
    let revoke = token::Revoke { id, person: None };
    drop(act(&state, (&who, remote), "token.revoke", &id.to_string(), revoke).await?);
    Ok(Redirect::to("/admin/tokens").into_response())
}

#[derive(Template)]
#[template(path = "admin_sessions.html")]
struct SessionsPage {
    frame: Frame,
    sessions: Vec<SessionRow>,
}

/// `GET /admin/sessions`.
pub(in crate::pages) async fn sessions(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let own = match who.via {
        Via::Session { id, .. } => Some(id),
        Via::Token { .. } => None,
    };
    let sessions = state.shore.people.ask(session::List(None)).await?;
    let sessions = sessions.into_iter().map(|session| rows::session(session, own)).collect();
    Ok(html(&SessionsPage { frame, sessions }))
}

/// `POST /admin/session/end`.
pub(in crate::pages) async fn session_end(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    // Ended by itself already is as good.
    let end = session::End { id, person: None };
    drop(act(&state, (&who, remote), "session.end", &id.to_string(), end).await?);
    Ok(Redirect::to("/admin/sessions").into_response())
}

#[derive(Template)]
#[template(path = "admin_audit.html")]
struct AuditPage {
    frame: Frame,
    entries: Vec<AuditRow>,
    people: Vec<String>,
    actions: &'static [(&'static str, &'static str)],
    filter: AuditFilter,
    /// Where older ones are; empty for nowhere.
    older: String,
}

/// What is asked for, as the form has it.
#[derive(Debug, Default, Deserialize)]
pub(in crate::pages) struct AuditFilter {
    #[serde(default)]
    who: String,
    #[serde(default)]
    what: String,
    /// Present where only what failed is wanted.
    failed: Option<String>,
    before: Option<i64>,
}

/// `GET /admin/audit`.
pub(in crate::pages) async fn audit(
    State(state): State<AppState>,
    frame: Frame,
    Query(filter): Query<AuditFilter>,
) -> Result<Response, PageError> {
    let some = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
    let wanted = log::Entries {
        before: filter.before,
        count: PAGE,
        actor: some(&filter.who),
        action: some(&filter.what),
        failed: filter.failed.is_some(),
    };
    let (entries, people) = state.shore.people.ask((wanted, log::Actors)).await?;
    let older = match entries.last() {
        Some(last) if entries.len() == PAGE as usize => {
            let failed = filter.failed.as_deref().unwrap_or_default();
            let kept = [("who", &*filter.who), ("what", &*filter.what), ("failed", failed)];
            rows::older("/admin/audit", &kept, last.id)
        }
        _ => String::new(),
    };
    let vessels = state.shore.people.vessels();
    let entries = entries.into_iter().map(|entry| rows::audit(frame.language, entry, &vessels)).collect();
    Ok(html(&AuditPage { frame, entries, people, actions: &ACTIONS, filter, older }))
}
