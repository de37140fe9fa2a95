//! The first page in a real browser, on a made-up fleet.

use super::testing::{Boats, an_hour, boat, packet};
use crate::config::Config;
use crate::serve::{Serving, serve, serve_by};
use bytes::Bytes;
use detections::{Detection, Effort, Origin, Pose, Protocol, ReceiverClock};
use hub::{Incoming, Lane, LinkSeq};
use imc::messages::{
    Abort, Announce, EntityInfo, EntityList, EntityListOp, EntityParameter, EntityParameters, EntityState,
    EntityStateState, EstimatedState, Event, FuelLevel, LogBookEntry, LogBookEntryType, Message,
    Payload as _, PlanControl, PlanControlType, QueryEntityParameters, TBRFishTag, VehicleState,
    VehicleStateOpMode,
};
use shore::clock::{self, Clock, ClockHand};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use units::{LatLon, UtcTime};

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

/// Behaviour of a test's boat, as set by its script.
#[derive(Default)]
struct Doing {
    silent: AtomicBool,
    empty: AtomicBool,
    astray: AtomicBool,
    /// It reports everything but its position.
    placeless: AtomicBool,
    /// It has a fault of each priority.
    wrecked: AtomicBool,
}

/// Faulty entities, which together give an alarm of each priority.
const WRECK: [(u8, &str, EntityStateState); 5] = [
    (20, "Grounding", EntityStateState::Error),
    (21, "Motor Port", EntityStateState::Error),
    (22, "Motor Starboard", EntityStateState::Error),
    (23, "Camera", EntityStateState::Error),
    (24, "Lights", EntityStateState::Fault),
];

impl Doing {
    /// As the script says.
    fn hear(&self, line: &str) {
        let (what, is) = match line {
            "silence" => (&self.silent, true),
            "speak" => (&self.silent, false),
            "empty" => (&self.empty, true),
            "full" => (&self.empty, false),
            "lost" => (&self.astray, true),
            "no place" => (&self.placeless, true),
            "place" => (&self.placeless, false),
            _ => return,
        };
        what.store(is, Ordering::Relaxed);
    }

    /// The boat's packets at a time; none while it is silent.
    fn said(&self, now: UtcTime) -> Vec<Bytes> {
        if self.silent.load(Ordering::Relaxed) {
            return Vec::new();
        }
        let (op_mode, maneuver_type) = (VehicleStateOpMode::Maneuver, 450);
        let value = if self.empty.load(Ordering::Relaxed) { 24.0 } else { 87.0 };
        let state = if self.astray.load(Ordering::Relaxed) {
            EntityStateState::Error
        } else {
            EntityStateState::Normal
        };
        // Without the log book's line, which is the other test's.
        let mut said = boat(0, now);
        said.pop();
        if self.placeless.load(Ordering::Relaxed) {
            said.retain(|packet| {
                imc::PacketView::new(packet).is_ok_and(|view| view.id() != EstimatedState::ID)
            });
        }
        let act = UtcTime::from_micros(now.micros() + 300_000_000);
        let act = clock::written(act)[11..19].to_owned();
        let words = format!("in contact; without: hold at {act} UTC");
        let (state_of_loss, description) = (EntityStateState::Normal, words.as_str().into());
        let label = "Lost Communications".into();
        said.extend([
            packet(0, 255, now, EntityInfo { id: 9, label, ..EntityInfo::default() }),
            packet(0, 9, now, EntityState { state: state_of_loss, description, ..EntityState::default() }),
            packet(
                0,
                9,
                now,
                Event { topic: "EntityStateValues".into(), data: "lost=0;due_s=300;then=hold".into() },
            ),
            packet(0, 255, now, VehicleState { op_mode, maneuver_type, ..VehicleState::default() }),
            packet(0, 4, now, FuelLevel { value, ..FuelLevel::default() }),
            packet(0, 1, now, EntityState { state, ..EntityState::default() }),
        ]);
        if self.wrecked.load(Ordering::Relaxed) {
            for (id, label, state) in WRECK {
                let info = EntityInfo { id, label: label.into(), ..EntityInfo::default() };
                let description = "as a test wants it".into();
                let worst = EntityState { state, description, ..EntityState::default() };
                said.extend([packet(0, 255, now, info), packet(0, id, now, worst)]);
            }
        }
        said
    }
}

