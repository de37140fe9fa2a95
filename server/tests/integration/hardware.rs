//! The whole chain with real programs: simulated devices on pseudo-terminals, the agent that steers by their real protocols,
//! its link, a server, and the server's answers. Everything known of the vessel comes from its devices.

use crate::support::browser::Browser;
use crate::support::program::{Agent, Process, Server, add_admin, agent_program, link_token, until};
use crate::support::{CONSOLE, Client, OTTER, PATIENCE, ashore::now_s, packet};
use imc::PacketView;
use imc::messages::{
    Goto, PlanControl, PlanControlOp, PlanControlType, PlanManeuver, PlanSpecification, ZUnits,
};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, Stdio};
use std::time::Instant;
use tempfile::TempDir;

/// Duration of a tag's transmission before its line is sent (s): `Transmission Time` of the configuration.
const SENDING_S: f64 = 3.0;
/// How far a detection may be from where the vessel was. The compass has no errors here: what is left is the age of its
/// positions and the estimate between them (m).
const TOLERANCE_M: f64 = 1.5;
/// Metres of a degree of latitude, good to 1 % anywhere.
const DEGREE_M: f64 = 111_500.0;

/// Simulated devices and the vessel's true state.
struct Devices {
    _process: Process,
    _out: BufReader<ChildStdout>,
    truth: PathBuf,
}

#[derive(Debug, Clone, Copy)]
struct Truth {
    utc_s: f64,
    lat_deg: f64,
    lon_deg: f64,
    speed_mps: f64,
}

impl Devices {
    fn start(program: &Path, folder: &Path) -> Self {
        let (config, truth) = (folder.join("devices.ini"), folder.join("truth"));
        let otter = testkit::repository().join("vehicle-agent/etc/otter.ini");
        let mut text = std::fs::read_to_string(otter).unwrap();
        text += "\n[Simulators.Fish]\nEnabled = Simulation\nTag Interval = 5, 6\nArea -- Radius = 20\n";
        std::fs::write(&config, text).unwrap();
        let mut child = Command::new(program)
            .args(["simulate-devices", "--perfect", "--config"])
            .arg(config)
            .arg("--links")
            .arg(folder.join("dev"))
            .arg("--truth")
            .arg(&truth)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        assert!(line.starts_with("devices gnss="), "{line:?}");
        Self { _process: Process(child), _out: out, truth }
    }

    fn truth(&self) -> Vec<Truth> {
        let read = |line: &str| {
            let value: Value = serde_json::from_str(line).ok()?;
            let number = |key: &str| value[key].as_f64();
            let (utc_s, speed_mps) = (number("utc_s")?, number("speed_mps")?);
            Some(Truth { utc_s, lat_deg: number("lat_deg")?, lon_deg: number("lon_deg")?, speed_mps })
        };
        std::fs::read_to_string(&self.truth).unwrap().lines().filter_map(read).collect()
    }

    /// The true state at a time, interpolated.
    fn at(&self, utc_s: f64) -> Truth {
        let all = self.truth();
        let after = all.iter().position(|truth| truth.utc_s >= utc_s).unwrap();
        let (a, b) = (all[after.checked_sub(1).unwrap()], all[after]);
        let part = (utc_s - a.utc_s) / (b.utc_s - a.utc_s);
        let between = |a: f64, b: f64| a + part * (b - a);
        Truth { utc_s, lat_deg: between(a.lat_deg, b.lat_deg), lon_deg: between(a.lon_deg, b.lon_deg), ..b }
    }
}

/// The agent's configuration: its devices are behind the links.
fn devices_of(folder: &Path) -> String {
    let links = folder.join("dev");
    let links = links.display();
    let mut text = String::new();
    write!(
        text,
        "[Sensors.GPS]\nSerial Port - Device = {links}/gnss\nSerial Port - Baud Rate = 115200\n\
         [Actuators.Torqeedo]\nCAN Port - Device = slcan:{links}/motors\n\
         [Sensors.ThelmaHydrophone]\nSerial Port - Device = {links}/hydrophone\nSerial Port - Baud Rate = 115200\n\
         Use PPS = false\n"
    )
    .unwrap();
    text
}

