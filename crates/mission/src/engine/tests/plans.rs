//! Plans: how they start, continue and end, and the replies.

use super::*;
use crate::maneuver::FailReason;
use crate::plan::TransitionDraft;
use crate::plan_limits::PlanLimits;
use crate::testing::{draft, goto, idle, progress};

fn text(request: u16, ok: bool, text: &str) -> (u16, bool, String) {
    (request, ok, text.to_owned())
}

#[test]
fn a_start_is_answered_three_times_under_its_number() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0), goto(200.0, 0.0)]);
    assert_eq!(bench.replies(), [text(1, true, "plan loaded"), text(1, true, "m0: executing maneuver")]);
    assert_eq!((bench.phase(), bench.mode()), (PlanPhase::Executing, Mode::Maneuver));
    bench.near();
    assert_eq!(bench.replies(), []);
    assert_eq!(bench.engine.plan_state(at(0.0)).maneuver.unwrap().0, "m1");
    bench.near();
    assert_eq!(bench.last_command(), Some(Command::Drift));
    assert_eq!(bench.replies(), [text(1, true, "plan completed")]);
    assert_eq!((bench.phase(), bench.mode()), (PlanPhase::Ready, Mode::Service));
    assert_eq!(bench.outcome(), LastOutcome::Success);
}

#[test]
fn a_start_comes_out_in_the_order_of_the_original() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0)]);
    let order: Vec<&str> = bench
        .told
        .iter()
        .map(|output| match output {
            Output::Note(_) => "note",
            Output::PlanState(state) if state.phase == PlanPhase::Initializing => "initializing",
            Output::PlanState(state) if state.phase == PlanPhase::Executing => "executing",
            Output::PlanState(_) => "plan state",
            Output::Reply(_) => "reply",
            Output::PlanBegins { .. } => "begins",
            Output::Actions { .. } => "actions",
            Output::ManeuverBegins { .. } => "maneuver",
            Output::Command(_) => "command",
            Output::VehicleState(_) => "vehicle state",
            _ => "other",
        })
        .collect();
    let expected = [
        "note",
        "initializing",
        "reply",
        "begins",
        "actions",
        "actions",
        "maneuver",
        "command",
        "vehicle state",
        "executing",
        "reply",
    ];
    assert_eq!(order, expected);
}

#[test]
fn between_maneuvers_the_state_says_done_and_the_loops_stay() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0), goto(200.0, 0.0)]);
    bench.told.clear();
    bench.near();
    let done = |output: &Output| matches!(output, Output::VehicleState(state) if state.maneuver_done);
    assert_eq!(bench.told.iter().filter(|output| done(output)).count(), 1);
    assert!(!bench.told.contains(&Output::Command(Command::Drift)));
    let transition = ActionPoint::Transition { from: "m0".to_owned(), to: "m1".to_owned() };
    assert!(bench.told.contains(&Output::Actions { run: RunId(1), point: transition }));
}

#[test]
fn a_stop_counts_as_failure_and_answers_only_itself() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0)]);
    bench.told.clear();
    bench.ask("", RequestKind::Stop);
    assert_eq!(bench.last_command(), Some(Command::Drift));
    assert_eq!(bench.replies(), [text(2, true, "OK")]);
    assert_eq!((bench.phase(), bench.outcome()), (PlanPhase::Ready, LastOutcome::Failure));
}

#[test]
fn requests_out_of_place_are_refused() {
    let mut bench = Bench::new();
    bench.start("survey", vec![idle(1)]);
    bench.pass(1.0);
    bench.told.clear();
    bench.ask("", RequestKind::Stop);
    bench.ask("", RequestKind::Get);
    let replies = bench.replies();
    let expected =
        [text(2, false, "no plan is running, request ignored"), text(3, false, "no plan is running")];
    assert_eq!(replies, expected);
    assert_eq!(bench.outcome(), LastOutcome::Success, "a needless stop changes no outcome");
    bench.ask("x", RequestKind::Load { plan: Ok(Box::new(plan(vec![goto(1.0, 0.0)]))) });
    assert_eq!(bench.replies(), [text(4, true, "plan loaded")]);
    bench.start("survey", vec![goto(100.0, 0.0)]);
    bench.told.clear();
    bench.ask("x", RequestKind::Load { plan: Ok(Box::new(plan(vec![goto(1.0, 0.0)]))) });
    bench.ask("", RequestKind::Get);
    assert_eq!(bench.replies(), [text(6, false, "cannot load while a plan is running"), text(7, true, "OK")]);
}

#[test]
fn a_start_replaces_the_running_plan_without_a_gap() {
    let mut bench = Bench::new();
    bench.start("one", vec![goto(100.0, 0.0)]);
    bench.told.clear();
    bench.start("two", vec![goto(200.0, 0.0)]);
    assert!(!bench.told.contains(&Output::Command(Command::Drift)));
    assert!(bench.told.contains(&Output::PlanEnded {
        run: RunId(1),
        plan_id: "one".to_owned(),
        reason: EndReason::Replaced
    }));
    let ready =
        |output: &Output| matches!(output, Output::PlanState(state) if state.phase == PlanPhase::Ready);
    assert!(!bench.told.iter().any(ready));
    assert_eq!(bench.replies().len(), 2, "none for the plan replaced");
    let state = bench.engine.plan_state(at(0.0));
    assert_eq!((state.plan_id.as_str(), state.run), ("two", Some(RunId(2))));
}