/// Lets the boat send five times a second, for the duration of the test.
async fn speak(boats: Boats, clock: Clock, doing: Arc<Doing>) {
    let mut interval = tokio::time::interval(Duration::from_millis(200));
    loop {
        interval.tick().await;
        boats.say(doing.said(clock.utc())).await;
    }
}

/// Every page and what opens on it, with an alarm of each priority, checked by axe.
#[tokio::test(flavor = "multi_thread")]
async fn every_page_is_accessible_in_all_palettes_and_with_every_alarm() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let doing = Arc::new(Doing { wrecked: AtomicBool::new(true), ..Doing::default() });
    let clock = serving.state.shore.clock.clone();
    tokio::spawn(speak(Boats::join(&serving.state.shore.router).await, clock, doing));
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

/// Alarms sent by a webhook to people who have no page open.
#[tokio::test(flavor = "multi_thread")]
async fn alarms_reach_people_who_look_at_no_page() {
    before_a_boat("notices.mjs").await;
}

/// Alarms in Bokmål: bar, list, advice, card, notification and history.
#[tokio::test(flavor = "multi_thread")]
async fn alarms_are_said_in_bokmal_to_who_chose_it() {
    before_a_boat("alarms-nb.mjs").await;
}

/// A rule of messages about alarms, changed in its place.
#[tokio::test(flavor = "multi_thread")]
async fn a_rule_of_messages_is_changed_in_its_place() {
    before_a_boat("notices-change.mjs").await;
}

/// A refusal by the server or a vessel is shown in the person's language, listed and marked.
#[tokio::test(flavor = "multi_thread")]
async fn where_an_order_was_refused_is_said_and_marked() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    super::charts_tests::archipelago(folder.path());
    let serving = serve(quiet(folder.path())).await.unwrap();
    let boats = Boats::join(&serving.state.shore.router).await;
    tokio::spawn(lies_in_deep_water(boats.clone()));
    tokio::spawn(refuses_every_start(boats, serving.state.shore.router.address()));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let script = move || testkit::browser::run("refused.mjs", &[&address, &password], |_| {});
    tokio::task::spawn_blocking(script).await.unwrap();
    serving.stop().await;
}

/// Areas are closed and lifted on the map, and no user can send a vessel into one.
#[tokio::test(flavor = "multi_thread")]
async fn an_area_is_closed_on_the_map_and_nobody_is_sent_into_it() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    super::charts_tests::archipelago(folder.path());
    let serving = serve(quiet(folder.path())).await.unwrap();
    tokio::spawn(lies_in_deep_water(Boats::join(&serving.state.shore.router).await));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let script = move || testkit::browser::run("nogo.mjs", &[&address, &password], |_| {});
    tokio::task::spawn_blocking(script).await.unwrap();
    serving.stop().await;
}

/// A boat that reports its position in the archipelago, ten times a second, for the duration of the test.
async fn lies_in_deep_water(boats: Boats) {
    let (lat, lon) = (63.446_f64.to_radians(), 10.345_f64.to_radians());
    let mut interval = tokio::time::interval(Duration::from_millis(100));
    loop {
        interval.tick().await;
        let now = clock::now();
        let elsewhere =
            |said: &Bytes| imc::PacketView::new(said).is_ok_and(|view| view.id() == EstimatedState::ID);
        let mut said = boat(0, now);
        said.retain(|one| !elsewhere(one));
        said.push(packet(0, 1, now, EstimatedState { lat, lon, ..EstimatedState::default() }));
        boats.say(said).await;
    }
}

