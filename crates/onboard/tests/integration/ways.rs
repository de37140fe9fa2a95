//! Ways that the vessel searches for on its own: home round a headland, to a reference behind land. A route that is found
//! is checked by the guard, and an answer without an open request moves nothing.

use crate::common::*;
use imc::messages::*;
use mission::{BatteryConfig, LostCommsConfig, Remedy, Step, check_plan};
use onboard::record::{read_input, write_input, write_output};
use onboard::{
    Brain, Chart, Condition, DeviceState, Entity, FoundRoute, GroundingSettings, Input, Lease, Output,
    RouteAnswer, RouteRequest, Settings, checked_plan,
};
use std::f64::consts::TAU;
use std::time::Duration;
use testkit::Numbers;
use testkit::sea::{Ground, Sea as Chartmaker};
use units::{LatLon, LocalPoint};
use vehicle::BrainEvent;

/// The guard's clearance of a track, without the uncertainty of the position (m).
const GUARD_M: f64 = 11.2;

/// 20 m of water, and land from the west as far as 120 m east of the start, 90 to 210 m north of it.
fn headland() -> Chartmaker {
    let land = (0..20).map(|n| LocalPoint { north_m: 150.0, east_m: 60.0 - 80.0 * f64::from(n) });
    let water = Chartmaker::new(frame().origin(), 1_500.0, 20.0);
    land.fold(water, |chart, at| chart.with(Ground::Land, at, 60.0, 24))
}

fn home() -> Remedy {
    Remedy::Run { plan_id: "home".to_owned() }
}

/// Home lies behind the headland; twenty seconds after the last heartbeat a vessel under way goes there.
fn wanting(chart: &Chartmaker) -> Settings {
    let ladder = vec![Step { after: Duration::from_secs(20), remedy: home() }];
    let mut settings = settings();
    settings.grounding =
        GroundingSettings { chart: Chart::of("headland", chart.index()), ..settings.grounding };
    settings.watch.lost_comms = LostCommsConfig {
        idle: ladder.clone(),
        plan: ladder.clone(),
        teleoperation: ladder,
        ..LostCommsConfig::default()
    };
    settings
}

/// Under way to the west, south of the headland.
fn under_way(mut sea: Sea) -> Sea {
    sea.upload(&plan("home", vec![("berth".into(), goto(300.0, 0.0, 1.5).into())]));
    let far = plan("far", vec![("a".into(), goto(0.0, -1_200.0, 1.5).into())]);
    sea.ask(PlanControlOp::Start, "far", Some(far.into()));
    sea.run(10.0);
    assert!(runs(&sea, "far"), "{:?}", sea.plan_state());
    sea
}

/// The same, and contact is lost; the test answers the requests for routes.
fn lost() -> (Sea, RouteRequest) {
    lost_by(wanting(&headland()))
}

fn lost_by(settings: Settings) -> (Sea, RouteRequest) {
    let mut sea = under_way(Sea::with(settings, |_| {}).ready());
    sea.vehicle.routes = None;
    sea.heartbeats = false;
    assert!(sea.run_until(30.0, |sea| !requests(sea).is_empty()), "it asks for a route");
    sea.run(1.0);
    let request = requests(&sea).pop().flatten().unwrap();
    (sea, request)
}

fn runs(sea: &Sea, plan_id: &str) -> bool {
    let state = sea.plan_state();
    state.state == PlanControlStateState::Executing && state.plan_id == plan_id
}

fn requests(sea: &Sea) -> Vec<Option<RouteRequest>> {
    let wanted = |output: &Output| {
        if let Output::Route(wanted) = output { Some(wanted.as_deref().cloned()) } else { None }
    };
    sea.outputs.iter().filter_map(|(_, output)| wanted(output)).collect()
}

/// Round the end of the headland.
fn around(request: &RouteRequest) -> FoundRoute {
    let places = vec![request.from, place(50.0, 200.0), place(250.0, 200.0), request.to];
    FoundRoute { places, length_m: 900.0, start_moved: false }
}

