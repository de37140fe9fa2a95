use super::*;
use proptest::prelude::*;
use units::Turn;

const ORIGIN: (f64, f64) = (63.33, 10.0833);

fn origin() -> LatLon {
    LatLon::from_deg(ORIGIN.0, ORIGIN.1).unwrap()
}

/// The place some metres north and east of the origin.
fn spot(north_m: f64, east_m: f64) -> LatLon {
    displaced(origin(), east_m.atan2(north_m), north_m.hypot(east_m))
}

fn fix(north_m: f64, east_m: f64, heading_deg: f64, speed_mps: f64) -> Fix {
    let heading_rad = heading_deg.to_radians();
    let motion = Motion::from_course(heading_rad, None, heading_rad, speed_mps);
    Fix { place: spot(north_m, east_m), motion, variance_m2: None }
}

fn at(seconds: f64) -> MonoTime {
    MonoTime::from_micros((seconds * 1e6) as u64)
}

fn tracker(config: PathConfig) -> PathTracker {
    PathTracker::new(config).unwrap()
}

fn go(north_m: f64, east_m: f64) -> PathCommand {
    PathCommand {
        path_ref: 7,
        start: PathStart::Chained,
        end: PathEnd::At(spot(north_m, east_m)),
        loiter: None,
    }
}

fn circle(north_m: f64, east_m: f64, radius_m: f64, turn: Turn) -> PathCommand {
    PathCommand { loiter: Some(Loiter { radius_m, turn }), ..go(north_m, east_m) }
}

fn cross_of(status: &PathStatus) -> f64 {
    status.geometry.cross_m()
}

#[test]
fn cross_track_is_positive_to_starboard_of_the_track() {
    let mut path = tracker(PathConfig::default());
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 1.0)).unwrap();
    let got = path.update(at(1.0), &fix(30.0, 4.0, 10.0, 1.0), false).unwrap();
    assert!((cross_of(&got) - 4.0).abs() < 1e-3);
    assert!((got.left_m - 70.0).abs() < 1e-2);
    assert!((got.course_error_rad - 10_f64.to_radians()).abs() < 1e-4);
    assert!((got.range_m - 70_f64.hypot(4.0)).abs() < 1e-2);
}

#[test]
fn arrives_by_time_before_the_end_and_stays_near() {
    // 5 s at 2 m/s: near 10 m before the end.
    let mut path = tracker(PathConfig::thesis());
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 2.0)).unwrap();
    for (t, north_m, eta_s, near, event) in [
        (1.0, 50.0, 20, false, None),
        (2.0, 89.5, 0, false, None),
        (3.0, 90.5, 0, true, Some(PathEvent::Near)),
        (4.0, 140.0, 15, true, None),
    ] {
        let got = path.update(at(t), &fix(north_m, 0.0, 0.0, 2.0), false).unwrap();
        assert_eq!((got.eta_s, got.near, got.event), (eta_s, near, event), "{north_m} m: {got:?}");
    }
}

#[test]
fn arrives_when_abeam_of_the_end() {
    // Abeam within 1.75 x 5 s x 2 m/s = 17.5 m counts, beyond does not.
    for (aside_m, near) in [(17.0, true), (18.0, false)] {
        let mut path = tracker(PathConfig::thesis());
        path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 2.0)).unwrap();
        assert_eq!(path.update(at(9.0), &fix(92.0, aside_m, 0.0, 2.0), false).unwrap().near, near);
    }
}

#[test]
fn arrives_within_a_radius_when_so_configured() {
    let mut path = tracker(PathConfig { near: NearRule::Radius(3.0), ..PathConfig::thesis() });
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 2.0)).unwrap();
    assert!(!path.update(at(1.0), &fix(96.0, 0.0, 0.0, 2.0), false).unwrap().near);
    assert!(!path.update(at(2.0), &fix(100.0, 3.5, 0.0, 2.0), false).unwrap().near);
    assert!(path.update(at(3.0), &fix(99.0, 2.5, 0.0, 2.0), false).unwrap().near);
}

