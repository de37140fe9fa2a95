//! The transfer of the shore's chart, with the real server and a real Otter: both are killed in the middle, then the chart
//! is complete, in force and obeyed, and shown on the vessel's page.

use crate::support::ashore::now_s;
use crate::support::browser::Browser;
use crate::support::program::{Agent, Line, SERVER, Server, add_admin, agent_program, link_token, until};
use crate::support::{CONSOLE, Client, OTTER, PATIENCE, packet};
use charts::depth_index::Water;
use guard::GuardLimits;
use imc::PacketView;
use imc::messages::{Goto, Message, PlanControl, PlanControlOp, PlanControlType, SpeedUnits, ZUnits};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;
use units::{LatLon, LocalFrame, LocalPoint};

/// Configuration of the Otter: its position in the archipelago; its guard is stricter than the shore's.
const START: &str = "\n[Simulators.GPS]\nInitial Position = 63.446, 10.345\n\n[Supervisors.Grounding]\nAutonomous Depth = 8\n";
const PASSWORD: &str = "seven-small-boats-at-sea";

/// Imports the fictitious archipelago into the chart set.
fn import(data: &Path) {
    let cells = data.join("cells");
    std::fs::create_dir_all(&cells).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(file.name), file.bytes).unwrap();
    }
    chart(data, &["import", cells.to_str().unwrap()]);
}

fn chart(data: &Path, arguments: &[&str]) -> Value {
    let mut command = Command::new(SERVER);
    let output = command.arg("chart").args(arguments).args(["--json", "--data"]).arg(data).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The place on land nearest to the start, by the chart.
fn on_land(data: &Path) -> (f64, f64) {
    let index = chartdb::load_index(&data.join("charts/chart.gpkg")).unwrap().sealed.index;
    let demand = GuardLimits::default().demand(1.0);
    let frame = LocalFrame::new(LatLon::from_deg(63.446, 10.345).unwrap());
    let around = (1..150).flat_map(|ring| (0..16).map(move |part| (f64::from(ring) * 20.0, f64::from(part))));
    let mut places = around.map(|(far_m, part)| {
        frame.to_place(LocalPoint::default().displaced(part / 16.0 * std::f64::consts::TAU, far_m))
    });
    let land = places.find(|place| index.depth_at(*place, &demand).water == Water::Land).unwrap();
    (land.lat_deg(), land.lon_deg())
}

/// Received bytes of the incomplete chart.
fn part_bytes(aboard: &Path) -> u64 {
    let files = std::fs::read_dir(aboard.join("chart")).into_iter().flatten().flatten();
    let parts = files.filter(|file| file.path().extension().is_some_and(|extension| extension == "part"));
    parts.filter_map(|file| Some(file.metadata().ok()?.len())).sum()
}

/// Asks the vessel itself to load a plan to a place; returns its answer.
async fn load(console: &mut Client, request_id: u16, (lat_deg, lon_deg): (f64, f64)) -> PlanControl {
    let goto = Goto {
        lat: lat_deg.to_radians(),
        lon: lon_deg.to_radians(),
        z_units: ZUnits::Depth,
        speed: 1.5,
        speed_units: SpeedUnits::MetersPs,
        timeout: 3_000,
        ..Goto::default()
    };
    let request = PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Load,
        request_id,
        plan_id: "east".into(),
        arg: Some(Message::from(goto)).into(),
        ..PlanControl::default()
    };
    let mut asked = 0.0;
    loop {
        assert!(asked < 30.0, "the vessel does not answer {request_id}");
        console.say(&packet(CONSOLE, OTTER, now_s(), request.clone())).await;
        let heard = async {
            loop {
                let heard = console.hear().await;
                let view = PacketView::new(&heard).unwrap();
                if let Some(answer) = imc::decode::<PlanControl>(&view).unwrap()
                    && (answer.request_id, view.src()) == (request_id, OTTER)
                    && matches!(answer.r#type, PlanControlType::Success | PlanControlType::Failure)
                {
                    return answer;
                }
            }
        };
        if let Ok(answer) = tokio::time::timeout(PATIENCE / 10, heard).await {
            return answer;
        }
        asked += 1.0;
    }
}

/// A place some tens of metres away that the vessel itself would go to.
async fn open_water(console: &mut Client) -> (f64, f64) {
    let frame = LocalFrame::new(LatLon::from_deg(63.446, 10.345).unwrap());
    for part in 0..16_u16 {
        let course_rad = f64::from(part) / 16.0 * std::f64::consts::TAU;
        let place = frame.to_place(LocalPoint::default().displaced(course_rad, 80.0));
        let place = (place.lat_deg(), place.lon_deg());
        if load(console, 810 + part, place).await.r#type == PlanControlType::Success {
            return place;
        }
    }
    panic!("it goes nowhere");
}

/// Closes a square of 40 m around a place to all vessels.
fn close(browser: &mut Browser, (lat_deg, lon_deg): (f64, f64)) {
    let page = browser.get("/no-go-areas");
    let token = page.split_once("name=\"csrf\" content=\"").unwrap().1.split('"').next().unwrap();
    let corner = |north: f64, east: f64| [lat_deg + north * 1.8e-4, lon_deg + east * 4e-4];
    let corners = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    let area = serde_json::json!({"name": "Salmon farm", "reason": "", "corners": corners}).to_string();
    let more = format!("content-type: application/json\r\nx-csrf-token: {token}\r\n");
    let (head, body) = browser.ask("POST /api/v1/no-go-areas", &more, &area);
    assert!(head.contains(" 200 "), "{head}\n{body}");
}