fn answer(sea: &mut Sea, number: u32, outcome: Result<FoundRoute, String>) {
    sea.tell(Input::Route(RouteAnswer { number, outcome }));
}

fn told(sea: &Sea, word: &str) -> usize {
    let entries = sea.all::<LogBookEntry>();
    entries.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains(word)).count()
}

fn state(sea: &Sea, entity: Entity) -> String {
    let mut own = sea.said.iter().rev().filter(|(_, packet)| packet.header.src_ent == entity.number());
    own.find_map(|(_, packet)| packet.get::<EntityState>()).unwrap().description.to_string()
}

/// Some seconds: a return of seven minutes in wind and current.
#[test]
fn a_vessel_that_hears_nobody_comes_home_around_a_headland() {
    let chart = headland();
    let sea = Sea::with(wanting(&chart), |vessel| {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (0.25, 0.0);
        (vessel.environment.wind.speed_mps, vessel.environment.wind.from_rad) = (6.0, 3.0);
    });
    let mut sea = under_way(sea.ready());
    sea.heartbeats = false;
    assert!(sea.run_until(30.0, |sea| runs(sea, "home")), "{:?}", sea.plan_state());
    sea.run(3.0);
    assert_eq!(told(&sea, "a route around land is looked for"), 1);
    assert_eq!(told(&sea, "run plan home: returning by a route of"), 1);
    let text = state(&sea, Entity::LostComms);
    assert!(text.contains("run plan home: in force; returning by a route of"), "{text}");
    assert!(sea.plan_state().man_id.to_str_lossy().starts_with("route "), "{:?}", sea.plan_state());
    let mut closest = true;
    let arrived = sea.run_until(900.0, |sea| {
        // More than the guard's clearance beyond the allowed cross-track error.
        closest &= chart.is_deep_within(sea.position(), 20.0, 5.0);
        !runs(sea, "home")
    });
    assert!(arrived && closest, "{:?}", sea.position());
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
    assert!(sea.position().distance_m(LocalPoint { north_m: 300.0, east_m: 0.0 }) < 30.0);
    // The plan at home is as it was uploaded.
    let kept: Vec<_> = sea.disk.plans.iter().map(|record| record.plan_id.as_str()).collect();
    assert_eq!(kept.iter().filter(|id| **id == "home").count(), 1, "{kept:?}");
    assert!(!told_of_route_in(&sea.disk), "the route is not stored");
}

fn told_of_route_in(disk: &mission::Kept) -> bool {
    disk.plans.iter().any(|record| record.bytes.windows(7).any(|bytes| bytes == b"route 1"))
}

#[test]
fn a_low_battery_leads_home_around_a_headland() {
    let mut settings = wanting(&headland());
    settings.watch.battery = BatteryConfig { reserve_remedy: Some(home()), ..BatteryConfig::default() };
    let mut sea = under_way(Sea::with(settings, |_| {}).ready());
    sea.vehicle.hull.vessel.drain_to(18.0);
    assert!(sea.run_until(20.0, |sea| runs(sea, "home")), "{:?}", sea.plan_state());
    sea.run(1.0);
    assert!(state(&sea, Entity::Fuel).contains("returning by a route of"), "{}", state(&sea, Entity::Fuel));
}

/// An operator took it over a shoal where it may not sail on its own, and fell silent.
#[test]
fn a_vessel_in_shallows_goes_back_to_deep_water_first() {
    let chart = headland().with(Ground::Depth(3.0), LocalPoint::default(), 30.0, 24);
    let mut sea = Sea::with(wanting(&chart), |_| {}).ready();
    sea.upload(&plan("home", vec![("berth".into(), goto(300.0, 0.0, 1.5).into())]));
    sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(1.0);
    sea.heartbeats = false;
    assert!(sea.run_until(30.0, |sea| runs(sea, "home")), "{}", state(&sea, Entity::LostComms));
    sea.run(1.0);
    let text = state(&sea, Entity::LostComms);
    assert!(text.contains("first back to deep water"), "{text}");
    let deep = |sea: &Sea| chart.is_deep_within(sea.position(), 10.0, 5.0);
    assert!(sea.run_until(120.0, deep), "{:?}", sea.position());
    assert!(sea.run_until(900.0, |sea| !runs(sea, "home") || !deep(sea)));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
    assert!(deep(&sea), "{:?}", sea.position());
}

