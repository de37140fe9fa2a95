//! Two people, one boat: the vessel itself obeys the holder of the lease.

use crate::common::{CONSOLE, OTTER, Sea, frame};
use imc::messages::*;
use imc::{Header, Packet};
use onboard::{Input, Lease, Mandate, Peer};
use std::time::Duration;
use units::LocalPoint;

/// The shore among the peers, and its address.
const SHORE: Peer = Peer::Tcp(u32::MAX);
const SHORE_ADDRESS: imc::Address = imc::Address(0x4100);

/// The number ashore of every order here.
const COMMAND: u64 = 1_790_000_000_000;

fn lease(sea: &mut Sea, epoch: u64, seconds: u64) {
    let holder = format!("holder {epoch}");
    sea.tell(Input::Lease(Lease { epoch, lasts: Duration::from_secs(seconds), holder }));
}

/// An order over the link under a lease.
fn order(sea: &mut Sea, epoch: u64, message: impl Into<Message>) {
    let timestamp = sea.vehicle.now.utc.seconds();
    let header = Header { timestamp, src: SHORE_ADDRESS, dst: OTTER, ..Header::default() };
    let mandate = Mandate { lease: epoch, command: COMMAND };
    sea.tell(Input::Order(SHORE, mandate, Packet::new(header, message).encode().unwrap()));
}

/// Keeping station somewhere, as a plan of one maneuver.
fn start(plan_id: &str) -> PlanControl {
    let place = frame().to_place(LocalPoint { north_m: 50.0, east_m: 0.0 });
    let station = StationKeeping {
        lat: place.lat_rad(),
        lon: place.lon_rad(),
        radius: 10.0,
        speed: 1.0,
        speed_units: SpeedUnits::MetersPs,
        z_units: ZUnits::Depth,
        ..StationKeeping::default()
    };
    PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        request_id: 9,
        plan_id: plan_id.into(),
        arg: Some(Message::from(station)).into(),
        ..PlanControl::default()
    }
}

