//! A connection that stands: what is sent over it when, and what comes back.

use super::records::{InFlight, LagTracker};
use super::{Entry, SpoolState};
use crate::clocks::Clocks;
use crate::frame::{Ack, Capabilities, Frame, Gap, GapReason, Heartbeat, Welcome, message};
use crate::live::LiveSet;
use crate::pace::Pace;
use crate::{HEARTBEAT, Latency, MAX_BATCH_RAW_BYTES, Packer, Record};
use bytes::Bytes;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// So many records are sent without waiting for more.
const ENOUGH_RECORDS: u64 = 64;
/// Fresh records wait for others for a quarter of a round trip, but not longer than this.
const GREATEST_WAIT: Duration = Duration::from_millis(50);
/// A spool that could not be read is asked again after this.
const SPOOL_RETRY: Duration = Duration::from_secs(1);
const GREATEST_READ_BYTES: usize = 64 << 10;
const LEAST_READ_BYTES: usize = 2 << 10;
const LIVE_EVERY: Duration = Duration::from_millis(250);
const LIVE_LOOK_EVERY: Duration = Duration::from_millis(25);
const LIVE_FIRST_BYTES: usize = 64 << 10;
const LIVE_BYTES: usize = 16 << 10;
const LEAST_LIVE_BYTES: usize = 1 << 10;

/// State of a connection that stands.
#[derive(Debug)]
pub(crate) struct Up {
    capabilities: Capabilities,
    window_bytes: usize,
    packer: Packer,
    budget_bytes_per_s: Option<u32>,
    pub(crate) next_heartbeat: MonoTime,
    /// The number to send next.
    pub(crate) cursor: u64,
    /// When the last record that was sent was recorded.
    cursor_recorded: Option<UtcTime>,
    /// Since when something waits to be sent.
    waits_since: Option<MonoTime>,
    /// The number the spool was asked for.
    asked: Option<u64>,
    not_before: MonoTime,
    pub(crate) durable: u64,
    unkept: InFlight,
    next_live: MonoTime,
    live_is_first: bool,
    last_kept: Duration,
}

/// What all parts of a step need.
pub(crate) struct Step<'a> {
    pub(crate) now: Now,
    pub(crate) spool: SpoolState,
    pub(crate) pace: &'a mut Pace,
    pub(crate) clocks: &'a Clocks,
    pub(crate) growth: &'a LagTracker,
    pub(crate) live: &'a mut LiveSet,
}

impl Up {
    pub(crate) fn new(now: MonoTime, welcome: &Welcome, budget_bytes_per_s: Option<u32>) -> Self {
        Self {
            capabilities: welcome.capabilities,
            window_bytes: welcome.window_bytes as usize,
            packer: Packer::new(welcome.capabilities.has(Capabilities::ZSTD)),
            budget_bytes_per_s,
            next_heartbeat: now,
            cursor: welcome.resume,
            cursor_recorded: None,
            waits_since: None,
            asked: None,
            not_before: now,
            durable: welcome.resume,
            unkept: InFlight::default(),
            next_live: now,
            live_is_first: true,
            last_kept: Duration::ZERO,
        }
    }

    /// What falls due: messages to send, and where the spool is to be read.
    pub(crate) fn step(&mut self, step: &mut Step<'_>) -> (Vec<Bytes>, Option<(u64, usize)>) {
        let mut messages = Vec::new();
        if step.now.mono >= self.next_heartbeat {
            self.next_heartbeat = step.now.mono + HEARTBEAT;
            messages.push(message(&Frame::Heartbeat(self.heartbeat(step))));
        }
        messages.extend(self.live(step));
        let need = self.need(step);
        (messages, need)
    }

    fn heartbeat(&self, step: &Step<'_>) -> Heartbeat {
        let waiting_us = match self.cursor_recorded {
            Some(recorded) if self.cursor < step.spool.next => {
                (step.now.utc - recorded).max(0).unsigned_abs()
            }
            _ => 0,
        };
        Heartbeat {
            stamp: step.clocks.stamp(step.now),
            bytes: 0,
            next: step.spool.next,
            durable: self.durable,
            waiting_us,
            kept_us: self.last_kept.as_micros() as u64,
        }
    }

    fn live(&mut self, step: &mut Step<'_>) -> Option<Bytes> {
        let now = step.now.mono;
        let due = self.live_is_first
            || (now >= self.next_live && step.growth.lags(now, self.cursor) && step.pace.room() > 0);
        if !self.capabilities.has(Capabilities::LIVE) {
            self.live_is_first = false;
            return None;
        }
        if !due {
            return None;
        }
        let most = if self.live_is_first {
            LIVE_FIRST_BYTES
        } else {
            // Three quarters of the budget at most, so that the records always move.
            self.budget_bytes_per_s.map_or(LIVE_BYTES, |rate| {
                let share = u64::from(rate) * 3 / 4 * LIVE_EVERY.as_millis() as u64 / 1000;
                (share as usize).clamp(LEAST_LIVE_BYTES, LIVE_BYTES)
            })
        };
        self.live_is_first = false;
        self.next_live = now + LIVE_EVERY;
        step.live.take(now, most, &mut self.packer).map(|batch| message(&Frame::Live(batch)))
    }

