//! The send queue of a peer that may be slow to read.
//!
//! The bound is in bytes. When it is reached, the older half of the waiting telemetry is dropped, so that a
//! peer that reads again gets the newest; commands, answers, detections and other events stay. When these
//! alone fill the queue, the caller is asked to disconnect the peer.

use crate::delivery::{CommandId, Delivery, Urgency};
use imc::messages::{Abort, Payload as _};
use imc::{Address, PacketView};
use std::collections::VecDeque;

/// Bytes that a waiting packet costs beside its own.
const OVERHEAD_BYTES: usize = size_of::<Delivery>();

/// How a push went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pushed {
    /// It waits.
    Queued,
    /// It waits, and this many older telemetry packets were dropped for it.
    Dropped(u64),
    /// Nothing that can be dropped is left: the peer must go.
    Overflow,
}

/// The queue of one peer.
#[derive(Debug)]
pub struct PeerQueue {
    packets: VecDeque<Delivery>,
    bytes: usize,
    bound_bytes: usize,
}

impl PeerQueue {
    /// An empty queue of at most `bound_bytes`.
    pub fn new(bound_bytes: usize) -> Self {
        Self { packets: VecDeque::new(), bytes: 0, bound_bytes }
    }

    /// Takes out the orders that a stop calls off: what waits for the same vessel and would make it do something after the
    /// stop. The commands among them are given back.
    pub fn call_off(&mut self, stop: &Delivery) -> Vec<CommandId> {
        let Ok(view) = PacketView::unchecked(&stop.packet) else { return Vec::new() };
        let (vessel, mut off) = (view.dst(), Vec::new());
        self.packets.retain(|waits| {
            let moves = PacketView::unchecked(&waits.packet).is_ok_and(|view| {
                view.dst() == vessel && (waits.tag.is_some() || crate::exchange::is_command(&view))
            });
            let keep = is_stop(waits)
                || !moves
                || PacketView::unchecked(&waits.packet).is_ok_and(|view| view.id() == Abort::ID);
            if !keep {
                self.bytes -= waits.packet.len() + OVERHEAD_BYTES;
                off.extend(waits.tag.and_then(|tag| tag.id));
            }
            keep
        });
        off
    }

    /// Puts in a stop ahead of everything else. It replaces an older stop for the same vessel. There is always room for it.
    pub fn push_stop(&mut self, stop: Delivery) {
        let vessel = destination(&stop);
        if let Some(older) =
            self.packets.iter_mut().find(|waits| is_stop(waits) && destination(waits) == vessel)
        {
            *older = stop;
            return;
        }
        self.bytes += stop.packet.len() + OVERHEAD_BYTES;
        let place = self.packets.iter().take_while(|waits| is_stop(waits)).count();
        self.packets.insert(place, stop);
    }

    /// Drops everything but stops, and gives back the commands among it.
    pub fn keep_stops(&mut self) -> Vec<CommandId> {
        let all = self.take();
        let (stops, others): (Vec<_>, Vec<_>) = all.into_iter().partition(is_stop);
        for stop in stops {
            self.push_stop(stop);
        }
        others.into_iter().filter_map(|packet| packet.tag?.id).collect()
    }

    /// Appends packets. Stops go ahead of everything else.
    pub fn push(&mut self, packets: impl IntoIterator<Item = Delivery>) -> Pushed {
        let mut dropped = 0;
        for packet in packets {
            if is_stop(&packet) {
                self.push_stop(packet);
                continue;
            }
            self.bytes += packet.packet.len() + OVERHEAD_BYTES;
            self.packets.push_back(packet);
            if self.bytes > self.bound_bytes {
                dropped += self.shed();
                if self.bytes > self.bound_bytes {
                    return Pushed::Overflow;
                }
            }
        }
        if dropped == 0 { Pushed::Queued } else { Pushed::Dropped(dropped) }
    }

    /// Takes everything that waits.
    pub fn take(&mut self) -> VecDeque<Delivery> {
        self.bytes = 0;
        std::mem::take(&mut self.packets)
    }

    /// Takes the oldest that wait, not more than so many bytes but one packet at least.
    pub fn take_some(&mut self, most_bytes: usize) -> VecDeque<Delivery> {
        let (mut count, mut bytes) = (0, 0);
        for packet in &self.packets {
            let more = bytes + packet.packet.len() + OVERHEAD_BYTES;
            if count > 0 && more > most_bytes {
                break;
            }
            (count, bytes) = (count + 1, more);
        }
        self.bytes -= bytes;
        self.packets.drain(..count).collect()
    }

    /// Packets that wait.
    pub fn len(&self) -> usize {
        self.packets.len()
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.packets.is_empty()
    }

    /// Bytes that wait, with what keeping them costs.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Drops telemetry from the front until half of the bound is free or none is left.
    fn shed(&mut self) -> u64 {
        let (before, goal) = (self.packets.len(), self.bound_bytes / 2);
        let mut bytes = self.bytes;
        self.packets.retain(|packet| {
            let keep = bytes <= goal || !is_telemetry(packet);
            if !keep {
                bytes -= packet.packet.len() + OVERHEAD_BYTES;
            }
            keep
        });
        self.bytes = bytes;
        (before - self.packets.len()) as u64
    }
}

fn destination(delivery: &Delivery) -> Option<Address> {
    PacketView::unchecked(&delivery.packet).ok().map(|view| view.dst())
}

/// Whether it is a stop of this server's own.
pub fn is_stop(delivery: &Delivery) -> bool {
    delivery.tag.is_some_and(|tag| tag.urgency == Urgency::Stop)
}

