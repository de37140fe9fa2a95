//! Every remedy in every state, outside the area, without a chart, without a position and with all of that: the vessel
//! ends in a state that has a name, and never drifts unless that is what was asked.

use crate::common::*;
use control::MotorPair;
use guard::Area;
use imc::messages::*;
use mission::{LostCommsConfig, Remedy, Step};
use onboard::{Chart, Entity, Settings};
use std::time::Duration;

/// The trouble.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trouble {
    outside: bool,
    no_chart: bool,
    no_position: bool,
}

/// The vessel's activity when communications are lost.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Doing {
    Plan,
    Teleoperation,
    OwnHold,
    Adrift,
    AtRest,
}

/// How it ends.
#[derive(Debug, PartialEq)]
enum End {
    Holds,
    Returns,
    /// Motors off, as was asked.
    Stopped,
    /// Motors off, as it was never set in motion.
    AtRest,
    /// Motors off until there is a position, and it says so.
    WaitsForPosition,
}

const AFTER_S: f64 = 9.0;

fn home() -> Remedy {
    Remedy::Run { plan_id: "home".to_owned() }
}

fn settings_for(remedy: &Remedy, trouble: Trouble) -> Settings {
    let mut settings = settings();
    let ladder = vec![Step { after: Duration::from_secs_f64(AFTER_S), remedy: remedy.clone() }];
    settings.watch.lost_comms = LostCommsConfig {
        idle: ladder.clone(),
        plan: ladder.clone(),
        teleoperation: ladder,
        ..LostCommsConfig::default()
    };
    // The area begins 60 m north of the vessel, or lies around it.
    let south_m = if trouble.outside { 60.0 } else { -2000.0 };
    let corners = [(south_m, -1500.0), (4000.0, -1500.0), (4000.0, 1500.0), (south_m, 1500.0)];
    let area = Area::new(&corners.map(|(n, e)| place(n, e))).unwrap();
    settings.mission.limits.area = Some(area.clone());
    settings.watch.limits.area = Some(area);
    settings.watch.limits.area_remedy = None;
    settings
}

/// A vessel in a slow current that does something; its console is heard for the last time now.
fn doing(settings: &Settings, doing: Doing) -> Sea {
    let mut sea = Sea::with(settings.clone(), |vessel| {
        vessel.environment.current.speed_mps = 0.2;
        vessel.environment.current.to_rad = -std::f64::consts::FRAC_PI_2;
    })
    .ready();
    sea.override_preflight("the chart may be damaged");
    sea.upload(&plan("home", vec![("a".into(), goto(900.0, 0.0, 1.5).into())]));
    let steer = Message::from(Teleoperation { custom: "src=16385".into() });
    let far = plan("far", vec![("a".into(), goto(2500.0, 0.0, 1.0).into())]);
    match doing {
        Doing::Plan => sea.ask(PlanControlOp::Start, "far", Some(far.into())),
        Doing::Teleoperation | Doing::OwnHold | Doing::Adrift => {
            sea.ask(PlanControlOp::Start, "steer", Some(steer))
        }
        Doing::AtRest => 0,
    };
    sea.run(3.0);
    match doing {
        Doing::OwnHold => {
            // Communications were lost before, too.
            sea.heartbeats = false;
            sea.run(AFTER_S + 5.0);
            sea.heartbeats = true;
            sea.run(2.0);
        }
        Doing::Adrift => {
            sea.ask(PlanControlOp::Stop, "", None);
            sea.run(2.0);
        }
        Doing::Plan | Doing::Teleoperation | Doing::AtRest => {}
    }
    sea.heartbeats = false;
    sea
}

fn state(sea: &Sea, entity: Entity) -> (EntityStateState, String) {
    let mut own = sea
        .said
        .iter()
        .rev()
        .filter(|(_, packet)| packet.header.src == OTTER && packet.header.src_ent == entity.number());
    let state = own.find_map(|(_, packet)| packet.get::<EntityState>()).unwrap();
    (state.state, state.description.to_string())
}

fn stopped(sea: &Sea) -> bool {
    sea.motors.last().is_none_or(|(_, motors)| *motors == MotorPair::STOPPED)
}

