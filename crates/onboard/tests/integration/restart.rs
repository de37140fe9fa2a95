//! The program is killed and starts over: it reports what was under way, and does what the files say.

use crate::common::*;
use control::CrossTrackConfig;
use imc::messages::*;
use mission::{LostCommsConfig, Remedy, Step};
use onboard::{AfterRestart, Entity, Settings};
use std::time::Duration;
use units::LocalPoint;

fn with(action: AfterRestart) -> Settings {
    let mut settings = settings();
    settings.mission.restart.action = action;
    settings.watch.lost_comms = LostCommsConfig { idle: vec![], plan: vec![], ..LostCommsConfig::default() };
    settings
}

/// A vessel in a slow stream, at the second of three goals.
fn under_way(settings: &Settings) -> Sea {
    let mut sea = Sea::with(settings.clone(), |vessel| vessel.environment.current.speed_mps = 0.2).ready();
    sea.upload(&plan("home", vec![("a".into(), goto(-300.0, 0.0, 1.5).into())]));
    let goals = [("wp1", 10.0), ("wp2", 500.0), ("wp3", 900.0)];
    let goals = goals.map(|(id, north_m)| (id.to_owned(), Message::from(goto(north_m, 0.0, 1.5))));
    sea.ask(PlanControlOp::Start, "far", Some(plan("far", goals.to_vec()).into()));
    assert!(sea.run_until(60.0, |sea| sea.plan_state().man_id == "wp2"), "{:?}", sea.plan_state());
    sea.run(5.0);
    sea
}

fn runs(sea: &Sea, plan_id: &str) -> bool {
    let state = sea.plan_state();
    state.state == PlanControlStateState::Executing && state.plan_id == plan_id
}

fn told(sea: &Sea, what: &str) -> bool {
    sea.all::<LogBookEntry>().iter().any(|(_, entry)| entry.text.to_str_lossy().contains(what))
}

fn engine(sea: &Sea) -> String {
    text(sea, Entity::PlanEngine)
}

fn text(sea: &Sea, entity: Entity) -> String {
    let mut own = sea
        .said
        .iter()
        .rev()
        .filter(|(_, packet)| packet.header.src == OTTER && packet.header.src_ent == entity.number());
    own.find_map(|(_, packet)| packet.get::<EntityState>()).unwrap().description.to_string()
}