#[test]
fn a_slow_vessel_is_reckoned_with_the_minimum_speed() {
    let mut path = tracker(PathConfig::thesis());
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 0.0)).unwrap();
    let got = path.update(at(1.0), &fix(40.0, 0.0, 0.0, 0.1), false).unwrap();
    assert!((54..=55).contains(&got.eta_s), "60 m at 1 m/s, less 5 s: {got:?}");
}

#[test]
fn a_reached_end_is_where_the_next_leg_starts() {
    let mut path = tracker(PathConfig::thesis());
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 2.0)).unwrap();
    // Not reached: from here.
    let got = path.start(at(1.0), &go(100.0, 50.0), &fix(20.0, 3.0, 0.0, 2.0)).unwrap();
    assert!(range_and_bearing(got.start, spot(20.0, 3.0)).0 < 1e-3);
    path.update(at(2.0), &fix(95.0, 45.0, 0.0, 2.0), false).unwrap();
    // Reached: from its end, cut corner or not, unless the command is to go direct.
    let mut direct = path.clone();
    let got = path.start(at(3.0), &go(100.0, 200.0), &fix(95.0, 45.0, 0.0, 2.0)).unwrap();
    assert!(range_and_bearing(got.start, spot(100.0, 50.0)).0 < 1e-3);
    assert!((cross_of(&got) - 5.0).abs() < 0.05);
    let command = PathCommand { start: PathStart::Here, ..go(100.0, 200.0) };
    let got = direct.start(at(3.0), &command, &fix(95.0, 45.0, 0.0, 2.0)).unwrap();
    assert!(cross_of(&got).abs() < 1e-3);
}

#[test]
fn an_ended_path_is_continued_within_a_second_only() {
    for (pause_s, continued) in [(0.5, true), (1.5, false)] {
        let mut path = tracker(PathConfig::thesis());
        path.start(at(0.0), &go(100.0, 0.0), &fix(95.0, 0.0, 0.0, 2.0)).unwrap();
        path.stop(at(10.0));
        assert!(!path.is_active());
        assert_eq!(path.update(at(10.0), &fix(0.0, 0.0, 0.0, 0.0), false), Err(PathError::Idle));
        let got = path.start(at(10.0 + pause_s), &go(300.0, 0.0), &fix(97.0, 2.0, 0.0, 1.0)).unwrap();
        let here = if continued { spot(100.0, 0.0) } else { spot(97.0, 2.0) };
        assert!(range_and_bearing(got.start, here).0 < 1e-2, "{pause_s} s");
    }
}

#[test]
fn waiting_at_the_end_for_too_long_is_a_fault() {
    let mut path = tracker(PathConfig::ntnu());
    path.start(at(0.0), &go(100.0, 0.0), &fix(0.0, 0.0, 0.0, 2.0)).unwrap();
    for (t, fault) in [(10.0, None), (14.9, None), (15.0, Some(PathFault::NoNewPath))] {
        let got = path.update(at(t), &fix(97.0, 0.0, 0.0, 0.0), true).unwrap();
        assert_eq!(got.fault, fault, "{t} s");
    }
    assert_eq!(path.start(at(16.0), &go(0.0, 0.0), &fix(97.0, 0.0, 0.0, 0.0)).unwrap().fault, None);
}

#[test]
fn approaches_a_circle_on_the_side_of_its_sense() {
    for (turn, east_m) in [(Turn::Clockwise, -15.0), (Turn::CounterClockwise, 15.0)] {
        let mut path = tracker(PathConfig::thesis());
        path.start(at(0.0), &circle(200.0, 0.0, 15.0, turn), &fix(0.0, 0.0, 0.0, 1.0)).unwrap();
        let aim = path.active.as_ref().unwrap().leg.end();
        assert!(range_and_bearing(aim, spot(200.0, east_m)).0 < 0.01, "{turn:?}");
    }
}

