//! What breaks at sea: sensors, motors, clocks, consoles.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod common;

use common::*;
use control::MotorPair;
use imc::messages::*;
use onboard::{GnssReading, Input};

fn under_way() -> Sea {
    let mut sea = Sea::new().ready();
    let far = plan("far", vec![("a".into(), goto(2000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(20.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    sea
}

fn stopped(sea: &Sea) -> bool {
    sea.motors.last().is_some_and(|(_, motors)| *motors == MotorPair::STOPPED)
}

#[test]
fn a_silent_compass_is_bridged_for_seconds_and_then_stops_the_vessel() {
    let mut sea = under_way();
    sea.world.vessel.faults_mut().gnss_silent = true;
    sea.run(2.0);
    assert!(!stopped(&sea), "short gaps are reckoned over");
    sea.world.vessel.faults_mut().gnss_silent = false;
    sea.run(5.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    sea.world.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(6.5, stopped), "nobody steers without a position");
    assert!(sea.run_until(3.0, |sea| sea.mode() == VehicleStateOpMode::Error));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Failure);
    sea.world.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(10.0, |sea| sea.mode() == VehicleStateOpMode::Service));
    assert!(stopped(&sea), "it waits for orders");
}

#[test]
fn a_jump_is_refused_while_it_is_short_and_believed_when_it_stays() {
    let mut sea = under_way();
    let place = sea.world.brain.estimate().unwrap().place;
    sea.world.vessel.faults_mut().position_jump = Some(units::LocalPoint { north_m: 0.0, east_m: 400.0 });
    sea.run(0.3);
    let after = sea.world.brain.estimate().unwrap().place;
    let frame = units::LocalFrame::new(place);
    assert!(frame.to_local(after).east_m.abs() < 10.0);
    sea.run(5.0);
    let after = sea.world.brain.estimate().unwrap().place;
    assert!((frame.to_local(after).east_m - 400.0).abs() < 20.0, "{:?}", frame.to_local(after));
    assert!(
        sea.all::<GpsFixRejection>().iter().any(|(_, r)| r.reason == GpsFixRejectionReason::AboveThreshold)
    );
}

#[test]
fn what_is_no_number_never_reaches_a_motor() {
    let mut sea = under_way();
    sea.world.vessel.faults_mut().heading_nan = true;
    sea.run(20.0);
    assert!(sea.motors.iter().all(|(_, m)| m.port.abs() <= 1.0 && m.starboard.abs() <= 1.0));
    assert!(stopped(&sea), "without a heading nobody steers");
    assert!(sea.all::<EstimatedState>().iter().all(|(_, state)| state.psi.is_finite()));
    assert_eq!(sea.mode(), VehicleStateOpMode::Error);
    let nonsense = GnssReading { velocity: Some((f64::NAN, f64::INFINITY)), ..GnssReading::default() };
    sea.tell(Input::Gnss(nonsense));
}

#[test]
fn a_lost_motor_feedback_ends_the_plan() {
    let mut sea = under_way();
    sea.world.vessel.faults_mut().motor_feedback_lost.port = true;
    assert!(sea.run_until(5.0, |sea| sea.mode() == VehicleStateOpMode::Error));
    assert!(stopped(&sea));
    let state = sea.last::<VehicleState>().unwrap();
    assert!(state.error_ents.to_str_lossy().contains("Motor Port"), "{state:?}");
}

#[test]
fn a_clock_stepped_by_an_hour_changes_records_only() {
    let mut sea = under_way();
    sea.forget();
    sea.run(10.0);
    let before = sea.said.len();
    sea.world.clock_error_us = 3_600_000_000;
    sea.forget();
    sea.run(10.0);
    assert!((before as f64 * 0.9..before as f64 * 1.1).contains(&(sea.said.len() as f64)));
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    assert!(!stopped(&sea));
    let told = sea
        .all::<LogBookEntry>()
        .into_iter()
        .any(|(_, entry)| entry.text.to_str_lossy().contains("+3600.0 s"));
    assert!(told);
    sea.world.clock_error_us = -3_600_000_000;
    sea.run(10.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

#[test]
fn garbage_packets_change_nothing() {
    let mut sea = under_way();
    for length in 0..200_u8 {
        let bytes = (0..length).map(|n| n.wrapping_mul(37) ^ length).collect();
        sea.tell(Input::Packet(PEER, bytes));
    }
    sea.run(1.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

#[test]
fn a_flood_of_packets_does_not_fill_the_log_and_commands_in_it_still_act() {
    let mut sea = under_way();
    sea.forget();
    for _ in 0..100 {
        for _ in 0..100 {
            sea.send(TextMessage { text: "x".repeat(200).as_str().into(), ..TextMessage::default() });
        }
        sea.run(0.1);
    }
    let logged = sea.said.iter().filter(|(_, packet)| packet.get::<TextMessage>().is_some()).count();
    assert!((1000..3000).contains(&logged), "{logged} of 10000");
    let told = sea.all::<LogBookEntry>();
    let told = told.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains("packets are not logged"));
    assert!((1..=2).contains(&told.count()), "said, and not with every packet");
    sea.send(Abort);
    assert!(stopped(&sea));
}

#[test]
fn after_a_hang_the_motors_stop_and_the_plan_is_over() {
    let mut sea = under_way();
    // The computer hangs for three seconds, longer than motors and compass may be silent.
    sea.world.vessel.step(std::time::Duration::from_secs(3));
    sea.forget();
    sea.tell(Input::Timer);
    assert_eq!(sea.motors.first().unwrap().1, MotorPair::STOPPED);
    sea.run(5.0);
    assert!(stopped(&sea));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Failure);
    assert_eq!(sea.mode(), VehicleStateOpMode::Service, "ready for orders");
}

#[test]
fn motors_stop_first_at_shutdown() {
    let mut sea = under_way();
    sea.forget();
    sea.tell(Input::Shutdown);
    let motors = sea.outputs.iter().position(|(_, o)| matches!(o, onboard::Output::Motors(_))).unwrap();
    let log = sea.outputs.iter().position(|(_, o)| matches!(o, onboard::Output::CloseLog)).unwrap();
    assert!(motors < log && stopped(&sea));
    sea.forget();
    sea.run(5.0);
    assert!(sea.motors.iter().all(|(_, motors)| *motors == MotorPair::STOPPED));
    assert!(sea.motors.len() >= 4, "the stop is repeated");
}