#[test]
fn a_plan_is_told_and_the_vessel_holds() {
    let settings = with(AfterRestart::Hold);
    let mut sea = under_way(&settings);
    sea.kill(settings, 60.0);
    assert!(sea.run_until(30.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    assert!(told(&sea, "plan 'far' was under way at maneuver 'wp2' when the program ended"));
    sea.run(1.0);
    assert!(engine(&sea).contains("plan 'far' was under way"), "{}", engine(&sea));
    let begun = sea.position();
    sea.run(300.0);
    assert!(runs(&sea, "hold") && sea.position().distance_m(begun) < 20.0);
    // The stored activity now is the hold.
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(2.0);
    assert_eq!(engine(&sea), "active");
}

#[test]
fn a_plan_resumes_from_its_maneuver_after_the_count_down() {
    let mut settings = with(AfterRestart::Resume);
    settings.mission.restart.countdown = Duration::from_secs(20);
    let mut sea = under_way(&settings);
    let stored = sea.disk.plans.clone();
    sea.kill(settings, 60.0);
    assert!(sea.run_until(30.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    sea.run(3.0);
    assert!(engine(&sea).contains("'far' resumes at "), "{}", engine(&sea));
    sea.run(14.0);
    assert!(runs(&sea, "hold"), "not before the count-down is over");
    assert!(sea.run_until(10.0, |sea| runs(sea, "far")), "{:?}", sea.plan_state());
    sea.run(1.0);
    assert_eq!(sea.plan_state().man_id, "wp2");
    assert!(sea.run_until(900.0, |sea| sea.plan_state().man_id == "wp3"));
    assert_eq!(sea.disk.plans, stored, "the stored plan keeps its first maneuver");
}

#[test]
fn the_shore_stops_the_count_down() {
    for stop in [true, false] {
        let settings = with(AfterRestart::Resume);
        let mut sea = under_way(&settings);
        sea.kill(settings, 20.0);
        assert!(sea.run_until(30.0, |sea| runs(sea, "hold")));
        sea.run(3.0);
        if stop {
            sea.ask(PlanControlOp::Stop, "", None);
        } else {
            sea.send(Abort);
        }
        sea.run(60.0);
        assert_eq!(sea.plan_state().state, PlanControlStateState::Ready);
        let resumed = sea.all::<PlanControlState>().iter().any(|(_, state)| state.plan_id == *"far");
        assert!(!resumed, "stop: {stop}");
    }
}

#[test]
fn a_second_kill_in_the_count_down_forgets_nothing() {
    let settings = with(AfterRestart::Resume);
    let mut sea = under_way(&settings);
    for _ in 0..3 {
        sea.kill(settings.clone(), 20.0);
        assert!(sea.run_until(30.0, |sea| runs(sea, "hold")));
        sea.run(5.0);
    }
    assert!(
        sea.run_until(40.0, |sea| runs(sea, "far")),
        "{:?}",
        sea.all::<LogBookEntry>().iter().map(|e| e.1.text.to_string()).collect::<Vec<_>>()
    );
}

#[test]
fn by_parameter_it_comes_home() {
    let settings = with(AfterRestart::Return("home".to_owned()));
    let mut sea = under_way(&settings);
    sea.kill(settings, 20.0);
    assert!(sea.run_until(30.0, |sea| runs(sea, "home")), "{:?}", sea.plan_state());
}

#[test]
fn what_is_long_ago_or_at_rest_starts_no_motor() {
    let settings = with(AfterRestart::Resume);
    let mut long_ago = under_way(&settings);
    long_ago.kill(settings.clone(), 3600.0);
    long_ago.run(60.0);
    assert!(told(&long_ago, "too long ago to act upon"));
    let mut aborted = under_way(&settings);
    aborted.send(Abort);
    aborted.run(1.0);
    aborted.kill(settings.clone(), 5.0);
    aborted.run(60.0);
    let mut quay = Sea::with(settings.clone(), |_| {}).ready();
    quay.kill(settings, 5.0);
    quay.run(60.0);
    for sea in [&long_ago, &aborted, &quay] {
        assert!(sea.motors.iter().all(|(_, motors)| *motors == control::MotorPair::STOPPED));
        assert!(sea.disk.under_way.is_none());
    }
}

#[test]
fn lost_communications_act_after_a_restart_although_nobody_was_heard_since() {
    let mut settings = with(AfterRestart::Hold);
    settings.watch.lost_comms.plan =
        vec![Step { after: Duration::from_mins(1), remedy: Remedy::Run { plan_id: "home".to_owned() } }];
    settings.watch.lost_comms.idle.clone_from(&settings.watch.lost_comms.plan);
    let mut sea = under_way(&settings);
    sea.heartbeats = false;
    sea.kill(settings, 10.0);
    sea.run(20.0);
    let lost = text(&sea, Entity::LostComms);
    assert!(
        lost.contains("none was heard since the start") && lost.contains("without: run plan home at"),
        "{lost}"
    );
    assert!(sea.run_until(90.0, |sea| runs(sea, "home")), "{:?}", sea.plan_state());
}

#[test]
fn what_is_under_way_is_on_its_way_to_the_disk_before_the_motors_run() {
    let sea = under_way(&with(AfterRestart::Hold));
    let kept = sea
        .outputs
        .iter()
        .position(|(_, output)| matches!(output, onboard::Output::Keep(onboard::Keep::UnderWay(Some(_)))));
    let moved = sea.outputs.iter().position(|(_, output)| {
        matches!(output, onboard::Output::Motors(motors) if *motors != control::MotorPair::STOPPED)
    });
    assert!(kept.unwrap() < moved.unwrap());
}

/// The failed plan's hold waits for a position.
fn hold_waits(settings: &Settings) -> Sea {
    let mut sea = under_way(settings);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(60.0, |sea| told(sea, "'hold station' is not possible")));
    sea
}

#[test]
fn a_hold_that_waits_for_a_position_is_not_taken_for_drifting_on_purpose() {
    let mut settings = with(AfterRestart::Hold);
    settings.mission.engine.position_patience = Duration::from_secs(10);
    let mut sea = hold_waits(&settings);
    sea.kill(settings, 5.0);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(30.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    assert!(told(&sea, "the vessel's own 'hold' was under way") && !told(&sea, "adrift on purpose"));
}

#[test]
fn a_second_kill_before_the_hold_could_begin_forgets_nothing() {
    let settings = with(AfterRestart::Hold);
    let mut sea = under_way(&settings);
    for _ in 0..2 {
        sea.kill(settings.clone(), 5.0);
        assert!(sea.run_until(10.0, |sea| told(sea, "s ago: hold station")));
        assert!(!runs(&sea, "hold"), "it was killed before");
    }
    assert!(sea.run_until(30.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
}

#[test]
fn an_operator_who_steps_in_right_after_a_failure_is_not_overruled() {
    for stops in [true, false] {
        // The track is lost at once: positions jump to the side.
        let mut settings = with(AfterRestart::Hold);
        settings.mission.track_recovery = Duration::from_secs(3);
        settings.path.jump.recovery_mps = 10.0;
        let limit = CrossTrackConfig { limit_m: 25.0, uncertainty_factor: None, time_limit_s: 3.0 };
        settings.path.cross_track = Some(limit);
        let mut sea = under_way(&settings);
        sea.vehicle.hull.vessel.faults_mut().position_jump = Some(LocalPoint { north_m: 0.0, east_m: 60.0 });
        assert!(sea.run_until(60.0, |sea| !runs(sea, "far")), "{:?}", sea.plan_state());
        assert!(!told(&sea, "hold station"), "the failure was looked at already");
        if stops {
            sea.ask(PlanControlOp::Stop, "", None);
        } else {
            let steer = Message::from(Teleoperation { custom: "src=16385".into() });
            let request = PlanControl {
                op: PlanControlOp::Start,
                plan_id: "steer".into(),
                flags: PlanControlFlags::IGNORE_ERRORS,
                arg: steer.into(),
                ..PlanControl::default()
            };
            sea.send(request);
            assert!(runs(&sea, "steer"), "{:?}", sea.plan_state());
        }
        sea.run(20.0);
        assert!(!runs(&sea, "hold") && !told(&sea, "hold station"), "stops: {stops}, {:?}", sea.plan_state());
        assert!(stops || runs(&sea, "steer"), "{:?}", sea.plan_state());
    }
}

#[test]
fn a_clock_that_is_an_hour_off_does_not_change_how_long_ago_it_was() {
    let settings = with(AfterRestart::Hold);
    for hours in [-1, 1] {
        let mut sea = under_way(&settings);
        sea.set_clock_ahead(hours * 3_600_000_000);
        sea.run(40.0);
        sea.kill(settings.clone(), 20.0);
        assert!(sea.run_until(30.0, |sea| runs(sea, "hold")), "{hours} h: {:?}", sea.plan_state());
        assert!(!told(&sea, "too long ago"));
    }
}

#[test]
fn a_silence_after_a_restart_is_told_although_nothing_is_done_about_it() {
    let settings = with(AfterRestart::Hold);
    let mut sea = under_way(&settings);
    sea.heartbeats = false;
    sea.kill(settings, 10.0);
    sea.run(330.0);
    let lost = text(&sea, Entity::LostComms);
    assert!(lost.contains("no console is heard, none was heard since the start 5 min ago"), "{lost}");
}

#[test]
fn a_plan_is_not_resumed_while_lost_communications_ask_for_something() {
    let mut settings = with(AfterRestart::Resume);
    settings.mission.restart.countdown = Duration::from_secs(15);
    settings.watch.lost_comms.idle = vec![Step { after: Duration::from_secs(10), remedy: Remedy::Hold }];
    let mut sea = under_way(&settings);
    sea.heartbeats = false;
    sea.kill(settings, 10.0);
    sea.run(60.0);
    assert!(told(&sea, "'far' is not resumed: another supervisor asks for something"));
    assert!(
        runs(&sea, "hold") && !sea.all::<PlanControlState>().iter().any(|(_, one)| one.plan_id == *"far")
    );
    let kept = imc::Packet::decode(sea.disk.under_way.as_deref().unwrap()).unwrap();
    assert!(kept.get::<PlanControl>().unwrap().info.to_str_lossy().starts_with("remedy"));
}

#[test]
fn a_stop_before_the_motors_start_again_keeps_them_still() {
    let settings = with(AfterRestart::Hold);
    let mut sea = under_way(&settings);
    sea.kill(settings, 10.0);
    assert!(sea.run_until(10.0, |sea| told(sea, "hold station from ")));
    assert!(sea.run_until(3.0, |sea| engine(sea).contains("unless it is stopped")), "{}", engine(&sea));
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(60.0);
    assert!(sea.motors.iter().all(|(_, motors)| *motors == control::MotorPair::STOPPED));
}

#[test]
fn a_vessel_that_was_stopped_starts_no_motor_after_a_restart_with_nobody_to_be_heard() {
    let mut settings = with(AfterRestart::Hold);
    settings.watch.lost_comms.idle = vec![Step { after: Duration::from_secs(20), remedy: Remedy::Hold }];
    let mut sea = under_way(&settings);
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(5.0);
    sea.heartbeats = false;
    sea.kill(settings, 10.0);
    sea.run(60.0);
    assert!(told(&sea, "the vessel was adrift on purpose"));
    let begun = sea.all::<PlanControlState>();
    assert!(begun.iter().all(|(_, state)| state.state != PlanControlStateState::Executing));
}
