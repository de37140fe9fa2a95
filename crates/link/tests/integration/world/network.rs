//! Connections like TCP's: messages come whole and in order or not at all; a cut holds them back, and for longer
//! than it lasts; an end that is gone is noticed only by sending to it.

use super::{Event, World, connection, micros};
use bytes::Bytes;
use link::{Failure, ShoreInput, VesselInput};
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

/// Towards the shore, or towards the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Direction {
    Up,
    Down,
}

impl Direction {
    fn other(self) -> Self {
        match self {
            Self::Up => Self::Down,
            Self::Down => Self::Up,
        }
    }
}

/// One connection. `ends` are those that still have it: at the end of `Up` the shore.
#[derive(Debug, Default)]
struct Wire {
    /// The way that it goes by.
    way: usize,
    up: VecDeque<(u64, Bytes)>,
    down: VecDeque<(u64, Bytes)>,
    shore_has_it: bool,
    vessel_has_it: bool,
    /// Direction and time of the last delivery, so that order holds.
    last: [u64; 2],
}

impl Wire {
    fn queue(&mut self, direction: Direction) -> &mut VecDeque<(u64, Bytes)> {
        match direction {
            Direction::Up => &mut self.up,
            Direction::Down => &mut self.down,
        }
    }

    fn end(&mut self, direction: Direction) -> &mut bool {
        match direction {
            Direction::Up => &mut self.shore_has_it,
            Direction::Down => &mut self.vessel_has_it,
        }
    }
}

/// One way between vessel and shore.
#[derive(Debug, Clone)]
pub(crate) struct Path {
    cut_until: [u64; 2],
    /// Until then it connects, and carries nothing.
    pub(crate) mute_until: u64,
    /// Connections made by it.
    pub(crate) connections: u64,
    /// When the last byte sent leaves the sender.
    free_at: [u64; 2],
    pub(crate) delay_us: u64,
    pub(crate) bytes_per_s: u64,
    /// Bytes a second until a time.
    pub(crate) slow: (u64, u64),
    /// Bytes sent, both directions together.
    pub(crate) carried_bytes: u64,
}

impl Default for Path {
    fn default() -> Self {
        Self {
            cut_until: [0; 2],
            mute_until: 0,
            connections: 0,
            free_at: [0; 2],
            delay_us: 40_000,
            bytes_per_s: 250_000,
            slow: (0, 0),
            carried_bytes: 0,
        }
    }
}

#[derive(Debug)]
pub(crate) struct Network {
    wires: BTreeMap<u64, Wire>,
    /// The ways of connections that are being made.
    connecting: BTreeMap<u64, usize>,
    pub(crate) paths: Vec<Path>,
    pub(crate) duplicate_next: bool,
    pub(crate) swap_next: bool,
}

impl Default for Network {
    fn default() -> Self {
        Self {
            wires: BTreeMap::new(),
            connecting: BTreeMap::new(),
            paths: vec![Path::default()],
            duplicate_next: false,
            swap_next: false,
        }
    }
}

impl Network {
    pub(crate) fn ids(&self) -> Vec<u64> {
        self.wires.keys().copied().collect()
    }

    /// Cuts all ways.
    pub(crate) fn cut(&mut self, direction: Direction, until_us: u64) {
        (0..self.paths.len()).for_each(|way| self.cut_way(way, direction, until_us));
    }

    pub(crate) fn cut_way(&mut self, way: usize, direction: Direction, until_us: u64) {
        let way = way % self.paths.len();
        let cut = &mut self.paths[way].cut_until[direction as usize];
        *cut = (*cut).max(until_us);
    }

    fn is_cut(&self, way: usize, now_us: u64) -> bool {
        self.paths[way].cut_until.iter().any(|until| *until > now_us)
    }
}

impl World {
    /// The vessel connects.
    pub(crate) fn connect(&mut self, id: u64, way: usize, patience: Duration) {
        self.network.connecting.insert(id, way);
        let (delay, jitter) = (self.network.paths[way].delay_us, self.chance.below(20_000));
        if self.network.is_cut(way, self.now_us) {
            // The kernel sends its first packet again after a second.
            let again = self.now_us + 1_000_000;
            if micros(patience) <= 1_000_000 + 4 * delay || self.network.is_cut(way, again) {
                return self.at(micros(patience), Event::ConnectFailed(id));
            }
            return self.at(1_000_000 + 4 * delay + jitter, Event::Connected(id));
        }
        // A handshake of TCP and one of WebSocket.
        self.at(4 * delay + jitter, Event::Connected(id));
    }

