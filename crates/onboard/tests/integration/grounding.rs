//! The sea chart aboard: plans that lead over shoals, water ahead, an operator who steers for land.

use crate::common::*;
use imc::messages::*;
use onboard::{Chart, Entity, GroundingSettings, Input, Settings};
use testkit::sea::{Ground, Sea as Chartmaker};
use units::{LatLon, LocalPoint};

fn chartmaker() -> Chartmaker {
    Chartmaker::new(frame().origin(), 1500.0, 20.0)
}

/// 20 m of water with an islet of 60 m, 200 m north of the start.
fn islet() -> Chartmaker {
    chartmaker().with(Ground::Land, point(200.0, 0.0), 60.0, 24)
}

fn point(north_m: f64, east_m: f64) -> LocalPoint {
    LocalPoint { north_m, east_m }
}

fn with_chart(chart: Chart) -> Settings {
    Settings { grounding: GroundingSettings { chart, ..GroundingSettings::default() }, ..settings() }
}

fn afloat(chart: &Chartmaker) -> Sea {
    Sea::with(with_chart(Chart::of("made up", chart.index())), |_| {}).ready()
}

fn through() -> PlanSpecification {
    plan("through", vec![("over".to_owned(), goto(400.0, 0.0, 1.5).into())])
}

fn says(sea: &Sea, entity: Entity, word: &str) -> bool {
    let own = sea.said.iter().filter(|(_, packet)| packet.header.src_ent == entity.number());
    own.filter_map(|(_, packet)| packet.get::<LogBookEntry>())
        .any(|entry| entry.text.to_str_lossy().contains(word))
}

fn state(sea: &Sea, entity: Entity) -> EntityState {
    let mut own = sea.said.iter().rev().filter(|(_, packet)| packet.header.src_ent == entity.number());
    own.find_map(|(_, packet)| packet.get::<EntityState>().cloned()).unwrap()
}

