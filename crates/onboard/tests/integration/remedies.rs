//! Supervisors' demands: tried until they hold, never replaced by weaker ones, settled when an operator steps in.

use crate::common::*;
use imc::messages::*;
use mission::{BatteryConfig, LimitsConfig, LostCommsConfig, Remedy, Step};
use onboard::{Entity, Settings};
use std::time::Duration;

fn home() -> Remedy {
    Remedy::Run { plan_id: "home".to_owned() }
}

/// Twenty seconds after the last heartbeat a vessel under way does this.
fn lost(remedy: Remedy) -> LostCommsConfig {
    let ladder = vec![Step { after: Duration::from_secs(20), remedy }];
    LostCommsConfig {
        idle: ladder.clone(),
        plan: ladder.clone(),
        teleoperation: ladder,
        ..LostCommsConfig::default()
    }
}

fn under_way(change: impl FnOnce(&mut Settings)) -> Sea {
    let mut settings = settings();
    settings.watch.lost_comms = LostCommsConfig { idle: vec![], plan: vec![], ..lost(Remedy::Hold) };
    change(&mut settings);
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.upload(&plan("home", vec![("a".into(), goto(-3000.0, 0.0, 1.5).into())]));
    let far = plan("far", vec![("a".into(), goto(3000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(10.0);
    assert_eq!(sea.plan_state().plan_id, "far");
    sea
}

fn runs(sea: &Sea, plan_id: &str) -> bool {
    let state = sea.plan_state();
    state.state == PlanControlStateState::Executing && state.plan_id == plan_id
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

fn says(sea: &Sea, entity: Entity, what: &str) -> bool {
    state(sea, entity).1.contains(what)
}

/// A part's reports in names and values, without those from before its vessel was ready.
fn values(sea: &Sea, entity: Entity) -> Vec<String> {
    let own = sea.said.iter().filter(|(_, packet)| packet.header.src_ent == entity.number());
    own.filter_map(|(_, packet)| packet.get::<Event>()).map(|event| event.data.to_string()).collect()
}

#[test]
fn a_remedy_that_a_gap_in_the_positions_prevents_is_carried_out_after_it() {
    let mut sea = under_way(|settings| settings.watch.lost_comms = lost(Remedy::Hold));
    sea.heartbeats = false;
    sea.run(15.0);
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    sea.run(15.0);
    assert!(!runs(&sea, "far") && !runs(&sea, "hold"), "{:?}", sea.plan_state());
    let text = state(&sea, Entity::LostComms).1;
    let coded = |sea: &Sea| values(sea, Entity::LostComms).pop().unwrap_or_default();
    assert!(coded(&sea).ends_with(";now=hold;stands=waits"), "{}", coded(&sea));
    assert!(text.contains("hold station: not possible (the position is not known); adrift with the motors stopped meanwhile; next try at "), "{text}");
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(10.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
    sea.run(2.0);
    assert!(says(&sea, Entity::LostComms, "hold station: in force"), "{:?}", state(&sea, Entity::LostComms));
    assert_eq!(coded(&sea), "lost=1;then=nothing;now=hold;stands=holds");
    // Without positions the hold fails after a time. It starts again when there are positions.
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = true;
    assert!(sea.run_until(150.0, |sea| !runs(sea, "hold")));
    sea.vehicle.hull.vessel.faults_mut().gnss_silent = false;
    assert!(sea.run_until(15.0, |sea| runs(sea, "hold")), "{:?}", sea.plan_state());
}

#[test]
fn a_weaker_remedy_does_not_replace_a_stronger_one() {
    let battery = BatteryConfig { reserve_remedy: Some(home()), ..BatteryConfig::default() };
    let mut sea = under_way(|settings| {
        settings.watch.lost_comms = lost(Remedy::Hold);
        settings.watch.battery = battery;
    });
    sea.vehicle.hull.vessel.drain_to(18.0);
    assert!(sea.run_until(20.0, |sea| runs(sea, "home")), "{:?}", sea.plan_state());
    sea.heartbeats = false;
    sea.run(60.0);
    assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
    assert!(says(&sea, Entity::Fuel, "run plan home: in force; next: hold station"));
    assert!(says(&sea, Entity::LostComms, "hold station: run plan home is in force instead"));
    let coded = values(&sea, Entity::LostComms).pop().unwrap_or_default();
    assert!(coded.ends_with(";now=run;now_plan=home;stands=outranked"), "{coded}");
}

#[test]
fn a_missing_plan_is_stood_in_for_and_runs_once_it_is_there() {
    let plan_id = "berth".to_owned();
    let mut sea = under_way(|settings| settings.watch.lost_comms = lost(Remedy::Run { plan_id }));
    sea.heartbeats = false;
    assert!(sea.run_until(30.0, |sea| runs(sea, "hold")));
    sea.run(2.0);
    assert!(says(&sea, Entity::LostComms, "not possible (there is no plan 'berth')"));
    assert!(values(&sea, Entity::LostComms).pop().unwrap().ends_with(";now=run;now_plan=berth;stands=waits"));
    // From a system that is no console, so that communications stay lost.
    let berth = plan("berth", vec![("a".into(), goto(-500.0, 0.0, 1.5).into())]);
    let set = PlanDB { op: PlanDBOp::Set, plan_id: "berth".into(), arg: berth.into(), ..PlanDB::default() };
    sea.send_as(imc::Address(0x2811), OTTER, set);
    assert!(sea.run_until(5.0, |sea| runs(sea, "berth")), "{:?}", sea.plan_state());
}

#[test]
fn an_operator_who_steps_in_is_not_overruled() {
    let battery = BatteryConfig { reserve_remedy: Some(home()), ..BatteryConfig::default() };
    let mut sea = under_way(|settings| settings.watch.battery = battery);
    sea.vehicle.hull.vessel.drain_to(18.0);
    assert!(sea.run_until(20.0, |sea| runs(sea, "home")));
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(20.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Ready);
    assert!(says(&sea, Entity::Fuel, "run plan home: done, or an operator decided otherwise"));
    let other = plan("other", vec![("a".into(), goto(3000.0, 0.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "other", Some(other.into()));
    sea.run(20.0);
    assert!(runs(&sea, "other"));
    sea.vehicle.hull.vessel.drain_to(8.0);
    assert!(sea.run_until(20.0, |sea| runs(sea, "hold")), "a worse stage counts again");
}

#[test]
fn limits_that_only_warn_are_watched_and_told() {
    let mut sea = under_way(|settings| {
        let (area_remedy, speed_remedy) = (None, None);
        settings.watch.limits =
            LimitsConfig { max_speed_mps: Some(0.5), area_remedy, speed_remedy, ..LimitsConfig::default() };
    });
    sea.run(20.0);
    assert!(runs(&sea, "far"), "nothing is done");
    let (condition, text) = state(&sea, Entity::Limits);
    assert_eq!((condition, text.as_str()), (EntityStateState::Error, "faster than allowed; only reported"));
}

#[test]
fn every_supervisor_tells_what_it_will_do_before_anything_happens() {
    let mut settings = settings();
    settings.watch.lost_comms = lost(home());
    settings.watch.limits = LimitsConfig {
        max_speed_mps: Some(2.5),
        speed_remedy: Some(Remedy::Hold),
        ..LimitsConfig::default()
    };
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.run(3.0);
    assert!(says(&sea, Entity::LostComms, "in contact; without: run plan home at "));
    // The same for programs, as numbers, once and not each second.
    assert_eq!(values(&sea, Entity::LostComms), ["lost=0", "lost=0;due_s=19;then=run;plan=home"]);
    assert!(says(&sea, Entity::Limits, "kept; next: above 2.5 m/s: hold station"));
    assert!(says(&sea, Entity::Fuel, "next: run plan return"), "{:?}", state(&sea, Entity::Fuel));
    sea.vehicle.hull.vessel.drain_to(15.0);
    sea.run(15.0);
    assert!(says(&sea, Entity::Fuel, "run plan return: not before an operator has set the vessel in motion"));
}

#[test]
fn a_battery_that_is_only_watched_says_when_it_will_warn() {
    let mut settings = settings();
    settings.watch.battery =
        BatteryConfig { reserve_remedy: None, critical_remedy: None, ..BatteryConfig::default() };
    let low = format!("next: a warning below {:.0} %", 100.0 * settings.watch.battery.low);
    let reserve = format!("next: a warning below {:.0} %", 100.0 * settings.watch.battery.reserve);
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.run(3.0);
    assert!(says(&sea, Entity::Fuel, &low), "{:?}", state(&sea, Entity::Fuel));
    sea.vehicle.hull.vessel.drain_to(25.0);
    sea.run(60.0);
    assert!(says(&sea, Entity::Fuel, &reserve), "{:?}", state(&sea, Entity::Fuel));
}

#[test]
fn a_low_voltage_counts_whatever_the_charge() {
    let mut sea = under_way(|settings| {
        // Above what the simulated batteries have.
        settings.watch.battery = BatteryConfig {
            low_v: Some(100.0),
            reserve_v: Some(90.0),
            lasting: Duration::from_secs(20),
            reserve_remedy: Some(Remedy::Hold),
            ..BatteryConfig::default()
        };
    });
    assert!(sea.run_until(15.0, |sea| runs(sea, "hold")), "{:?}", state(&sea, Entity::Fuel));
    assert_eq!(state(&sea, Entity::Fuel).0, EntityStateState::Error);
}

#[test]
fn a_plan_that_carries_on_in_silence_does_not_call_that_contact() {
    let mut sea = under_way(|settings| settings.watch.lost_comms.plan = Vec::new());
    assert!(says(&sea, Entity::LostComms, "in contact; without: carry on"));
    sea.heartbeats = false;
    sea.run(60.0);
    assert!(says(&sea, Entity::LostComms, "not heard for 60 s; without: carry on"));
    sea.run(600.0);
    let (condition, text) = state(&sea, Entity::LostComms);
    assert_eq!(text, "no console is heard, not heard for 11 min; next: carry on");
    assert_eq!(condition, EntityStateState::Fault);
    assert!(runs(&sea, "far"), "it carries on all the same");
    let told = sea.all::<LogBookEntry>();
    assert_eq!(told.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains("carries on")).count(), 1);
    sea.heartbeats = true;
    sea.run(3.0);
    assert!(says(&sea, Entity::LostComms, "in contact; without: carry on"));
}
