//! Faults of disk, network, terminal and people, with the real process.

use crate::common::{Agent, Console, DEADLINE, far_plan, ini, logs, packet, program};
use imc::lsf::{LogItem, LogReader};
use imc::messages::*;
use imc::{Address, Header, Packet};
use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use tempfile::TempDir;

/// A small disk, where the system permits one.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(at: PathBuf, size: &str) -> Option<Self> {
        std::fs::create_dir_all(&at).unwrap();
        let options = format!("size={size}");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &options, "tmpfs"]).arg(&at).output();
        match mounted {
            Ok(output) if output.status.success() => Some(Self(at)),
            Ok(output) => {
                testkit::absent(testkit::Need::Mount, String::from_utf8_lossy(&output.stderr).trim());
                None
            }
            Err(error) => {
                testkit::absent(testkit::Need::Mount, &error.to_string());
                None
            }
        }
    }
}

impl std::ops::Drop for SmallDisk {
    fn drop(&mut self) {
        Command::new("umount").arg("--lazy").arg(&self.0).status().ok();
    }
}

#[test]
fn a_full_disk_stops_the_log_and_no_vessel() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let Some(disk) = SmallDisk::mount(data.clone(), "3m") else { return };
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), &config).unwrap();
    let agent = Agent::spawn(program().arg("run").arg(&config).arg("--quiet"), &data, &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    assert_eq!(console.database(PlanDBOp::Set, "far", Some(far_plan().into())).r#type, PlanDBType::Success);
    console.start("far", None);

    // Another file fills all free space.
    let fill = data.join("fill");
    let mut file = std::fs::File::create(&fill).unwrap();
    while file.write_all(&[1; 4096]).is_ok() {}
    while file.write_all(&[1]).is_ok() {}
    let logger = onboard::Entity::Logger.number();
    let is = |packet: &Packet, wanted: EntityStateState| {
        let state = packet.get::<EntityState>().filter(|_| packet.header.src_ent == logger)?;
        (state.state == wanted).then(|| state.description.to_str_lossy().into_owned())
    };
    let why = console.wait("the log's end", |packet| is(packet, EntityStateState::Error));
    assert!(why.contains("no log is written"), "{why}");
    // It sails on, and a plan that cannot be kept is refused rather than half kept.
    console.wait_for::<EstimatedState>("way on", |state| state.u > 1.0);
    let mut other = far_plan();
    other.plan_id = "other".into();
    let refused = console.database(PlanDBOp::Set, "other", Some(other.into()));
    assert_eq!(refused.r#type, PlanDBType::Failure, "{refused:?}");
    assert!(!refused.info.is_empty());

    drop(file);
    std::fs::remove_file(&fill).unwrap();
    let retried = Instant::now();
    // The next attempt is due within half a minute, the limit of one wait: so wait twice.
    let well = |packet: &Packet| is(packet, EntityStateState::Normal);
    let first = console.wait("a new log", |packet| match packet.get::<EntityState>() {
        Some(_) => well(packet).map(Some),
        None => (retried.elapsed() > DEADLINE * 2 / 3).then_some(None),
    });
    if first.is_none() {
        console.wait("a new log, later", well);
    }
    let state = console.wait_for::<PlanControlState>("the plan", |_| true);
    assert_eq!(state.state, PlanControlStateState::Executing);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));

    let (plans, parts): (Vec<_>, Vec<_>) = std::fs::read_dir(data.join("plans"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .partition(|path| path.extension().is_some_and(|extension| extension == "plan"));
    assert_eq!((plans.len(), parts.len()), (1, 0), "{plans:?} {parts:?}");
    drop(disk);
}

#[test]
fn twenty_mistakes_are_told_at_once_and_start_nothing() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    let mut text = std::fs::read_to_string(ini()).unwrap();
    let mut mistakes = vec!["[Transports.UDP]", "Local Port = ninety", "Contact Timeout = -1"];
    mistakes.extend(["Dynamic Nodes = maybe", "Rate Limiters = EstimatedState:fast", "[Control.Path.ILOS]"]);
    mistakes.extend(["Control Frequency = 1e9", "Course Control = yes", "Maximum Track Length = long"]);
    mistakes.extend([
        "State Report Frequency = 0",
        "Corridor -- Width = wide",
        "[Navigation.General.GPSNavigation]",
    ]);
    mistakes.extend(["Maximum HDOP = 0", "GPS Timeout = soon", "GPS has Yaw = perhaps"]);
    mistakes.extend(["Position Jump Speed = 0", "[Transports.Announce]", "Announcement Periodicity = 0"]);
    mistakes.extend(["Multicast Address = everyone", "Ports = 70000", "System Type = SUBMARINE"]);
    mistakes.extend(["[Transports.Logging]", "LSF Compression Method = best", "Flush Interval = 0"]);
    mistakes.extend(["[Transports.TCP.Server]", "Port = 0"]);
    for line in &mistakes {
        text.push_str(line);
        text.push('\n');
    }
    std::fs::write(&config, text).unwrap();
    let out = program().arg("run").arg(&config).arg("--data").arg(folder.path()).output().unwrap();
    let told = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{told}");
    let wrong: Vec<_> = mistakes.iter().filter_map(|line| line.split_once(" = ")).collect();
    assert_eq!(wrong.len(), 20);
    for (name, value) in wrong {
        assert!(told.lines().any(|line| line.contains(name) || line.contains(value)), "{name}: {told}");
    }
    assert!(!folder.path().join("plans").exists(), "nothing was begun");
}

#[test]
fn motors_stop_when_the_console_is_gone() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let mut watcher = Console::connect(&agent);
    watcher.ready();
    let mut operator = Console::connect(&agent);
    operator.start("teleoperation-mode", Some(Teleoperation { custom: "src=16385".into() }.into()));
    operator.send(RemoteActions { actions: "Port Motor=64;Starboard Motor=64".into() });
    watcher.wait_for::<SetThrusterActuation>("ahead", |set| set.value > 0.4);
    drop(operator);
    watcher.wait_for::<SetThrusterActuation>("a stop", |set| set.value == 0.0);
    agent.terminate();
}

