//! A world in which a vessel and a shore talk: connections like TCP's over a network that is cut, stalls and
//! resets, two processes that are killed and keep what is on their disks, and clocks that disagree. Everything
//! follows from one seed.

pub(crate) mod chance;
pub(crate) mod chart;
pub(crate) mod network;
pub(crate) mod shore;
pub(crate) mod vessel;

use bytes::Bytes;
use chance::Chance;
use imc::messages::EstimatedState;
use imc::{Address, Header, Packet};
use link::{ConnectionId, WaySettings};
use network::{Direction, Network, Path};
use shore::ShoreNode;
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};
use vessel::VesselNode;

pub(crate) const SECOND: u64 = 1_000_000;
const EPOCH_US: i64 = 1_790_000_000_000_000;

/// An event at a time.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Event {
    /// The vessel says the next packet.
    Say,
    VesselTimer,
    ShoreTimer,
    /// Both ends of a connection learn of it.
    Connected(u64),
    ConnectFailed(u64),
    Deliver(u64, Direction),
    /// An end learns that its connection is gone: the vessel's (down) or the shore's (up).
    Gone(u64, Direction),
    Commit,
    /// The vessel's disk has done what the chart needs.
    ChartDisk,
    Fault(Fault),
    VesselStarts,
    ShoreStarts,
    Command,
}

/// A fault, and for how long (µs).
#[derive(Debug, Clone, Copy)]
pub(crate) enum Fault {
    Cut(u64),
    /// Only one way.
    CutUp(u64),
    CutDown(u64),
    /// One of the ways.
    CutWay(usize, u64),
    CutWayUp(usize, u64),
    CutWayDown(usize, u64),
    /// One of the ways connects, and carries nothing: a box on the way answers in the shore's place.
    MuteWay(usize, u64),
    /// One of the ways takes so long in one direction from now on.
    Delay(usize, u64),
    KillVessel(u64),
    /// The vessel's program stalls, and then continues.
    Stall(u64),
    KillShore(u64),
    /// All connections break and both ends are informed.
    Reset,
    DiskFull(u64),
    /// Bytes a second, and for how long.
    Slow(u64, u64),
    /// The vessel's UTC is set by so many µs.
    StepClock(i64),
    /// A message comes twice.
    Duplicate,
    /// A message overtakes the previous one.
    Swap,
    /// The shore has another chart of so many bytes.
    NewChart(u64),
    /// A part of it is read with a wrong byte.
    CorruptChart,
}

pub(crate) struct World {
    pub(crate) now_us: u64,
    sequence: u64,
    queue: BTreeMap<(u64, u64), Event>,
    pub(crate) chance: Chance,
    pub(crate) network: Network,
    pub(crate) vessel: VesselNode,
    pub(crate) shore: ShoreNode,
    say_every_us: u64,
    pub(crate) said: u64,
    say_until_us: u64,
    command_every_us: Option<u64>,
    vessel_utc_us: i64,
}

impl World {
    pub(crate) fn new(seed: u64, say_every_us: u64, budget: Option<u32>) -> Self {
        let mut world = Self {
            now_us: 10 * SECOND,
            sequence: 0,
            queue: BTreeMap::new(),
            chance: Chance::new(seed),
            network: Network::default(),
            vessel: VesselNode::new(budget),
            shore: ShoreNode::default(),
            say_every_us,
            said: 0,
            say_until_us: u64::MAX,
            command_every_us: None,
            vessel_utc_us: 3_700_000,
        };
        world.at(0, Event::ShoreStarts);
        world.at(1000, Event::VesselStarts);
        world.at(2000, Event::Say);
        world
    }

    /// With as many ways as there are paths.
    pub(crate) fn with_ways(mut self, ways: Vec<WaySettings>, paths: Vec<Path>) -> Self {
        (self.vessel.ways, self.network.paths) = (ways, paths);
        self
    }

    pub(crate) fn with_commands(mut self, every_us: u64) -> Self {
        self.command_every_us = Some(every_us);
        self.at(every_us, Event::Command);
        self
    }

    /// Schedules an event this much later.
    pub(crate) fn at(&mut self, after_us: u64, event: Event) {
        self.sequence += 1;
        self.queue.insert((self.now_us + after_us, self.sequence), event);
    }

    pub(crate) fn run(&mut self, for_us: u64) {
        let until = self.now_us + for_us;
        self.run_until(until, |_| false);
    }

    /// Runs until `done`, or panics after so long.
    pub(crate) fn run_to(&mut self, within_us: u64, what: &str, done: impl Fn(&Self) -> bool) -> u64 {
        let start = self.now_us;
        assert!(self.run_until(start + within_us, done), "not {what} within {within_us} us");
        self.now_us - start
    }

    fn run_until(&mut self, until_us: u64, done: impl Fn(&Self) -> bool) -> bool {
        while !done(self) {
            match self.queue.first_key_value() {
                Some(((at, _), _)) if *at <= until_us => {
                    let ((at, _), event) = self.queue.pop_first().unwrap();
                    self.now_us = at;
                    self.happen(event);
                }
                _ => {
                    self.now_us = until_us;
                    return false;
                }
            }
        }
        true
    }

    pub(crate) fn stop_saying(&mut self) {
        self.say_until_us = self.now_us;
        self.command_every_us = None;
    }

    /// The vessel's clocks; its steady one starts again with its program.
    pub(crate) fn vessel_now(&self) -> Now {
        Now {
            mono: MonoTime::from_micros(self.now_us - self.vessel.started_us + 1),
            utc: UtcTime::from_micros(EPOCH_US + self.now_us as i64 + self.vessel_utc_us),
        }
    }

