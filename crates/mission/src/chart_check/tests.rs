//! Plans on a made-up sea: what each maneuver sweeps, and what is said about it.

use super::*;
use crate::maneuver::{FollowPath, Idle, Loiter, LoiterShape, Maneuver, Rows, StationKeeping, Teleoperation};
use crate::place::RawPlace;
use crate::testing::{SPEED, draft, frame, goto, idle, place, plan};
use crate::{Operator, PlanLimits, TransitionDraft};
use guard::{Outcome, Part, Reason};
use std::time::Duration;
use testkit::sea::{Ground, Sea};
use units::{LocalPoint, Turn};

fn point(north_m: f64, east_m: f64) -> LocalPoint {
    LocalPoint { north_m, east_m }
}

/// 20 m deep, 4 km wide, with an islet of 100 m at the middle.
fn islet() -> DepthIndex {
    sea().with(Ground::Land, point(0.0, 0.0), 100.0, 24).index()
}

fn sea() -> Sea {
    Sea::new(frame().origin(), 2000.0, 20.0)
}

fn check(maneuvers: Vec<Maneuver<RawPlace>>, from: (f64, f64), index: &DepthIndex) -> Verdict {
    check_plan(&plan(maneuvers), Some(place(from.0, from.1)), index, &GuardLimits::default())
}

fn first(verdict: &Verdict) -> (Part, u32, Reason) {
    let leg = verdict.refused().next().unwrap();
    (leg.part, leg.number, leg.reason.unwrap())
}

fn station(north_m: f64, east_m: f64, radius_m: f64) -> Maneuver<RawPlace> {
    let centre = place(north_m, east_m).into();
    Maneuver::StationKeeping(StationKeeping { centre, radius_m, speed: SPEED, duration: None })
}

fn loiter(north_m: f64, east_m: f64, radius_m: f64, shape: LoiterShape) -> Maneuver<RawPlace> {
    let (centre, duration) = (place(north_m, east_m).into(), Some(Duration::from_mins(1)));
    Maneuver::Loiter(Loiter { centre, radius_m, speed: SPEED, duration, shape })
}

#[test]
fn the_way_to_the_first_point_counts() {
    let index = islet();
    let verdict = check(vec![goto(500.0, 0.0)], (-500.0, 0.0), &index);
    assert_eq!(first(&verdict), (Part::Transit, 0, Reason::Land));
    let leg = &verdict.legs[0];
    assert_eq!((leg.label.as_str(), leg.spot.class), ("m0", Some("LNDARE")));
    assert_eq!((leg.spot.cell.as_deref(), leg.spot.scale), (Some("XX5SEA01"), Some(10_000)));
    assert!((frame().to_local(leg.spot.at)).distance_m(point(0.0, 0.0)) <= 101.0);
    assert!(verdict.summary().contains("land"), "{}", verdict.summary());
    assert_eq!(check(vec![goto(500.0, 0.0)], (500.0, 300.0), &index).outcome(), Outcome::Ok);
    let nowhere = check_plan(&plan(vec![goto(500.0, 0.0)]), None, &index, &GuardLimits::default());
    assert_eq!(nowhere.outcome(), Outcome::Warnings);
    assert_eq!(nowhere.warnings, [Warning::StartUnknown { label: "m0".to_owned() }]);
}

#[test]
fn the_corridor_is_as_wide_as_it_says() {
    let index = islet();
    let GuardLimits { position_m, .. } = GuardLimits::default();
    let wide_m = GuardLimits::default().half_width_m() + position_m;
    let passing = |off_m: f64| check(vec![goto(600.0, 100.0 + off_m)], (-600.0, 100.0 + off_m), &index);
    assert!(passing(wide_m - 0.5).is_refused());
    assert!(!passing(wide_m + 0.5).is_refused());
}

