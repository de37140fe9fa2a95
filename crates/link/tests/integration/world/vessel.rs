//! The vessel in the world: its disk survives, its program does not.

use super::chart::ChartAtSea;
use super::network::Direction;
use super::{Event, SECOND, World};
use bytes::Bytes;
use link::{
    Answer, Entry, Gap, GapReason, Record, SpoolState, Used, Vessel, VesselInput, VesselOutput,
    VesselSettings, WaySettings, WaysReport,
};
use std::collections::BTreeMap;
use units::UtcTime;

const STREAM: u64 = 4711;

#[derive(Debug)]
pub(crate) struct VesselNode {
    pub(crate) machine: Option<Vessel>,
    pub(crate) started_us: u64,
    budget: Option<u32>,
    starts: u64,
    /// On disk: packets with the time they were recorded.
    spool: BTreeMap<u64, (UtcTime, Bytes)>,
    next: u64,
    timer_us: u64,
    /// Its program does nothing until then; what happens meanwhile waits.
    stalled_until_us: u64,
    waiting: Vec<VesselInput>,
    /// It looks so much later than it should.
    pub(crate) late_us: u64,
    /// When each packet was sent (µs).
    pub(crate) told: Vec<u64>,
    /// Commands that were delivered: identity and world time.
    pub(crate) delivered: Vec<(u64, u64)>,
    /// So many of them by earlier starts.
    delivered_before: usize,
    pub(crate) ways: Vec<WaySettings>,
    /// The bytes that each way had carried, as on the disk.
    used: Vec<Used>,
    next_used_us: u64,
    /// When which way carried what.
    pub(crate) switches: Vec<(u64, WaysReport)>,
    pub(crate) chart: ChartAtSea,
}

impl VesselNode {
    pub(crate) fn new(budget: Option<u32>) -> Self {
        Self {
            machine: None,
            started_us: 0,
            budget,
            starts: 0,
            spool: BTreeMap::new(),
            next: 0,
            timer_us: u64::MAX,
            stalled_until_us: 0,
            waiting: Vec::new(),
            late_us: 0,
            told: Vec::new(),
            delivered: Vec::new(),
            delivered_before: 0,
            ways: Vec::new(),
            used: Vec::new(),
            next_used_us: 0,
            switches: Vec::new(),
            chart: ChartAtSea::default(),
        }
    }

    fn state(&self) -> SpoolState {
        let first = self.spool.first_key_value().map_or(self.next, |(seq, _)| *seq);
        SpoolState { stream: STREAM, first, next: self.next }
    }

    fn read(&self, from: u64, most: usize) -> Vec<Entry> {
        let first = self.state().first;
        if from < first {
            let time = UtcTime::default();
            let reason = GapReason::AcknowledgedBefore;
            return vec![Entry::Gap(Gap { from, to: first, since: time, until: time, reason })];
        }
        let mut bytes = 0;
        let records = self.spool.range(from..).map(|(seq, (recorded, packet))| Record {
            seq: *seq,
            recorded: *recorded,
            packet: packet.clone(),
        });
        records
            .take_while(|record| {
                let before = bytes;
                bytes += record.packet.len();
                before < most
            })
            .map(Entry::Record)
            .collect()
    }

    fn configured(&self) -> Vec<WaySettings> {
        let mut ways = self.ways.clone();
        for (way, used) in ways.iter_mut().zip(&self.used) {
            way.used = *used;
        }
        ways
    }

    /// Keeps from time to time what the ways have carried.
    fn keep_used(&mut self, now_us: u64) {
        if now_us >= self.next_used_us {
            self.next_used_us = now_us + 10 * SECOND;
            self.used = self.machine.as_ref().map(Vessel::used).unwrap_or_default();
        }
    }

    /// Forgets what the shore has, as a disk does that forgets whole files.
    fn forget(&mut self, below: u64) {
        self.spool = self.spool.split_off(&(below / 500 * 500));
    }
}

impl World {
    pub(crate) fn vessel_starts(&mut self) {
        self.vessel.started_us = self.now_us;
        self.vessel.starts += 1;
        (self.vessel.stalled_until_us, self.vessel.timer_us) = (0, u64::MAX);
        self.vessel.waiting.clear();
        self.vessel.delivered_before = self.vessel.delivered.len();
        let settings = VesselSettings {
            address: 0x2810,
            name: "ntnu-otter-01".to_owned(),
            software: "test".to_owned(),
            incarnation: self.vessel.starts,
            seed: self.vessel.starts,
            budget_bytes_per_s: self.vessel.budget,
            spool: self.vessel.state(),
            ways: self.vessel.configured(),
        };
        self.vessel.machine = Some(Vessel::new(self.vessel_now(), settings));
        self.tell_chart_aboard();
        self.vessel_handle(VesselInput::Timer);
    }

    pub(crate) fn vessel_says(&mut self, packet: &Bytes) {
        let recorded = self.vessel_now().utc;
        self.vessel.spool.insert(self.vessel.next, (recorded, packet.clone()));
        self.vessel.next += 1;
        self.vessel.told.push(self.now_us);
        let state = self.vessel.state();
        self.vessel_handle(VesselInput::Live(packet.clone()));
        self.vessel_handle(VesselInput::Spool(state));
    }

