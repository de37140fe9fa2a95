//! Steering by hand with the real server, a real agent and a real browser: however it fails, the vessel's own log shows
//! that its motors stopped within 0.75 s of the last fresh stick sample, and stayed stopped until the sticks had passed
//! neutral. All the while a console without control commands full ahead, and is not obeyed.

use crate::support::ashore::now_s;
use crate::support::program::{
    Agent, Line, Server, add_admin, agent_program, link_token, logged, run, until,
};
use crate::support::{CONSOLE, OTTER, packet};
use charts::depth_index::{Demand, Leg, SealedIndex};
use imc::PacketView;
use imc::messages::{LogBookEntry, RemoteActions, SetThrusterActuation};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;
use tokio::io::AsyncWriteExt as _;
use tokio::net::TcpStream;
use units::{LatLon, LocalFrame, LocalPoint};

/// From the last fresh sample to zero thrust.
const BOUND_S: f64 = 0.75;
/// A greater actuation than any person commands here.
const ROGUE: f32 = 0.9;

/// A line of the browser's script.
#[derive(Debug)]
enum ScriptLine {
    Fault(Fault),
    /// From this time on thrust is allowed again.
    May(f64),
}

#[derive(Debug)]
struct Fault {
    name: String,
    /// Whether the motors ran when it came, as the script saw it.
    ran: bool,
    /// When it came, UTC s.
    at_s: f64,
    /// The last fresh sample until then.
    fresh_s: f64,
}

/// The vessel's motor commands: time (s), motor, actuation.
type Thrust = [(f64, u8, f32)];

fn thrust(packets: &[bytes::Bytes]) -> Vec<(f64, u8, f32)> {
    let mut all: Vec<(f64, u8, f32)> = Vec::new();
    for packet in packets {
        let view = PacketView::new(packet).unwrap();
        if let Ok(Some(motor)) = imc::decode::<SetThrusterActuation>(&view) {
            all.push((view.timestamp(), motor.id, motor.value));
        }
    }
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    all
}

/// Whether both motors ran at a time.
fn ran(thrust: &Thrust, at_s: f64) -> bool {
    let last = |motor| thrust.iter().rfind(|one| one.0 <= at_s && one.1 == motor);
    [0, 1].into_iter().all(|motor| last(motor).is_some_and(|one| one.2 != 0.0))
}

/// When both motors were commanded to stop after a fault, permanently until `until_s`.
fn still_s(thrust: &Thrust, until_s: f64) -> Option<f64> {
    let before = thrust.iter().filter(|one| one.0 < until_s);
    let last = before.clone().rfind(|one| one.2 != 0.0)?;
    let zero = |motor| before.clone().find(|one| one.0 >= last.0 && one.1 == motor && one.2 == 0.0);
    Some(zero(0)?.0.max(zero(1)?.0))
}

/// A console that commands full ahead ten times a second, regardless of the answers.
async fn rogue(port: u16) {
    let Ok(stream) = TcpStream::connect(("127.0.0.1", port)).await else { return };
    let (mut from, mut to) = stream.into_split();
    tokio::spawn(async move { tokio::io::copy(&mut from, &mut tokio::io::sink()).await });
    let mut every = tokio::time::interval(Duration::from_millis(100));
    loop {
        every.tick().await;
        let keys = RemoteActions { actions: "Port Motor=127;Starboard Motor=127".into() };
        if to.write_all(&packet(CONSOLE, OTTER, now_s(), keys)).await.is_err() {
            return;
        }
    }
}