#[test]
fn a_plan_that_is_not_possible_fails_and_leaves_a_running_one_alone() {
    let mut bench = Bench::new();
    let options = StartOptions::default();
    bench.ask("x", RequestKind::Start { plan: Err(NoPlan::Undefined), options });
    assert_eq!(bench.replies(), [text(1, false, "undefined plan")]);
    assert_eq!((bench.phase(), bench.outcome()), (PlanPhase::Ready, LastOutcome::Failure));
    bench.start("survey", vec![goto(100.0, 0.0)]);
    bench.told.clear();
    bench.ask("x", RequestKind::Start { plan: Err(NoPlan::Undefined), options });
    assert_eq!(bench.replies(), [text(3, false, "undefined plan")]);
    assert_eq!(bench.phase(), PlanPhase::Executing);
}

#[test]
fn calibration_comes_first_and_is_answered_once() {
    let mut bench = Bench::new();
    let options = StartOptions { calibrate: true, ..StartOptions::default() };
    bench.start_with("survey", vec![goto(100.0, 0.0)], options);
    assert_eq!((bench.phase(), bench.mode()), (PlanPhase::Initializing, Mode::Calibration));
    bench.entities(&[("gps", EntityCondition::Error)]);
    bench.entities(&[]);
    bench.pass(2.9);
    assert_eq!(bench.mode(), Mode::Calibration);
    bench.pass(3.0);
    assert_eq!((bench.phase(), bench.mode()), (PlanPhase::Executing, Mode::Maneuver));
    assert_eq!(bench.replies(), [text(1, true, "plan loaded")]);
    bench.start_with("survey", vec![goto(100.0, 0.0)], options);
    assert_eq!(bench.last_command(), Some(Command::Drift));
    bench.ask("", RequestKind::Stop);
    bench.pass(100.0);
    assert_eq!((bench.phase(), bench.mode()), (PlanPhase::Ready, Mode::Service));
}

#[test]
fn a_failing_maneuver_fails_the_plan() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0)]);
    bench.told.clear();
    let reason = "off track".to_owned();
    bench.input(Input::Event(Event::PathFailed { path_ref: 1, reason }));
    assert_eq!(bench.last_command(), Some(Command::Drift));
    assert_eq!(bench.replies(), [text(1, false, "m0: maneuver error: path control: off track")]);
    assert_eq!(bench.mode(), Mode::Service);
    let state = bench.engine.vehicle_state(at(0.0));
    assert_eq!(state.last_error.unwrap().0, "Goto maneuver error: path control: off track");
}

#[test]
fn progress_of_older_paths_is_ignored() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0), goto(200.0, 0.0)]);
    bench.near();
    bench.input(Input::Event(near(1)));
    bench.input(Input::Event(Event::PathFailed { path_ref: 1, reason: String::new() }));
    assert_eq!(bench.engine.plan_state(at(0.0)).maneuver.unwrap().0, "m1");
}

#[test]
fn silent_path_control_fails_the_plan() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(100.0, 0.0)]);
    bench.pass(9.0);
    bench.input(Input::Event(Event::Path(progress(1, 50.0))));
    bench.pass(18.9);
    assert_eq!(bench.phase(), PlanPhase::Executing);
    bench.pass(19.0);
    let reason = EndReason::Maneuver { maneuver: "m0".to_owned(), reason: FailReason::PathSilent };
    assert_eq!(bench.replies().last().unwrap().2, reason.to_string());
    assert_eq!(bench.phase(), PlanPhase::Ready);
}

#[test]
fn cycles_go_round_and_empty_ones_fail() {
    let cyclic = |maneuvers| {
        let mut draft = draft(maneuvers);
        draft.transitions.push(TransitionDraft { from: "m1".to_owned(), to: "m0".to_owned() });
        RequestKind::Start {
            plan: Ok(Box::new(Plan::build(&draft, &PlanLimits::default()).unwrap())),
            options: StartOptions::default(),
        }
    };
    let mut bench = Bench::new();
    bench.ask("round", cyclic(vec![goto(100.0, 0.0), goto(0.0, 0.0)]));
    for _ in 0..1_000 {
        bench.near();
    }
    assert_eq!(bench.phase(), PlanPhase::Executing);
    assert_eq!(bench.engine.plan_state(at(0.0)).progress, None);
    let empty = || {
        Maneuver::FollowPath(crate::FollowPath {
            origin: crate::testing::place(0.0, 0.0).into(),
            points: Vec::new(),
            speed: crate::testing::SPEED,
        })
    };
    bench.told.clear();
    bench.ask("empty", cyclic(vec![empty(), empty()]));
    assert_eq!(bench.phase(), PlanPhase::Ready);
    assert_eq!(bench.replies().last().unwrap().2, EndReason::EmptyCycle.to_string());
}

#[test]
fn sails_six_hundred_waypoints() {
    let mut bench = Bench::new();
    bench.start("long", (0..600).map(|index| goto(10.0 * f64::from(index), 0.0)).collect());
    for index in 0..600 {
        assert_eq!(bench.engine.plan_state(at(0.0)).maneuver.unwrap().0, format!("m{index}"));
        bench.told.clear();
        bench.near();
    }
    assert_eq!(bench.outcome(), LastOutcome::Success);
}

#[test]
fn tells_progress_and_time_to_the_end() {
    let mut bench = Bench::new();
    bench.start("survey", vec![goto(150.0, 0.0), idle(100)]);
    let state = bench.engine.plan_state(at(0.0));
    assert!((state.plan_eta_s.unwrap() - 200.0).abs() < 0.1);
    assert!((state.maneuver_eta_s.unwrap() - 100.0).abs() < 0.1);
    bench.pass(5.0);
    bench.near();
    bench.pass(55.0);
    let state = bench.engine.plan_state(at(55.0));
    assert!((state.progress.unwrap() - 0.75).abs() < 0.01);
    assert!((state.plan_eta_s.unwrap() - 50.0).abs() < 0.1);
}