#[test]
fn a_circle_begins_at_the_end_of_its_approach_or_when_captured() {
    for (config, begins_at_m) in [(PathConfig::thesis(), 195.0), (PathConfig::default(), 186.8)] {
        let mut path = tracker(config);
        let centre = circle(200.0, 15.0, 15.0, Turn::Clockwise);
        let command = PathCommand { start: PathStart::At(spot(0.0, 15.0)), ..centre };
        path.start(at(0.0), &command, &fix(0.0, 0.0, 0.0, 1.0)).unwrap();
        let got = path.update(at(1.0), &fix(begins_at_m - 3.0, 0.0, 0.0, 1.0), false).unwrap();
        assert!(!got.loitering, "{got:?}");
        let got = path.update(at(2.0), &fix(begins_at_m + 0.1, 0.0, 0.0, 1.0), false).unwrap();
        assert_eq!((got.event, got.near, got.eta_s), (Some(PathEvent::Loitering), false, 0), "{got:?}");
        assert!(got.left_m.abs() < 1e-9);
    }
}

#[test]
fn on_a_circle_outside_is_away_from_the_centre() {
    for (turn, side) in [(Turn::Clockwise, -1.0), (Turn::CounterClockwise, 1.0)] {
        let mut path = tracker(PathConfig::default());
        let command = PathCommand { end: PathEnd::Here, ..circle(0.0, 0.0, 20.0, turn) };
        path.start(at(0.0), &command, &fix(0.0, 0.0, 0.0, 1.0)).unwrap();
        path.update(at(1.0), &fix(18.0, 0.0, 0.0, 1.0), false).unwrap();
        // North of the centre the tangent points east (clockwise) or west.
        let got = path.update(at(2.0), &fix(23.0, 0.0, 90.0, 1.0), false).unwrap();
        assert!((cross_of(&got) - side * 3.0).abs() < 1e-2, "{got:?}");
        assert!(wrap_pi(got.geometry.bearing_rad() + side * FRAC_PI_2).abs() < 1e-3);
    }
}

#[test]
fn a_circle_moved_a_little_is_kept_without_an_approach() {
    for (moved_m, radius_m, stays) in [(3.0, 20.0, true), (3.0, 60.0, false), (40.0, 20.0, false)] {
        let mut path = tracker(PathConfig::default());
        path.start(at(0.0), &circle(0.0, 0.0, 20.0, Turn::Clockwise), &fix(20.0, 0.0, 90.0, 1.0)).unwrap();
        path.update(at(1.0), &fix(20.0, 0.0, 90.0, 1.0), false).unwrap();
        let next = circle(moved_m, 0.0, radius_m, Turn::Clockwise);
        let got = path.start(at(2.0), &next, &fix(20.0, 0.0, 90.0, 1.0)).unwrap();
        let circling = matches!(got.geometry, Geometry::Circle(_));
        assert_eq!(
            circling && path.active.as_ref().unwrap().phase == Phase::Loitering,
            stays || got.event.is_some()
        );
        assert_eq!(got.event.is_none() && circling, stays, "{moved_m} {radius_m}: {got:?}");
    }
}

#[test]
fn monitors_report_and_rest_while_braking_or_after_a_jump() {
    // What happens in 60 s of lying still on the track.
    for (case, braking_s, jump, fault_at_s) in
        [("plain", 0.0, false, 40.0), ("braking", 35.0, false, 71.0), ("jump", 0.0, true, 80.0)]
    {
        let mut path = tracker(PathConfig::thesis());
        path.start(at(0.0), &go(500.0, 0.0), &fix(0.0, 0.0, 0.0, 0.0)).unwrap();
        let mut failed_at_s = None;
        for t in 1..=100 {
            let t = f64::from(t);
            let north_m = if jump { 20.0 } else { 0.0 };
            let got = path.update(at(t), &fix(north_m, 0.0, 0.0, 0.0), t < braking_s).unwrap();
            if got.fault.is_some() {
                failed_at_s.get_or_insert(t);
                assert_eq!(got.fault, Some(PathFault::NoProgress));
            }
        }
        let failed_at_s: f64 = failed_at_s.unwrap();
        assert!((failed_at_s - fault_at_s).abs() <= 2.0, "{case}: {failed_at_s} s");
    }
}

