//! Modes of the vehicle: entities, aborts, loops from outside.

use super::*;
use crate::testing::goto;

const ERROR: EntityCondition = EntityCondition::Error;
const BOOT: EntityCondition = EntityCondition::Boot;
const IGNORING: StartOptions = StartOptions { calibrate: false, ignore_errors: true };

fn begin(maneuver: Maneuver<RawPlace>, options: StartOptions) -> Bench {
    let mut bench = Bench::new();
    bench.start_with("plan", vec![maneuver], options);
    assert_eq!(bench.mode(), Mode::Maneuver);
    bench
}

#[test]
fn boots_when_nothing_boots_any_more() {
    let cases: [(&[(&str, EntityCondition)], Mode); 4] = [
        (&[], Mode::Service),
        (&[("gps", BOOT)], Mode::Boot),
        (&[("gps", BOOT), ("motor", ERROR)], Mode::Boot),
        (&[("motor", ERROR)], Mode::Error),
    ];
    for (bad, mode) in cases {
        let mut bench = Bench::new();
        bench.engine = Engine::new(EngineConfig::default());
        assert_eq!((bench.mode(), bench.phase()), (Mode::Boot, PlanPhase::Blocked));
        bench.entities(bad);
        assert_eq!(bench.mode(), mode, "{bad:?}");
    }
}

#[test]
fn entity_errors_come_and_go() {
    let mut bench = Bench::new();
    for condition in [ERROR, BOOT] {
        bench.entities(&[("gps", condition)]);
        assert_eq!((bench.mode(), bench.phase()), (Mode::Error, PlanPhase::Blocked));
        assert_eq!(bench.engine.vehicle_state(at(0.0)).errors, ["gps"]);
        bench.entities(&[]);
        assert_eq!((bench.mode(), bench.phase()), (Mode::Service, PlanPhase::Ready));
    }
}

#[test]
fn an_entity_error_ends_a_plan_unless_it_may_be_ignored() {
    let plain = StartOptions::default();
    let cases = [
        (goto(100.0, 0.0), plain, "gps", Mode::Error),
        (goto(100.0, 0.0), IGNORING, "gps", Mode::Maneuver),
        (goto(100.0, 0.0), IGNORING, "motor", Mode::Error),
        (teleoperation(), plain, "motor", Mode::Maneuver),
    ];
    for (maneuver, options, label, mode) in cases {
        let mut bench = begin(maneuver, options);
        bench.entities(&[(label, ERROR)]);
        assert_eq!(bench.mode(), mode, "{label}");
        if mode == Mode::Error {
            assert_eq!(bench.last_command(), Some(Command::Drift));
            assert_eq!(bench.outcome(), LastOutcome::Failure);
            assert_eq!(bench.replies().last().unwrap().2, format!("entity error: {label}"));
        }
    }
}

#[test]
fn a_plan_that_ends_amid_errors_leaves_the_vehicle_in_error() {
    let mut bench = begin(teleoperation(), StartOptions::default());
    bench.entities(&[("gps", ERROR)]);
    bench.input(Input::Event(Event::TeleoperationDone { from: 1 }));
    assert_eq!((bench.outcome(), bench.mode()), (LastOutcome::Success, Mode::Error));
}

#[test]
fn in_error_only_plans_that_ignore_it_start() {
    let cases =
        [("gps", StartOptions::default(), false), ("gps", IGNORING, true), ("motor", IGNORING, false)];
    for (label, options, starts) in cases {
        let mut bench = Bench::new();
        bench.entities(&[(label, ERROR)]);
        bench.told.clear();
        bench.start_with("plan", vec![goto(1.0, 0.0)], options);
        assert_eq!(bench.phase() == PlanPhase::Executing, starts, "{label}");
        if !starts {
            assert_eq!(bench.replies()[0].2, format!("vehicle is blocked: {label}"));
        }
    }
}

#[test]
fn an_abort_ends_everything_until_the_next_report() {
    let mut bench = begin(goto(100.0, 0.0), IGNORING);
    bench.told.clear();
    bench.input(Input::Abort { by: 0x4001 });
    assert_eq!(bench.last_command(), Some(Command::Drift));
    assert!(bench.told.contains(&Output::Aborted { by: 0x4001 }));
    assert_eq!(bench.replies(), [(1, false, "stopped by 0x4001".to_owned())]);
    assert_eq!((bench.mode(), bench.phase()), (Mode::Error, PlanPhase::Blocked));
    bench.start_with("plan", vec![goto(1.0, 0.0)], IGNORING);
    assert_eq!(bench.phase(), PlanPhase::Blocked);
    bench.entities(&[]);
    assert_eq!((bench.mode(), bench.phase()), (Mode::Service, PlanPhase::Ready));
    assert_eq!(bench.outcome(), LastOutcome::Failure);
}

#[test]
fn an_abort_with_nothing_running_still_switches_the_loops_off() {
    let mut bench = Bench::new();
    bench.input(Input::Abort { by: 1 });
    assert_eq!((bench.last_command(), bench.mode()), (Some(Command::Drift), Mode::Error));
}
