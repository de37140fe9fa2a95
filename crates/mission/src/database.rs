//! The plan database: named plans as opaque bytes with a digest, who changed them and when.
//!
//! The database holds what is safely stored. A change is first passed to the shell ([`Effect`]), becomes
//! visible when the shell reports it done ([`PlanDatabase::stored`]) and is only then answered with success;
//! so a confirmed change survives a power cut, provided the shell writes atomically. Effects are to be
//! carried out in their order. Reading answers at once, by what is stored.
//!
//! Bounds: number of plans, bytes of one plan and of all, changes under way. At a bound a change is refused;
//! nothing is ever evicted.

mod answer;

pub use answer::{
    Answer, DatabaseError, DatabaseOperation, DatabaseReply, DatabaseState, Effect, Outgoing, PlanInfo,
};

use crate::engine::Origin;
use crate::plan_limits::PlanLimits;
use std::collections::{BTreeMap, VecDeque};
use units::UtcTime;

/// Digest of a plan's bytes, by the caller's algorithm.
pub type Digest = [u8; 16];

/// Who changed something, and when.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Change {
    /// Time of the change.
    pub at: UtcTime,
    /// Address of the system.
    pub system: u16,
    /// Its name.
    pub name: String,
}

/// A stored plan.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Record {
    /// Its name.
    pub plan_id: String,
    /// The plan, byte for byte as it came.
    pub bytes: Vec<u8>,
    /// Digest of the bytes.
    pub digest: Digest,
    /// Its last change.
    pub change: Change,
}

/// The stored state that the shell has found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Kept {
    /// The plans.
    pub plans: Vec<Record>,
    /// The last time that plans were forgotten, where that is known.
    pub forgotten: Option<Change>,
    /// The activity when the program ended, byte for byte as stored.
    pub under_way: Option<Vec<u8>>,
}

/// A request to the database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DatabaseQuery {
    /// Store a plan under its name, in place of one of that name.
    Set {
        /// The plan, byte for byte.
        bytes: Vec<u8>,
        /// Digest of the bytes.
        digest: Digest,
        /// The name inside the bytes; it must be that of the request.
        named: String,
    },
    /// Forget a plan.
    Delete,
    /// Send a plan.
    Get,
    /// Report a plan.
    GetInfo,
    /// Forget all plans.
    Clear,
    /// Report all plans.
    GetState,
}

impl DatabaseQuery {
    fn operation(&self) -> DatabaseOperation {
        match self {
            Self::Set { .. } => DatabaseOperation::Set,
            Self::Delete => DatabaseOperation::Delete,
            Self::Get => DatabaseOperation::Get,
            Self::GetInfo => DatabaseOperation::GetInfo,
            Self::Clear => DatabaseOperation::Clear,
            Self::GetState => DatabaseOperation::GetState,
        }
    }
}

/// A request to the database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatabaseRequest {
    /// The requester.
    pub origin: Origin,
    /// Name of the requester's system, for the record.
    pub name: String,
    /// Which plan; ignored where all are meant.
    pub plan_id: String,
    /// The request.
    pub ask: DatabaseQuery,
}

/// Number of a change under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket(pub u64);

/// Bounds of the database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatabaseLimits {
    /// Most plans.
    pub max_plans: usize,
    /// Most bytes of one plan.
    pub max_plan_bytes: usize,
    /// Most bytes of all plans.
    pub max_bytes: usize,
    /// Most changes under way.
    pub max_changes: usize,
    /// Longest name (bytes).
    pub max_name_bytes: usize,
}

impl Default for DatabaseLimits {
    /// A plan of [`PlanLimits`]' size fits some times over.
    fn default() -> Self {
        let max_plan_bytes = 512 * PlanLimits::default().max_maneuvers;
        Self {
            max_plans: 1_000,
            max_plan_bytes,
            max_bytes: 16 * max_plan_bytes,
            max_changes: 64,
            max_name_bytes: 256,
        }
    }
}

