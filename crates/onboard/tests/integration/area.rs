//! Outside the area of operation: every remedy leads back inside, or to a station that is reported.

use crate::common::*;
use guard::Area;
use imc::messages::*;
use mission::{LimitsConfig, LostCommsConfig, Remedy, Step};
use onboard::{Chart, Entity, Settings};
use std::time::Duration;
use testkit::sea::{Ground, Sea as Chartlet};
use units::LocalPoint;

/// A square whose southern border lies `north_m` north of where the vessel begins.
fn square(north_m: f64) -> Area {
    let corners = [(0.0, -100.0), (200.0, -100.0), (200.0, 100.0), (0.0, 100.0)];
    let corners = corners.map(|(n, e)| place(north_m + n, e));
    Area::new(&corners).unwrap()
}

/// A vessel that an operator has set in motion, the area beginning so far north of it.
fn outside_by(north_m: f64, change: impl FnOnce(&mut Settings)) -> Sea {
    let mut settings = settings();
    let area = Some(square(north_m));
    settings.mission.limits.area.clone_from(&area);
    settings.watch.limits = LimitsConfig {
        area,
        area_remedy: Some(Remedy::Hold),
        max_speed_mps: None,
        ..LimitsConfig::default()
    };
    settings.watch.lost_comms =
        LostCommsConfig { idle: vec![], plan: vec![], teleoperation: vec![], ..LostCommsConfig::default() };
    change(&mut settings);
    let mut sea = Sea::with(settings, |_| {}).ready();
    sea.ask(PlanControlOp::Start, "steer", Some(Teleoperation { custom: "src=16385".into() }.into()));
    sea.run(1.0);
    sea
}

fn runs(sea: &Sea, plan_id: &str) -> bool {
    let state = sea.plan_state();
    state.state == PlanControlStateState::Executing && state.plan_id == plan_id
}

fn depth_m(sea: &Sea, north_m: f64) -> f64 {
    let position = sea.position();
    square(north_m).depth_m(place(position.north_m, position.east_m))
}

fn text(sea: &Sea, entity: Entity) -> String {
    let mut own = sea
        .said
        .iter()
        .rev()
        .filter(|(_, packet)| packet.header.src == OTTER && packet.header.src_ent == entity.number());
    own.find_map(|(_, packet)| packet.get::<EntityState>()).unwrap().description.to_string()
}

fn told(sea: &Sea, what: &str) -> bool {
    sea.all::<LogBookEntry>().iter().any(|(_, entry)| entry.text.to_str_lossy().contains(what))
}

#[test]
fn the_hold_of_the_area_leads_back_inside_and_stays_there() {
    let mut sea = outside_by(40.0, |_| {});
    assert!(sea.run_until(15.0, |sea| runs(sea, "hold")), "{}", text(&sea, Entity::Limits));
    assert!(sea.run_until(120.0, |sea| depth_m(sea, 40.0) > 5.0), "{:?}", sea.position());
    sea.run(200.0);
    assert!(runs(&sea, "hold") && depth_m(&sea, 40.0) > 0.0, "{:?}", sea.position());
    assert!(told(&sea, "straight in, as there is no chart to hold the way against"));
    assert!(sea.position().north_m < 80.0, "the nearest place inside: {:?}", sea.position());
}

#[test]
fn a_hold_that_lost_communications_ask_for_outside_leads_inside_too() {
    let mut sea = outside_by(40.0, |settings| {
        settings.watch.limits.area_remedy = None;
        let ladder = vec![Step { after: Duration::from_secs(10), remedy: Remedy::Hold }];
        settings.watch.lost_comms.teleoperation = ladder;
    });
    sea.heartbeats = false;
    assert!(sea.run_until(20.0, |sea| runs(sea, "hold")), "{}", text(&sea, Entity::LostComms));
    assert!(sea.run_until(120.0, |sea| depth_m(sea, 40.0) > 0.0), "{:?}", sea.position());
}

