//! What happened at the doors since the start, for the people who keep the server: where each is open, whom it refused,
//! what went wrong last.

use crate::clock;
use hub::Door;
use imc::Address;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use units::UtcTime;

/// Letters of a text that are kept: some of it comes from outside.
const LETTERS: usize = 300;

/// The book; cheap to clone.
#[derive(Debug, Clone, Default)]
pub struct Ledger(Arc<Mutex<Book>>);

#[derive(Debug, Default)]
struct Book {
    doors: BTreeMap<Door, DoorRecord>,
    links: BTreeMap<Address, UtcTime>,
}

/// Of one door.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DoorRecord {
    /// Where it is open; empty while it is not.
    pub address: String,
    /// Whom or what it did not let in: connections, or datagrams of strangers.
    pub refused: u64,
    /// The last of them, and why.
    pub refusal: Option<Happened>,
    /// What went wrong last.
    pub error: Option<Happened>,
    /// Packets that were lost on the way in because they came faster than they could be taken.
    pub lost: u64,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Happened {
    pub at: UtcTime,
    pub text: String,
}

impl Happened {
    fn now(text: &str) -> Self {
        Self { at: clock::now(), text: text.chars().take(LETTERS).collect() }
    }
}

impl Ledger {
    fn book(&self) -> MutexGuard<'_, Book> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, door: Door, change: impl FnOnce(&mut DoorRecord)) {
        change(self.book().doors.entry(door).or_default());
    }

    /// A door is open at an address.
    pub fn opened(&self, door: Door, address: String) {
        self.change(door, |record| record.address = address);
    }

    /// Somebody was not let in.
    pub fn refused(&self, door: Door, who: IpAddr, why: &str) {
        let happened = Happened::now(&format!("{who}: {why}"));
        self.change(door, |record| {
            record.refused += 1;
            record.refusal = Some(happened);
        });
    }

    /// Something went wrong with a peer, or with the door itself.
    pub fn failed(&self, door: Door, what: &str) {
        let happened = Happened::now(what);
        self.change(door, |record| record.error = Some(happened));
    }

    /// So many packets were lost on the way in, since the start.
    pub fn lost(&self, door: Door, lost: u64) {
        self.change(door, |record| {
            if lost > record.lost {
                let more = lost - record.lost;
                tracing::warn!(%door, more, lost, "packets were lost: they came faster than they were taken");
                record.error = Some(Happened::now(&format!(
                    "{more} packets came faster than they were taken and are lost"
                )));
            }
            record.lost = lost;
        });
    }

    /// A vessel's link came up or went down.
    pub fn link_changed(&self, vessel: Address) {
        self.book().links.insert(vessel, clock::now());
    }

    /// What happened at a door.
    pub fn of(&self, door: Door) -> DoorRecord {
        self.book().doors.get(&door).cloned().unwrap_or_default()
    }

    /// Since when a vessel's link is as it is.
    pub fn link_since(&self, vessel: Address) -> Option<UtcTime> {
        self.book().links.get(&vessel).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_are_counted_and_texts_from_outside_bounded() {
        let ledger = Ledger::default();
        ledger.refused(Door::Udp, [10, 0, 0, 7].into(), "not in doors.udp.allow");
        ledger.refused(Door::Udp, [10, 0, 0, 8].into(), &"x".repeat(1_000));
        ledger.failed(Door::Udp, "gone");
        let record = ledger.of(Door::Udp);
        assert_eq!((record.refused, record.error.unwrap().text.as_str()), (2, "gone"));
        let text = record.refusal.unwrap().text;
        assert!(text.starts_with("10.0.0.8: x") && text.len() == LETTERS);
        assert_eq!(ledger.of(Door::Tcp), DoorRecord::default());
        ledger.lost(Door::Udp, 0);
        assert_eq!(ledger.of(Door::Udp).error.unwrap().text, "gone");
        ledger.lost(Door::Udp, 37);
        ledger.lost(Door::Udp, 37);
        let record = ledger.of(Door::Udp);
        assert!(record.lost == 37 && record.error.unwrap().text.starts_with("37 packets came faster"));
    }
}
