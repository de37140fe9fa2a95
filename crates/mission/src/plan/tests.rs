//! Tests of plans.

use super::*;
use crate::kind::ManeuverKind;
use crate::maneuver::{FollowPath, FollowTrajectory, Loiter, Rows, TimedOffset};
use crate::place::Offset;
use crate::testing::{SPEED, draft, goto, idle, place};
use guard::Area;
use units::Speed;

fn problems(draft: &PlanDraft, limits: &PlanLimits) -> Vec<String> {
    match Plan::build(draft, limits) {
        Ok(_) => Vec::new(),
        Err(problems) => problems.0.iter().map(ToString::to_string).collect(),
    }
}

fn goto_at(lat_rad: f64, lon_rad: f64, speed: Speed) -> Maneuver<RawPlace> {
    Maneuver::Goto(crate::maneuver::Goto { target: RawPlace { lat_rad, lon_rad }, speed })
}

#[test]
fn six_hundred_waypoints_make_a_plan() {
    let maneuvers = (0..600).map(|index| goto(10.0 * f64::from(index), 0.0)).collect();
    let plan = Plan::build(&draft(maneuvers), &PlanLimits::default()).unwrap();
    assert_eq!(plan.order(), (0..600).collect::<Vec<_>>());
    assert_eq!(plan.warnings(), []);
    assert!(!plan.is_cyclic());
}

#[test]
fn tells_all_problems_at_once() {
    let mut bad = draft(vec![
        goto_at(f64::NAN, 0.1, SPEED),
        goto_at(0.0, 0.0, SPEED),
        goto_at(1.0, 9.0, Speed::MetresPerSecond(-3.0)),
        goto(1.0, 1.0),
        goto(2.0, 2.0),
        goto(3.0, 3.0),
        goto(4.0, 4.0),
    ]);
    bad.id.clear();
    bad.start = "nowhere".to_owned();
    bad.maneuvers[3].body = DraftBody::Missing;
    bad.maneuvers[4].body = DraftBody::Unsupported("YoYo".to_owned());
    bad.maneuvers[5].depth_m = Some(2.0);
    bad.maneuvers[6].id = "m5".to_owned();
    bad.transitions.push(TransitionDraft { from: "m0".to_owned(), to: "m99".to_owned() });
    bad.transitions.push(TransitionDraft { from: "m98".to_owned(), to: PLAN_END.to_owned() });
    let told = problems(&bad, &PlanLimits::default()).join("\n");
    let expected = [
        "the plan has no name",
        "m5: the name is used twice",
        "the first maneuver, 'nowhere', does not exist",
        "m5: a transition leads to 'm6', which does not exist",
        "m0: a transition leads to 'm99', which does not exist",
        "a transition leads from 'm98', which does not exist",
        "m0: no transition leads to it",
        "m0: latitude NaN° is not within -90° to 90°",
        "m1: the position is 0, 0",
        "m2: a speed of -3 m/s is not possible",
        "m2: longitude 515.662015617741° is not within -180° to 180°",
        "m3: it holds no maneuver",
        "m4: maneuver YoYo is not supported",
        "m5: a depth of 2 m is wanted, 0 m is possible",
    ];
    assert_eq!(told, expected.join("\n"));
}

#[test]
fn an_empty_plan_is_one_problem() {
    assert_eq!(problems(&draft(Vec::new()), &PlanLimits::default()), ["the plan has no maneuvers"]);
}

#[test]
fn a_text_of_many_problems_counts_the_rest() {
    let maneuvers = (0..600).map(|_| goto_at(f64::INFINITY, 0.0, SPEED)).collect();
    let problems = Plan::build(&draft(maneuvers), &PlanLimits::default()).unwrap_err();
    assert_eq!(problems.0.len(), 600);
    assert!(problems.to_string().ends_with("; and 590 more"), "{problems}");
}

#[test]
fn reserved_and_empty_names_are_refused() {
    for id in ["", PLAN_END] {
        let mut draft = draft(vec![goto(1.0, 0.0)]);
        (draft.start, draft.maneuvers[0].id) = (id.to_owned(), id.to_owned());
        assert_eq!(problems(&draft, &PlanLimits::default()).len(), 1, "{id}");
    }
}

