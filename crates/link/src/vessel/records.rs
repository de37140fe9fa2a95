//! The record lane's place in the stream, and whether it lags.

use crate::vessel::SpoolState;
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, Now};

/// A record that is not sent after this time makes the lane lag.
pub(crate) const LAGS_AFTER: Duration = Duration::from_secs(1);
const MARK_EVERY: Duration = Duration::from_millis(125);

/// Recent ends of the spool, so that the age of waiting records is known without asking it.
#[derive(Debug, Clone)]
pub(crate) struct LagTracker {
    /// Times and the number that was next then, oldest first; the front is older than the bound, or the first.
    marks: VecDeque<(MonoTime, u64)>,
    /// The disk does not take the spool: there are no records to wait for.
    refused: bool,
}

impl LagTracker {
    pub(crate) fn new(now: Now, spool: SpoolState) -> Self {
        Self { marks: VecDeque::from([(now.mono, spool.next)]), refused: false }
    }

    pub(crate) fn mark(&mut self, now: MonoTime, next: u64) {
        if self.marks.back().is_none_or(|(at, _)| now.since(*at) >= MARK_EVERY) {
            self.marks.push_back((now, next));
        }
        while self.marks.get(1).is_some_and(|(at, _)| now.since(*at) >= LAGS_AFTER) {
            self.marks.pop_front();
        }
    }

    /// Whether the disk takes the spool.
    pub(crate) fn refuse(&mut self, refused: bool) {
        self.refused = refused;
    }

    /// Whether the disk does not take the spool.
    pub(crate) fn is_refused(&self) -> bool {
        self.refused
    }

    /// Whether the next record has waited for a second or more, or the disk refuses records.
    pub(crate) fn lags(&self, now: MonoTime, cursor: u64) -> bool {
        self.refused
            || self.marks.front().is_some_and(|(at, next)| now.since(*at) >= LAGS_AFTER && cursor < *next)
    }
}

/// Bytes of records that were sent and are not durable yet.
#[derive(Debug, Clone, Default)]
pub(crate) struct InFlight {
    sent: VecDeque<(u64, usize, MonoTime)>,
    bytes: usize,
}

impl InFlight {
    /// Everything below `to` was sent, the last of it in a message of so many bytes.
    pub(crate) fn sent(&mut self, now: MonoTime, to: u64, bytes: usize) {
        self.bytes += bytes;
        self.sent.push_back((to, bytes, now));
    }

    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }

    /// Everything below `durable` is; returns how long the last of it took.
    pub(crate) fn kept(&mut self, now: MonoTime, durable: u64) -> Option<Duration> {
        let mut took = None;
        while let Some((_, bytes, at)) = self.sent.pop_front_if(|(to, ..)| *to <= durable) {
            self.bytes -= bytes;
            took = Some(now.since(at));
        }
        took
    }
}