    /// When records may be asked for; `None` while nothing that time brings would allow it.
    fn records_due(&mut self, step: &mut Step<'_>) -> Option<MonoTime> {
        let now = step.now.mono;
        if self.asked.is_some() || self.cursor >= step.spool.next {
            return None;
        }
        if step.pace.room() == 0 || self.unkept.bytes() >= self.window_bytes {
            return None;
        }
        let since = *self.waits_since.get_or_insert(now);
        let enough = step.spool.next - self.cursor >= ENOUGH_RECORDS;
        let wait = step.clocks.shortest_round_trip().unwrap_or_default() / 4;
        let together = if enough { now } else { since + wait.min(GREATEST_WAIT) };
        Some(together.max(self.not_before).max(step.pace.affordable(now)))
    }

    fn need(&mut self, step: &mut Step<'_>) -> Option<(u64, usize)> {
        let due = self.records_due(step)?;
        if due > step.now.mono {
            return None;
        }
        self.asked = Some(self.cursor);
        let affordable = self.budget_bytes_per_s.map_or(GREATEST_READ_BYTES, |rate| rate as usize / 4);
        let most = step.pace.room().min(affordable).clamp(LEAST_READ_BYTES, GREATEST_READ_BYTES);
        Some((self.cursor, most))
    }

    /// When something falls due.
    pub(crate) fn poll_timeout(&mut self, step: &mut Step<'_>) -> MonoTime {
        let mut due = self.next_heartbeat;
        if let Some(records) = self.records_due(step) {
            due = due.min(records);
        }
        if self.live_is_first {
            due = step.now.mono;
        } else if (self.cursor < step.spool.next || step.growth.is_refused()) && step.live.is_fresh() {
            // Whether the lane lags by then is not known now.
            due = due.min(self.next_live.max(step.now.mono + LIVE_LOOK_EVERY));
        }
        due
    }

    /// What the spool has from the cursor on, as messages.
    pub(crate) fn entries(&mut self, step: &Step<'_>, from: u64, entries: Vec<Entry>) -> Vec<Bytes> {
        if self.asked != Some(from) {
            return Vec::new();
        }
        (self.asked, self.waits_since) = (None, None);
        let (before, mut messages, mut run) = (self.cursor, Vec::new(), Run::default());
        for entry in entries {
            // Numbers that were left out are missing on the disk.
            let start = match &entry {
                Entry::Record(record) => record.seq,
                Entry::Gap(gap) => gap.from,
            };
            if start > self.cursor {
                self.flush(step, &mut run, &mut messages);
                let time = self.cursor_recorded.unwrap_or(step.now.utc);
                let (from, reason) = (self.cursor, GapReason::Damaged);
                self.gap(
                    step,
                    Gap { from, to: start, since: time, until: step.now.utc, reason },
                    &mut messages,
                );
            }
            match entry {
                Entry::Record(record) if record.seq == self.cursor => {
                    if run.bytes + record.packet.len() + 16 > MAX_BATCH_RAW_BYTES / 2 {
                        self.flush(step, &mut run, &mut messages);
                    }
                    self.cursor += 1;
                    self.cursor_recorded = Some(record.recorded);
                    run.push(record);
                }
                Entry::Gap(gap) if gap.to > self.cursor => {
                    self.flush(step, &mut run, &mut messages);
                    self.gap(step, Gap { from: self.cursor, ..gap }, &mut messages);
                }
                Entry::Record(_) | Entry::Gap(_) => {}
            }
        }
        self.flush(step, &mut run, &mut messages);
        if self.cursor == before {
            self.not_before = step.now.mono + SPOOL_RETRY;
        }
        messages
    }

    fn flush(&mut self, step: &Step<'_>, run: &mut Run, messages: &mut Vec<Bytes>) {
        let Some(first) = run.records.first() else { return };
        let records = run.records.iter().map(|record| (record.recorded, &record.packet[..]));
        let batch = self.packer.pack(first.seq, records);
        let message = message(&Frame::Records(batch));
        self.unkept.sent(step.now.mono, self.cursor, message.len());
        messages.push(message);
        *run = Run::default();
    }

    fn gap(&mut self, step: &Step<'_>, gap: Gap, messages: &mut Vec<Bytes>) {
        self.cursor = gap.to;
        let message = message(&Frame::Gap(gap));
        self.unkept.sent(step.now.mono, gap.to, message.len());
        messages.push(message);
    }

    /// The shore says how far it is; answers whether more is durable, or `None` when it cannot be that far.
    pub(crate) fn ack(&mut self, now: MonoTime, ack: Ack, keeping: &mut Latency) -> Option<bool> {
        if ack.durable > ack.received || ack.received > self.cursor {
            return None;
        }
        if ack.durable <= self.durable {
            return Some(false);
        }
        self.durable = ack.durable;
        if let Some(took) = self.unkept.kept(now, ack.durable) {
            self.last_kept = took;
            keeping.add(took);
        }
        Some(true)
    }
}

/// Records with consecutive numbers, for one batch.
#[derive(Debug, Default)]
struct Run {
    records: Vec<Record>,
    bytes: usize,
}

impl Run {
    fn push(&mut self, record: Record) {
        self.bytes += record.packet.len() + 16;
        self.records.push(record);
    }
}
