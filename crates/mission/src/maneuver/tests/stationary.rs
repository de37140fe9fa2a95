//! Maneuvers that stay somewhere.

use super::{Bench, path};
use crate::command::{Circle, Command, Operator, PathStart};
use crate::event::{Event, Fix};
use crate::maneuver::{Left, Loiter, LoiterShape, Maneuver, StationKeeping, Teleoperation};
use crate::place::RawPlace;
use crate::testing::{SPEED, fix, frame, idle, place};
use std::time::Duration;
use units::Turn;

fn station(duration_s: u64) -> Maneuver<RawPlace> {
    Maneuver::StationKeeping(StationKeeping {
        centre: place(0.0, 0.0).into(),
        radius_m: 10.0,
        speed: SPEED,
        duration: (duration_s > 0).then_some(Duration::from_secs(duration_s)),
    })
}

fn loiter(shape: LoiterShape, radius_m: f64) -> Maneuver<RawPlace> {
    let duration = Some(Duration::from_mins(10));
    Maneuver::Loiter(Loiter { centre: place(0.0, 0.0).into(), radius_m, speed: SPEED, duration, shape })
}

#[test]
fn station_keeping_drifts_inside_and_drives_back_from_outside() {
    let mut bench = Bench::new(station(0));
    assert_eq!(bench.start(), [Command::Drift], "without a fix it waits");
    let out = path(&bench.fix(fix(40.0, 0.0)));
    assert_eq!((out.start, out.circle), (PathStart::Here, None));
    assert!(frame().to_local(out.end).north_m.abs() < 1e-3, "to the centre, how it drifts is not known");
    assert_eq!(bench.fix(fix(20.0, 0.0)), []);
    assert_eq!(bench.fix(fix(5.0, 0.0)), [], "it goes on to the centre");
    assert_eq!(bench.fix(fix(1.0, 0.0)), [Command::Drift], "the rest it runs without motors");
    assert_eq!(bench.fix(fix(9.9, 0.0)), [], "it drifts");
    path(&bench.fix(fix(10.1, 0.0)));
    assert_eq!(bench.fix(fix(-0.5, 4.0)), [Command::Drift], "past the centre, however far beside it");
    bench.pass(1e6);
    assert!(!bench.is_done(), "it never ends by itself");
}

#[test]
fn station_keeping_turns_back_by_what_its_position_may_be_wrong() {
    let mut bench = Bench::new(station(0));
    bench.fix = Some(fix(0.0, 0.0));
    bench.start();
    let at = |north_m, sigma_m| Fix { sigma_m, ..fix(north_m, 0.0) };
    assert_eq!(bench.fix(at(7.9, 1.0)), []);
    path(&bench.fix(at(8.1, 1.0)));
    bench.fix(at(0.0, 1.0));
    assert_eq!(bench.fix(at(4.9, 50.0)), [], "half the radius is left in any case");
    path(&bench.fix(at(5.1, 50.0)));
}

#[test]
fn station_keeping_drives_towards_the_weather_before_it_has_drifted_out() {
    let mut bench = Bench::new(station(0));
    bench.fix = Some(fix(0.0, 0.0));
    bench.start();
    let mut north_m = 0.0;
    let back = loop {
        bench.now_s += 1.0;
        north_m += 0.1;
        let commands = bench.fix(fix(north_m, 0.0));
        if !commands.is_empty() {
            break path(&commands);
        }
    };
    // 0.1 m/s for the 12 s of a turn.
    assert!((8.7..8.95).contains(&north_m), "{north_m}");
    let aim = frame().to_local(back.end);
    assert!((aim.north_m + 8.0).abs() < 0.1 && aim.east_m.abs() < 0.1, "{aim:?}");
    assert_eq!(bench.fix(fix(-7.0, 0.0)), [Command::Drift]);
    bench.now_s += 30.0;
    assert_eq!(bench.fix(fix(-9.9, 0.0)), [], "from there it drifts inward");
    path(&bench.fix(fix(-10.1, 0.0)));
}

#[test]
fn station_keeping_goes_on_where_path_control_is_content() {
    let mut bench = Bench::new(station(0));
    bench.fix = Some(fix(40.0, 0.0));
    path(&bench.start());
    bench.now_s = 0.5;
    assert_eq!(bench.near(), []);
    bench.now_s = 1.0;
    assert_eq!(path(&bench.near()).path_ref, 2, "once a second, so that path control goes on");
    assert_eq!(bench.near(), []);
}

