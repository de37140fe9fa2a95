//! Plans from a console to their end, in simulation, with the exchange that consoles know from DUNE's tasks
//! `Plan.Engine` and `Plan.DB`.

use crate::common::*;
use imc::messages::*;

fn names(sea: &Sea) -> Vec<&'static str> {
    let own = sea.said.iter().filter(|(_, packet)| packet.header.src == OTTER);
    own.filter_map(|(_, packet)| packet.message().map(Message::abbrev)).collect()
}

/// Whether `wanted` occur in this order, with anything between.
fn in_order(said: &[&str], wanted: &[&str]) -> bool {
    let mut left = wanted.iter();
    let mut next = left.next();
    for name in said {
        if next == Some(name) {
            next = left.next();
        }
    }
    next.is_none()
}

#[test]
fn sails_a_stored_plan_to_its_end_with_the_exchange_consoles_know() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    let uploads = sea.all::<PlanDB>();
    let kinds: Vec<PlanDBType> = uploads.iter().map(|(_, reply)| reply.r#type).collect();
    assert_eq!(kinds, [PlanDBType::InProgress, PlanDBType::Success]);
    let Some(information) = uploads[1].1.arg.of::<PlanDBInformation>() else { panic!("{uploads:?}") };
    assert_eq!(information.md5, imc::plan_digest::plan_md5(&triangle()).unwrap());
    sea.forget();

    let request = sea.ask(PlanControlOp::Start, "triangle", None);
    // All of this within the handling of the request, as DUNE has it within 3 ms.
    let expected = [
        "LogBookEntry",
        "PlanControlState",
        "PlanControl",
        "LoggingControl",
        "PlanSpecification",
        "VehicleCommand",
        "VehicleCommand",
        "ControlLoops",
        "ControlLoops",
        "DesiredPath",
        "DesiredZ",
        "DesiredSpeed",
        "PathControlState",
        "VehicleState",
        "PlanControlState",
        "PlanControl",
    ];
    assert!(in_order(&names(&sea), &expected), "{:?}", names(&sea));
    let states: Vec<_> = sea.all::<PlanControlState>().into_iter().map(|(_, state)| state).collect();
    assert_eq!(states[0].state, PlanControlStateState::Initializing);
    let now = states.last().unwrap();
    assert_eq!(
        (now.state, &now.man_id, now.man_type),
        (PlanControlStateState::Executing, &"wp1".into(), 450)
    );
    let replies = sea.replies(request);
    assert!(replies[0].arg.of::<PlanStatistics>().is_some());
    assert_eq!(replies[0].info, "plan loaded");
    assert_eq!(replies[1].info, "wp1: executing maneuver");

    assert!(sea.run_until(300.0, |sea| sea.replies(request).len() == 3), "{:?}", sea.plan_state());
    assert_eq!(sea.replies(request)[2].info, "plan completed");
    assert!(sea.replies(request).iter().all(|reply| reply.r#type == PlanControlType::Success));
    let state = sea.plan_state();
    assert_eq!(state.state, PlanControlStateState::Ready);
    assert_eq!(state.last_outcome, PlanControlStateLastOutcome::Success);
    let logs: Vec<_> = sea.all::<LoggingControl>().into_iter().map(|(_, log)| log.name.to_string()).collect();
    assert_eq!(logs, ["triangle", ""]);
    // It went by all three waypoints, within the distance at which one counts as reached.
    let visited: std::collections::BTreeSet<String> =
        sea.all::<PlanControlState>().into_iter().map(|(_, state)| state.man_id.to_string()).collect();
    assert!(["wp1", "wp2", "wp3"].iter().all(|id| visited.contains(*id)));
    assert!(sea.position().distance_m(units::LocalPoint { north_m: 50.0, east_m: 0.0 }) < 12.0);
    sea.run(2.0);
    assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED);
}

#[test]
fn reports_at_the_rates_consoles_expect() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(2.0);
    sea.forget();
    sea.run(20.0);
    let rate = |count: usize| count as f64 / 20.0;
    for (name, rate, low, high) in [
        ("PlanControlState", rate(sea.all::<PlanControlState>().len()), 2.4, 3.1),
        ("VehicleState", rate(sea.all::<VehicleState>().len()), 1.9, 2.9),
        ("EstimatedState", rate(sea.all::<EstimatedState>().len()), 4.8, 10.0),
        ("PathControlState", rate(sea.all::<PathControlState>().len()), 0.8, 1.3),
        ("Heartbeat", rate(sea.all::<Heartbeat>().len()), 0.9, 1.1),
        ("ManeuverControlState", rate(sea.all::<ManeuverControlState>().len()), 0.9, 1.1),
        ("EntityState", rate(sea.all::<EntityState>().len()), 36.0, 39.0),
    ] {
        assert!((low..=high).contains(&rate), "{name}: {rate}");
    }
}

