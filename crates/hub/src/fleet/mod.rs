//! The live state of the fleet: the last packet of every series, how old it is and how often it comes, the
//! names of entities, and the latest events.
//!
//! A series is a message of an entity of a system; where an `id` distinguishes several parts of one entity (as
//! `SetThrusterActuation` does port and starboard), each is a series. Packets are kept as received and decoded by
//! the reader.
//!
//! Every change has a revision, so that a reader that comes back asks only for what is new since then and sees
//! the latest of each series; how many were skipped follows from the counts. Events are kept one by one in a ring
//! of [`EVENTS_KEPT`]; a reader that was away for longer learns how many it missed.

mod ring;
mod system;

pub use system::{Liveness, Series, SeriesKey, System};

use crate::Transport;
use bytes::Bytes;
use imc::messages::{self as m, Payload as _};
use imc::{Address, PacketView};
use ring::Ring;
use std::collections::BTreeMap;
use units::{Now, UtcTime};

/// Systems that are known at once; beyond that the one silent for longest is forgotten.
const SYSTEMS_KEPT: usize = 512;
/// Bytes that the series of all systems may take; beyond that, too, the one silent for longest is forgotten.
const BYTES_KEPT: usize = 16 << 20;
/// Events that are kept.
const EVENTS_KEPT: usize = 4_096;
/// Bytes that all kept events may have.
const EVENT_BYTES_KEPT: usize = 4 << 20;
/// Events of the past that are kept, and their bytes: a vessel that comes back with a season takes no place of the present.
const LATE_KEPT: usize = 1_024;
const LATE_BYTES_KEPT: usize = 1 << 20;

/// A message that is an event and is not replaced by the next of its kind.
#[derive(Debug, Clone)]
pub struct Event {
    /// The revision that it made.
    pub revision: u64,
    /// The packet.
    pub packet: Bytes,
    /// When it came.
    pub received: UtcTime,
    /// Whether it is of the past, delivered late.
    pub late: bool,
}

/// Changes that are new to a reader.
#[derive(Debug)]
pub struct Changes<'a> {
    /// To ask with next time.
    pub revision: u64,
    /// Series with a new value, in order of change.
    pub series: Vec<(&'a System, SeriesKey, &'a Series)>,
    /// Events, in order.
    pub events: Vec<Event>,
    /// Events that were forgotten before the reader came.
    pub events_missed: u64,
}

/// All systems.
#[derive(Debug)]
pub struct Fleet {
    systems: BTreeMap<Address, System>,
    /// The size of their series.
    bytes: usize,
    revision: u64,
    /// The changed series by revision; each is here once, at its latest.
    changed: BTreeMap<u64, (Address, SeriesKey)>,
    events: Ring,
    late: Ring,
}

impl Default for Fleet {
    fn default() -> Self {
        Self {
            systems: BTreeMap::new(),
            bytes: 0,
            revision: 0,
            changed: BTreeMap::new(),
            events: Ring::new(EVENTS_KEPT, EVENT_BYTES_KEPT),
            late: Ring::new(LATE_KEPT, LATE_BYTES_KEPT),
        }
    }
}

/// Whether a message is an event: each one counts, and none is dropped for a newer one.
pub fn is_event(id: u16) -> bool {
    matches!(
        id,
        m::Abort::ID
            | m::Aborted::ID
            | m::EntityParameters::ID
            | m::Event::ID
            | m::HistoricEvent::ID
            | m::LogBookEntry::ID
            | m::PlanControl::ID
            | m::PlanDB::ID
            | m::Sms::ID
            | m::TBRFishTag::ID
            | m::Target::ID
            | m::TeleoperationDone::ID
            | m::TextMessage::ID
            | m::VehicleCommand::ID
    )
}

