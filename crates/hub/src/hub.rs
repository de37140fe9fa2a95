//! The machine that owns routing, the fleet's state and the records for the archive.
//!
//! Packets come in by [`Hub::packets`], which decides what is trusted, what is new and what is a copy;
//! `route` chooses the receivers. Every new packet is recorded, whether it has a receiver or not.

use crate::delivery::Delivery;
use crate::downlink::{OrderLog, PendingStops, Waiting};
use crate::duplicates::{self, Repeats, Window};
use crate::exchange::is_command;
use crate::fleet::Fleet;
use crate::linked::{Contradiction, Linked};
use crate::node::{Node, Settings};
use crate::peer::{Peer, PeerId, PeerState, Sources};
use crate::slot::Slot;
use bytes::Bytes;
use imc::messages::{Abort, Payload as _};
use imc::{Address, PacketView};
use link::{LinkSeq, Transport};
use std::collections::{BTreeMap, BTreeSet};
use units::{MonoTime, Now, UtcTime};

/// How a packet came by the vessel link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Not by the link, or as a record of the present: it is shown, relayed and recorded.
    Present,
    /// The latest value ahead of the records: it is shown and relayed; its record comes later.
    Live,
    /// A record of the past: it is recorded, and neither shown nor relayed. A detection is an event all the same: nothing
    /// newer replaces it.
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
    /// By which transport.
    pub transport: Transport,
    /// Its place on the vessel link, to acknowledge once it is durable.
    pub link: Option<LinkSeq>,
}

/// Counters since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Packets that came.
    pub received: u64,
    /// Bytes that were not a packet.
    pub damaged: u64,
    /// Packets with a source address that their peer may not use.
    pub refused: u64,
    /// Copies of packets that came before.
    pub duplicates: u64,
    /// Deliveries to peers.
    pub delivered: u64,
    /// Packets for one system that lives behind no peer.
    pub unroutable: u64,
}

/// Routing, the fleet's state and what goes to the archive. `O` follows orders to their end.
#[derive(Debug)]
pub struct Hub<O> {
    settings: Settings,
    node: Node,
    fleet: Fleet,
    pub(crate) peers: BTreeMap<PeerId, Slot>,
    next_peer: u32,
    linked: Linked,
    samples: Window,
    deliveries: Window,
    repeats: Repeats,
    records: Vec<Record>,
    pub(crate) counters: Counters,
    pub(crate) orders: O,
    /// Orders for which there is no way yet.
    pub(crate) waiting: Waiting,
    /// Stops that are kept until their vessels show that they have them.
    pub(crate) standing: PendingStops,
}

impl<O: OrderLog> Hub<O> {
    /// A hub without peers.
    pub fn new(settings: Settings, orders: O) -> Self {
        Self {
            node: Node::new(&settings),
            orders,
            waiting: Waiting::default(),
            standing: PendingStops::default(),
            settings,
            fleet: Fleet::default(),
            peers: BTreeMap::new(),
            next_peer: 1,
            linked: Linked::default(),
            samples: Window::default(),
            deliveries: Window::default(),
            repeats: Repeats::default(),
            records: Vec::new(),
            counters: Counters::default(),
        }
    }

    /// The live state of the fleet.
    pub fn fleet(&self) -> &Fleet {
        &self.fleet
    }

    /// The log of orders.
    pub fn orders(&self) -> &O {
        &self.orders
    }

    /// The log of orders, to add to it.
    pub fn orders_mut(&mut self) -> &mut O {
        &mut self.orders
    }

    /// Who else sends with the address of vessels that have a link, in the last minute.
    pub fn contradictions(&mut self, now: MonoTime) -> Vec<Contradiction> {
        self.linked.contradictions(now)
    }

    /// The transports besides the link by which vessels that have a link are trusted too.
    pub fn trust_transports(&mut self, transports: impl IntoIterator<Item = Transport>) {
        self.linked.trust(transports);
    }

    /// The vessels that have a link with a token, all of them. They are trusted there and at trusted transports only, and
    /// get their commands there. One whose link joins is one of them from then on.
    pub fn set_linked(&mut self, vessels: BTreeSet<Address>) {
        for slot in self.peers.values_mut().filter(|slot| !self.linked.is_trusted(slot.peer.transport)) {
            for vessel in &vessels {
                slot.disown(*vessel);
            }
        }
        self.linked.set(vessels);
    }

