//! The plan database's answers, and its changes to store.

use super::{Change, Digest, Record, Ticket};
use crate::engine::Origin;
use thiserror::Error;

/// An output for the shell: an answer to send or a change to store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outgoing {
    /// Send this.
    Reply(DatabaseReply),
    /// Carry this out and report with [`PlanDatabase::stored`](super::PlanDatabase::stored).
    Effect(Effect),
}

/// A change of what is stored; each must be atomic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Store a plan in place of one of its name.
    Store {
        /// Number of the change.
        ticket: Ticket,
        /// The plan.
        record: Record,
    },
    /// Remove a plan, and keep the change as the last one.
    Remove {
        /// Number of the change.
        ticket: Ticket,
        /// Its name.
        plan_id: String,
        /// Who and when.
        change: Change,
    },
    /// Remove all plans, and keep the change as the last one.
    RemoveAll {
        /// Number of the change.
        ticket: Ticket,
        /// Who and when.
        change: Change,
    },
}

impl Effect {
    /// Number of the change.
    pub fn ticket(&self) -> Ticket {
        match self {
            Self::Store { ticket, .. } | Self::Remove { ticket, .. } | Self::RemoveAll { ticket, .. } => {
                *ticket
            }
        }
    }
}

/// An answer. Changes are answered twice: in progress, then with a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatabaseReply {
    /// The receiver.
    pub origin: Origin,
    /// The request.
    pub operation: DatabaseOperation,
    /// Which plan; empty where all are meant.
    pub plan_id: String,
    /// `None` while in progress.
    pub result: Option<Result<Answer, DatabaseError>>,
}

/// The request, for the reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DatabaseOperation {
    /// [`DatabaseQuery::Set`](super::DatabaseQuery::Set).
    Set,
    /// [`DatabaseQuery::Delete`](super::DatabaseQuery::Delete).
    Delete,
    /// [`DatabaseQuery::Get`](super::DatabaseQuery::Get).
    Get,
    /// [`DatabaseQuery::GetInfo`](super::DatabaseQuery::GetInfo).
    GetInfo,
    /// [`DatabaseQuery::Clear`](super::DatabaseQuery::Clear).
    Clear,
    /// [`DatabaseQuery::GetState`](super::DatabaseQuery::GetState).
    GetState,
}

/// A success.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The plan is stored.
    Stored {
        /// About it.
        info: PlanInfo,
        /// Whether it took the place of one of its name.
        replaced: bool,
    },
    /// The plan, or all of them, are gone.
    Removed,
    /// The plan.
    Plan(Record),
    /// About the plan.
    Info(PlanInfo),
    /// About all plans.
    State(DatabaseState),
}

/// Why the database did not do what was asked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DatabaseError {
    /// There is no plan of that name.
    #[error("undefined plan")]
    Undefined,
    /// The plan inside has another name than the request.
    #[error("the plan is named '{named}'")]
    NamesDiffer {
        /// That name.
        named: String,
    },
    /// The name is empty or too long.
    #[error("the name is empty or too long")]
    BadName,
    /// The plan is too large.
    #[error("the plan has {bytes} bytes, {limit} are allowed")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The limit.
        limit: usize,
    },
    /// There is no room for another plan.
    #[error("the plan database is full")]
    Full,
    /// Too many changes are under way.
    #[error("the plan database is busy")]
    Busy,
    /// The change could not be stored.
    #[error("storage failed: {0}")]
    Storage(String),
}

/// About a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanInfo {
    /// Its name.
    pub plan_id: String,
    /// Its size in bytes.
    pub bytes: usize,
    /// Digest of the bytes.
    pub digest: Digest,
    /// Its last change.
    pub change: Change,
}

impl From<&Record> for PlanInfo {
    fn from(record: &Record) -> Self {
        Self {
            plan_id: record.plan_id.clone(),
            bytes: record.bytes.len(),
            digest: record.digest,
            change: record.change.clone(),
        }
    }
}

/// About all plans.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DatabaseState {
    /// The plans, ordered by name. The state's own digest is that of their digests in this order.
    pub plans: Vec<PlanInfo>,
    /// Bytes of all plans.
    pub bytes: usize,
    /// The last change of any plan, also of those that are gone.
    pub last_change: Option<Change>,
}
