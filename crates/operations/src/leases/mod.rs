//! Who commands a vessel: one lease per vessel, requested, granted, renewed, taken over, and expiring on its own.
//!
//! A lease has an epoch that grows with every grant, also over restarts of the server, because a grant takes the
//! greater of the last one plus one and UTC in µs. The epoch is sent to the vessel, which obeys only its holder while
//! the lease is valid, so that an order of a former holder is void however late it comes.
//!
//! | asked | while free | while another has it | by its holder |
//! |---|---|---|---|
//! | request | granted | waits for an answer, granted after [`ANSWER_WITHIN`] | renewed, or moved to this window |
//! | grant, decline | refused | the requester may withdraw | decides about the request |
//! | take | granted | granted at once; a person who waits waits again | as request |
//! | renew | refused | refused | lasts [`LASTS`] from now |
//! | release | refused | refused | ends; a person who waits has it then |

#[cfg(test)]
mod tests;

use api::{Wording, say};
use imc::Address;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// A lease expires so long after its holder's page was last heard.
pub const LASTS: Duration = Duration::from_mins(1);
/// A request that the holder does not answer within this is granted.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(30);
/// Most characters of a reason.
pub const REASON_CHARS: usize = 200;
/// Most characters of the key that distinguishes a person's windows.
const KEY_CHARS: usize = 64;
/// Events that were not fetched yet; the oldest is dropped first, and counted.
const EVENTS_KEPT: usize = 1_000;

/// A person in one window, or one of their scripts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// The person's number.
    pub person: i64,
    /// The person's name.
    pub name: String,
    /// Distinguishes the windows of a person; empty for scripts.
    pub key: String,
}

/// A lease that is held.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Held {
    /// Who has control.
    pub holder: Holder,
    /// Grows with every grant.
    pub epoch: u64,
    /// Since when.
    pub since: UtcTime,
    /// Until when unless it is renewed, by UTC as it was at the last renewal.
    pub until: UtcTime,
    expires: MonoTime,
}

/// A person who asked for a lease that another holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiting {
    /// Who waits for it.
    pub who: Holder,
    /// Why, in their words; may be empty.
    pub reason: String,
    /// Since when.
    pub since: UtcTime,
    /// When it is granted without an answer.
    pub granted_at: UtcTime,
    due: MonoTime,
}

/// How a lease changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// It was free and is held now.
    Granted,
    /// Another person waits for it.
    Requested,
    /// The holder gave it to the requester.
    HandedOver,
    /// The holder did not answer in time, so that the requester has it.
    Unanswered,
    /// The holder keeps it.
    Declined,
    /// The requester withdrew.
    Withdrawn,
    /// The holder gave it back.
    Released,
    /// The holder's page was not heard for too long.
    Expired,
    /// Another person took it without asking.
    TakenOver,
}

impl Change {
    /// A stable word for people and machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Granted => "granted",
            Self::Requested => "requested",
            Self::HandedOver => "handed over",
            Self::Unanswered => "granted without an answer",
            Self::Declined => "declined",
            Self::Withdrawn => "withdrawn",
            Self::Released => "released",
            Self::Expired => "expired",
            Self::TakenOver => "taken over",
        }
    }
}

/// An event of a lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeaseEvent {
    /// The vessel.
    pub vessel: Address,
    /// Time of the change.
    pub at: UtcTime,
    /// The change.
    pub change: Change,
    /// Who did it, or whom it concerns where it happened automatically.
    pub who: String,
    /// Who had the lease before, where that is another.
    pub from: Option<String>,
    /// Why, in their words; may be empty.
    pub reason: String,
}

/// The lease of one vessel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lease {
    /// Who holds it; `None` while it is free.
    pub held: Option<Held>,
    /// Who waits for it.
    pub waiting: Option<Waiting>,
    /// The last event.
    pub last: Option<LeaseEvent>,
    /// The greatest epoch that was given out.
    pub last_epoch: u64,
    revision: u64,
}

