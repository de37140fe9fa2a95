//! Every maneuver as a console sends it, sailed to its end or into its steady state.

use crate::common::*;
use imc::Address;
use imc::messages::*;
use units::LocalPoint;

fn start(maneuver: impl Into<Message>) -> Sea {
    let mut sea = Sea::new().ready();
    let request = sea.ask(PlanControlOp::Start, "one", Some(maneuver.into()));
    assert_eq!(sea.replies(request).len(), 2, "{:?}", sea.replies(request));
    sea
}

fn completes(sea: &mut Sea, limit_s: f64) -> bool {
    sea.run_until(limit_s, |sea| sea.plan_state().last_outcome == PlanControlStateLastOutcome::Success)
}

fn at(north_m: f64, east_m: f64) -> (f64, f64) {
    let place = place(north_m, east_m);
    (place.lat_rad(), place.lon_rad())
}

fn offsets(points: &[(f32, f32)]) -> imc::MessageList {
    points.iter().map(|(x, y)| PathPoint { x: *x, y: *y, z: 0.0 }).collect()
}

#[test]
fn launch_goes_once_afloat() {
    let (lat, lon) = at(40.0, 0.0);
    let mut sea = start(Launch { lat, lon, z_units: ZUnits::Depth, speed: 1.5, ..Launch::default() });
    assert!(completes(&mut sea, 60.0));
}

#[test]
fn loiter_circles_for_its_duration() {
    let (lat, lon) = at(60.0, 0.0);
    let mut sea = start(Loiter {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed: 1.5,
        radius: 20.0,
        duration: 120,
        r#type: LoiterType::Circular,
        direction: LoiterDirection::Cclockw,
        ..Loiter::default()
    });
    assert!(sea.run_until(90.0, |sea| {
        sea.last::<PathControlState>()
            .is_some_and(|state| state.flags.contains(PathControlStateFlags::LOITERING))
    }));
    sea.run(40.0);
    let range_m = sea.position().distance_m(LocalPoint { north_m: 60.0, east_m: 0.0 });
    assert!((17.0..23.0).contains(&range_m), "{range_m}");
    assert!(completes(&mut sea, 120.0));
}

#[test]
fn follow_path_goes_by_every_point() {
    let (lat, lon) = at(0.0, 0.0);
    let points = offsets(&[(40.0, 0.0), (40.0, 40.0), (0.0, 40.0)]);
    let mut sea =
        start(FollowPath { lat, lon, z_units: ZUnits::Depth, speed: 1.5, points, ..FollowPath::default() });
    assert!(completes(&mut sea, 200.0));
    assert!(sea.position().distance_m(LocalPoint { north_m: 0.0, east_m: 40.0 }) < 12.0);
}

#[test]
fn follow_trajectory_keeps_its_times() {
    let (lat, lon) = at(0.0, 0.0);
    let point = |x, y, t| TrajectoryPoint { x, y, z: 0.0, t };
    let points =
        [point(0.0, 0.0, 0.0), point(60.0, 0.0, 45.0), point(60.0, 60.0, 90.0)].into_iter().collect();
    let mut sea = start(FollowTrajectory {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed: 1.5,
        points,
        ..FollowTrajectory::default()
    });
    let begun = sea.vehicle.now.mono;
    assert!(completes(&mut sea, 200.0));
    let took_s = sea.vehicle.now.mono.since(begun).as_secs_f64();
    assert!((70.0..110.0).contains(&took_s), "{took_s}");
}

#[test]
fn rows_sweep_an_area() {
    let (lat, lon) = at(0.0, 0.0);
    let mut sea = start(Rows {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed: 1.5,
        width: 60.0,
        length: 80.0,
        hstep: 20.0,
        coff: 5,
        alternation: 100,
        flags: RowsFlags::SQUARE_CURVE | RowsFlags::CURVE_RIGHT,
        ..Rows::default()
    });
    let mut widest_m = 0.0_f64;
    for _ in 0..800 {
        sea.run(1.0);
        widest_m = widest_m.max(sea.position().east_m);
        if sea.plan_state().state == PlanControlStateState::Ready {
            break;
        }
    }
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
    assert!(widest_m > 50.0, "{widest_m}");
}

#[test]
fn rows_coverage_begins_its_first_row() {
    let (lat, lon) = at(0.0, 0.0);
    let mut sea = start(RowsCoverage {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed: 1.5,
        width: 60.0,
        length: 80.0,
        range: 10,
        flags: RowsCoverageFlags::SQUARE_CURVE,
        ..RowsCoverage::default()
    });
    sea.run(40.0);
    assert!(sea.position().north_m > 20.0);
}