#[test]
fn it_holds_while_it_waits_and_a_stale_answer_moves_nothing() {
    let (mut sea, request) = lost();
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
    assert!(state(&sea, Entity::LostComms).contains("a route around land is looked for"));
    answer(&mut sea, request.number.wrapping_sub(1), Ok(around(&request)));
    answer(&mut sea, request.number + 1, Ok(around(&request)));
    sea.run(3.0);
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
    answer(&mut sea, request.number, Ok(around(&request)));
    assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
    assert_eq!(sea.plan_state().man_id, "route 1");
    // A console that is heard again gets the route, and the vessel continues.
    sea.forget();
    sea.heartbeats = true;
    sea.run(3.0);
    assert_eq!(sea.last::<PlanSpecification>().unwrap().start_man_id, "route 1");
    assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
    // The same answer once more has no open request.
    sea.ask(PlanControlOp::Stop, "", None);
    answer(&mut sea, request.number, Ok(around(&request)));
    sea.run(5.0);
    assert_eq!(sea.plan_state().state, PlanControlStateState::Ready);
}

/// Stop, abort, another plan, an operator who steers, a console that is heard again: each wins over an answer that comes later.
#[test]
fn whoever_steps_in_is_not_overruled_by_an_answer() {
    type StepIn = fn(&mut Sea);
    let all: [(StepIn, &str); 5] = [
        (|sea| _ = sea.ask(PlanControlOp::Stop, "", None), ""),
        (|sea| sea.send(Abort), ""),
        (
            |sea| {
                let far = plan("other", vec![("a".into(), goto(-300.0, -300.0, 1.5).into())]);
                sea.ask(PlanControlOp::Start, "other", Some(far.into()));
            },
            "other",
        ),
        (|sea| _ = sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into())), "hand"),
        (|sea| sea.send(Heartbeat), "hold"),
    ];
    for (step_in, runs_then) in all {
        let (mut sea, request) = lost();
        step_in(&mut sea);
        // The supervisors check twice a second whether a console is heard.
        sea.run(0.6);
        let withdrawn = requests(&sea);
        assert_eq!(withdrawn.last(), Some(&None), "{runs_then}: the search is called off");
        answer(&mut sea, request.number, Ok(around(&request)));
        sea.run(3.0);
        let state = sea.plan_state();
        match runs_then {
            "" => assert_eq!(state.state, PlanControlStateState::Ready, "{state:?}"),
            plan_id => assert!(runs(&sea, plan_id), "{state:?}"),
        }
    }
}

#[test]
fn where_there_is_no_route_it_says_why_holds_and_looks_again_after_a_minute() {
    let (mut sea, request) = lost();
    assert!((request.needs.clearance_m - 25.0).abs() < 1e-9, "{request:?}");
    answer(&mut sea, request.number, Err("no water is wide enough".into()));
    let second = requests(&sea).pop().flatten().unwrap();
    assert!(
        (second.needs.clearance_m - GUARD_M).abs() < 1e-9,
        "then with the guard's own clearance: {second:?}"
    );
    answer(&mut sea, second.number, Err("an islet closes the sound".into()));
    sea.run(3.0);
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
    let text = state(&sea, Entity::LostComms);
    assert!(text.contains("no route around land either: an islet closes the sound"), "{text}");
    assert!(told(&sea, "an islet closes the sound") > 0);
    sea.run(50.0);
    assert_eq!(requests(&sea).len(), 2);
    sea.run(20.0);
    let third = requests(&sea).pop().flatten().unwrap();
    assert!(third.number > second.number);
    answer(&mut sea, third.number, Ok(around(&third)));
    assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
}