fn held(browser: &mut Browser) -> Value {
    let links: Value = serde_json::from_str(&browser.get("/api/v1/links")).unwrap();
    links[0]["chart"].clone()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_chart_comes_aboard_although_both_are_killed_and_plans_are_refused_by_it() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    add_admin(&data, "ada", PASSWORD);
    let mut server = Server::start(&data);
    let line = Line::to(server.web).await;
    let start = || Agent::start_with(Command::new(&program), aboard.path(), line.address, &token, START);
    let mut agent = start();

    // Without any chart nothing is refused.
    let mut browser = Browser::log_in(&server.web.to_string(), "ada", PASSWORD);
    until("told of", || (held(&mut browser)["state"] == "none").then_some(())).await;
    import(&data);
    let land = on_land(&data);

    // Slow enough for the kills during the transfer.
    let whole = std::fs::metadata(data.join("charts/chart.lutra-index")).unwrap().len();
    line.carries((whole / 10).max(50_000));
    let more_than = |part: u64| (part_bytes(aboard.path()) > part).then_some(());
    until("begun", || more_than(whole / 10)).await;
    let mut console = Client::connect(server.proxy).await;
    assert_eq!(load(&mut console, 801, land).await.r#type, PlanControlType::Success);
    let told =
        until("told how far", || Some(held(&mut browser)).filter(|chart| chart["state"] == "fetching")).await;
    assert!(told["difference"]["percent"].as_f64().unwrap() > 0.0 && told["edition"].is_null(), "{told}");

    // The vessel dies, then the server; nothing is fetched twice.
    agent.process.kill();
    let before = part_bytes(aboard.path());
    assert!(before > whole / 10);
    drop(agent);
    let mut agent = start();
    until("on after the vessel died", || more_than(before + whole / 10)).await;
    server.process.kill();
    let before = part_bytes(aboard.path());
    assert!(before > whole / 5 && !aboard.path().join("chart/chart.lutra-index").exists());
    let mut server = Server::start(&data);
    line.passes(server.web);
    until("on after the server died", || more_than(before)).await;
    line.carries(0);

    let whole = aboard.path().join("chart/chart.lutra-index");
    until("whole", || whole.exists().then_some(())).await;
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(data.join("charts/chart.lutra-index")).unwrap());
    let mut browser = Browser::log_in(&server.web.to_string(), "ada", PASSWORD);
    let told = until("in force", || Some(held(&mut browser)).filter(|chart| chart["state"] == "same")).await;
    assert!(told["edition"].as_str().unwrap().contains("XX5LUTRA"), "{told}");
    let mut console = Client::connect(server.proxy).await;
    let refused = load(&mut console, 802, land).await;
    assert_eq!(refused.r#type, PlanControlType::Failure);
    assert!(refused.info.to_str_lossy().contains("sea chart"), "{}", refused.info);

    // The page shows it, and so does the command line.
    if testkit::browser::is_there() {
        let url = format!("http://{}", server.web);
        let script =
            move || testkit::browser::run("chart-aboard.mjs", &[&url, "ada", PASSWORD, "10256"], |_| ());
        tokio::task::spawn_blocking(script).await.unwrap();
    }
    let list = chart(&data, &["sync", "--vessel", "otter-1"]);
    assert_eq!(
        (&list["vessels"][0]["name"], &list["vessels"][0]["chart"]["state"]),
        (&"otter-1".into(), &"same".into())
    );
    assert_eq!(list["digest"], told["digest"]);

    // A no-go area comes aboard in the same way: the vessel itself refuses a place that it would have gone to.
    let open = open_water(&mut console).await;
    close(&mut browser, open);
    let digest = told["digest"].clone();
    let closed = |chart: &Value| chart["state"] == "same" && chart["digest"] != digest;
    let told = until("closed aboard too", || Some(held(&mut browser)).filter(closed)).await;
    let refused = load(&mut console, 890, open).await;
    assert_eq!(refused.r#type, PlanControlType::Failure);
    assert!(refused.info.to_str_lossy().contains("prohibited"), "{}", refused.info);

    // The next start uses it, even without a shore; the same for a chart that was carried aboard by hand.
    agent.process.terminate();
    std::fs::remove_file(&whole).unwrap();
    let copied = chart(&data, &["sync", "--to", aboard.path().join("chart").to_str().unwrap()]);
    assert_eq!(copied["copied"], whole.to_str().unwrap());
    line.cut();
    let mut agent = start();
    line.passes(server.web);
    let before_us = told["told_us"].as_i64();
    let again = |chart: &Value| chart["state"] == "same" && chart["told_us"].as_i64() > before_us;
    until("in force again", || Some(held(&mut browser)).filter(again)).await;
    let refused = load(&mut console, 803, land).await;
    assert_eq!(refused.r#type, PlanControlType::Failure, "{}", refused.info);
    agent.process.terminate();
    server.process.terminate();
}
