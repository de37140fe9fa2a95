//! State of the transports since the start, for the server's administrators: where each listens, refused peers, the last
//! error.

use crate::clock::Clock;
use api::{Said, say};
use hub::Transport;
use imc::Address;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use units::UtcTime;

/// Most characters of a text that are kept: some of it is from outside.
const LETTERS: usize = 300;

/// Handle of the ledger; cheap to clone.
#[derive(Debug, Clone)]
pub struct Ledger {
    book: Arc<Mutex<Book>>,
    clock: Clock,
}

#[derive(Debug, Default)]
struct Book {
    transports: BTreeMap<Transport, TransportRecord>,
    links: BTreeMap<Address, UtcTime>,
}

/// State of one transport.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TransportRecord {
    /// Where it listens; empty while it does not.
    pub address: String,
    /// Number of refused connections, or datagrams of unknown senders.
    pub refused: u64,
    /// The last of them, and why.
    pub refusal: Option<TransportEvent>,
    /// The last error.
    pub error: Option<TransportEvent>,
    /// Incoming packets that were lost because they arrived faster than they were read.
    pub lost: u64,
}

/// An event at a transport.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TransportEvent {
    /// Time of the event.
    pub at: UtcTime,
    /// With whom.
    pub whose: Whose,
    /// What happened, in words.
    pub what: Said,
}

/// With whom something happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Whose {
    /// A vessel, by its link.
    Vessel(Address),
    /// A peer, by its network address.
    Peer(String),
    /// The transport itself.
    Transport,
}

impl Ledger {
    /// Empty, with its clock.
    pub(crate) fn new(clock: Clock) -> Self {
        Self { book: Arc::default(), clock }
    }

    fn happened(&self, whose: Whose, what: impl Into<Said>) -> TransportEvent {
        let whose = match whose {
            Whose::Peer(name) => Whose::Peer(name.chars().take(LETTERS).collect()),
            known => known,
        };
        TransportEvent { at: self.clock.utc(), whose, what: what.into().at_most(LETTERS) }
    }

    fn book(&self) -> MutexGuard<'_, Book> {
        self.book.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, transport: Transport, change: impl FnOnce(&mut TransportRecord)) {
        change(self.book().transports.entry(transport).or_default());
    }

    /// A transport listens at an address.
    pub fn opened(&self, transport: Transport, address: String) {
        self.change(transport, |record| record.address = address);
    }

    /// Somebody was not let in.
    pub fn refused(&self, transport: Transport, who: IpAddr, why: impl Into<Said>) {
        let happened = self.happened(Whose::Peer(who.to_string()), why);
        self.change(transport, |record| {
            record.refused += 1;
            record.refusal = Some(happened);
        });
    }

    /// Something went wrong with a peer, or with the transport itself.
    pub fn failed(&self, transport: Transport, whose: Whose, what: impl Into<Said>) {
        let happened = self.happened(whose, what);
        self.change(transport, |record| record.error = Some(happened));
    }

    /// Sets the number of incoming packets lost since the start.
    pub fn lost(&self, transport: Transport, lost: u64) {
        self.change(transport, |record| {
            if lost > record.lost {
                let more = lost - record.lost;
                tracing::warn!(%transport, more, lost, "packets were lost: they came faster than they were taken");
                let what = match more {
                    1 => say("1 packet came faster than it was taken and is lost"),
                    _ => say("{n} packets came faster than they were taken and are lost").with("n", more),
                };
                record.error = Some(self.happened(Whose::Transport, what));
            }
            record.lost = lost;
        });
    }

    /// A vessel's link came up or went down.
    pub fn link_changed(&self, vessel: Address) {
        self.book().links.insert(vessel, self.clock.utc());
    }

    /// The state of a transport.
    pub fn of(&self, transport: Transport) -> TransportRecord {
        self.book().transports.get(&transport).cloned().unwrap_or_default()
    }

    /// When a vessel's link last went up or down.
    pub fn link_since(&self, vessel: Address) -> Option<UtcTime> {
        self.book().links.get(&vessel).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_are_counted_and_texts_from_outside_bounded() {
        let ledger = Ledger::new(Clock::real());
        ledger.refused(Transport::Udp, [10, 0, 0, 7].into(), say("not in transports.udp.allow"));
        ledger.refused(Transport::Udp, [10, 0, 0, 8].into(), Said::as_is("x".repeat(1_000)));
        ledger.failed(Transport::Udp, Whose::Peer("y".repeat(1_000)), Said::as_is("gone"));
        let record = ledger.of(Transport::Udp);
        let TransportEvent { whose, what, .. } = record.error.unwrap();
        assert_eq!((record.refused, whose, what.as_str()), (2, Whose::Peer("y".repeat(LETTERS)), "gone"));
        let TransportEvent { whose, what, .. } = record.refusal.unwrap();
        assert_eq!((whose, what.len()), (Whose::Peer("10.0.0.8".to_owned()), LETTERS));
        assert_eq!(ledger.of(Transport::Tcp), TransportRecord::default());
        ledger.lost(Transport::Udp, 0);
        assert_eq!(ledger.of(Transport::Udp).error.unwrap().what, "gone");
        ledger.lost(Transport::Udp, 37);
        ledger.lost(Transport::Udp, 37);
        let record = ledger.of(Transport::Udp);
        assert!(record.lost == 37 && record.error.unwrap().what.starts_with("37 packets came faster"));
        ledger.lost(Transport::Udp, 38);
        assert!(
            ledger.of(Transport::Udp).error.unwrap().what.starts_with("1 packet came faster than it was")
        );
    }
}