/// Whether a newer packet of the kind makes this one worthless. What is addressed to one system and every event
/// is not telemetry.
fn is_telemetry(delivery: &Delivery) -> bool {
    delivery.tag.is_none()
        && PacketView::unchecked(&delivery.packet)
            .is_ok_and(|view| !crate::is_event(view.id()) && !crate::exchange::is_exchange(view.id()))
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::delivery::Tag;
    use bytes::Bytes;
    use imc::{Header, Packet, messages};

    fn state() -> Delivery {
        let packet = Packet::new(Header::default(), messages::EstimatedState::default()).encode().unwrap();
        Bytes::from(packet).into()
    }

    #[test]
    fn what_is_taken_in_parts_is_whole_and_in_order() {
        let mut queue = PeerQueue::new(100_000);
        let all: Vec<Delivery> = (0..100_u8).map(|n| Bytes::from(vec![n; 100]).into()).collect();
        queue.push(all.clone());
        let mut taken = Vec::new();
        while !queue.is_empty() {
            let some = queue.take_some(1_000);
            assert!((1..=10).contains(&some.len()));
            taken.extend(some);
        }
        assert_eq!((taken, queue.bytes()), (all, 0));
        queue.push([Bytes::from(vec![0; 5_000]).into()]);
        assert_eq!(queue.take_some(1_000).len(), 1, "a long packet comes alone");
    }

    fn abort() -> Delivery {
        Bytes::from(Packet::new(Header::default(), messages::Abort).encode().unwrap()).into()
    }

    #[test]
    fn a_stop_goes_ahead_of_all_that_waits() {
        let mut queue = PeerQueue::new(100_000);
        let tagged = |vessel, urgency| {
            let header = Header { dst: imc::Address(vessel), ..Header::default() };
            let packet = Bytes::from(Packet::new(header, messages::Abort).encode().unwrap());
            let tag =
                Tag { id: None, is_copy: false, epoch: 0, expires: units::MonoTime::default(), urgency };
            Delivery { packet, tag: Some(tag) }
        };
        queue.push([
            state(),
            tagged(7, Urgency::Command),
            tagged(7, Urgency::Stop),
            state(),
            tagged(8, Urgency::Stop),
        ]);
        let urgencies: Vec<Option<Urgency>> =
            queue.take().into_iter().map(|one| one.tag.map(|tag| tag.urgency)).collect();
        let stop = Some(Urgency::Stop);
        assert_eq!(urgencies, [stop, stop, None, Some(Urgency::Command), None]);
    }

    #[test]
    fn a_stop_calls_off_what_waits_for_its_vessel_and_nothing_else() {
        let mut queue = PeerQueue::new(100_000);
        let order = |vessel, urgency, number| {
            let header = Header { dst: imc::Address(vessel), ..Header::default() };
            let packet = Packet::new(header, messages::PlanControl::default()).encode().unwrap();
            let id = Some(CommandId(number));
            let tag = Tag { id, is_copy: false, epoch: 0, expires: units::MonoTime::default(), urgency };
            Delivery { packet: Bytes::from(packet), tag: Some(tag) }
        };
        let console = Delivery { tag: None, ..order(7, Urgency::Command, 0) };
        let stop = order(7, Urgency::Stop, 9);
        queue.push([
            order(7, Urgency::Command, 1),
            state(),
            console,
            order(8, Urgency::Command, 2),
            stop.clone(),
        ]);
        assert_eq!(queue.call_off(&stop), [CommandId(1)]);
        let left: Vec<Option<CommandId>> =
            queue.take().into_iter().map(|one| one.tag.and_then(|tag| tag.id)).collect();
        assert_eq!(left, [Some(CommandId(9)), None, Some(CommandId(2))]);
        assert_eq!(queue.bytes(), 0);
    }

    #[test]
    fn a_stop_has_room_where_nothing_has_and_a_newer_one_takes_its_place() {
        let mut queue = PeerQueue::new(1_000);
        let stop = |vessel, number| {
            let header = Header { dst: imc::Address(vessel), ..Header::default() };
            let packet = Packet::new(header, messages::Abort).encode().unwrap();
            let (id, expires) = (Some(CommandId(number)), units::MonoTime::default());
            let tag = Tag { id, is_copy: false, epoch: 0, expires, urgency: Urgency::Stop };
            Delivery { packet: Bytes::from(packet), tag: Some(tag) }
        };
        while queue.push([abort()]) != Pushed::Overflow {}
        for number in 0..1_000 {
            queue.push_stop(stop(7, number));
        }
        queue.push_stop(stop(8, 5));
        assert!(queue.keep_stops().is_empty(), "what a console said is not an order of ours");
        let left: Vec<u64> = queue.take().into_iter().filter_map(|one| Some(one.tag?.id?.0)).collect();
        assert_eq!((left, queue.bytes()), (vec![999, 5], 0));
    }

    #[test]
    fn sheds_old_telemetry_and_keeps_commands() {
        let mut queue = PeerQueue::new(10_000);
        queue.push([abort()]);
        let mut dropped = 0;
        for _ in 0..1_000 {
            if let Pushed::Dropped(count) = queue.push([state()]) {
                dropped += count;
            }
            assert!(queue.bytes() <= 10_000);
        }
        let left = queue.take();
        assert_eq!(left.len() as u64 + dropped, 1_001);
        assert_eq!(left[0], abort(), "what cannot be replaced stays in its place");
        assert!(queue.is_empty());
        assert_eq!(queue.bytes(), 0);
    }

    #[test]
    fn says_when_only_commands_are_left() {
        let mut queue = PeerQueue::new(1_000);
        let outcome = (0..100).map(|_| queue.push([abort()])).find(|pushed| *pushed == Pushed::Overflow);
        assert_eq!(outcome, Some(Pushed::Overflow));
        assert!(queue.bytes() <= 1_000 + 22 + OVERHEAD_BYTES);
    }
}