#[test]
fn an_answer_that_leads_over_land_is_not_sailed() {
    let (mut sea, request) = lost();
    let over = FoundRoute { places: vec![request.from, request.to], length_m: 300.0, start_moved: false };
    answer(&mut sea, request.number, Ok(over.clone()));
    let second = requests(&sea).pop().flatten().unwrap();
    assert_ne!(second.number, request.number);
    answer(&mut sea, second.number, Ok(FoundRoute { start_moved: true, ..over }));
    sea.run(5.0);
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
    assert!(state(&sea, Entity::LostComms).contains("land"), "{}", state(&sea, Entity::LostComms));
}

#[test]
fn out_of_deep_water_no_way_leads_over_a_shoal() {
    let shoal = LocalPoint { north_m: 25.0, east_m: 90.0 };
    let (mut sea, request) = lost_by(wanting(&headland().with(Ground::Depth(3.0), shoal, 20.0, 24)));
    let over =
        FoundRoute { start_moved: true, places: around(&request).places.split_off(1), length_m: 900.0 };
    answer(&mut sea, request.number, Ok(over.clone()));
    let second = requests(&sea).pop().flatten().unwrap();
    answer(&mut sea, second.number, Ok(over));
    sea.run(5.0);
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
}

#[test]
fn what_leads_out_of_the_area_again_is_not_sailed() {
    let mut settings = wanting(&headland());
    let corners = [(-60.0, -1_300.0), (-60.0, 300.0), (330.0, 300.0), (330.0, -1_300.0)];
    let corners = corners.map(|(north_m, east_m)| place(north_m, east_m));
    settings.mission.limits.area = Some(guard::Area::new(&corners).unwrap());
    let (mut sea, request) = lost_by(settings);
    let mut out = around(&request);
    out.places.insert(2, place(50.0, 400.0));
    answer(&mut sea, request.number, Ok(out));
    sea.run(1.0);
    assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
}

#[test]
fn a_search_whose_answer_is_lost_is_told_and_made_again() {
    let (mut sea, request) = lost();
    sea.run(65.0);
    assert!(state(&sea, Entity::LostComms).contains("has been found within a minute"));
    assert!(sea.run_until(70.0, |sea| requests(sea).len() > 1));
    assert!(requests(&sea).pop().flatten().unwrap().number > request.number);
}

#[test]
fn a_late_answer_is_taken_until_it_is_asked_for_again() {
    let (mut sea, request) = lost();
    sea.run(65.0);
    answer(&mut sea, request.number, Ok(around(&request)));
    sea.run(1.0);
    assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
}

#[test]
fn no_route_is_looked_for_where_the_files_say_so_or_none_would_help() {
    let mut without = wanting(&headland());
    without.grounding.routes.around = false;
    // Home is too near land to stay there, from wherever the vessel comes.
    let islet = headland().with(Ground::Land, LocalPoint { north_m: 300.0, east_m: 10.0 }, 20.0, 12);
    let closed = Settings { grounding: GroundingSettings::default(), ..wanting(&islet) };
    for (settings, chart) in [(without, None), (closed, Some(islet))] {
        let mut sea = Sea::with(settings, |_| {}).ready();
        sea = under_way(sea);
        if let Some(chart) = chart {
            let Chart::Loaded(file) = Chart::of("islet", chart.index()) else { panic!() };
            sea.tell(Input::Chart(file));
        }
        sea.heartbeats = false;
        sea.run(40.0);
        assert!(requests(&sea).is_empty());
        assert!(runs(&sea, "hold"), "{:?}", sea.plan_state());
        assert!(state(&sea, Entity::LostComms).contains("refused by the sea chart"));
    }
}

fn reference(goal: LatLon) -> Reference {
    Reference {
        flags: ReferenceFlags::LOCATION | ReferenceFlags::SPEED,
        speed: DesiredSpeed { value: 1.5, speed_units: SpeedUnits::MetersPs }.into(),
        lat: goal.lat_rad(),
        lon: goal.lon_rad(),
        ..Reference::default()
    }
}

