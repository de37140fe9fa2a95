//! Maneuvers that go from point to point.

use super::{Bench, path};
use crate::command::{Command, PathStart};
use crate::event::{Event, Medium};
use crate::maneuver::{
    FollowPath, FollowTrajectory, Launch, Left, Maneuver, Outcome, Rows, RowsCoverage, Swath, TimedOffset,
    distance_m,
};
use crate::place::{Offset, RawPlace};
use crate::testing::{SPEED, fix, frame, goto, place, progress};
use units::Speed;

fn origin() -> RawPlace {
    place(0.0, 0.0).into()
}

fn offset(north_m: f64, east_m: f64) -> Offset {
    Offset { north_m, east_m }
}

fn rows() -> Rows<RawPlace> {
    Rows {
        origin: origin(),
        speed: SPEED,
        bearing_rad: 0.0,
        cross_angle_rad: 0.0,
        width_m: 40.0,
        length_m: 100.0,
        step_m: 20.0,
        curve_offset_m: 10.0,
        alternation: 1.0,
        square_curve: false,
        curve_right: true,
    }
}

#[track_caller]
fn assert_points(rows: &Rows<RawPlace>, expected: &[(f64, f64)]) {
    let points: Vec<_> = rows.at(place(0.0, 0.0)).points().collect();
    let close = |point: &Offset, (north_m, east_m): &(f64, f64)| {
        (point.north_m - north_m).abs() < 1e-6 && (point.east_m - east_m).abs() < 1e-6
    };
    assert_eq!(points.len(), expected.len(), "{points:?}");
    assert!(points.iter().zip(expected).all(|(point, expected)| close(point, expected)), "{points:?}");
}

#[test]
fn goto_takes_one_path_and_is_done_when_near() {
    let mut bench = Bench::new(goto(100.0, 0.0));
    bench.fix = Some(fix(0.0, 0.0));
    let path = path(&bench.start());
    assert!(distance_m(path.end, place(100.0, 0.0)) < 1e-6);
    assert_eq!((path.start, path.speed, path.circle), (PathStart::Chained, SPEED, None));
    bench.event(&Event::Path(progress(1, 40.0)));
    assert_eq!(bench.left(), Some(Left { way_m: 40.0, wait_s: 0.0 }));
    bench.near();
    assert!(bench.is_done());
}

#[test]
fn launch_waits_for_the_water() {
    let mut bench = Bench::new(Maneuver::Launch(Launch { target: origin(), speed: SPEED }));
    assert_eq!(bench.start(), [Command::Drift]);
    assert_eq!(bench.event(&Event::Medium(Medium::Ground)), []);
    path(&bench.event(&Event::Medium(Medium::Water)));
    assert_eq!(bench.event(&Event::Medium(Medium::Water)), []);
    bench.near();
    assert!(bench.is_done());
}

#[test]
fn follow_path_goes_along_all_points() {
    let points = vec![offset(0.0, 0.0), offset(100.0, 0.0), offset(100.0, 50.0)];
    let mut bench = Bench::new(Maneuver::FollowPath(FollowPath { origin: origin(), points, speed: SPEED }));
    bench.fix = Some(fix(-30.0, 0.0));
    path(&bench.start());
    assert!((bench.left().unwrap().way_m - 180.0).abs() < 0.01);
    let second = path(&bench.near());
    assert!(distance_m(second.end, place(100.0, 0.0)) < 1e-6);
    assert_eq!((second.path_ref, second.start), (2, PathStart::Chained));
    assert!((bench.left().unwrap().way_m - 150.0).abs() < 0.01);
    path(&bench.near());
    assert_eq!(bench.near(), []);
    assert!(bench.is_done());
}

#[test]
fn follow_path_without_points_is_done_at_once() {
    let path = FollowPath { origin: origin(), points: Vec::new(), speed: SPEED };
    let mut bench = Bench::new(Maneuver::FollowPath(path));
    assert_eq!(bench.start(), []);
    assert!(bench.is_done());
}

#[test]
fn rows_turn_diagonally_or_squarely() {
    let up_and_down = [(-10.0, 0.0), (0.0, 0.0), (110.0, 0.0), (100.0, 20.0), (-10.0, 20.0), (0.0, 40.0)];
    let diagonal: Vec<_> = up_and_down.into_iter().chain([(110.0, 40.0)]).collect();
    assert_points(&rows(), &diagonal);
    let square = [
        (-10.0, 0.0),
        (0.0, 0.0),
        (110.0, 0.0),
        (110.0, 20.0),
        (100.0, 20.0),
        (-10.0, 20.0),
        (-10.0, 40.0),
        (0.0, 40.0),
        (110.0, 40.0),
    ];
    assert_points(&Rows { square_curve: true, ..rows() }, &square);
}

#[test]
fn rows_alternate_their_steps() {
    // Up 20·0.5, down 20·1.5.
    let expected = [
        (-10.0, 0.0),
        (0.0, 0.0),
        (110.0, 0.0),
        (100.0, -10.0),
        (-10.0, -10.0),
        (0.0, -40.0),
        (110.0, -40.0),
    ];
    assert_points(&Rows { alternation: 0.5, curve_right: false, ..rows() }, &expected);
}

