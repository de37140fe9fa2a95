//! Motors are armed when all is good, or a person says why not.

use crate::common::*;
use imc::messages::*;
use onboard::{Chart, Entity, Settings};

fn goto() -> Message {
    let place = frame().origin();
    let maneuver = Goto {
        lat: place.lat_rad() + 1e-5,
        lon: place.lon_rad(),
        speed: 1.0,
        speed_units: SpeedUnits::MetersPs,
        ..Goto::default()
    };
    maneuver.into()
}

/// The plan engine's answers to the last request to start.
fn start(sea: &mut Sea) -> (PlanControlType, String) {
    sea.forget();
    sea.ask(PlanControlOp::Start, "out", Some(goto()));
    let replies = sea.all::<PlanControl>();
    let (_, reply) = replies.last().unwrap();
    (reply.r#type, reply.info.to_string())
}

fn clock_is_off() -> Sea {
    let mut sea = Sea::new();
    sea.set_clock_ahead(5_000_000);
    sea.ready()
}

#[test]
fn before_anything_was_heard_each_thing_is_named() {
    let reason = "the file is broken".to_owned();
    let mut settings: Settings = settings();
    settings.grounding.chart = Chart::Unreadable { reason };
    settings.grounding.refuses_without = true;
    let mut sea = Sea::with(settings, |_| {});
    let (kind, info) = start(&mut sea);
    assert_eq!(kind, PlanControlType::Failure);
    for missing in ["position (", "heading (", "clock (not compared", "CAN (no feedback of the Motor Port)"] {
        assert!(info.contains(missing), "{missing}: {info}");
    }
    assert!(
        info.contains("chart (cannot be read: the file is broken)")
            && info.contains("`Override` of `Preflight`"),
        "{info}"
    );
}

#[test]
fn a_simulated_vessel_is_good_as_soon_as_it_is_ready_and_stays_armed() {
    let mut sea = Sea::new().ready();
    assert_eq!(start(&mut sea).0, PlanControlType::Success);
    sea.ask(PlanControlOp::Stop, "out", None);
    sea.set_clock_ahead(5_000_000);
    sea.run(3.0);
    assert_eq!(start(&mut sea).0, PlanControlType::Success, "it must be able to come home");
}

#[test]
fn a_wrong_clock_keeps_the_motors_off_until_a_person_says_why_not_and_only_for_this_run() {
    let mut sea = clock_is_off();
    let (kind, info) = start(&mut sea);
    assert_eq!(kind, PlanControlType::Failure);
    assert!(info.contains("missing: clock (+5.0 s off the satellites); mend it"), "{info}");
    sea.run(2.0);
    assert!(sea.motors.iter().all(|(_, motors)| *motors == control::MotorPair::STOPPED));

    sea.forget();
    sea.override_preflight("  sea trial without records ");
    let told: Vec<_> =
        sea.all::<LogBookEntry>().into_iter().map(|(_, entry)| entry.text.to_string()).collect();
    let words = "overrides the preflight: sea trial without records; missing: clock";
    assert!(told.iter().any(|text| text.contains(words)), "{told:?}");
    assert_eq!(start(&mut sea).0, PlanControlType::Success);

    let away_s = 1.0;
    sea.ask(PlanControlOp::Stop, "out", None);
    sea.run(1.0);
    sea.kill(settings(), away_s);
    let (kind, info) = start(&mut sea);
    assert_eq!(kind, PlanControlType::Failure, "the reason ended with the program: {info}");
}

#[test]
fn an_override_without_a_reason_is_none() {
    let mut sea = clock_is_off();
    sea.override_preflight("trial");
    sea.override_preflight(" ");
    assert_eq!(start(&mut sea).0, PlanControlType::Failure);
    sea.run(1.5);
    let of_preflight = |(_, packet): &(_, imc::Packet)| {
        let said =
            packet.get::<EntityState>().filter(|_| packet.header.src_ent == Entity::Preflight.number())?;
        Some((said.state, said.description.to_string()))
    };
    let (state, text) = sea.said.iter().rev().find_map(of_preflight).unwrap();
    assert_eq!(state, EntityStateState::Boot);
    assert!(text.starts_with("the motors are not armed; missing: clock"), "{text}");
}

#[test]
fn who_starts_at_the_first_moment_that_is_allowed_is_led_at_once() {
    let mut sea = Sea::new();
    let armed = sea.run_until(30.0, |sea| {
        let states = sea.all::<EntityState>();
        states.iter().any(|(_, state)| state.description.to_str_lossy().starts_with("passed: the motors"))
    });
    assert!(armed);
    let (kind, info) = start(&mut sea);
    assert_ne!(kind, PlanControlType::Failure, "{info}");
    sea.run(1.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing, "{:?}", sea.plan_state());
}

#[test]
fn an_epoch_that_can_be_used_is_taken_up_at_once() {
    let mut sea = Sea::with(settings(), |vessel| vessel.gnss.latency_s = 10.0);
    sea.run(5.0);
    let utc = Some(sea.vehicle.now.utc);
    let place = frame().origin();
    let fix = devices::GnssFix {
        lat_rad: place.lat_rad(),
        lon_rad: place.lon_rad(),
        hdop: 1.0,
        ..Default::default()
    };
    let reading = devices::GnssReading {
        utc,
        fix: Some(fix),
        satellites: 9,
        heading_rad: Some(0.0),
        ..Default::default()
    };
    assert!(sea.last::<EstimatedState>().is_none());
    sea.read(devices::Reading::Gnss(reading));
    assert!(sea.last::<EstimatedState>().is_some(), "not a step later");
}
