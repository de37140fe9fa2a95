//! The latest packet of each kind, for a map that is current while the records are not.
//!
//! Bounded: [`MOST_KINDS`] kinds and [`MOST_BYTES`] bytes. When full, kinds that were never seen are left to the
//! record lane and counted; known kinds continue.

use crate::frame::Batch;
use crate::ways::Thinning;
use crate::{MAX_BATCH_RAW_BYTES, Packer};
use bytes::Bytes;
use imc::PacketView;
use imc::messages::{
    Abort, EntityState, EstimatedState, FuelLevel, GpsFix, LogBookEntry, Payload as _, PlanControl,
    PlanControlState, PlanDB, VehicleCommand, VehicleState,
};
use std::collections::BTreeMap;
use units::{MonoTime, Now, UtcTime};

const MOST_KINDS: usize = 2048;
const MOST_BYTES: usize = 512 << 10;

/// Whether a way carries the newest of a message.
fn carries(thinning: Thinning, id: u16) -> bool {
    thinning < Thinning::Most || LAST_TO_GO.contains(&id)
}

/// Messages whose first byte says which of several alike is meant: EntityInfo, ServoPosition,
/// SetThrusterActuation, SetServoPosition. (The Otters' two thrusters share entity and millisecond.)
const NUMBERED: [u16; 4] = [3, 281, 301, 302];

/// The messages that a thinned way carries to the last: position, alarms, states, and answers to commands.
const LAST_TO_GO: [u16; 11] = [
    EntityState::ID,
    GpsFix::ID,
    EstimatedState::ID,
    FuelLevel::ID,
    VehicleState::ID,
    VehicleCommand::ID,
    Abort::ID,
    PlanControlState::ID,
    PlanControl::ID,
    PlanDB::ID,
    LogBookEntry::ID,
];

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    id: u16,
    src: u16,
    entity: u8,
    number: u8,
}

#[derive(Debug, Clone)]
struct Value {
    packet: Bytes,
    at: UtcTime,
    /// Not sent since it changed.
    fresh: bool,
    /// When this kind was sent last.
    sent: MonoTime,
}

/// The latest packets.
#[derive(Debug, Clone, Default)]
pub(crate) struct LiveSet {
    values: BTreeMap<Kind, Value>,
    bytes: usize,
    left_out: u64,
}

impl LiveSet {
    /// Takes a packet; answers false for what is not a packet.
    pub(crate) fn put(&mut self, now: Now, packet: Bytes) -> bool {
        let Ok(view) = PacketView::unchecked(&packet) else { return false };
        let id = view.id();
        let number = if NUMBERED.contains(&id) { view.payload().first().copied().unwrap_or(0) } else { 0 };
        let kind = Kind { id, src: view.src().0, entity: view.src_ent(), number };
        let (before, sent) = self
            .values
            .get(&kind)
            .map_or((None, MonoTime::default()), |value| (Some(value.packet.len()), value.sent));
        let bytes = self.bytes - before.unwrap_or(0) + packet.len();
        if bytes > MOST_BYTES || (before.is_none() && self.values.len() >= MOST_KINDS) {
            self.left_out += 1;
            return true;
        }
        self.bytes = bytes;
        self.values.insert(kind, Value { packet, at: now.utc, fresh: true, sent });
        true
    }

    /// All must be sent again: the other side may have none.
    pub(crate) fn refresh(&mut self) {
        for value in self.values.values_mut() {
            value.fresh = true;
        }
    }

    /// Packets that found no room.
    pub(crate) fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Whether something was not sent since it changed.
    pub(crate) fn is_fresh(&self, thinning: Thinning) -> bool {
        self.values.iter().any(|(kind, value)| value.fresh && carries(thinning, kind.id))
    }

    /// Messages not sent since they changed, those first that waited longest, up to `most_bytes` (but one at
    /// least).
    pub(crate) fn take(
        &mut self,
        now: MonoTime,
        most_bytes: usize,
        packer: &mut Packer,
        thinning: Thinning,
    ) -> Option<Batch> {
        let mut fresh: Vec<(MonoTime, Kind)> = self
            .values
            .iter()
            .filter(|(kind, value)| value.fresh && carries(thinning, kind.id))
            .map(|(kind, value)| (value.sent, *kind))
            .collect();
        fresh.sort_unstable();
        let mut bytes = 0;
        let most_bytes = most_bytes.min(MAX_BATCH_RAW_BYTES / 2);
        let mut taken: Vec<(UtcTime, Bytes)> = Vec::new();
        for (_, kind) in fresh {
            let Some(value) = self.values.get_mut(&kind) else { continue };
            bytes += value.packet.len() + 16;
            if bytes > most_bytes && !taken.is_empty() {
                break;
            }
            (value.fresh, value.sent) = (false, now);
            taken.push((value.at, value.packet.clone()));
        }
        if taken.is_empty() {
            return None;
        }
        // Old values first, so that the order in which they were sent is kept.
        taken.sort_by_key(|(at, _)| *at);
        Some(packer.pack(0, taken.iter().map(|(at, packet)| (*at, &packet[..]))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unpack;
    use imc::messages::{Rpm, SetThrusterActuation};
    use imc::{Header, Message, Packet};

    fn packet(message: impl Into<Message>, entity: u8) -> Bytes {
        let header = Header { src_ent: entity, ..Header::default() };
        Packet::new(header, message.into()).encode().unwrap().into()
    }

    fn take(live: &mut LiveSet, most: usize) -> Vec<Bytes> {
        let batch = live.take(MonoTime::from_micros(1), most, &mut Packer::new(true), Thinning::Nothing);
        batch.map_or_else(Vec::new, |batch| {
            unpack(&batch).unwrap().into_iter().map(|one| one.packet).collect()
        })
    }

    #[test]
    fn the_latest_of_each_kind_is_sent_once() {
        let mut live = LiveSet::default();
        let thrust = |id, value| packet(SetThrusterActuation { id, value }, 7);
        for value in [0.1, 0.2] {
            for id in 0..2 {
                assert!(live.put(Now::default(), thrust(id, value)));
            }
        }
        assert!(!live.put(Now::default(), Bytes::from_static(b"no packet")));
        assert_eq!(take(&mut live, 10_000), [thrust(0, 0.2), thrust(1, 0.2)]);
        assert!(!live.is_fresh(Thinning::Nothing) && take(&mut live, 10_000).is_empty());
        live.refresh();
        assert_eq!(take(&mut live, 10_000).len(), 2);
    }

    #[test]
    fn little_room_is_shared_in_turns() {
        let mut live = LiveSet::default();
        let mut seen = std::collections::BTreeSet::new();
        for turn in 0..10 {
            for entity in 0..20 {
                live.put(Now::default(), packet(Rpm { value: turn }, entity));
            }
            let now = MonoTime::from_micros(turn as u64 + 1);
            if let Some(one) = live.take(now, 100, &mut Packer::new(false), Thinning::Nothing) {
                for record in unpack(&one).unwrap() {
                    seen.insert(PacketView::new(&record.packet).unwrap().src_ent());
                }
            }
        }
        assert_eq!(seen.len(), 20);
    }

    #[test]
    fn it_never_grows_beyond_its_bounds() {
        let mut live = LiveSet::default();
        for src in 0..3000 {
            let header = Header { src: imc::Address(src), ..Header::default() };
            let bytes = Packet::new(header, Rpm { value: 1 }).encode().unwrap();
            live.put(Now::default(), bytes.into());
        }
        assert_eq!((live.values.len(), live.left_out()), (MOST_KINDS, 3000 - MOST_KINDS as u64));
    }
}
