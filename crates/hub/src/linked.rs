//! Vessels that have a link with a token, and packets that others send with their addresses.
//!
//! A link authenticates the sender; the other transports have no passwords. So a vessel that has a link is trusted there,
//! and by the other transports that the configuration trusts. Packets with its address by another transport are refused and
//! counted, and reported for [`CLAIM_LASTS`] after the last of them.

use imc::Address;
use link::Transport;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use units::MonoTime;

/// How long a [`Contradiction`] is reported after the last such packet.
const CLAIM_LASTS: Duration = Duration::from_mins(1);
/// Characters of a peer's name that are reported.
const NAME_CHARS: usize = 100;

/// Another peer sends with the address of a vessel that has a link, and is not trusted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The vessel.
    pub vessel: Address,
    /// Where the other came in.
    pub transport: Transport,
    /// The other peer's name there, usually its address.
    pub peer: String,
}

/// Which senders are trusted at which transport.
#[derive(Debug, Default)]
pub(crate) struct Linked {
    vessels: BTreeSet<Address>,
    trusted: BTreeSet<Transport>,
    /// At most one for each vessel and transport.
    claims: BTreeMap<(Address, Transport), Claim>,
}

/// Packets in a vessel's name.
#[derive(Debug)]
struct Claim {
    peer: String,
    last: MonoTime,
}

impl Linked {
    pub(crate) fn trust(&mut self, transports: impl IntoIterator<Item = Transport>) {
        self.trusted = transports.into_iter().collect();
    }

    pub(crate) fn set(&mut self, vessels: BTreeSet<Address>) {
        self.claims.retain(|(vessel, _), _| vessels.contains(vessel));
        self.vessels = vessels;
    }

    pub(crate) fn vessels(&self) -> impl Iterator<Item = Address> {
        self.vessels.iter().copied()
    }

    /// Whether vessels that have a link are trusted at a transport.
    pub(crate) fn is_trusted(&self, transport: Transport) -> bool {
        transport == Transport::Link || self.trusted.contains(&transport)
    }

    /// Whether a vessel is not trusted at a transport.
    pub(crate) fn denies(&self, source: Address, transport: Transport) -> bool {
        self.vessels.contains(&source) && !self.is_trusted(transport)
    }

    /// A peer sent with a vessel's address.
    pub(crate) fn claimed(&mut self, now: MonoTime, vessel: Address, transport: Transport, peer: &str) {
        let empty = || Claim { peer: String::new(), last: now };
        let claim = self.claims.entry((vessel, transport)).or_insert_with(empty);
        if claim.peer != peer {
            claim.peer = peer.chars().take(NAME_CHARS).collect();
        }
        claim.last = now;
    }

    /// What must be reported now.
    pub(crate) fn contradictions(&mut self, now: MonoTime) -> Vec<Contradiction> {
        self.claims.retain(|_, claim| now.since(claim.last) < CLAIM_LASTS);
        let told = self.claims.iter().map(|((vessel, transport), claim)| Contradiction {
            vessel: *vessel,
            transport: *transport,
            peer: claim.peer.clone(),
        });
        told.collect()
    }
}
