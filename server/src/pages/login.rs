//! Logging in and out.

use super::form::Sent;
use super::frame::{Frame, PageError, html, inside, set_secret_cookie};
use super::words::worded;
use crate::AppState;
use crate::web::{ApiError, Remote, SESSION_COOKIE, Who, cookie, cookie_name};
use askama::Template;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{AppendHeaders, IntoResponse, Redirect, Response};
use serde::Deserialize;
use shore::identity::{Attempt, Refused, Secret, Via, same, sessions};

/// Ties the login form to the browser it was shown in.
const FORM_COOKIE: &str = "lutra_login";
/// By which a browser is known to belong to somebody.
const DEVICE_COOKIE: &str = "lutra_device";
/// How long a login form may lie open, seconds.
const FORM_SECONDS: u32 = 86_400;
/// How long a browser is known, seconds.
const DEVICE_SECONDS: u32 = 400 * 86_400;

#[derive(Template)]
#[template(path = "login.html")]
struct LoginPage {
    frame: Frame,
    token: String,
    next: String,
    name: String,
    problem: String,
    plain: bool,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Next {
    #[serde(default)]
    next: String,
}

/// `GET /login`.
pub(super) async fn page(
    frame: Frame,
    remote: Remote,
    headers: HeaderMap,
    Query(query): Query<Next>,
) -> Response {
    if !frame.name.is_empty() {
        return Redirect::to(inside(&query.next)).into_response();
    }
    show(frame, remote, &headers, query.next, String::new(), String::new())
}

fn show(
    frame: Frame,
    remote: Remote,
    headers: &HeaderMap,
    next: String,
    name: String,
    problem: String,
) -> Response {
    let known = cookie(headers, &cookie_name(FORM_COOKIE, remote));
    let secret = known.unwrap_or_else(Secret::random);
    let plain = !remote.encrypted && !remote.address.is_loopback();
    let page = LoginPage { frame, token: secret.derived("login"), next, name, problem, plain };
    let cookie = set_secret_cookie(FORM_COOKIE, &secret.text(), FORM_SECONDS, remote);
    ([(header::SET_COOKIE, cookie)], html(&page)).into_response()
}

#[derive(Debug, Deserialize)]
pub(super) struct Login {
    name: String,
    password: String,
    #[serde(default)]
    csrf: String,
    #[serde(default)]
    next: String,
}

/// `POST /login`.
pub(super) async fn login(
    State(state): State<AppState>,
    frame: Frame,
    remote: Remote,
    headers: HeaderMap,
    Sent(login): Sent<Login>,
) -> Result<Response, PageError> {
    let Login { name, password, csrf, next } = login;
    let form = cookie(&headers, &cookie_name(FORM_COOKIE, remote));
    if !form.is_some_and(|secret| same(&secret.derived("login"), &csrf)) {
        let problem = frame.t("The form was too old, or cookies are switched off. Try again.").to_string();
        return Ok(show(frame, remote, &headers, next, name, problem));
    }
    let agent = headers.get(header::USER_AGENT).and_then(|agent| agent.to_str().ok()).unwrap_or_default();
    let attempt = Attempt {
        name: name.trim().to_owned(),
        password,
        address: remote.address,
        agent: agent.to_owned(),
        device: cookie(&headers, &cookie_name(DEVICE_COOKIE, remote)),
    };
    let logged_in = match state.shore.people.login(attempt).await {
        Ok(logged_in) => logged_in,
        Err(Refused::Fault(fault)) => return Err(fault.into()),
        Err(refused) => {
            let error = ApiError::from(refused);
            let problem = worded(frame.language, &error.text);
            let mut response = show(frame, remote, &headers, next, name, problem);
            *response.status_mut() = error.status;
            if let Some(wait_s) = error.wait_s {
                response.headers_mut().insert(header::RETRY_AFTER, wait_s.into());
            }
            return Ok(response);
        }
    };
    let seconds = state.config.people.session_days * 86_400;
    let cookies = AppendHeaders([
        (header::SET_COOKIE, set_secret_cookie(SESSION_COOKIE, &logged_in.session.text(), seconds, remote)),
        (
            header::SET_COOKIE,
            set_secret_cookie(DEVICE_COOKIE, &logged_in.device.text(), DEVICE_SECONDS, remote),
        ),
        (header::SET_COOKIE, set_secret_cookie(FORM_COOKIE, "", 0, remote)),
    ]);
    let next = if logged_in.must_change_password { "/account" } else { inside(&next) };
    Ok((StatusCode::SEE_OTHER, cookies, [(header::LOCATION, next.to_owned())]).into_response())
}

/// `POST /logout`.
pub(super) async fn logout(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
) -> Result<Response, PageError> {
    if let Via::Session { id, .. } = who.via {
        let end = sessions::End { id, person: None };
        state.shore.people.act(&who, remote.address.to_string(), "logout", who.name.clone(), end).await?;
    }
    let cookie = set_secret_cookie(SESSION_COOKIE, "", 0, remote);
    Ok(([(header::SET_COOKIE, cookie)], Redirect::to("/login")).into_response())
}
