//! Routes of the planner, sailed in wind and current by the simulated Otter.
//!
//! Start and goal are anywhere in the archipelago's harbour cell. What the planner finds with the guard's own demands is
//! accepted aboard, sailed to its end without a remedy, and the hull stays clear of all that the route keeps clear of but for
//! what it may stray from its track.

use super::archipelago::{EAST_M, Known, NORTH_M, known};
use crate::common::*;
use charts::demo::SeaFloor;
use guard::{GuardLimits, check_way};
use imc::messages::*;
use mission::{LostCommsConfig, Remedy, Step};
use onboard::{GroundingSettings, Settings};
use planner::{Cancel, Needs, Refusal, Request, Route, Router};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use testkit::Numbers;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime};

/// Clearance of the routes (m).
const CLEARANCE_M: f64 = 25.0;
/// Turning radius that they are planned for (m).
const TURN_RADIUS_M: f64 = 8.0;
const SPEED_MPS: f64 = 1.5;

/// The result of a route.
#[derive(Debug)]
struct Sailed {
    length_m: f64,
    legs: usize,
    /// Farthest from the route (m).
    strayed_m: f64,
    /// Nearest to land, a danger or shallow water (m).
    nearest_m: f64,
    /// The failure; empty if none.
    wrong: String,
}

fn router() -> &'static Router {
    static ROUTER: OnceLock<Router> = OnceLock::new();
    ROUTER.get_or_init(|| Router::new(Arc::new(known().index.clone())))
}

fn place_in_harbour(numbers: &mut Numbers) -> LatLon {
    let middle = LocalFrame::new(SeaFloor::ORIGIN.place().unwrap());
    let north_m = numbers.within(NORTH_M[0], NORTH_M[1]);
    middle.to_place(LocalPoint { north_m, east_m: numbers.within(EAST_M[0], EAST_M[1]) })
}

/// A route between two random places; another pair is taken if they have no route.
fn route(numbers: &mut Numbers, limits: &GuardLimits) -> Route {
    let needs = Needs { demand: limits.demand(limits.autonomous_m), clearance_m: CLEARANCE_M };
    loop {
        let (from, to) = (place_in_harbour(numbers), place_in_harbour(numbers));
        let request = Request { turn_radius_m: Some(TURN_RADIUS_M), ..Request::new(from, to) };
        match router().route(&request, &needs, &Cancel::never()) {
            Ok(route) if route.length_m > 300.0 => return route,
            Ok(_) | Err(Refusal::Closed { .. } | Refusal::NoWay { .. }) => {}
            Err(other) => panic!("{from:?} to {to:?}: {other}"),
        }
    }
}

