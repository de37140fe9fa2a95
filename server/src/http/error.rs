//! How errors look to programs: a status, a code that stays, and a text for people.

use crate::people::{Fault, Refused};
use axum::Json;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use store::StoreError;

/// Something that did not work, ready to be answered.
#[derive(Debug, Clone)]
pub(crate) struct ApiError {
    pub(crate) status: StatusCode,
    /// For programs; stays the same.
    pub(crate) code: &'static str,
    /// For people: what is wrong and what to do.
    pub(crate) text: String,
    /// Seconds after which to try again.
    pub(crate) wait_s: Option<u64>,
}

impl ApiError {
    pub(crate) fn new(status: StatusCode, code: &'static str, text: impl Into<String>) -> Self {
        Self { status, code, text: text.into(), wait_s: None }
    }

    pub(crate) fn bad_request(text: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "bad_request", text)
    }

    /// What cannot be read, with the status that says in which way.
    pub(crate) fn malformed(status: StatusCode, text: impl Into<String>) -> Self {
        Self { status, ..Self::bad_request(text) }
    }

    pub(crate) fn not_found(text: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not_found", text)
    }

    pub(crate) fn forbidden(text: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, "forbidden", text)
    }

    pub(crate) fn unavailable(text: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "unavailable", text)
    }

    pub(crate) fn stopping() -> Self {
        Self::unavailable("The server is stopping.")
    }

    /// Too many ask for the same.
    pub(crate) fn busy(text: &str) -> Self {
        Self { wait_s: Some(10), ..Self::new(StatusCode::SERVICE_UNAVAILABLE, "busy", text) }
    }

    pub(crate) fn not_logged_in() -> Self {
        let text = "Log in at /login, or send Authorization: Bearer TOKEN with a token that has not ended.";
        Self::new(StatusCode::UNAUTHORIZED, "not_logged_in", text)
    }

    /// What went wrong inside is logged, not shown.
    pub(crate) fn internal(error: &dyn std::fmt::Display) -> Self {
        tracing::error!(%error, "a request failed");
        let text = "The server failed; its log says why.";
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", text)
    }
}

impl From<Fault> for ApiError {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Refused(text) => Self::new(StatusCode::UNPROCESSABLE_ENTITY, "refused", text),
            Fault::NotYet(text) => Self { code: "password_change_required", ..Self::forbidden(text) },
            Fault::Busy => Self::busy("Too many passwords are looked at: try again in some seconds."),
            Fault::Hangs => Self::unavailable(fault.to_string()),
            Fault::Stopped => Self::stopping(),
            fault => Self::internal(&fault),
        }
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Query(text) => Self::bad_request(text),
            StoreError::Cancelled => Self::stopping(),
            error => Self::internal(&error),
        }
    }
}

impl From<Refused> for ApiError {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Fault(fault) => fault.into(),
            Refused::Wrong | Refused::WrongOld => {
                Self::new(StatusCode::UNAUTHORIZED, "wrong", refused.to_string())
            }
            Refused::Wait(wait) => Self {
                wait_s: Some(wait.as_secs() + 1),
                ..Self::new(StatusCode::TOO_MANY_REQUESTS, "too_many_attempts", refused.to_string())
            },
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let body = Json(json!({ "error": { "code": self.code, "text": self.text } }));
        let mut response = (self.status, body).into_response();
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
