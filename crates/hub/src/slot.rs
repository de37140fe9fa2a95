//! The hub's state of a peer: the systems behind it, its send queue, and its figures.

use crate::delivery::Delivery;
use crate::peer::{Peer, PeerId, PeerState, Role, Sources};
use imc::Address;
use link::Transport;
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// A system lives behind a peer for this long after it was heard there.
const HOME_LASTS: Duration = Duration::from_mins(2);
/// How often at most a home's time is written again.
const HOME_REFRESH: Duration = Duration::from_secs(1);
/// A way is alive when its system was heard there within this: vessels say something each second.
const ALIVE: Duration = Duration::from_secs(3);
/// Systems that may live behind one peer; further ones are relayed but cannot be addressed there.
const HOMES_PER_PEER: usize = 256;

/// A peer.
#[derive(Debug)]
pub(crate) struct Slot {
    pub(crate) peer: Peer,
    since: UtcTime,
    homes: BTreeMap<Address, MonoTime>,
    /// The source that spoke last, and until when its home needs no look.
    speaker: Option<(Address, MonoTime)>,
    pub(crate) out: Vec<Delivery>,
    /// Whether it is a vessel's open link.
    pub(crate) stands: bool,
    /// Whether what it is given has room.
    pub(crate) takes: bool,
    pub(crate) received: u64,
    pub(crate) refused: u64,
    pub(crate) delivered: u64,
}

impl Slot {
    pub(crate) fn new(peer: Peer, since: UtcTime) -> Self {
        let homes = BTreeMap::new();
        Self {
            peer,
            since,
            homes,
            speaker: None,
            out: Vec::new(),
            stands: false,
            takes: true,
            received: 0,
            refused: 0,
            delivered: 0,
        }
    }

    /// Whether it is the link of this vessel.
    pub(crate) fn is_link_of(&self, vessel: Address) -> bool {
        self.peer.transport == Transport::Link
            && matches!(&self.peer.sources, Sources::Only(own) if own.contains(&vessel))
    }

    /// The vessels whose link it is.
    pub(crate) fn own_vessels(&self) -> Vec<Address> {
        match &self.peer.sources {
            Sources::Only(own) if self.peer.transport == Transport::Link => own.clone(),
            Sources::Only(_) | Sources::Any => Vec::new(),
        }
    }

    pub(crate) fn is_home_of(&self, address: Address, now: MonoTime) -> bool {
        self.homes.get(&address).is_some_and(|heard| now.since(*heard) < HOME_LASTS)
    }

    /// The systems that live behind it.
    pub(crate) fn homes(&self, now: MonoTime) -> impl Iterator<Item = Address> {
        self.homes
            .iter()
            .filter(move |(_, heard)| now.since(**heard) < HOME_LASTS)
            .map(|(address, _)| *address)
    }

    /// How good a way it is to a system behind it, the best one highest: one that is alive before one that is
    /// not, then by transport (those that report losses, and the nearest, first), then the one heard last.
    pub(crate) fn way_to(&self, address: Address, now: MonoTime) -> Option<(bool, u8, MonoTime)> {
        let heard = *self.homes.get(&address).filter(|heard| now.since(**heard) < HOME_LASTS)?;
        let by_transport = match self.peer.transport {
            Transport::Link => 3,
            Transport::Tcp => 2,
            Transport::Udp => 1,
            Transport::Proxy | Transport::Shore | Transport::Import | Transport::Recovered => 0,
        };
        Some((self.takes && now.since(heard) < ALIVE, by_transport, heard))
    }

    /// A packet of a system came. One that `came_before` was perhaps given to this peer and comes back: that makes no
    /// home of it.
    pub(crate) fn heard(&mut self, source: Address, now: MonoTime, came_before: bool) {
        if self.speaker.is_some_and(|(speaker, until)| speaker == source && now < until) {
            return;
        }
        let may_come_back = self.peer.role == Role::Console || source.is_ccu();
        if came_before && may_come_back && !self.is_home_of(source, now) {
            return;
        }
        self.speaker = Some((source, now + HOME_REFRESH));
        if self.homes.len() >= HOMES_PER_PEER && !self.homes.contains_key(&source) {
            self.homes.retain(|_, heard| now.since(*heard) < HOME_LASTS);
            if self.homes.len() >= HOMES_PER_PEER {
                return;
            }
        }
        self.homes.insert(source, now);
    }

    /// The system does not live here after all.
    pub(crate) fn disown(&mut self, address: Address) {
        self.homes.remove(&address);
        self.speaker = None;
    }

    pub(crate) fn state(&self, id: PeerId) -> PeerState {
        let mut homes: Vec<(MonoTime, Address)> = self.homes.iter().map(|(a, at)| (*at, *a)).collect();
        homes.sort_unstable();
        PeerState {
            id,
            peer: self.peer.clone(),
            since: self.since,
            systems: homes.into_iter().map(|(_, address)| address).collect(),
            received: self.received,
            refused: self.refused,
            delivered: self.delivered,
        }
    }
}
