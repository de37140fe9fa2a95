//! Events one by one, the latest of them.

use super::Event;
use std::collections::VecDeque;

/// A ring of events, in order of their revisions. Beyond its bounds the oldest is forgotten, and counted.
#[derive(Debug)]
pub(super) struct Ring {
    events: VecDeque<Event>,
    bytes: usize,
    most: usize,
    most_bytes: usize,
    /// The revisions of those that were forgotten last; as many as there may be events.
    forgotten: VecDeque<u64>,
}

impl Ring {
    pub(super) fn new(most: usize, most_bytes: usize) -> Self {
        Self { events: VecDeque::new(), bytes: 0, most, most_bytes, forgotten: VecDeque::new() }
    }

    pub(super) fn push(&mut self, event: Event) {
        self.bytes += event.packet.len();
        self.events.push_back(event);
        while self.events.len() > self.most || self.bytes > self.most_bytes {
            let Some(old) = self.events.pop_front() else { break };
            self.bytes -= old.packet.len();
            self.forgotten.push_back(old.revision);
            if self.forgotten.len() > self.most {
                self.forgotten.pop_front();
            }
        }
    }

    /// Those after the revision `from`, up to `to`.
    pub(super) fn between(&self, from: u64, to: u64) -> impl Iterator<Item = &Event> {
        let first = self.events.partition_point(|event| event.revision <= from);
        let last = self.events.partition_point(|event| event.revision <= to);
        self.events.range(first..last)
    }

    /// How many after the revision `from` were forgotten.
    pub(super) fn missed(&self, from: u64) -> u64 {
        (self.forgotten.len() - self.forgotten.partition_point(|at| *at <= from)) as u64
    }
}
