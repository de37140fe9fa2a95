//! The first page in a real browser, on a made-up fleet.

use super::serve::serve;
use super::testing::{Boats, an_hour, boat, packet};
use crate::config::Config;
use imc::messages::{
    Announce, EntityInfo, EntityList, EntityListOp, EntityParameter, EntityParameters, EntityState,
    EntityStateState, EstimatedState, FuelLevel, LogBookEntry, LogBookEntryType, Message, Payload as _,
    QueryEntityParameters, TBRFishTag, VehicleState, VehicleStateOpMode,
};
use shore::clock;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[tokio::test(flavor = "multi_thread")]
async fn the_first_page_shows_the_fleet() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    an_hour(folder.path(), clock::now());
    let serving = serve(quiet(folder.path())).await.unwrap();
    Boats::join(&serving.state.shore.router).await.sail();
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (ask_to_stop, mut asked) = tokio::sync::mpsc::channel(1);
    let script = tokio::task::spawn_blocking(move || {
        testkit::browser::run("fleet.mjs", &[&address, &password], |line| {
            if line == "stop the server" {
                ask_to_stop.blocking_send(()).unwrap();
            }
        });
    });
    if asked.recv().await.is_some() {
        serving.stop().await;
    }
    script.await.unwrap();
}

/// What the boat of a test does, as its script says.
#[derive(Default)]
struct Doing {
    silent: AtomicBool,
    empty: AtomicBool,
    astray: AtomicBool,
    /// It tells everything but where it is.
    placeless: AtomicBool,
    /// Of each priority something is wrong with it.
    wrecked: AtomicBool,
}

/// Parts that are not well, an alarm of each priority together.
const WRECK: [(u8, &str, EntityStateState); 5] = [
    (20, "Grounding", EntityStateState::Error),
    (21, "Motor Port", EntityStateState::Error),
    (22, "Motor Starboard", EntityStateState::Error),
    (23, "Camera", EntityStateState::Error),
    (24, "Lights", EntityStateState::Fault),
];

/// Lets the boat speak five times a second, for as long as the test lasts.
async fn speak(boats: Boats, doing: Arc<Doing>) {
    let mut interval = tokio::time::interval(std::time::Duration::from_millis(200));
    loop {
        interval.tick().await;
        if doing.silent.load(Ordering::Relaxed) {
            continue;
        }
        let now = clock::now();
        let (op_mode, maneuver_type) = (VehicleStateOpMode::Maneuver, 450);
        let value = if doing.empty.load(Ordering::Relaxed) { 24.0 } else { 87.0 };
        let state = if doing.astray.load(Ordering::Relaxed) {
            EntityStateState::Error
        } else {
            EntityStateState::Normal
        };
        // Without the log book's line, which is the other test's.
        let mut said = boat(0, now);
        said.pop();
        if doing.placeless.load(Ordering::Relaxed) {
            said.retain(|packet| {
                imc::PacketView::new(packet).is_ok_and(|view| view.id() != EstimatedState::ID)
            });
        }
        let act = units::UtcTime::from_micros(now.micros() + 300_000_000);
        let act = clock::written(act)[11..19].to_owned();
        let words = format!("in contact; without: hold at {act} UTC");
        let (state_of_loss, description) = (EntityStateState::Normal, words.as_str().into());
        let label = "Lost Communications".into();
        said.extend([
            packet(0, 255, now, EntityInfo { id: 9, label, ..EntityInfo::default() }),
            packet(0, 9, now, EntityState { state: state_of_loss, description, ..EntityState::default() }),
            packet(0, 255, now, VehicleState { op_mode, maneuver_type, ..VehicleState::default() }),
            packet(0, 4, now, FuelLevel { value, ..FuelLevel::default() }),
            packet(0, 1, now, EntityState { state, ..EntityState::default() }),
        ]);
        if doing.wrecked.load(Ordering::Relaxed) {
            for (id, label, state) in WRECK {
                let info = EntityInfo { id, label: label.into(), ..EntityInfo::default() };
                let description = "as a test wants it".into();
                let worst = EntityState { state, description, ..EntityState::default() };
                said.extend([packet(0, 255, now, info), packet(0, id, now, worst)]);
            }
        }
        boats.say(said).await;
    }
}