/// Sends heartbeats as fast as the other side accepts them, until `stop` or a closed connection.
fn flood(port: u16, stop: &Arc<AtomicBool>) -> std::thread::JoinHandle<()> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    let (beats, stop) = (packet(Heartbeat).repeat(1000), Arc::clone(stop));
    std::thread::spawn(move || while !stop.load(Ordering::Relaxed) && stream.write_all(&beats).is_ok() {})
}

#[test]
fn an_abort_comes_through_a_flood() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    console.start("far", Some(far_plan().into()));
    console.wait_for::<EstimatedState>("way on", |state| state.u > 0.5);

    let stop = Arc::new(AtomicBool::new(false));
    let floods = [flood(agent.tcp[0], &stop), flood(agent.tcp[0], &stop)];
    // By datagrams, without acknowledgement, as a broadcast, from a new console.
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let header = Header { src: Address(0x4002), dst: Address::BROADCAST, ..Header::default() };
    let abort = Packet::new(header, Abort).encode().unwrap();
    socket.send_to(&abort, ("127.0.0.1", agent.udp)).unwrap();
    console.wait_for::<Aborted>("aborted", |_| true);
    console.wait_for::<SetThrusterActuation>("a stop", |set| set.value == 0.0);
    console.wait_for::<VehicleState>("service", |state| state.op_mode == VehicleStateOpMode::Service);
    // Others are served meanwhile, and a flooding client may abort too.
    console.start("far", None);
    let mut loud = TcpStream::connect(("127.0.0.1", agent.tcp[0])).unwrap();
    loud.write_all(&packet(Heartbeat).repeat(50_000)).unwrap();
    loud.write_all(&packet(Abort)).unwrap();
    console.wait_for::<Aborted>("aborted again", |_| true);
    // The termination works as well.
    let last = agent.terminate();
    stop.store(true, Ordering::Relaxed);
    for flood in floods {
        flood.join().unwrap();
    }
    assert!(last.starts_with("motors stopped, log closed"), "{last}");
}

#[test]
fn a_client_that_does_not_read_is_disconnected_with_a_word() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), &config).unwrap();
    let mut command = program();
    command.arg("run").arg(&config).stderr(Stdio::piped());
    let mut agent = Agent::spawn(&mut command, folder.path(), &[]);
    let mut words = BufReader::new(agent.child.stderr.take().unwrap()).lines();
    let deaf = TcpStream::connect(("127.0.0.1", agent.tcp[0])).unwrap();
    // The client that does not read gets answers to others: the list of entities, repeatedly.
    let mut asker = TcpStream::connect(("127.0.0.1", agent.tcp[0])).unwrap();
    let query = packet(EntityList { op: EntityListOp::Query, ..Default::default() }).repeat(500);
    let mut reader = asker.try_clone().unwrap();
    let reading = std::thread::spawn(move || std::io::copy(&mut reader, &mut std::io::sink()).ok());
    let asking = std::thread::spawn(move || while asker.write_all(&query).is_ok() {});
    let port = deaf.local_addr().unwrap().port().to_string();
    let said = words.any(|line| {
        let line = line.unwrap();
        line.contains(&port) && line.contains("disconnected")
    });
    assert!(said);
    agent.signal("TERM");
    // Its output is still read.
    let rest = std::thread::spawn(move || words.count());
    assert!(agent.ended().starts_with("motors stopped"));
    asking.join().unwrap();
    reading.join().unwrap();
    rest.join().unwrap();
}