fn following() -> Sea {
    let mut settings = wanting(&headland());
    settings.watch.lost_comms = LostCommsConfig::default();
    let mut sea = Sea::with(settings, |_| {}).ready();
    let follow =
        FollowReference { control_src: 0xFFFF, control_ent: 0xFF, timeout: 60.0, ..Default::default() };
    sea.ask(PlanControlOp::Start, "follow", Some(follow.into()));
    sea.run(1.0);
    sea
}

/// Some seconds: a way of seven minutes.
#[test]
fn a_reference_behind_land_is_followed_around_it() {
    let (mut sea, chart) = (following(), headland());
    let goal = LocalPoint { north_m: 300.0, east_m: -50.0 };
    for _ in 0..700 {
        sea.send(reference(place(goal.north_m, goal.east_m)));
        sea.run(1.0);
        assert!(chart.is_deep_within(sea.position(), 20.0, 5.0), "{:?}", sea.position());
        if sea.position().distance_m(goal) < 15.0 {
            break;
        }
    }
    assert!(sea.position().distance_m(goal) < 30.0, "{:?}", sea.position());
    assert_eq!(requests(&sea).len(), 1, "asked once");
    assert_eq!(told(&sea, "the place asked for is reached by a route"), 1);
}

#[test]
fn a_reference_that_is_given_up_is_not_followed_by_a_late_answer() {
    let mut sea = following();
    sea.vehicle.routes = None;
    sea.send(reference(place(300.0, -50.0)));
    let request = requests(&sea).pop().flatten().unwrap();
    // Another place, which a straight way leads to.
    sea.send(reference(place(-200.0, 0.0)));
    answer(&mut sea, request.number, Ok(around(&request)));
    sea.run(40.0);
    assert!(sea.position().north_m < -20.0, "{:?}", sea.position());
    // One that waits, and an abort.
    sea.send(reference(place(300.0, -50.0)));
    let request = requests(&sea).pop().flatten().unwrap();
    sea.send(Abort);
    sea.run(0.2);
    assert_eq!(requests(&sea).last(), Some(&None));
    answer(&mut sea, request.number, Ok(around(&request)));
    sea.run(5.0);
    assert_ne!(sea.plan_state().state, PlanControlStateState::Executing);
    assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED);
}

/// An islet lies between, and the shorter way around it leads out of the area.
#[test]
fn the_way_home_is_looked_for_inside_the_area() {
    let north_m = |north_m| LocalPoint { north_m, east_m: 0.0 };
    let chart =
        Chartmaker::new(frame().origin(), 1_500.0, 20.0).with(Ground::Land, north_m(200.0), 100.0, 24);
    let mut settings = wanting(&chart);
    let corners = [(-200.0, -900.0), (-200.0, 80.0), (500.0, 80.0), (500.0, -900.0)];
    let area = guard::Area::new(&corners.map(|(north_m, east_m)| place(north_m, east_m))).unwrap();
    settings.mission.limits.area = Some(area.clone());
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.upload(&plan("home", vec![("berth".into(), goto(420.0, 20.0, 1.5).into())]));
    sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(1.0);
    sea.heartbeats = false;
    assert!(sea.run_until(40.0, |sea| runs(sea, "home")), "{}", state(&sea, Entity::LostComms));
    assert_eq!(requests(&sea).len(), 1, "the first route is one inside");
    assert!(sea.run_until(900.0, |sea| {
        assert!(area.outside_m(frame().to_place(sea.position())) <= 0.0, "{:?}", sea.position());
        !runs(sea, "home")
    }));
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
}

/// It moves a metre each second, along the far side of the headland.
#[test]
fn a_reference_that_moves_behind_land_is_followed_by_one_route() {
    let mut sea = following();
    let mut goal = LocalPoint { north_m: 300.0, east_m: -50.0 };
    let mut first = None;
    for _ in 0..240 {
        goal.east_m -= 0.5;
        sea.send(reference(place(goal.north_m, goal.east_m)));
        sea.run(1.0);
        first.get_or_insert_with(|| sea.position());
    }
    let sailed_m = sea.position().distance_m(first.unwrap());
    assert!(sailed_m > 150.0, "it sails: {sailed_m} m");
    assert!(requests(&sea).len() <= 3, "asked {} times", requests(&sea).len());
    assert!(told(&sea, "cannot be reached straight") <= 3, "{}", told(&sea, "cannot be reached straight"));
}

