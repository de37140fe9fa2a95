//! Why a request is refused: a stable code with parameters, from which pages make words; and a plain sentence.

use crate::{Guard, Wording};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The answer to a refused request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Refusal {
    /// The reason, as a code.
    pub error: RefusalReason,
}

/// Why something is not done.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct RefusalReason {
    /// Stays the same: `grounding`, `no_control`, `called_off`, `refused`, `not_found`, …
    pub code: String,
    /// In English, for scripts and logs: what is wrong and what to do.
    pub text: String,
    /// Of `grounding`: the verdict, with the legs and their worst spots.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard: Option<Guard>,
    /// Of `no_control`: why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<NoControl>,
    /// Of what pages make `text` in their reader's language, where it is no fixed sentence and neither of the two above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub says: Option<Wording>,
}

/// Why the requester has no control, or does not get it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "why", rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum NoControl {
    /// It is not held: it can be taken.
    Free,
    /// Another person has it.
    Held {
        /// The person who has it.
        by: String,
    },
    /// Another window of the same person has it.
    OtherWindow,
    /// It was theirs and expired.
    Expired,
    /// No client is waiting for it.
    NobodyWaits,
    /// Another person has asked already.
    Asked {
        /// The person who has it.
        by: String,
        /// Within how many seconds they get an answer.
        #[cfg_attr(test, ts(type = "number"))]
        within_s: u64,
    },
    /// A takeover needs a reason.
    ReasonNeeded {
        /// Who has it, and is informed.
        by: String,
    },
    /// A text is too long.
    TooLong {
        /// Letters that it may have.
        #[cfg_attr(test, ts(type = "number"))]
        most: u64,
    },
}