#[test]
fn depth_is_judged_twice() {
    let index = sea().with(Ground::Depth(3.0), point(0.0, 0.0), 50.0, 8).index();
    let verdict = check(vec![goto(500.0, 0.0)], (-500.0, 0.0), &index);
    assert_eq!(first(&verdict).2, Reason::TooShallowAlone);
    let spot = &verdict.legs[0].spot;
    assert_eq!((spot.least_m, spot.margin_m), (Some(3.0), Some(-2.0)));
    let index = sea().with(Ground::Depth(0.5), point(0.0, 0.0), 50.0, 8).index();
    assert_eq!(first(&check(vec![goto(500.0, 0.0)], (-500.0, 0.0), &index)).2, Reason::TooShallow);
    let index = sea().with(Ground::Hole, point(0.0, 0.0), 50.0, 8).index();
    let verdict = check(vec![goto(500.0, 0.0)], (-500.0, 0.0), &index);
    assert_eq!((first(&verdict).2, verdict.legs[0].spot.class), (Reason::NoData, None));
    let outside = check(vec![goto(2500.0, 0.0)], (1500.0, 0.0), &sea().index());
    assert_eq!(first(&outside).2, Reason::NoData);
    let index = sea().with(Ground::Danger, point(0.0, 0.0), 50.0, 8).index();
    let verdict = check(vec![goto(500.0, 0.0)], (-500.0, 0.0), &index);
    assert_eq!(first(&verdict).2, Reason::UnknownDepth);
}

#[test]
fn station_keeping_needs_its_radius() {
    let index = islet();
    assert_eq!(first(&check(vec![station(300.0, 0.0, 200.0)], (300.0, 0.0), &index)).0, Part::Station);
    assert_eq!(check(vec![station(300.0, 0.0, 150.0)], (300.0, 0.0), &index).outcome(), Outcome::Ok);
    // From anywhere in the disc, also from its far side, the way leads on.
    let leaving = vec![station(300.0, 0.0, 150.0), goto(300.0, 600.0)];
    let leaving: Vec<_> = leaving.into_iter().map(timed).collect();
    assert_eq!(check(leaving, (300.0, 0.0), &index).outcome(), Outcome::Ok);
    let past = vec![timed(station(-260.0, 0.0, 140.0)), goto(0.0, 250.0)];
    let verdict = check(past, (-300.0, 0.0), &index);
    assert_eq!(first(&verdict).0, Part::Transit);
}

fn timed(maneuver: Maneuver<RawPlace>) -> Maneuver<RawPlace> {
    match maneuver {
        Maneuver::StationKeeping(station) => {
            Maneuver::StationKeeping(StationKeeping { duration: Some(Duration::from_mins(1)), ..station })
        }
        other => other,
    }
}

#[test]
fn a_circle_around_an_islet_is_sailed_and_not_crossed() {
    let index = islet();
    let around = |radius_m| loiter(0.0, 0.0, radius_m, LoiterShape::Circle(Turn::Clockwise));
    assert_eq!(check(vec![around(200.0)], (-600.0, 0.0), &index).outcome(), Outcome::Ok);
    let close = check(vec![around(110.0)], (-600.0, 0.0), &index);
    assert!(close.refused().any(|leg| leg.part == Part::Circle));
    // When its time is over it may be anywhere on the circle, also behind the islet.
    let onward = check(vec![around(200.0), goto(600.0, 0.0)], (-600.0, 0.0), &index);
    assert_eq!(first(&onward), (Part::Transit, 0, Reason::Land));
    // From inside, the approach is not known.
    assert_eq!(first(&check(vec![around(400.0)], (-200.0, 0.0), &index)).0, Part::Transit);
    let eight = LoiterShape::Eight { length_m: 600.0, bearing_rad: 0.0 };
    let verdict = check(vec![loiter(0.0, 0.0, 50.0, eight)], (-600.0, 0.0), &index);
    assert_eq!(first(&verdict).0, Part::Circle);
    let beside = check(vec![loiter(0.0, 400.0, 50.0, eight)], (-600.0, 400.0), &index);
    assert_eq!(beside.outcome(), Outcome::Ok);
}

#[test]
fn a_circle_is_met_on_the_side_that_its_sense_asks_for() {
    // North of the start; clockwise is met in the west, counter-clockwise in the east.
    let index = sea().with(Ground::Land, point(-100.0, -150.0), 60.0, 24).index();
    let circle = |turn| {
        let verdict =
            check(vec![loiter(200.0, 0.0, 200.0, LoiterShape::Circle(turn))], (-600.0, 0.0), &index);
        verdict.legs.into_iter().find(|leg| leg.part == Part::Transit).unwrap().reason
    };
    assert_eq!(circle(Turn::Clockwise), Some(Reason::Land));
    assert_eq!(circle(Turn::CounterClockwise), None);
}