/// Starts a long plan, as soon as the vessel is ready for one.
async fn set_out(console: &mut Client) {
    let goto = Goto {
        lat: 63.34_f64.to_radians(),
        lon: 10.083_333_f64.to_radians(),
        z_units: ZUnits::Depth,
        speed: 1.5,
        ..Goto::default()
    };
    let node = PlanManeuver { maneuver_id: "go".into(), data: goto.into(), ..PlanManeuver::default() };
    let plan = PlanSpecification {
        plan_id: "far".into(),
        start_man_id: "go".into(),
        maneuvers: [node].into_iter().collect(),
        ..PlanSpecification::default()
    };
    let end = Instant::now() + 2 * PATIENCE;
    for request_id in 1.. {
        assert!(Instant::now() < end, "the plan does not start");
        let start = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            request_id,
            plan_id: "far".into(),
            arg: plan.clone().into(),
            ..PlanControl::default()
        };
        console.say(&packet(CONSOLE, OTTER, now_s(), start)).await;
        let answer = async {
            loop {
                let heard = console.hear().await;
                let view = PacketView::new(&heard).unwrap();
                if let Some(answer) = imc::decode::<PlanControl>(&view).unwrap()
                    && (answer.request_id, view.src()) == (request_id, OTTER)
                    && answer.r#type != PlanControlType::Request
                {
                    return answer.r#type == PlanControlType::Success;
                }
            }
        };
        if tokio::time::timeout(PATIENCE / 15, answer).await.unwrap_or(false) {
            return;
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_the_devices_heard_is_ashore_at_the_places_where_the_vessel_was() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    add_admin(&data, "nils", "seven small boats");
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = Server::start(&data);
    let devices = Devices::start(&program, aboard.path());
    let more = devices_of(aboard.path());
    let command = Command::new(&program);
    let mut agent = Agent::start_in(command, "Hardware", aboard.path(), server.web, &token, &more);
    let mut console = Client::connect(server.proxy).await;
    set_out(&mut console).await;
    until("under way", || devices.truth().last().filter(|truth| truth.speed_mps > 1.0).map(|_| ())).await;
    let under_way_s = now_s();

    // Four detections that were all sent while it sailed.
    let mut person = Browser::log_in(&server.web.to_string(), "nils", "seven small boats");
    let from_us = (under_way_s * 1e6) as i64;
    let path =
        format!("/api/v1/vessels/{}/detections?from_us={from_us}&to_us={}", OTTER.0, from_us + 3_600_000_000);
    let found = until("heard and ashore", || {
        let answer: Value = serde_json::from_str(&person.get(&path)).unwrap();
        let sailed = |one: &&Value| {
            one["heard_us"].as_f64().is_some_and(|heard_us| heard_us / 1e6 - SENDING_S > under_way_s)
        };
        let found: Vec<Value> =
            answer["detections"].as_array().unwrap().iter().filter(sailed).cloned().collect();
        (found.len() >= 4).then_some(found)
    })
    .await;
    let newest_s = found.iter().filter_map(|one| one["heard_us"].as_f64()).fold(0.0, f64::max) / 1e6;
    until("the truth of that time", || {
        devices.truth().iter().any(|truth| truth.utc_s > newest_s).then_some(())
    })
    .await;
    let mut worst_m = 0.0_f64;
    let (mut places, mut truths) = (Vec::new(), Vec::new());
    for one in &found {
        let truth = devices.at(one["heard_us"].as_f64().unwrap() / 1e6 - SENDING_S);
        let (lat_deg, lon_deg) = (one["lat_deg"].as_f64().unwrap(), one["lon_deg"].as_f64().unwrap());
        let north_m = (lat_deg - truth.lat_deg) * DEGREE_M;
        let east_m = (lon_deg - truth.lon_deg) * DEGREE_M * truth.lat_deg.to_radians().cos();
        let off_m = north_m.hypot(east_m);
        assert!(off_m < TOLERANCE_M, "{off_m} m from {truth:?}: {one}");
        assert!(one["raw"].as_str().unwrap().starts_with('$'), "{one}");
        worst_m = worst_m.max(off_m);
        places.push(lat_deg * DEGREE_M);
        truths.push(json!({"heard_us": one["heard_us"], "lat_deg": truth.lat_deg, "lon_deg": truth.lon_deg}));
    }
    let extent_m =
        places.iter().copied().fold(f64::MIN, f64::max) - places.iter().copied().fold(f64::MAX, f64::min);
    assert!(extent_m > 10.0, "all at one place: {extent_m} m");
    println!("{} detections along {extent_m:.0} m, the worst {worst_m:.2} m from the truth", found.len());
    if testkit::browser::is_there() {
        let (url, truths) = (format!("http://{}", server.web), Value::from(truths).to_string());
        let vessel = OTTER.0.to_string();
        let show = move || {
            let arguments = [&*url, "nils", "seven small boats", &vessel, &truths];
            testkit::browser::run("devices.mjs", &arguments, |_| ());
        };
        tokio::task::spawn_blocking(show).await.unwrap();
    }
    agent.process.terminate();
    server.process.terminate();
}
