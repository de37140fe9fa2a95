//! Vessels' names and the tokens of their links.

use super::{Words, act};
use crate::clock;
use crate::http::{ApiError, Caller, Who};
use crate::pages::form::Sent;
use crate::pages::frame::{Frame, PageError, html};
use crate::people::tokens::{self, NewLink};
use crate::people::vessels;
use crate::shore::AppState;
use askama::Template;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;

struct VesselRow {
    name: String,
    address: u16,
    tokens: usize,
}

#[derive(Template)]
#[template(path = "admin_vessels.html")]
struct VesselsPage {
    frame: Frame,
    vessels: Vec<VesselRow>,
    words: Words,
}

/// `GET /admin/vessels`.
pub(in crate::pages) async fn page(
    State(state): State<AppState>,
    frame: Frame,
) -> Result<Response, PageError> {
    show(&state, frame, Words::default()).await
}

async fn show(state: &AppState, frame: Frame, words: Words) -> Result<Response, PageError> {
    let (vessels, tokens) = state.people.ask(|db| Ok((vessels::list(db)?, tokens::list(db, None)?))).await?;
    let links = |address: u16| {
        let of = |token: &&api::Token| token.role.is_none() && token.vessel == Some(address);
        tokens.iter().filter(of).count()
    };
    let row = |vessel: api::Vessel| VesselRow {
        tokens: links(vessel.address),
        name: vessel.name,
        address: vessel.address,
    };
    let bad = !words.problem.is_empty();
    let frame = Frame { path: "/admin/vessels".to_owned(), ..frame };
    let mut response = html(&VesselsPage { frame, vessels: vessels.into_iter().map(row).collect(), words });
    if bad {
        *response.status_mut() = StatusCode::UNPROCESSABLE_ENTITY;
    }
    Ok(response)
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct NewVessel {
    name: String,
    address: String,
}

/// `POST /admin/vessel`.
pub(in crate::pages) async fn add(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    caller: Caller,
    Sent(new): Sent<NewVessel>,
) -> Result<Response, PageError> {
    let name = new.name.trim().to_owned();
    let address = match vessels::address(new.address.trim()) {
        Ok(address) => address,
        Err(problem) => return show(&state, frame, Words::problem(problem)).await,
    };
    let added = name.clone();
    let done = act(&state, (&who, caller), "vessel.add", &name, move |db| {
        vessels::add(db, address, &added, clock::now())
    });
    let words = match done.await? {
        Ok(()) => Words::notice(format!("{name} is known. Its link needs a token: make one below.")),
        Err(words) => words,
    };
    show(&state, frame, words).await
}

#[derive(Debug, Deserialize)]
pub(in crate::pages) struct ByAddress {
    address: u16,
}

/// `POST /admin/vessel/remove`.
pub(in crate::pages) async fn remove(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    caller: Caller,
    Sent(ByAddress { address }): Sent<ByAddress>,
) -> Result<Response, PageError> {
    let subject = format!("0x{address:04X}");
    let done = act(&state, (&who, caller), "vessel.remove", &subject, move |db| vessels::remove(db, address));
    let words = match done.await? {
        Ok(()) => Words::notice("Forgotten, and its link tokens are revoked. Its archive and history stay."),
        Err(words) => words,
    };
    show(&state, frame, words).await
}

/// `POST /admin/vessel/token`.
pub(in crate::pages) async fn token(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    caller: Caller,
    Sent(ByAddress { address }): Sent<ByAddress>,
) -> Result<Response, PageError> {
    let known = state.people.ask(vessels::list).await?;
    let vessel = known.into_iter().find(|vessel| vessel.address == address);
    let vessel = vessel.ok_or_else(|| ApiError::not_found("There is no such vessel."))?;
    let label = vessel.name.clone();
    let done = act(&state, (&who, caller), "token.make", &vessel.name, move |db| {
        tokens::make_link(db, &NewLink { label: &label, vessel: address, days: None }, clock::now())
    });
    let words = match done.await? {
        Ok(made) => Words {
            secret_for: format!("Link token of {}", vessel.name),
            secret: made.secret,
            ..Words::default()
        },
        Err(words) => words,
    };
    show(&state, frame, words).await
}
