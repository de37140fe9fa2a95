//! Faults at sea: sensors, motors, clocks, consoles.

use crate::common::*;
use control::MotorPair;
use devices::{GnssReading, GroundVelocity, Reading};
use imc::messages::*;
use onboard::{Entity, HostReading, Input};

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

/// The parts in error, as the vessel reports them.
fn errors(sea: &Sea) -> String {
    sea.last::<VehicleState>().unwrap_or_default().error_ents.to_string()
}

#[test]
fn a_silent_compass_is_bridged_for_seconds_and_then_lets_the_plan_wait() {
    let mut sea = under_way();
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    sea.run(2.0);
    assert!(!stopped(&sea), "short gaps are reckoned over");
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    sea.run(5.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(6.5, stopped), "nobody steers without a position");
    assert!(sea.run_until(3.0, |sea| errors(sea).contains("Navigation")), "{}", errors(&sea));
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(10.0, |sea| !stopped(sea)), "it goes on by itself");
    assert_eq!(sea.plan_state().plan_id, "far");
}

#[test]
fn a_jump_is_refused_while_it_is_short_and_believed_when_it_stays() {
    let mut sea = under_way();
    let place = sea.vehicle.brain.estimate().unwrap().place;
    sea.vehicle.hull.vessel.faults_mut().position_jump =
        Some(units::LocalPoint { north_m: 0.0, east_m: 400.0 });
    sea.run(0.3);
    let after = sea.vehicle.brain.estimate().unwrap().place;
    let frame = units::LocalFrame::new(place);
    assert!(frame.to_local(after).east_m.abs() < 10.0);
    sea.run(5.0);
    let after = sea.vehicle.brain.estimate().unwrap().place;
    assert!((frame.to_local(after).east_m - 400.0).abs() < 20.0, "{:?}", frame.to_local(after));
    assert!(
        sea.all::<GpsFixRejection>().iter().any(|(_, r)| r.reason == GpsFixRejectionReason::AboveThreshold)
    );
}

#[test]
fn what_is_no_number_never_reaches_a_motor() {
    let mut sea = under_way();
    sea.vehicle.hull.vessel.faults_mut().heading_nan = true;
    sea.run(20.0);
    assert!(sea.motors.iter().all(|(_, m)| m.port.abs() <= 1.0 && m.starboard.abs() <= 1.0));
    assert!(stopped(&sea), "without a heading nobody steers");
    assert!(sea.all::<EstimatedState>().iter().all(|(_, state)| state.psi.is_finite()));
    assert!(errors(&sea).contains("Navigation"), "{}", errors(&sea));
    let nonsense = GnssReading {
        velocity: Some(GroundVelocity { course_rad: f64::NAN, speed_mps: f64::INFINITY }),
        ..GnssReading::default()
    };
    sea.read(Reading::Gnss(nonsense));
}