#[test]
fn shallows_on_the_straight_way_are_gone_around() {
    let mut sea = outside_by(60.0, |settings| {
        let north = LocalPoint { north_m: 40.0, east_m: 0.0 };
        let sea = Chartlet::new(frame().origin(), 600.0, 30.0).with(Ground::Depth(0.5), north, 12.0, 12);
        settings.grounding.chart = Chart::of("bank", sea.index());
    });
    assert!(sea.run_until(15.0, |sea| runs(sea, "hold")), "{}", text(&sea, Entity::Limits));
    let mut nearest_m = f64::INFINITY;
    let inside = sea.run_until(240.0, |sea| {
        let LocalPoint { north_m, east_m } = sea.position();
        nearest_m = nearest_m.min((north_m - 40.0).hypot(east_m));
        depth_m(sea, 60.0) > 3.0
    });
    assert!(inside && nearest_m > 15.0, "{:?}, {nearest_m} m", sea.position());
}

#[test]
fn without_a_safe_way_back_it_holds_where_it_is_and_says_so() {
    let mut sea = outside_by(60.0, |settings| {
        // A wall of shallows between the vessel and all of the area.
        let mut sea = Chartlet::new(frame().origin(), 600.0, 30.0);
        for step in -14..=14_i32 {
            let at = LocalPoint { north_m: 45.0, east_m: 20.0 * f64::from(step) };
            sea = sea.with(Ground::Depth(0.5), at, 14.0, 8);
        }
        settings.grounding.chart = Chart::of("wall", sea.index());
    });
    assert!(sea.run_until(15.0, |sea| runs(sea, "hold")), "{}", text(&sea, Entity::Limits));
    sea.run(60.0);
    assert!(runs(&sea, "hold"));
    assert!(sea.position().north_m.abs() < 20.0, "{:?}", sea.position());
    assert!(told(&sea, "no safe way back inside"), "{}", text(&sea, Entity::Limits));
    assert!(text(&sea, Entity::Limits).contains("outside the area"), "{}", text(&sea, Entity::Limits));
    let limits = text(&sea, Entity::Limits);
    assert!(limits.contains("no safe way back inside") && limits.contains("0.5 m"), "{limits}");
}

#[test]
fn a_reference_over_shallows_or_out_of_the_area_is_refused_with_a_word() {
    let mut sea = outside_by(-100.0, |settings| {
        let north = LocalPoint { north_m: 40.0, east_m: 0.0 };
        let sea = Chartlet::new(frame().origin(), 600.0, 30.0).with(Ground::Depth(2.0), north, 10.0, 12);
        settings.grounding.chart = Chart::of("bank", sea.index());
        settings.grounding.routes.around = false;
    });
    let follow = FollowReference {
        control_src: 0xFFFF,
        control_ent: 0xFF,
        timeout: 300.0,
        ..FollowReference::default()
    };
    sea.ask(PlanControlOp::Start, "follow", Some(follow.into()));
    let to = |north_m, east_m| {
        let place = place(north_m, east_m);
        Reference {
            flags: ReferenceFlags::LOCATION,
            lat: place.lat_rad(),
            lon: place.lon_rad(),
            ..Reference::default()
        }
    };
    sea.send(to(80.0, 0.0));
    sea.run(10.0);
    assert!(told(&sea, "a reference is refused, it waits: ") && told(&sea, "2.0 m"));
    assert!(sea.position().north_m.abs() < 3.0, "{:?}", sea.position());
    sea.send(to(0.0, 60.0));
    sea.run(5.0);
    sea.send(to(-150.0, 0.0));
    sea.run(60.0);
    assert!(told(&sea, "a reference is refused, the one before goes on: it lies 50 m outside the area"));
    assert!(
        sea.position().east_m > 15.0 && runs(&sea, "follow"),
        "{:?} {:?}",
        sea.plan_state(),
        sea.all::<LogBookEntry>().iter().map(|e| e.1.text.to_string()).collect::<Vec<_>>()
    );
}
