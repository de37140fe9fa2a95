//! What a person does to their rules for messages about alarms: made, changed, tried, removed.

use super::account::{Words, show};
use super::form::{Sent, vessel};
use super::frame::{Frame, PageError};
use super::rules::{Refused, message_row};
use super::words::worded;
use crate::AppState;
use crate::web::{ApiError, Remote, Who};
use api::say;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use operations::alarms::Priority;
use serde::Deserialize;
use shore::ErrorKind;
use shore::identity::{Principal, Via};
use shore::notices::{Made, RuleChange, Way};
use std::time::Duration;

/// The form of a rule: of a new one with its way, of one that changes with its number.
#[derive(Debug, Deserialize)]
pub(super) struct Wanted {
    #[serde(default)]
    id: i64,
    #[serde(default)]
    way: String,
    target: String,
    least: String,
    vessel: String,
    after_s: u64,
    #[serde(default)]
    also_over: bool,
}

impl Wanted {
    fn typed(&self, vessel: Option<u16>, least: Priority) -> RuleChange {
        let (target, after) = (self.target.trim().to_owned(), Duration::from_secs(self.after_s));
        RuleChange { target, least, vessel, after, also_over: self.also_over }
    }
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
    let vessel = vessel(&wanted.vessel)?;
    let problem = match (Way::named(&wanted.way), Priority::named(&wanted.least)) {
        (None, _) => frame.t("A message goes by mail or webhook.").to_string(),
        (_, None) => no_priority(&frame),
        (Some(way), Some(least)) => {
            let typed = wanted.typed(vessel, least);
            let target = typed.clone().of(way).check_target(state.shore.notices.settings()).is_err();
            match state.shore.notices.add(&who, remote.address.to_string(), typed.clone().of(way)).await {
                Ok(Made { secret, .. }) if secret.is_empty() => {
                    return Ok(Redirect::to("/account?done=rule").into_response());
                }
                Ok(Made { secret, .. }) => {
                    return show(&state, &who, frame, Words { signing: secret, ..Words::default() }).await;
                }
                Err(error) if error.kind == ErrorKind::Refused => {
                    let refused = Some(Refused { id: None, way: way.name(), typed, target });
                    let problem = worded(frame.language, &error.text);
                    return show(&state, &who, frame, Words { problem, refused, ..Words::default() }).await;
                }
                Err(error) => return Err(ApiError::from(error).into()),
            }
        }
    };
    show(&state, &who, frame, Words { problem, ..Words::default() }).await
}

/// What is said where a priority is none.
fn no_priority(frame: &Frame) -> String {
    frame.t("Alarms are emergency, alarm, warning or caution.").to_string()
}

/// `POST /account/notice/change`.
pub(super) async fn change(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(wanted): Sent<Wanted>,
) -> Result<Response, PageError> {
    in_person(&who)?;
    let (id, vessel) = (wanted.id, vessel(&wanted.vessel)?);
    let Some(least) = Priority::named(&wanted.least) else {
        let problem = no_priority(&frame);
        return show(&state, &who, frame, Words { problem, ..Words::default() }).await;
    };
    let typed = wanted.typed(vessel, least);
    match state.shore.notices.change(&who, remote.address.to_string(), id, typed.clone()).await {
        Ok(()) => Ok(Redirect::to("/account?done=rule-changed").into_response()),
        Err(error) if error.kind == ErrorKind::Refused => {
            let settings = state.shore.notices.settings();
            let mine = state.shore.notices.mine(&who).await?.rules;
            let way = mine.iter().find(|rule| rule.id == id).map(|rule| rule.ask.way);
            let target = way.is_some_and(|way| typed.clone().of(way).check_target(settings).is_err());
            let refused = Some(Refused { id: Some(id), way: "", typed, target });
            let problem = worded(frame.language, &error.text);
            show(&state, &who, frame, Words { problem, refused, ..Words::default() }).await
        }
        Err(error) => Err(ApiError::from(error).into()),
    }
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
        Err(error) if error.kind == ErrorKind::Refused => worded(frame.language, &error.text),
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
        Via::Token { .. } => Err(ApiError::forbidden(say("A token makes no rules: log in with a browser."))),
    }
}