/// A request about a lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeaseRequest {
    /// To have it, for this reason, if the holder agrees or does not answer.
    Request(String),
    /// To grant it to the person who waits.
    Grant,
    /// To decline the request; by the person who waits: to withdraw it.
    Decline,
    /// To give it back.
    Release,
    /// To keep it.
    Renew,
    /// To have it at once, for this reason.
    Take(String),
}

/// Why a request about a lease is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeaseRefused {
    /// Only the holder may do that.
    NotYours(NotYours),
    /// No one is waiting.
    NobodyWaits,
    /// Another waits already.
    AnotherWaits(String),
    /// Taking over needs a reason, which this person will see.
    NoReason(String),
    /// A text is too long: the limit.
    TooLong(usize),
}

/// Why a person does not have control.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotYours {
    /// It is not held.
    Free,
    /// This person has it.
    Held(String),
    /// Another window of the same person has it.
    OtherWindow,
    /// It was theirs.
    Expired,
}

impl LeaseRefused {
    /// In words that the catalogue has.
    pub fn said(&self) -> Wording {
        match self {
            Self::NotYours(NotYours::Free) => say("You do not have control of this vessel: take it first."),
            Self::NotYours(NotYours::Held(by)) => {
                say("You do not have control of this vessel: {by} has it.").with("by", by)
            }
            Self::NotYours(NotYours::OtherWindow) => {
                say("Another of your windows has control of this vessel: take it here first.")
            }
            Self::NotYours(NotYours::Expired) => say("Your control of this vessel expired: take it again."),
            Self::NobodyWaits => say("Nobody waits for control of this vessel."),
            Self::AnotherWaits(by) => say("{by} has asked already and gets an answer within {n} s.")
                .with("by", by)
                .with("n", ANSWER_WITHIN.as_secs()),
            Self::NoReason(by) => say("Say why you take over: {by} will see it.").with("by", by),
            Self::TooLong(most) => say("This is longer than {n} characters.").with("n", most),
        }
    }
}

impl fmt::Display for LeaseRefused {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.said().fmt(out)
    }
}

impl std::error::Error for LeaseRefused {}

/// The leases of all vessels.
#[derive(Debug, Default)]
pub struct Leases {
    vessels: BTreeMap<Address, Lease>,
    events: VecDeque<LeaseEvent>,
    forgotten: u64,
    revision: u64,
}

impl Leases {
    /// Carries out the request of `who`, or says why not. Nothing changes in that case.
    ///
    /// # Errors
    /// Why not.
    pub fn ask(
        &mut self,
        now: Now,
        vessel: Address,
        who: &Holder,
        ask: LeaseRequest,
    ) -> Result<(), LeaseRefused> {
        if who.key.chars().count() > KEY_CHARS {
            return Err(LeaseRefused::TooLong(KEY_CHARS));
        }
        self.tick(now);
        match ask {
            LeaseRequest::Request(reason) => self.request(now, vessel, who, reason),
            LeaseRequest::Take(reason) => self.take(now, vessel, who, reason),
            LeaseRequest::Grant => {
                self.of_holder(vessel, who)?;
                let waiting = self.stop_waiting(vessel).ok_or(LeaseRefused::NobodyWaits)?;
                self.grant(now, vessel, waiting.who, Change::HandedOver, waiting.reason);
                Ok(())
            }
            LeaseRequest::Decline => {
                let withdrawn = self.of(vessel).waiting.as_ref().is_some_and(|one| same(&one.who, who));
                if !withdrawn {
                    self.of_holder(vessel, who)?;
                }
                let waiting = self.stop_waiting(vessel).ok_or(LeaseRefused::NobodyWaits)?;
                let change = if withdrawn { Change::Withdrawn } else { Change::Declined };
                self.note(now, vessel, change, who.name.clone(), Some(waiting.who.name), String::new());
                Ok(())
            }
            LeaseRequest::Release => {
                self.of_holder(vessel, who)?;
                self.end(now, vessel, Change::Released);
                Ok(())
            }
            LeaseRequest::Renew => {
                let held = self.of_holder(vessel, who)?;
                if held.holder.key != who.key {
                    return Err(LeaseRefused::NotYours(NotYours::OtherWindow));
                }
                let lease = self.vessels.entry(vessel).or_default();
                if let Some(held) = &mut lease.held {
                    (held.expires, held.until) = (now.mono + LASTS, later(now, LASTS));
                }
                self.revision += 1;
                lease.revision = self.revision;
                Ok(())
            }
        }
    }

