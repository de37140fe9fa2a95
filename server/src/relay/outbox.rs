//! What waits for one peer, between the hub that never waits and the socket that may.

use super::Clock;
use bytes::Bytes;
use hub::{CommandId, Delivery, PeerQueue, Pushed};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use tokio::sync::Notify;

/// Bytes that a socket takes from the queue at once: what it took already waits beside the queue and is sent
/// however old it gets.
pub(crate) const AT_ONCE_BYTES: usize = 64 << 10;

/// The peer took nothing for so long that even what must not be dropped has no room.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("the peer does not read: what waits for it has no room any more")]
pub(crate) struct Overflow;

/// Orders that are not sent.
#[derive(Debug, Default)]
pub(crate) struct Unsent {
    /// A stop followed.
    pub(crate) called_off: Vec<CommandId>,
    /// The peer does not read.
    pub(crate) no_room: Vec<CommandId>,
}

/// The queue of one peer, its bound in bytes. See [`PeerQueue`] for what is dropped when it is full.
#[derive(Debug)]
pub(crate) struct Outbox {
    clock: Clock,
    queue: Mutex<PeerQueue>,
    ready: Notify,
    dropped: AtomicU64,
    overflow: AtomicBool,
}

impl Outbox {
    pub(crate) fn new(bound_bytes: usize, clock: Clock) -> Self {
        Self {
            clock,
            queue: Mutex::new(PeerQueue::new(bound_bytes)),
            ready: Notify::new(),
            dropped: AtomicU64::new(0),
            overflow: AtomicBool::new(false),
        }
    }

    /// Appends packets; never waits.
    pub(crate) fn push(&self, packets: Vec<Delivery>) -> Unsent {
        let orders =
            |packets: &[Delivery]| packets.iter().filter_map(|packet| packet.tag?.id).collect::<Vec<_>>();
        let given = orders(&packets);
        if self.overflow.load(Ordering::Relaxed) {
            self.count_dropped(packets.len() as u64);
            return Unsent { no_room: given, ..Unsent::default() };
        }
        let mut unsent = Unsent::default();
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        for stop in packets.iter().filter(|packet| hub::is_stop(packet)) {
            unsent.called_off.extend(queue.call_off(stop));
        }
        let (was_empty, all) = (queue.is_empty(), queue.len() + packets.len());
        match queue.push(packets) {
            Pushed::Queued => {}
            Pushed::Dropped(count) => self.count_dropped(count),
            Pushed::Overflow => {
                // Its memory is free at once, whenever the peer's task notices.
                unsent.no_room = orders(queue.take().make_contiguous());
                unsent.no_room.extend(given);
                self.overflow.store(true, Ordering::Relaxed);
                self.count_dropped(all as u64);
            }
        }
        drop(queue);
        if was_empty {
            self.ready.notify_one();
        }
        unsent
    }

    fn count_dropped(&self, count: u64) {
        self.dropped.fetch_add(count, Ordering::Relaxed);
        metrics::counter!("lutra_relay_dropped_total").increment(count);
    }

    /// The packets that wait, as [`Outbox::take`].
    ///
    /// # Errors
    /// As [`Outbox::take`].
    pub(crate) async fn take_packets(&self) -> Result<Vec<Bytes>, Overflow> {
        Ok(self.take().await?.into_iter().map(|delivery| delivery.packet).collect())
    }

    /// The oldest that wait, up to [`AT_ONCE_BYTES`]; waits for something. An order whose life has ended meanwhile is
    /// dropped and counted.
    ///
    /// # Errors
    /// The peer took nothing for too long.
    pub(crate) async fn take(&self) -> Result<VecDeque<Delivery>, Overflow> {
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

    /// Everything that waits, for a peer that is gone.
    pub(crate) fn drain(&self) -> VecDeque<Delivery> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Starts anew after an overflow, for a peer that is not let go for it. What waited is lost.
    pub(crate) fn reopen(&self) {
        self.overflow.store(false, Ordering::Relaxed);
    }

    /// Telemetry packets that were dropped because the peer did not read.
    pub(crate) fn dropped(&self) -> u64 {
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
        let outbox = Outbox::new(1_000, Clock::start());
        outbox.push(vec![stop.clone(); 100]);
        assert!(outbox.take().await.is_err());
        outbox.push(vec![stop.clone()]);
        assert!(outbox.take().await.is_err(), "the peer is to be let go");
        outbox.reopen();
        outbox.push(vec![stop.clone()]);
        assert_eq!(outbox.take().await.unwrap(), [stop]);
    }
}
