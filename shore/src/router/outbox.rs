//! The queue of one peer, between the hub, which never waits, and the socket, which may.

use crate::clock::Clock;
use bytes::Bytes;
use hub::{CommandId, Delivery, PeerQueue, Pushed};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use tokio::sync::Notify;

/// Bytes that a socket takes from the queue at once: these wait outside of the queue and are sent however old they get.
pub const AT_ONCE_BYTES: usize = 64 << 10;

/// The peer has read nothing for this long that there is no room even for packets that must not be dropped.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("the peer does not read: what waits for it has no room any more")]
pub struct Overflow;

/// Orders that are not sent.
#[derive(Debug, Default)]
pub struct Unsent {
    /// Superseded by a stop.
    pub called_off: Vec<CommandId>,
    /// No room, because the peer does not read.
    pub no_room: Vec<CommandId>,
}

/// The queue of one peer, its bound in bytes. See [`PeerQueue`] for what is dropped when it is full.
#[derive(Debug)]
pub struct Outbox {
    clock: Clock,
    queue: Mutex<PeerQueue>,
    ready: Notify,
    dropped: AtomicU64,
    overflow: AtomicBool,
}

impl Outbox {
    /// Empty, with this limit in bytes.
    pub fn new(bound_bytes: usize, clock: Clock) -> Self {
        Self {
            clock,
            queue: Mutex::new(PeerQueue::new(bound_bytes)),
            ready: Notify::new(),
            dropped: AtomicU64::new(0),
            overflow: AtomicBool::new(false),
        }
    }

    /// Appends packets; never waits.
    pub fn push(&self, packets: Vec<Delivery>) -> Unsent {
        let (stops, others): (Vec<_>, Vec<_>) = packets.into_iter().partition(hub::is_stop);
        let given = others.iter().filter_map(|packet| packet.tag?.id).collect::<Vec<_>>();
        let mut unsent = Unsent::default();
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let was_empty = queue.is_empty();
        // Queued even when full: a stop is sent as soon as the peer reads, or by another transport.
        for stop in stops {
            unsent.called_off.extend(queue.call_off(&stop));
            queue.push_stop(stop);
        }
        let all = (queue.len() + others.len()) as u64;
        if self.overflow.load(Ordering::Relaxed) {
            self.count_dropped(others.len() as u64);
            unsent.no_room = given;
        } else {
            match queue.push(others) {
                Pushed::Queued => {}
                Pushed::Dropped(count) => self.count_dropped(count),
                Pushed::Overflow => {
                    // Frees its memory at once, before the peer's task notices.
                    unsent.no_room = queue.keep_stops();
                    unsent.no_room.extend(given);
                    self.overflow.store(true, Ordering::Relaxed);
                    self.count_dropped(all - queue.len() as u64);
                }
            }
        }
        drop(queue);
        if was_empty {
            self.ready.notify_one();
        }
        unsent
    }

    /// Whether it has room.
    pub fn takes(&self) -> bool {
        !self.overflow.load(Ordering::Relaxed)
    }

    fn count_dropped(&self, count: u64) {
        self.dropped.fetch_add(count, Ordering::Relaxed);
        metrics::counter!("lutra_relay_dropped_total").increment(count);
    }

    /// The queued packets, as [`Outbox::take`].
    ///
    /// # Errors
    /// As [`Outbox::take`].
    pub async fn take_packets(&self) -> Result<Vec<Bytes>, Overflow> {
        Ok(self.take().await?.into_iter().map(|delivery| delivery.packet).collect())
    }

    /// Waits for packets, and takes the oldest, up to [`AT_ONCE_BYTES`]. An order whose time to live has ended is dropped
    /// and counted.
    ///
    /// # Errors
    /// The peer has read nothing for too long.
    pub async fn take(&self) -> Result<VecDeque<Delivery>, Overflow> {
        loop {
            if self.overflow.load(Ordering::Relaxed) {
                return Err(Overflow);
            }
            let mut packets =
                self.queue.lock().unwrap_or_else(PoisonError::into_inner).take_some(AT_ONCE_BYTES);
            let (now, all) = (self.clock.now().mono, packets.len());
            packets.retain(|packet| packet.tag.is_none_or(|tag| now < tag.expires));
            self.count_dropped((all - packets.len()) as u64);
            if !packets.is_empty() {
                return Ok(packets);
            }
            if all == 0 {
                self.ready.notified().await;
            }
        }
    }

    /// Takes everything that is queued for a peer that is gone.
    pub fn drain(&self) -> VecDeque<Delivery> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Reopens after an overflow, for a peer that stays connected. All queued packets but stops are lost.
    pub fn reopen(&self) {
        self.overflow.store(false, Ordering::Relaxed);
    }

    /// Telemetry packets that were dropped because the peer did not read fast enough.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::{Address, Header, Packet, messages};

    #[tokio::test]
    async fn what_has_no_room_is_an_overflow_until_it_is_reopened() {
        let header = Header { dst: Address(0x2810), timestamp: 1.0, ..Header::default() };
        let stop = Delivery::from(Bytes::from(Packet::new(header, messages::Abort).encode().unwrap()));
        let outbox = Outbox::new(1_000, Clock::real());
        outbox.push(vec![stop.clone(); 100]);
        assert!(outbox.take().await.is_err());
        outbox.push(vec![stop.clone()]);
        assert!(outbox.take().await.is_err(), "the peer is to be let go");
        outbox.reopen();
        outbox.push(vec![stop.clone()]);
        assert_eq!(outbox.take().await.unwrap(), [stop]);
    }

    #[tokio::test]
    async fn a_stop_outlives_an_overflow() {
        let clock = Clock::real();
        let header = Header { dst: Address(0x2810), timestamp: 1.0, ..Header::default() };
        let abort = Bytes::from(Packet::new(header, messages::Abort).encode().unwrap());
        let order = |number, urgency| {
            let expires = clock.now().mono + hub::STOP_LIFE;
            let tag =
                Some(hub::Tag { id: Some(CommandId(number)), is_copy: false, epoch: 0, expires, urgency });
            Delivery { packet: abort.clone(), tag }
        };
        let outbox = Outbox::new(1_000, clock.clone());
        let stop = order(1, hub::Urgency::Stop);
        let mut all = vec![Delivery::from(abort.clone()); 100];
        all.push(stop.clone());
        assert!(outbox.takes() && outbox.push(all).no_room.is_empty() && !outbox.takes());
        assert_eq!(outbox.push(vec![order(2, hub::Urgency::Command)]).no_room, [CommandId(2)]);
        let later = order(3, hub::Urgency::Stop);
        assert!(outbox.push(vec![later.clone()]).no_room.is_empty());
        assert!(outbox.take().await.is_err());
        outbox.reopen();
        assert_eq!(outbox.take().await.unwrap(), [later]);
    }
}
