//! The shore in the world: what it committed survives, the rest does not.

use super::chart::ChartAshore;
use super::network::Direction;
use super::{Event, SECOND, World, said_at};
use bytes::Bytes;
use link::frame::{self, Frame};
use link::{Capabilities, Hello, Outcome, Shore, ShoreInput, ShoreOutput, ShoreSettings, WaysReport};
use std::collections::BTreeMap;
use std::time::Duration;

#[derive(Debug, Default)]
pub(crate) struct ShoreNode {
    pub(crate) machine: Option<Shore>,
    pub(crate) started_us: u64,
    timer_us: u64,
    pub(crate) disk_full_until_us: u64,
    commit_planned: bool,
    /// Received, not on disk.
    pub(crate) pending: Vec<(u64, Bytes)>,
    /// On disk, by number.
    pub(crate) kept: BTreeMap<u64, Bytes>,
    stream: u64,
    /// Packets that came again after they were received.
    pub(crate) repeated: u64,
    /// When the newest packet known ashore was sent (µs).
    pub(crate) newest_us: u64,
    pub(crate) commands: u64,
    /// Identity to the time it was given (µs), its time to live and its outcome.
    pub(crate) asked: BTreeMap<u64, (u64, Duration, Option<Outcome>)>,
    pub(crate) ups: u64,
    starts: u64,
    /// The last record given since the link is open.
    last_given: Option<u64>,
    last_live_us: u64,
    pub(crate) ways: Option<WaysReport>,
    /// It is of a version that knows nothing of ways.
    pub(crate) is_older: bool,
    /// When the newest value came last, and the longest time without a newer one (µs), since it was set to zero.
    heard_us: u64,
    pub(crate) longest_gap_us: u64,
    /// Records that came after a live value that was sent later.
    pub(crate) overtaken: u64,
    pub(crate) chart: ChartAshore,
}

impl ShoreNode {
    pub(crate) fn durable(&self) -> Option<u64> {
        // Nothing is kept with holes, so the last number is enough.
        self.kept.last_key_value().map(|(seq, _)| *seq)
    }
}

impl World {
    pub(crate) fn shore_starts(&mut self) {
        self.shore.started_us = self.now_us;
        self.shore.timer_us = u64::MAX;
        (self.shore.last_given, self.shore.last_live_us) = (None, 0);
        self.shore.starts += 1;
        self.shore.machine =
            Some(Shore::new(ShoreSettings { run: self.shore.starts, ..ShoreSettings::default() }));
        self.offer();
    }

    pub(crate) fn shore_timer(&mut self) {
        if self.now_us >= self.shore.timer_us {
            self.shore.timer_us = u64::MAX;
            self.shore_handle(ShoreInput::Timer);
        }
    }

    pub(crate) fn shore_handle(&mut self, input: ShoreInput) {
        let now = self.shore_now();
        let input = if self.shore.is_older { as_read_by_an_older_shore(input) } else { input };
        let Some(machine) = &mut self.shore.machine else { return };
        machine.handle(now, input);
        while let Some(output) = self.shore.machine.as_mut().and_then(Shore::poll_output) {
            self.shore_does(output);
        }
        let due = self.shore.machine.as_ref().and_then(|shore| shore.poll_timeout(now));
        if let Some(due) = due {
            let at = self.now_us + super::micros(due.since(now.mono)).max(100);
            if at < self.shore.timer_us {
                self.shore.timer_us = at;
                self.at(at - self.now_us, Event::ShoreTimer);
            }
        }
    }

    fn shore_does(&mut self, output: ShoreOutput) {
        match output {
            ShoreOutput::Send(id, bytes) => self.transmit(id.0, Direction::Down, bytes),
            ShoreOutput::Close(id, ..) => self.close(id.0, Direction::Up),
            ShoreOutput::Hello(id, hello) => {
                self.shore.stream = hello.stream;
                let durable = self.shore.durable();
                self.shore_handle(ShoreInput::Resume(id, durable));
            }
            ShoreOutput::Records { records, .. } => {
                for record in records {
                    assert!(
                        self.shore.last_given.is_none_or(|last| record.seq == last + 1),
                        "once, and in order"
                    );
                    self.shore.last_given = Some(record.seq);
                    self.heard(said_at(&record.packet));
                    self.shore.pending.push((record.seq, record.packet));
                }
                self.plan_commit();
            }
            ShoreOutput::Live(records) => {
                for record in records {
                    let at_us = said_at(&record.packet);
                    if self.vessel.ways.len() > 1 {
                        assert!(at_us >= self.shore.last_live_us, "no older value after a newer one");
                    }
                    self.shore.last_live_us = at_us;
                    self.heard(at_us);
                }
            }
            ShoreOutput::Gap { gap, .. } => panic!("nothing is lost here: {gap:?}"),
            ShoreOutput::Outcome(id, outcome) => {
                let slot = &mut self.shore.asked.get_mut(&id).unwrap().2;
                assert_eq!(slot.replace(outcome), None, "one outcome for each command");
            }
            ShoreOutput::Up(_) => self.shore.ups += 1,
            ShoreOutput::ChartPart(id, ask) => self.shore_reads(id, ask),
            ShoreOutput::ChartReport(report) => self.shore.chart.report = Some(report),
            ShoreOutput::Ways(report) => self.shore.ways = Some(report),
            ShoreOutput::Down => self.shore.last_given = None,
            ShoreOutput::Sent { .. } | ShoreOutput::Stray(_) => {}
        }
    }

