//! The real process over real sockets on loopback, with ports chosen by the system.
//!
//! Nothing sleeps to let things settle: every wait is for a packet or a line, with a deadline.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use imc::lsf::{LogItem, LogReader};
use imc::messages::*;
use imc::{Address, Deframer, Frame, Header, Packet, Payload};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const OTTER: Address = Address(0x2810);
const CONSOLE: Address = Address(0x4001);
const DEADLINE: Duration = Duration::from_secs(30);

/// The program, its folder, and the ports it chose.
struct Agent {
    child: Child,
    out: BufReader<ChildStdout>,
    udp: u16,
    tcp: u16,
    announce: u16,
}

fn ini() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("etc/otter.ini")
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_lutra-agent"))
}

impl Agent {
    fn start(folder: &Path, more: &[&str]) -> Self {
        let config = folder.join("otter.ini");
        if !config.exists() {
            std::fs::copy(ini(), &config).unwrap();
        }
        let mut child = program()
            .arg("run")
            .arg(&config)
            .arg("--data")
            .arg(folder)
            .args(["--bind", "127.0.0.1", "--udp-port", "0", "--tcp-port", "0", "--announce-port", "0"])
            .arg("--quiet")
            .args(more)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        let port = |name: &str| {
            let found = line.split_whitespace().find_map(|word| word.strip_prefix(&format!("{name}=")));
            found.unwrap_or_else(|| panic!("{line}")).parse().unwrap()
        };
        let (udp, tcp, announce) = (port("udp"), port("tcp"), port("announce"));
        Self { child, out, udp, tcp, announce }
    }

    /// Ends it as an init system does; answers what it printed last.
    fn terminate(mut self) -> String {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        let mut rest = String::new();
        self.out.read_to_string(&mut rest).unwrap();
        assert!(self.child.wait().unwrap().success());
        rest
    }
}

impl std::ops::Drop for Agent {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// A console on a stream.
struct Console {
    stream: TcpStream,
    deframer: Deframer,
    beat: Instant,
    request: u16,
    seen: Vec<Packet>,
}

impl Console {
    fn connect(agent: &Agent) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", agent.tcp)).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        let (deframer, seen) = (Deframer::new(), Vec::new());
        Self { stream, deframer, beat: Instant::now(), request: 0, seen }
    }

    fn send(&mut self, message: impl Into<Message>) {
        self.stream.write_all(&packet(message)).unwrap();
    }

    /// Reads until something is what is wanted.
    fn wait<T>(&mut self, what: &str, mut wanted: impl FnMut(&Packet) -> Option<T>) -> T {
        let until = Instant::now() + DEADLINE;
        while Instant::now() < until {
            if self.beat.elapsed() > Duration::from_millis(800) {
                self.beat = Instant::now();
                self.send(Heartbeat);
            }
            let mut buffer = [0; 8192];
            match self.stream.read(&mut buffer) {
                Ok(0) => panic!("{what}: the agent hung up"),
                Ok(length) => self.deframer.push(&buffer[..length]),
                Err(_) => {}
            }
            while let Some(frame) = self.deframer.next_frame() {
                let Frame::Packet { view, .. } = frame else { panic!("{what}: damage on the stream") };
                let packet = Packet::decode(view.bytes()).unwrap();
                if let Some(found) = wanted(&packet) {
                    return found;
                }
                self.seen.push(packet);
            }
        }
        panic!("{what}: not within {DEADLINE:?}; last: {:?}", self.seen.last());
    }

    fn wait_for<T: Payload + Clone>(&mut self, what: &str, mut wanted: impl FnMut(&T) -> bool) -> T {
        self.wait(what, |packet| packet.get::<T>().filter(|message| wanted(message)).cloned())
    }

    fn ready(&mut self) {
        self.wait_for::<VehicleState>("service", |state| state.op_mode == VehicleStateOpMode::Service);
    }

    fn ask(&mut self, op: PlanControlOp, plan_id: &str, arg: Option<Message>) -> u16 {
        self.request += 1;
        self.send(PlanControl {
            r#type: PlanControlType::Request,
            op,
            request_id: self.request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            ..PlanControl::default()
        });
        self.request
    }