    /// Counters since the start.
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
        if let (Transport::Link, Sources::Only(vessels)) = (peer.transport, &peer.sources) {
            // Of several connections of one link the last counts, also if the previous one ended without a close.
            for slot in self.peers.values_mut().filter(|slot| vessels.iter().any(|own| slot.is_link_of(*own)))
            {
                slot.stands = false;
            }
            let all = self.linked.vessels().chain(vessels.iter().copied()).collect();
            self.set_linked(all);
        }
        self.peers.insert(id, Slot::new(peer, now.utc));
        if let Some(announce) = self.node.announce_to_newcomer(now) {
            self.deliver(id, announce);
        }
        id
    }

    /// A peer is gone; what waited for it is dropped.
    pub fn leave(&mut self, peer: PeerId) {
        self.peers.remove(&peer);
        self.standing.lost(peer);
    }

    /// Whether a peer reads its packets; one that does not is not used as a way to a vessel.
    pub fn takes(&mut self, peer: PeerId, takes: bool) {
        if let Some(slot) = self.peers.get_mut(&peer) {
            slot.takes = takes;
        }
    }

    /// All peers.
    pub fn peers(&self) -> Vec<PeerState> {
        self.peers.iter().map(|(id, slot)| slot.state(*id)).collect()
    }

    /// Whether a system can be reached now.
    pub fn reaches(&self, now: MonoTime, address: Address) -> bool {
        self.transports_to(now, address).next().is_some()
    }

    /// The transports of the peers behind which a system was heard last.
    pub fn transports_to(&self, now: MonoTime, address: Address) -> impl Iterator<Item = Transport> {
        let there = move |slot: &&Slot| slot.is_home_of(address, now);
        self.peers.values().filter(there).map(|slot| slot.peer.transport)
    }

    /// Packets that came from a peer.
    pub fn packets(&mut self, now: Now, from: PeerId, batch: impl IntoIterator<Item = Incoming>) {
        let Some(slot) = self.peers.get(&from) else { return };
        let transport = slot.peer.transport;
        for incoming in batch {
            self.packet(now, from, transport, incoming);
        }
    }

    fn packet(&mut self, now: Now, from: PeerId, transport: Transport, incoming: Incoming) {
        self.counters.received += 1;
        let Some(slot) = self.peers.get_mut(&from) else { return };
        slot.received += 1;
        let Incoming { packet, link, lane } = incoming;
        let Ok(view) = PacketView::new(&packet) else {
            slot.refused += 1;
            self.counters.damaged += 1;
            return;
        };
        // What follows the packet in its message is not passed on.
        let packet = packet.slice(..view.bytes().len());
        if link.is_some() && !slot.peer.sources.allow(view.src()) {
            // What the vessel recorded from other systems, above all a console in reach of its own radio.
            // It is recorded but not routed: a vessel sends for itself only.
            self.records.push(Record { packet, received: now.utc, transport, link });
            return;
        }
        let sample = duplicates::sample(&view);
        let delivery = sample.map(|sample| duplicates::delivery(sample, &view));
        if !self.is_believed(now.mono, from, &view, delivery) {
            return;
        }
        let present = lane != Lane::Backlog;
        let copy = present && delivery.is_some_and(|digest| self.deliveries.seen(digest));
        if let Some(slot) = self.peers.get_mut(&from) {
            slot.heard(view.src(), now.mono, copy);
        }
        // The link numbers its records: their number identifies them, and a record that was seen live is still
        // a record.
        let mut recorded = link.is_none() && sample.is_some_and(|sample| self.samples.seen(sample));
        let mut again = copy;
        if present && is_command(&view) && !self.is_echo(now.mono, from, view.dst()) {
            again = delivery.is_some_and(|digest| !self.is_said(now.mono, from, &view, digest));
            recorded = link.is_none() && again;
        }
        if present && !again {
            if !self.is_echo(now.mono, from, view.dst()) {
                self.another_starts(now, &view);
            }
            self.route(now.mono, from, transport, &view, &packet);
            self.fleet.update(now, &view, transport);
            self.orders.heard(now, &view);
            self.way_back(now, &view);
        }
        if !present
            && detections::is_report(&view)
            && !delivery.is_some_and(|digest| self.deliveries.contains(digest))
        {
            self.fleet.late(now, &view);
        }
        if recorded {
            self.counters.duplicates += 1;
        } else if lane != Lane::Live {
            self.records.push(Record { packet, received: now.utc, transport, link });
        }
    }

    /// Whether a peer may use a packet's source address; refused packets are counted.
    fn is_believed(
        &mut self,
        now: MonoTime,
        from: PeerId,
        view: &PacketView<'_>,
        delivery: Option<u64>,
    ) -> bool {
        let Some(slot) = self.peers.get_mut(&from) else { return false };
        let (source, transport) = (view.src(), slot.peer.transport);
        let denied = self.linked.denies(source, transport);
        let comes_back = denied && delivery.is_some_and(|digest| self.deliveries.contains(digest));
        if source == self.settings.address || comes_back {
            // Our own packets come back from vessels that echo them, and a vessel's packets from peers to which they were
            // passed on.
            self.counters.duplicates += 1;
            return false;
        }
        if denied {
            self.linked.claimed(now, source, transport, &slot.peer.name);
        }
        if denied || !slot.peer.sources.allow(source) {
            slot.refused += 1;
            self.counters.refused += 1;
            return false;
        }
        true
    }

    /// Whether a command is sent, for the first time or again, and is not a copy.
    fn is_said(&mut self, now: MonoTime, from: PeerId, view: &PacketView<'_>, digest: u64) -> bool {
        let by = self.repeats.speaker(digest);
        let by_another = by.is_some_and(|by| by != from && self.peers.contains_key(&by));
        self.repeats.passes(now, digest, from, by_another, view.id() == Abort::ID)
    }

    /// A packet of this server's own: from people, programs, or the server as a console. It is recorded before it
    /// is delivered. Returns whether it had a receiver.
    pub fn send(&mut self, now: Now, packet: &Bytes) -> bool {
        let Ok(view) = PacketView::new(packet) else { return false };
        let delivered = self.counters.delivered;
        self.another_starts(now, &view);
        self.record_own(now, packet);
        self.route(now.mono, PeerId(0), Transport::Shore, &view, packet);
        self.counters.delivered > delivered
    }

    /// A packet of this server's own that goes to its vessel by another way than these routes. It is recorded.
    pub fn record_own(&mut self, now: Now, packet: &Bytes) {
        let Ok(view) = PacketView::new(packet) else { return };
        self.records.push(Record {
            packet: packet.clone(),
            received: now.utc,
            transport: Transport::Shore,
            link: None,
        });
        self.fleet.update(now, &view, Transport::Shore);
    }

    fn deliver(&mut self, to: PeerId, packet: Bytes) {
        if let Some(slot) = self.peers.get_mut(&to) {
            slot.delivered += 1;
            slot.out.push(packet.into());
            self.counters.delivered += 1;
        }
    }

    /// Sends the server's own announcements, heartbeats and queries. To be called once a second.
    pub fn tick(&mut self, now: Now) {
        self.expire_waiting(now);
        if !self.settings.active {
            return;
        }
        for packet in self.node.tick(now, &self.fleet) {
            let Ok(view) = PacketView::unchecked(&packet) else { continue };
            self.route(now.mono, PeerId(0), Transport::Shore, &view, &packet);
        }
    }

    /// The server's own announcement, for the discovery ports.
    pub fn announcement(&mut self, now: Now) -> Option<Bytes> {
        self.settings.active.then(|| self.node.announcement(now))
    }

    /// Sets the services that the server announces: where the transports listen.
    pub fn set_services(&mut self, services: &str) {
        self.node.set_services(services);
    }

    /// Passes on what waits for each peer.
    pub fn drain_deliveries(&mut self, mut take: impl FnMut(PeerId, Vec<Delivery>)) {
        for (id, slot) in &mut self.peers {
            if !slot.out.is_empty() {
                take(*id, std::mem::take(&mut slot.out));
            }
        }
    }

    /// Passes on what must be recorded.
    pub fn drain_records(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.records)
    }
}
