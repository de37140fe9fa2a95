//! An open connection: what is sent over it when, and what comes back.

use super::records::{InFlight, LagTracker};
use super::{Entry, SpoolState};
use crate::clocks::Clocks;
use crate::frame::{Ack, Capabilities, Frame, Gap, GapReason, Heartbeat, Welcome, message};
use crate::live::LiveSet;
use crate::pace::Pace;
use crate::ways::Thinning;
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
/// After a switch, records alone for so long.
const RECORDS_FIRST: Duration = Duration::from_millis(500);
const LIVE_LOOK_EVERY: Duration = Duration::from_millis(25);
const LIVE_FIRST_BYTES: usize = 64 << 10;
const LIVE_BYTES: usize = 16 << 10;
const LEAST_LIVE_BYTES: usize = 1 << 10;

/// State of an open connection.
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
    /// The number that the shore last acknowledged over this connection.
    received: u64,
    unkept: InFlight,
    next_live: MonoTime,
    live_is_first: bool,
    last_kept: Duration,
}

/// The lanes that a connection carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lanes {
    pub(crate) live: bool,
    pub(crate) records: bool,
    /// The number that the record lane is at; `None` where it is on no way.
    pub(crate) records_at: Option<u64>,
    pub(crate) thinning: Thinning,
    /// The interval of heartbeats.
    pub(crate) beat: Duration,
}

/// The context of a step.
pub(crate) struct Step<'a> {
    pub(crate) lanes: Lanes,
    /// Counts live messages where the vessel has several ways.
    pub(crate) live_number: Option<&'a mut u64>,
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
            received: welcome.resume,
            unkept: InFlight::default(),
            next_live: now,
            live_is_first: true,
            last_kept: Duration::ZERO,
        }
    }

    /// Records go by this connection from now on, from the number that the shore acknowledged over it.
    pub(crate) fn take_records(&mut self) {
        self.cursor = self.received;
        self.unkept = InFlight::default();
        (self.asked, self.waits_since) = (None, None);
    }

    /// Records go by another.
    pub(crate) fn leave_records(&mut self) {
        (self.asked, self.waits_since) = (None, None);
    }

    /// Live values go by this connection from now on. After a switch records come again in their order by it, and what is
    /// newer must not come before them: live values wait a moment, and go where records still lag then.
    pub(crate) fn take_live(&mut self, now: MonoTime, is_switch: bool, with_records: bool) {
        self.live_is_first = !is_switch;
        self.next_live = if is_switch && with_records { now + RECORDS_FIRST } else { now };
        self.next_heartbeat = self.next_heartbeat.min(now + HEARTBEAT);
    }

    /// The outputs that are due: messages to send, and where the spool is to be read.
    pub(crate) fn step(&mut self, step: &mut Step<'_>) -> (Vec<Bytes>, Option<(u64, usize)>) {
        let mut messages = Vec::new();
        if step.now.mono >= self.next_heartbeat {
            self.next_heartbeat = step.now.mono + step.lanes.beat;
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
        if !step.lanes.live {
            return None;
        }
        let due = self.live_is_first || (now >= self.next_live && self.lags(step) && step.pace.room() > 0);
        if !self.capabilities.has(Capabilities::LIVE) {
            self.live_is_first = false;
            return None;
        }
        if !due {
            return None;
        }
        let thinning = step.lanes.thinning;
        let most = if self.live_is_first && step.live_number.is_none() {
            LIVE_FIRST_BYTES
        } else {
            // Three quarters of the budget at most, so that the records always move.
            self.budget_bytes_per_s.map_or(LIVE_BYTES, |rate| {
                let share = u64::from(rate) * 3 / 4 * LIVE_EVERY.as_millis() as u64 / 1000;
                (share as usize).clamp(LEAST_LIVE_BYTES, LIVE_BYTES)
            })
        };
        self.live_is_first = false;
        self.next_live = now + thinning.live_every().unwrap_or(LIVE_EVERY);
        let mut batch = step.live.take(now, most, &mut self.packer, thinning)?;
        if let Some(number) = &mut step.live_number {
            **number += 1;
            batch.first = **number;
        }
        Some(message(&Frame::Live(batch)))
    }

    /// Whether records lag, by whatever way they go.
    fn lags(&self, step: &Step<'_>) -> bool {
        let at = if step.lanes.records { Some(self.cursor) } else { step.lanes.records_at };
        at.is_none_or(|at| step.growth.lags(step.now.mono, at))
    }

    /// When records may be asked for; `None` while nothing that time brings would allow it.
    fn records_due(&mut self, step: &mut Step<'_>) -> Option<MonoTime> {
        let now = step.now.mono;
        if !step.lanes.records || self.asked.is_some() || self.cursor >= step.spool.next {
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
        if !step.lanes.live {
            return due;
        }
        let at = if step.lanes.records { Some(self.cursor) } else { step.lanes.records_at };
        let waits = at.is_none_or(|at| at < step.spool.next) || step.growth.is_refused();
        if self.live_is_first {
            due = step.now.mono;
        } else if waits && step.live.is_fresh(step.lanes.thinning) {
            // Whether the lane lags by then is not known now.
            due = due.min(self.next_live.max(step.now.mono + LIVE_LOOK_EVERY));
        }
        due
    }

    /// The spool's records from the cursor on, as messages.
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

    /// The shore says how far it is; answers whether more is durable, or `None` when it cannot be that far. `most` is
    /// what was sent over other connections.
    pub(crate) fn ack(&mut self, now: MonoTime, ack: Ack, most: u64, keeping: &mut Latency) -> Option<bool> {
        if ack.durable > ack.received || ack.received > self.cursor.max(most) {
            return None;
        }
        self.received = self.received.max(ack.received);
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