/// The fault in a line of the script; `noted_s` is its time if it was not caused by the script.
fn fault_of(words: &[&str], noted_s: Option<f64>) -> Fault {
    let [name, ran, at_ms, samples] = words else { panic!("{words:?}") };
    let at_s = noted_s.unwrap_or_else(|| at_ms.parse::<f64>().unwrap() / 1e3);
    let samples = samples.split(',').map(|ms| ms.parse::<f64>().unwrap() / 1e3);
    let fresh_s = samples.filter(|sample_s| *sample_s <= at_s).fold(f64::NEG_INFINITY, f64::max);
    assert!(fresh_s.is_finite(), "{name}: no fresh sample");
    Fault { name: (*name).to_owned(), ran: *ran == "ran", at_s, fresh_s }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn however_steering_by_hand_fails_the_motors_stand_still_in_time() {
    let Some(program) = agent_program() else { return };
    if !testkit::browser::is_there() {
        return;
    }
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let mut server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let password = "seven small boats at sea";
    for person in ["anna", "bert"] {
        add_admin(&data, person, password);
    }
    let (to_vessel, to_browser) = (Line::to(server.web).await, Line::to(server.web).await);
    let mut agent = Agent::start(&program, aboard.path(), to_vessel.address, &token);
    let rogue = tokio::spawn(rogue(agent.tcp));
    let url = format!("http://{}", to_browser.address);

    let (mut told, mut noted_s) = (Vec::new(), None);
    tokio::task::block_in_place(|| {
        testkit::browser::run("teleop.mjs", &[&url, password], |line| {
            let words: Vec<&str> = line.split(' ').collect();
            let way = |name| if name == "vessel" { &to_vessel } else { &to_browser };
            match words[..] {
                ["fault", ref rest @ ..] => told.push(ScriptLine::Fault(fault_of(rest, noted_s.take()))),
                ["may", ms] => told.push(ScriptLine::May(ms.parse::<f64>().unwrap() / 1e3)),
                ["silence", name] => {
                    noted_s = Some(now_s());
                    way(name).silent();
                }
                ["passes", name] => way(name).passes(server.web),
                ["kill", "server"] => {
                    noted_s = Some(now_s());
                    server.process.kill();
                    server = Server::start(&data);
                    to_vessel.passes(server.web);
                    to_browser.passes(server.web);
                }
                _ => {}
            }
        });
    });
    // Wait until the commands after the last fault are in the log.
    let end_s = now_s() + 2.0;
    until("two seconds of the log after the last fault", || (now_s() > end_s).then_some(())).await;
    rogue.abort();
    agent.process.terminate();

    let packets = logged(aboard.path());
    let thrust = thrust(&packets);
    let mut proven = BTreeSet::new();
    for (n, one) in told.iter().enumerate() {
        let ScriptLine::Fault(Fault { name, ran: seen, at_s, fresh_s }) = one else { continue };
        let later = told[n + 1..].iter().find_map(|one| match one {
            ScriptLine::May(may_s) => Some(*may_s),
            ScriptLine::Fault(_) => None,
        });
        let still_s = still_s(&thrust, later.unwrap_or(end_s));
        let took_s = still_s.unwrap_or_else(|| panic!("{name}: the motors did not stop")) - fresh_s;
        let ran = *seen && ran(&thrust, *at_s);
        let note = if ran { "" } else { ", but they stood still before the fault" };
        println!("{name}: zero thrust {:.0} ms after the last fresh sample{note}", took_s * 1e3);
        assert!(took_s <= BOUND_S, "{name}: {took_s} s");
        if ran {
            proven.insert(name.as_str());
        }
    }
    assert_eq!(proven, FAULTS.into(), "the motors ran when each of these came");

    let fastest = thrust.iter().map(|one| one.2.abs()).fold(0.0, f32::max);
    assert!(fastest < ROGUE, "the console without control steered: {fastest}");
    let refused = "RemoteActions of 0x4001 is refused: anna has control";
    assert!(
        packets.iter().any(|packet| log_book(packet).contains(refused)),
        "the vessel says whom it refused"
    );
}

/// A chart set made of the fictitious archipelago, and a place in it 13 m south of danger.
fn chart(data: &Path) -> (PathBuf, LatLon) {
    let cells = data.with_file_name("cells");
    std::fs::create_dir_all(&cells).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(format!("{}.000", file.name.trim_end_matches(".000"))), file.bytes)
            .unwrap();
    }
    run(data, &["chart", "import", cells.to_str().unwrap()]);
    let index = data.join("charts/chart.lutra-index");
    let chart = SealedIndex::from_bytes(&std::fs::read(&index).unwrap()).unwrap().index;
    let demand = Demand { position_m: 3.0, ..Demand::least_depth(1.0) };
    let place = (0..40).find_map(|step| {
        let from = LatLon::from_deg(63.446, 10.345 + 0.004 * f64::from(step)).unwrap();
        let frame = LocalFrame::new(from);
        let north = |north_m| frame.to_place(LocalPoint { north_m, east_m: 0.0 });
        let leg = Leg { from, to: north(3_000.0) };
        let along_m = chart.first_danger_along(leg, 1.2, &demand)?.along_m;
        (along_m > 100.0).then(|| north(along_m - 13.0))
    });
    (index, place.expect("somewhere there is danger to the north"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn thrust_towards_danger_is_blocked_until_the_operator_lifts_the_guard() {
    let Some(program) = agent_program() else { return };
    if !testkit::browser::is_there() {
        return;
    }
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    std::fs::create_dir_all(&data).unwrap();
    let (index, place) = chart(&data);
    let server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    add_admin(&data, "anna", "seven small boats at sea");
    let more = format!(
        "\n[Supervisors.Grounding]\nChart = {}\n\n[Simulators.GPS]\nInitial Position = {:.7}, {:.7}\n",
        index.display(),
        place.lat_deg(),
        place.lon_deg()
    );
    let mut agent =
        Agent::start_with(std::process::Command::new(&program), aboard.path(), server.web, &token, &more);
    let url = format!("http://{}", server.web);
    tokio::task::block_in_place(|| {
        testkit::browser::run("teleop-guard.mjs", &[&url, "seven small boats at sea"], |_| ());
    });
    agent.process.terminate();
    let packets = logged(aboard.path());
    for text in ["steers unguarded by the sea chart for 60 s", "ends the exemption"] {
        assert!(packets.iter().any(|packet| log_book(packet).contains(text)), "{text}");
    }
}

/// Text of an entry of the log book.
fn log_book(packet: &bytes::Bytes) -> String {
    let entry = imc::decode::<LogBookEntry>(&PacketView::new(packet).unwrap()).ok().flatten();
    entry.map(|entry| entry.text.to_str_lossy().into_owned()).unwrap_or_default()
}

const FAULTS: [&str; 13] = [
    "browser-killed",
    "clock-jump",
    "finger-frozen",
    "gamepad-frozen",
    "gamepad-unplugged",
    "keyboard-frozen",
    "lease-taken",
    "network-dropped-browser",
    "network-dropped-vessel",
    "released",
    "server-killed",
    "stop-pressed",
    "tab-hidden",
];
