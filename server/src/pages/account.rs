//! One's own password, sessions and tokens.

use super::form::{Sent, role, vessel};
use super::frame::{Frame, PageError, html};
use super::rows::{self, SessionRow, TokenRow};
use super::rules::{MessageRow, Refused, RuleForm, RuleRow, message_row, new_rule, rule_row};
use super::words::{t, worded};
use crate::AppState;
use crate::web::{ApiError, Remote, Who};
use api::{NewToken, Vessel, say};
use askama::Template;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use operations::alarms::Priority;
use serde::Deserialize;
use shore::identity::{
    Fault, Language, Principal, Via, language, password, persons, sessions, tokens, vessels,
};
use shore::notices::{PER_HOUR, Webhooks};

#[derive(Template)]
#[template(path = "account.html")]
struct AccountPage {
    frame: Frame,
    must_change: bool,
    least: usize,
    sessions: Vec<SessionRow>,
    tokens: Vec<TokenRow>,
    vessels: Vec<Vessel>,
    rules: Vec<RuleRow>,
    priorities: [Priority; 4],
    new_rule: RuleForm,
    /// How messages of the new rule go, where that was chosen.
    new_way: &'static str,
    messages: Vec<MessageRow>,
    /// Whether this server sends mail, and webhooks.
    sends: (bool, bool),
    per_hour: usize,
    notice: String,
    problem: String,
    /// A new token, shown this once.
    secret: String,
    /// What a new webhook's messages are signed by, shown this once.
    signing: String,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Done {
    #[serde(default)]
    done: String,
}

/// What the page says above all else.
#[derive(Default)]
pub(super) struct Words {
    pub(super) notice: String,
    pub(super) problem: String,
    pub(super) secret: String,
    pub(super) signing: String,
    pub(super) refused: Option<Refused>,
}

/// `GET /account`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    Query(done): Query<Done>,
) -> Result<Response, PageError> {
    let notice = match done.done.as_str() {
        "password" => Some(frame.t("Your password is changed; your other sessions have ended.")),
        "session" => Some(frame.t("The session has ended.")),
        "token" => Some(frame.t("The token is revoked.")),
        "rule" => Some(frame.t("The rule is made. Try it with “Send a test message”.")),
        "rule-changed" => Some(frame.t("The rule is changed.")),
        "rule-removed" => Some(frame.t("The rule is removed.")),
        "language" => Some(frame.t("The pages speak the language that you chose.")),
        "delivered" => Some(frame.t("The test message was delivered.")),
        _ => None,
    };
    let notice = notice.map(|text| text.to_string()).unwrap_or_default();
    show(&state, &who, frame, Words { notice, ..Words::default() }).await
}

/// The page with words of its own.
pub(super) async fn show(
    state: &AppState,
    who: &Principal,
    frame: Frame,
    words: Words,
) -> Result<Response, PageError> {
    let person = who.person;
    let (own, must_change) = match &who.via {
        Via::Session { id, must_change_password, .. } => (Some(*id), *must_change_password),
        Via::Token { .. } => (None, false),
    };
    let read =
        state.shore.people.ask(((sessions::List(Some(person)), tokens::List(Some(person))), vessels::List));
    let ((sessions, tokens), vessels) = read.await?;
    let mine = state.shore.notices.mine(who).await?;
    let settings = state.shore.notices.settings();
    let (bad, language, refused) = (!words.problem.is_empty(), frame.language, words.refused.as_ref());
    let (new_rule, new_way) = new_rule(language, &vessels, refused);
    let mut response = html(&AccountPage {
        frame: Frame { path: "/account".to_owned(), ..frame },
        must_change,
        least: state.config.people.password_length,
        sessions: sessions.into_iter().map(|session| rows::session(session, own)).collect(),
        tokens: tokens.into_iter().map(|token| rows::token(language, token, &vessels)).collect(),
        priorities: [Priority::Emergency, Priority::Alarm, Priority::Warning, Priority::Caution],
        rules: mine.rules.iter().map(|rule| rule_row(language, rule, &vessels, refused)).collect(),
        new_rule,
        new_way,
        messages: mine.messages.into_iter().map(|message| message_row(language, message)).collect(),
        sends: (!settings.mail.host.is_empty(), settings.webhooks != Webhooks::Off),
        per_hour: PER_HOUR,
        vessels,
        notice: words.notice,
        problem: words.problem,
        secret: words.secret,
        signing: words.signing,
    });
    if bad {
        *response.status_mut() = StatusCode::UNPROCESSABLE_ENTITY;
    }
    Ok(response)
}

