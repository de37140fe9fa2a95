//! A person's rules for messages about alarms, on the page under their name.

use super::account::{Words, show};
use super::form::{Sent, vessel};
use super::frame::{Frame, PageError};
use super::words::{said, t};
use crate::AppState;
use crate::http::{ApiError, Remote, Who};
use api::Vessel;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use operations::alarms::Priority;
use serde::Deserialize;
use shore::ErrorKind;
use shore::clock::written;
use shore::identity::{Language, Principal, Via};
use shore::notices::{Delivery, Made, Rule, RuleChange, RuleRequest, Way};
use std::time::Duration;
use units::UtcTime;

/// A rule as the page shows it.
pub(super) struct RuleRow {
    pub(super) id: i64,
    pub(super) target: String,
    pub(super) about: String,
    pub(super) when: String,
    /// What its form shows.
    pub(super) least: Priority,
    /// Address, name, and whether it is this rule's; that one also where it has no name any more.
    pub(super) vessels: Vec<(u16, String, bool)>,
    pub(super) every_vessel: bool,
    /// For how long nobody acknowledged an alarm: seconds, words, and whether it is this rule's.
    pub(super) waits: Vec<(u64, String, bool)>,
    pub(super) also_over: bool,
}

/// What a form offers of times without an acknowledgement (s).
const WAITS_S: [u64; 4] = [0, 60, 300, 1_800];

/// The times that a rule's form offers, its own among them.
fn waits(language: Language, own_s: u64) -> Vec<(u64, String, bool)> {
    let mut all: Vec<u64> = WAITS_S.to_vec();
    if !all.contains(&own_s) {
        all.push(own_s);
        all.sort_unstable();
    }
    let words = |after_s: u64| match after_s {
        0 => t(language, "at once").to_string(),
        other => t(language, "nobody acknowledged it for {min} min").with("min", minutes(other)).to_string(),
    };
    all.into_iter().map(|after_s| (after_s, words(after_s), after_s == own_s)).collect()
}

/// Whole minutes, or with a decimal.
fn minutes(seconds: u64) -> String {
    if seconds.is_multiple_of(60) {
        (seconds / 60).to_string()
    } else {
        format!("{:.1}", Duration::from_secs(seconds).as_secs_f64() / 60.0)
    }
}

pub(super) fn rule_row(language: Language, rule: &Rule, vessels: &[Vessel]) -> RuleRow {
    let ask = &rule.ask;
    let least = match ask.least {
        Priority::Emergency => t(language, "emergencies").to_string(),
        other => {
            t(language, "{priority} and worse").with("priority", said(language, other.name())).to_string()
        }
    };
    let of = ask.vessel.map(|address| {
        let named = vessels.iter().find(|vessel| vessel.address == address);
        named.map_or_else(|| format!("0x{address:04x}"), |vessel| vessel.name.clone())
    });
    let mut choices: Vec<(u16, String, bool)> = vessels
        .iter()
        .map(|vessel| (vessel.address, vessel.name.clone(), ask.vessel == Some(vessel.address)))
        .collect();
    if let (Some(address), Some(name), false) = (ask.vessel, &of, choices.iter().any(|choice| choice.2)) {
        choices.push((address, name.clone(), true));
    }
    let after_s = ask.after.as_secs();
    let begin = match after_s {
        0 => t(language, "at once"),
        other => t(language, "not acknowledged for {min} min").with("min", minutes(other)),
    };
    RuleRow {
        id: rule.id,
        target: ask.target.clone(),
        about: format!("{least}, {}", of.as_deref().unwrap_or(said(language, "all vessels"))),
        when: if ask.also_over {
            t(language, "{begin}; and when it is over").with("begin", begin).to_string()
        } else {
            begin.to_string()
        },
        least: ask.least,
        vessels: choices,
        every_vessel: ask.vessel.is_none(),
        waits: waits(language, after_s),
        also_over: ask.also_over,
    }
}

/// A message as the page shows it.
pub(super) struct MessageRow {
    pub(super) made: String,
    pub(super) subject: String,
    pub(super) outcome: String,
}

pub(super) fn message_row(language: Language, message: Delivery) -> MessageRow {
    let outcome = match (message.outcome.as_str(), message.words.as_str()) {
        ("", "") => t(language, "waits").to_string(),
        ("", words) => t(language, "waits; the last attempt: {words}").with("words", words).to_string(),
        (outcome, "") => said(language, outcome).to_owned(),
        (outcome, words) => format!("{}: {words}", said(language, outcome)),
    };
    MessageRow { made: written(UtcTime::from_micros(message.made_us)), subject: message.subject, outcome }
}

