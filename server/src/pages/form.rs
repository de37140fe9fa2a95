//! Forms as people send them: empty fields mean nothing was said.

use super::frame::PageError;
use crate::http::ApiError;
use api::Role;
use axum::extract::rejection::FormRejection;
use axum::extract::{FromRequest, Request};
use serde::de::DeserializeOwned;
use shore::identity::vessels;

/// A form; what is malformed is answered by a page.
pub(super) struct Sent<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Sent<T> {
    type Rejection = PageError;
    async fn from_request(request: Request, state: &S) -> Result<Self, PageError> {
        let form = axum::extract::Form::<T>::from_request(request, state).await;
        let axum::extract::Form(sent) =
            form.map_err(|error: FormRejection| ApiError::malformed(error.status(), error.body_text()))?;
        Ok(Self(sent))
    }
}

/// Reads a role.
pub(super) fn role(text: &str) -> Result<Role, ApiError> {
    text.parse().map_err(|error: String| ApiError::bad_request(error))
}

/// Reads a vessel's address; nothing means all vessels.
pub(super) fn vessel(text: &str) -> Result<Option<u16>, ApiError> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    vessels::address(text).map(Some).map_err(ApiError::bad_request)
}