    /// A value that was sent then is ashore.
    fn heard(&mut self, said_us: u64) {
        self.shore.overtaken += u64::from(said_us < self.shore.newest_us);
        if said_us > self.shore.newest_us {
            let gap_us = self.now_us - self.shore.heard_us;
            self.shore.longest_gap_us = self.shore.longest_gap_us.max(gap_us);
            (self.shore.newest_us, self.shore.heard_us) = (said_us, self.now_us);
        }
    }

    fn plan_commit(&mut self) {
        if !self.shore.commit_planned {
            self.shore.commit_planned = true;
            let after = self.chance.between(5_000, 250_000);
            self.at(after, Event::Commit);
        }
    }

    pub(crate) fn shore_commits(&mut self) {
        self.shore.commit_planned = false;
        if self.shore.machine.is_none() {
            return;
        }
        if self.shore.disk_full_until_us > self.now_us {
            return self.plan_commit();
        }
        for (seq, packet) in std::mem::take(&mut self.shore.pending) {
            // As the store does: what has a known number is dropped, and nothing comes out of order.
            let next = self.shore.durable().map_or(0, |seq| seq + 1);
            assert!(seq <= next, "a hole before {seq}");
            if seq == next {
                self.shore.kept.insert(seq, packet);
            } else {
                assert_eq!(self.shore.kept[&seq], packet);
                self.shore.repeated += 1;
            }
        }
        if let Some(seq) = self.shore.durable() {
            self.shore_handle(ShoreInput::Durable { stream: self.shore.stream, seq });
        }
    }

    pub(crate) fn shore_commands(&mut self) {
        if self.shore.machine.is_none() {
            return;
        }
        self.shore.commands += 1;
        let id = self.shore.commands;
        let ttl = Duration::from_millis(self.chance.between(100, 20_000));
        self.shore.asked.insert(id, (self.now_us, ttl, None));
        let packet = Bytes::from(id.to_le_bytes().to_vec());
        self.shore_handle(ShoreInput::Command { id, ttl, lease: 0, order: id, overtakes: false, packet });
    }

    /// No command came late or twice, and each outcome is true.
    pub(crate) fn check_commands(&self) {
        let mut delivered = BTreeMap::new();
        for (id, at_us) in &self.vessel.delivered {
            let (asked_us, ttl, _) = &self.shore.asked[id];
            assert!(*at_us <= asked_us + super::micros(*ttl), "command {id} came late");
            *delivered.entry(*id).or_insert(0) += 1;
        }
        for (id, (asked_us, _, outcome)) in &self.shore.asked {
            match outcome {
                Some(Outcome::Received) => assert!(delivered.contains_key(id)),
                Some(Outcome::Expired | Outcome::Refused(_)) => assert!(!delivered.contains_key(id), "{id}"),
                Some(Outcome::Unanswered) => {}
                // Its shore was killed, or it is still young.
                None => assert!(*asked_us < self.shore.started_us || self.now_us - asked_us < 30 * SECOND),
            }
        }
    }
}

/// A greeting without what an older shore does not read of it.
fn as_read_by_an_older_shore(input: ShoreInput) -> ShoreInput {
    match input {
        ShoreInput::Message(id, bytes) => match frame::decode(bytes.clone()).unwrap().next() {
            Some(Ok(Frame::Hello(hello))) => {
                let capabilities = hello.capabilities.and(Capabilities(15));
                let hello = Hello { capabilities, way: None, ..hello };
                ShoreInput::Message(id, frame::message(&Frame::Hello(hello)))
            }
            _ => ShoreInput::Message(id, bytes),
        },
        other => other,
    }
}