#[test]
fn idle_drifts_for_its_duration() {
    let mut sea = start(IdleManeuver { duration: 20, ..IdleManeuver::default() });
    sea.run(15.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    assert!(completes(&mut sea, 10.0));
    assert!(sea.motors.iter().all(|(_, motors)| *motors == control::MotorPair::STOPPED));
}

#[test]
fn scheduled_goto_is_there_in_time() {
    let (lat, lon) = at(100.0, 0.0);
    let arrival_time = crate::common::start().seconds() + 110.0;
    let mut sea =
        start(ScheduledGoto { arrival_time, lat, lon, z_units: ZUnits::Depth, ..ScheduledGoto::default() });
    assert!(completes(&mut sea, 180.0));
    let late_s = sea.vehicle.now.utc.seconds() - arrival_time;
    assert!((-1.0..10.0).contains(&late_s), "{late_s}");
    assert!(sea.position().distance_m(LocalPoint { north_m: 100.0, east_m: 0.0 }) < 15.0);
}

#[test]
fn follow_system_keeps_beside_another() {
    const LEADER: Address = Address(0x2811);
    let mut sea = start(FollowSystem {
        system: LEADER.0,
        speed: 1.5,
        y: 25.0,
        z_units: ZUnits::Depth,
        ..FollowSystem::default()
    });
    for step in 0..16 {
        let (lat, lon) = at(40.0 + 8.0 * f64::from(step), 0.0);
        let announce = Announce { sys_name: "leader".into(), lat, lon, ..Announce::default() };
        sea.send_as(LEADER, Address::ANNOUNCE, announce);
        sea.run(10.0);
        assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    }
    assert!(sea.position().north_m > 80.0, "{:?}", sea.position());
}

/// The operator's keys, ten times a second.
fn keys(sea: &mut Sea, text: &str, seconds: u32) {
    for _ in 0..10 * seconds {
        sea.send(RemoteActions { actions: text.into() });
        sea.run(0.1);
    }
}

#[test]
fn an_operator_gives_heading_and_speed_to_the_autopilot_and_takes_the_motors_back() {
    let mut settings = settings();
    settings.remote.mixing =
        control::Mixing::Autopilot { max_speed_mps: 2.0, max_turn_rad: std::f64::consts::PI };
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.ask(PlanControlOp::Start, "by-hand", Some(Teleoperation { custom: "src=16385".into() }.into()));
    let heading_rad = |sea: &Sea| sea.vehicle.brain.estimate().unwrap().motion.heading_rad;
    let before_rad = heading_rad(&sea);
    // Half the axis is 90° to starboard of the heading at the first key.
    keys(&mut sea, "Throttle=64;Heading=64", 40);
    let turned_rad = units::wrap_pi(heading_rad(&sea) - before_rad);
    assert!((turned_rad.to_degrees() - 90.7).abs() < 3.0, "{turned_rad}");
    let speed_mps = sea.vehicle.brain.estimate().unwrap().motion.surge_mps();
    assert!((speed_mps - 1.0).abs() < 0.1, "{speed_mps}");
    let loops = CLoopsMask::TELEOPERATION | CLoopsMask::YAW | CLoopsMask::SPEED;
    assert_eq!(sea.last::<VehicleState>().unwrap().control_loops, loops);
    assert!((sea.last::<DesiredSpeed>().unwrap().value - 128.0 / 127.0).abs() < 1e-6);
    assert!(sea.last::<DesiredHeading>().is_some());
    keys(&mut sea, "Port Motor=64;Starboard Motor=-64", 1);
    assert_eq!(sea.last::<VehicleState>().unwrap().control_loops, CLoopsMask::TELEOPERATION);
    let motors = sea.motors.last().unwrap().1;
    assert!((motors.port - 64.0 / 127.0).abs() < 1e-6 && (motors.starboard + 64.0 / 127.0).abs() < 1e-6);
    keys(&mut sea, "Throttle=64", 1);
    assert!(sea.run_until(3.0, |sea| sea.motors.last().unwrap().1 == control::MotorPair::STOPPED));
    sea.run(1.0);
    assert_eq!(sea.last::<VehicleState>().unwrap().control_loops, CLoopsMask::TELEOPERATION);
}
