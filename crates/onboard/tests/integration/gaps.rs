//! Gaps in the positions, and a vessel that is carried off its track: a plan waits and continues, and where it fails the
//! vessel keeps its station.

use crate::common::*;
use control::{CrossTrackConfig, MotorPair};
use imc::messages::*;
use mission::LostCommsConfig;
use onboard::{Entity, Settings};
use std::time::Duration;
use units::LocalPoint;

fn under_way(change: impl FnOnce(&mut Settings), current_mps: f64) -> Sea {
    let mut settings = settings();
    settings.watch.lost_comms = LostCommsConfig { idle: vec![], plan: vec![], ..LostCommsConfig::default() };
    change(&mut settings);
    let mut sea = Sea::with(settings, |vessel| {
        vessel.environment.current.speed_mps = current_mps;
        vessel.environment.current.to_rad = std::f64::consts::FRAC_PI_2;
    })
    .ready();
    let far = plan("far", vec![("a".into(), goto(2000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(40.0);
    assert!(runs(&sea, "far"), "{:?}", sea.plan_state());
    sea
}

fn runs(sea: &Sea, plan_id: &str) -> bool {
    let state = sea.plan_state();
    state.state == PlanControlStateState::Executing && state.plan_id == plan_id
}

fn stopped(sea: &Sea) -> bool {
    sea.motors.last().is_some_and(|(_, motors)| *motors == MotorPair::STOPPED)
}

fn told(sea: &Sea, what: &str) -> bool {
    sea.all::<LogBookEntry>().iter().any(|(_, entry)| entry.text.to_str_lossy().contains(what))
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
fn a_silent_compass_is_bridged_as_long_as_is_promised() {
    let mut sea = under_way(|_| {}, 0.0);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    let reckoning_s = settings().navigation.reckoning_s;
    sea.run(reckoning_s - 0.4);
    assert!(!stopped(&sea), "{}", text(&sea, Entity::Navigation));
    let (_, motors) = *sea.motors.last().unwrap();
    assert!(
        (motors.port - motors.starboard).abs() < 1e-6,
        "without a heading it goes straight on: {motors:?}"
    );
    sea.run(1.5);
    assert!(stopped(&sea) && runs(&sea, "far"), "{:?}", sea.plan_state());
}

#[test]
fn a_plan_waits_for_positions_and_goes_on_with_them() {
    for no_fix in [false, true] {
        let mut sea = under_way(|_| {}, 0.3);
        let faults = sea.vehicle.hull.vessel.faults_mut();
        (faults.gnss_silent, faults.gnss_no_fix) = (!no_fix, no_fix);
        sea.run(40.0);
        assert!(runs(&sea, "far") && stopped(&sea), "{:?}", sea.plan_state());
        assert!(told(&sea, "the plan waits with its motors stopped"), "{no_fix}");
        assert!(
            text(&sea, Entity::Navigation).contains("a plan waits"),
            "{}",
            text(&sea, Entity::Navigation)
        );
        let north_m = sea.position().north_m;
        *sea.vehicle.hull.vessel.faults_mut() = sim::Faults::default();
        sea.run(1.5);
        assert!(stopped(&sea), "not before they have been good for a while");
        sea.run(60.0);
        assert!(runs(&sea, "far") && told(&sea, "the plan goes on"));
        assert!(sea.position().north_m > north_m + 40.0, "{:?}", sea.position());
        assert!(sea.position().east_m.abs() < 8.0, "back on its track: {:?}", sea.position());
    }
}

#[test]
fn without_positions_it_slows_down_and_its_uncertainty_grows_honestly() {
    let mut sea = under_way(|settings| settings.navigation.reckoning_s = 20.0, 0.0);
    let sailed_mps = 1.4;
    assert!(sea.last::<EstimatedState>().unwrap().u > sailed_mps);
    sea.forget();
    sea.vehicle.hull.vessel.faults_mut().gnss_no_fix = true;
    sea.run(8.0);
    assert!(runs(&sea, "far"));
    let truth = sea.vehicle.hull.vessel.truth().state.position;
    let estimate = *sea.vehicle.brain.estimate().unwrap();
    let error_m = frame().to_local(estimate.place).distance_m(truth);
    assert!(error_m < 2.45 * estimate.sigma_m, "{error_m} m, sigma {} m", estimate.sigma_m);
    let told_m = sea.last::<NavigationUncertainty>().unwrap().x.sqrt();
    assert!(told_m > 5.0 && f64::from(told_m) > 0.8 * estimate.sigma_m, "{told_m} of {}", estimate.sigma_m);
    let motors = sea.motors.last().unwrap().1;
    assert!(f64::midpoint(motors.port, motors.starboard) < 0.35, "slowed down: {motors:?}");
    // It ends by the uncertainty, before the time is over.
    assert!(sea.run_until(12.0, stopped), "{}", estimate.sigma_m);
}

#[test]
fn after_too_long_a_gap_the_plan_fails_and_the_vessel_holds_once_it_can() {
    let mut sea =
        under_way(|settings| settings.mission.engine.position_patience = Duration::from_secs(30), 0.2);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(45.0, |sea| sea.plan_state().state != PlanControlStateState::Executing));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Failure);
    sea.run(5.0);
    assert!(stopped(&sea) && told(&sea, "'hold station' is not possible"));
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(10.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    let begun = sea.position();
    sea.run(300.0);
    assert!(runs(&sea, "hold") && sea.position().distance_m(begun) < 20.0, "{:?}", sea.position());
}

#[test]
fn by_parameter_a_failed_plan_drifts_as_before() {
    let mut sea = under_way(
        |settings| {
            settings.mission.engine.position_patience = Duration::ZERO;
            settings.mission.holds_after_failure = false;
        },
        0.0,
    );
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(8.0, |sea| sea.plan_state().state != PlanControlStateState::Executing));
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    sea.run(20.0);
    assert!(stopped(&sea) && sea.plan_state().state == PlanControlStateState::Ready);
}

#[test]
fn a_vessel_that_is_found_off_its_track_comes_back_to_it() {
    let mut sea = under_way(
        |settings| {
            settings.path.jump.recovery_mps = 10.0;
            settings.path.cross_track =
                Some(CrossTrackConfig { limit_m: 25.0, uncertainty_factor: None, time_limit_s: 3.0 });
        },
        0.0,
    );
    sea.vehicle.hull.vessel.faults_mut().position_jump = Some(LocalPoint { north_m: 0.0, east_m: 60.0 });
    sea.run(12.0);
    assert!(runs(&sea, "far"), "{:?}", sea.plan_state());
    assert!(told(&sea, "too far from the track; it steers back"));
    assert!(text(&sea, Entity::Path).contains("steers back, fails in"), "{}", text(&sea, Entity::Path));
    assert!(sea.run_until(110.0, |sea| (sea.position().east_m + 60.0).abs() < 10.0), "{:?}", sea.position());
    assert!(runs(&sea, "far") && told(&sea, "back on the track"));
}

#[test]
fn what_a_vessel_waits_for_a_position_is_no_part_of_its_way_back() {
    let mut sea = under_way(
        |settings| {
            settings.path.jump.recovery_mps = 10.0;
            settings.path.cross_track =
                Some(CrossTrackConfig { limit_m: 25.0, uncertainty_factor: None, time_limit_s: 3.0 });
            settings.mission.track_recovery = Duration::from_mins(1);
            settings.mission.engine.position_patience = Duration::from_mins(2);
        },
        0.0,
    );
    sea.vehicle.hull.vessel.faults_mut().position_jump = Some(LocalPoint { north_m: 0.0, east_m: 60.0 });
    sea.run(12.0);
    assert!(told(&sea, "too far from the track; it steers back"));
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    sea.run(80.0);
    assert!(runs(&sea, "far") && stopped(&sea), "{:?}", sea.plan_state());
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(60.0, |sea| told(sea, "back on the track")), "{:?}", sea.position());
    assert!(runs(&sea, "far"));
}

#[test]
fn a_track_that_cannot_be_come_back_to_fails_and_the_vessel_holds() {
    // The stream is stronger than the speed that the plan asks for.
    let mut sea = under_way(
        |settings| {
            settings.mission.track_recovery = Duration::from_secs(30);
            settings.path.along_track = None;
        },
        2.6,
    );
    assert!(sea.run_until(150.0, |sea| !runs(sea, "far")), "{:?}", sea.plan_state());
    assert!(
        told(&sea, "too far from the track; it steers back") && told(&sea, "maneuver error"),
        "{:?}",
        sea.position()
    );
    assert!(sea.run_until(10.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    sea.run(1.0);
    let engine = text(&sea, Entity::PlanEngine);
    assert!(engine.contains("'far' failed") && engine.contains("hold station: in force"), "{engine}");
}