    pub(crate) fn connected(&mut self, id: u64) {
        let way = self.network.connecting.get(&id).copied().unwrap_or(0);
        if self.network.is_cut(way, self.now_us) || self.shore.machine.is_none() {
            return self.connect_failed(id);
        }
        self.network.connecting.remove(&id);
        self.network.paths[way].connections += 1;
        let vessel_has_it = self.vessel.machine.is_some();
        let wire = Wire { way, shore_has_it: true, vessel_has_it, ..Wire::default() };
        self.network.wires.insert(id, wire);
        self.shore_handle(ShoreInput::Opened(connection(id)));
        self.vessel_handle(VesselInput::Opened(connection(id)));
    }

    pub(crate) fn connect_failed(&mut self, id: u64) {
        self.network.connecting.remove(&id);
        self.vessel_handle(VesselInput::Failed(connection(id), Failure::Unanswered));
    }

    pub(crate) fn transmit(&mut self, id: u64, direction: Direction, bytes: Bytes) {
        let (now, network) = (self.now_us, &mut self.network);
        let Some(wire) = network.wires.get_mut(&id) else { return };
        let path = &mut network.paths[wire.way];
        let rate = if path.slow.1 > now { path.slow.0 } else { path.bytes_per_s };
        let leaves = path.free_at[direction as usize].max(now) + bytes.len() as u64 * 1_000_000 / rate;
        path.free_at[direction as usize] = leaves;
        path.carried_bytes += bytes.len() as u64;
        let arrives = (leaves + path.delay_us + self.chance.below(5_000)).max(wire.last[direction as usize]);
        wire.last[direction as usize] = arrives;
        let queue = wire.queue(direction);
        queue.push_back((arrives, bytes.clone()));
        let mut events = 1;
        if std::mem::take(&mut network.duplicate_next) {
            queue.push_back((arrives, bytes));
            events = 2;
        }
        if queue.len() > 1 && std::mem::take(&mut network.swap_next) {
            let last = queue.len() - 1;
            queue.swap(last, last - 1);
        }
        for _ in 0..events {
            self.at(arrives - now, Event::Deliver(id, direction));
        }
    }

    pub(crate) fn deliver(&mut self, id: u64, direction: Direction) {
        let now = self.now_us;
        let Some(wire) = self.network.wires.get_mut(&id) else { return };
        let path = &self.network.paths[wire.way];
        let (cut_until, delay_us) = (path.cut_until[direction as usize].max(path.mute_until), path.delay_us);
        if cut_until > now {
            // TCP tries again later than at once, and each connection in its own time.
            let stall = self.chance.below((cut_until - now).min(5_000_000));
            let later = (cut_until + stall).max(wire.last[direction as usize]);
            wire.last[direction as usize] = later;
            return self.at(later - now, Event::Deliver(id, direction));
        }
        if wire.last[direction as usize] > now
            && wire.queue(direction).front().is_some_and(|(at, _)| *at > now)
        {
            let later = wire.last[direction as usize];
            return self.at(later - now, Event::Deliver(id, direction));
        }
        let has_it = *wire.end(direction);
        let Some((_, bytes)) = wire.queue(direction).pop_front() else { return };
        if !has_it {
            // The receiver is gone: the sender is informed.
            let back = delay_us;
            return self.at(back, Event::Gone(id, direction.other()));
        }
        match direction {
            Direction::Up => self.shore_handle(ShoreInput::Message(connection(id), bytes)),
            Direction::Down => self.vessel_handle(VesselInput::Message(connection(id), bytes)),
        }
    }

    /// One end closes; the other learns of it where the network carries that.
    pub(crate) fn close(&mut self, id: u64, closer: Direction) {
        let Some(wire) = self.network.wires.get_mut(&id) else { return };
        *wire.end(closer) = false;
        let path = &self.network.paths[wire.way];
        let towards = closer.other();
        // Behind what was sent before.
        let after = wire.last[towards as usize].saturating_sub(self.now_us).max(path.delay_us);
        if path.cut_until[towards as usize] <= self.now_us {
            self.at(after, Event::Gone(id, towards));
        }
    }

    /// A process is killed: its kernel closes its connections.
    pub(crate) fn hang_up(&mut self, killed: Direction) {
        for id in self.network.ids() {
            self.close(id, killed);
        }
    }

    pub(crate) fn gone(&mut self, id: u64, end: Direction) {
        let Some(wire) = self.network.wires.get_mut(&id) else { return };
        if self.network.paths[wire.way].cut_until[end as usize] > self.now_us {
            return;
        }
        let had_it = std::mem::take(wire.end(end));
        if !wire.shore_has_it && !wire.vessel_has_it {
            self.network.wires.remove(&id);
        }
        match end {
            _ if !had_it => {}
            Direction::Up => self.shore_handle(ShoreInput::Closed(connection(id))),
            Direction::Down => self.vessel_handle(VesselInput::Closed(connection(id))),
        }
    }
}