#[test]
fn rows_and_paths_are_followed_leg_by_leg() {
    let index = islet();
    let rows = Rows {
        origin: RawPlace::from(place(-300.0, -300.0)),
        speed: SPEED,
        bearing_rad: 0.0,
        cross_angle_rad: 0.0,
        width_m: 600.0,
        length_m: 600.0,
        step_m: 100.0,
        curve_offset_m: 15.0,
        alternation: 1.0,
        square_curve: true,
        curve_right: true,
    };
    let verdict = check(vec![Maneuver::Rows(rows)], (-600.0, -300.0), &index);
    assert_eq!(first(&verdict).0, Part::Track);
    let narrow = Rows { width_m: 150.0, ..rows };
    assert_eq!(check(vec![Maneuver::Rows(narrow)], (-600.0, -300.0), &index).outcome(), Outcome::Ok);
    let origin = place(0.0, 0.0).into();
    let around = [point(-300.0, 0.0), point(-300.0, 300.0), point(300.0, 300.0), point(300.0, 0.0)];
    let path = |points: &[LocalPoint]| {
        vec![Maneuver::FollowPath(FollowPath { origin, points: points.to_vec(), speed: SPEED })]
    };
    assert_eq!(check(path(&around), (-600.0, 0.0), &index).outcome(), Outcome::Ok);
    let through = [around[0], around[3]];
    assert_eq!(first(&check(path(&through), (-600.0, 0.0), &index)), (Part::Track, 0, Reason::Land));
}

#[test]
fn drifting_grows_and_what_nobody_knows_is_told() {
    let index = islet();
    let drifting = |seconds| check(vec![goto(150.0, 0.0), idle(seconds)], (300.0, 0.0), &index);
    assert_eq!(drifting(60).outcome(), Outcome::Ok);
    assert_eq!(first(&drifting(600)).0, Part::Drift);
    let endless = drifting(0);
    assert_eq!(endless.warnings, [Warning::DriftsOn { label: "m1".to_owned() }]);
    let steered = Maneuver::Teleoperation(Teleoperation { operator: Operator::Anyone });
    let verdict = check(vec![steered, goto(500.0, 0.0)], (-500.0, 0.0), &index);
    let codes: Vec<_> = verdict.warnings.iter().map(Warning::code).collect();
    assert_eq!((verdict.outcome(), codes), (Outcome::Warnings, vec!["unchecked", "start-unknown"]));
}

#[test]
fn the_way_back_of_a_circle_of_maneuvers_counts() {
    let index = islet();
    let mut there_and_back = draft(vec![goto(-300.0, 0.0), goto(0.0, 300.0), goto(300.0, 0.0)]);
    there_and_back.transitions.push(TransitionDraft { from: "m2".to_owned(), to: "m0".to_owned() });
    let cyclic = Plan::build(&there_and_back, &PlanLimits::default()).unwrap();
    let from = Some(place(-300.0, 50.0));
    let verdict = check_plan(&cyclic, from, &index, &GuardLimits::default());
    assert_eq!((first(&verdict), verdict.refused().count()), ((Part::Transit, 0, Reason::Land), 1));
    assert_eq!(verdict.legs.len(), 4);
    let open = check(vec![goto(-300.0, 0.0), goto(0.0, 300.0), goto(300.0, 0.0)], (-300.0, 50.0), &index);
    assert_eq!(open.outcome(), Outcome::Ok);
}

#[test]
fn what_is_too_large_is_refused() {
    let origin = RawPlace::from(place(500.0, 500.0));
    let points: Vec<LocalPoint> =
        (0..9_999).map(|n| point(if n % 2 == 0 { 0.0 } else { 200.0 }, 0.0)).collect();
    let long = Maneuver::FollowPath(FollowPath { origin, points, speed: SPEED });
    let verdict = check(vec![long], (500.0, 500.0), &sea().index());
    assert!(verdict.too_much && verdict.is_refused());
    assert!(verdict.summary().contains("too large"));
}

#[test]
fn limits_that_are_no_numbers_find_everything_dangerous() {
    let index = sea().index();
    let good = GuardLimits::default();
    assert_eq!(good.validate(), Ok(()));
    let still = plan(vec![Maneuver::Idle(Idle { duration: Some(Duration::from_secs(1)) }), goto(100.0, 0.0)]);
    for bad in [
        GuardLimits { autonomous_m: f64::NAN, ..good },
        GuardLimits { position_m: f64::NAN, ..good },
        GuardLimits { cross_track_m: f64::NAN, ..good },
        GuardLimits { drift_mps: f64::NAN, ..good },
        GuardLimits { water_level_m: f64::NAN, ..good },
    ] {
        assert!(bad.validate().is_err());
        assert!(check_plan(&still, Some(place(0.0, 0.0)), &index, &bad).is_refused(), "{bad:?}");
    }
}