#[test]
fn stops_with_success_and_the_outcome_of_a_failure() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(10.0);
    let stop = sea.ask(PlanControlOp::Stop, "", None);
    assert_eq!(sea.replies(stop)[0].r#type, PlanControlType::Success);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Ready);
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Failure);
    sea.run(0.2);
    assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED);
    let again = sea.ask(PlanControlOp::Stop, "", None);
    assert_eq!(sea.replies(again)[0].info, "no plan is running, request ignored");
}

#[test]
fn an_abort_stops_at_once_and_must_be_addressed() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    let start = sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(10.0);
    sea.send_as(CONSOLE, imc::Address::NULL, Abort);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    sea.send(Abort);
    assert_eq!(sea.mode(), VehicleStateOpMode::Error);
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Failure);
    assert_eq!(sea.replies(start).last().unwrap().r#type, PlanControlType::Failure);
    assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED);
    assert!(sea.run_until(5.0, |sea| sea.mode() == VehicleStateOpMode::Service));
}

#[test]
fn to_all_vessels_only_what_stops_is_said() {
    use imc::Address;
    let started = |sea: &Sea| sea.plan_state().state == PlanControlStateState::Executing;
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    let start = |op| PlanControl { op, plan_id: "triangle".into(), ..PlanControl::default() };
    sea.send_as(CONSOLE, Address::BROADCAST, start(PlanControlOp::Start));
    let changed = PlanDB { op: PlanDBOp::Del, plan_id: "triangle".into(), ..PlanDB::default() };
    sea.send_as(CONSOLE, Address::BROADCAST, changed);
    sea.run(1.0);
    assert!(!started(&sea), "a start must name its vessel");
    for stop in [Message::from(Abort), start(PlanControlOp::Stop).into()] {
        sea.run(2.0);
        sea.ask(PlanControlOp::Start, "triangle", None);
        sea.run(3.0);
        assert!(started(&sea), "the plan is still there");
        sea.send_as(CONSOLE, Address::BROADCAST, stop);
        assert!(!started(&sea));
        sea.run(0.5);
        assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED);
    }
}

