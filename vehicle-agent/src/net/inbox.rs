//! The queues of the loop: one for each peer, served in turn, and a priority path for Aborts.
//!
//! - Each peer's queue holds at most [`PEER_BYTES`]; beyond that only its own packets are dropped and counted. A stream
//!   that carries plans or commands ([`is_record`]) waits for room first, so that many plans can be sent at once; only
//!   packets that wait for longer than [`ROOM_WAIT`] are dropped. All datagrams together take at most [`UDP_BYTES`]: at
//!   that bound the peer with the longest queue loses its newest. Connections are few ([`clients`](super::clients)), so
//!   that their queues are bounded too.
//! - An Abort that is addressed to this vessel or broadcast on purpose (0xFFF0) goes before everything else and is never
//!   dropped; while one of a peer is queued, further ones of that peer are merged with it. Earlier packets must not take
//!   effect after it: queued commands ([`COMMANDS`]) are withdrawn, and counted.
//! - Results from the disk are bounded by the work given to it.

use crate::disk::{Done, is_record};
use imc::{Address, PacketView};
use onboard::{Lease, Mandate, Peer, RouteAnswer};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most queued bytes of one peer, with the overhead of entries.
pub(super) const PEER_BYTES: usize = 512 << 10;
/// Most queued bytes of all datagrams together.
const UDP_BYTES: usize = 4 << 20;
/// Memory of an entry besides its bytes.
const ENTRY_BYTES: usize = 64;

/// Most numbers of commands that are kept until they are reported, a second at most.
const NUMBERS: usize = 64;

/// How long a stream waits for the loop to make room.
const ROOM_WAIT: Duration = Duration::from_secs(5);

const ABORT: u16 = 550;
/// RemoteActions, TeleoperationDone, Reference, VehicleCommand, PlanControl: messages that could start a motion.
const COMMANDS: [u16; 5] = [305, 460, 479, 501, 559];

/// An event for the loop.
#[derive(Debug, PartialEq)]
pub(crate) enum Event {
    /// A packet.
    Packet(Peer, Vec<u8>),
    /// A packet of the shore, and under what it comes.
    Order(Peer, Mandate, Vec<u8>),
    /// The shore reports the controller.
    Lease(Lease),
    /// A client has connected.
    Connected(u32),
    /// A client has disconnected.
    Disconnected(u32),
    /// The outcome of work for the disk.
    Disk(Done),
    /// The answer to a route request.
    Route(RouteAnswer),
}

/// Packets that were not passed on since the last call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Losses {
    /// Packets dropped, by peer.
    pub(crate) dropped: Vec<(Peer, u64)>,
    /// Commands that an Abort overtook.
    pub(crate) withdrawn: u64,
    /// Numbers ashore of those among them that have one, and of Aborts that found one of the shore's queued.
    pub(crate) commands: Overtaken,
}

/// Commands of the shore that are not carried out by themselves, by their numbers ashore.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Overtaken {
    /// An Abort came after them.
    pub(crate) withdrawn: Vec<u64>,
    /// An Abort that is carried out by the one that was queued before it.
    pub(crate) merged: Vec<u64>,
}

/// The queues.
#[derive(Debug)]
pub(crate) struct Inbox {
    own: Address,
    waiting: Mutex<Waiting>,
    arrived: Condvar,
    /// Signals free room to a stream that waits for it.
    room: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    /// The loop was woken for something that is not queued here.
    woken: bool,
    /// Streams that wait for room.
    readers: usize,
    aborts: BTreeMap<Peer, (Mandate, Vec<u8>)>,
    after_abort: bool,
    done: VecDeque<Done>,
    /// The newest answer; older ones are not needed.
    route: Option<RouteAnswer>,
    peers: BTreeMap<Peer, Queue>,
    /// Peers with queued packets, the next first.
    turns: VecDeque<Peer>,
    udp_bytes: usize,
    dropped: BTreeMap<Peer, u64>,
    dropped_of_all: u64,
    withdrawn: u64,
    overtaken: Overtaken,
}

#[derive(Debug, Default)]
struct Queue {
    items: VecDeque<Item>,
    bytes: usize,
    commands: usize,
}

#[derive(Debug)]
enum Item {
    Here,
    Packet(Vec<u8>),
    Order(Mandate, Vec<u8>),
    Lease(Lease),
    Gone,
}

