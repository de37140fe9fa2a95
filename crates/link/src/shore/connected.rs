//! An open connection, and what was received of a vessel's stream over all of them.

use super::{PeerBacklog, ShoreOutput};
use crate::clocks::Clocks;
use crate::frame::{Ack, Capabilities, Frame, Gap, Heartbeat, Hello};
use crate::ways::{SLOW_HEARTBEAT, WayHello, dead_after};
use crate::{ConnectionId, DEAD_AFTER, HEARTBEAT, Latency, Record};
use std::time::Duration;
use units::{MonoTime, Now};

/// Latencies beyond this are backlog, not transit, and would drown it in the mean.
const LONGEST_TRANSIT: Duration = Duration::from_mins(1);

/// The records received of a stream, over all connections of one start of the vessel's program.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) stream: u64,
    /// The number after the last received without holes.
    received: u64,
    durable: u64,
    pub(crate) backlog: PeerBacklog,
}

impl Joined {
    pub(crate) fn new(hello: &Hello, resume: u64) -> Self {
        Self { stream: hello.stream, received: resume, durable: resume, backlog: PeerBacklog::default() }
    }

    /// One more connection of the same stream; everything below `resume` is durable.
    pub(crate) fn again(&mut self, resume: u64) {
        self.received = self.received.max(resume);
        self.durable = self.durable.max(resume);
    }

    /// Takes records; those received before are dropped and counted. Fails where there is a gap.
    pub(crate) fn records(
        &mut self,
        now: Now,
        clocks: &Clocks,
        mut records: Vec<Record>,
        (transit, repeated): (&mut Latency, &mut u64),
    ) -> Result<Option<ShoreOutput>, String> {
        let Some(first) = records.first().map(|record| record.seq) else { return Ok(None) };
        if first > self.received {
            return Err(format!("records from {first} on without {} and what follows", self.received));
        }
        let known = ((self.received - first) as usize).min(records.len());
        records.drain(..known);
        *repeated += known as u64;
        let Some(last) = records.last() else { return Ok(None) };
        self.received = last.seq + 1;
        if let Some(estimate) = clocks.estimate(now) {
            for record in &records {
                // The vessel's clock less by how much it is ahead is ours.
                let us = (now.utc - record.recorded).saturating_add(estimate.utc_ahead_us).max(0);
                let took = Duration::from_micros(us.unsigned_abs());
                if took <= LONGEST_TRANSIT {
                    transit.add(took);
                }
            }
        }
        Ok(Some(ShoreOutput::Records { stream: self.stream, records }))
    }

    /// Takes a gap, but for what was received before. Fails where there is a gap.
    pub(crate) fn gap(&mut self, gap: Gap) -> Result<Option<ShoreOutput>, String> {
        if gap.from > self.received {
            return Err(format!("a gap from {} on without {} and what follows", gap.from, self.received));
        }
        if gap.to <= self.received {
            return Ok(None);
        }
        let gap = Gap { from: self.received, ..gap };
        self.received = gap.to;
        Ok(Some(ShoreOutput::Gap { stream: self.stream, gap }))
    }

    /// The records that wait aboard; the connection that carries records reports their age.
    pub(crate) fn heartbeat(&mut self, beat: &Heartbeat, carries_records: bool) {
        self.backlog.records = beat.next.saturating_sub(self.received);
        if carries_records {
            self.backlog.waiting = Duration::from_micros(beat.waiting_us);
            self.backlog.keeping = Duration::from_micros(beat.kept_us);
        }
    }

    /// Everything below this number is durable; returns whether that is new. A number never received is ignored.
    pub(crate) fn kept(&mut self, next: u64) -> bool {
        let next = next.min(self.received);
        let news = next > self.durable;
        self.durable = self.durable.max(next);
        news
    }
}

/// An open connection.
#[derive(Debug)]
pub(crate) struct Connected {
    pub(crate) id: ConnectionId,
    pub(crate) way: Option<WayHello>,
    pub(crate) capabilities: Capabilities,
    pub(crate) heard: MonoTime,
    pub(crate) next_heartbeat: MonoTime,
    pub(crate) clocks: Clocks,
    /// Bytes of messages received.
    pub(crate) bytes: u64,
    /// A message came that the vessel expects to be acknowledged.
    pub(crate) ack_due: bool,
}

impl Connected {
    pub(crate) fn new(
        now: MonoTime,
        id: ConnectionId,
        way: Option<WayHello>,
        (capabilities, clocks, bytes): (Capabilities, Clocks, u64),
    ) -> Self {
        // Over a second way the vessel hears at once how far the others have come.
        let ack_due = way.is_some();
        let next_heartbeat = now + HEARTBEAT;
        Self { id, way, capabilities, heard: now, next_heartbeat, clocks, bytes, ack_due }
    }

    /// The place of its way.
    pub(crate) fn place(&self) -> Option<u8> {
        self.way.as_ref().map(|way| way.index)
    }

    /// When it is given up for silence.
    pub(crate) fn dead_at(&self) -> MonoTime {
        self.heard + self.way.as_ref().map_or(DEAD_AFTER, |way| dead_after(way.metered))
    }

    /// The frames that fall due.
    pub(crate) fn due(&mut self, now: Now, joined: &Joined) -> Vec<Frame> {
        let mut frames = Vec::new();
        if std::mem::take(&mut self.ack_due) {
            frames.push(Frame::Ack(Ack {
                received: joined.received,
                durable: joined.durable,
                bytes: self.bytes,
            }));
        }
        if now.mono >= self.next_heartbeat {
            let metered = self.way.as_ref().is_some_and(|way| way.metered);
            self.next_heartbeat = now.mono + if metered { SLOW_HEARTBEAT } else { HEARTBEAT };
            let stamp = self.clocks.stamp(now);
            frames.push(Frame::Heartbeat(Heartbeat { stamp, bytes: self.bytes, ..Heartbeat::default() }));
        }
        frames
    }
}
