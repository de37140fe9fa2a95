//! The one connection over which the link stands: what was received, what is durable.

use super::{PeerBacklog, ShoreOutput};
use crate::clocks::Clocks;
use crate::frame::{Ack, Capabilities, Frame, Gap, Heartbeat};
use crate::{ConnectionId, HEARTBEAT, Latency, Record};
use std::time::Duration;
use units::{MonoTime, Now};

/// Latencies beyond this are backlog, not transit, and would drown it in the mean.
const LONGEST_TRANSIT: Duration = Duration::from_mins(1);

#[derive(Debug)]
pub(crate) struct Connected {
    pub(crate) id: ConnectionId,
    pub(crate) capabilities: Capabilities,
    pub(crate) stream: u64,
    pub(crate) heard: MonoTime,
    pub(crate) next_heartbeat: MonoTime,
    pub(crate) clocks: Clocks,
    /// The number after the last received without holes.
    received: u64,
    durable: u64,
    /// Bytes of messages received.
    pub(crate) bytes: u64,
    /// Something came that the vessel waits to hear of.
    ack_due: bool,
    pub(crate) backlog: PeerBacklog,
}

impl Connected {
    pub(crate) fn new(
        now: MonoTime,
        id: ConnectionId,
        stream: u64,
        resume: u64,
        rest: (Capabilities, Clocks, u64),
    ) -> Self {
        let (capabilities, clocks, bytes) = rest;
        Self {
            id,
            capabilities,
            stream,
            heard: now,
            next_heartbeat: now + HEARTBEAT,
            clocks,
            received: resume,
            durable: resume,
            bytes,
            ack_due: false,
            backlog: PeerBacklog::default(),
        }
    }

    /// Takes records; those received before are dropped and counted. Fails where there is a gap.
    pub(crate) fn records(
        &mut self,
        now: Now,
        mut records: Vec<Record>,
        (transit, repeated): (&mut Latency, &mut u64),
    ) -> Result<Option<ShoreOutput>, String> {
        self.ack_due = true;
        let Some(first) = records.first().map(|record| record.seq) else { return Ok(None) };
        if first > self.received {
            return Err(format!("records from {first} on without {} and what follows", self.received));
        }
        let known = ((self.received - first) as usize).min(records.len());
        records.drain(..known);
        *repeated += known as u64;
        let Some(last) = records.last() else { return Ok(None) };
        self.received = last.seq + 1;
        if let Some(estimate) = self.clocks.estimate(now) {
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
        self.ack_due = true;
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

    pub(crate) fn live(&mut self) {
        self.ack_due = true;
    }

    pub(crate) fn heartbeat(&mut self, now: Now, beat: &Heartbeat) {
        self.clocks.heard(now, beat.stamp);
        self.backlog = PeerBacklog {
            records: beat.next.saturating_sub(self.received),
            waiting: Duration::from_micros(beat.waiting_us),
            keeping: Duration::from_micros(beat.kept_us),
        };
    }

    /// Everything below this number is durable. What was never received over this connection is not believed.
    pub(crate) fn kept(&mut self, next: u64) {
        let next = next.min(self.received);
        if next > self.durable {
            self.durable = next;
            self.ack_due = true;
        }
    }

    /// The frames that fall due.
    pub(crate) fn due(&mut self, now: Now) -> Vec<Frame> {
        let mut frames = Vec::new();
        if std::mem::take(&mut self.ack_due) {
            frames.push(Frame::Ack(Ack {
                received: self.received,
                durable: self.durable,
                bytes: self.bytes,
            }));
        }
        if now.mono >= self.next_heartbeat {
            self.next_heartbeat = now.mono + HEARTBEAT;
            let stamp = self.clocks.stamp(now);
            frames.push(Frame::Heartbeat(Heartbeat { stamp, bytes: self.bytes, ..Heartbeat::default() }));
        }
        frames
    }
}
