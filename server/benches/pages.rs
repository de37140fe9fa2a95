//! How fast the pages are in a browser: `cargo bench -p server --bench pages [-- SECTION...]`; `scripts/bench-pages`
//! prepares what it needs.
//!
//! A server with the chart of the demonstration and a history, a fleet that sends over the IMCProxy transport when the
//! browser's script says so, and headless Chromium, all on this machine. Sections are those of
//! `tests/browser/bench-pages.mjs`.

#![expect(clippy::unwrap_used, reason = "a benchmark ends where it unwraps nothing")]

mod support;

use bytes::Bytes;
use chartdb::ImportOptions;
use imc::messages::{
    Announce, EntityList, EntityListOp, EntityState, EntityStateState, EstimatedState, FuelLevel,
    PlanControlState, PlanControlStateState, Rpm, SystemType, VehicleState, VehicleStateOpMode,
};
use imc::{Address, Header};
use std::f64::consts::TAU;
use std::fs;
use std::io::Write as _;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use store::{Accepted, Store};
use support::{config, connect, frame};
use units::UtcTime;

/// The vessel with the long history; the fleet's follow.
const FIRST: u16 = 0x2810;
const NAVIGATION: u8 = 1;
const TICK: Duration = Duration::from_millis(100);
/// What the fleet sailed before the browser comes.
const PAST_S: u32 = 3_600;
/// Packets of the past from one commit to the next.
const AT_ONCE: u32 = 25_000;

fn main() {
    let sections: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let (samples, vessels) = (number("SAMPLES", 1_000_000), number("VESSELS", 50));
    if !testkit::browser::is_there() {
        return;
    }
    let data = tempfile::tempdir().unwrap();
    chart(data.path());
    let now_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
    let begun = Instant::now();
    let (from_s, to_s) = history(data.path(), now_s, samples, vessels);
    println!(
        "history of {samples} samples, and an hour of {vessels} vessels, written in {:.1} s",
        begun.elapsed().as_secs_f64()
    );

    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let serving = runtime.block_on(server::serve(config(data.path()))).unwrap();
    let fleet = Arc::new(AtomicBool::new(false));
    let over = Arc::new(AtomicBool::new(false));
    let sailing = {
        let (transport, fleet, over) =
            (serving.transports.imcproxy.unwrap(), Arc::clone(&fleet), Arc::clone(&over));
        thread::spawn(move || sail(transport, vessels, &fleet, &over))
    };
    let url = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let times = [from_s, to_s].map(|seconds| ((seconds * 1e6) as u64).to_string());
    let (first, count) = (FIRST.to_string(), vessels.to_string());
    let mut arguments = vec![url.as_str(), &password, &first, &count, &times[0], &times[1]];
    arguments.extend(sections.iter().map(String::as_str));
    testkit::browser::run("bench-pages.mjs", &arguments, |line| match line {
        "the fleet sails" => fleet.store(true, Ordering::Relaxed),
        "the fleet is silent" => fleet.store(false, Ordering::Relaxed),
        _ => {}
    });
    over.store(true, Ordering::Relaxed);
    sailing.join().unwrap();
    runtime.block_on(serving.stop());
}

fn number(name: &str, default: u32) -> u32 {
    std::env::var(name).map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name} is a number")))
}

/// Brings in the archipelago of the demonstration.
fn chart(data: &Path) {
    let cells = tempfile::tempdir().unwrap();
    for file in charts::demo::archipelago().unwrap() {
        fs::write(cells.path().join(format!("{}.000", file.name.trim_end_matches(".000"))), file.bytes)
            .unwrap();
    }
    let set = config(data).chart_set();
    fs::create_dir_all(set.parent().unwrap()).unwrap();
    let options = ImportOptions::new(UtcTime::from_micros(0));
    let report = chartdb::import(&set, &[cells.path().to_owned()], &options, &mut |_| true).unwrap();
    assert!(report.failures.is_empty(), "the archipelago comes in whole");
}