impl Item {
    fn bytes(&self) -> usize {
        ENTRY_BYTES
            + match self {
                Self::Packet(bytes) | Self::Order(_, bytes) => bytes.len(),
                Self::Lease(lease) => lease.holder.len(),
                Self::Here | Self::Gone => 0,
            }
    }

    fn is_command(&self) -> bool {
        match self {
            Self::Packet(bytes) | Self::Order(_, bytes) => id(bytes).is_some_and(|id| COMMANDS.contains(&id)),
            Self::Here | Self::Lease(_) | Self::Gone => false,
        }
    }
}

fn id(bytes: &[u8]) -> Option<u16> {
    PacketView::unchecked(bytes).ok().map(|view| view.id())
}

impl Inbox {
    /// Empty queues of the system with this address.
    pub(crate) fn new(own: Address) -> Self {
        Self { own, waiting: Mutex::default(), arrived: Condvar::new(), room: Condvar::new() }
    }

    /// A packet from a peer.
    pub(super) fn packet(&self, peer: Peer, bytes: &[u8]) {
        let mut waiting = self.lock();
        if self.is_abort(bytes) {
            waiting.abort(peer, Mandate::default(), bytes);
        } else {
            let patient = matches!(peer, Peer::Tcp(_)) && id(bytes).is_some_and(is_record);
            if patient && !waiting.has_room(peer, bytes.len()) {
                waiting.readers += 1;
                let full = |waiting: &mut Waiting| !waiting.has_room(peer, bytes.len());
                let waited = self.room.wait_timeout_while(waiting, ROOM_WAIT, full);
                waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
                waiting.readers -= 1;
            }
            waiting.packet(peer, bytes);
        }
        drop(waiting);
        self.arrived.notify_one();
    }

    /// A packet of the shore; returns whether there was room, for the answer to the shore. Never waits.
    pub(crate) fn order(&self, peer: Peer, mandate: Mandate, bytes: &[u8]) -> bool {
        let mut waiting = self.lock();
        let taken = if self.is_abort(bytes) {
            waiting.abort(peer, mandate, bytes);
            true
        } else {
            let has_room = waiting.has_room(peer, bytes.len());
            if has_room {
                waiting.put(peer, Item::Order(mandate, bytes.to_vec()));
            }
            has_room
        };
        drop(waiting);
        self.arrived.notify_one();
        taken
    }

    /// The shore reports the controller, in order with its packets; returns whether there was room.
    pub(crate) fn lease(&self, peer: Peer, lease: Lease) -> bool {
        let mut waiting = self.lock();
        let has_room = waiting.has_room(peer, lease.holder.len());
        if has_room {
            waiting.put(peer, Item::Lease(lease));
        }
        drop(waiting);
        self.arrived.notify_one();
        has_room
    }

    pub(super) fn connected(&self, client: u32) {
        self.lock().put(Peer::Tcp(client), Item::Here);
        self.arrived.notify_one();
    }

    pub(super) fn disconnected(&self, client: u32) {
        self.lock().put(Peer::Tcp(client), Item::Gone);
        self.arrived.notify_one();
    }

    /// The disk's thread has an outcome.
    pub(crate) fn done(&self, done: Done) {
        self.lock().done.push_back(done);
        self.arrived.notify_one();
    }

    /// The answer to a route request.
    pub(crate) fn route(&self, answer: RouteAnswer) {
        self.lock().route = Some(answer);
        self.arrived.notify_one();
    }

    /// Wakes the loop, for work that is not queued here.
    pub(crate) fn wake(&self) {
        self.lock().woken = true;
        self.arrived.notify_one();
    }

