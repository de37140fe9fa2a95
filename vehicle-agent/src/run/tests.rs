//! The loop with its own clocks: nothing here waits for real time.

use super::*;
use crate::hull::Simulated;
use crate::net::Event;
use crate::{Arguments, Command};
use clap::Parser as _;
use imc::lsf::{LogItem, LogReader};
use imc::messages::*;
use imc::{Address, Header, Packet};
use std::path::Path;
use std::sync::Mutex;
use testkit::sea::{Ground, Sea};
use units::{LatLon, LocalFrame, LocalPoint, UtcTime};

const STEP: Duration = Duration::from_millis(50);
const RECORDING: &str = "run.recording";
const PEER: Peer = Peer::Tcp(1);

struct Bench {
    agent: Agent<Simulated>,
    elapsed: Arc<Mutex<Duration>>,
    /// Offset of the computer's clock from true time (µs).
    ahead_us: Arc<Mutex<i64>>,
    /// Whether the next reading of the clock panics.
    broken: Arc<Mutex<bool>>,
    folder: tempfile::TempDir,
}

fn get<T: Copy>(value: &Mutex<T>) -> T {
    *value.lock().unwrap()
}

impl Bench {
    fn new() -> Self {
        Self::with("", false)
    }

    /// With more configuration, and optionally a recording.
    fn with(more: &str, records: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("otter.ini");
        std::fs::write(&config, format!("{}\n{more}", crate::OTTER_INI)).unwrap();
        let line = ["lutra-agent", "run", "otter.ini", "--bind", "127.0.0.1", "--udp-port", "0"];
        let data = ["--tcp-port", "0", "--announce-port", "0", "--data", folder.path().to_str().unwrap()];
        let record = folder.path().join(RECORDING);
        let record = if records { vec!["--record", record.to_str().unwrap()] } else { vec![] };
        let line = line.into_iter().chain(data).chain(record);
        let Command::Run(arguments) = Arguments::parse_from(line).command else { panic!() };
        let (elapsed, ahead_us) = (Arc::new(Mutex::new(Duration::ZERO)), Arc::new(Mutex::new(0)));
        let (of_elapsed, of_utc, of_ahead) =
            (Arc::clone(&elapsed), Arc::clone(&elapsed), Arc::clone(&ahead_us));
        let broken = Arc::new(Mutex::new(false));
        let of_broken = Arc::clone(&broken);
        let clock = Clock::of(
            move || {
                assert!(!get(&of_broken), "a clock that breaks");
                get(&of_elapsed)
            },
            move || {
                let since_us = get(&of_utc).as_micros() as i64 + get(&of_ahead);
                UtcTime::from_micros(1_790_000_000_000_000 + since_us)
            },
        );
        let agent =
            Agent::start(&arguments, setup::load(&config, "Simulation").unwrap(), clock, simulated).unwrap();
        let mut bench = Self { agent, elapsed, ahead_us, broken, folder };
        bench.agent.take(Event::Connected(1));
        bench
    }

    /// Lets time pass, step by step.
    fn pass(&mut self, span: Duration) {
        let until = get(&self.elapsed) + span;
        while get(&self.elapsed) < until {
            *self.elapsed.lock().unwrap() += STEP;
            self.agent.catch_up();
            self.agent.each_second();
            while let Some(event) = self.agent.net.inbox.take(Duration::ZERO) {
                self.agent.take(event);
            }
        }
    }

    /// The same, waiting each second for the disk, as a recording ends if the disk is too slow.
    fn pass_recorded(&mut self, span: Duration) {
        for _ in 0..span.as_secs() {
            self.pass(SECOND);
            let now = self.agent.vehicle.now;
            self.agent.disk.hand(Work::Tick(now.mono, now.utc));
            loop {
                let event = self.agent.net.inbox.take(Duration::from_secs(30)).unwrap();
                let has_caught_up = matches!(event, Event::Disk(Done::Host(_)));
                self.agent.take(event);
                if has_caught_up {
                    break;
                }
            }
        }
    }