/// Answers each order to start something as a vessel's guard does: in a sentence.
async fn refuses_every_start(boats: Boats, shore: imc::Address) {
    loop {
        let packet = boats.heard(PlanControl::ID).await;
        let view = imc::PacketView::new(&packet).unwrap();
        let request: PlanControl = imc::decode(&view).unwrap().unwrap();
        let info =
            "'go' (transit 1): 2.5 m deep; needs 5.0 m at 63.44750, 10.34880 (DEPARE of XX5LUTRA)".into();
        let answer =
            PlanControl { r#type: PlanControlType::Failure, info, arg: None::<Message>.into(), ..request };
        let src = imc::Address(super::testing::FIRST);
        let header =
            imc::Header { src, dst: shore, timestamp: clock::now().seconds(), ..imc::Header::default() };
        boats.say(vec![imc::Packet::new(header, answer).encode().unwrap().into()]).await;
    }
}

/// Alarms, people, vessels and tokens without a pointer.
#[tokio::test(flavor = "multi_thread")]
async fn alarms_and_people_are_managed_by_keyboard_alone() {
    before_a_boat("keyboard-admin.mjs").await;
}

/// Animals and tags by hand and by a table, with errors reported before anything is changed.
#[tokio::test(flavor = "multi_thread")]
async fn a_biologist_registers_tags_and_animals() {
    before_a_boat("register.mjs").await;
}

/// An unregistered system that is gone does not appear in the main STOP.
#[tokio::test(flavor = "multi_thread")]
async fn a_lost_stranger_never_takes_the_main_stop() {
    before_a_boat("stranger.mjs").await;
}

/// If a part of a page fails, nothing on it looks fresh.
#[tokio::test(flavor = "multi_thread")]
async fn a_page_that_fails_says_so_and_is_grey() {
    before_a_boat("failing.mjs").await;
}

/// Control ends automatically when its page is closed, and other viewers see that it expired.
#[tokio::test(flavor = "multi_thread")]
async fn control_whose_page_is_gone_ends_by_itself() {
    before_a_boat("lease-left.mjs").await;
}

/// Over a network path that keeps connections open and delivers nothing.
#[tokio::test(flavor = "multi_thread")]
async fn a_stop_gets_through_as_soon_as_anything_does() {
    before_a_boat("stop-hole.mjs").await;
}

/// One line above, nothing cut off, and the map in the first screen at 390 px and at 1024x768.
#[tokio::test(flavor = "multi_thread")]
async fn small_screens_cut_nothing_off() {
    before_a_boat("narrow.mjs").await;
}

/// A row that is a card is still heard as a row of its table.
#[tokio::test(flavor = "multi_thread")]
async fn tables_are_tables_on_a_phone_to_who_hears_them() {
    before_a_boat("cards.mjs").await;
}

/// What grows above the focus takes it out of nobody's sight.
#[tokio::test(flavor = "multi_thread")]
async fn a_focus_by_keyboard_stays_in_sight_and_no_scrolling_is_undone() {
    before_a_boat("insight.mjs").await;
}

/// STOP of all vessels asks once, goes to each of them, and tells what became of each.
#[tokio::test(flavor = "multi_thread")]
async fn stop_all_goes_to_each_vessel_after_two_steps() {
    let Some(aborted) = before_two_boats("stop-all.mjs").await else { return };
    let [first, second] = [super::testing::FIRST, super::testing::FIRST + 1];
    assert_eq!(aborted, BTreeSet::from([first, second]), "each vessel that is heard");
}

/// With Bokmål chosen every page is in Bokmål, nothing is cut off, and STOP stops the vessel that it names.
#[tokio::test(flavor = "multi_thread")]
async fn the_pages_speak_bokmal_to_who_chose_it() {
    let Some(aborted) = before_two_boats("bokmal.mjs").await else { return };
    assert_eq!(aborted, BTreeSet::from([super::testing::FIRST]), "the one that was stopped");
}

/// What the server refuses, and what became of an order, is said in Bokmål too.
#[tokio::test(flavor = "multi_thread")]
async fn refusals_and_outcomes_are_said_in_bokmal() {
    before_two_boats("bokmal-refusals.mjs").await;
}

/// Runs a script before two boats of which the first stops when it is told to; which were told to.
async fn before_two_boats(script: &'static str) -> Option<BTreeSet<u16>> {
    if !testkit::browser::is_there() {
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let boats = Boats::join(&serving.state.shore.router).await;
    let stopped = Arc::new(AtomicBool::new(false));
    tokio::spawn(two_sail(boats.clone(), Arc::clone(&stopped)));
    let aborted = Arc::new(Mutex::new(BTreeSet::new()));
    let told = Arc::clone(&aborted);
    tokio::spawn(async move {
        loop {
            for packet in boats.heard_together(Abort::ID).await {
                let vessel = imc::PacketView::new(&packet).unwrap().header().dst.0;
                told.lock().unwrap().insert(vessel);
                // The first one stops, the second continues.
                stopped.fetch_or(vessel == super::testing::FIRST, Ordering::Relaxed);
            }
        }
    });
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let script = move || testkit::browser::run(script, &[&address, &password], |_| {});
    tokio::task::spawn_blocking(script).await.unwrap();
    let all = aborted.lock().unwrap().clone();
    Some(all)
}

/// Two boats that report their state, ten times a second, for the duration of the test.
async fn two_sail(boats: Boats, stopped: Arc<AtomicBool>) {
    let mut interval = tokio::time::interval(Duration::from_millis(100));
    loop {
        interval.tick().await;
        let now = clock::now();
        for number in [0, 1] {
            let stands = number == 0 && stopped.load(Ordering::Relaxed);
            let op_mode = if stands { VehicleStateOpMode::Error } else { VehicleStateOpMode::Maneuver };
            let mut said = boat(number, now);
            said.push(packet(number, 255, now, VehicleState { op_mode, ..VehicleState::default() }));
            boats.say(said).await;
        }
    }
}

/// Runs a script with a boat that does what the script says.
async fn before_a_boat(script: &'static str) {
    if testkit::browser::is_there() {
        Scene::set().await.play(script).await;
    }
}

/// A server with a clock that can be moved, and a boat.
struct Scene {
    serving: Serving,
    boats: Boats,
    doing: Arc<Doing>,
    clock: Clock,
    hand: ClockHand,
    _folder: tempfile::TempDir,
}

impl Scene {
    async fn set() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (clock, hand) = Clock::with_hand();
        let serving = serve_by(clock.clone(), quiet(folder.path())).await.unwrap();
        let (boats, doing) = (Boats::join(&serving.state.shore.router).await, Arc::new(Doing::default()));
        tokio::spawn(speak(boats.clone(), clock.clone(), Arc::clone(&doing)));
        Self { serving, boats, doing, clock, hand, _folder: folder }
    }

    /// Runs a script, and does what it says.
    async fn play(self, script: &'static str) {
        let address = format!("http://{}", self.serving.address);
        let password = self.serving.first_admin().unwrap().1.to_owned();
        let (say, mut said) = tokio::sync::mpsc::channel(16);
        let script = tokio::task::spawn_blocking(move || {
            let tell = |line: &str| say.blocking_send(line.to_owned()).unwrap();
            testkit::browser::run(script, &[&address, &password], tell);
        });
        let (router, mut serving) = (self.serving.state.shore.router.clone(), Some(self.serving));
        while let Some(line) = said.recv().await {
            if let Some(seconds) = line.strip_prefix("advance ") {
                let by = Duration::from_secs(seconds.parse().unwrap());
                let (hand, then) = (self.hand.clone(), self.clock.utc().micros() + by.as_micros() as i64);
                // The boat's packets are processed before a check whether it is heard: the hub works in order.
                let moved = router.inspect(move |_, _| hand.advance(by));
                let spoken = self.boats.say(self.doing.said(UtcTime::from_micros(then)));
                tokio::join!(moved, spoken).0.unwrap();
            } else if let Some(what) = line.strip_prefix("hear ") {
                self.boats.give(heard(what, self.clock.utc())).await;
            } else if line == "stop the server" {
                serving.take().unwrap().stop().await;
            } else {
                self.doing.hear(&line);
            }
        }
        script.await.unwrap();
    }
}

/// The boat's detection of a tag of this number: `brief` as a TBRFishTag alone, `whole` as both messages, `nameless` with a
/// coding without a number and a clock that is not set, `late` as a record of ten minutes ago.
fn heard(what: &str, now: UtcTime) -> Vec<Incoming> {
    let (number, how) = what.split_once(' ').unwrap();
    let (tag_id, late) = (number.parse().unwrap(), how == "late");
    let reported = UtcTime::from_micros(now.micros() - if late { 600_000_000 } else { 0 });
    let place = LatLon::from_deg(63.44, 10.40).unwrap();
    let nameless = how == "nameless";
    let seconds = if nameless { 600 } else { u32::try_from(reported.micros() / 1_000_000).unwrap() - 4 };
    let one = Detection {
        origin: Origin { system: imc::Address(super::testing::FIRST), entity: 9, reported, received: None },
        receiver: 1_024,
        maker: None,
        clock: ReceiverClock::read(seconds, 250),
        protocol: Protocol::named(if nameless { "OPi" } else { "R64K" }),
        tag_id,
        data: None,
        snr_db: Some(30),
        frequency_khz: Some(69),
        line: 7,
        pose: Some(Pose { place, age_s: Some(0.4), sigma_m: Some(0.8) }),
        effort: Effort::default(),
        raw: Some("$001024,a line".to_owned()),
    };
    let brief = one.fish_tag().map(|tag| packet(0, 9, reported, tag));
    let whole = (how != "brief").then(|| packet(0, 9, reported, one.report()));
    let lane = if late { Lane::Backlog } else { Lane::Present };
    let link = |at: usize| LinkSeq { stream: 7, seq: u64::from(tag_id) * 2 + at as u64 };
    let incoming = |(at, packet)| Incoming { packet, link: late.then(|| link(at)), lane };
    brief.into_iter().chain(whole).enumerate().map(incoming).collect()
}

/// A detection appears on the page at once, without a request; missed ones are requested once.
#[tokio::test(flavor = "multi_thread")]
async fn a_tag_that_is_heard_comes_by_itself() {
    before_a_boat("heard.mjs").await;
}

/// If the server cannot be reached, an opened page says so, and appears automatically when it can.
#[tokio::test(flavor = "multi_thread")]
async fn a_page_that_is_opened_without_a_link_says_so_and_comes_later() {
    before_a_boat("offline.mjs").await;
}

/// Follow, course up and range rings of the vessel that is chosen.
#[tokio::test(flavor = "multi_thread")]
async fn the_map_goes_with_the_vessel_that_is_chosen() {
    before_a_boat("maptools.mjs").await;
}

/// Help on keys and terms, by one key on every page.
#[tokio::test(flavor = "multi_thread")]
async fn help_is_one_key_away() {
    before_a_boat("help.mjs").await;
}

/// The manual before the login, each chapter at a desk and on a phone, its search, and the way from an alarm to its section.
/// Takes long, for it looks at every chapter.
#[tokio::test(flavor = "multi_thread")]
async fn the_manual_is_read_by_anyone_and_reached_from_alarms() {
    before_a_boat("manual.mjs").await;
}

/// The place of the person at the device, with consent, and nowhere but on the page.
#[tokio::test(flavor = "multi_thread")]
async fn the_place_of_the_person_is_shown_and_not_sent() {
    before_a_boat("own-place.mjs").await;
}

/// All detections: loaded automatically, filtered, and the file of exactly what is shown.
#[tokio::test(flavor = "multi_thread")]
async fn all_detections_are_shown_filtered_and_taken_away() {
    before_a_boat("detections.mjs").await;
}

/// Hostile names and values.
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

/// A vessel of another program: its parameters are shown as names and values, whatever they contain.
#[tokio::test(flavor = "multi_thread")]
async fn parameters_of_a_foreign_vessel_are_shown_as_they_are() {
    if !testkit::browser::is_there() {
        return;
    }
    let scene = Scene::set().await;
    let (boats, clock) = (scene.boats.clone(), scene.clock.clone());
    tokio::spawn(async move {
        loop {
            for asked in boats.heard_together(QueryEntityParameters::ID).await {
                let asked: QueryEntityParameters =
                    imc::decode(&imc::PacketView::new(&asked).unwrap()).unwrap().unwrap();
                // Some entities of a vessel are silent.
                if asked.name != "Spare" {
                    boats.say(vec![packet(0, 1, clock.utc(), hostile(&asked.name))]).await;
                }
            }
        }
    });
    scene.play("foreign.mjs").await;
}

/// Nothing old looks fresh: a silent vessel, a silent receiver, a tab that slept, a clock that was set, no server.
#[tokio::test(flavor = "multi_thread")]
async fn nothing_old_looks_fresh_on_any_view() {
    before_a_boat("freshness.mjs").await;
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

/// CSV contains what the page shows, value by value, and the rest where the page shows only a part.
#[tokio::test(flavor = "multi_thread")]
async fn what_is_taken_away_is_what_is_shown() {
    over_a_long_past("taken.mjs").await;
}

/// Files of the history: their size before the download, errors at their field, and the promised contents.
#[tokio::test(flavor = "multi_thread")]
async fn files_are_chosen_by_day_and_hold_what_was_promised() {
    over_a_long_past("data.mjs").await;
}

/// Plots of detections by a query in the page's address, and their files.
#[tokio::test(flavor = "multi_thread")]
async fn a_biologist_explores_detections() {
    over_a_long_past("explore.mjs").await;
}

/// A dataset of what the explorer shows, published, and shared by a link with a person without an account.
#[tokio::test(flavor = "multi_thread")]
async fn a_biologist_publishes_a_dataset_and_shares_it() {
    over_a_long_past("datasets.mjs").await;
}

/// The log book: written, found, corrected and withdrawn by keyboard and on a phone, with a photo and errors at their field.
#[tokio::test(flavor = "multi_thread")]
async fn notes_are_written_found_and_corrected() {
    over_a_long_past("logbook.mjs").await;
}

/// A note whose answer is lost is sent again automatically, and stored once.
#[tokio::test(flavor = "multi_thread")]
async fn a_note_whose_answer_is_lost_is_sent_again_and_is_one_note() {
    over_a_long_past("logbook-retry.mjs").await;
}

/// Missions that other users begin, change and withdraw are updated in the list automatically.
#[tokio::test(flavor = "multi_thread")]
async fn the_list_of_missions_follows_what_others_do() {
    over_a_long_past("missions-follow.mjs").await;
}

/// A mission: recorded, changed, with its replay, summary, files and notes, printed and withdrawn.
#[tokio::test(flavor = "multi_thread")]
async fn missions_are_written_down_summed_up_and_printed() {
    over_a_long_past("missions.mjs").await;
}

/// Runs a script on a server with [`long_past`], and passes it the time span.
async fn over_a_long_past(script: &'static str) {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    long_past(folder.path());
    let serving = serve(quiet(folder.path())).await.unwrap();
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let (from, to) = (PAST_US.to_string(), (PAST_US + ENTRIES * 1_000_000).to_string());
    let run = move || testkit::browser::run(script, &[&address, &password, &from, &to], |_| {});
    tokio::task::spawn_blocking(run).await.unwrap();
    serving.stop().await;
}

/// A server on a free port that sends nothing itself.
pub(super) fn quiet(data: &Path) -> Config {
    let mut config = Config { data: data.to_owned(), ..Config::default() };
    config.imc.active = false;
    config.notices.webhooks = shore::notices::Webhooks::Any;
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config
}
