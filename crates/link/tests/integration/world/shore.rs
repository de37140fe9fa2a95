//! The shore in the world: what it committed survives, the rest does not.

use super::chart::ChartAshore;
use super::network::Direction;
use super::{Event, SECOND, World, said_at};
use bytes::Bytes;
use link::{Outcome, Shore, ShoreInput, ShoreOutput, ShoreSettings};
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
    /// When the newest packet known ashore was said (µs).
    pub(crate) newest_us: u64,
    pub(crate) commands: u64,
    /// Identity to the time it was given (µs), its time to live and what became of it.
    pub(crate) asked: BTreeMap<u64, (u64, Duration, Option<Outcome>)>,
    pub(crate) ups: u64,
    pub(crate) chart: ChartAshore,
}

impl ShoreNode {
    pub(crate) fn durable(&self) -> Option<u64> {
        // Nothing is kept with holes, so the last tells.
        self.kept.last_key_value().map(|(seq, _)| *seq)
    }
}

impl World {
    pub(crate) fn shore_starts(&mut self) {
        self.shore.started_us = self.now_us;
        self.shore.timer_us = u64::MAX;
        self.shore.machine = Some(Shore::new(ShoreSettings::default()));
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
        let Some(machine) = &mut self.shore.machine else { return };
        machine.handle(now, input);
        while let Some(output) = self.shore.machine.as_mut().and_then(Shore::poll_output) {
            self.shore_does(output);
        }
        let due = self.shore.machine.as_ref().and_then(Shore::poll_timeout);
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
                    self.shore.newest_us = self.shore.newest_us.max(said_at(&record.packet));
                    self.shore.pending.push((record.seq, record.packet));
                }
                self.plan_commit();
            }
            ShoreOutput::Live(records) => {
                for record in records {
                    self.shore.newest_us = self.shore.newest_us.max(said_at(&record.packet));
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
            ShoreOutput::Down => {}
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
        self.shore_handle(ShoreInput::Command { id, ttl, lease: 0, overtakes: false, packet });
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