fn stop() -> PlanControl {
    PlanControl { r#type: PlanControlType::Request, op: PlanControlOp::Stop, ..PlanControl::default() }
}

fn runs(sea: &mut Sea) -> Option<String> {
    sea.run(1.0);
    let state = sea.plan_state();
    let executing = state.state == PlanControlStateState::Executing;
    executing.then(|| state.plan_id.to_str_lossy().into_owned())
}

/// The vessel's last answer about plans, and to whom.
fn answer(sea: &Sea) -> (PlanControlType, String, imc::Address) {
    let mut own = sea.said.iter().rev().filter(|(_, packet)| packet.header.src == OTTER);
    let found = own.find_map(|(_, packet)| {
        let answer = packet.get::<PlanControl>()?;
        Some((answer.r#type, answer.info.to_str_lossy().into_owned(), packet.header.dst))
    });
    found.unwrap()
}

fn entries(sea: &Sea, words: &str) -> usize {
    let entries = sea.all::<LogBookEntry>();
    entries.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains(words)).count()
}

#[test]
fn of_two_people_the_vessel_obeys_the_one_with_the_lease() {
    let mut sea = Sea::new();
    sea.run(5.0);
    lease(&mut sea, 7, 30);
    order(&mut sea, 7, start("first"));
    assert_eq!(runs(&mut sea).as_deref(), Some("first"));
    // Another takes over; what the first one sent on a slow link comes afterwards.
    lease(&mut sea, 8, 30);
    order(&mut sea, 7, stop());
    assert_eq!(runs(&mut sea).as_deref(), Some("first"));
    let (kind, info, to) = answer(&sea);
    assert_eq!((kind, to), (PlanControlType::Failure, SHORE_ADDRESS));
    assert!(info.contains("has ended"), "{info}");
    order(&mut sea, 8, start("second"));
    assert_eq!(runs(&mut sea).as_deref(), Some("second"));
}

#[test]
fn the_log_book_says_which_command_of_the_shore_led_to_what() {
    let mut sea = Sea::new();
    sea.run(5.0);
    lease(&mut sea, 7, 30);
    order(&mut sea, 7, start("first"));
    order(&mut sea, 6, start("second"));
    order(&mut sea, 0, Abort);
    sea.run(1.0);
    let told: Vec<(String, bool)> = sea
        .all::<LogBookEntry>()
        .iter()
        .map(|(_, entry)| {
            let text = entry.text.to_str_lossy();
            let (text, command) = imc::logbook::split_command(&text);
            (text.to_owned(), command == Some(COMMAND))
        })
        .collect();
    let of = |words: &str| told.iter().find(|(text, _)| text.contains(words)).map(|(_, named)| *named);
    for words in ["request start 'first'", "first: plan initializing", "has ended", "stopped by 0x4100"] {
        assert_eq!(of(words), Some(true), "{words}: {told:?}");
    }
    assert_eq!(of("holder 7 has control"), Some(false), "no command: {told:?}");
}

#[test]
fn consoles_are_refused_while_a_lease_lives_and_obeyed_when_it_has_died() {
    let mut sea = Sea::new();
    sea.run(5.0);
    lease(&mut sea, 7, 30);
    assert_eq!(entries(&sea, "holder 7 has control"), 1);
    for _ in 0..20 {
        sea.send(start("console"));
    }
    assert_eq!(runs(&mut sea), None);
    let (kind, info, to) = answer(&sea);
    assert_eq!((kind, to), (PlanControlType::Failure, CONSOLE));
    assert!(info.contains("holder 7 has control"), "{info}");
    assert_eq!(entries(&sea, "is refused: holder 7"), 1, "one line for a burst");
    // Writes to the database are refused, reads are answered.
    sea.send(PlanDB {
        r#type: PlanDBType::Request,
        op: PlanDBOp::Del,
        plan_id: "x".into(),
        ..PlanDB::default()
    });
    let deleted: PlanDB = sea.last().unwrap();
    assert_eq!(deleted.r#type, PlanDBType::Failure);
    assert!(deleted.info.to_str_lossy().contains("holder 7"), "{deleted:?}");
    sea.send(PlanDB { r#type: PlanDBType::Request, op: PlanDBOp::GetState, ..PlanDB::default() });
    assert_eq!(sea.last::<PlanDB>().unwrap().r#type, PlanDBType::Success);
    // The shore falls silent.
    sea.run(30.0);
    sea.send(start("console"));
    assert_eq!(runs(&mut sea).as_deref(), Some("console"));
}

#[test]
fn an_abort_is_never_refused() {
    let mut sea = Sea::new();
    sea.run(5.0);
    lease(&mut sea, 7, 30);
    order(&mut sea, 7, start("mine"));
    assert_eq!(runs(&mut sea).as_deref(), Some("mine"));
    sea.send(stop());
    assert_eq!(runs(&mut sea).as_deref(), Some("mine"));
    sea.send(Abort);
    assert_eq!(runs(&mut sea), None);
}

#[test]
fn keys_of_others_move_nothing_while_a_lease_lives() {
    let mut sea = Sea::new();
    sea.run(5.0);
    lease(&mut sea, 7, 300);
    let teleoperation = Teleoperation { custom: format!("src={}", SHORE_ADDRESS.0).as_str().into() };
    let session =
        PlanControl { arg: Some(Message::from(teleoperation)).into(), ..start("teleoperation-mode") };
    order(&mut sea, 7, session);
    assert!(runs(&mut sea).is_some());
    let keys = || RemoteActions { actions: "Port Motor=100;Starboard Motor=100".into() };
    let moved = |sea: &Sea| sea.motors.iter().any(|(_, pair)| pair.port != 0.0 || pair.starboard != 0.0);
    sea.motors.clear();
    for epoch in [0, 6] {
        for _ in 0..10 {
            order(&mut sea, epoch, keys());
            sea.run(0.1);
        }
    }
    assert!(!moved(&sea));
    for _ in 0..10 {
        order(&mut sea, 7, keys());
        sea.run(0.1);
    }
    assert!(moved(&sea));
}