/// The database.
#[derive(Debug, Clone)]
pub struct PlanDatabase {
    limits: DatabaseLimits,
    records: BTreeMap<String, Record>,
    last_change: Option<Change>,
    under_way: BTreeMap<Ticket, UnderWay>,
    next_ticket: u64,
    outgoing: VecDeque<Outgoing>,
}

/// A change that the shell is carrying out.
#[derive(Debug, Clone)]
struct UnderWay {
    asked: Asked,
    effect: Effect,
}

/// The request to answer.
#[derive(Debug, Clone)]
struct Asked {
    origin: Origin,
    operation: DatabaseOperation,
    plan_id: String,
}

impl PlanDatabase {
    /// A database with what the shell has found stored. All of it is taken, bounds or not.
    pub fn new(limits: DatabaseLimits, kept: Kept) -> Self {
        let changes = kept.plans.iter().map(|record| &record.change).chain(&kept.forgotten);
        Self {
            limits,
            last_change: changes.max_by_key(|change| change.at).cloned(),
            records: kept.plans.into_iter().map(|record| (record.plan_id.clone(), record)).collect(),
            under_way: BTreeMap::new(),
            next_ticket: 0,
            outgoing: VecDeque::new(),
        }
    }

    /// A stored plan.
    pub fn get(&self, plan_id: &str) -> Option<&Record> {
        self.records.get(plan_id)
    }

    /// All stored plans, ordered by name.
    pub fn records(&self) -> impl Iterator<Item = &Record> {
        self.records.values()
    }

    /// The answers and the changes to store, in order.
    pub fn poll_outgoing(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }

    /// Takes a request at `now`.
    pub fn handle(&mut self, now: UtcTime, request: DatabaseRequest) {
        let DatabaseRequest { origin, name, plan_id, ask } = request;
        let operation = ask.operation();
        let of_all = matches!(operation, DatabaseOperation::Clear | DatabaseOperation::GetState);
        let named = if of_all { String::new() } else { plan_id.clone() };
        let asked = Asked { origin, operation, plan_id: named };
        let change = Change { at: now, system: origin.system, name };
        let effect = match ask {
            DatabaseQuery::Set { bytes, digest, named } => {
                let id = plan_id.clone();
                self.check_set(&id, &named, bytes.len()).map(|()| Effect::Store {
                    ticket: self.ticket(),
                    record: Record { plan_id: id, bytes, digest, change },
                })
            }
            DatabaseQuery::Delete => self.check_room().and_then(|()| {
                if self.will_exist(&plan_id) {
                    let (ticket, plan_id) = (self.ticket(), plan_id.clone());
                    Ok(Effect::Remove { ticket, plan_id, change })
                } else {
                    Err(DatabaseError::Undefined)
                }
            }),
            DatabaseQuery::Clear => {
                self.check_room().map(|()| Effect::RemoveAll { ticket: self.ticket(), change })
            }
            DatabaseQuery::Get => {
                let found = self.found(&plan_id).map(|record| Answer::Plan(record.clone()));
                return self.answer(asked, found);
            }
            DatabaseQuery::GetInfo => {
                let found = self.found(&plan_id).map(|record| Answer::Info(record.into()));
                return self.answer(asked, found);
            }
            DatabaseQuery::GetState => {
                let state = Answer::State(self.state());
                return self.answer(asked, Ok(state));
            }
        };
        self.begin(asked, effect);
    }

    /// The shell has carried out the effect of `ticket`, or failed with a text for people.
    pub fn stored(&mut self, ticket: Ticket, result: Result<(), String>) {
        let Some(UnderWay { asked, effect }) = self.under_way.remove(&ticket) else { return };
        let result = match (result, effect) {
            (Err(text), _) => Err(DatabaseError::Storage(text)),
            (Ok(()), Effect::Store { record, .. }) => {
                let info = PlanInfo::from(&record);
                self.last_change = Some(record.change.clone());
                let replaced = self.records.insert(record.plan_id.clone(), record).is_some();
                Ok(Answer::Stored { info, replaced })
            }
            (Ok(()), Effect::Remove { plan_id, change, .. }) => {
                self.last_change = Some(change);
                self.records.remove(&plan_id);
                Ok(Answer::Removed)
            }
            (Ok(()), Effect::RemoveAll { change, .. }) => {
                self.last_change = Some(change);
                self.records.clear();
                Ok(Answer::Removed)
            }
        };
        self.answer(asked, result);
    }

