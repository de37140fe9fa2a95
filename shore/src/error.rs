//! Errors of the shore: a kind for programs, a text for people.

use crate::identity::Fault;
use crate::router::Stopped;
use api::{NoControl, Said, say};
use operations::{ANSWER_WITHIN, LeaseRefused, NotYours};
use store::StoreError;

/// Kind of an error. Pages and the API map it to their own status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// The request is malformed.
    Malformed,
    /// The request is well-formed, but refused.
    Refused,
    /// Another user has control of the vessel.
    NoControl,
    /// A stop was ordered meanwhile.
    CalledOff,
    /// The chart shows danger.
    Grounding,
    /// The vessel has not reported which entities it has.
    UnknownEntities,
    /// It does not exist, or the person may not see it.
    NotFound,
    /// It existed, and no longer does.
    Gone,
    /// The person may not do this.
    Forbidden,
    /// There is a newer revision.
    Newer,
    /// The password must be changed first.
    PasswordChange,
    /// Too many requests of this kind; try again later.
    Busy,
    /// Temporarily not possible: a disk hangs, or the server is stopping.
    Unavailable,
    /// The server failed; the log says why.
    Internal,
}

/// An error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{text}")]
pub struct Error {
    /// For programs.
    pub kind: ErrorKind,
    /// For people: what is wrong and what to do.
    pub text: Said,
    /// What a page makes its own words of, where there is more than the kind.
    pub detail: Option<Box<Detail>>,
}

/// The parameters of a refusal.
#[derive(Debug, Clone, PartialEq)]
pub enum Detail {
    /// The guard's verdict.
    Guard(api::Guard),
    /// Why the user has no control.
    Control(api::NoControl),
}

/// Result of the shore's services.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Of a kind, with its text.
    pub fn new(kind: ErrorKind, text: impl Into<Said>) -> Self {
        Self { kind, text: text.into(), detail: None }
    }

    /// Understood, and cannot be.
    pub fn refused(text: impl Into<Said>) -> Self {
        Self::new(ErrorKind::Refused, text)
    }

    /// The chart shows danger, by this verdict.
    pub(crate) fn grounding(guard: api::Guard) -> Self {
        let text = say("The chart shows danger: {text}").with("text", &guard.text);
        Self { detail: Some(Box::new(Detail::Guard(guard))), ..Self::new(ErrorKind::Grounding, text) }
    }

    /// Whether a repeated request would be refused again: no fault of the server.
    pub(crate) fn is_final(&self) -> bool {
        !matches!(self.kind, ErrorKind::Unavailable | ErrorKind::Internal | ErrorKind::Busy)
    }

    /// The cause is logged, not shown.
    pub fn internal(error: &dyn std::fmt::Display) -> Self {
        tracing::error!(%error, "a request failed");
        Self::new(ErrorKind::Internal, say("The server failed; its log says why."))
    }
}

impl From<Stopped> for Error {
    fn from(_: Stopped) -> Self {
        Self::new(ErrorKind::Unavailable, say("The server is stopping."))
    }
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Refused(text) => Self::refused(text),
            Fault::NotYet(text) => Self::new(ErrorKind::PasswordChange, text),
            Fault::Busy => Self::new(
                ErrorKind::Busy,
                say("Too many passwords are being checked: try again in some seconds."),
            ),
            Fault::Hangs => {
                let text = say(
                    "app.db does not answer: does its disk hang, or has another program locked it? What you \
                     asked for may still be done when it answers: look before you ask again",
                );
                Self::new(ErrorKind::Unavailable, text)
            }
            Fault::Stopped => Stopped.into(),
            fault => Self::internal(&fault),
        }
    }
}

impl From<StoreError> for Error {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Query(text) => Self::new(ErrorKind::Malformed, Said::as_is(text)),
            StoreError::Asked(why) => {
                let text =
                    why.downcast().map_or_else(|why| Said::as_is(why.to_string()), |said: Box<Said>| *said);
                Self::new(ErrorKind::Malformed, text)
            }
            StoreError::Cancelled => Stopped.into(),
            error => no_room(&error).unwrap_or_else(|| Self::internal(&error)),
        }
    }
}

/// A file has no room, in the words of its writer; what the system alone says of it is logged.
fn no_room(error: &StoreError) -> Option<Error> {
    let StoreError::Io { source, .. } = error else { return None };
    let kind = match source.kind() {
        std::io::ErrorKind::FileTooLarge => ErrorKind::Refused,
        std::io::ErrorKind::StorageFull => ErrorKind::Unavailable,
        _ => return None,
    };
    source.get_ref().map(|text| Error::new(kind, Said::as_is(text.to_string())))
}

impl From<operations::NotOrdered> for Error {
    fn from(why: operations::NotOrdered) -> Self {
        match why {
            operations::NotOrdered::NoControl(why) => why.into(),
            operations::NotOrdered::CalledOff => {
                Self::new(ErrorKind::CalledOff, say("a stop was ordered before it could be sent"))
            }
            operations::NotOrdered::Refused(why) => Self::refused(why),
        }
    }
}

/// A question that has no answer as it was asked, in words that the catalogue has.
pub(crate) fn asked_wrong(text: impl Into<Said>) -> StoreError {
    StoreError::Asked(Box::new(text.into()))
}

impl From<LeaseRefused> for Error {
    fn from(why: LeaseRefused) -> Self {
        let text = why.said();
        let control = match why {
            LeaseRefused::NotYours(NotYours::Free) => NoControl::Free,
            LeaseRefused::NotYours(NotYours::Held(by)) => NoControl::Held { by },
            LeaseRefused::NotYours(NotYours::OtherWindow) => NoControl::OtherWindow,
            LeaseRefused::NotYours(NotYours::Expired) => NoControl::Expired,
            LeaseRefused::NobodyWaits => NoControl::NobodyWaits,
            LeaseRefused::AnotherWaits(by) => NoControl::Asked { by, within_s: ANSWER_WITHIN.as_secs() },
            LeaseRefused::NoReason(by) => NoControl::ReasonNeeded { by },
            LeaseRefused::TooLong(most) => NoControl::TooLong { most: most as u64 },
        };
        Self { detail: Some(Box::new(Detail::Control(control))), ..Self::new(ErrorKind::NoControl, text) }
    }
}

/// Runs slow work on a thread where it blocks no other task.
pub(crate) async fn slow<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> Result<R> {
    tokio::task::spawn_blocking(work).await.map_err(|error| Error::internal(&error))
}
