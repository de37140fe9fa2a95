//! The queue from the loop to the thread: in memory, bounded, non-blocking.

use link::ChartAboard;
use std::collections::VecDeque;
use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use units::UtcTime;

/// Most queued bytes, with the overhead of packets.
const QUEUE_BYTES: usize = 4 << 20;
const PACKET_COST_BYTES: usize = 64;

/// The queue.
#[derive(Debug)]
pub(super) struct Queue {
    waiting: Mutex<Waiting>,
    /// The thread was woken and has not looked yet.
    woken: AtomicBool,
    /// The chart aboard, as last set.
    chart: Mutex<ChartAboard>,
    bell: UnixStream,
}

/// Queued packets, and those lost for lack of room.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    pub(super) packets: VecDeque<(UtcTime, Vec<u8>)>,
    bytes: usize,
    pub(super) missed: Option<Missed>,
    pub(super) ending: bool,
}

/// Packets without room, after the queued ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Missed {
    pub(super) count: u64,
    pub(super) since: UtcTime,
    pub(super) until: UtcTime,
}

impl Queue {
    /// An empty queue, and the end of a pipe that becomes readable when something is put.
    pub(super) fn new() -> io::Result<(Self, UnixStream)> {
        let (bell, wake) = UnixStream::pair()?;
        bell.set_nonblocking(true)?;
        wake.set_nonblocking(true)?;
        let (waiting, woken, chart) = (Mutex::default(), AtomicBool::new(false), Mutex::default());
        Ok((Self { waiting, woken, chart, bell }, wake))
    }

    /// Queues a packet, or counts it if there is no room. Once one was lost, the following are too until the thread has
    /// emptied the queue, so that the gap is in its place. [`Queue::flush`] must follow.
    pub(super) fn put(&self, recorded: UtcTime, packet: &[u8]) {
        let mut waiting = self.lock();
        let cost = packet.len() + PACKET_COST_BYTES;
        if waiting.missed.is_some() || waiting.bytes + cost > QUEUE_BYTES {
            let before = waiting.missed.unwrap_or(Missed { count: 0, since: recorded, until: recorded });
            waiting.missed = Some(Missed { count: before.count + 1, until: recorded, ..before });
        } else {
            waiting.bytes += cost;
            waiting.packets.push_back((recorded, packet.to_vec()));
        }
    }

    /// Wakes the thread for the queued packets.
    pub(super) fn flush(&self) {
        let is_empty = {
            let waiting = self.lock();
            waiting.packets.is_empty() && waiting.missed.is_none()
        };
        if !is_empty {
            self.ring();
        }
    }

    /// Sets the chart aboard.
    pub(super) fn put_chart(&self, chart: ChartAboard) {
        let mut known = self.chart.lock().unwrap_or_else(PoisonError::into_inner);
        if *known != chart {
            *known = chart;
            drop(known);
            self.ring();
        }
    }

    /// The chart aboard.
    pub(super) fn chart(&self) -> ChartAboard {
        self.chart.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// No more will be put.
    pub(super) fn end(&self) {
        self.lock().ending = true;
        self.ring();
    }

    /// Whether no more will be put.
    pub(super) fn is_ending(&self) -> bool {
        self.lock().ending
    }

    /// Wakes the thread.
    pub(super) fn ring(&self) {
        if !self.woken.swap(true, Ordering::AcqRel) {
            // A full pipe wakes the thread too.
            (&self.bell).write_all(&[0]).ok();
        }
    }

    /// Takes the whole queue.
    pub(super) fn take(&self, wake: &mut UnixStream) -> Waiting {
        let mut bytes = [0; 64];
        while wake.read(&mut bytes).is_ok_and(|read| read > 0) {}
        self.woken.store(false, Ordering::Release);
        let mut waiting = self.lock();
        let ending = waiting.ending;
        Waiting { ending, ..std::mem::take(&mut *waiting) }
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_finds_no_room_is_counted_until_the_thread_has_looked() {
        let (queue, mut wake) = Queue::new().unwrap();
        let time = UtcTime::from_micros;
        let packet = vec![0; 1000 - PACKET_COST_BYTES];
        let fits = (QUEUE_BYTES / 1000) as i64;
        for at in 0..fits + 7 {
            queue.put(time(at), &packet);
        }
        queue.put(time(fits + 7), &[]);
        let waiting = queue.take(&mut wake);
        assert_eq!(waiting.packets.len() as i64, fits);
        assert_eq!(waiting.missed, Some(Missed { count: 8, since: time(fits), until: time(fits + 7) }));
        queue.put(time(0), &packet);
        let waiting = queue.take(&mut wake);
        assert_eq!((waiting.packets.len(), waiting.missed), (1, None));
    }
}