    /// The next event, waiting for at most `longest`, or until the loop is woken.
    pub(crate) fn take(&self, longest: Duration) -> Option<Event> {
        let until = Instant::now() + longest;
        let mut waiting = self.lock();
        loop {
            if let Some(event) = waiting.take() {
                if waiting.readers > 0 {
                    self.room.notify_all();
                }
                return Some(event);
            }
            let left = until.saturating_duration_since(Instant::now());
            if std::mem::take(&mut waiting.woken) || left.is_zero() {
                return None;
            }
            waiting = self.arrived.wait_timeout(waiting, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Losses since the last call, if any.
    pub(crate) fn take_losses(&self) -> Option<Losses> {
        let mut waiting = self.lock();
        let dropped: Vec<_> = std::mem::take(&mut waiting.dropped).into_iter().collect();
        let withdrawn = std::mem::take(&mut waiting.withdrawn);
        let commands = std::mem::take(&mut waiting.overtaken);
        let any = withdrawn > 0 || !dropped.is_empty() || commands != Overtaken::default();
        any.then_some(Losses { dropped, withdrawn, commands })
    }

    /// Packets dropped since the start.
    pub(crate) fn dropped(&self) -> u64 {
        self.lock().dropped_of_all
    }

    /// Connections whose end the loop has not processed yet.
    pub(super) fn streams(&self) -> usize {
        self.lock().peers.keys().filter(|peer| matches!(peer, Peer::Tcp(_))).count()
    }

    fn is_abort(&self, bytes: &[u8]) -> bool {
        id(bytes) == Some(ABORT)
            && PacketView::new(bytes).is_ok_and(|view| {
                let to = view.dst();
                to == self.own || to == Address::BROADCAST
            })
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn abort(&mut self, peer: Peer, mandate: Mandate, bytes: &[u8]) {
        match self.aborts.entry(peer) {
            Entry::Vacant(free) => drop(free.insert((mandate, bytes.to_vec()))),
            Entry::Occupied(queued) if queued.get().0.command != mandate.command => {
                note(&mut self.overtaken.merged, mandate.command);
            }
            Entry::Occupied(_) => {}
        }
        for (peer, queue) in self.peers.iter_mut().filter(|(_, queue)| queue.commands > 0) {
            let before = queue.bytes;
            queue.items.retain(|item| {
                if let (true, Item::Order(mandate, _)) = (item.is_command(), item) {
                    note(&mut self.overtaken.withdrawn, mandate.command);
                }
                !item.is_command()
            });
            queue.bytes = queue.items.iter().map(Item::bytes).sum();
            self.withdrawn += queue.commands as u64;
            queue.commands = 0;
            if matches!(peer, Peer::Udp(_)) {
                self.udp_bytes -= before - queue.bytes;
            }
        }
        self.peers.retain(|_, queue| !queue.items.is_empty());
        self.turns.retain(|peer| self.peers.contains_key(peer));
    }

    fn packet(&mut self, peer: Peer, bytes: &[u8]) {
        let item = Item::Packet(bytes.to_vec());
        let size = item.bytes();
        if !self.has_room(peer, bytes.len()) {
            return self.count_dropped(peer);
        }
        if matches!(peer, Peer::Udp(_)) {
            while self.udp_bytes + size > UDP_BYTES {
                let Some(fullest) = self.fullest_udp() else { break };
                self.drop_newest(fullest);
            }
        }
        self.put(peer, item);
    }

    fn has_room(&self, peer: Peer, bytes: usize) -> bool {
        let waiting = self.peers.get(&peer).map_or(0, |queue| queue.bytes);
        waiting + bytes + ENTRY_BYTES <= PEER_BYTES
    }

    fn put(&mut self, peer: Peer, item: Item) {
        let size = item.bytes();
        if matches!(peer, Peer::Udp(_)) {
            self.udp_bytes += size;
        }
        let queue = self.peers.entry(peer).or_default();
        if queue.items.is_empty() {
            self.turns.push_back(peer);
        }
        queue.bytes += size;
        queue.commands += usize::from(item.is_command());
        queue.items.push_back(item);
    }

    fn fullest_udp(&self) -> Option<Peer> {
        let udp = self.peers.iter().filter(|(peer, _)| matches!(peer, Peer::Udp(_)));
        udp.max_by_key(|(_, queue)| queue.bytes).map(|(peer, _)| *peer)
    }

    fn drop_newest(&mut self, peer: Peer) {
        let Some(queue) = self.peers.get_mut(&peer) else { return };
        if let Some(item) = queue.items.pop_back() {
            queue.bytes -= item.bytes();
            queue.commands -= usize::from(item.is_command());
            self.udp_bytes -= item.bytes();
        }
        if queue.items.is_empty() {
            self.peers.remove(&peer);
            self.turns.retain(|turn| *turn != peer);
        }
        self.count_dropped(peer);
    }

    fn count_dropped(&mut self, peer: Peer) {
        self.dropped_of_all += 1;
        // Forged senders must not fill the memory either.
        if self.dropped.len() < 64 || self.dropped.contains_key(&peer) {
            *self.dropped.entry(peer).or_default() += 1;
        }
    }

    fn take(&mut self) -> Option<Event> {
        // An endless series of Aborts must leave turns for others too.
        if !std::mem::take(&mut self.after_abort)
            && let Some(abort) = self.take_abort()
        {
            self.after_abort = true;
            return Some(abort);
        }
        if let Some(done) = self.done.pop_front() {
            return Some(Event::Disk(done));
        }
        if let Some(answer) = self.route.take() {
            return Some(Event::Route(answer));
        }
        let next = self.next_in_turn();
        next.or_else(|| self.take_abort())
    }

    fn take_abort(&mut self) -> Option<Event> {
        let (peer, (mandate, bytes)) = self.aborts.pop_first()?;
        let by_shore = mandate != Mandate::default();
        Some(if by_shore { Event::Order(peer, mandate, bytes) } else { Event::Packet(peer, bytes) })
    }

    fn next_in_turn(&mut self) -> Option<Event> {
        while let Some(peer) = self.turns.pop_front() {
            let Some(queue) = self.peers.get_mut(&peer) else { continue };
            let item = queue.items.pop_front();
            if let Some(item) = &item {
                let size = item.bytes();
                queue.bytes -= size;
                queue.commands -= usize::from(item.is_command());
                if matches!(peer, Peer::Udp(_)) {
                    self.udp_bytes -= size;
                }
            }
            if queue.items.is_empty() {
                self.peers.remove(&peer);
            } else {
                self.turns.push_back(peer);
            }
            match (item, peer) {
                (Some(Item::Packet(bytes)), _) => return Some(Event::Packet(peer, bytes)),
                (Some(Item::Order(mandate, bytes)), _) => return Some(Event::Order(peer, mandate, bytes)),
                (Some(Item::Lease(lease)), _) => return Some(Event::Lease(lease)),
                (Some(Item::Here), Peer::Tcp(client)) => return Some(Event::Connected(client)),
                (Some(Item::Gone), Peer::Tcp(client)) => return Some(Event::Disconnected(client)),
                (Some(Item::Here | Item::Gone), Peer::Udp(_)) | (None, _) => {}
            }
        }
        None
    }
}

/// Notes the number of a command that has one, of a few.
fn note(numbers: &mut Vec<u64>, command: u64) {
    if command > 0 && numbers.len() < NUMBERS {
        numbers.push(command);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{Abort, Heartbeat, Message, PlanControl, PlanDB, PlanSpecification};
    use imc::{Header, Packet};
    use std::net::{Ipv4Addr, SocketAddrV4};

    const OWN: Address = Address(0x2810);

    fn packet(dst: Address, message: impl Into<Message>) -> Vec<u8> {
        let header = Header { src: Address(0x4001), dst, ..Header::default() };
        Packet::new(header, message).encode().unwrap()
    }

    fn udp(host: u32, port: u16) -> Peer {
        Peer::Udp(SocketAddrV4::new(Ipv4Addr::from_bits(0x0A00_0000 + host), port))
    }

    fn take(inbox: &Inbox) -> Option<Event> {
        inbox.take(Duration::ZERO)
    }

    fn drain(inbox: &Inbox) -> Vec<Event> {
        std::iter::from_fn(|| take(inbox)).collect()
    }

    #[test]
    fn a_flood_takes_its_own_room_and_its_own_turns_only() {
        let inbox = Inbox::new(OWN);
        let (beat, quiet) = (packet(OWN, Heartbeat), udp(1, 6001));
        inbox.connected(7);
        for _ in 0..100_000 {
            inbox.packet(Peer::Tcp(7), &beat);
        }
        inbox.packet(quiet, &beat);
        assert_eq!(take(&inbox), Some(Event::Connected(7)));
        // The quiet peer is next but one, however much is queued of the other.
        let next: Vec<_> = (0..2).map(|_| take(&inbox).unwrap()).collect();
        assert!(next.contains(&Event::Packet(quiet, beat.clone())), "{next:?}");
        let losses = inbox.take_losses().unwrap();
        let [(Peer::Tcp(7), dropped)] = losses.dropped[..] else { panic!("{losses:?}") };
        assert_eq!(dropped, inbox.dropped());
        // All packets that were not dropped come, then the end.
        inbox.disconnected(7);
        let rest = drain(&inbox);
        assert_eq!(rest.last(), Some(&Event::Disconnected(7)));
        assert_eq!(rest.len() as u64 + dropped, 100_000);
        assert!(inbox.take_losses().is_none() && inbox.streams() == 0);
    }

    #[test]
    fn a_stream_of_many_plans_waits_and_loses_none() {
        let inbox = std::sync::Arc::new(Inbox::new(OWN));
        let plan = PlanSpecification { description: "x".repeat(2000).as_str().into(), ..Default::default() };
        let set = packet(OWN, PlanDB { arg: plan.into(), ..PlanDB::default() });
        let (filling, sent) = (std::sync::Arc::clone(&inbox), set.clone());
        let stream = std::thread::spawn(move || {
            for _ in 0..2000 {
                filling.packet(Peer::Tcp(1), &sent);
            }
        });
        for _ in 0..2000 {
            assert_eq!(inbox.take(ROOM_WAIT), Some(Event::Packet(Peer::Tcp(1), set.clone())));
        }
        stream.join().unwrap();
        assert_eq!(inbox.dropped(), 0);
    }

    #[test]
    fn invented_senders_fill_no_memory_and_hold_nobody_up() {
        let inbox = Inbox::new(OWN);
        let large = vec![0; 60_000];
        let quiet = udp(1, 6001);
        inbox.packet(quiet, &packet(OWN, Heartbeat));
        for host in 2..10_000 {
            inbox.packet(udp(host, 1), &large);
        }
        assert!(inbox.lock().udp_bytes <= UDP_BYTES);
        assert!(inbox.lock().dropped.len() <= 64);
        assert!(matches!(take(&inbox), Some(Event::Packet(peer, _)) if peer == quiet));
        drain(&inbox);
        assert_eq!(inbox.lock().udp_bytes, 0);
    }

    #[test]
    fn an_abort_overtakes_and_withdraws_what_would_set_the_vessel_going() {
        let inbox = Inbox::new(OWN);
        let (start, beat) = (packet(OWN, PlanControl::default()), packet(OWN, Heartbeat));
        for _ in 0..50_000 {
            inbox.packet(Peer::Tcp(1), &beat);
        }
        inbox.packet(udp(2, 1), &start);
        inbox.packet(udp(3, 1), &beat);
        let abort = packet(OWN, Abort);
        inbox.packet(Peer::Tcp(1), &abort);
        inbox.packet(Peer::Tcp(1), &abort);
        inbox.packet(udp(3, 1), &packet(Address::BROADCAST, Abort));
        // An Abort for another system, and a damaged one, do not count as Aborts here.
        inbox.packet(udp(4, 1), &packet(Address(0x2811), Abort));
        let mut damaged = abort.clone();
        damaged[10] ^= 1;
        inbox.packet(udp(5, 1), &damaged);
        // Commands after an Abort are intended.
        inbox.packet(udp(2, 1), &start);

        let is_abort = |event: &Event| matches!(event, Event::Packet(_, bytes) if id(bytes) == Some(ABORT));
        assert!(is_abort(&take(&inbox).unwrap()));
        let rest = drain(&inbox);
        // One of each peer; the brain refuses the damaged one.
        assert_eq!(rest.iter().filter(|event| is_abort(event)).count(), 3);
        let starts = rest.iter().filter(|event| matches!(event, Event::Packet(_, bytes) if *bytes == start));
        assert_eq!(starts.count(), 1);
        assert_eq!(inbox.take_losses().unwrap().withdrawn, 1);
        assert!(inbox.lock().peers.is_empty() && inbox.lock().turns.is_empty());
        assert_eq!(inbox.lock().udp_bytes, 0);
    }

    #[test]
    fn commands_of_the_shore_that_a_stop_overtakes_are_named() {
        let inbox = Inbox::new(OWN);
        let (start, abort) = (packet(OWN, PlanControl::default()), packet(OWN, Abort));
        let shore = Peer::Tcp(u32::MAX);
        let mandate = |command| Mandate { lease: 0, command };
        assert!(inbox.order(shore, mandate(41), &start));
        for command in [42, 42, 43] {
            assert!(inbox.order(shore, mandate(command), &abort));
        }
        assert_eq!(drain(&inbox), [Event::Order(shore, mandate(42), abort)]);
        let overtaken = Overtaken { withdrawn: vec![41], merged: vec![43] };
        assert_eq!(inbox.take_losses().unwrap().commands, overtaken);
    }

    #[test]
    fn a_row_of_aborts_without_end_lets_others_through() {
        let inbox = Inbox::new(OWN);
        let (abort, beat) = (packet(OWN, Abort), packet(OWN, Heartbeat));
        inbox.packet(udp(1, 1), &beat);
        inbox.done(Done::NotKept("something".to_owned()));
        let mut seen = Vec::new();
        for _ in 0..4 {
            inbox.packet(udp(2, 1), &abort);
            seen.push(take(&inbox).unwrap());
        }
        assert!(seen.contains(&Event::Packet(udp(1, 1), beat)), "{seen:?}");
    }
}