#[test]
fn a_lost_motor_feedback_ends_the_plan() {
    let mut sea = under_way();
    sea.vehicle.hull.vessel.faults_mut().motor_feedback_lost.port = true;
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
    sea.set_clock_ahead(3_600_000_000);
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
    sea.set_clock_ahead(-3_600_000_000);
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
fn after_a_hang_the_motors_stop_first_and_then_the_plan_goes_on() {
    let mut sea = under_way();
    // The computer hangs for three seconds, longer than motors and compass may be silent.
    sea.hang(3.0);
    sea.forget();
    sea.tell(Input::Timer);
    assert_eq!(sea.motors.first().unwrap().1, MotorPair::STOPPED);
    sea.run(5.0);
    assert_eq!(
        sea.plan_state().state,
        PlanControlStateState::Executing,
        "no device was silent, the vessel was deaf"
    );
    assert_ne!(sea.plan_state().plan_id, "hold");
    assert_ne!(sea.motors.last().unwrap().1, MotorPair::STOPPED);
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

/// On a station of 10 m, at rest in its middle.
fn on_station() -> Sea {
    let mut sea = Sea::new().ready();
    let here = place(0.0, 0.0);
    let station = StationKeeping {
        lat: here.lat_rad(),
        lon: here.lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        speed: 1.0,
        ..StationKeeping::default()
    };
    sea.ask(PlanControlOp::Start, "station", Some(station.into()));
    sea.run(60.0);
    assert!(stopped(&sea) && sea.plan_state().state == PlanControlStateState::Executing);
    sea.forget();
    sea
}

fn never_moved(sea: &Sea) -> bool {
    sea.motors.iter().all(|(_, motors)| *motors == MotorPair::STOPPED)
}

#[test]
fn a_vessel_that_listens_starts_no_motor_for_a_position_that_jumps_and_returns() {
    let mut sea = on_station();
    sea.vehicle.hull.vessel.faults_mut().position_jump =
        Some(units::LocalPoint { north_m: 0.0, east_m: 300.0 });
    sea.run(0.3);
    sea.vehicle.hull.vessel.faults_mut().position_jump = None;
    sea.run(30.0);
    assert!(never_moved(&sea));
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    assert!(
        sea.all::<GpsFixRejection>().iter().any(|(_, r)| r.reason == GpsFixRejectionReason::AboveThreshold)
    );
}

#[test]
fn a_vessel_that_listens_goes_on_drifting_when_its_positions_end() {
    for fault in ["silent", "no fix", "no heading"] {
        let mut sea = on_station();
        let faults = sea.vehicle.hull.vessel.faults_mut();
        match fault {
            "silent" => faults.gnss_silent = true,
            "no fix" => faults.gnss_no_fix = true,
            _ => faults.heading_nan = true,
        }
        assert!(sea.run_until(12.0, |sea| errors(sea).contains("Navigation")), "{fault}");
        sea.run(10.0);
        assert_eq!(sea.plan_state().state, PlanControlStateState::Executing, "{fault}");
        assert!(never_moved(&sea), "{fault}");
    }
}

#[test]
fn positions_without_a_fix_stop_a_vessel_under_way() {
    let mut sea = under_way();
    sea.vehicle.hull.vessel.faults_mut().gnss_no_fix = true;
    assert!(sea.run_until(8.0, stopped));
    assert!(sea.run_until(3.0, |sea| errors(sea).contains("Navigation")), "{}", errors(&sea));
    assert!(sea.all::<GpsFixRejection>().iter().any(|(_, r)| r.reason == GpsFixRejectionReason::Invalid));
}

#[test]
fn velocities_and_rates_that_are_no_numbers_leave_the_vessel_on_its_way() {
    let mut sea = under_way();
    sea.forget();
    for _ in 0..100 {
        sea.run(0.1);
        let nonsense = GnssReading {
            velocity: Some(GroundVelocity { course_rad: f64::NAN, speed_mps: f64::NEG_INFINITY }),
            heading_rad: Some(f64::INFINITY),
            yaw_rate_rad_s: Some(f64::NAN),
            ..GnssReading::default()
        };
        sea.read(Reading::Gnss(nonsense));
    }
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    let east_m = sea.position().east_m;
    assert!(east_m.abs() < 2.0 && sea.position().north_m > 30.0, "{:?}", sea.position());
    let states = sea.all::<EstimatedState>();
    assert!(
        states.iter().all(|(_, s)| [s.psi, s.u, s.v, s.r, s.x, s.y].iter().all(|value| value.is_finite()))
    );
}

#[test]
fn a_silent_motor_card_ends_the_plan_and_names_both_motors() {
    let mut sea = under_way();
    sea.vehicle.hull.vessel.faults_mut().card_silent = true;
    assert!(sea.run_until(6.0, |sea| sea.mode() == VehicleStateOpMode::Error));
    assert!(stopped(&sea));
    let state = sea.last::<VehicleState>().unwrap();
    let names = state.error_ents.to_str_lossy();
    assert!(names.contains("Motor Port") && names.contains("Motor Starboard"), "{names}");
}

#[test]
fn a_console_that_is_gone_leaves_a_listening_vessel_on_its_station() {
    let mut sea = on_station();
    sea.heartbeats = false;
    sea.tell(Input::Disconnected(PEER));
    sea.run(20.0);
    sea.tell(Input::Connected(PEER));
    sea.heartbeats = true;
    sea.run(3.0);
    assert_eq!(sea.plan_state().plan_id, "station");
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    assert!(never_moved(&sea));
}

#[test]
fn a_clock_stepped_by_an_hour_makes_an_appointment_late_and_nothing_else() {
    for (step_us, outcome) in
        [(3_600_000_000, PlanControlStateLastOutcome::Failure), (0, PlanControlStateLastOutcome::None)]
    {
        let mut sea = Sea::new().ready();
        let target = place(100.0, 0.0);
        let appointment = ScheduledGoto {
            lat: target.lat_rad(),
            lon: target.lon_rad(),
            z_units: ZUnits::Depth,
            arrival_time: sea.vehicle.now.utc.seconds() + 600.0,
            delayed: ScheduledGotoDelayed::Fail,
            ..ScheduledGoto::default()
        };
        sea.ask(PlanControlOp::Start, "appointment", Some(appointment.into()));
        sea.run(5.0);
        sea.set_clock_ahead(step_us);
        sea.run(10.0);
        assert_eq!(sea.plan_state().last_outcome, outcome);
        assert_eq!(sea.plan_state().plan_id == "appointment", step_us == 0);
        assert!(stopped(&sea), "too early to start, or too late");
    }
}

/// Whatever a plan is damaged to on its way, it is refused with a reason or is a plan.
#[test]
fn damaged_plans_are_answered_and_harm_nothing() {
    let mut sea = Sea::new().ready();
    let request = PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Load,
        plan_id: "triangle".into(),
        arg: triangle().into(),
        ..PlanControl::default()
    };
    let header = imc::Header { src: CONSOLE, dst: OTTER, ..imc::Header::default() };
    let whole = imc::Packet::new(header, request).encode().unwrap();
    let payload = imc::HEADER_BYTES..whole.len() - imc::FOOTER_BYTES;
    for at in payload {
        for damage in [0xFF, 0x01, 0x80] {
            let mut bytes = whole.clone();
            bytes[at] ^= damage;
            let end = bytes.len() - imc::FOOTER_BYTES;
            let crc = imc::crc16(&bytes[..end]).to_le_bytes();
            bytes[end..].copy_from_slice(&crc);
            sea.tell(Input::Packet(PEER, bytes));
        }
        sea.outputs.clear();
    }
    let replies = sea.all::<PlanControl>();
    let of = |kind| replies.iter().filter(move |(_, reply)| reply.r#type == kind);
    assert!(of(PlanControlType::Success).count() > 100, "most numbers may be others");
    let failed: Vec<_> = of(PlanControlType::Failure).map(|(_, reply)| reply.info.to_string()).collect();
    assert!(failed.iter().filter(|info| info.starts_with("parse error: ")).count() > 50, "{failed:?}");
    assert!(failed.iter().all(|info| !info.is_empty()));
    sea.run(1.0);
    assert_eq!(sea.mode(), VehicleStateOpMode::Service);
    sea.ask(PlanControlOp::Start, "triangle", Some(triangle().into()));
    sea.run(5.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

#[test]
fn a_large_disk_is_not_short_of_room_while_a_week_of_recording_fits() {
    let mut sea = Sea::new();
    let state = |sea: &mut Sea, disk_free_mib: f64, disk_free_percent: f64| {
        sea.tell(Input::Host(HostReading { disk_free_mib, disk_free_percent, ..HostReading::default() }));
        sea.run(2.0);
        let number = Entity::Host.number();
        let mut own = sea.said.iter().rev().filter(|(_, packet)| packet.header.src_ent == number);
        own.find_map(|(_, packet)| packet.get::<EntityState>().cloned()).unwrap()
    };
    assert_eq!(state(&mut sea, 24_000.0, 9.0).state, EntityStateState::Normal);
    assert_eq!(state(&mut sea, 12_000.0, 1.0).state, EntityStateState::Normal);
    let short = state(&mut sea, 1_000.0, 3.5);
    assert_eq!(short.state, EntityStateState::Fault);
    assert_eq!(short.description.to_string(), "disk: 1000 MiB left; the log stops when it is full");
    assert_eq!(state(&mut sea, 400.0, 1.4).state, EntityStateState::Error);
}