#[derive(Debug, Deserialize)]
pub(super) struct NewPassword {
    old: String,
    new: String,
    again: String,
}

/// `POST /account/password`.
pub(super) async fn password(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(sent): Sent<NewPassword>,
) -> Result<Response, PageError> {
    if let Err(problem) = change_password(&state, &who, (remote, frame.language), sent).await? {
        return show(&state, &who, frame, Words { problem, ..Words::default() }).await;
    }
    Ok(Redirect::to("/account?done=password").into_response())
}

async fn change_password(
    state: &AppState,
    who: &Principal,
    (remote, language): (Remote, Language),
    sent: NewPassword,
) -> Result<Result<(), String>, ApiError> {
    if sent.new != sent.again {
        return Ok(Err(t(language, "The new password was typed differently the second time.").to_string()));
    }
    if sent.new == sent.old {
        return Ok(Err(t(language, "The new password is the old one.").to_string()));
    }
    if let Err(problem) = password::check_new(&who.name, &sent.new, state.config.people.password_length) {
        return Ok(Err(worded(language, &problem)));
    }
    if let Err(refused) = state.shore.people.confirm(who, sent.old, remote.address).await {
        let error = ApiError::from(refused);
        return if error.status.is_server_error() {
            Err(error)
        } else {
            Ok(Err(worded(language, &error.text)))
        };
    }
    let password_hash = state.shore.people.hash(sent.new).await?;
    let keep = match who.via {
        Via::Session { id, .. } => Some(id),
        Via::Token { .. } => None,
    };
    let set = persons::SetPassword { name: who.name.clone(), password_hash, must_change: false, keep };
    state.shore.people.act(who, remote.address.to_string(), "password.change", who.name.clone(), set).await?;
    Ok(Ok(()))
}

#[derive(Debug, Deserialize)]
pub(super) struct ChosenLanguage {
    /// Its code; empty to follow what the browser asks for.
    language: String,
}

/// `POST /account/language`.
pub(super) async fn language(
    State(state): State<AppState>,
    Who(who): Who,
    Sent(chosen): Sent<ChosenLanguage>,
) -> Result<Response, PageError> {
    let code = &*chosen.language;
    let language = Language::by_code(code);
    if language.is_none() && !code.is_empty() {
        return Err(ApiError::bad_request(
            say("language: no pages speak `{code}`: give en, nb or nothing").with("code", code),
        )
        .into());
    }
    state.shore.people.change(language::Choose { person: who.person, language }).await?;
    Ok(Redirect::to("/account?done=language").into_response())
}

#[derive(Debug, Deserialize)]
pub(super) struct ById {
    id: i64,
}

/// `POST /account/session/end`.
pub(super) async fn session_end(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    let person = Some(who.person);
    let end = sessions::End { id, person };
    state.shore.people.act(&who, remote.address.to_string(), "session.end", id.to_string(), end).await?;
    Ok(Redirect::to("/account?done=session").into_response())
}

#[derive(Debug, Deserialize)]
pub(super) struct Wanted {
    label: String,
    role: String,
    vessel: String,
    days: u32,
}

/// `POST /account/token`.
pub(super) async fn token_make(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
    remote: Remote,
    Sent(wanted): Sent<Wanted>,
) -> Result<Response, PageError> {
    if matches!(who.via, Via::Token { .. }) {
        return Err(ApiError::forbidden(say("A token cannot make tokens: log in with a browser.")).into());
    }
    let new = NewToken {
        role: role(&wanted.role)?,
        vessel: vessel(&wanted.vessel)?,
        label: wanted.label,
        days: wanted.days,
    };
    let subject = new.label.clone();
    let make = tokens::Make { person: who.person, new, now: state.shore.clock.utc() };
    let made = state.shore.people.act(&who, remote.address.to_string(), "token.make", subject, make);
    let words = match made.await {
        Ok(made) => Words { secret: made.secret, ..Words::default() },
        Err(Fault::Refused(problem)) => {
            Words { problem: worded(frame.language, &problem), ..Words::default() }
        }
        Err(fault) => return Err(fault.into()),
    };
    show(&state, &who, frame, words).await
}

/// `POST /account/token/revoke`.
pub(super) async fn token_revoke(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    Sent(ById { id }): Sent<ById>,
) -> Result<Response, PageError> {
    let person = Some(who.person);
    let revoke = tokens::Revoke { id, person };
    state.shore.people.act(&who, remote.address.to_string(), "token.revoke", id.to_string(), revoke).await?;
    Ok(Redirect::to("/account?done=token").into_response())
}
