//! Forms and addresses as people send them: empty fields mean nothing was said.

use super::frame::PageError;
use crate::web::{ApiError, WholeBody, query};
use api::{Role, Said, say};
use axum::extract::{FromRequest, FromRequestParts, Path, Request};
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use shore::identity::vessels;

/// A form; what is malformed is answered by a page.
pub(super) struct Sent<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Sent<T> {
    type Rejection = PageError;
    async fn from_request(request: Request, state: &S) -> Result<Self, PageError> {
        let WholeBody(form) = WholeBody::from_request(request, state).await?;
        let form = std::str::from_utf8(&form).map_err(|_| {
            ApiError::bad_request(say("The form is not UTF-8: reload the page and try again."))
        })?;
        Ok(Self(query::read(form).map_err(|wrong| ApiError::bad_request(wrong.said()))?))
    }
}

/// The number of a plan or a mission in a page's address. What is not a number leads nowhere, like the number of one that is
/// not there.
pub(super) struct Numbered(pub(super) i64);

impl<S: Send + Sync> FromRequestParts<S> for Numbered {
    type Rejection = PageError;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, PageError> {
        let path = Path::<i64>::from_request_parts(parts, state).await;
        let Path(number) = path
            .map_err(|_| ApiError::not_found(say("There is nothing here: the address ends in no number.")))?;
        Ok(Self(number))
    }
}

/// Reads a role.
pub(super) fn role(text: &str) -> Result<Role, ApiError> {
    text.parse().map_err(|error: String| ApiError::bad_request(Said::as_is(error)))
}

/// Reads a role, or `none`.
pub(super) fn role_or_none(text: &str) -> Result<Option<Role>, ApiError> {
    if text == "none" { Ok(None) } else { role(text).map(Some) }
}

/// Reads a vessel's address; nothing means all vessels.
pub(super) fn vessel(text: &str) -> Result<Option<u16>, ApiError> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    let wrong = || say("{text} is not an IMC address; give one like 2068 or 0x0814.").with("text", text);
    vessels::address(text).map(Some).map_err(|_| ApiError::bad_request(wrong()))
}