    pub(crate) fn shore_now(&self) -> Now {
        Now {
            mono: MonoTime::from_micros(self.now_us - self.shore.started_us + 77 * SECOND),
            utc: UtcTime::from_micros(EPOCH_US + self.now_us as i64),
        }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Say if self.now_us < self.say_until_us => {
                if self.vessel.machine.is_some() {
                    let packet = packet(self.said, self.now_us);
                    self.said += 1;
                    self.vessel_says(&packet);
                }
                self.at(self.say_every_us, Event::Say);
            }
            Event::Say => {}
            Event::VesselTimer => self.vessel_timer(),
            Event::ShoreTimer => self.shore_timer(),
            Event::Connected(id) => self.connected(id),
            Event::ConnectFailed(id) => self.connect_failed(id),
            Event::Deliver(id, direction) => self.deliver(id, direction),
            Event::Gone(id, direction) => self.gone(id, direction),
            Event::Commit => self.shore_commits(),
            Event::ChartDisk => self.chart_disk_answers(),
            Event::Fault(fault) => self.fault(fault),
            Event::VesselStarts => self.vessel_starts(),
            Event::ShoreStarts => self.shore_starts(),
            Event::Command => {
                self.shore_commands();
                if let Some(every) = self.command_every_us {
                    self.at(every, Event::Command);
                }
            }
        }
    }

    fn fault(&mut self, fault: Fault) {
        match fault {
            Fault::Cut(us) => {
                self.network.cut(Direction::Up, self.now_us + us);
                self.network.cut(Direction::Down, self.now_us + us);
            }
            Fault::CutUp(us) => self.network.cut(Direction::Up, self.now_us + us),
            Fault::CutDown(us) => self.network.cut(Direction::Down, self.now_us + us),
            Fault::CutWay(way, us) => {
                self.network.cut_way(way, Direction::Up, self.now_us + us);
                self.network.cut_way(way, Direction::Down, self.now_us + us);
            }
            Fault::CutWayUp(way, us) => self.network.cut_way(way, Direction::Up, self.now_us + us),
            Fault::CutWayDown(way, us) => self.network.cut_way(way, Direction::Down, self.now_us + us),
            Fault::MuteWay(way, us) => self.network.paths[way].mute_until = self.now_us + us,
            Fault::Delay(way, us) => {
                let way = way % self.network.paths.len();
                self.network.paths[way].delay_us = us;
            }
            Fault::KillVessel(us) => {
                if self.vessel.machine.take().is_some() {
                    self.hang_up(Direction::Down);
                    self.at(us, Event::VesselStarts);
                }
            }
            Fault::Stall(us) => self.vessel_stalls(us),
            Fault::KillShore(us) => {
                if self.shore.machine.take().is_some() {
                    self.shore.pending.clear();
                    self.hang_up(Direction::Up);
                    self.at(us, Event::ShoreStarts);
                }
            }
            Fault::Reset => {
                for id in self.network.ids() {
                    self.at(0, Event::Gone(id, Direction::Up));
                    self.at(0, Event::Gone(id, Direction::Down));
                }
            }
            Fault::DiskFull(us) => self.shore.disk_full_until_us = self.now_us + us,
            Fault::Slow(rate, us) => {
                let until = self.now_us + us;
                self.network.paths.iter_mut().for_each(|path| path.slow = (rate, until));
            }
            Fault::StepClock(us) => self.vessel_utc_us += us,
            Fault::Duplicate => self.network.duplicate_next = true,
            Fault::Swap => self.network.swap_next = true,
            Fault::NewChart(bytes) => self.publish(bytes),
            Fault::CorruptChart => self.shore.chart.corrupt_next = true,
        }
    }

    /// The records on the shore's disk are those that the vessel sent: each once, none missing.
    pub(crate) fn check_everything_arrived(&self) {
        assert_eq!(self.shore.kept.len() as u64, self.said, "each packet once");
        let mut numbers = self.shore.kept.iter();
        for (number, told) in self.vessel.told.iter().enumerate() {
            let (seq, kept) = numbers.next().unwrap();
            assert_eq!((*seq, kept), (number as u64, &packet(number as u64, *told)));
        }
    }

    /// The number of sent packets that the shore's disk lacks.
    pub(crate) fn missing(&self) -> u64 {
        self.said - self.shore.kept.len() as u64
    }
}

/// The packet of this number, sent at this time.
fn packet(number: u64, at_us: u64) -> Bytes {
    // Measured values are noise in their lower digits, which is what compression meets at sea.
    let mut chance = Chance::new(number + 1);
    let mut noisy = |scale: f32| scale * (1.0 + chance.below(1 << 20) as f32 / (1 << 20) as f32);
    let state = EstimatedState {
        lat: 1.1,
        lon: 0.18,
        height: noisy(40.0),
        x: noisy(100.0),
        y: noisy(-30.0),
        psi: noisy(1.0),
        phi: noisy(0.01),
        theta: noisy(0.02),
        u: noisy(1.2),
        v: noisy(0.1),
        vx: noisy(1.0),
        vy: noisy(0.4),
        r: noisy(0.02),
        ..EstimatedState::default()
    };
    let header = Header { timestamp: at_us as f64, src: Address(0x2810), ..Header::default() };
    Packet::new(header, state).encode().unwrap().into()
}

/// When a packet was sent (µs).
pub(crate) fn said_at(packet: &[u8]) -> u64 {
    imc::PacketView::new(packet).unwrap().timestamp() as u64
}

pub(crate) fn connection(id: u64) -> ConnectionId {
    ConnectionId(id)
}

pub(crate) fn micros(time: Duration) -> u64 {
    time.as_micros() as u64
}
