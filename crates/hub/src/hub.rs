//! Who hears what.
//!
//! | packet | goes to |
//! |---|---|
//! | from an IMCProxy client | every other IMCProxy client, whatever its destination, as that protocol has it |
//! | for one system | the peers behind which that system was heard last |
//! | for everyone, from a vessel | every console |
//! | for everyone, from a console | every console and every vessel |
//! | for this server | nobody: the fleet's state and the record take it |
//!
//! Never back to where it came from, never towards a peer behind which its own source lives, and a packet that was
//! here before by another door goes nowhere: so two relays, or a vessel that is reached twice, make no loop.
//! Every packet that is new is recorded, whether somebody hears it or not.

use crate::Now;
use crate::alarm::{Alarms, Outside};
use crate::command::Commands;
use crate::duplicates::{self, Window};
use crate::fleet::Fleet;
use crate::lease::Leases;
use crate::node::Node;
use crate::peer::{Door, Peer, PeerId, PeerState, Role};
use bytes::Bytes;
use imc::messages::{self as m, Payload as _};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// A system lives behind a peer for this long after it was heard there.
const HOME_LASTS: Duration = Duration::from_mins(2);
/// How often at most a home's time is written anew.
const HOME_REFRESH: Duration = Duration::from_secs(1);
/// Systems that may live behind one peer; further ones are relayed but cannot be addressed there.
const HOMES_PER_PEER: usize = 256;

/// What the hub is told once.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// This server's own address, a console's (0x4000 to 0x5FFF), or vessels would not count its heartbeats.
    pub address: Address,
    /// This server's own name.
    pub name: String,
    /// Whether the server takes part as a console: announces itself, sends heartbeats so that vessels keep
    /// sending, and asks for names of entities. Without it the server only listens.
    pub active: bool,
}

/// The place of a packet on the vessel link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinkSeq {
    /// The vessel's spool.
    pub stream: u64,
    /// Its number there.
    pub seq: u64,
}

/// How a packet came by the vessel link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Not by the link, or as a record of the present: it is shown, relayed and recorded.
    Present,
    /// The latest value ahead of the records: it is shown and relayed; its record comes later.
    Live,
    /// A record of the past: it is recorded, and neither shown nor relayed.
    Backlog,
}

/// A packet from a peer.
#[derive(Debug, Clone)]
pub struct Incoming {
    /// The packet's bytes.
    pub packet: Bytes,
    /// Its place on the vessel link.
    pub link: Option<LinkSeq>,
    /// How it came.
    pub lane: Lane,
}

impl From<Bytes> for Incoming {
    fn from(packet: Bytes) -> Self {
        Self { packet, link: None, lane: Lane::Present }
    }
}

/// A packet for the archive.
#[derive(Debug, Clone)]
pub struct Record {
    /// The packet's bytes.
    pub packet: Bytes,
    /// When it came.
    pub received: UtcTime,
    /// By which door.
    pub door: Door,
    /// Its place on the vessel link, to acknowledge once it is durable.
    pub link: Option<LinkSeq>,
}

/// What happened so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Packets that came.
    pub received: u64,
    /// Bytes that were no packet.
    pub damaged: u64,
    /// Packets of a source that their peer may not speak for.
    pub refused: u64,
    /// Copies of packets that were here before.
    pub duplicates: u64,
    /// Deliveries to peers.
    pub delivered: u64,
    /// Packets for one system that lives behind no peer.
    pub unroutable: u64,
}

#[derive(Debug)]
struct Slot {
    peer: Peer,
    since: UtcTime,
    homes: BTreeMap<Address, MonoTime>,
    /// The source that spoke last, and until when its home needs no look.
    speaker: Option<(Address, MonoTime)>,
    out: Vec<Bytes>,
    received: u64,
    refused: u64,
    delivered: u64,
}

impl Slot {
    fn is_home_of(&self, address: Address, now: MonoTime) -> bool {
        self.homes.get(&address).is_some_and(|heard| now.since(*heard) < HOME_LASTS)
    }

