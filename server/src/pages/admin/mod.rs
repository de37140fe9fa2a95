//! Managing people, vessels and access.

pub(super) mod access;
pub(super) mod connections;
pub(super) mod import;
pub(super) mod people;
pub(super) mod storage;
pub(super) mod vessels;

use super::words::worded;
use crate::AppState;
use crate::web::{ApiError, Remote};
use api::Said;
use shore::identity::{Fault, Language, Principal, Request};
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

    /// Why something was not done.
    fn refused(language: Language, why: &Said) -> Self {
        Self::problem(worded(language, why))
    }
}

/// Does something with its line in the audit log; a refusal is for the page to say.
async fn act<R: Request>(
    state: &AppState,
    (who, remote): (&Principal, Remote),
    action: &'static str,
    subject: &str,
    request: R,
) -> Result<Result<R::Answer, Said>, ApiError> {
    match state.shore.people.act(who, remote.address.to_string(), action, subject.to_owned(), request).await {
        Ok(done) => Ok(Ok(done)),
        Err(Fault::Refused(why)) => Ok(Err(why)),
        Err(fault) => Err(fault.into()),
    }
}