    fn start(&mut self, plan_id: &str, arg: Option<Message>) {
        let request = self.ask(PlanControlOp::Start, plan_id, arg);
        self.wait_for::<PlanControl>("executing", |reply| {
            let ours = reply.request_id == request && reply.r#type != PlanControlType::Request;
            assert!(!ours || reply.r#type == PlanControlType::Success, "{reply:?}");
            ours && reply.info.to_str_lossy().ends_with("executing maneuver")
        });
    }

    fn database(&mut self, op: PlanDBOp, plan_id: &str, arg: Option<Message>) -> PlanDB {
        self.request += 1;
        let request = self.request;
        self.send(PlanDB {
            r#type: PlanDBType::Request,
            op,
            request_id: request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            ..PlanDB::default()
        });
        self.wait_for::<PlanDB>("plan database", |reply| {
            reply.request_id == request && matches!(reply.r#type, PlanDBType::Success | PlanDBType::Failure)
        })
    }
}

fn packet(message: impl Into<Message>) -> Vec<u8> {
    let header = Header { src: CONSOLE, dst: OTTER, ..Header::default() };
    Packet::new(header, message).encode().unwrap()
}

fn far_plan() -> PlanSpecification {
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

#[test]
fn a_scripted_mission_from_outside() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &["--record", folder.path().join("run.rec").to_str().unwrap()]);
    let mut console = Console::connect(&agent);
    console.ready();

    let reply = console.database(PlanDBOp::Set, "far", Some(far_plan().into()));
    let Some(information) = reply.arg.of::<PlanDBInformation>() else { panic!("{reply:?}") };
    assert_eq!(information.md5, imc::plan_digest::plan_md5(&far_plan()).unwrap());
    console.start("far", None);
    console.wait_for::<EstimatedState>("way on", |state| state.u > 0.5);

    let follow =
        FollowReference { control_src: 0xFFFF, control_ent: 0xFF, timeout: 30.0, ..Default::default() };
    console.start("follow", Some(follow.into()));
    console.send(Reference {
        flags: ReferenceFlags::LOCATION,
        lat: 63.335_f64.to_radians(),
        lon: 10.08_f64.to_radians(),
        ..Reference::default()
    });
    console.wait_for::<FollowRefState>("following", |state| state.state == FollowRefStateState::Goto);

    console.start("teleoperation-mode", Some(Teleoperation { custom: "src=16385".into() }.into()));
    console.send(RemoteActions { actions: "Port Motor=-64;Starboard Motor=-64".into() });
    console.wait_for::<SetThrusterActuation>("astern", |set| set.value < -0.4);

    console.send(SetEntityParameters {
        name: "Path Control".into(),
        params: [EntityParameter { name: "ILOS Lookahead Distance".into(), value: "13".into() }]
            .into_iter()
            .collect(),
    });
    console.wait_for::<EntityParameters>("parameter", |set| set.name == "Path Control");
    console.send(SaveEntityParameters { name: "Path Control".into() });
    console.send(Abort);
    console.wait_for::<Aborted>("aborted", |_| true);
    console.wait_for::<VehicleState>("service again", |state| state.op_mode == VehicleStateOpMode::Service);
    let saved = std::fs::read_to_string(folder.path().join("ntnu-otter-01-saved.ini")).unwrap();
    assert!(saved.contains("ILOS Lookahead Distance") && saved.contains("13"), "{saved}");

    let last = agent.terminate();
    assert!(last.starts_with("motors stopped"), "{last}");
    let replay = program().arg("replay").arg(folder.path().join("run.rec")).output().unwrap();
    let text = String::from_utf8_lossy(&replay.stdout).into_owned();
    assert!(
        replay.status.success() && text.contains("identical"),
        "{text}{}",
        String::from_utf8_lossy(&replay.stderr)
    );
}

#[test]
fn its_times_do_not_lag_by_the_time_it_took_to_start() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    let mut late = f64::INFINITY;
    // The best of some: other programs may hold up any one of them.
    for _ in 0..30 {
        let made = console
            .wait("estimate", |packet| packet.get::<EstimatedState>().map(|_| packet.header.timestamp));
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        late = late.min(now.as_secs_f64() - made);
    }
    assert!((-0.005..0.05).contains(&late), "{late} s");
}

#[test]
fn a_console_in_contact_by_datagrams() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(DEADLINE)).unwrap();
    let port = socket.local_addr().unwrap().port();
    let announce = Announce {
        sys_name: "console".into(),
        services: format!("imc+udp://127.0.0.1:{port}/").into(),
        ..Announce::default()
    };
    let header = Header { src: CONSOLE, dst: Address::ANNOUNCE, ..Header::default() };
    let announcement = Packet::new(header, announce).encode().unwrap();
    socket.send_to(&announcement, ("127.0.0.1", agent.announce)).unwrap();
    let mut buffer = vec![0; 65_536];
    let mut heard = std::collections::BTreeSet::new();
    let until = Instant::now() + DEADLINE;
    socket
        .send_to(
            &packet(EntityList { op: EntityListOp::Query, ..Default::default() }),
            ("127.0.0.1", agent.udp),
        )
        .unwrap();
    while !["EstimatedState", "VehicleState", "PlanControlState", "EntityList"]
        .iter()
        .all(|name| heard.contains(name))
    {
        assert!(Instant::now() < until, "{heard:?}");
        let (length, _) = socket.recv_from(&mut buffer).unwrap();
        let packet = Packet::decode(&buffer[..length]).unwrap();
        heard.extend(packet.message().map(Message::abbrev));
    }
}