fn distance_to_leg_m(at: LocalPoint, from: LocalPoint, to: LocalPoint) -> f64 {
    let (north_m, east_m) = (to.north_m - from.north_m, to.east_m - from.east_m);
    let along = (at.north_m - from.north_m) * north_m + (at.east_m - from.east_m) * east_m;
    let share = (along / (north_m.powi(2) + east_m.powi(2)).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    at.distance_m(LocalPoint {
        north_m: from.north_m + share * north_m,
        east_m: from.east_m + share * east_m,
    })
}

fn sailed(seed: u64) -> Sailed {
    let mut numbers = Numbers(0x9E37_79B9_7F4A_7C15 ^ (seed + 1).wrapping_mul(0x2545_F491_4F6C_DD1D));
    for _ in 0..8 {
        numbers.within(0.0, 1.0);
    }
    let Known { chart, index, .. } = known();
    let grounding = GroundingSettings { chart: chart.clone(), ..GroundingSettings::default() };
    let limits = grounding.limits;
    let route = route(&mut numbers, &limits);
    let frame = LocalFrame::new(route.start);
    let corners: Vec<LocalPoint> = route.places().map(|place| frame.to_local(place)).collect();
    let current = (numbers.within(0.0, 0.3), numbers.within(0.0, TAU));
    let wind = (numbers.within(0.0, 8.0), numbers.within(0.0, TAU));
    let mut sea = Sea::with(Settings { grounding, ..settings() }, |vessel| {
        vessel.start_place = route.start;
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = current;
        (vessel.environment.wind.speed_mps, vessel.environment.wind.from_rad) = wind;
    })
    .ready();
    let mut sailed = Sailed {
        length_m: route.length_m,
        legs: route.legs.len(),
        strayed_m: 0.0,
        nearest_m: f64::INFINITY,
        wrong: String::new(),
    };
    let legs = route.legs.iter().enumerate().map(|(number, leg)| {
        let to = Goto { lat: leg.to.lat_rad(), lon: leg.to.lon_rad(), ..goto(0.0, 0.0, SPEED_MPS as f32) };
        (format!("leg {number}"), to.into())
    });
    let request = sea.ask(PlanControlOp::Start, "route", Some(plan("route", legs.collect()).into()));
    sea.run(0.5);
    if let Some(reply) = sea.replies(request).iter().find(|reply| reply.r#type == PlanControlType::Failure) {
        sailed.wrong = format!("refused: {}", reply.info);
        return sailed;
    }
    let least_s = route.length_m / SPEED_MPS;
    for _ in 0..(3.0 * least_s + 200.0) as u32 {
        sea.run(1.0);
        let at = sea.position();
        let beside = corners.windows(2).map(|leg| distance_to_leg_m(at, leg[0], leg[1]));
        sailed.strayed_m = beside.fold(f64::INFINITY, f64::min).max(sailed.strayed_m);
        let near = index.distance_to_shallower(frame.to_place(at), limits.autonomous_m, 2.0 * CLEARANCE_M);
        sailed.nearest_m = near.map_or(f64::INFINITY, |near| near.distance_m).min(sailed.nearest_m);
        let state = sea.plan_state();
        if state.state != PlanControlStateState::Executing
            && state.last_outcome != PlanControlStateLastOutcome::None
        {
            if state.last_outcome != PlanControlStateLastOutcome::Success {
                sailed.wrong = format!("ended by {:?}", state.last_outcome);
            }
            return sailed;
        }
    }
    "it never ended".clone_into(&mut sailed.wrong);
    sailed
}

fn sail(seeds: Range<u64>) {
    let all: Vec<Sailed> = seeds.clone().map(sailed).collect();
    let most = |of: &dyn Fn(&Sailed) -> f64| all.iter().map(of).fold(0.0, f64::max);
    let nearest_m = all.iter().map(|one| one.nearest_m).fold(f64::INFINITY, f64::min);
    println!(
        "{} routes, {:.1} km, {} legs: at most {:.1} m beside the route, never nearer than {nearest_m:.1} m to what it keeps {CLEARANCE_M} m clear of",
        all.len(),
        all.iter().map(|one| one.length_m).sum::<f64>() / 1e3,
        all.iter().map(|one| one.legs).sum::<usize>(),
        most(&|one| one.strayed_m),
    );
    let limits = GuardLimits::default();
    let may_m = limits.cross_track_m;
    for (seed, one) in seeds.zip(&all) {
        assert!(one.wrong.is_empty(), "{seed}: {one:?}");
        let is_clear = one.strayed_m <= may_m && one.nearest_m >= CLEARANCE_M - may_m;
        assert!(is_clear, "{seed}: {one:?}: it may stray {may_m} m");
    }
}

/// Takes some seconds: four routes of 7 km together, over an hour at sea, in steps of the control loop.
#[test]
fn some_routes_are_sailed_without_entering_their_margins() {
    sail(0..4);
}

#[test]
#[ignore = "minutes; run it optimised as the head of this folder's mod.rs says"]
fn a_hundred_routes_are_sailed_without_entering_their_margins() {
    sail(0..100);
}

/// Contact is lost while an operator steers, and home lies behind the archipelago's land. Takes some seconds: a
/// quarter of an hour at sea.
#[test]
fn a_return_over_the_demonstrations_chart_keeps_out_of_all_margins() {
    let Known { chart, index, .. } = known();
    let grounding = GroundingSettings { chart: chart.clone(), ..GroundingSettings::default() };
    let limits = grounding.limits;
    let mut numbers = Numbers(11);
    let way = loop {
        let way = route(&mut numbers, &limits);
        let straight = check_way("straight", way.start, way.goal(), index, &limits);
        if straight.reason.is_some() && (500.0..1_200.0).contains(&way.length_m) {
            break way;
        }
    };
    let remedy = Remedy::Run { plan_id: "home".to_owned() };
    let ladder = vec![Step { after: Duration::from_secs(20), remedy }];
    let mut wanting = Settings { grounding, ..settings() };
    wanting.watch.lost_comms = LostCommsConfig { teleoperation: ladder, ..LostCommsConfig::default() };
    let mut sea = Sea::with(wanting, |vessel| {
        vessel.start_place = way.start;
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (0.2, 1.0);
        (vessel.environment.wind.speed_mps, vessel.environment.wind.from_rad) = (6.0, 4.0);
    })
    .ready();
    let goal = way.goal();
    let berth = Goto { lat: goal.lat_rad(), lon: goal.lon_rad(), ..goto(0.0, 0.0, SPEED_MPS as f32) };
    sea.upload(&plan("home", vec![("berth".to_owned(), berth.into())]));
    sea.ask(PlanControlOp::Start, "hand", Some(Teleoperation::default().into()));
    sea.run(1.0);
    sea.heartbeats = false;
    let returns = |sea: &Sea| {
        sea.plan_state().plan_id == "home" && sea.plan_state().state == PlanControlStateState::Executing
    };
    assert!(sea.run_until(40.0, returns), "{:?}", sea.plan_state());
    let told = sea.all::<LogBookEntry>();
    assert!(told.iter().any(|(_, entry)| entry.text.to_str_lossy().contains("returning by a route of")));
    let frame = LocalFrame::new(way.start);
    // Its clearance, without the allowed stray; the start may lie as near as the guard lets it.
    let least_m = limits.hull_m + limits.position_m;
    while returns(&sea) {
        sea.run(1.0);
        let near = index.distance_to_shallower(frame.to_place(sea.position()), limits.autonomous_m, 60.0);
        assert!(near.is_none_or(|near| near.distance_m > least_m), "{:?} {near:?}", sea.position());
        assert!(sea.vehicle.now.mono < MonoTime::from_micros(3_600_000_000), "it never arrives");
    }
    assert_eq!(sea.plan_state().last_outcome, PlanControlStateLastOutcome::Success);
    assert!(sea.position().distance_m(frame.to_local(goal)) < 30.0, "{:?}", sea.position());
}