    pub(crate) fn vessel_timer(&mut self) {
        if self.now_us >= self.vessel.timer_us {
            self.vessel.timer_us = u64::MAX;
            self.vessel_handle(VesselInput::Timer);
        }
    }

    pub(crate) fn vessel_stalls(&mut self, for_us: u64) {
        self.vessel.stalled_until_us = self.now_us + for_us;
        self.vessel.timer_us = self.vessel.stalled_until_us;
        self.at(for_us, Event::VesselTimer);
    }

    /// Events of a stall come after the time is read, as in the driver, which reads its sockets later.
    pub(crate) fn vessel_handle(&mut self, input: VesselInput) {
        if self.now_us < self.vessel.stalled_until_us {
            return self.vessel.waiting.push(input);
        }
        if !self.vessel.waiting.is_empty() {
            self.vessel_handle_now(VesselInput::Timer);
            for waited in std::mem::take(&mut self.vessel.waiting) {
                self.vessel_handle_now(waited);
            }
        }
        self.vessel_handle_now(input);
    }

    fn vessel_handle_now(&mut self, input: VesselInput) {
        // Connections of an earlier start have numbers of their own in this world.
        let Some(input) = self.vessel_number(input) else { return };
        let now = self.vessel_now();
        let Some(machine) = &mut self.vessel.machine else { return };
        machine.handle(now, input);
        self.vessel.keep_used(self.now_us);
        while let Some(output) = self.vessel.machine.as_mut().and_then(Vessel::poll_output) {
            self.vessel_does(output);
        }
        let due = self.vessel.machine.as_mut().and_then(|machine| machine.poll_timeout(now));
        if let Some(due) = due {
            let at = self.now_us + super::micros(due.since(now.mono)).max(100) + self.vessel.late_us;
            if at < self.vessel.timer_us {
                self.vessel.timer_us = at;
                self.at(at - self.now_us, Event::VesselTimer);
            }
        }
    }

    fn vessel_does(&mut self, output: VesselOutput) {
        match output {
            VesselOutput::Open(id, way, patience) => {
                let id = self.world_number(id.0);
                self.connect(id, way, patience);
            }
            VesselOutput::Send(id, bytes) => {
                let id = self.world_number(id.0);
                self.transmit(id, Direction::Up, bytes);
            }
            VesselOutput::Close(id, _) => {
                let id = self.world_number(id.0);
                self.close(id, Direction::Down);
            }
            VesselOutput::Need(from, most) => {
                let entries = self.vessel.read(from, most);
                self.vessel_handle(VesselInput::Entries(from, entries));
            }
            VesselOutput::Acknowledged(next) => {
                assert!(self.shore.durable().is_some_and(|seq| seq + 1 >= next), "only what is on its disk");
                self.vessel.forget(next);
                let state = self.vessel.state();
                self.vessel_handle(VesselInput::Spool(state));
            }
            VesselOutput::Renumber => panic!("no number is given out twice when only programs die"),
            VesselOutput::Command { id, expires, .. } => {
                assert!(self.vessel_now().mono < expires);
                let this_start = &self.vessel.delivered[self.vessel.delivered_before..];
                assert!(
                    this_start.iter().all(|(before, _)| *before != id),
                    "command {id} is carried out twice"
                );
                if self.vessel.ways.len() > 1 {
                    assert!(
                        this_start.iter().all(|(before, _)| *before < id),
                        "command {id} is out of order"
                    );
                }
                self.vessel.delivered.push((id, self.now_us));
                self.vessel_handle(VesselInput::Answer(id, Answer::Received));
            }
            VesselOutput::ChartBegin(offer) => self.chart_begins(offer),
            VesselOutput::ChartPart { digest, offset, bytes } => {
                self.chart_part_came(&digest, offset, &bytes);
            }
            VesselOutput::Switched(report) => self.vessel.switches.push((self.now_us, report)),
            VesselOutput::Answered(receipt) => assert_eq!(receipt.order, receipt.id, "as the world orders"),
            VesselOutput::Up(_) | VesselOutput::Lease(_) | VesselOutput::Came { .. } => {}
        }
    }

    /// Connections by start and number in one number.
    fn world_number(&self, id: u64) -> u64 {
        self.vessel.starts * 1_000_000 + id
    }

    fn vessel_number(&self, input: VesselInput) -> Option<VesselInput> {
        let own = |id: link::ConnectionId| {
            (id.0 / 1_000_000 == self.vessel.starts).then_some(link::ConnectionId(id.0 % 1_000_000))
        };
        Some(match input {
            VesselInput::Opened(id) => VesselInput::Opened(own(id)?),
            VesselInput::Failed(id, why) => VesselInput::Failed(own(id)?, why),
            VesselInput::Message(id, bytes) => VesselInput::Message(own(id)?, bytes),
            VesselInput::Closed(id) => VesselInput::Closed(own(id)?),
            other => other,
        })
    }
}