/// The name of what the vessel does; a vessel that drifts without saying why has none.
fn end_of(sea: &Sea, case: &str) -> End {
    let plan = sea.plan_state();
    let executes = plan.state == PlanControlStateState::Executing;
    let (condition, text) = state(sea, Entity::LostComms);
    if text.contains("waits for a position with the motors stopped") {
        assert!(stopped(sea) && condition != EntityStateState::Normal, "{case}");
        return End::WaitsForPosition;
    }
    match &*plan.plan_id.to_string() {
        "hold" if executes => return End::Holds,
        "home" if executes => return End::Returns,
        _ => {}
    }
    assert!(stopped(sea), "{case}: {plan:?}");
    if text.contains("stop: in force") {
        return End::Stopped;
    }
    if text.contains("not before an operator has set the vessel in motion")
        || text.contains("no console was ever heard")
    {
        return End::AtRest;
    }
    let blocked = text.split_once("vehicle is blocked: ").map(|(_, parts)| parts);
    let of_position = |parts: &str| ["GPS", "Navigation", "GNSS"].iter().any(|part| parts.contains(part));
    let waits = text.contains("the position is not known") || blocked.is_some_and(of_position);
    assert!(
        waits && condition != EntityStateState::Normal,
        "{case}: adrift without a word: {text}, {plan:?}"
    );
    End::WaitsForPosition
}

fn expected(remedy: &Remedy, trouble: Trouble, doing: Doing, killed: bool) -> End {
    match remedy {
        // To stop a vessel at rest needs no action.
        Remedy::Stop if !killed => End::Stopped,
        _ if doing == Doing::AtRest => End::AtRest,
        // A vessel that was stopped may lie on a trailer by now: it acts once a console was heard.
        _ if killed && doing == Doing::Adrift => End::AtRest,
        Remedy::Stop if doing == Doing::OwnHold => End::AtRest,
        Remedy::Stop => End::Stopped,
        _ if trouble.no_position => End::WaitsForPosition,
        Remedy::Run { .. } if !trouble.no_chart => End::Returns,
        Remedy::Run { .. } | Remedy::Hold => End::Holds,
    }
}

fn troubles() -> impl Iterator<Item = Trouble> {
    (0..8_u8).map(|n| Trouble { outside: n & 1 > 0, no_chart: n & 2 > 0, no_position: n & 4 > 0 })
}

/// Without its chart from now on: what it had cannot be read at the next start.
fn unreadable(settings: &mut Settings) {
    settings.grounding.chart = Chart::Unreadable { reason: "damaged".to_owned() };
}

/// Runs a case to its end; `killed` also kills the program at the moment at which communications are lost.
fn check(remedy: &Remedy, trouble: Trouble, what: Doing, killed: bool) {
    let case = format!("{remedy}, {trouble:?}, {what:?}, killed: {killed}");
    let mut settings = settings_for(remedy, trouble);
    // A plan is refused without a chart that was configured: it must have begun before.
    if trouble.no_chart && what != Doing::Plan {
        unreadable(&mut settings);
    }
    let mut sea = doing(&settings, what);
    sea.run(5.0);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = trouble.no_position;
    if killed {
        if trouble.no_chart {
            unreadable(&mut settings);
        }
        sea.kill(settings, 4.0);
    }
    sea.run(AFTER_S + 12.0);
    let mut wanted = expected(remedy, trouble, what, killed);
    if what == Doing::Plan && trouble.no_chart && !killed && wanted == End::Holds && *remedy == home() {
        // The chart was there when the plan began.
        wanted = End::Returns;
    }
    if killed && trouble.no_position && what != Doing::AtRest {
        // How long ago that was is unknown until the GNSS receiver gives the time.
        assert!(sea.motors.iter().all(|(_, motors)| *motors == MotorPair::STOPPED), "{case}");
        let told = sea.all::<LogBookEntry>();
        let told = told
            .iter()
            .any(|(_, entry)| entry.text.to_str_lossy().contains("it waits for the time of the satellites"));
        assert!(told, "{case}: says nothing");
    } else {
        assert_eq!(end_of(&sea, &case), wanted, "{case}: {:?}", state(&sea, Entity::LostComms));
    }
    // With positions again it does what was asked.
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    sea.run(20.0);
    let known = Trouble { no_position: false, ..trouble };
    let mut wanted = expected(remedy, known, what, killed);
    if what == Doing::Plan && trouble.no_chart && !killed && wanted == End::Holds && *remedy == home() {
        wanted = End::Returns;
    }
    assert_eq!(
        end_of(&sea, &case),
        wanted,
        "{case}, with positions again: {:?}",
        state(&sea, Entity::LostComms)
    );
}

fn check_all(killed: bool) {
    let states = [Doing::Plan, Doing::Teleoperation, Doing::OwnHold, Doing::Adrift, Doing::AtRest];
    for remedy in [Remedy::Hold, home(), Remedy::Stop] {
        for trouble in troubles() {
            for state in states {
                check(&remedy, trouble, state, killed);
            }
        }
    }
}

#[test]
fn every_remedy_ends_in_a_named_state() {
    check_all(false);
}

#[test]
fn after_a_kill_in_every_state_too() {
    check_all(true);
}
