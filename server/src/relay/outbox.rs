//! What waits for one peer, between the hub that never waits and the socket that may.

use bytes::Bytes;
use hub::{PeerQueue, Pushed};
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

/// The queue of one peer, its bound in bytes. See [`PeerQueue`] for what is dropped when it is full.
#[derive(Debug)]
pub(crate) struct Outbox {
    queue: Mutex<PeerQueue>,
    ready: Notify,
    dropped: AtomicU64,
    overflow: AtomicBool,
}

impl Outbox {
    pub(crate) fn new(bound_bytes: usize) -> Self {
        Self {
            queue: Mutex::new(PeerQueue::new(bound_bytes)),
            ready: Notify::new(),
            dropped: AtomicU64::new(0),
            overflow: AtomicBool::new(false),
        }
    }

    /// Appends packets; never waits.
    pub(crate) fn push(&self, packets: Vec<Bytes>) {
        if self.overflow.load(Ordering::Relaxed) {
            return self.count_dropped(packets.len() as u64);
        }
        let mut queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let (was_empty, all) = (queue.is_empty(), queue.len() + packets.len());
        match queue.push(packets) {
            Pushed::Queued => {}
            Pushed::Dropped(count) => self.count_dropped(count),
            Pushed::Overflow => {
                // Its memory is free at once, whenever the peer's task notices.
                queue.take();
                self.overflow.store(true, Ordering::Relaxed);
                self.count_dropped(all as u64);
            }
        }
        drop(queue);
        if was_empty {
            self.ready.notify_one();
        }
    }

    fn count_dropped(&self, count: u64) {
        self.dropped.fetch_add(count, Ordering::Relaxed);
        metrics::counter!("lutra_relay_dropped_total").increment(count);
    }

    /// The oldest that wait, up to [`AT_ONCE_BYTES`]; waits for something.
    pub(crate) async fn take(&self) -> Result<VecDeque<Bytes>, Overflow> {
        loop {
            if self.overflow.load(Ordering::Relaxed) {
                return Err(Overflow);
            }
            let packets = self.queue.lock().unwrap_or_else(PoisonError::into_inner).take_some(AT_ONCE_BYTES);
            if !packets.is_empty() {
                return Ok(packets);
            }
            self.ready.notified().await;
        }
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
        let stop = Bytes::from(Packet::new(header, messages::Abort).encode().unwrap());
        let outbox = Outbox::new(1_000);
        outbox.push(vec![stop.clone(); 100]);
        assert!(outbox.take().await.is_err());
        outbox.push(vec![stop.clone()]);
        assert!(outbox.take().await.is_err(), "the peer is to be let go");
        outbox.reopen();
        outbox.push(vec![stop.clone()]);
        assert_eq!(outbox.take().await.unwrap(), [stop]);
    }
}