#[test]
fn a_pending_reference_is_given_up_and_told_when_control_changes_or_the_plan_ends() {
    let holder = |epoch: u64| {
        let lasts = Duration::from_mins(1);
        Input::Lease(Lease { epoch, lasts, holder: format!("holder {epoch}") })
    };
    let mut sea = following();
    sea.vehicle.routes = None;
    sea.send(reference(place(300.0, -50.0)));
    let request = requests(&sea).pop().flatten().unwrap();
    sea.tell(holder(1));
    assert_eq!(requests(&sea).last(), Some(&None), "the search is called off");
    assert_eq!(told(&sea, "is given up: control has changed hands"), 1);
    answer(&mut sea, request.number, Ok(around(&request)));
    sea.run(5.0);
    assert_eq!(sea.motors.last().unwrap().1, control::MotorPair::STOPPED, "the answer moves nothing");
    let mut sea = following();
    sea.vehicle.routes = None;
    sea.send(reference(place(300.0, -50.0)));
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(0.2);
    assert_eq!(told(&sea, "has stopped: 'follow' has ended"), 1);
}

/// A chart came under way that has land where the route leads.
#[test]
fn a_return_under_way_is_judged_again_by_a_new_chart() {
    let across = LocalPoint { north_m: 150.0, east_m: 200.0 };
    for (land, goes_on) in [(across, false), (LocalPoint { north_m: -300.0, east_m: -300.0 }, true)] {
        let (mut sea, request) = lost();
        answer(&mut sea, request.number, Ok(around(&request)));
        assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
        let chart = headland().with(Ground::Land, land, 40.0, 12);
        let Chart::Loaded(file) = Chart::of("another", chart.index()) else { panic!() };
        sea.tell(Input::Chart(file));
        sea.run(1.0);
        let told = told(&sea, "the new chart closes the way home");
        if goes_on {
            assert!(runs(&sea, "home") && told == 0, "{:?}", sea.plan_state());
            continue;
        }
        assert!(runs(&sea, "hold") && told == 1, "{:?}", sea.plan_state());
        let second = requests(&sea).pop().flatten().unwrap();
        assert!(second.number > request.number, "another is looked for");
        let mut wider = around(&second);
        (wider.places[1], wider.places[2]) = (place(50.0, 300.0), place(250.0, 300.0));
        answer(&mut sea, second.number, Ok(wider));
        assert!(runs(&sea, "home"), "{:?}", sea.plan_state());
    }
}

/// 900 m at 1.5 m/s take 39 Wh by the table of the vessel; of 3660 Wh the tenth is kept.
#[test]
fn a_route_that_the_charge_does_not_reach_is_not_sailed_and_told_with_figures() {
    for (percent, sails) in [(10.4, false), (14.0, true)] {
        let mut settings = wanting(&headland());
        let none = BatteryConfig { reserve_remedy: None, critical_remedy: None, ..BatteryConfig::default() };
        settings.watch.battery = none;
        let mut sea = under_way(Sea::with(settings, |_| {}).ready());
        sea.vehicle.routes = None;
        sea.vehicle.hull.vessel.drain_to(percent);
        sea.heartbeats = false;
        assert!(sea.run_until(30.0, |sea| !requests(sea).is_empty()));
        sea.run(2.0);
        for _ in 0..2 {
            let Some(Some(request)) = requests(&sea).pop() else { continue };
            answer(&mut sea, request.number, Ok(around(&request)));
        }
        sea.run(3.0);
        assert!(runs(&sea, if sails { "home" } else { "hold" }), "{percent}: {:?}", sea.plan_state());
        let text = state(&sea, Entity::LostComms);
        let out_of_reach = text.contains("is out of reach: it takes about")
            && text.contains("Wh may be used (10 % are kept in reserve)");
        assert_eq!(out_of_reach, !sails, "{text}");
        assert_eq!(told(&sea, "is out of reach") > 0, !sails);
    }
}