#[test]
fn station_keeping_counts_from_the_first_arrival() {
    let mut bench = Bench::new(station(60));
    bench.fix = Some(fix(40.0, 0.0));
    bench.start();
    let left = bench.left().unwrap();
    assert!((left.way_m - 40.0).abs() < 1e-3 && (left.wait_s - 60.0).abs() < 1e-9);
    bench.pass(100.0);
    bench.fix(fix(0.5, 0.0));
    bench.pass(130.0);
    path(&bench.fix(fix(11.0, 0.0)));
    bench.pass(170.0);
    assert!(!bench.is_done(), "it comes back first");
    bench.fix(fix(0.5, 0.0));
    assert!(bench.is_done());
}

#[test]
fn station_keeping_is_done_after_its_duration_while_drifting() {
    let mut bench = Bench::new(station(60));
    bench.fix = Some(fix(1.0, 0.0));
    assert_eq!(bench.start(), [Command::Drift]);
    bench.pass(59.0);
    assert!(!bench.is_done());
    bench.pass(60.0);
    assert!(bench.is_done());
}

#[test]
fn loiter_circles_until_its_time_is_over() {
    let cases = [
        (LoiterShape::Circle(Turn::Clockwise), Turn::Clockwise, 20.0, 20.0),
        (LoiterShape::Circle(Turn::CounterClockwise), Turn::CounterClockwise, 20.0, 20.0),
        (LoiterShape::Other(Turn::Clockwise), Turn::Clockwise, 0.0, 1.0),
    ];
    for (shape, turn, asked_m, radius_m) in cases {
        let mut bench = Bench::new(loiter(shape, asked_m));
        assert_eq!(path(&bench.start()).circle, Some(Circle { radius_m, turn }));
        bench.pass(1_000.0);
        assert!(!bench.is_done(), "the time counts from the circle");
        bench.loitering();
        assert_eq!(bench.left(), Some(Left { way_m: 0.0, wait_s: 600.0 }));
        bench.pass(1_599.0);
        assert!(!bench.is_done());
        bench.pass(1_600.0);
        assert!(bench.is_done());
    }
}

#[test]
fn a_figure_of_eight_changes_circles_abeam_of_their_centres() {
    let shape = LoiterShape::Eight { length_m: 100.0, bearing_rad: 0.0 };
    let mut bench = Bench::new(loiter(shape, 20.0));
    let first = path(&bench.start());
    assert!((frame().to_local(first.end).north_m + 50.0).abs() < 1e-3);
    assert_eq!(first.circle.map(|circle| circle.turn), Some(Turn::Clockwise));
    bench.loitering();
    for (north_m, east_m) in [(-30.0, 0.0), (-50.0, 20.0), (-70.0, 0.0), (-55.0, -20.0)] {
        assert_eq!(bench.fix(fix(north_m, east_m)), []);
    }
    let second = path(&bench.fix(fix(-49.0, -20.0)));
    assert!((frame().to_local(second.end).north_m - 50.0).abs() < 1e-3);
    assert_eq!(second.circle.map(|circle| circle.turn), Some(Turn::CounterClockwise));
    assert_eq!(bench.fix(fix(70.0, 0.0)), [], "not on the circle yet");
    bench.loitering();
    assert_eq!(bench.fix(fix(70.0, 0.0)), []);
    let third = path(&bench.fix(fix(49.0, -20.0)));
    assert_eq!(third.end, first.end);
}

#[test]
fn idle_ends_by_time_or_never() {
    let mut bench = Bench::new(idle(5));
    assert_eq!(bench.start(), [Command::Drift]);
    bench.pass(4.9);
    assert!(!bench.is_done());
    bench.pass(5.0);
    assert!(bench.is_done());
    let mut endless = Bench::new(idle(0));
    endless.start();
    endless.pass(1e6);
    assert_eq!((endless.is_done(), endless.left()), (false, None));
}

#[test]
fn teleoperation_ends_by_its_operator() {
    for (operator, from, ends) in
        [(Operator::Anyone, 7, true), (Operator::System(7), 7, true), (Operator::System(8), 7, false)]
    {
        let mut bench = Bench::new(Maneuver::Teleoperation(Teleoperation { operator }));
        assert_eq!(bench.start(), [Command::Teleoperate(operator)]);
        bench.event(&Event::TeleoperationDone { from });
        assert_eq!(bench.is_done(), ends);
    }
}
