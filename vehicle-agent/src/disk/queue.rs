//! The bounded queue before the disk, and what happens when it is full.

use super::{Work, is_record};
use imc::PacketView;
use std::collections::VecDeque;
use std::fmt;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Memory of an entry besides its bytes.
const ENTRY_BYTES: usize = 96;

/// Counts of work that could not be taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    /// Packets of measurements and states, and lines of text.
    pub(crate) ordinary: u64,
    /// Detections, commands and messages that explain a log.
    pub(crate) records: u64,
}

impl Lost {
    /// Counts a packet.
    pub(crate) fn count(&mut self, packet: &[u8]) {
        let is_record = PacketView::unchecked(packet).is_ok_and(|view| is_record(view.id()));
        *(if is_record { &mut self.records } else { &mut self.ordinary }) += 1;
    }

    pub(crate) fn is_none(self) -> bool {
        self == Self::default()
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ordinary, records } = self;
        write!(
            f,
            "{records} detections, commands or entries and {ordinary} other messages or lines are missing in \
             the log"
        )
    }
}

/// The queue.
#[derive(Debug)]
pub(crate) struct Queue {
    waiting: Mutex<Waiting>,
    changed: Condvar,
    most_bytes: usize,
}

#[derive(Debug, Default)]
struct Waiting {
    works: VecDeque<Work>,
    bytes: usize,
    ticks: usize,
    lost: Lost,
    closed: bool,
}

/// No other record of a run is larger than a chart.
const LARGE_RECORD_BYTES: usize = 128 << 10;

/// Share of the queue that a kind of work may fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Share {
    Most,
    All,
    Always,
}

impl Queue {
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self { waiting: Mutex::default(), changed: Condvar::new(), most_bytes }
    }

    /// Queues work; returns whether there was room.
    pub(crate) fn put(&self, work: Work) -> bool {
        let (share, bytes) = (share(&work), bytes(&work));
        let mut waiting = self.lock();
        let after = waiting.bytes + bytes;
        let fits = match share {
            Share::Most => after <= self.most_bytes / 4 * 3,
            Share::All => after <= self.most_bytes,
            Share::Always => true,
        };
        if !fits {
            match share {
                Share::Most => waiting.lost.ordinary += 1,
                Share::All | Share::Always => waiting.lost.records += 1,
            }
            return false;
        }
        if matches!(work, Work::Tick(..)) {
            // One queued tick is enough.
            if waiting.ticks > 0 {
                return true;
            }
            waiting.ticks += 1;
        }
        waiting.bytes = after;
        waiting.works.push_back(work);
        drop(waiting);
        self.changed.notify_one();
        true
    }

    /// Waits for work; `None` after the end.
    pub(crate) fn take(&self) -> Option<Work> {
        let mut waiting = self.lock();
        loop {
            if let Some(work) = waiting.works.pop_front() {
                waiting.bytes -= bytes(&work);
                waiting.ticks -= usize::from(matches!(work, Work::Tick(..)));
                return Some(work);
            }
            if waiting.closed {
                return None;
            }
            waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    pub(crate) fn take_lost(&self) -> Lost {
        std::mem::take(&mut self.lock().lost)
    }

    /// No more work comes; the queue can still be drained.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn share(work: &Work) -> Share {
    match work {
        Work::Packet(_, bytes) => {
            let is_record = PacketView::unchecked(bytes).is_ok_and(|view| is_record(view.id()));
            if is_record { Share::All } else { Share::Most }
        }
        // A chart, which is rare.
        Work::Record(_, bytes) if bytes.len() > LARGE_RECORD_BYTES => Share::Always,
        Work::Line(..) | Work::Record(..) => Share::Most,
        Work::Open(..)
        | Work::Close(_)
        | Work::Plans(_)
        | Work::Parameters(..)
        | Work::UnderWay(_)
        | Work::EndRecording
        | Work::Tick(..) => Share::Always,
    }
}

fn bytes(work: &Work) -> usize {
    ENTRY_BYTES
        + match work {
            Work::Packet(_, bytes) | Work::Record(_, bytes) => bytes.len(),
            Work::Line(_, text) | Work::Open(_, _, text) => text.len(),
            Work::UnderWay(packet) => packet.as_ref().map_or(0, Vec::len),
            Work::Close(_) | Work::Plans(_) | Work::Parameters(..) | Work::EndRecording | Work::Tick(..) => 0,
        }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{Abort, EstimatedState, Message};
    use imc::{Header, Packet};
    use units::{MonoTime, UtcTime};

    fn packet(message: impl Into<Message>) -> Work {
        Work::Packet(MonoTime::default(), Packet::new(Header::default(), message).encode().unwrap())
    }

    fn fill(queue: &Queue, work: &Work) -> u64 {
        (0..100_000).find(|_| !queue.put(work.clone())).unwrap()
    }

    #[test]
    fn measurements_give_way_to_commands_and_both_to_changes() {
        let queue = Queue::new(64 << 10);
        let (state, abort) = (packet(EstimatedState::default()), packet(Abort));
        assert!(fill(&queue, &state) > 200);
        assert!(!queue.put(Work::Line(MonoTime::default(), "a line".repeat(40))));
        assert_eq!(queue.take_lost(), Lost { ordinary: 2, records: 0 });
        // A quarter of the queue is reserved for them.
        assert!(fill(&queue, &abort) > 100);
        assert_eq!(queue.take_lost(), Lost { ordinary: 0, records: 1 });
        assert!(queue.take_lost().is_none());
        let open = Work::Open(MonoTime::default(), UtcTime::default(), "plan".to_owned());
        assert!(queue.put(open.clone()) && queue.put(Work::EndRecording));

        // All accepted work comes out, in order, and makes room again.
        queue.close();
        let all: Vec<Work> = std::iter::from_fn(|| queue.take()).collect();
        assert_eq!((all.first(), all.get(all.len() - 2)), (Some(&state), Some(&open)));
        assert_eq!(queue.lock().bytes, 0);
        assert!(queue.put(state));
    }

    #[test]
    fn ticks_do_not_pile_up() {
        let queue = Queue::new(1 << 10);
        for _ in 0..1000 {
            assert!(queue.put(Work::Tick(MonoTime::default(), UtcTime::default())));
        }
        assert_eq!(queue.lock().works.len(), 1);
        queue.take();
        assert!(queue.put(Work::Tick(MonoTime::default(), UtcTime::default())));
        assert_eq!(queue.lock().works.len(), 1);
    }
}