    /// Time passes: leases end, and requests without an answer are granted. Call it about once a second.
    pub fn tick(&mut self, now: Now) {
        let due: Vec<Address> = self
            .vessels
            .iter()
            .filter(|(_, lease)| {
                lease.held.as_ref().is_some_and(|held| now.mono >= held.expires)
                    || lease.waiting.as_ref().is_some_and(|waiting| now.mono >= waiting.due)
            })
            .map(|(vessel, _)| *vessel)
            .collect();
        for vessel in due {
            let expired = self.of(vessel).held.as_ref().is_some_and(|held| now.mono >= held.expires);
            if expired {
                self.end(now, vessel, Change::Expired);
            } else if let Some(waiting) = self.stop_waiting(vessel) {
                self.grant(now, vessel, waiting.who, Change::Unanswered, waiting.reason);
            }
        }
    }

    /// The lease of a vessel.
    pub fn of(&self, vessel: Address) -> &Lease {
        static FREE: Lease = Lease { held: None, waiting: None, last: None, last_epoch: 0, revision: 0 };
        self.vessels.get(&vessel).unwrap_or(&FREE)
    }

    /// The epoch under which `who` may command a vessel at present, from this very window.
    ///
    /// # Errors
    /// Who may do it instead.
    pub fn epoch(&self, now: Now, vessel: Address, who: &Holder) -> Result<u64, LeaseRefused> {
        let held = self.of_holder(vessel, who)?;
        if held.holder.key != who.key {
            return Err(LeaseRefused::NotYours(NotYours::OtherWindow));
        }
        if now.mono >= held.expires {
            return Err(LeaseRefused::NotYours(NotYours::Expired));
        }
        Ok(held.epoch)
    }

    /// All leases that changed after `revision`.
    pub fn changed(&self, revision: u64) -> impl Iterator<Item = (Address, &Lease)> {
        self.vessels
            .iter()
            .filter(move |(_, one)| one.revision > revision)
            .map(|(vessel, one)| (*vessel, one))
    }

    /// Counts changes.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The events since the last call, and how many were dropped because they were not fetched.
    pub fn drain(&mut self) -> (Vec<LeaseEvent>, u64) {
        (self.events.drain(..).collect(), std::mem::take(&mut self.forgotten))
    }

    fn of_holder(&self, vessel: Address, who: &Holder) -> Result<&Held, LeaseRefused> {
        match &self.of(vessel).held {
            Some(held) if held.holder.person == who.person => Ok(held),
            Some(held) => Err(LeaseRefused::NotYours(NotYours::Held(held.holder.name.clone()))),
            None => Err(LeaseRefused::NotYours(NotYours::Free)),
        }
    }

    fn request(
        &mut self,
        now: Now,
        vessel: Address,
        who: &Holder,
        reason: String,
    ) -> Result<(), LeaseRefused> {
        bounded(&reason)?;
        let lease = self.of(vessel);
        match (&lease.held, &lease.waiting) {
            (None, _) => {
                self.grant(now, vessel, who.clone(), Change::Granted, reason);
                Ok(())
            }
            (Some(held), _) if held.holder == *who => self.ask(now, vessel, who, LeaseRequest::Renew),
            (Some(held), _) if held.holder.person == who.person => {
                self.grant(now, vessel, who.clone(), Change::TakenOver, "in another window".to_owned());
                Ok(())
            }
            (Some(_), Some(waiting)) if !same(&waiting.who, who) => {
                Err(LeaseRefused::AnotherWaits(waiting.who.name.clone()))
            }
            (Some(held), waiting) => {
                let from = Some(held.holder.name.clone());
                let (since, due) =
                    waiting.as_ref().map_or((now.utc, now.mono + ANSWER_WITHIN), |one| (one.since, one.due));
                let granted_at = later(now, due.since(now.mono));
                let waiting = Waiting { who: who.clone(), reason: reason.clone(), since, granted_at, due };
                self.vessels.entry(vessel).or_default().waiting = Some(waiting);
                self.note(now, vessel, Change::Requested, who.name.clone(), from, reason);
                Ok(())
            }
        }
    }

