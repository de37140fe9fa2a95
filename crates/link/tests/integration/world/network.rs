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

#[derive(Debug)]
pub(crate) struct Network {
    wires: BTreeMap<u64, Wire>,
    cut_until: [u64; 2],
    /// When the last byte sent leaves the sender.
    free_at: [u64; 2],
    pub(crate) delay_us: u64,
    pub(crate) bytes_per_s: u64,
    /// Bytes a second until a time.
    pub(crate) slow: (u64, u64),
    pub(crate) duplicate_next: bool,
    pub(crate) swap_next: bool,
    /// Bytes sent, both ways together.
    pub(crate) carried_bytes: u64,
}

impl Default for Network {
    fn default() -> Self {
        Self {
            wires: BTreeMap::new(),
            cut_until: [0; 2],
            free_at: [0; 2],
            delay_us: 40_000,
            bytes_per_s: 250_000,
            slow: (0, 0),
            duplicate_next: false,
            swap_next: false,
            carried_bytes: 0,
        }
    }
}

impl Network {
    pub(crate) fn ids(&self) -> Vec<u64> {
        self.wires.keys().copied().collect()
    }

    pub(crate) fn cut(&mut self, direction: Direction, until_us: u64) {
        let cut = &mut self.cut_until[direction as usize];
        *cut = (*cut).max(until_us);
    }

    fn is_cut(&self, now_us: u64) -> bool {
        self.cut_until.iter().any(|until| *until > now_us)
    }
}

impl World {
    /// The vessel connects.
    pub(crate) fn connect(&mut self, id: u64, patience: Duration) {
        let (delay, jitter) = (self.network.delay_us, self.chance.below(20_000));
        if self.network.is_cut(self.now_us) {
            // The kernel sends its first packet again after a second.
            let again = self.now_us + 1_000_000;
            if micros(patience) <= 1_000_000 + 4 * delay || self.network.is_cut(again) {
                return self.at(micros(patience), Event::ConnectFailed(id));
            }
            return self.at(1_000_000 + 4 * delay + jitter, Event::Connected(id));
        }
        // A handshake of TCP and one of WebSocket.
        self.at(4 * delay + jitter, Event::Connected(id));
    }

    pub(crate) fn connected(&mut self, id: u64) {
        if self.network.is_cut(self.now_us) || self.shore.machine.is_none() {
            return self.connect_failed(id);
        }
        let wire =
            Wire { shore_has_it: true, vessel_has_it: self.vessel.machine.is_some(), ..Wire::default() };
        self.network.wires.insert(id, wire);
        self.shore_handle(ShoreInput::Opened(connection(id)));
        self.vessel_handle(VesselInput::Opened(connection(id)));
    }

    pub(crate) fn connect_failed(&mut self, id: u64) {
        self.vessel_handle(VesselInput::Failed(connection(id), Failure::Unanswered));
    }

    pub(crate) fn transmit(&mut self, id: u64, direction: Direction, bytes: Bytes) {
        let (now, network) = (self.now_us, &mut self.network);
        let Some(wire) = network.wires.get_mut(&id) else { return };
        let rate = if network.slow.1 > now { network.slow.0 } else { network.bytes_per_s };
        let leaves = network.free_at[direction as usize].max(now) + bytes.len() as u64 * 1_000_000 / rate;
        network.free_at[direction as usize] = leaves;
        network.carried_bytes += bytes.len() as u64;
        let arrives =
            (leaves + network.delay_us + self.chance.below(5_000)).max(wire.last[direction as usize]);
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
        let cut_until = self.network.cut_until[direction as usize];
        let Some(wire) = self.network.wires.get_mut(&id) else { return };
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
            // Nobody there: the sender is told.
            let back = self.network.delay_us;
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
        let towards = closer.other();
        // Behind what was sent before.
        let after = wire.last[towards as usize].saturating_sub(self.now_us).max(self.network.delay_us);
        if self.network.cut_until[towards as usize] <= self.now_us {
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
        if self.network.cut_until[end as usize] > self.now_us {
            return;
        }
        let Some(wire) = self.network.wires.get_mut(&id) else { return };
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