/// A vital part is in error when the answer comes.
#[test]
fn a_route_that_is_found_while_the_engine_is_blocked_is_sailed_when_it_is_not() {
    let device = |condition| {
        Input::Device(DeviceState { entity: Entity::Light, condition, text: "a test".to_owned() })
    };
    for drifts_ashore in [false, true] {
        let mut settings = wanting(&headland());
        settings.watch.monitored.push(Entity::Light);
        settings.watch.vital.push(Entity::Light);
        let (mut sea, request) = lost_by(settings);
        sea.tell(device(Condition::Error));
        sea.run(3.0);
        answer(&mut sea, request.number, Ok(around(&request)));
        sea.run(20.0);
        assert!(!runs(&sea, "home"));
        let text = state(&sea, Entity::LostComms);
        assert!(text.contains("was found and cannot start yet: vehicle is blocked"), "{text}");
        assert_eq!(requests(&sea).len(), 1, "not asked again");
        if drifts_ashore {
            // A chart that refuses the way lets go of it.
            let chart = headland().with(Ground::Land, LocalPoint { north_m: 50.0, east_m: 200.0 }, 40.0, 12);
            let Chart::Loaded(file) = Chart::of("another", chart.index()) else { panic!() };
            sea.tell(Input::Chart(file));
        }
        sea.tell(device(Condition::Normal));
        sea.run(5.0);
        assert_eq!(runs(&sea, "home"), !drifts_ashore, "{:?}", sea.plan_state());
        assert_eq!(requests(&sea).len(), if drifts_ashore { 2 } else { 1 });
    }
}

/// Seas with islets, start and home anywhere, answers of the planner and answers that lead anywhere: whatever is sailed
/// passes the guard from where the vessel is.
#[test]
fn every_way_that_is_sailed_passes_the_guard() {
    let mut sailed = 0;
    for seed in 0..16 {
        let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15 ^ (seed + 1));
        for _ in 0..8 {
            numbers.within(0.0, 1.0);
        }
        sailed += usize::from(is_sailed_safely(&mut numbers, seed));
    }
    assert!(sailed >= 4, "{sailed} ways were sailed");
}

fn is_sailed_safely(numbers: &mut Numbers, seed: u64) -> bool {
    let islet = |chart: Chartmaker, numbers: &mut Numbers| {
        let at = LocalPoint::default().displaced(numbers.within(0.0, TAU), numbers.within(150.0, 600.0));
        chart.with(Ground::Land, at, numbers.within(20.0, 90.0), 7)
    };
    let towards_rad = numbers.within(0.0, TAU);
    let berth = LocalPoint::default().displaced(towards_rad, 700.0);
    let between = LocalPoint::default().displaced(towards_rad, numbers.within(200.0, 500.0));
    let mut chart = Chartmaker::new(frame().origin(), 1_500.0, 20.0).with(Ground::Land, between, 70.0, 9);
    for _ in 0..8 {
        chart = islet(chart, numbers);
    }
    let mut settings = wanting(&chart);
    settings.grounding.routes.clearance_m = numbers.within(0.0, 60.0);
    let limits = settings.guard_limits();
    let mut sea = Sea::with(settings.clone(), |_| {}).ready();
    sea.upload(&plan("home", vec![("berth".into(), goto(berth.north_m, berth.east_m, 1.5).into())]));
    // An operator lets go of it: it holds and then returns.
    sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(1.0);
    if seed % 2 == 1 {
        sea.vehicle.routes = None;
    }
    sea.heartbeats = false;
    for _ in 0..50 {
        sea.run(1.0);
        let Some(Some(request)) = requests(&sea).pop() else { continue };
        if seed % 2 == 1 {
            let anywhere =
                |numbers: &mut Numbers| place(numbers.within(-800.0, 800.0), numbers.within(-800.0, 800.0));
            let mut places = vec![request.from, anywhere(numbers), anywhere(numbers)];
            places.push(request.to);
            answer(&mut sea, request.number, Ok(FoundRoute { places, length_m: 1.0, start_moved: false }));
        }
    }
    let index = chart.index();
    let mut by_route = false;
    for (now, specification) in sea.all::<PlanSpecification>() {
        let first = specification.start_man_id.to_str_lossy().into_owned();
        if !first.starts_with("route") {
            continue;
        }
        by_route = true;
        let before =
            sea.all::<EstimatedState>().into_iter().rev().find(|(at, _)| at.mono <= now.mono).unwrap();
        let here = before.1;
        let from = LatLon::from_rad(here.lat, here.lon).unwrap();
        let offset = LocalPoint { north_m: f64::from(here.x), east_m: f64::from(here.y) };
        let from = units::LocalFrame::new(from).to_place(offset);
        let plan = checked_plan(&specification, &settings).unwrap();
        let verdict = check_plan(&plan, Some(from), &index, &limits);
        assert!(!verdict.is_refused(), "{seed}: {}", verdict.summary());
    }
    by_route
}