/// Every page and what opens on it, with an alarm of each priority, before axe.
#[tokio::test(flavor = "multi_thread")]
async fn every_page_is_accessible_in_all_palettes_and_with_every_alarm() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let doing = Arc::new(Doing { wrecked: AtomicBool::new(true), ..Doing::default() });
    tokio::spawn(speak(Boats::join(&serving.state.shore.router).await, doing));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let script = move || testkit::browser::run("every-page.mjs", &[&address, &password], |_| {});
    tokio::task::spawn_blocking(script).await.unwrap();
    serving.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn alarms_are_told_acknowledged_and_over() {
    before_a_boat("alarms.mjs").await;
}

/// Alarms, people, vessels and tokens without a pointer.
#[tokio::test(flavor = "multi_thread")]
async fn alarms_and_people_are_managed_by_keyboard_alone() {
    before_a_boat("keyboard-admin.mjs").await;
}

/// A system that nobody registered and that is gone does not come to the main STOP.
#[tokio::test(flavor = "multi_thread")]
async fn a_lost_stranger_never_takes_the_main_stop() {
    before_a_boat("stranger.mjs").await;
}

/// A part of a page that fails leaves nothing that looks fresh.
#[tokio::test(flavor = "multi_thread")]
async fn a_page_that_fails_says_so_and_is_grey() {
    before_a_boat("failing.mjs").await;
}

/// Over a path that keeps connections open and delivers nothing.
#[tokio::test(flavor = "multi_thread")]
async fn a_stop_gets_through_as_soon_as_anything_does() {
    before_a_boat("stop-hole.mjs").await;
}

/// Runs a script before a boat that does what the script says.
async fn before_a_boat(script: &'static str) {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let doing = Arc::new(Doing::default());
    tokio::spawn(speak(Boats::join(&serving.state.shore.router).await, Arc::clone(&doing)));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (ask_to_stop, mut asked) = tokio::sync::mpsc::channel(1);
    let script = tokio::task::spawn_blocking(move || {
        testkit::browser::run(script, &[&address, &password], |line| match line {
            "silence" => doing.silent.store(true, Ordering::Relaxed),
            "speak" => doing.silent.store(false, Ordering::Relaxed),
            "empty" => doing.empty.store(true, Ordering::Relaxed),
            "full" => doing.empty.store(false, Ordering::Relaxed),
            "lost" => doing.astray.store(true, Ordering::Relaxed),
            "stop the server" => ask_to_stop.blocking_send(()).unwrap(),
            _ => {}
        });
    });
    if asked.recv().await.is_some() {
        serving.stop().await;
    }
    script.await.unwrap();
}

/// What nobody should believe to be names and values.
fn hostile(entity: &imc::Text) -> EntityParameters {
    let one = |name: &str, value: &str| EntityParameter { name: name.into(), value: value.into() };
    let (long, longer) = ("n".repeat(400), "<b>v</b> ".repeat(3_000));
    let params = [
        one("Sample Rate", "5"),
        one("<img src=x onerror=alert(1)>", "\"><script>alert(2)</script>"),
        one(&long, &longer),
        one("\u{202e}gnp", "\n\n\t"),
    ];
    EntityParameters { name: entity.clone(), params: params.into_iter().collect() }
}

/// A vessel of another program: its parameters are names and values, whatever stands in them.
#[tokio::test(flavor = "multi_thread")]
async fn parameters_of_a_foreign_vessel_are_shown_as_they_are() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let boats = Boats::join(&serving.state.shore.router).await;
    boats.sail();
    tokio::spawn(async move {
        loop {
            for asked in boats.heard_together(QueryEntityParameters::ID).await {
                let asked: QueryEntityParameters =
                    imc::decode(&imc::PacketView::new(&asked).unwrap()).unwrap().unwrap();
                // Some parts of a vessel say nothing.
                if asked.name != "Spare" {
                    boats.say(vec![packet(0, 1, clock::now(), hostile(&asked.name))]).await;
                }
            }
        }
    });
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let script = tokio::task::spawn_blocking(move || {
        testkit::browser::run("foreign.mjs", &[&address, &password], |_| {});
    });
    script.await.unwrap();
    serving.stop().await;
}