#[derive(Debug, Deserialize)]
pub(super) struct Wanted {
    way: String,
    target: String,
    least: String,
    vessel: String,
    after_s: u64,
    #[serde(default)]
    also_over: bool,
}

/// `POST /account/notice`.
pub(super) async fn add(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(wanted): Sent<Wanted>,
) -> Result<Response, PageError> {
    in_person(&who)?;
    let words = match ask(&wanted)? {
        Err(problem) => Words { problem, ..Words::default() },
        Ok(ask) => match state.shore.notices.add(&who, remote.address.to_string(), ask).await {
            Ok(Made { secret, .. }) if secret.is_empty() => {
                return Ok(Redirect::to("/account?done=rule").into_response());
            }
            Ok(Made { secret, .. }) => Words { signing: secret, ..Words::default() },
            Err(error) if error.kind == ErrorKind::Refused => {
                Words { problem: error.text, ..Words::default() }
            }
            Err(error) => return Err(ApiError::from(error).into()),
        },
    };
    show(&state, &who, frame, words).await
}

/// What is said where a priority is none.
const NO_PRIORITY: &str = "Alarms are emergency, alarm, warning or caution.";

#[derive(Debug, Deserialize)]
pub(super) struct Changed {
    id: i64,
    target: String,
    least: String,
    vessel: String,
    after_s: u64,
    #[serde(default)]
    also_over: bool,
}

/// `POST /account/notice/change`.
pub(super) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(sent): Sent<Changed>,
) -> Result<Response, PageError> {
    in_person(&who)?;
    let vessel = vessel(&sent.vessel)?;
    let outcome = match Priority::named(&sent.least) {
        None => Err(shore::Error::refused(NO_PRIORITY)),
        Some(least) => {
            let (after, target) = (Duration::from_secs(sent.after_s), sent.target.trim().to_owned());
            let change = RuleChange { target, least, vessel, after, also_over: sent.also_over };
            state.shore.notices.change(&who, remote.address.to_string(), sent.id, change).await
        }
    };
    match outcome {
        Ok(()) => Ok(Redirect::to("/account?done=rule-changed").into_response()),
        Err(error) if error.kind == ErrorKind::Refused => {
            show(&state, &who, frame, Words { problem: error.text, ..Words::default() }).await
        }
        Err(error) => Err(ApiError::from(error).into()),
    }
}

fn ask(wanted: &Wanted) -> Result<Result<RuleRequest, String>, ApiError> {
    let vessel = vessel(&wanted.vessel)?;
    let Some(way) = Way::named(&wanted.way) else {
        return Ok(Err("A message goes by mail or webhook.".to_owned()));
    };
    let Some(least) = Priority::named(&wanted.least) else {
        return Ok(Err(NO_PRIORITY.to_owned()));
    };
    let after = Duration::from_secs(wanted.after_s);
    let target = wanted.target.trim().to_owned();
    Ok(Ok(RuleRequest { way, target, least, vessel, after, also_over: wanted.also_over }))
}

#[derive(Debug, Deserialize)]
pub(super) struct ById {
    id: i64,
}

/// `POST /account/notice/test`.
pub(super) async fn test(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    in_person(&who)?;
    let problem = match state.shore.notices.test(&who, id).await {
        Ok(message) if message.outcome == "delivered" => {
            return Ok(Redirect::to("/account?done=delivered").into_response());
        }
        Ok(message) => {
            let outcome = message_row(frame.language, message).outcome;
            frame.t("The test message: {outcome}.").with("outcome", outcome).to_string()
        }
        Err(error) if error.kind == ErrorKind::Refused => error.text,
        Err(error) => return Err(ApiError::from(error).into()),
    };
    show(&state, &who, frame, Words { problem, ..Words::default() }).await
}

/// `POST /account/notice/remove`.
pub(super) async fn remove(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    state.shore.notices.remove(&who, remote.address.to_string(), id).await?;
    Ok(Redirect::to("/account?done=rule-removed").into_response())
}

/// A token that reads in somebody's name has nothing sent anywhere.
fn in_person(who: &Principal) -> Result<(), ApiError> {
    match who.via {
        Via::Session { .. } => Ok(()),
        Via::Token { .. } => Err(ApiError::forbidden("A token makes no rules: log in with a browser.")),
    }
}
