//! Operators and commanders: teleoperation, references, parameters, and their silence.

use crate::common::*;
use control::MotorPair;
use imc::Address;
use imc::messages::*;
use mission::{LimitsConfig, LostCommsConfig, Remedy, Step};
use std::time::Duration;

const OTHER: Address = Address(0x4002);

fn keys(text: &str) -> RemoteActions {
    RemoteActions { actions: text.into() }
}

fn teleoperated() -> Sea {
    let mut sea = Sea::new().ready();
    let maneuver = Teleoperation { custom: "src=16385".into() };
    let request = sea.ask(PlanControlOp::Start, "teleoperation-mode", Some(maneuver.into()));
    assert_eq!(sea.replies(request).len(), 2);
    assert_eq!(sea.last::<VehicleState>().unwrap().maneuver_type, 452);
    assert_eq!(sea.last::<VehicleState>().unwrap().control_loops, CLoopsMask::TELEOPERATION);
    sea
}

fn drive(sea: &mut Sea, from: Address, text: &str, messages: u32) {
    for _ in 0..messages {
        sea.send_as(from, OTTER, keys(text));
        sea.run(0.1);
    }
}

#[test]
fn an_operator_steers_and_the_motors_stop_two_seconds_after_the_last_key() {
    let mut sea = teleoperated();
    sea.send(RemoteActionsRequest { op: RemoteActionsRequestOp::Query, ..Default::default() });
    assert!(sea.last::<RemoteActionsRequest>().unwrap().actions.to_str_lossy().contains("Heading=Axis"));
    drive(&mut sea, CONSOLE, "Accelerate=1", 12);
    let motors = sea.motors.last().unwrap().1;
    assert!((motors.port - 0.6).abs() < 0.06, "{motors:?}");
    let last_key = sea.vehicle.now.mono;
    assert!(sea.run_until(3.0, |sea| sea.motors.last().unwrap().1 == MotorPair::STOPPED));
    let silence_s = sea.vehicle.now.mono.since(last_key).as_secs_f64();
    assert!((1.8..=2.1).contains(&silence_s), "{silence_s}");
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing, "the plan goes on");
    drive(&mut sea, CONSOLE, "Port Motor=127;Starboard Motor=64", 2);
    let motors = sea.motors.last().unwrap().1;
    assert!((motors.port - 1.0).abs() < 1e-6 && (motors.starboard - 64.0 / 127.0).abs() < 1e-6);
    sea.send(keys("Exit=1"));
    assert!(sea.run_until(2.0, |sea| sea.plan_state().state == PlanControlStateState::Ready));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
    assert_eq!(sea.motors.last().unwrap().1, MotorPair::STOPPED);
}

#[test]
fn keys_that_say_how_long_they_are_good_for_stop_the_motors_then() {
    let mut sea = teleoperated();
    drive(&mut sea, CONSOLE, "Port Motor=127;Starboard Motor=127;Life=450", 12);
    assert!(sea.motors.last().unwrap().1.port > 0.9);
    // The last key is 0.1 s old here.
    let since = sea.vehicle.now.mono;
    assert!(sea.run_until(3.0, |sea| sea.motors.last().unwrap().1 == MotorPair::STOPPED));
    let silence_s = 0.1 + sea.vehicle.now.mono.since(since).as_secs_f64();
    assert!((0.4..=0.5).contains(&silence_s), "{silence_s}");
    // A life that is over when it comes moves nothing.
    drive(&mut sea, CONSOLE, "Port Motor=127;Life=0", 3);
    assert_eq!(sea.motors.last().unwrap().1, MotorPair::STOPPED);
}

#[test]
fn nobody_else_steers_nor_keeps_the_watchdog_quiet() {
    let mut sea = teleoperated();
    drive(&mut sea, OTHER, "Port Motor=127", 5);
    assert!(sea.motors.iter().all(|(_, motors)| *motors == MotorPair::STOPPED));
    drive(&mut sea, CONSOLE, "Port Motor=127", 3);
    drive(&mut sea, OTHER, "Port Motor=127", 25);
    assert_eq!(sea.motors.last().unwrap().1, MotorPair::STOPPED);
}