#[test]
fn rows_end_before_the_step_that_leaves_the_width() {
    let narrow = Rows { width_m: 19.0, ..rows() };
    assert_points(&narrow, &[(-10.0, 0.0), (0.0, 0.0), (110.0, 0.0)]);
}

#[test]
fn rows_turn_with_their_bearing_and_cross_angle() {
    let east = Rows { bearing_rad: std::f64::consts::FRAC_PI_2, width_m: 19.0, ..rows() };
    assert_points(&east, &[(0.0, -10.0), (0.0, 0.0), (0.0, 110.0)]);
    let cross_angle_rad = 30_f64.to_radians();
    let crossed = Rows { cross_angle_rad, width_m: 20.0, curve_offset_m: 0.0, ..rows() };
    let side_m = 20.0 * cross_angle_rad.cos();
    assert_points(&crossed, &[(0.0, 0.0), (0.0, 0.0), (100.0, 0.0), (90.0, side_m), (-10.0, side_m)]);
}

#[test]
fn coverage_narrows_its_steps_over_shallow_water() {
    let swath = Swath { range_m: 50.0, aperture_rad: 60_f64.to_radians(), overlap: 0.2 };
    assert!((swath.width_m() - 50.0).abs() < 1e-9);
    let cases = [
        (None, 1.0),
        (Some(-1.0), 1.0),
        (Some(1_000.0), 0.9),
        (Some(20.0), 0.9 * 40.0 * 30_f64.to_radians().tan() / 50.0),
        (Some(0.01), 0.1),
    ];
    for (below_m, scale) in cases {
        assert!((swath.step_scale(below_m) - scale).abs() < 1e-9, "{below_m:?}");
    }
    let all_around = Swath { aperture_rad: 0.0, ..swath };
    assert!((all_around.width_m() - 100.0).abs() < 1e-9);
    assert!((all_around.step_scale(Some(1.0)) - 0.9).abs() < 1e-9);
}

#[test]
fn coverage_ends_where_its_rows_end() {
    let swath = Swath { range_m: 50.0, aperture_rad: 60_f64.to_radians(), overlap: 0.0 };
    let rows = rows();
    let coverage = RowsCoverage {
        origin: rows.origin,
        speed: SPEED,
        bearing_rad: 0.0,
        cross_angle_rad: 0.0,
        width_m: 120.0,
        length_m: 100.0,
        curve_offset_m: 0.0,
        swath,
        square_curve: false,
        curve_right: true,
    };
    let mut bench = Bench::new(Maneuver::RowsCoverage(coverage));
    let mut shallow = fix(0.0, 0.0);
    shallow.water_below_m = Some(20.0);
    bench.fix = Some(shallow);
    let mut last = path(&bench.start());
    while !bench.is_done() {
        if let [Command::Follow(path)] = bench.near()[..] {
            last = path;
        }
    }
    // Steps of 23.1 m fit five times into 120 m, steps of 50 m only twice.
    let east_m = frame().to_local(last.end).east_m;
    assert!((east_m - 5.0 * 40.0 * 30_f64.to_radians().tan()).abs() < 0.01, "{east_m}");
}

fn trajectory() -> FollowTrajectory<RawPlace> {
    let point = |north_m, time_s| TimedOffset { offset: offset(north_m, 0.0), time_s };
    let points = vec![point(0.0, 0.0), point(150.0, 100.0), point(300.0, 200.0)];
    FollowTrajectory { origin: origin(), points, speed: SPEED }
}

#[test]
fn trajectory_corrects_its_speed_when_late_or_early() {
    // Arrival at the second point and the speed to the third.
    let cases = [(100.0, 1.5), (101.9, 1.5), (110.0, 150.0 / 90.0), (150.0, 2.0), (500.0, 2.0), (40.0, 1.0)];
    for (second_s, mps) in cases {
        let mut bench = Bench::new(Maneuver::FollowTrajectory(trajectory()));
        path(&bench.start());
        bench.now_s = 1_000.0;
        assert_eq!(path(&bench.near()).speed, Speed::MetresPerSecond(1.5));
        bench.now_s = 1_000.0 + second_s;
        let Speed::MetresPerSecond(corrected_mps) = path(&bench.near()).speed else { panic!("not m/s") };
        assert!((corrected_mps - mps).abs() < 1e-6, "{second_s} s: {corrected_mps}");
        bench.near();
        assert!(bench.is_done());
    }
}

#[test]
fn a_path_that_is_refused_fails_the_maneuver() {
    for maneuver in [goto(1.0, 0.0), Maneuver::Rows(rows()), Maneuver::FollowTrajectory(trajectory())] {
        let mut bench = Bench::new(maneuver);
        bench.start();
        bench.event(&Event::PathFailed { path_ref: 1, reason: "too long".to_owned() });
        assert!(matches!(bench.outcome, Some(Outcome::Failed(_))));
    }
}