    fn heard(&mut self, source: Address, now: MonoTime) {
        if self.speaker.is_some_and(|(speaker, until)| speaker == source && now < until) {
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
}

/// Routing, the fleet's state and what goes to the archive.
#[derive(Debug)]
pub struct Hub {
    settings: Settings,
    node: Node,
    fleet: Fleet,
    peers: BTreeMap<PeerId, Slot>,
    next_peer: u32,
    samples: Window,
    deliveries: Window,
    records: Vec<Record>,
    counters: Counters,
    leases: Leases,
    commands: Commands,
    alarms: Alarms,
}

impl Hub {
    /// A hub without peers.
    pub fn new(settings: Settings) -> Self {
        Self {
            node: Node::new(&settings),
            commands: Commands::new(settings.address),
            leases: Leases::default(),
            alarms: Alarms::default(),
            settings,
            fleet: Fleet::default(),
            peers: BTreeMap::new(),
            next_peer: 1,
            samples: Window::default(),
            deliveries: Window::default(),
            records: Vec::new(),
            counters: Counters::default(),
        }
    }

    /// What the fleet looks like.
    pub fn fleet(&self) -> &Fleet {
        &self.fleet
    }

    /// Who commands which vessel.
    pub fn leases(&self) -> &Leases {
        &self.leases
    }

    /// Who commands which vessel, to change it.
    pub fn leases_mut(&mut self) -> &mut Leases {
        &mut self.leases
    }

    /// What people ordered, and what became of it.
    pub fn commands(&self) -> &Commands {
        &self.commands
    }

    /// What people ordered, to add to it.
    pub fn commands_mut(&mut self) -> &mut Commands {
        &mut self.commands
    }

    /// What is wrong, and who knows of it.
    pub fn alarms(&self) -> &Alarms {
        &self.alarms
    }

    /// What is wrong, to say something to it.
    pub fn alarms_mut(&mut self) -> &mut Alarms {
        &mut self.alarms
    }

    /// Looks for what is wrong in the fleet and in what the server says of itself. To be called once a second.
    pub fn watch(&mut self, now: Now, outside: &Outside) {
        self.alarms.watch(now, &self.fleet, outside);
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// This server's own address.
    pub fn address(&self) -> Address {
        self.settings.address
    }

    /// A peer connects.
    pub fn join(&mut self, now: Now, peer: Peer) -> PeerId {
        let id = PeerId(self.next_peer);
        self.next_peer += 1;
        let slot = Slot {
            peer,
            since: now.utc,
            homes: BTreeMap::new(),
            speaker: None,
            out: Vec::new(),
            received: 0,
            refused: 0,
            delivered: 0,
        };
        self.peers.insert(id, slot);
        if let Some(announce) = self.node.announce_to_newcomer(now) {
            self.deliver(id, announce);
        }
        id
    }

    /// A peer is gone; what waited for it is dropped.
    pub fn leave(&mut self, peer: PeerId) {
        self.peers.remove(&peer);
    }

    /// All peers.
    pub fn peers(&self) -> Vec<PeerState> {
        let state = |(id, slot): (&PeerId, &Slot)| {
            let mut homes: Vec<(MonoTime, Address)> = slot.homes.iter().map(|(a, at)| (*at, *a)).collect();
            homes.sort_unstable();
            PeerState {
                id: *id,
                peer: slot.peer.clone(),
                since: slot.since,
                systems: homes.into_iter().map(|(_, address)| address).collect(),
                received: slot.received,
                refused: slot.refused,
                delivered: slot.delivered,
            }
        };
        self.peers.iter().map(state).collect()
    }

    /// Whether a system can be reached now.
    pub fn reaches(&self, now: MonoTime, address: Address) -> bool {
        self.doors_to(now, address).next().is_some()
    }

    /// The doors of the peers behind which a system was heard last.
    pub fn doors_to(&self, now: MonoTime, address: Address) -> impl Iterator<Item = Door> {
        let there = move |slot: &&Slot| slot.is_home_of(address, now);
        self.peers.values().filter(there).map(|slot| slot.peer.door)
    }

    /// Packets that came from a peer.
    pub fn packets(&mut self, now: Now, from: PeerId, batch: impl IntoIterator<Item = Incoming>) {
        let Some(slot) = self.peers.get(&from) else { return };
        let door = slot.peer.door;
        for incoming in batch {
            self.packet(now, from, door, incoming);
        }
    }

    fn packet(&mut self, now: Now, from: PeerId, door: Door, incoming: Incoming) {
        self.counters.received += 1;
        let Some(slot) = self.peers.get_mut(&from) else { return };
        slot.received += 1;
        let Incoming { packet, link, lane } = incoming;
        let Ok(view) = PacketView::new(&packet) else {
            slot.refused += 1;
            self.counters.damaged += 1;
            return;
        };
        // What follows the packet in its message is none of anybody's business.
        let packet = packet.slice(..view.bytes().len());
        let source = view.src();
        if !slot.peer.sources.allow(source) {
            if link.is_some() {
                // What the vessel recorded of what others told it, a console in its own radio's reach above all.
                // That is kept, but the vessel speaks for nobody else.
                self.records.push(Record { packet, received: now.utc, door, link });
            } else {
                slot.refused += 1;
                self.counters.refused += 1;
            }
            return;
        }
        if source == self.settings.address {
            // Our own words come back from vehicles that echo them.
            self.counters.duplicates += 1;
            return;
        }
        slot.heard(source, now.mono);
        let sample = duplicates::sample(&view);
        if lane != Lane::Backlog {
            let delivery = sample.map(|sample| duplicates::delivery(sample, &view));
            let again = delivery.is_some_and(|digest| self.deliveries.seen(digest));
            if !again {
                self.route(now.mono, from, door, &view, &packet);
                self.fleet.update(now, &view, door);
                self.commands.heard(now, &view);
            }
        }
        // The link numbers its records: they are told apart by number, and a record that was seen live is still
        // a record.
        let again = link.is_none() && sample.is_some_and(|sample| self.samples.seen(sample));
        if again {
            self.counters.duplicates += 1;
        } else if lane != Lane::Live {
            self.records.push(Record { packet, received: now.utc, door, link });
        }
    }

    /// A packet of this server's own: from people, programs, or the server as a console. It is recorded before it
    /// is delivered. Whether somebody was there to hear it.
    pub fn send(&mut self, now: Now, packet: &Bytes) -> bool {
        let Ok(view) = PacketView::new(packet) else { return false };
        let delivered = self.counters.delivered;
        self.record_own(now, packet);
        self.route(now.mono, PeerId(0), Door::Shore, &view, packet);
        self.counters.delivered > delivered
    }

    /// A packet of this server's own that goes to its vessel by another way than these routes. It is recorded.
    pub fn record_own(&mut self, now: Now, packet: &Bytes) {
        let Ok(view) = PacketView::new(packet) else { return };
        self.records.push(Record {
            packet: packet.clone(),
            received: now.utc,
            door: Door::Shore,
            link: None,
        });
        self.fleet.update(now, &view, Door::Shore);
    }

    fn route(&mut self, now: MonoTime, from: PeerId, door: Door, view: &PacketView<'_>, packet: &Bytes) {
        let (source, to) = (view.src(), view.dst());
        let for_us = to == self.settings.address;
        let for_all = to.is_everyone();
        let from_console = source.is_ccu();
        let mut homes = 0;
        for (id, slot) in &mut self.peers {
            if *id == from {
                continue;
            }
            let wanted = if door == Door::Proxy && slot.peer.door == Door::Proxy {
                true
            } else if for_us || slot.is_home_of(source, now) {
                false
            } else if for_all {
                slot.peer.role == Role::Console || from_console
            } else {
                slot.is_home_of(to, now)
            };
            if wanted {
                homes += 1;
                slot.delivered += 1;
                slot.out.push(packet.clone());
            }
        }
        self.counters.delivered += homes;
        if homes == 0 && !for_all && !for_us {
            self.counters.unroutable += 1;
        }
    }

    fn deliver(&mut self, to: PeerId, packet: Bytes) {
        if let Some(slot) = self.peers.get_mut(&to) {
            slot.delivered += 1;
            slot.out.push(packet);
            self.counters.delivered += 1;
        }
    }

    /// Time passes: the server's own announcements, heartbeats and questions. To be called once a second.
    pub fn tick(&mut self, now: Now) {
        self.leases.tick(now);
        self.commands.tick(now);
        if !self.settings.active {
            return;
        }
        for packet in self.node.tick(now, &self.fleet) {
            let Ok(view) = PacketView::unchecked(&packet) else { continue };
            self.route(now.mono, PeerId(0), Door::Shore, &view, &packet);
        }
    }

    /// The server's own announcement, for the discovery ports.
    pub fn announcement(&mut self, now: Now) -> Option<Bytes> {
        self.settings.active.then(|| self.node.announcement(now))
    }

    /// Sets the services that the server announces: where the doors listen.
    pub fn set_services(&mut self, services: &str) {
        self.node.set_services(services);
    }

    /// Hands over what waits for each peer.
    pub fn drain_deliveries(&mut self, mut take: impl FnMut(PeerId, Vec<Bytes>)) {
        for (id, slot) in &mut self.peers {
            if !slot.out.is_empty() {
                take(*id, std::mem::take(&mut slot.out));
            }
        }
    }

    /// Hands over what must be recorded.
    pub fn drain_records(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.records)
    }
}

/// Whether a message belongs to an exchange between two systems: a request or an answer that nobody repeats.
pub(crate) fn is_exchange(id: u16) -> bool {
    matches!(
        id,
        m::EntityInfo::ID
            | m::EntityList::ID
            | m::LoggingControl::ID
            | m::PlanSpecification::ID
            | m::PopEntityParameters::ID
            | m::PowerChannelControl::ID
            | m::PushEntityParameters::ID
            | m::QueryEntityParameters::ID
            | m::RemoteActionsRequest::ID
            | m::SaveEntityParameters::ID
            | m::SetEntityParameters::ID
    ) || id == m::PlanDB::ID
}