    fn send(&mut self, message: impl Into<Message>) {
        let header = Header { src: Address(0x4001), dst: Address(0x2810), ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        self.agent.take(Event::Packet(PEER, packet));
    }

    /// Whether this plan is stored as under way.
    fn has_under_way(&self, plan_id: &str) -> bool {
        let kept = std::fs::read(self.folder.path().join("under-way.imc")).unwrap_or_default();
        kept.windows(plan_id.len()).any(|bytes| bytes == plan_id.as_bytes())
    }

    fn shafts(&self) -> f64 {
        let shafts = self.agent.vehicle.hull.vessel.truth().state.shaft_radps;
        shafts.port.abs() + shafts.starboard.abs()
    }

    /// Ends the agent; returns all packets of its logs.
    fn end(self) -> Vec<Packet> {
        self.agent.end(&Ending::default()).unwrap();
        logged(&self.folder)
    }
}

fn logged(folder: &tempfile::TempDir) -> Vec<Packet> {
    let mut packets = Vec::new();
    read(&folder.path().join("logs"), &mut packets);
    packets
}

fn read(folder: &Path, packets: &mut Vec<Packet>) {
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            read(&path, packets);
        } else if path.ends_with("Data.lsf.gz") {
            let mut log = LogReader::open(&path).unwrap();
            while let Some(item) = log.next_item().unwrap() {
                let LogItem::Packet { view, .. } = item else { panic!("damage") };
                packets.push(Packet::decode(view.bytes()).unwrap());
            }
        }
    }
}

fn plan() -> PlanSpecification {
    let goto = Goto {
        lat: 63.34_f64.to_radians(),
        lon: 10.083_333_f64.to_radians(),
        z_units: ZUnits::Depth,
        speed: 1.5,
        ..Goto::default()
    };
    let node = PlanManeuver { maneuver_id: "go".into(), data: goto.into(), ..PlanManeuver::default() };
    PlanSpecification {
        plan_id: "far".into(),
        start_man_id: "go".into(),
        maneuvers: [node].into_iter().collect(),
        ..PlanSpecification::default()
    }
}

fn start() -> PlanControl {
    PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        plan_id: "far".into(),
        arg: plan().into(),
        ..PlanControl::default()
    }
}

#[test]
fn a_clock_that_is_set_is_noticed_in_words_states_and_times() {
    let mut bench = Bench::new();
    bench.pass(Duration::from_secs(10));
    *bench.ahead_us.lock().unwrap() = 3_600_000_000;
    bench.pass(Duration::from_secs(10));
    let packets = bench.end();
    let entries: Vec<String> = packets
        .iter()
        .filter_map(|packet| packet.get::<LogBookEntry>())
        .map(|entry| entry.text.to_str_lossy().into_owned())
        .collect();
    let told = entries.iter().filter(|text| text.contains("the clock was set by +3600.0 s"));
    assert_eq!(told.count(), 1, "{entries:?}");
    let off = packets.iter().filter_map(|packet| packet.get::<EntityState>()).any(|state| {
        state.state == EntityStateState::Fault
            && state.description.to_str_lossy().contains("s off the satellites")
    });
    assert!(off, "the clock's state tells that it is off the satellites");
    let seconds: Vec<f64> = packets
        .iter()
        .filter(|packet| packet.get::<EstimatedState>().is_some())
        .map(|packet| packet.header.timestamp - 1_790_000_000.0)
        .collect();
    assert!(seconds.iter().all(|at| (0.0..=10.1).contains(at) || (3610.0..=3620.1).contains(at)));
    assert!(seconds.iter().filter(|at| **at > 3600.0).count() > 20);
}

#[test]
fn a_vessel_whose_loop_hangs_loses_its_thrust_and_goes_on_afterwards() {
    let mut bench = Bench::new();
    // The watchdog uses the computer's clock, and a loaded machine may delay the test.
    bench.agent.vehicle.hull.obey_at_once();
    bench.pass(Duration::from_secs(5));
    bench.send(start());
    bench.pass(Duration::from_secs(10));
    let sailing = bench.shafts();
    assert!(sailing > 20.0, "{sailing}");
    // A long step: the plan would have continued, but without control.
    *bench.elapsed.lock().unwrap() += Duration::from_millis(1500);
    bench.agent.catch_up();
    assert!(bench.shafts() < 0.1 * sailing, "{} of {sailing}", bench.shafts());
    bench.pass(Duration::from_secs(10));
    assert!(bench.shafts() > 0.5 * sailing, "{} of {sailing}", bench.shafts());
    bench.end();
}