/// Nothing old looks fresh: a silent vessel, a silent receiver, a tab that slept, a clock that was set, no server.
#[tokio::test(flavor = "multi_thread")]
async fn nothing_old_looks_fresh_on_any_view() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let doing = Arc::new(Doing::default());
    tokio::spawn(speak(Boats::join(&serving.state.shore.router).await, Arc::clone(&doing)));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (ask_to_stop, mut asked) = tokio::sync::mpsc::channel(1);
    let script = tokio::task::spawn_blocking(move || {
        testkit::browser::run("freshness.mjs", &[&address, &password], |line| match line {
            "silence" => doing.silent.store(true, Ordering::Relaxed),
            "speak" => doing.silent.store(false, Ordering::Relaxed),
            "no place" => doing.placeless.store(true, Ordering::Relaxed),
            "place" => doing.placeless.store(false, Ordering::Relaxed),
            "stop the server" => ask_to_stop.blocking_send(()).unwrap(),
            _ => {}
        });
    });
    if asked.recv().await.is_some() {
        serving.stop().await;
    }
    script.await.unwrap();
}

/// 2026-11-21 08:00 UTC.
const PAST_US: i64 = 1_795_248_000_000_000;
const ENTRIES: i64 = 10_500;

/// More of a boat's past than a page shows at once: a log book with an entry each second, tags, and two minutes of places.
fn long_past(data: &Path) {
    let list = EntityList { op: EntityListOp::Report, list: "Navigation=1;Receiver=2".into() };
    let announce = Announce { sys_name: "otter-0".into(), ..Announce::default() };
    let mut said: Vec<(u8, i64, Message)> =
        vec![(255, PAST_US, list.into()), (255, PAST_US, announce.into())];
    for number in 0..ENTRIES {
        let kinds = [
            LogBookEntryType::Info,
            LogBookEntryType::Warning,
            LogBookEntryType::Error,
            LogBookEntryType::Critical,
            LogBookEntryType::Debug,
        ];
        let context = if number % 3 == 0 { "" } else { "=Task, \"<b>\"" };
        let text = format!("entry {number} =1+1, \"quoted\"");
        let r#type = kinds[usize::try_from(number % 5).unwrap()];
        let entry = LogBookEntry {
            r#type,
            text: text.as_str().into(),
            context: context.into(),
            ..LogBookEntry::default()
        };
        // Two of each time.
        said.push((1, PAST_US + number / 2 * 2_000_000, entry.into()));
    }
    for number in 0..5_200_u32 {
        let along = f64::from(number) / 5_200.0;
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: u32::try_from(PAST_US / 1_000_000).unwrap() + number,
            millis: 250,
            trans_id: u16::try_from(100 + number % 7).unwrap().into(),
            trans_data: u16::try_from(number % 256).unwrap(),
            snr: u8::try_from(6 + number % 40).unwrap(),
            trans_freq: 69,
            lat: Some((63.44 + 0.004 * along).to_radians()),
            lon: Some((10.40 - 0.006 * along).to_radians()),
            ..TBRFishTag::default()
        };
        said.push((2, PAST_US + i64::from(number) * 1_000_000 + 500_000, tag.into()));
    }
    for number in 0..40_u8 {
        let along = f64::from(number) / 40.0;
        let state = EstimatedState {
            lat: (63.44 + 0.001 * along).to_radians(),
            lon: (10.40 + 0.002 * along * along).to_radians(),
            u: f32::from(number) * 0.053 - 0.5,
            ..EstimatedState::default()
        };
        said.push((1, PAST_US + i64::from(number) * 3_000_000 + 1_000_000, state.into()));
    }
    super::history_tests::put(data, &said);
}

/// CSV holds what the page shows, value by value, and more of it where the page shows a part.
#[tokio::test(flavor = "multi_thread")]
async fn what_is_taken_away_is_what_is_shown() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    long_past(folder.path());
    let serving = serve(quiet(folder.path())).await.unwrap();
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (from, to) = (PAST_US.to_string(), (PAST_US + ENTRIES * 1_000_000).to_string());
    let script = move || testkit::browser::run("taken.mjs", &[&address, &password, &from, &to], |_| {});
    tokio::task::spawn_blocking(script).await.unwrap();
    serving.stop().await;
}

/// A server on a free port that says nothing itself.
pub(super) fn quiet(data: &Path) -> Config {
    let mut config = Config { data: data.to_owned(), ..Config::default() };
    config.imc.active = false;
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config
}