impl Fleet {
    /// A packet that came, checked to be one. Whether it was new to the fleet's state (and not older than what
    /// is known of its series).
    pub fn update(&mut self, now: Now, view: &PacketView<'_>, transport: Transport) -> bool {
        let source = view.src();
        if !self.systems.contains_key(&source) && self.systems.len() >= SYSTEMS_KEPT {
            self.forget_longest_silent();
        }
        let system = self.systems.entry(source).or_insert_with(|| System::new(source, now));
        system.heard(now, view, transport);
        let key = SeriesKey::of(view);
        let revision = self.revision + 1;
        let before = system.size();
        // A copy of its own: the bytes that came are a part of a message, which would stay in memory with them.
        let packet = Bytes::copy_from_slice(view.bytes());
        let taken = system.take(now, key, &packet, view.timestamp(), revision);
        self.bytes = self.bytes - before + system.size();
        if let Some(before) = taken {
            before.map(|before| self.changed.remove(&before));
            self.changed.insert(revision, (source, key));
        }
        // An event counts even when a later one of its series came first.
        let event = is_event(view.id());
        if event {
            self.events.push(Event { revision, packet, received: now.utc, late: false });
        }
        if taken.is_some() || event {
            self.revision = revision;
        }
        // The one that was just heard is the last to go.
        while self.bytes > BYTES_KEPT && self.systems.len() > 1 {
            self.forget_longest_silent();
        }
        taken.is_some()
    }

    /// An event of the past that came only now. It says nothing of how its system is.
    pub fn late(&mut self, now: Now, view: &PacketView<'_>) {
        self.revision += 1;
        let packet = Bytes::copy_from_slice(view.bytes());
        self.late.push(Event { revision: self.revision, packet, received: now.utc, late: true });
    }

    fn forget_longest_silent(&mut self) {
        let oldest = self.systems.values().min_by_key(|system| system.last_heard()).map(System::address);
        if let Some(address) = oldest {
            self.bytes -= self.systems.remove(&address).map_or(0, |system| system.size());
            self.changed.retain(|_, (of, _)| *of != address);
        }
    }

    /// All systems, by address.
    pub fn systems(&self) -> impl Iterator<Item = &System> {
        self.systems.values()
    }

    /// One system.
    pub fn system(&self, address: Address) -> Option<&System> {
        self.systems.get(&address)
    }

    /// What to call a system: its name, with its address where another announced the same, or its address.
    pub fn title(&self, address: Address) -> String {
        let Some(name) = self.system(address).and_then(System::name) else { return address.to_string() };
        let shared = self.systems.values().filter(|system| system.name() == Some(name)).count() > 1;
        if shared { format!("{name} ({:#06x})", address.0) } else { name.to_owned() }
    }

    /// The system that announced a name; the one heard last when several did.
    pub fn named(&self, name: &str) -> Option<&System> {
        self.systems
            .values()
            .filter(|system| system.name() == Some(name))
            .max_by_key(|system| system.last_heard())
    }

    /// The revision of the last change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// What changed after `revision` in series that `wanted` admits, at most `most` series: the oldest changes
    /// come first, and [`Changes::revision`] says where to continue. Events are given to every reader that admits
    /// their series.
    pub fn changes(
        &self,
        revision: u64,
        most: usize,
        wanted: impl Fn(Address, SeriesKey) -> bool,
    ) -> Changes<'_> {
        let mut series = Vec::new();
        let mut reached = self.revision;
        for (changed, (address, key)) in self.changed.range(revision + 1..) {
            if series.len() == most {
                reached = changed - 1;
                break;
            }
            if !wanted(*address, *key) {
                continue;
            }
            if let Some(system) = self.systems.get(address)
                && let Some(value) = system.series(*key)
            {
                series.push((system, *key, value));
            }
        }
        let admitted = |event: &&Event| {
            PacketView::unchecked(&event.packet).is_ok_and(|view| wanted(view.src(), SeriesKey::of(&view)))
        };
        let both = self.events.between(revision, reached).chain(self.late.between(revision, reached));
        let mut events: Vec<Event> = both.filter(admitted).cloned().collect();
        events.sort_by_key(|event| event.revision);
        // A reader that starts from nothing misses nothing: it asked for the present.
        let missed = self.events.missed(revision) + self.late.missed(revision);
        let events_missed = if revision == 0 { 0 } else { missed };
        Changes { revision: reached, series, events, events_missed }
    }
}

#[cfg(test)]
mod tests;
