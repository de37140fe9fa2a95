//! What waits for a peer that may not read.
//!
//! The bound is in bytes. When it is reached, the older half of the telemetry that waits is dropped, so that a
//! peer that reads again gets what is newest; commands, answers, detections and other events stay. When these
//! alone fill the queue, the peer is beyond help and the caller is told to let it go.

use bytes::Bytes;
use imc::PacketView;
use std::collections::VecDeque;

/// Bytes that a waiting packet costs beside its own.
const OVERHEAD_BYTES: usize = size_of::<Bytes>();

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
    packets: VecDeque<Bytes>,
    bytes: usize,
    bound_bytes: usize,
}

impl PeerQueue {
    /// An empty queue of at most `bound_bytes`.
    pub fn new(bound_bytes: usize) -> Self {
        Self { packets: VecDeque::new(), bytes: 0, bound_bytes }
    }

    /// Appends packets.
    pub fn push(&mut self, packets: impl IntoIterator<Item = Bytes>) -> Pushed {
        let mut dropped = 0;
        for packet in packets {
            self.bytes += packet.len() + OVERHEAD_BYTES;
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
    pub fn take(&mut self) -> VecDeque<Bytes> {
        self.bytes = 0;
        std::mem::take(&mut self.packets)
    }

    /// Takes the oldest that wait, not more than so many bytes but one packet at least.
    pub fn take_some(&mut self, most_bytes: usize) -> VecDeque<Bytes> {
        let (mut count, mut bytes) = (0, 0);
        for packet in &self.packets {
            let more = bytes + packet.len() + OVERHEAD_BYTES;
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
                bytes -= packet.len() + OVERHEAD_BYTES;
            }
            keep
        });
        self.bytes = bytes;
        (before - self.packets.len()) as u64
    }
}

/// Whether a newer packet of the kind makes this one worthless. What is addressed to one system and every event
/// is no telemetry.
fn is_telemetry(packet: &[u8]) -> bool {
    PacketView::unchecked(packet)
        .is_ok_and(|view| !crate::is_event(view.id()) && !crate::hub::is_exchange(view.id()))
}

#[cfg(test)]
mod tests {

    use super::*;
    use imc::{Header, Packet, messages};

    fn state() -> Bytes {
        Packet::new(Header::default(), messages::EstimatedState::default()).encode().unwrap().into()
    }

    #[test]
    fn what_is_taken_in_parts_is_whole_and_in_order() {
        let mut queue = PeerQueue::new(100_000);
        let all: Vec<Bytes> = (0..100_u8).map(|n| Bytes::from(vec![n; 100])).collect();
        queue.push(all.clone());
        let mut taken = Vec::new();
        while !queue.is_empty() {
            let some = queue.take_some(1_000);
            assert!((1..=10).contains(&some.len()));
            taken.extend(some);
        }
        assert_eq!((taken, queue.bytes()), (all, 0));
        queue.push([Bytes::from(vec![0; 5_000])]);
        assert_eq!(queue.take_some(1_000).len(), 1, "a long packet comes alone");
    }

    fn abort() -> Bytes {
        Packet::new(Header::default(), messages::Abort).encode().unwrap().into()
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