/// Packets of the logs, oldest first.
fn logged(folder: &Path) -> Vec<Packet> {
    let mut all = logs(&folder.join("logs"));
    all.sort();
    let mut packets = Vec::new();
    for log in all {
        let mut reader = LogReader::open(&log).unwrap();
        while let Some(item) = reader.next_item().unwrap() {
            let LogItem::Packet { view, .. } = item else { panic!("damage in {}", log.display()) };
            packets.push(Packet::decode(view.bytes()).unwrap());
        }
    }
    packets
}

#[test]
fn a_signal_in_the_middle_of_work_stops_motors_first_and_closes_the_log() {
    for signal in ["TERM", "HUP", "INT"] {
        let folder = TempDir::new().unwrap();
        let agent = Agent::start(folder.path(), &[]);
        let mut console = Console::connect(&agent);
        console.ready();
        console.start("far", Some(far_plan().into()));
        console.wait_for::<SetThrusterActuation>("ahead", |set| set.value > 0.1);
        for _ in 0..200 {
            console.send(LoggingControl { op: LoggingControlOp::RequestStart, name: "more".into() });
        }
        agent.signal(signal);
        let last = agent.ended();
        assert!(last.starts_with("motors stopped, log closed"), "{signal}: {last}");
        let packets = logged(folder.path());
        let mut running = [true; 2];
        for set in packets.iter().filter_map(|packet| packet.get::<SetThrusterActuation>()) {
            running[usize::from(set.id)] = set.value != 0.0;
        }
        assert_eq!(running, [false; 2], "{signal}: what the motors were told last");
        let Some(end) = packets.last().and_then(|packet| packet.get::<LoggingControl>()) else { panic!() };
        assert_eq!(end.op, LoggingControlOp::Stopped);
    }
}

#[test]
fn a_folder_in_use_is_refused_by_a_code_of_its_own() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let config = folder.path().join("otter.ini");
    let second = program().arg("run").arg(&config).arg("--data").arg(folder.path()).output().unwrap();
    let told = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(3), "{told}");
    assert!(told.contains(&format!("process {}", agent.child.id())) && told.contains("--data"), "{told}");
    agent.terminate();
    // The lock ends with the process, also when it is killed.
    let mut killed = Agent::start(folder.path(), &[]);
    killed.child.kill().unwrap();
    killed.child.wait().unwrap();
    Agent::start(folder.path(), &[]).terminate();
}

#[test]
fn what_the_configuration_has_off_is_off() {
    let folder = TempDir::new().unwrap();
    let mut text = std::fs::read_to_string(ini()).unwrap();
    for task in ["UDP", "TCP.Server", "Announce", "Logging"] {
        writeln!(text, "[Transports.{task}]\nEnabled = Never").unwrap();
    }
    std::fs::write(folder.path().join("otter.ini"), text).unwrap();
    let agent = Agent::start(folder.path(), &[]);
    assert_eq!(agent.listening.trim(), "listening udp=off tcp=off announce=off");
    let sockets = std::fs::read_dir(format!("/proc/{}/fd", agent.child.id())).unwrap();
    let sockets = sockets
        .filter_map(|entry| std::fs::read_link(entry.unwrap().path()).ok())
        .filter(|target| target.to_string_lossy().starts_with("socket:"));
    // Those of the inherited standard streams may be sockets too; none listens.
    let listening = std::fs::read_to_string(format!("/proc/{}/net/udp", agent.child.id())).unwrap();
    let own: Vec<String> = sockets
        .filter_map(|target| {
            let text = target.to_string_lossy().into_owned();
            Some(text.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned())
        })
        .collect();
    assert!(!own.iter().any(|inode| listening.contains(inode)), "{own:?}");
    assert!(agent.terminate().starts_with("motors stopped"));
    assert!(logs(&folder.path().join("logs")).is_empty());
}

#[test]
fn the_listener_survives_a_lack_of_file_descriptors() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), &config).unwrap();
    let mut command = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_lutra-agent");
    command.args(["-c", "ulimit -n 16 && exec \"$@\"", "sh", program, "run"]).arg(&config);
    let mut agent = Agent::spawn(command.stderr(Stdio::piped()), folder.path(), &[]);
    let mut words = BufReader::new(agent.child.stderr.take().unwrap()).lines();
    let crowd: Vec<_> = (0..14).map(|_| TcpStream::connect(("127.0.0.1", agent.tcp[0])).unwrap()).collect();
    let told = words.any(|line| line.unwrap().contains("a connection could not be accepted"));
    assert!(told);
    drop(crowd);
    let mut console = Console::connect(&agent);
    console.ready();
    agent.signal("TERM");
    let rest = std::thread::spawn(move || words.count());
    assert!(agent.ended().starts_with("motors stopped"));
    rest.join().unwrap();
}

