//! Lanes and zones of ordered traffic: gone round where that is not far, crossed the short way else.

use crate::waters::{at, is_safe, local, open_sea, place, router};
use charts::depth_index::Leg;
use planner::{
    Cancel, InTraffic, Needs, Objective, Power, Request, Route, Router, TrafficArea, TrafficKind, Zone,
};
use units::LocalPoint;

fn needs() -> Needs {
    Needs::depth_and_clearance(5.0, 10.0)
}

/// A lane to the north, 300 m wide, from 1500 m south to 1500 m north of the middle.
fn lane() -> TrafficArea {
    let corners = [(-1_500.0, -150.0), (-1_500.0, 150.0), (1_500.0, 150.0), (1_500.0, -150.0)];
    let zone = Zone::new(corners.map(|(north_m, east_m)| place(at(north_m, east_m))).to_vec()).unwrap();
    TrafficArea { zone, kind: TrafficKind::Lane, towards_rad: Some(0.0) }
}

fn objective(area: TrafficArea, traffic_factor: f64) -> Objective {
    let power = Power::new(|_| None);
    Objective { traffic: vec![area], traffic_factor, ..Objective::shortest(1.5, power) }
}

fn ask(router: &Router, objective: &Objective, from: LocalPoint, to: LocalPoint) -> Route {
    let request = Request { move_up_to_m: 0.0, ..Request::new(place(from), place(to)) };
    let router = router.by_objective(objective.clone()).unwrap();
    let route = router.route(&request, &needs(), &Cancel::never()).unwrap();
    assert!(is_safe(&route, router.index(), &needs()));
    route
}

/// How far a route leads within the lane (m), and how much of that to the south, by small steps.
fn within_m(route: &Route) -> (f64, f64) {
    let places: Vec<LocalPoint> = route.places().map(local).collect();
    let (mut all_m, mut south_m) = (0.0, 0.0);
    for leg in places.windows(2) {
        let length_m = leg[0].distance_m(leg[1]);
        let steps = length_m.ceil().max(1.0);
        for step in 0..steps as u32 {
            let share = (f64::from(step) + 0.5) / steps;
            let north_m = leg[0].north_m + share * (leg[1].north_m - leg[0].north_m);
            let east_m = leg[0].east_m + share * (leg[1].east_m - leg[0].east_m);
            if north_m.abs() < 1_500.0 && east_m.abs() < 150.0 {
                all_m += length_m / steps;
                if leg[0].north_m - leg[1].north_m > 0.5 * length_m {
                    south_m += length_m / steps;
                }
            }
        }
    }
    (all_m, south_m)
}

#[test]
fn a_route_that_leads_along_a_lane_keeps_beside_it() {
    let router = router(&open_sea());
    let (south, north) = (at(-1_400.0, 0.0), at(1_400.0, 0.0));
    let route = ask(&router, &objective(lane(), 3.0), south, north);
    let (within, _) = within_m(&route);
    // Both ends lie 150 m within. The best way leaves the lane where each metre to the side saves three along it: at an angle
    // whose cosine is a third, 159.1 m to either border, and 2693.9 m beside it.
    assert!(
        (within - 318.2).abs() < 10.0 && (route.length_m - 3_012.1).abs() < 10.0,
        "{within} of {} m",
        route.length_m
    );
    let direct = route.shortest.expect("it stands beside");
    assert!((direct.length_m - 2_800.0).abs() < 5.0);
    // Where traffic is not minded there is that way alone, and its leg says what it meets.
    let careless = objective(lane(), 1.0);
    let straight = ask(&router, &careless, south, north);
    assert!(straight.shortest.is_none() && (straight.length_m - direct.length_m).abs() < 1e-6);
    let met = |objective: &Objective, route: &Route| route.reckon(objective)[0].traffic;
    let lane_met = |against| Some(InTraffic { kind: TrafficKind::Lane, against });
    assert_eq!(met(&careless, &straight), lane_met(false));
    assert_eq!(met(&careless, &ask(&router, &careless, north, south)), lane_met(true));
}

#[test]
fn a_lane_is_crossed_the_short_way_and_least_of_all_entered_against_its_direction() {
    let router = router(&open_sea());
    let minded = objective(lane(), 3.0);
    // Straight across there is nothing to gain.
    let across = ask(&router, &minded, at(0.0, -1_000.0), at(0.0, 1_000.0));
    assert!((across.length_m - 2_000.0).abs() < 1.0 && across.shortest.is_none(), "{}", across.length_m);
    assert_eq!(
        across.reckon(&minded)[0].traffic,
        Some(InTraffic { kind: TrafficKind::Lane, against: false })
    );
    // Aslant, it is crossed more nearly at a right angle than straight on.
    let aslant = ask(&router, &minded, at(-1_000.0, -400.0), at(1_000.0, 400.0));
    let direct = aslant.shortest.as_ref().expect("another one than the shortest");
    assert!(within_m(&aslant).0 < 0.6 * within_m(direct).0, "{:?} {:?}", within_m(&aslant), within_m(direct));
    // From one place within to another: with the lane it is worth while to stay, against it the way leaves it.
    let (low, high) = (at(-100.0, 0.0), at(100.0, 0.0));
    assert!(within_m(&ask(&router, &objective(lane(), 1.5), low, high)).0 > 190.0);
    let against = ask(&router, &objective(lane(), 20.0), at(500.0, 140.0), at(-500.0, 140.0));
    assert!(within_m(&against).1 < 100.0, "{:?}", within_m(&against));
}

#[test]
fn a_route_out_of_all_traffic_is_the_shortest_one() {
    let router = router(&open_sea());
    let plain = ask(&router, &objective(lane(), 1.0), at(-1_800.0, 400.0), at(1_800.0, 500.0));
    let minded = ask(&router, &objective(lane(), 3.0), at(-1_800.0, 400.0), at(1_800.0, 500.0));
    assert_eq!((plain.legs.len(), minded.shortest.is_none()), (minded.legs.len(), true));
    assert!((plain.length_m - minded.length_m).abs() < 1e-9);
    let leg = minded.legs.first().map(|leg| Leg { from: leg.from, to: leg.to }).unwrap();
    assert!((leg.length_m() - minded.length_m).abs() < 1.0, "one leg");
    for (factor, what) in [(0.5, "factor of traffic"), (f64::NAN, "factor of traffic")] {
        let error = router.by_objective(objective(lane(), factor)).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let many = Objective { traffic: vec![lane(); 201], ..objective(lane(), 3.0) };
    assert!(router.by_objective(many).unwrap_err().to_string().contains("number of traffic areas"));
}
