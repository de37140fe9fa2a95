//! Accounts: adding, roles, one-time passwords, removing.

use super::{Words, act};
use crate::AppState;
use crate::pages::form::{Sent, role_or_none, vessel as read_vessel};
use crate::pages::frame::{Frame, PageError, html};
use crate::pages::rows::{self, PersonRow};
use crate::web::{Remote, Who};
use api::{Role, Vessel};
use askama::Template;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use shore::identity::{one_time_password, persons, sessions, tokens, vessels};

#[derive(Template)]
#[template(path = "admin_people.html")]
struct PeoplePage {
    frame: Frame,
    people: Vec<PersonRow>,
    vessels: Vec<Vessel>,
    words: Words,
}

/// `GET /admin`.
pub(in crate::pages) async fn page(
    State(state): State<AppState>,
    frame: Frame,
) -> Result<Response, PageError> {
    show(&state, frame, Words::default()).await
}

async fn show(state: &AppState, frame: Frame, words: Words) -> Result<Response, PageError> {
    let ((people, vessels), (sessions, tokens)) = state
        .shore
        .people
        .ask(((persons::List, vessels::List), (sessions::List(None), tokens::List(None))))
        .await?;
    let bad = !words.problem.is_empty();
    let row = |person| rows::person(frame.language, person, &vessels, &sessions, &tokens);
    let people = people.into_iter().map(row).collect();
    let frame = Frame { path: "/admin".to_owned(), ..frame };
    let mut response = html(&PeoplePage { frame, people, vessels, words });
    if bad {
        *response.status_mut() = StatusCode::UNPROCESSABLE_ENTITY;
    }
    Ok(response)
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct NewPerson {
    name: String,
    /// `none` gives none.
    role: String,
    vessel: String,
}

/// `POST /admin/person`.
pub(in crate::pages) async fn add(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(new): Sent<NewPerson>,
) -> Result<Response, PageError> {
    let (role, vessel) = (role_or_none(&new.role)?, read_vessel(&new.vessel)?);
    let secret = one_time_password();
    let hash = state.shore.people.hash(secret.clone()).await?;
    let name = new.name.trim().to_owned();
    let (added, now) = (name.clone(), state.shore.clock.utc());
    let add = persons::Add { name: added, password_hash: hash, must_change: true, vessel, role, now };
    let words = match act(&state, (&who, remote), "person.add", &name, add).await? {
        Ok(_) => Words { secret_for: secret_for(&frame, &name), secret, ..Words::default() },
        Err(why) => Words::refused(frame.language, &why),
    };
    show(&state, frame, words).await
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct NewRole {
    name: String,
    /// `none` takes it.
    role: String,
    vessel: String,
}

/// `POST /admin/person/role`.
pub(in crate::pages) async fn role(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(new): Sent<NewRole>,
) -> Result<Response, PageError> {
    let role = role_or_none(&new.role)?;
    let vessel = read_vessel(&new.vessel)?;
    let place = vessel.map_or_else(|| "all vessels".to_owned(), |vessel| format!("0x{vessel:04X}"));
    let subject = format!("{}: {} on {place}", new.name, role.map_or("nothing", Role::name));
    let set = persons::SetRole { name: new.name, vessel, role };
    let words = match act(&state, (&who, remote), "person.role", &subject, set).await? {
        Ok(()) => Words::notice(frame.t("Changed. {what}.").with("what", &subject)),
        Err(why) => Words::refused(frame.language, &why),
    };
    show(&state, frame, words).await
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct ByName {
    name: String,
}

/// `POST /admin/person/password`.
pub(in crate::pages) async fn password(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(ByName { name }): Sent<ByName>,
) -> Result<Response, PageError> {
    let secret = one_time_password();
    let hash = state.shore.people.hash(secret.clone()).await?;
    let reset = name.clone();
    let set = persons::SetPassword { name: reset, password_hash: hash, must_change: true, keep: None };
    let words = match act(&state, (&who, remote), "person.password", &name, set).await? {
        Ok(()) => Words { secret_for: secret_for(&frame, &name), secret, ..Words::default() },
        Err(why) => Words::refused(frame.language, &why),
    };
    show(&state, frame, words).await
}

/// `POST /admin/person/remove`.
pub(in crate::pages) async fn remove(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(ByName { name }): Sent<ByName>,
) -> Result<Response, PageError> {
    let remove = persons::Remove(name.clone());
    let words = match act(&state, (&who, remote), "person.remove", &name, remove).await? {
        Ok(()) => Words::notice(frame.t("{name} is removed.").with("name", &name)),
        Err(why) => Words::refused(frame.language, &why),
    };
    show(&state, frame, words).await
}

/// What is shown this once.
fn secret_for(frame: &Frame, name: &str) -> String {
    frame.t("One-time password of {name}").with("name", name).to_string()
}
