//! The real process over real sockets on loopback, with ports chosen by the system.
//!
//! Nothing sleeps to let things settle: every wait is for a packet or a line, with a deadline.

use crate::common::{Agent, CONSOLE, Console, DEADLINE, far_plan, ini, logs, packet, program};
use imc::lsf::{LogItem, LogReader};
use imc::messages::*;
use imc::{Address, Header, Packet};
use std::net::UdpSocket;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use testkit::ServiceManager;

#[test]
fn the_service_manager_is_told_that_it_is_ready_lives_and_ends() {
    let (folder, manager) = (TempDir::new().unwrap(), ServiceManager::start());
    let mut command = program();
    manager.watches(command.arg("run").arg(ini()).arg("--quiet"), Duration::from_millis(400));
    let agent = Agent::spawn(&mut command, folder.path(), &[]);
    // The first watchdog message may come before the ready message.
    manager.waits_for("READY=1");
    for _ in 0..3 {
        assert_eq!(manager.told(), "WATCHDOG=1");
    }
    agent.signal("TERM");
    manager.waits_for("STOPPING=1");
    agent.ended();
}

#[test]
fn a_scripted_mission_from_outside() {
    let folder = TempDir::new().unwrap();
    let agent = Agent::start(folder.path(), &["--record", folder.path().join("run.rec").to_str().unwrap()]);
    let mut console = Console::connect(&agent);
    console.ready();

    let reply = console.database(PlanDBOp::Set, "far", Some(far_plan().into()));
    let information =
        reply.arg.of::<imc::messages::PlanDBInformation>().unwrap_or_else(|| panic!("{reply:?}"));
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
    let last = agent.terminate();
    assert!(last.starts_with("motors stopped"), "{last}");
    // Saved data are on disk at the end at the latest.
    let saved = std::fs::read_to_string(folder.path().join("ntnu-otter-01-saved.ini")).unwrap();
    assert!(saved.contains("ILOS Lookahead Distance") && saved.contains("13"), "{saved}");
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
    // The best of several: other programs may delay any of them.
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
    while !["EstimatedState", "VehicleState", "PlanControlState", "EntityList"]
        .iter()
        .all(|name| heard.contains(name))
    {
        assert!(Instant::now() < until, "{heard:?}");
        let (length, _) = socket.recv_from(&mut buffer).unwrap();
        if heard.is_empty() {
            // Requested after the announcement, which has its own port and thread.
            let query = packet(EntityList { op: EntityListOp::Query, ..Default::default() });
            socket.send_to(&query, ("127.0.0.1", agent.udp)).unwrap();
        }
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
    // Two flushes of the log: everything before the last is on disk.
    console.wait_for::<EstimatedState>("way on", |state| state.x.hypot(state.y) > 12.0);
    agent.child.kill().unwrap();
    agent.child.wait().unwrap();

    let mut names = std::collections::BTreeSet::new();
    for log in logs(&folder.path().join("logs")) {
        let mut reader = LogReader::open(&log).unwrap();
        // A truncated log ends in damage or an error, after all complete packets.
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
    let state = reply.arg.of::<imc::messages::PlanDBState>().unwrap_or_else(|| panic!("{reply:?}"));
    let plan = state.plans_info.of::<PlanDBInformation>().next().unwrap();
    assert_eq!(plan.md5, imc::plan_digest::plan_md5(&far_plan()).unwrap());
    assert_eq!(plan.change_sid, CONSOLE.0);
    let idle = console.wait_for::<PlanControlState>("idle", |_| true);
    assert_eq!(idle.state, PlanControlStateState::Ready);
    let moving = console.seen.iter().filter_map(|packet| packet.get::<SetThrusterActuation>());
    assert_eq!(moving.filter(|set| set.value != 0.0).count(), 0, "nothing moves after a restart");
}

#[test]
fn two_simulations_record_the_same_bytes_and_replay() {
    let folder = TempDir::new().unwrap();
    let mut recordings = Vec::new();
    for name in ["a", "b"] {
        let path = folder.path().join(name);
        let out = program()
            .args(["simulate", "--every", "0", "--current", "0.3@90", "--wind", "4@200", "--record"])
            .arg(&path)
            .output()
            .unwrap();
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        recordings.push(std::fs::read(&path).unwrap());
    }
    assert!(recordings[0] == recordings[1]);
    assert!(program().arg("replay").arg(folder.path().join("a")).status().unwrap().success());
    // Damage is detected, except in the rare byte that nothing depends on.
    let noticed = (2..5).filter(|quarter| {
        let mut damaged = recordings[0].clone();
        let place = damaged.len() * quarter / 6;
        damaged[place] ^= 0xFF;
        let path = folder.path().join("damaged");
        std::fs::write(&path, damaged).unwrap();
        !program().arg("replay").arg(&path).stderr(Stdio::null()).status().unwrap().success()
    });
    assert!(noticed.count() >= 2);
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
    let shown = String::from_utf8_lossy(&good.stdout);
    assert!(good.status.success() && !shown.contains("warning:"), "{shown}");
    let json = program().arg("check").arg(ini()).arg("--json").output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["doubts"], serde_json::json!([]));
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("bad.ini");
    std::fs::write(&path, "[Require nowhere.ini]\n[Control.Path.ILOS]\nILOS Lookahead Distance = far\n")
        .unwrap();
    let bad = program().arg("check").arg(&path).output().unwrap();
    assert_eq!(bad.status.code(), Some(1));
}

#[test]
fn gains_that_oscillate_are_told_by_check_and_at_the_start_and_hinder_neither() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("otter.ini");
    let gains = "\n[Control.ASV.HeadingAndSpeed]\nYaw PID Gains = 3, 0, 0\n";
    std::fs::write(&path, std::fs::read_to_string(ini()).unwrap() + gains).unwrap();
    let told = |text: &str| text.lines().filter(|line| line.contains("it oscillates: at")).count();
    let check = program().arg("check").arg(&path).output().unwrap();
    assert!(check.status.success());
    let text = String::from_utf8_lossy(&check.stdout);
    assert_eq!(told(&text), 1, "{text}");
    assert!(text.trim_end().ends_with("\n1 warning of what these settings do aboard"), "{text}");
    let json = program().arg("check").arg(&path).arg("--json").output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["doubts"].as_array().unwrap().len(), 1, "{json}");
    // Its standard input is closed already: it starts, and ends normally.
    let run = program()
        .arg("run")
        .arg(&path)
        .args(["--quiet", "--end-with-stdin", "--bind", "127.0.0.1", "--data"])
        .arg(folder.path())
        .args(["--udp-port", "0", "--tcp-port", "0", "--announce-port", "0"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success() && told(&text) == 1, "{text}");
}