#[test]
fn the_state_of_a_full_database_fits_a_packet() {
    let mut sea = Sea::new().ready();
    sea.send(Announce { sys_name: "ø".repeat(100).as_str().into(), ..Announce::default() });
    let mut kept = 0;
    for n in 0..500 {
        sea.forget();
        sea.upload(&plan(&format!("{n:060}"), vec![("a".into(), goto(10.0, 0.0, 1.0).into())]));
        kept += usize::from(sea.last::<PlanDB>().unwrap().r#type == PlanDBType::Success);
    }
    assert_eq!(kept, 400);
    sea.forget();
    sea.send(PlanDB { op: PlanDBOp::GetState, request_id: 7, ..PlanDB::default() });
    let reply = sea.last::<PlanDB>().unwrap();
    assert_eq!((reply.r#type, reply.request_id), (PlanDBType::Success, 7));
    let state: PlanDBState = reply.arg.of().unwrap();
    assert_eq!((state.plan_count, state.plans_info.of::<PlanDBInformation>().count()), (400, 400));
}

#[test]
fn an_abort_holds_the_error_for_a_second_whenever_it_comes() {
    for after in [10.0, 10.2, 10.5, 10.8] {
        let mut sea = Sea::new().ready();
        sea.upload(&triangle());
        sea.ask(PlanControlOp::Start, "triangle", None);
        sea.run(after);
        sea.send(Abort);
        sea.run(0.9);
        assert_eq!(sea.mode(), VehicleStateOpMode::Error, "{after}");
        let early = sea.ask(PlanControlOp::Start, "triangle", None);
        assert_eq!(sea.replies(early)[0].r#type, PlanControlType::Failure, "{after}");
        assert!(sea.run_until(0.4, |sea| sea.mode() == VehicleStateOpMode::Service), "{after}");
    }
}

#[test]
fn an_unknown_plan_fails_and_another_replaces_the_running_one() {
    let mut sea = Sea::new().ready();
    let unknown = sea.ask(PlanControlOp::Start, "nowhere", None);
    let reply = &sea.replies(unknown)[0];
    assert_eq!((reply.r#type, &reply.info), (PlanControlType::Failure, &"undefined plan".into()));

    sea.upload(&triangle());
    sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(5.0);
    let other = plan("other", vec![("a".into(), goto(-60.0, 0.0, 1.5).into())]);
    let request = sea.ask(PlanControlOp::Start, "other", Some(other.into()));
    assert_eq!(sea.plan_state().plan_id, "other");
    assert_eq!(sea.replies(request).len(), 2);
    // A plan that comes with its start is stored, and all systems are informed.
    let kept = sea.all::<PlanDB>().into_iter().any(|(_, told)| {
        told.plan_id == "other" && told.op == PlanDBOp::Set && told.r#type == PlanDBType::Success
    });
    assert!(kept);
    assert!(sea.run_until(120.0, |sea| sea.replies(request).len() == 3));
}

#[test]
fn plans_that_are_not_possible_fail_and_leave_the_running_one_alone() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(3.0);
    let mut nowhere = triangle();
    nowhere.start_man_id = "wp9".into();
    let mut hollow = triangle();
    hollow.maneuvers = MessageListOf::none();
    let nan = plan("nan", vec![("a".into(), Goto { lat: f64::NAN, ..goto(0.0, 0.0, 1.0) }.into())]);
    let backwards = plan("fast", vec![("a".into(), goto(50.0, 0.0, -3.0).into())]);
    let strange = plan("strange", vec![("a".into(), Heartbeat.into())]);
    for bad in [nowhere, hollow, nan, backwards, strange] {
        let id = format!("bad-{}", bad.plan_id);
        let bad = PlanSpecification { plan_id: id.as_str().into(), ..bad };
        let request = sea.ask(PlanControlOp::Start, &id, Some(bad.into()));
        let reply = &sea.replies(request)[0];
        assert_eq!(reply.r#type, PlanControlType::Failure, "{id}");
        assert!(reply.info.to_str_lossy().starts_with("parse error: "), "{id}: {}", reply.info);
        assert_eq!(sea.plan_state().plan_id, "triangle");
    }
    let wrong = sea.ask(PlanControlOp::Start, "wrong", Some(Abort.into()));
    assert_eq!(sea.replies(wrong)[0].r#type, PlanControlType::Failure);
    sea.run(1.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

#[test]
fn takes_a_plan_of_600_waypoints() {
    let mut sea = Sea::new().ready();
    let points = (0..600).map(|n| {
        let (row, column) = (n / 20, n % 20);
        let east_m = if row % 2 == 0 { column } else { 19 - column };
        (format!("{n}"), goto(f64::from(row) * 15.0, f64::from(east_m) * 15.0, 2.0).into())
    });
    let long = plan("long", points.collect());
    sea.upload(&long);
    assert_eq!(sea.last::<PlanDB>().unwrap().r#type, PlanDBType::Success);
    let request = sea.ask(PlanControlOp::Start, "long", None);
    assert_eq!(sea.replies(request).len(), 2, "{:?}", sea.replies(request));
    sea.run(300.0);
    let at: u32 = sea.plan_state().man_id.to_string().parse().unwrap();
    assert!(at > 20, "{at}");
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

fn lookahead(sea: &mut Sea) -> String {
    let name = "Path Control";
    sea.send(QueryEntityParameters { name: name.into(), visibility: "user".into(), scope: "global".into() });
    let told = sea.last::<EntityParameters>().unwrap();
    let mut all = told.params.of::<EntityParameter>();
    all.find(|parameter| parameter.name == "ILOS Lookahead Distance").unwrap().value.to_string()
}

fn book(sea: &Sea) -> String {
    let entries = sea.all::<LogBookEntry>();
    entries.iter().map(|(_, entry)| entry.text.to_string()).collect::<Vec<_>>().join("\n")
}

fn set(name: &str, parameter: &str, value: &str) -> Message {
    let params = [EntityParameter { name: parameter.into(), value: value.into() }].into_iter().collect();
    SetEntityParameters { name: name.into(), params }.into()
}

#[test]
fn a_maneuver_has_parameters_of_its_own_and_gives_the_others_back() {
    let mut sea = Sea::new().ready();
    let before = lookahead(&mut sea);
    let wait = IdleManeuver { duration: 10, ..IdleManeuver::default() };
    let mut keeper = plan("keeper", vec![("a".into(), wait.clone().into()), ("b".into(), wait.into())]);
    let node = |id: &str, start: Vec<Message>, end: Vec<Message>| PlanManeuver {
        maneuver_id: id.into(),
        data: IdleManeuver { duration: 10, ..IdleManeuver::default() }.into(),
        start_actions: start.into_iter().collect(),
        end_actions: end.into_iter().collect(),
    };
    let name = || "Path Control".into();
    keeper.maneuvers = [
        node(
            "a",
            vec![
                PushEntityParameters { name: name() }.into(),
                set("Path Control", "ILOS Lookahead Distance", "13"),
            ],
            vec![PopEntityParameters { name: name() }.into()],
        ),
        node("b", Vec::new(), vec![PopEntityParameters { name: name() }.into()]),
    ]
    .into_iter()
    .collect();
    sea.ask(PlanControlOp::Start, "keeper", Some(keeper.clone().into()));
    sea.run(5.0);
    assert_eq!(lookahead(&mut sea), "13");
    sea.run(10.0);
    assert_eq!(sea.plan_state().man_id, "b");
    assert_eq!(lookahead(&mut sea), before);
    assert!(sea.run_until(10.0, |sea| sea.plan_state().last_outcome == PlanControlStateLastOutcome::Success));
    assert!(book(&sea).contains("the stack of parameters is empty: nothing to restore"), "{}", book(&sea));
    // Also where the maneuver does not come to its end.
    sea.ask(PlanControlOp::Start, "keeper", Some(keeper.into()));
    sea.run(5.0);
    assert_eq!(lookahead(&mut sea), "13");
    sea.send(Abort);
    sea.run(1.0);
    assert_eq!(lookahead(&mut sea), before);
}

#[test]
fn parameters_are_kept_and_given_back_for_a_console_but_not_without_end() {
    let mut sea = Sea::new().ready();
    let before = lookahead(&mut sea);
    for _ in 0..20 {
        sea.send(PushEntityParameters { name: "Path Control".into() });
    }
    assert!(book(&sea).contains("parameters are not kept"), "{}", book(&sea));
    sea.send(set("Path Control", "ILOS Lookahead Distance", "13"));
    assert_eq!(lookahead(&mut sea), "13");
    sea.send(PopEntityParameters { name: "Path Control".into() });
    assert_eq!(lookahead(&mut sea), before);
}

#[test]
fn what_a_plan_asks_for_in_vain_is_told_before_it_is_sailed() {
    let mut sea = Sea::new().ready();
    let mut odd = triangle();
    odd.start_actions = [set("Sidescan", "Active", "true")].into_iter().collect();
    let loaded = sea.ask(PlanControlOp::Load, "triangle", Some(odd.clone().into()));
    assert_eq!(sea.replies(loaded)[0].r#type, PlanControlType::Success);
    assert!(book(&sea).contains("there is no part 'Sidescan' aboard"), "{}", book(&sea));
    odd.end_actions = [Message::from(PowerChannelControl::default())].into_iter().collect();
    for op in [PlanControlOp::Load, PlanControlOp::Start] {
        let refused = sea.ask(op, "triangle", Some(odd.clone().into()));
        let reply = &sea.replies(refused)[0];
        assert_eq!(reply.r#type, PlanControlType::Failure);
        let info = reply.info.to_str_lossy().into_owned();
        assert!(info.contains("end action: PowerChannelControl is not carried out aboard"), "{info}");
    }
    assert_eq!(sea.mode(), VehicleStateOpMode::Service);
}

#[test]
fn keeps_station_quietly() {
    let mut sea = Sea::new().ready();
    let here = place(40.0, 0.0);
    let station = StationKeeping {
        lat: here.lat_rad(),
        lon: here.lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        speed: 1.0,
        ..StationKeeping::default()
    };
    sea.ask(PlanControlOp::Start, "station", Some(station.into()));
    assert!(sea.run_until(120.0, |sea| sea.position().north_m > 31.0));
    sea.run(30.0);
    sea.forget();
    sea.run(600.0);
    let running = sea.motors.iter().filter(|(_, motors)| *motors != control::MotorPair::STOPPED).count();
    assert!(running * 4 <= sea.motors.len(), "{running} of {}", sea.motors.len());
    assert!(sea.position().distance_m(units::LocalPoint { north_m: 40.0, east_m: 0.0 }) <= 11.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
}

struct MessageListOf;

impl MessageListOf {
    fn none() -> imc::MessageList {
        imc::MessageList::default()
    }
}

#[test]
fn a_start_with_a_broken_plan_leaves_the_stored_one_as_it_is() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    let broken = PlanSpecification { start_man_id: "nowhere".into(), ..triangle() };
    let request = sea.ask(PlanControlOp::Start, "triangle", Some(broken.into()));
    assert!(sea.replies(request).iter().any(|reply| reply.r#type == PlanControlType::Failure));
    sea.ask(PlanControlOp::Start, "triangle", None);
    sea.run(2.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing, "the stored one is whole");
    // One that is good takes its place.
    let other = PlanSpecification { description: "another".into(), ..triangle() };
    sea.ask(PlanControlOp::Start, "triangle", Some(other.clone().into()));
    let get = PlanDB { op: PlanDBOp::Get, plan_id: "triangle".into(), ..PlanDB::default() };
    sea.send(get);
    let stored = sea.last::<PlanDB>().unwrap().arg.of::<PlanSpecification>();
    assert_eq!(stored, Some(other));
}