#[test]
fn parameters_must_be_in_range() {
    let rows = |step_m, width_m| {
        Maneuver::Rows(Rows {
            origin: place(0.0, 0.0).into(),
            speed: SPEED,
            bearing_rad: 0.0,
            cross_angle_rad: 0.0,
            width_m,
            length_m: 100.0,
            step_m,
            curve_offset_m: 0.0,
            alternation: 1.0,
            square_curve: false,
            curve_right: true,
        })
    };
    let path =
        |points| Maneuver::FollowPath(FollowPath { origin: place(0.0, 0.0).into(), points, speed: SPEED });
    let circle = |radius_m| {
        Maneuver::Loiter(Loiter {
            centre: place(0.0, 0.0).into(),
            radius_m,
            speed: SPEED,
            duration: None,
            shape: LoiterShape::Circle(units::Turn::Clockwise),
        })
    };
    let cases = [
        (rows(0.0, 100.0), 1, "step"),
        (rows(0.01, 1000.0), 1, "too many rows"),
        (rows(10.0, f64::NAN), 1, "width"),
        (path(vec![Offset { north_m: f64::NAN, east_m: 1e9 }]), 2, "offsets"),
        (path(vec![Offset::default(); 10_001]), 1, "too many points"),
        (circle(-1.0), 1, "radius"),
        (circle(f64::INFINITY), 1, "radius"),
        (circle(20.0), 0, "fine"),
        (rows(10.0, 100.0), 0, "fine"),
    ];
    for (maneuver, count, what) in cases {
        let told = problems(&draft(vec![maneuver]), &PlanLimits::default());
        assert_eq!(told.len(), count, "{what}: {told:?}");
    }
}

#[test]
fn places_outside_the_area_are_refused() {
    let corners = [place(0.0, 0.0), place(100.0, 0.0), place(100.0, 100.0), place(0.0, 100.0)];
    let limits = PlanLimits { area: Some(Area::new(&corners).unwrap()), ..PlanLimits::default() };
    assert_eq!(problems(&draft(vec![goto(50.0, 50.0)]), &limits).len(), 0);
    let told = problems(&draft(vec![goto(50.0, 50.0), goto(50.0, 150.0)]), &limits);
    assert_eq!(told, ["m1: it leaves the area of operation by 50 m"]);
}

#[test]
fn kinds_that_the_vessel_does_not_do_are_refused() {
    let limits = PlanLimits { refused: [ManeuverKind::Idle].into(), ..PlanLimits::default() };
    assert_eq!(problems(&draft(vec![idle(1)]), &limits), ["m0: maneuver Idle is not supported"]);
}

#[test]
fn only_the_first_transition_counts() {
    let mut draft = draft(vec![goto(1.0, 0.0), goto(2.0, 0.0), goto(3.0, 0.0)]);
    draft.transitions = vec![
        TransitionDraft { from: "m0".to_owned(), to: "m2".to_owned() },
        TransitionDraft { from: "m0".to_owned(), to: "m1".to_owned() },
        TransitionDraft { from: "m2".to_owned(), to: PLAN_END.to_owned() },
    ];
    let plan = Plan::build(&draft, &PlanLimits::default()).unwrap();
    assert_eq!(plan.order(), [0, 2]);
    let ignored = PlanWarning::TransitionIgnored { from: "m0".to_owned(), to: "m1".to_owned() };
    assert_eq!(plan.warnings(), [PlanWarning::NeverReached("m1".to_owned()), ignored]);
}

#[test]
fn cycles_are_legal_and_told() {
    let mut draft = draft(vec![goto(1.0, 0.0), goto(2.0, 0.0)]);
    draft.transitions.push(TransitionDraft { from: "m1".to_owned(), to: "m0".to_owned() });
    let plan = Plan::build(&draft, &PlanLimits::default()).unwrap();
    assert_eq!((plan.order(), plan.is_cyclic()), (vec![0, 1], true));
    assert_eq!(plan.warnings(), [PlanWarning::Cycle]);
}

#[test]
fn what_cannot_be_followed_refuses_the_plan_or_is_told() {
    let note = |maneuver: Option<&str>, refuses, text: &str| DraftNote {
        maneuver: maneuver.map(str::to_owned),
        refuses,
        text: text.to_owned(),
    };
    let mut plan = draft(vec![goto(1.0, 1.0), goto(2.0, 2.0)]);
    plan.notes = vec![note(Some("m1"), false, "left out"), note(None, false, "odd")];
    let built = Plan::build(&plan, &PlanLimits::default()).unwrap();
    let told: Vec<String> = built.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(told, ["m1: left out", "odd"]);
    plan.notes.push(note(Some("m0"), true, "not possible"));
    assert_eq!(problems(&plan, &PlanLimits::default()), ["m0: not possible"]);
}

#[test]
fn a_timetable_that_needs_too_much_speed_is_refused() {
    let point = |north_m, time_s| TimedOffset { offset: Offset { north_m, east_m: 0.0 }, time_s };
    let timed = |time_s| {
        draft(vec![Maneuver::FollowTrajectory(FollowTrajectory {
            origin: place(0.0, 0.0).into(),
            points: vec![point(0.0, 0.0), point(100.0, time_s)],
            speed: SPEED,
        })])
    };
    let slow = PlanLimits { max_timed_mps: 2.0, ..PlanLimits::default() };
    assert_eq!(problems(&timed(50.0), &slow), Vec::<String>::new());
    assert_eq!(problems(&timed(40.0), &slow), ["m0: a speed of 2.5 m/s is not possible"]);
    assert_eq!(problems(&timed(40.0), &PlanLimits::default()), Vec::<String>::new());
}