/// Fills a data folder: the state of the first vessel ten times a second, that many times, and an hour of the whole
/// fleet at 1 Hz, all until `now_s`. Returns the begin and end of the first vessel's (s since 1970).
fn history(data: &Path, now_s: f64, samples: u32, vessels: u32) -> (f64, f64) {
    let mut store = Store::open(data).unwrap();
    let (mut bytes, mut waiting) = (Vec::new(), 0);
    let mut put = |number: u32, at_s: f64| {
        bytes.clear();
        imc::encode_into(&mut bytes, &header(number, NAVIGATION, at_s), &state(number, at_s)).unwrap();
        let received = UtcTime::from_micros((at_s * 1e6) as i64);
        let packet = Bytes::copy_from_slice(&bytes);
        store
            .accept(&Accepted { packet: &packet, received, transport: store::Transport::Tcp, link: None })
            .unwrap();
        waiting += 1;
        if waiting == AT_ONCE {
            store.commit().unwrap();
            waiting = 0;
        }
    };
    let from_s = now_s - f64::from(samples) / 10.0;
    for sample in 0..samples {
        put(0, from_s + f64::from(sample) / 10.0);
    }
    for second in (1..=PAST_S).rev() {
        for number in 1..vessels {
            put(number, now_s - f64::from(second));
        }
    }
    store.settle().unwrap();
    store.close().unwrap();
    (from_s, now_s)
}

fn header(number: u32, src_ent: u8, timestamp: f64) -> Header {
    Header { timestamp, src: Address(FIRST + number as u16), src_ent, ..Header::default() }
}

/// A vessel sails rounds of 300 m around a place given by its number, with a little noise in its measurements.
fn state(number: u32, at_s: f64) -> EstimatedState {
    let along = (at_s % 600.0) / 600.0 * TAU + f64::from(number);
    let (lat, lon) = (63.44 + 0.004 * f64::from(number / 8), 10.30 + 0.012 * f64::from(number % 8));
    let course = along + TAU / 4.0;
    let u = 1.5 + 0.1 * (at_s * 0.7).sin() + 0.05 * (at_s * 12.9898).sin() * (at_s * 78.233).cos();
    EstimatedState {
        lat: (lat + 0.0027 * along.cos()).to_radians(),
        lon: (lon + 0.006 * along.sin()).to_radians(),
        psi: course as f32,
        u: u as f32,
        vx: (u * course.cos()) as f32,
        vy: (u * course.sin()) as f32,
        ..EstimatedState::default()
    }
}

/// Lets the fleet send while `on`.
fn sail(transport: SocketAddr, vessels: u32, on: &AtomicBool, over: &AtomicBool) {
    let mut stream = connect(transport);
    // The answers are read and discarded, so that they do not pile up.
    let mut back = stream.try_clone().unwrap();
    thread::spawn(move || std::io::copy(&mut back, &mut std::io::sink()));
    let mut out = Vec::new();
    let mut due = Instant::now();
    for tick in 0_u64.. {
        due += TICK;
        thread::sleep(due.saturating_duration_since(Instant::now()));
        if over.load(Ordering::Relaxed) {
            break;
        }
        if !on.load(Ordering::Relaxed) {
            continue;
        }
        out.clear();
        let now_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
        for number in 0..vessels {
            say(&mut out, number, now_s, tick.is_multiple_of(10));
        }
        stream.write_all(&out).unwrap();
    }
    stream.shutdown(std::net::Shutdown::Both).ok();
}

/// A vessel's packets: always its state and motors, the others with `rest`.
fn say(out: &mut Vec<u8>, number: u32, now_s: f64, rest: bool) {
    frame(out, &header(number, NAVIGATION, now_s), &state(number, now_s));
    for motor in [2, 3] {
        let value = (700.0 + 50.0 * (now_s * 0.7).sin()) as i16;
        frame(out, &header(number, motor, now_s), &Rpm { value });
    }
    if !rest {
        return;
    }
    let by = |entity| header(number, entity, now_s);
    let sys_name = format!("otter-{number:02}").as_str().into();
    let announce = Announce { sys_name, sys_type: SystemType::Usv, owner: 0xFFFF, ..Announce::default() };
    let list = "Navigation=1;Motor Port=2;Motor Starboard=3;Fuel=4".into();
    let (op_mode, plan_id) = (VehicleStateOpMode::Maneuver, "survey".into());
    let plan = PlanControlState { state: PlanControlStateState::Executing, plan_id, ..Default::default() };
    frame(out, &by(255), &announce);
    frame(out, &by(255), &EntityList { op: EntityListOp::Report, list });
    frame(out, &by(255), &VehicleState { op_mode, maneuver_type: 450, ..Default::default() });
    frame(out, &by(255), &plan);
    frame(out, &by(4), &FuelLevel { value: 87.0, ..Default::default() });
    for entity in 1..=4 {
        frame(out, &by(entity), &EntityState { state: EntityStateState::Normal, ..Default::default() });
    }
}
