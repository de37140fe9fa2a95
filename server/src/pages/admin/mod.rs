//! Managing people, vessels and access.

pub(super) mod access;
pub(super) mod connections;
pub(super) mod import;
pub(super) mod people;
pub(super) mod storage;
pub(super) mod vessels;

use crate::AppState;
use crate::web::{ApiError, Remote};
use shore::identity::{Fault, Principal, Request};
use std::fmt::Display;

/// What a page says above its table.
#[derive(Debug, Default)]
struct Words {
    notice: String,
    problem: String,
    /// For whom [`Words::secret`] is.
    secret_for: String,
    /// A password or token, shown this once.
    secret: String,
}

impl Words {
    fn notice(text: impl Display) -> Self {
        Self { notice: text.to_string(), ..Self::default() }
    }

    fn problem(text: impl Into<String>) -> Self {
        Self { problem: text.into(), ..Self::default() }
    }
}

/// Does something with its line in the audit log; a refusal becomes words for the page.
async fn act<R: Request>(
    state: &AppState,
    (who, remote): (&Principal, Remote),
    action: &'static str,
    subject: &str,
    request: R,
) -> Result<Result<R::Answer, Words>, ApiError> {
    match state.shore.people.act(who, remote.address.to_string(), action, subject.to_owned(), request).await {
        Ok(done) => Ok(Ok(done)),
        Err(Fault::Refused(text)) => Ok(Err(Words::problem(text))),
        Err(fault) => Err(fault.into()),
    }
}