fn stored(sea: &Sea) -> PlanDB {
    let all = sea.all::<PlanDB>();
    all.into_iter().map(|(_, reply)| reply).rfind(|reply| reply.r#type != PlanDBType::InProgress).unwrap()
}

#[test]
fn a_plan_over_land_is_neither_stored_nor_started() {
    let mut sea = afloat(&islet());
    // From an unknown start this is one point in deep water.
    sea.upload(&through());
    sea.run(0.5);
    assert_ne!(stored(&sea).r#type, PlanDBType::Failure, "{}", stored(&sea).info);
    let request = sea.ask(PlanControlOp::Start, "through", Some(through().into()));
    sea.run(0.5);
    let reply = sea.replies(request).pop().unwrap();
    assert_eq!(reply.r#type, PlanControlType::Failure);
    let info = reply.info.to_str_lossy().into_owned();
    assert!(info.contains("sea chart") && info.contains("land at 63.33"), "{info}");
    assert_eq!(sea.mode(), VehicleStateOpMode::Service);
    let both = vec![
        ("south".to_owned(), goto(50.0, 0.0, 1.5).into()),
        ("north".to_owned(), goto(400.0, 0.0, 1.5).into()),
    ];
    sea.upload(&plan("both", both));
    sea.run(0.5);
    let reply = stored(&sea);
    assert_eq!(reply.r#type, PlanDBType::Failure);
    assert!(reply.info.to_str_lossy().contains("'north' (transit 1): land"), "{}", reply.info);
    assert!(says(&sea, Entity::Grounding, "'both' is not stored"));
    let request = sea.ask(PlanControlOp::Start, "triangle", Some(triangle().into()));
    sea.run(0.5);
    assert!(sea.replies(request).iter().all(|reply| reply.r#type != PlanControlType::Failure));
}

#[test]
fn without_a_chart_it_is_off_and_with_a_bad_one_only_an_operator_may_steer() {
    let mut sea = Sea::new().ready();
    sea.run(11.0);
    assert!(state(&sea, Entity::Grounding).description.to_str_lossy().contains("off: no chart"));
    let bad = Chart::read("chart.lutra-index", b"no chart");
    assert!(matches!(bad, Chart::Unreadable { .. }));
    let mut sea = Sea::with(with_chart(bad.clone()), |_| {}).ready();
    sea.run(11.0);
    let told = state(&sea, Entity::Grounding);
    assert_eq!(told.state, EntityStateState::Error);
    assert!(told.description.to_str_lossy().contains("chart.lutra-index"), "{}", told.description);
    // Without a reason nothing is armed at all, with one still no plan.
    for armed in [false, true] {
        if armed {
            sea.override_preflight("back to the quay by hand");
        }
        let request = sea.ask(PlanControlOp::Start, "triangle", Some(triangle().into()));
        sea.run(0.5);
        let reply = sea.replies(request).pop().unwrap();
        assert_eq!(reply.r#type, PlanControlType::Failure);
        let info = reply.info.to_str_lossy();
        assert!(info.contains("cannot be read") && info.contains("not armed") != armed, "{info}");
    }
    let request = sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(0.5);
    assert!(sea.replies(request).iter().all(|reply| reply.r#type != PlanControlType::Failure));
    let mut lenient = with_chart(bad);
    lenient.grounding.refuses_without = false;
    let mut sea = Sea::with(lenient, |_| {}).ready();
    let request = sea.ask(PlanControlOp::Start, "triangle", Some(triangle().into()));
    sea.run(0.5);
    assert!(sea.replies(request).iter().all(|reply| reply.r#type != PlanControlType::Failure));
    assert!(says(&sea, Entity::Grounding, "not held against the sea chart"));
}

/// Full ahead for so many seconds; answers the least distance of the hull's middle to a point.
fn full_ahead(sea: &mut Sea, seconds: f64, from: LocalPoint) -> f64 {
    ahead(sea, 127, seconds, from)
}

/// The same with a throttle of 127.
fn ahead(sea: &mut Sea, throttle: i8, seconds: f64, from: LocalPoint) -> f64 {
    let mut nearest_m = f64::INFINITY;
    for _ in 0..(seconds / 0.2) as u32 {
        sea.send(RemoteActions { actions: format!("Throttle={throttle}").into() });
        sea.run(0.2);
        nearest_m = nearest_m.min(sea.position().distance_m(from));
    }
    nearest_m
}

fn steer(sea: &mut Sea) {
    sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(1.0);
    sea.send(RemoteActions { actions: "Throttle=0".into() });
    sea.run(0.2);
}

#[test]
fn an_operators_thrust_towards_land_is_blocked_and_away_is_not() {
    let mut sea = afloat(&islet());
    steer(&mut sea);
    let nearest_m = full_ahead(&mut sea, 200.0, point(200.0, 0.0));
    assert!(nearest_m > 61.2, "{nearest_m}");
    assert!(nearest_m < 90.0, "it may come near: {nearest_m}");
    assert!(sea.position().north_m > 100.0, "{:?}", sea.position());
    sea.run(0.5);
    assert!(state(&sea, Entity::Grounding).description.to_str_lossy().contains("blocked"));
    let before_m = sea.position().north_m;
    for _ in 0..50 {
        sea.send(RemoteActions { actions: "Throttle=-127".into() });
        sea.run(0.2);
    }
    assert!(sea.position().north_m < before_m - 5.0, "{before_m} {:?}", sea.position());
}

/// However slow it is: blocked thrust comes before the vessel is taken out of the operator's hands.
#[test]
fn a_slow_operator_is_blocked_and_keeps_the_vessel() {
    for throttle in [30, 40, 60, 90] {
        let mut sea = afloat(&islet());
        steer(&mut sea);
        full_ahead(&mut sea, 30.0, point(200.0, 0.0));
        let nearest_m = ahead(&mut sea, throttle, 600.0, point(200.0, 0.0));
        assert!((61.2..75.0).contains(&nearest_m), "{throttle}: {nearest_m}");
        assert!(state(&sea, Entity::Grounding).description.to_str_lossy().contains("blocked"), "{throttle}");
        assert!(!says(&sea, Entity::Grounding, "back to deep water"), "{throttle}");
        assert_eq!(sea.plan_state().plan_id, "hand", "{throttle}");
    }
}

/// Land 3 m ahead of a vessel at a quay, where the position's uncertainty touches it.
#[test]
fn a_vessel_at_a_quay_is_its_operators_and_never_starts_by_itself() {
    let chart = chartmaker().with(Ground::Land, point(40.0, 0.0), 36.5, 48);
    let settings = with_chart(Chart::of("made up", chart.index()));
    let mut sea = Sea::with(settings, |vessel| {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (0.1, 0.0);
    })
    .ready();
    steer(&mut sea);
    for _ in 0..15 {
        sea.send(RemoteActions { actions: "Throttle=0".into() });
        sea.run(0.2);
    }
    assert!(!says(&sea, Entity::Grounding, "back to deep water"));
    assert_eq!(sea.plan_state().plan_id, "hand");
    // Away it goes; and once it was clear it is not let drift back in.
    for _ in 0..200 {
        sea.send(RemoteActions { actions: "Throttle=-100".into() });
        sea.run(0.2);
    }
    assert!(sea.position().north_m < -20.0, "{:?}", sea.position());
    assert!(!says(&sea, Entity::Grounding, "back to deep water"));
    sea.run(600.0);
    assert!(says(&sea, Entity::Grounding, "back to deep water"));
}

/// Whatever the motors do that is not towards danger, and however fast the water is.
#[test]
fn a_current_along_the_hull_is_no_way_of_the_operators() {
    for (current_mps, throttle) in [(0.6, -8), (0.6, 0), (0.9, -8), (1.2, 0)] {
        let chart = chartmaker().with(Ground::Depth(0.4), point(200.0, 0.0), 60.0, 48);
        let settings = with_chart(Chart::of("made up", chart.index()));
        let mut sea = Sea::with(settings, |vessel| {
            (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (current_mps, 0.0);
        })
        .ready();
        steer(&mut sea);
        let nearest_m = ahead(&mut sea, throttle, 300.0, point(200.0, 0.0));
        assert!(nearest_m > 61.2, "{current_mps} m/s, {throttle}: {nearest_m}");
        assert!(says(&sea, Entity::Grounding, "back to deep water"), "{current_mps} m/s, {throttle}");
    }
}

fn parameter(sea: &mut Sea, name: &str, value: &str) {
    let wanted = EntityParameter { name: name.into(), value: value.into() };
    let params = [wanted].into_iter().collect();
    sea.send(SetEntityParameters { name: "Grounding Supervisor".into(), params });
    sea.run(0.2);
}

#[test]
fn a_confirmed_exemption_lets_an_operator_go_on_and_ends() {
    let mut sea = afloat(&islet());
    steer(&mut sea);
    parameter(&mut sea, "Override Request", "300");
    assert!(says(&sea, Entity::Grounding, "asks to steer unguarded"));
    parameter(&mut sea, "Override Confirmation", "300");
    assert!(says(&sea, Entity::Grounding, "steers unguarded by the sea chart for 300 s"));
    let nearest_m = full_ahead(&mut sea, 150.0, point(200.0, 0.0));
    assert!(nearest_m < 55.0, "{nearest_m}");
    parameter(&mut sea, "Override Request", "0");
    assert!(says(&sea, Entity::Grounding, "ends the exemption"));
    // Safety parameters cannot be changed over the bus.
    parameter(&mut sea, "Autonomous Depth", "0.5");
    assert!(says(&sea, Entity::Grounding, "configuration file"));
}

#[test]
fn a_current_onto_a_shoal_makes_a_silent_operators_vessel_turn_back() {
    let chart = chartmaker().with(Ground::Depth(0.4), point(60.0, 0.0), 30.0, 24);
    let settings = with_chart(Chart::of("made up", chart.index()));
    let mut sea = Sea::with(settings, |vessel| {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (0.3, 0.0);
    })
    .ready();
    steer(&mut sea);
    let mut nearest_m = f64::INFINITY;
    for _ in 0..600 {
        sea.run(0.5);
        nearest_m = nearest_m.min(sea.position().distance_m(point(60.0, 0.0)));
    }
    assert!(nearest_m > 31.2, "{nearest_m}");
    assert!(says(&sea, Entity::Grounding, "back to deep water"));
    assert_eq!(sea.plan_state().plan_id, "deep water");
}

/// So slowly that there is no course, and for long.
#[test]
fn a_vessel_that_lies_at_its_operators_hand_does_not_creep_onto_a_shoal() {
    let chart = chartmaker().with(Ground::Depth(0.4), point(60.0, 0.0), 30.0, 24);
    let settings = with_chart(Chart::of("made up", chart.index()));
    let mut sea = Sea::with(settings, |vessel| {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (0.04, 0.0);
    })
    .ready();
    steer(&mut sea);
    full_ahead(&mut sea, 60.0, point(60.0, 0.0));
    sea.send(RemoteActions { actions: "Throttle=0".into() });
    let lay_m = sea.position().distance_m(point(60.0, 0.0));
    let mut nearest_m = f64::INFINITY;
    for _ in 0..800 {
        sea.run(0.5);
        nearest_m = nearest_m.min(sea.position().distance_m(point(60.0, 0.0)));
    }
    assert!(lay_m < 45.0, "it lay close: {lay_m}");
    // Shoal, hull and the position's uncertainty.
    assert!(nearest_m > 30.0 + 1.2 + 3.0, "{nearest_m}");
    assert!(says(&sea, Entity::Grounding, "it lies close to danger and drifts closer: back to deep water"));
}

/// The plan is in deep water but a reference leads elsewhere: what is not known beforehand is checked when it comes.
#[test]
fn a_reference_towards_land_is_refused_before_the_vessel_sets_out() {
    let mut sea = afloat(&islet());
    let follow =
        FollowReference { control_src: 0xFFFF, control_ent: 0xFF, timeout: 60.0, ..Default::default() };
    sea.ask(PlanControlOp::Start, "follow", Some(follow.into()));
    sea.run(1.0);
    let target = place(200.0, 0.0);
    let mut nearest_m = f64::INFINITY;
    for _ in 0..300 {
        let reference = Reference {
            flags: ReferenceFlags::LOCATION | ReferenceFlags::SPEED,
            lat: target.lat_rad(),
            lon: target.lon_rad(),
            speed: DesiredSpeed { value: 1.5, speed_units: SpeedUnits::MetersPs }.into(),
            ..Reference::default()
        };
        sea.send(reference);
        sea.run(1.0);
        nearest_m = nearest_m.min(sea.position().distance_m(point(200.0, 0.0)));
    }
    assert!(nearest_m > 190.0, "it did not set out: {nearest_m}");
    assert_eq!(sea.plan_state().plan_id, "follow", "it waits for another");
    let told = sea.all::<LogBookEntry>();
    let refused = told.iter().filter(|(_, entry)| {
        let text = entry.text.to_str_lossy();
        text.contains("a reference is refused, it waits: ") && text.contains("land")
    });
    assert_eq!(refused.count(), 1);
}

fn came(chart: &Chartmaker) -> Input {
    let Chart::Loaded(file) = Chart::of("chart.lutra-index", chart.index()) else { panic!() };
    Input::Chart(file)
}

#[test]
fn a_plan_under_way_is_held_against_a_chart_that_comes_and_the_vessel_acts_by_it() {
    let mut sea = afloat(&chartmaker());
    let request = sea.ask(PlanControlOp::Start, "through", Some(through().into()));
    sea.run(20.0);
    assert!(sea.replies(request).iter().all(|reply| reply.r#type != PlanControlType::Failure));
    assert!(sea.position().north_m > 5.0, "{:?}", sea.position());
    assert_eq!(state(&sea, Entity::Grounding).state, EntityStateState::Normal);

    sea.tell(came(&islet()));
    sea.run(1.0);
    assert_eq!(sea.vehicle.brain.chart(), &Chart::of("chart.lutra-index", islet().index()));
    assert!(says(&sea, Entity::Grounding, "'through' would be refused"));
    let told = state(&sea, Entity::Grounding);
    assert_eq!(told.state, EntityStateState::Fault, "{}", told.description);
    assert!(told.description.to_str_lossy().contains("turns back before danger"), "{}", told.description);
    assert_eq!(sea.mode(), VehicleStateOpMode::Maneuver, "the danger is far away: it goes on");

    let mut nearest_m = f64::INFINITY;
    for _ in 0..400 {
        sea.run(0.5);
        nearest_m = nearest_m.min(sea.position().distance_m(point(200.0, 0.0)));
    }
    assert!((61.2..120.0).contains(&nearest_m), "{nearest_m}");
    assert!(says(&sea, Entity::Grounding, "back to deep water"));
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(30.0);
    let told = state(&sea, Entity::Grounding).description.to_str_lossy().into_owned();
    assert!(!told.contains("would be refused"), "it ends with its plan: {told}");
}

#[test]
fn a_chart_of_somewhere_else_waits_until_the_vessel_rests() {
    let far = LatLon::from_deg(59.0, 5.0).unwrap();
    let elsewhere = Chartmaker::new(far, 500.0, 20.0);
    let mut sea = afloat(&chartmaker());
    let before = sea.vehicle.brain.chart().clone();
    sea.ask(PlanControlOp::Start, "through", Some(through().into()));
    sea.run(10.0);
    sea.tell(came(&elsewhere));
    sea.run(30.0);
    assert_eq!(sea.vehicle.brain.chart(), &before);
    assert!(sea.vehicle.brain.chart_waits().is_some_and(|why| why.contains("no data where the vessel is")));
    assert!(says(&sea, Entity::Grounding, "came and waits"));
    assert_eq!(sea.mode(), VehicleStateOpMode::Maneuver);
    sea.ask(PlanControlOp::Stop, "", None);
    sea.run(2.0);
    assert_eq!(sea.vehicle.brain.chart(), &Chart::of("chart.lutra-index", elsewhere.index()));
    assert_eq!(sea.vehicle.brain.chart_waits(), None);
    // The same again changes nothing; another is in force at once, as the vessel rests.
    sea.tell(came(&elsewhere));
    sea.tell(came(&islet()));
    sea.run(0.5);
    assert_eq!(sea.vehicle.brain.chart(), &Chart::of("chart.lutra-index", islet().index()));
}

#[test]
fn a_vessel_without_a_chart_is_guarded_by_one_that_comes_where_it_has_data() {
    let elsewhere = Chartmaker::new(LatLon::from_deg(59.0, 5.0).unwrap(), 500.0, 20.0);
    let mut sea = Sea::new();
    sea.tell(came(&elsewhere));
    assert!(sea.vehicle.brain.chart_waits().is_some_and(|why| why.contains("is not known yet")));
    let mut sea = sea.ready();
    sea.run(11.0);
    assert_eq!(sea.vehicle.brain.chart(), &Chart::Off);
    let told = state(&sea, Entity::Grounding);
    assert_eq!(told.state, EntityStateState::Normal);
    assert!(
        told.description.to_str_lossy().contains("has no data where the vessel is"),
        "{}",
        told.description
    );
    sea.tell(came(&islet()));
    assert_eq!(sea.vehicle.brain.chart(), &Chart::of("chart.lutra-index", islet().index()));
    assert_eq!(sea.vehicle.brain.chart_waits(), None);
}