#[test]
fn a_log_that_was_asked_for_without_end_neither_holds_the_loop_up_nor_loses_the_log() {
    if testkit::is_emulated() {
        let why = "the end of many logs within the 10 s that the program gives its disk: 8 s alone, more beside other tests";
        return testkit::absent(testkit::Need::Native, why);
    }
    let mut bench = Bench::new();
    bench.pass(Duration::from_secs(5));
    for _ in 0..200 {
        let name = "again".into();
        bench.send(LoggingControl { op: LoggingControlOp::RequestStart, name });
    }
    bench.send(start());
    bench.pass(Duration::from_secs(30));
    let packets = bench.end();
    let opened = packets
        .iter()
        .filter_map(|packet| packet.get::<LoggingControl>())
        .filter(|control| control.op == LoggingControlOp::Started);
    let opened = opened.count();
    assert!((3..=16).contains(&opened), "{opened} logs");
    assert!(packets.iter().any(|packet| packet.get::<PlanControl>().is_some()));
}

#[test]
fn a_panic_of_the_loop_stops_the_motors_closes_the_log_and_is_told() {
    let mut bench = Bench::new();
    bench.pass(Duration::from_secs(5));
    bench.send(start());
    let running = (0..60).any(|_| {
        bench.pass(SECOND);
        bench.shafts() > 20.0
    });
    assert!(running);
    *bench.broken.lock().unwrap() = true;
    let Bench { agent, folder, .. } = bench;
    let gate = Arc::clone(&agent.gate);
    let usual = std::panic::take_hook();
    let outcome = agent.run(&Ending::default());
    std::panic::set_hook(usual);
    assert!(outcome.unwrap_err().is::<Fault>());
    assert!(gate.has_ended());
    let packets = logged(&folder);
    let end = packets.last().and_then(|packet| packet.get::<LoggingControl>()).unwrap();
    assert_eq!(end.op, LoggingControlOp::Stopped);
}

/// The route comes from the planning thread, after some real time; the answer is in the recording. Takes some seconds: half
/// a minute of the whole agent, recorded, and again.
#[test]
fn a_vessel_that_hears_nobody_returns_by_a_route_and_that_is_replayed() {
    let middle = LatLon::from_deg(63.33, 10.083_333).unwrap();
    let land = (0..12).map(|n| LocalPoint { north_m: 150.0, east_m: 60.0 - 80.0 * f64::from(n) });
    let chart = land.fold(Sea::new(middle, 1_200.0, 20.0), |sea, at| sea.with(Ground::Land, at, 60.0, 24));
    let charts = tempfile::tempdir().unwrap();
    let path = charts.path().join("chart.lutra-index");
    std::fs::write(&path, chart.index().to_bytes()).unwrap();
    let more = format!(
        "[Supervisors.Grounding]\nChart = {}\n[Supervisors.ASV.LostComms]\nLost Comms Timeout = 5\nAction During Plan = return\n",
        path.display()
    );
    let mut bench = Bench::with(&more, true);
    bench.pass_recorded(Duration::from_secs(10));
    let place = |north_m, east_m| LocalFrame::new(middle).to_place(LocalPoint { north_m, east_m });
    let named = |plan_id: &str, at: LatLon| {
        let goto = Goto { lat: at.lat_rad(), lon: at.lon_rad(), speed: 1.5, ..Goto::default() };
        let node = PlanManeuver {
            maneuver_id: "go".into(),
            data: Message::from(goto).into(),
            ..PlanManeuver::default()
        };
        PlanSpecification {
            plan_id: plan_id.into(),
            start_man_id: "go".into(),
            maneuvers: [node].into_iter().collect(),
            ..PlanSpecification::default()
        }
    };
    let home = named("lost_comms", place(300.0, 0.0));
    bench.send(PlanDB {
        op: PlanDBOp::Set,
        plan_id: "lost_comms".into(),
        arg: home.into(),
        ..PlanDB::default()
    });
    bench.send(PlanControl {
        plan_id: "far".into(),
        arg: named("far", place(0.0, -600.0)).into(),
        ..start()
    });
    // The thread needs real time: the vessel's own time advances meanwhile.
    let begun = std::time::Instant::now();
    let mut returns = false;
    while !returns && begun.elapsed() < Duration::from_mins(1) {
        bench.pass_recorded(SECOND);
        returns = bench.has_under_way("lost_comms");
    }
    assert!(returns);
    bench.pass_recorded(Duration::from_secs(5));
    let Bench { agent, folder, .. } = bench;
    agent.end(&Ending::default()).unwrap();
    let entries = logged(&folder).into_iter().filter_map(|packet| packet.get::<LogBookEntry>().cloned());
    let told = |entry: &LogBookEntry| entry.text.to_str_lossy().contains("returning by a route of");
    assert_eq!(entries.filter(told).count(), 1);
    let replayed = crate::disk::recording::replay(&folder.path().join(RECORDING)).unwrap();
    assert!(replayed.outputs > 1_000 && !replayed.cut, "{replayed:?}");
}