#[test]
fn follows_references_until_their_source_falls_silent() {
    let mut sea = Sea::new().ready();
    let maneuver = FollowReference {
        control_src: CONSOLE.0,
        control_ent: 0xFF,
        timeout: 10.0,
        ..FollowReference::default()
    };
    let request = sea.ask(PlanControlOp::Start, "follow", Some(maneuver.into()));
    sea.run(1.0);
    assert_eq!(sea.last::<FollowRefState>().unwrap().state, FollowRefStateState::Wait);
    let goal = place(80.0, 0.0);
    let reference = Reference {
        flags: ReferenceFlags::LOCATION | ReferenceFlags::SPEED,
        speed: DesiredSpeed { value: 1.5, speed_units: SpeedUnits::MetersPs }.into(),
        lat: goal.lat_rad(),
        lon: goal.lon_rad(),
        ..Reference::default()
    };
    for _ in 0..20 {
        sea.send(reference.clone());
        sea.run(1.0);
    }
    assert_eq!(sea.last::<FollowRefState>().unwrap().state, FollowRefStateState::Goto);
    assert!(sea.position().north_m > 15.0);
    let last = sea.vehicle.now.mono;
    assert!(sea.run_until(15.0, |sea| sea.plan_state().state == PlanControlStateState::Ready));
    let silence_s = sea.vehicle.now.mono.since(last).as_secs_f64();
    assert!((8.5..=11.5).contains(&silence_s), "{silence_s}");
    let reply = sea.replies(request).pop().unwrap();
    assert_eq!(reply.r#type, PlanControlType::Failure);
    assert!(reply.info.to_str_lossy().contains("reference source timed out"), "{}", reply.info);
}

#[test]
fn a_commander_without_a_time_limit_has_one() {
    let mut sea = Sea::new().ready();
    sea.ask(
        PlanControlOp::Start,
        "follow",
        Some(FollowReference { timeout: 0.0, ..Default::default() }.into()),
    );
    sea.run(20.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Executing);
    assert!(sea.run_until(15.0, |sea| sea.plan_state().state == PlanControlStateState::Ready));
}

#[test]
fn parameters_are_told_changed_refused_and_saved() {
    let mut sea = Sea::new().ready();
    let query = |name: &str, scope: &str| QueryEntityParameters {
        name: name.into(),
        visibility: "user".into(),
        scope: scope.into(),
    };
    sea.send(query("Path Control", "global"));
    let told = sea.last::<EntityParameters>().unwrap();
    let lookahead =
        told.params.of::<EntityParameter>().find(|p| p.name == "ILOS Lookahead Distance").unwrap();
    assert!(lookahead.value.to_str_lossy().parse::<f64>().is_ok());
    let count = sea.all::<EntityParameters>().len();
    sea.send(query("Path Control", "anything"));
    sea.send(query("Nobody", "global"));
    assert_eq!(sea.all::<EntityParameters>().len(), count, "unknown words are not answered");
    sea.send(query("Path Control", "maneuver"));
    assert!(sea.last::<EntityParameters>().unwrap().params.is_empty(), "none holds for a maneuver only");
    let set = |name: &str, value: &str| SetEntityParameters {
        name: "Path Control".into(),
        params: [EntityParameter { name: name.into(), value: value.into() }].into_iter().collect(),
    };
    sea.send(set("ILOS Lookahead Distance", "12"));
    let taken = sea.last::<EntityParameters>().unwrap();
    assert_eq!(taken.params.of::<EntityParameter>().next().unwrap().value, "12");
    let count = sea.all::<EntityParameters>().len();
    for (name, value) in
        [("ILOS Lookahead Distance", "1200"), ("ILOS Lookahead Distance", "x"), ("Nothing", "1")]
    {
        sea.send(set(name, value));
    }
    assert_eq!(sea.all::<EntityParameters>().len(), count, "what is refused is not echoed");
    sea.send(SaveEntityParameters { name: "Path Control".into() });
    let kept = sea.outputs.iter().any(|(_, output)| {
        matches!(output, onboard::Output::Keep(onboard::Keep::Parameters(label, values))
            if label == "Path Control" && values.iter().any(|(name, value)| name == "ILOS Lookahead Distance" && value == "12"))
    });
    assert!(kept);
}

#[test]
fn a_developer_is_told_what_the_next_start_will_have() {
    const LOOKAHEAD: &str = "ILOS Lookahead Distance";
    let mut sea = Sea::new().ready();
    sea.vehicle.virtual_disk = false;
    let told = |sea: &mut Sea| {
        sea.send(QueryEntityParameters {
            name: "Path Control".into(),
            visibility: "developer".into(),
            scope: "global".into(),
        });
        let told = sea.last::<EntityParameters>().unwrap();
        let value = |name: &str| told.params.of::<EntityParameter>().find(|one| one.name == name).unwrap();
        (value(LOOKAHEAD).value.to_string(), value(&format!("{LOOKAHEAD} - Saved")).value.to_string())
    };
    let (first, saved) = told(&mut sea);
    assert_eq!(first, saved, "at the start all is as the files say");
    let parameter = EntityParameter { name: LOOKAHEAD.into(), value: "12".into() };
    sea.send(SetEntityParameters { name: "Path Control".into(), params: [parameter].into_iter().collect() });
    assert_eq!(told(&mut sea), ("12".to_owned(), first.clone()));
    sea.send(SaveEntityParameters { name: "Path Control".into() });
    assert_eq!(told(&mut sea), ("12".to_owned(), first.clone()), "not before it is on the disk");
    sea.tell(onboard::Input::ParametersKept("Path Control".to_owned(), Err("disk full".to_owned())));
    assert_eq!(told(&mut sea), ("12".to_owned(), first));
    sea.send(SaveEntityParameters { name: "Path Control".into() });
    sea.tell(onboard::Input::ParametersKept("Path Control".to_owned(), Ok(())));
    assert_eq!(told(&mut sea), ("12".to_owned(), "12".to_owned()));
    let entries: Vec<String> =
        sea.all::<LogBookEntry>().iter().map(|(_, one)| one.text.to_string()).collect();
    assert!(entries.iter().any(|text| text == "parameters are not saved: disk full"), "{entries:?}");
    assert!(entries.iter().any(|text| text == "parameters are saved"), "{entries:?}");
}

fn losing(plan_ladder: Vec<Step>) -> Sea {
    let mut settings = settings();
    settings.watch.lost_comms = LostCommsConfig { plan: plan_ladder, ..LostCommsConfig::default() };
    Sea::with(settings, |_| {}).ready()
}

#[test]
fn lost_communications_act_during_a_plan() {
    let home = Remedy::Run { plan_id: "lost_comms".to_owned() };
    let mut sea = losing(vec![
        Step { after: Duration::from_secs(20), remedy: Remedy::Hold },
        Step { after: Duration::from_mins(1), remedy: home },
    ]);
    sea.upload(&plan("lost_comms", vec![("home".into(), goto(0.0, -30.0, 1.5).into())]));
    let far = plan("far", vec![("a".into(), goto(2000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(10.0);
    let text = |sea: &Sea| {
        let mut all = sea
            .said
            .iter()
            .rev()
            .filter(|(_, packet)| packet.header.src_ent == onboard::Entity::LostComms.number());
        all.find_map(|(_, packet)| packet.get::<EntityState>()).unwrap().description.to_string()
    };
    assert!(text(&sea).starts_with("in contact; without: hold station at "), "{}", text(&sea));
    sea.heartbeats = false;
    sea.run(15.0);
    assert_eq!(sea.plan_state().plan_id, "far");
    sea.run(8.0);
    assert_eq!(sea.plan_state().plan_id, "hold");
    assert!(text(&sea).contains("next: run plan lost_comms at "), "{}", text(&sea));
    assert!(sea.run_until(45.0, |sea| sea.plan_state().plan_id == "lost_comms"));
    assert!(
        sea.run_until(200.0, |sea| sea.plan_state().last_outcome == PlanControlStateLastOutcome::Success)
    );
    sea.heartbeats = true;
    sea.run(2.0);
    assert!(text(&sea).starts_with("in contact"), "{}", text(&sea));
}

#[test]
fn a_plan_carries_on_without_consoles_when_so_configured() {
    let mut sea = losing(Vec::new());
    let far = plan("far", vec![("a".into(), goto(300.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.heartbeats = false;
    assert!(
        sea.run_until(400.0, |sea| sea.plan_state().last_outcome == PlanControlStateLastOutcome::Success)
    );
}

#[test]
fn teleoperation_without_its_console_stops_and_then_holds() {
    let mut sea = teleoperated();
    drive(&mut sea, CONSOLE, "Port Motor=100;Starboard Motor=100", 20);
    sea.heartbeats = false;
    sea.run(5.0);
    assert_eq!(sea.motors.last().unwrap().1, MotorPair::STOPPED);
    assert!(sea.run_until(40.0, |sea| sea.plan_state().plan_id == "hold"));
}

#[test]
fn an_empty_battery_makes_the_vessel_hold() {
    let mut sea = Sea::new().ready();
    let far = plan("far", vec![("a".into(), goto(2000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(10.0);
    sea.vehicle.hull.vessel.drain_to(8.0);
    assert!(sea.run_until(30.0, |sea| sea.plan_state().plan_id == "hold"), "{:?}", sea.plan_state());
}

#[test]
fn tells_what_it_consists_of_and_ignores_its_own_echo() {
    let mut sea = Sea::new().ready();
    sea.send(EntityList { op: EntityListOp::Query, ..EntityList::default() });
    let list = sea.last::<EntityList>().unwrap();
    assert!(list.list.to_str_lossy().contains("Vehicle Supervisor="));
    sea.upload(&triangle());
    sea.forget();
    let echo = PlanControl { op: PlanControlOp::Start, plan_id: "triangle".into(), ..PlanControl::default() };
    sea.send_as(OTTER, OTTER, echo.clone());
    sea.send_as(CONSOLE, Address::NULL, echo);
    assert_eq!(sea.mode(), VehicleStateOpMode::default());
    sea.run(1.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Ready, "neither echo nor a stray start counts");
}

#[test]
fn a_safety_limit_is_not_moved_from_the_bus_and_the_console_is_told_why() {
    let mut settings = settings();
    settings.watch.limits = LimitsConfig {
        max_speed_mps: Some(3.1),
        speed_remedy: Some(Remedy::Hold),
        ..LimitsConfig::default()
    };
    let mut sea = Sea::with(settings, |_| {}).ready();
    for (entity, name, value) in [
        ("Operational Limits", "Maximum Speed", "-1"),
        ("Operational Limits", "Action", "warn"),
        ("Fuel Monitor", "Reserve Level", "0"),
        ("Lost Communications", "Lost Comms Timeout", "86400"),
        ("Path Control", "ILOS Lookahead Distance", "0"),
    ] {
        sea.forget();
        let parameter = EntityParameter { name: name.into(), value: value.into() };
        let params = [parameter].into_iter().collect();
        sea.send(SetEntityParameters { name: entity.into(), params });
        let told = sea.said.iter().filter(|(_, packet)| packet.header.dst == CONSOLE);
        let told: Vec<_> = told.filter_map(|(_, packet)| packet.get::<LogBookEntry>()).collect();
        assert_eq!(told.len(), 1, "{name}");
        let text = told[0].text.to_string();
        assert!(text.contains(name) && text.contains("is refused: "), "{text}");
        assert!(text.contains("file only") || name.starts_with("ILOS"), "{text}");
        assert!(sea.all::<EntityParameters>().is_empty(), "nothing was taken: {name}");
    }
    sea.send(QueryEntityParameters {
        name: "Operational Limits".into(),
        visibility: "user".into(),
        scope: "global".into(),
    });
    let told = sea.last::<EntityParameters>().unwrap();
    assert_eq!(told.params.of::<EntityParameter>().next().unwrap().value, "3.1");
}