#[test]
fn killed_in_a_plan_it_comes_back_safe_with_its_plans_and_a_readable_log() {
    let folder = TempDir::new().unwrap();
    let mut agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    console.database(PlanDBOp::Set, "far", Some(far_plan().into()));
    console.start("far", None);
    // Two flushes of the log: what came before the last is on the disk.
    console.wait_for::<EstimatedState>("way on", |state| state.x.hypot(state.y) > 12.0);
    agent.child.kill().unwrap();
    agent.child.wait().unwrap();

    let mut names = std::collections::BTreeSet::new();
    for log in logs(&folder.path().join("logs")) {
        let mut reader = LogReader::open(&log).unwrap();
        // A log that was cut ends in damage or an error, after all that is whole.
        while let Ok(Some(item)) = reader.next_item() {
            if let LogItem::Packet { view, .. } = item {
                names.extend(Packet::decode(view.bytes()).unwrap().message().map(Message::abbrev));
            }
        }
    }
    for name in ["PlanSpecification", "EstimatedState", "DesiredPath", "SetThrusterActuation"] {
        assert!(names.contains(name), "{name} of {names:?}");
    }

    let agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    let reply = console.database(PlanDBOp::GetState, "", None);
    let Some(state) = reply.arg.of::<PlanDBState>() else { panic!("{reply:?}") };
    let plan = state.plans_info.of::<PlanDBInformation>().next().unwrap();
    assert_eq!(plan.md5, imc::plan_digest::plan_md5(&far_plan()).unwrap());
    assert_eq!(plan.change_sid, CONSOLE.0);
    let idle = console.wait_for::<PlanControlState>("idle", |_| true);
    assert_eq!(idle.state, PlanControlStateState::Ready);
    let moving = console.seen.iter().filter_map(|packet| packet.get::<SetThrusterActuation>());
    assert_eq!(moving.filter(|set| set.value != 0.0).count(), 0, "nothing moves after a restart");
}

fn logs(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(logs(&path));
        } else if path.ends_with("Data.lsf.gz") {
            found.push(path);
        }
    }
    found
}

#[test]
fn two_simulations_record_the_same_bytes_and_replay() {
    let folder = TempDir::new().unwrap();
    let mut recordings = Vec::new();
    for name in ["a", "b"] {
        let path = folder.path().join(name);
        let out = program()
            .args(["simulate", "--every", "0", "--current", "0.3,90", "--wind", "4,200", "--record"])
            .arg(&path)
            .output()
            .unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        recordings.push(std::fs::read(&path).unwrap());
    }
    assert!(recordings[0] == recordings[1]);
    assert!(program().arg("replay").arg(folder.path().join("a")).status().unwrap().success());
    // One flipped bit in the middle is noticed.
    let middle = recordings[0].len() / 2;
    recordings[0][middle] ^= 1;
    let path = folder.path().join("damaged");
    std::fs::write(&path, &recordings[0]).unwrap();
    assert!(!program().arg("replay").arg(&path).stderr(Stdio::null()).status().unwrap().success());
}

#[test]
fn the_committed_plans_sail_and_draw_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let plans = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/plans");
    for (name, wanted) in [("leg", "RMS"), ("square", "outside a turn"), ("station", "inside 100.0 %")] {
        let (plan, svg) = (plans.join(format!("{name}.json")), folder.path().join(name));
        let out = program()
            .args(["simulate", "--every", "0", "--gnss-error", "1,0", "--plan"])
            .arg(plan)
            .arg("--svg")
            .arg(&svg)
            .output()
            .unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let svg = std::fs::read_to_string(svg).unwrap();
        assert!(svg.contains(wanted) && svg.ends_with("</svg>\n") && svg.len() < 150_000, "{name}");
    }
}

#[test]
fn checks_the_shipped_configuration_and_refuses_a_broken_one() {
    let good = program().arg("check").arg(ini()).output().unwrap();
    assert!(good.status.success(), "{}", String::from_utf8_lossy(&good.stdout));
    let json = program().arg("check").arg(ini()).arg("--json").output().unwrap();
    assert!(serde_json::from_slice::<serde_json::Value>(&json.stdout).is_ok());
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("bad.ini");
    std::fs::write(&path, "[Require nowhere.ini]\n[Control.Path.ILOS]\nILOS Lookahead Distance = far\n")
        .unwrap();
    let bad = program().arg("check").arg(&path).output().unwrap();
    assert_eq!(bad.status.code(), Some(1));
}

#[test]
fn the_bare_hull_answers_as_the_reference() {
    let out =
        program().args(["simulate", "--open-loop", "60,60", "--until", "30", "--csv", "-"]).output().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    let last: Vec<f64> = text.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    // facts/onboard.md 6.2: 1.0287 m/s at 60/60 rad/s.
    assert!((last[1] - 1.0287).abs() < 0.002, "{last:?}");
    assert_eq!(text.lines().count(), 32);
}