#[test]
fn being_off_the_track_for_long_is_a_fault() {
    let mut path = tracker(PathConfig::thesis());
    path.start(at(0.0), &go(500.0, 0.0), &fix(0.0, 0.0, 0.0, 1.0)).unwrap();
    let mut fault = None;
    for t in 1..=40 {
        let t = f64::from(t);
        fault = path.update(at(t), &fix(t, (2.0 * t).min(30.0), 0.0, 2.3), false).unwrap().fault;
    }
    assert_eq!(fault, Some(PathFault::OffTrack));
}

#[test]
fn refuses_what_is_no_path() {
    let mut path = tracker(PathConfig::default());
    let here = fix(0.0, 0.0, 0.0, 0.0);
    let endless = PathCommand { end: PathEnd::At(LatLon::from_deg(63.8, 10.0833).unwrap()), ..go(0.0, 0.0) };
    assert!(matches!(path.start(at(0.0), &endless, &here), Err(PathError::TooLong { .. })));
    let pointless = PathCommand { end: PathEnd::Here, ..go(0.0, 0.0) };
    assert_eq!(path.start(at(0.0), &pointless, &here), Err(PathError::NoRadius));
    for radius_m in [0.0, -3.0, 1e4, f64::NAN] {
        let command = circle(0.0, 0.0, radius_m, Turn::Clockwise);
        assert!(matches!(path.start(at(0.0), &command, &here), Err(PathError::Radius(_))));
    }
    let mut blind = here;
    blind.motion.north_mps = f64::NAN;
    assert_eq!(path.start(at(0.0), &go(9.0, 9.0), &blind), Err(PathError::NotFinite));
    assert!(!path.is_active());
    let bad = PathConfig { eta_min_speed_mps: 0.0, near: NearRule::Radius(0.0), ..PathConfig::default() };
    assert_eq!(PathTracker::new(bad).unwrap_err().problems.len(), 2);
}

#[test]
fn a_leg_of_25_km_keeps_its_track_true() {
    let mut path = tracker(PathConfig { max_length_m: 26_000.0, ..PathConfig::default() });
    let end = LatLon::from_deg(63.33, 10.5833).unwrap();
    let got = path.start(
        at(0.0),
        &PathCommand { end: PathEnd::At(end), ..go(0.0, 0.0) },
        &fix(0.0, 0.0, 90.0, 1.0),
    );
    let leg = path.active.as_ref().unwrap().leg;
    let first = leg.locate(origin());
    let last = leg.locate(end);
    assert!((last.along_m - leg.length_m()).abs() < 1e-3 && last.cross_m.abs() < 1e-3, "{:?}", got.unwrap());
    // A constant bearing would be 0.45 degrees wrong in the end.
    assert!((wrap_pi(last.bearing_rad - first.bearing_rad).to_degrees() - 0.447).abs() < 0.01);
}

proptest! {
    #[test]
    fn status_is_always_a_number_and_mirrors(
        north_m in -900.0..900.0_f64, east_m in -900.0..900.0_f64,
        heading_deg in -180.0..180.0_f64, speed_mps in 0.0..3.0_f64, radius_m in proptest::option::of(1.0..80.0_f64),
    ) {
        let status = |side: f64| {
            let mut path = tracker(PathConfig::default());
            let turn = if side > 0.0 { Turn::Clockwise } else { Turn::CounterClockwise };
            let loiter = radius_m.map(|radius_m| Loiter { radius_m, turn });
            let command = PathCommand { loiter, ..go(500.0, 0.0) };
            path.start(at(0.0), &command, &fix(0.0, 0.0, 0.0, 0.0)).unwrap();
            path.update(at(1.0), &fix(north_m, side * east_m, side * heading_deg, speed_mps), false).unwrap()
        };
        let (one, other) = (status(1.0), status(-1.0));
        prop_assert!(one.left_m.is_finite() && one.range_m.is_finite() && one.course_error_rad.is_finite());
        prop_assert_eq!(one.loitering, other.loitering);
        prop_assert!((cross_of(&one) + cross_of(&other)).abs() < 0.2, "{:?} {:?}", one, other);
    }
}