    fn take(&mut self, now: Now, vessel: Address, who: &Holder, reason: String) -> Result<(), LeaseRefused> {
        bounded(&reason)?;
        match &self.of(vessel).held {
            Some(held) if held.holder.person != who.person => {
                if reason.trim().is_empty() {
                    return Err(LeaseRefused::NoReason(held.holder.name.clone()));
                }
                // Another person who waited now waits for the new holder, who gets the whole time to answer.
                if let Some(waiting) = self.stop_waiting(vessel).filter(|one| !same(&one.who, who)) {
                    let (granted_at, due) = (later(now, ANSWER_WITHIN), now.mono + ANSWER_WITHIN);
                    let waiting = Waiting { granted_at, due, ..waiting };
                    self.vessels.entry(vessel).or_default().waiting = Some(waiting);
                }
                self.grant(now, vessel, who.clone(), Change::TakenOver, reason);
                Ok(())
            }
            Some(_) | None => self.request(now, vessel, who, reason),
        }
    }

    fn stop_waiting(&mut self, vessel: Address) -> Option<Waiting> {
        self.vessels.get_mut(&vessel)?.waiting.take()
    }

    fn grant(&mut self, now: Now, vessel: Address, who: Holder, change: Change, reason: String) {
        let lease = self.vessels.entry(vessel).or_default();
        let utc_us = u64::try_from(now.utc.micros()).unwrap_or_default();
        let epoch = (lease.last_epoch + 1).max(utc_us);
        lease.last_epoch = epoch;
        let name = who.name.clone();
        let held =
            Held { holder: who, epoch, since: now.utc, until: later(now, LASTS), expires: now.mono + LASTS };
        let from = lease.held.replace(held).map(|before| before.holder.name);
        self.note(now, vessel, change, name, from, reason);
    }

    /// Ends a lease; a person who waits has it then.
    fn end(&mut self, now: Now, vessel: Address, change: Change) {
        let Some(lease) = self.vessels.get_mut(&vessel) else { return };
        let Some(held) = lease.held.take() else { return };
        let waiting = lease.waiting.take();
        self.note(now, vessel, change, held.holder.name, None, String::new());
        if let Some(waiting) = waiting {
            self.grant(now, vessel, waiting.who, Change::Granted, waiting.reason);
        }
    }

    fn note(
        &mut self,
        now: Now,
        vessel: Address,
        change: Change,
        who: String,
        from: Option<String>,
        reason: String,
    ) {
        let event = LeaseEvent { vessel, at: now.utc, change, who, from, reason };
        self.revision += 1;
        let lease = self.vessels.entry(vessel).or_default();
        (lease.last, lease.revision) = (Some(event.clone()), self.revision);
        if self.events.len() >= EVENTS_KEPT {
            self.events.pop_front();
            self.forgotten += 1;
        }
        self.events.push_back(event);
    }
}

fn same(one: &Holder, other: &Holder) -> bool {
    one.person == other.person
}

fn bounded(reason: &str) -> Result<(), LeaseRefused> {
    if reason.chars().count() > REASON_CHARS {
        return Err(LeaseRefused::TooLong(REASON_CHARS));
    }
    Ok(())
}

fn later(now: Now, span: Duration) -> UtcTime {
    // A minute at most.
    UtcTime::from_micros(now.utc.micros().saturating_add(span.as_micros() as i64))
}