    /// About all plans.
    pub fn state(&self) -> DatabaseState {
        DatabaseState {
            plans: self.records.values().map(PlanInfo::from).collect(),
            bytes: self.records.values().map(|record| record.bytes.len()).sum(),
            last_change: self.last_change.clone(),
        }
    }

    fn begin(&mut self, asked: Asked, effect: Result<Effect, DatabaseError>) {
        self.reply(asked.clone(), None);
        match effect {
            Ok(effect) => {
                self.outgoing.push_back(Outgoing::Effect(effect.clone()));
                self.under_way.insert(effect.ticket(), UnderWay { asked, effect });
            }
            Err(error) => self.answer(asked, Err(error)),
        }
    }

    fn answer(&mut self, asked: Asked, result: Result<Answer, DatabaseError>) {
        self.reply(asked, Some(result));
    }

    fn reply(&mut self, asked: Asked, result: Option<Result<Answer, DatabaseError>>) {
        let Asked { origin, operation, plan_id } = asked;
        let reply = DatabaseReply { origin, operation, plan_id, result };
        self.outgoing.push_back(Outgoing::Reply(reply));
    }

    fn ticket(&mut self) -> Ticket {
        self.next_ticket += 1;
        Ticket(self.next_ticket)
    }

    fn found(&self, plan_id: &str) -> Result<&Record, DatabaseError> {
        self.records.get(plan_id).ok_or(DatabaseError::Undefined)
    }

    fn check_room(&self) -> Result<(), DatabaseError> {
        if self.under_way.len() < self.limits.max_changes { Ok(()) } else { Err(DatabaseError::Busy) }
    }

    fn check_set(&self, plan_id: &str, named: &str, size: usize) -> Result<(), DatabaseError> {
        self.check_room()?;
        if plan_id.is_empty() || plan_id.len() > self.limits.max_name_bytes {
            return Err(DatabaseError::BadName);
        }
        if plan_id != named {
            return Err(DatabaseError::NamesDiffer { named: named.to_owned() });
        }
        if size > self.limits.max_plan_bytes {
            return Err(DatabaseError::TooLarge { bytes: size, limit: self.limits.max_plan_bytes });
        }
        let (mut plans, mut bytes) = (1, size);
        for (other, other_bytes) in self.sizes_to_be() {
            if other != plan_id {
                plans += 1;
                bytes += other_bytes;
            }
        }
        if plans > self.limits.max_plans || bytes > self.limits.max_bytes {
            return Err(DatabaseError::Full);
        }
        Ok(())
    }

    fn will_exist(&self, plan_id: &str) -> bool {
        self.sizes_to_be().contains_key(plan_id)
    }

    /// Sizes once the changes under way are done. One that fails may leave its plan over the bounds.
    fn sizes_to_be(&self) -> BTreeMap<&str, usize> {
        let records = self.records.values();
        let mut sizes: BTreeMap<&str, usize> =
            records.map(|record| (record.plan_id.as_str(), record.bytes.len())).collect();
        for under_way in self.under_way.values() {
            match &under_way.effect {
                Effect::Store { record, .. } => {
                    sizes.insert(&record.plan_id, record.bytes.len());
                }
                Effect::Remove { plan_id, .. } => {
                    sizes.remove(plan_id.as_str());
                }
                Effect::RemoveAll { .. } => sizes.clear(),
            }
        }
        sizes
    }
}

#[cfg(test)]
mod tests;