#[test]
fn the_bare_hull_answers_as_the_reference() {
    let out =
        program().args(["simulate", "--open-loop", "60,60", "--until", "30", "--csv", "-"]).output().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    let last: Vec<f64> = text.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    // The model's surge at 60/60 rad/s is 1.0287 m/s.
    assert!((last[1] - 1.0287).abs() < 0.002, "{last:?}");
    assert_eq!(text.lines().count(), 32);
}

#[test]
fn a_second_server_of_streams_carries_what_its_section_lists() {
    let folder = TempDir::new().unwrap();
    let mut config = std::fs::read_to_string(ini()).unwrap();
    config.push_str(
        "\n[Transports.TCP.Server/R1]\nEnabled = Always\nEntity Label = TCP for R1\nPort = 9801\n\
         Transports = Heartbeat\n",
    );
    std::fs::write(folder.path().join("otter.ini"), config).unwrap();
    let agent = Agent::start(folder.path(), &[]);
    let [first, second] = agent.tcp[..] else { panic!("{}", agent.listening) };
    let mut console = Console::connect_to(first);
    console.ready();
    let mut formation = Console::connect_to(second);
    for _ in 0..3 {
        formation.wait("the next", |packet| packet.get::<Heartbeat>().map(|_| ()));
    }
    // Requests are answered on all streams; only heartbeats are sent unrequested.
    let by_itself = formation.seen.iter().find(|packet| packet.header.dst.is_everyone());
    assert_eq!(by_itself, None);
    assert!(console.seen.len() > 10);
}

#[test]
fn it_ends_in_order_with_the_program_that_started_it_when_told_to() {
    let folder = TempDir::new().unwrap();
    let mut command = program();
    std::fs::copy(ini(), folder.path().join("otter.ini")).unwrap();
    command.arg("run").arg(folder.path().join("otter.ini")).args(["--quiet", "--end-with-stdin"]);
    let mut agent = Agent::spawn(command.stdin(Stdio::piped()), folder.path(), &[]);
    Console::connect(&agent).ready();
    // As the system does with the pipes of a program that has ended.
    drop(agent.child.stdin.take());
    assert!(agent.ended().starts_with("motors stopped, log closed"));
}
