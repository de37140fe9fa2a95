//! Vessels' names and the tokens of their links.

use super::{Words, act};
use crate::AppState;
use crate::pages::form::Sent;
use crate::pages::frame::{Frame, PageError, html};
use crate::web::{ApiError, Remote, Who};
use api::say;
use askama::Template;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use serde::Deserialize;
use shore::identity::{tokens, vessels};

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
    aboard: Option<Aboard>,
}

/// Where a new link token goes.
struct Aboard {
    vessel: String,
    address: u16,
    encrypted: bool,
    /// Of the vessel's configuration.
    lines: String,
}

impl Aboard {
    /// `host`: how the admin's browser calls this server.
    fn new(vessel: &api::Vessel, host: &str, encrypted: bool) -> Self {
        let (scheme, authority) =
            if encrypted { ("wss", "\nCertificate Authority = ca.pem") } else { ("ws", "") };
        let lines = format!(
            "[Transports.Lutra]\nEnabled = Always\nURL = {scheme}://{host}/link\nToken File = lutra.token{authority}"
        );
        Self { vessel: vessel.name.clone(), address: vessel.address, encrypted, lines }
    }

    /// Its address as configurations have it.
    fn hex(&self) -> String {
        format!("0x{:04X}", self.address)
    }
}

/// `GET /admin/vessels`.
pub(in crate::pages) async fn page(
    State(state): State<AppState>,
    frame: Frame,
) -> Result<Response, PageError> {
    show(&state, frame, Words::default()).await
}

async fn show(state: &AppState, frame: Frame, words: Words) -> Result<Response, PageError> {
    show_with(state, frame, words, None).await
}

async fn show_with(
    state: &AppState,
    frame: Frame,
    words: Words,
    aboard: Option<Aboard>,
) -> Result<Response, PageError> {
    let (vessels, tokens) = state.shore.people.ask((vessels::List, tokens::List(None))).await?;
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
    let vessels = vessels.into_iter().map(row).collect();
    let mut response = html(&VesselsPage { frame, vessels, words, aboard });
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
    remote: Remote,
    Sent(new): Sent<NewVessel>,
) -> Result<Response, PageError> {
    let name = new.name.trim().to_owned();
    let Ok(address) = vessels::address(new.address.trim()) else {
        let problem = frame.t("{text} is not an IMC address; give one like 2068 or 0x0814.");
        return show(&state, frame, Words::problem(problem.with("text", new.address.trim()).to_string()))
            .await;
    };
    let add = vessels::Add { address, name: name.clone(), now: state.shore.clock.utc() };
    let words = match act(&state, (&who, remote), "vessel.add", &name, add).await? {
        Ok(()) => Words::notice(
            frame.t("{name} is known. Its link needs a token: make one below.").with("name", &name),
        ),
        Err(why) => Words::refused(frame.language, &why),
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
    remote: Remote,
    Sent(ByAddress { address }): Sent<ByAddress>,
) -> Result<Response, PageError> {
    let subject = format!("0x{address:04X}");
    let remove = vessels::Remove(address);
    let words = match act(&state, (&who, remote), "vessel.remove", &subject, remove).await? {
        Ok(()) => Words::notice(
            frame.t("Forgotten, and its link tokens are revoked. Its archive and history stay."),
        ),
        Err(why) => Words::refused(frame.language, &why),
    };
    show(&state, frame, words).await
}

/// `POST /admin/vessel/token`.
pub(in crate::pages) async fn token(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    headers: HeaderMap,
    Sent(ByAddress { address }): Sent<ByAddress>,
) -> Result<Response, PageError> {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or("SERVER");
    let encrypted = remote.encrypted;
    let known = state.shore.people.vessels();
    let vessel = known.iter().find(|vessel| vessel.address == address).cloned();
    let vessel = vessel.ok_or_else(|| ApiError::not_found(say("There is no such vessel.")))?;
    let (label, now) = (vessel.name.clone(), state.shore.clock.utc());
    let make = tokens::MakeLink { label, vessel: address, days: None, now };
    let secret = match act(&state, (&who, remote), "token.make", &vessel.name, make).await? {
        Ok(made) => made.secret,
        Err(why) => {
            let words = Words::refused(frame.language, &why);
            return show(&state, frame, words).await;
        }
    };
    let secret_for = frame.t("Link token of {name}").with("name", &vessel.name).to_string();
    let words = Words { secret_for, secret, ..Words::default() };
    show_with(&state, frame, words, Some(Aboard::new(&vessel, host, encrypted))).await
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The configuration that lutra-agent comes with, every key in it.
    const OTTER: &str = include_str!("../../../../vehicle-agent/etc/otter.ini");

    #[test]
    fn what_goes_aboard_are_keys_that_the_agent_knows() {
        let vessel = api::Vessel { name: "Otter 1".to_owned(), address: 0x0814 };
        for (encrypted, url) in [(false, "ws://shore:8080/link"), (true, "wss://shore:8080/link")] {
            let aboard = Aboard::new(&vessel, "shore:8080", encrypted);
            let mut lines = aboard.lines.lines();
            assert_eq!(lines.next(), Some("[Transports.Lutra]"));
            let (_, section) = OTTER.split_once("\n[Transports.Lutra]\n").unwrap();
            let section = section.split("\n[").next().unwrap();
            for line in lines {
                let (key, value) = line.split_once(" = ").unwrap();
                assert!(section.lines().any(|known| known.starts_with(&format!("{key} ="))), "{key}");
                assert!(key != "URL" || value == url, "{line}");
            }
            assert_eq!(aboard.lines.contains("Certificate Authority"), encrypted);
        }
    }
}
