//! Errors of the API: a status, a stable code, and a text for people.

use api::{Refusal, RefusalReason, Said, say};
use axum::Json;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use shore::identity::{Fault, Refused};
use shore::router::Stopped;
use shore::{Detail, ErrorKind};
use store::StoreError;

/// An error, ready to be sent.
#[derive(Debug, Clone)]
pub(crate) struct ApiError {
    pub(crate) status: StatusCode,
    /// For programs; stable.
    pub(crate) code: &'static str,
    /// For people: what is wrong and what to do.
    pub(crate) text: Said,
    /// Seconds after which to try again.
    pub(crate) wait_s: Option<u64>,
    /// Parameters from which a page makes its own text, if any.
    pub(crate) detail: Option<Box<Detail>>,
}

impl ApiError {
    pub(crate) fn new(status: StatusCode, code: &'static str, text: impl Into<Said>) -> Self {
        Self { status, code, text: text.into(), wait_s: None, detail: None }
    }

    pub(crate) fn bad_request(text: impl Into<Said>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad_request", text)
    }

    /// What cannot be read, with the status that says in which way.
    pub(crate) fn malformed(status: StatusCode, text: impl Into<Said>) -> Self {
        Self { status, ..Self::bad_request(text) }
    }

    pub(crate) fn not_found(text: impl Into<Said>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not_found", text)
    }

    pub(crate) fn forbidden(text: impl Into<Said>) -> Self {
        Self::new(StatusCode::FORBIDDEN, "forbidden", text)
    }

    pub(crate) fn unavailable(text: impl Into<Said>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "unavailable", text)
    }

    pub(crate) fn stopping() -> Self {
        Self::unavailable(say("The server is stopping."))
    }

    /// Too many ask for the same.
    pub(crate) fn busy(text: impl Into<Said>) -> Self {
        Self::busy_for(10, text)
    }

    /// The same; it may be asked again after so long (s).
    pub(crate) fn busy_for(wait_s: u64, text: impl Into<Said>) -> Self {
        Self { wait_s: Some(wait_s), ..Self::new(StatusCode::SERVICE_UNAVAILABLE, "busy", text) }
    }

    pub(crate) fn not_logged_in() -> Self {
        let text =
            say("Log in at /login, or send Authorization: Bearer TOKEN with a token that has not ended.");
        Self::new(StatusCode::UNAUTHORIZED, "not_logged_in", text)
    }

    /// The cause is logged, not shown.
    pub(crate) fn internal(error: &dyn std::fmt::Display) -> Self {
        tracing::error!(%error, "a request failed");
        let text = say("The server failed; its log says why.");
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", text)
    }
}

impl From<shore::Error> for ApiError {
    fn from(error: shore::Error) -> Self {
        let shore::Error { kind, text, detail } = error;
        let (status, code) = match kind {
            ErrorKind::Malformed => (StatusCode::BAD_REQUEST, "bad_request"),
            ErrorKind::Refused => (StatusCode::UNPROCESSABLE_ENTITY, "refused"),
            ErrorKind::Grounding => (StatusCode::UNPROCESSABLE_ENTITY, "grounding"),
            ErrorKind::NoControl => (StatusCode::CONFLICT, "no_control"),
            ErrorKind::CalledOff => (StatusCode::CONFLICT, "called_off"),
            ErrorKind::UnknownEntities => (StatusCode::CONFLICT, "unknown_entities"),
            ErrorKind::Newer => (StatusCode::CONFLICT, "newer_revision"),
            ErrorKind::NotFound => (StatusCode::NOT_FOUND, "not_found"),
            ErrorKind::Gone => (StatusCode::GONE, "gone"),
            ErrorKind::Forbidden => (StatusCode::FORBIDDEN, "forbidden"),
            ErrorKind::PasswordChange => (StatusCode::FORBIDDEN, "password_change_required"),
            ErrorKind::Busy => return Self::busy(text),
            ErrorKind::Unavailable => (StatusCode::SERVICE_UNAVAILABLE, "unavailable"),
            ErrorKind::Internal => (StatusCode::INTERNAL_SERVER_ERROR, "internal"),
        };
        Self { detail, ..Self::new(status, code, text) }
    }
}

impl From<Fault> for ApiError {
    fn from(fault: Fault) -> Self {
        shore::Error::from(fault).into()
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        shore::Error::from(error).into()
    }
}

impl From<Stopped> for ApiError {
    fn from(stopped: Stopped) -> Self {
        shore::Error::from(stopped).into()
    }
}

impl From<Refused> for ApiError {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Fault(fault) => fault.into(),
            Refused::Wrong | Refused::WrongOld => {
                Self::new(StatusCode::UNAUTHORIZED, "wrong", refused.said())
            }
            Refused::WrongPassword => Self::new(StatusCode::FORBIDDEN, "wrong_password", refused.said()),
            Refused::Wait(wait) => Self {
                wait_s: Some(wait.as_secs() + 1),
                ..Self::new(StatusCode::TOO_MANY_REQUESTS, "too_many_attempts", refused.said())
            },
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let (guard, control) = match self.detail.map(|detail| *detail) {
            Some(Detail::Guard(guard)) => (Some(guard), None),
            Some(Detail::Control(control)) => (None, Some(control)),
            None => (None, None),
        };
        let (text, says) = self.text.into_parts();
        let error = RefusalReason { code: self.code.to_owned(), text, guard, control, says };
        let mut response = (self.status, Json(Refusal { error })).into_response();
        if let Some(wait_s) = self.wait_s {
            response.headers_mut().insert(header::RETRY_AFTER, wait_s.into());
        }
        if self.status == StatusCode::UNAUTHORIZED {
            let way = header::HeaderValue::from_static("Bearer");
            response.headers_mut().insert(header::WWW_AUTHENTICATE, way);
        }
        response
    }
}