#[test]
fn a_log_for_machines_is_one_object_a_line() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), &config).unwrap();
    let mut command = program();
    command.arg("run").arg(&config).args(["--log-format", "json", "--log-level", "debug"]);
    let mut agent = Agent::spawn(command.stderr(Stdio::piped()), folder.path(), &[]);
    let mut words = agent.child.stderr.take().unwrap();
    Console::connect(&agent).ready();
    agent.terminate();
    let mut text = String::new();
    words.read_to_string(&mut text).unwrap();
    let mut targets = std::collections::BTreeSet::new();
    for line in text.lines() {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(line["timestamp"].is_string() && line["level"].is_string() && line["message"].is_string());
        targets.insert(line["target"].as_str().unwrap().to_owned());
    }
    assert!(targets.contains("vessel"), "{text}");
}

#[test]
fn a_level_that_is_none_is_refused() {
    let out = program().args(["run", "none.ini", "--log-level", "shout=very"]).output().unwrap();
    assert_eq!(out.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&out.stderr).contains("--log-level"));
    let wrong = program().args(["run", "none.ini", "--log-format", "verse"]).output().unwrap();
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn a_terminal_that_nobody_reads_stops_no_vessel() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), &config).unwrap();
    let mut command = program();
    command.arg("run").arg(&config).args(["--log-level", "debug"]);
    let mut agent = Agent::spawn(command.stderr(Stdio::piped()), folder.path(), &[]);
    // Held open and never read: the pipe is full after some hundred lines.
    let words = agent.child.stderr.take().unwrap();
    let mut console = Console::connect(&agent);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    for _ in 0..5_000 {
        socket.send_to(b"no packet", ("127.0.0.1", agent.udp)).unwrap();
    }
    console.ready();
    console.start("far", Some(far_plan().into()));
    console.wait_for::<EstimatedState>("way on", |state| state.u > 0.5);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
    drop(words);
}

#[test]
fn a_disk_that_hangs_holds_up_its_answer_and_nothing_else() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    // Writing to a pipe without a reader blocks, like a failing disk.
    let pipe = folder.path().join("plans/far.part");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    console.send(PlanDB {
        r#type: PlanDBType::Request,
        op: PlanDBOp::Set,
        request_id: 77,
        plan_id: "far".into(),
        arg: far_plan().into(),
        ..PlanDB::default()
    });
    console.wait_for::<PlanDB>("in progress", |reply| reply.r#type == PlanDBType::InProgress);
    let far = far_plan();
    let goto = far.maneuvers.of::<PlanManeuver>().next().unwrap().data.get().unwrap();
    console.start("quick", Some(goto));
    console.wait_for::<EstimatedState>("way on", |state| state.u > 1.0);
    console.send(Abort);
    console.wait_for::<Aborted>("aborted", |_| true);
    let answers = console.seen.iter().filter_map(|packet| packet.get::<PlanDB>());
    let early = answers.filter(|reply| reply.request_id == 77 && reply.r#type != PlanDBType::InProgress);
    assert_eq!(early.count(), 0, "nothing is acknowledged before it is on the disk");
    // The disk returns with an error: a pipe cannot be synced.
    let mut given = Vec::new();
    std::fs::File::open(&pipe).unwrap().read_to_end(&mut given).unwrap();
    let refused = console.wait_for::<PlanDB>("the answer", |reply| reply.request_id == 77);
    assert_eq!(refused.r#type, PlanDBType::Failure);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
}

#[test]
fn a_disk_that_never_comes_back_stops_no_end() {
    let folder = TempDir::new().unwrap();
    let mut agent = Agent::start(folder.path(), &[]);
    let mut console = Console::connect(&agent);
    console.ready();
    let pipe = folder.path().join("plans/far.part");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    console.send(PlanDB {
        r#type: PlanDBType::Request,
        op: PlanDBOp::Set,
        plan_id: "far".into(),
        arg: far_plan().into(),
        ..PlanDB::default()
    });
    console.wait_for::<PlanDB>("in progress", |reply| reply.r#type == PlanDBType::InProgress);
    agent.signal("TERM");
    assert_eq!(agent.child.wait().unwrap().code(), Some(1));
}