/// Requests and answers are in the recording: equal inputs give equal outputs.
#[test]
fn a_return_by_a_route_is_replayed_bit_for_bit() {
    let settings = wanting(&headland());
    let mut sea = Sea::with(settings.clone(), |_| {});
    let begun = sea.vehicle.now;
    let mut all: Vec<(bool, Vec<u8>)> = Vec::new();
    let mut sink = |now: units::Now, event: BrainEvent<'_>| {
        let mut bytes = Vec::new();
        match &event {
            BrainEvent::Input(input) => {
                write_input(&mut bytes, now, input);
                all.push((true, bytes));
            }
            BrainEvent::Output(output) => {
                write_output(&mut bytes, output);
                all.push((false, bytes));
            }
        }
    };
    let packet = |message: Message| {
        let header = imc::Header { src: CONSOLE, dst: OTTER, ..imc::Header::default() };
        Input::Packet(PEER, imc::Packet::new(header, message).encode().unwrap())
    };
    let start = |plan_id: &str, plan: PlanSpecification| {
        packet(
            PlanControl {
                r#type: PlanControlType::Request,
                op: PlanControlOp::Start,
                plan_id: plan_id.into(),
                arg: plan.into(),
                ..PlanControl::default()
            }
            .into(),
        )
    };
    for second in 1_u64..=120 {
        let until = units::MonoTime::from_micros(second * 1_000_000);
        while sea.vehicle.now.mono < until {
            sea.vehicle.advance(until, &mut sink);
        }
        match second {
            // The way home is straight from nowhere; it is known by the start of it, which is refused and leaves it there.
            15 => {
                let home = plan("home", vec![("berth".into(), goto(300.0, 0.0, 1.5).into())]);
                let set = PlanDB {
                    op: PlanDBOp::Set,
                    plan_id: "home".into(),
                    arg: home.into(),
                    ..PlanDB::default()
                };
                sea.vehicle.tell(packet(set.into()), &mut sink);
            }
            20 => {
                let far = plan("far", vec![("a".into(), goto(0.0, -1_200.0, 1.5).into())]);
                sea.vehicle.tell(start("far", far), &mut sink);
            }
            _ => {}
        }
    }
    let mut brain = Brain::new(settings, begun, mission::Kept::default()).unwrap();
    brain.handle(begun, Input::Connected(PEER));
    while brain.poll_output().is_some() {}
    let mut outputs = Vec::new().into_iter();
    let mut answers = 0;
    for (is_input, bytes) in &all {
        if *is_input {
            assert_eq!(outputs.next(), None, "an output that was not recorded");
            let (now, input) = read_input(bytes).unwrap();
            answers += usize::from(matches!(input, Input::Route(RouteAnswer { outcome: Ok(_), .. })));
            brain.handle(now, input);
            let mut got = Vec::new();
            while let Some(output) = brain.poll_output() {
                let mut bytes = Vec::new();
                write_output(&mut bytes, &output);
                got.push(bytes);
            }
            outputs = got.into_iter();
        } else {
            assert_eq!(outputs.next().as_ref(), Some(bytes), "a replayed output differs");
        }
    }
    assert_eq!(answers, 1, "one route was found");
}
