//! A person's rules for messages about alarms, on the page under their name.

use super::account::{Words, show};
use super::form::{Sent, vessel};
use super::frame::{Frame, PageError};
use crate::AppState;
use crate::http::{ApiError, Remote, Who};
use api::Vessel;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use operations::alarms::Priority;
use serde::Deserialize;
use shore::ErrorKind;
use shore::clock::written;
use shore::identity::{Principal, Via};
use shore::notices::{Ask, Delivery, Made, Rule, Way};
use std::time::Duration;
use units::UtcTime;

/// A rule as the page shows it.
pub(super) struct RuleRow {
    pub(super) id: i64,
    pub(super) target: String,
    pub(super) about: String,
    pub(super) when: String,
}

pub(super) fn rule_row(rule: &Rule, vessels: &[Vessel]) -> RuleRow {
    let ask = &rule.ask;
    let least = match ask.least {
        Priority::Emergency => "emergencies".to_owned(),
        other => format!("{} and worse", other.name()),
    };
    let of = ask.vessel.map(|address| {
        let named = vessels.iter().find(|vessel| vessel.address == address);
        named.map_or_else(|| format!("0x{address:04x}"), |vessel| vessel.name.clone())
    });
    let after_min = ask.after.as_secs() / 60;
    let begin =
        if after_min == 0 { "at once".to_owned() } else { format!("not acknowledged for {after_min} min") };
    RuleRow {
        id: rule.id,
        target: ask.target.clone(),
        about: format!("{least}, {}", of.as_deref().unwrap_or("all vessels")),
        when: if ask.also_over { format!("{begin}; and when it is over") } else { begin },
    }
}

/// A message as the page shows it.
pub(super) struct MessageRow {
    pub(super) made: String,
    pub(super) subject: String,
    pub(super) outcome: String,
}

pub(super) fn message_row(message: Delivery) -> MessageRow {
    let outcome = match (message.outcome.as_str(), message.words.as_str()) {
        ("", "") => "waits".to_owned(),
        ("", words) => format!("waits; the last attempt: {words}"),
        (outcome, "") => outcome.to_owned(),
        (outcome, words) => format!("{outcome}: {words}"),
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

fn ask(wanted: &Wanted) -> Result<Result<Ask, String>, ApiError> {
    let vessel = vessel(&wanted.vessel)?;
    let Some(way) = Way::named(&wanted.way) else {
        return Ok(Err("A message goes by mail or webhook.".to_owned()));
    };
    let Some(least) = Priority::named(&wanted.least) else {
        return Ok(Err("Alarms are emergency, alarm, warning or caution.".to_owned()));
    };
    let after = Duration::from_secs(wanted.after_s);
    let target = wanted.target.trim().to_owned();
    Ok(Ok(Ask { way, target, least, vessel, after, also_over: wanted.also_over }))
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
        Ok(message) => format!("The test message: {}.", message_row(message).outcome),
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
