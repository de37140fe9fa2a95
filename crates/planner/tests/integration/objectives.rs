//! Routes by time, energy and preferred water, against the best ways found without the planner.

use crate::waters::{HALF_M, at, is_safe, local, open_sea, place, point, router, sea, shoals};
use charts::depth_index::{DepthIndex, Leg};
use planner::{
    Aim, Cancel, CurrentGrid, Currents, Flow, LegCost, Needs, Objective, PlanError, Power, Preferences,
    Refusal, Request, Route, Router, SpeedLimit, Zone,
};
use proptest::prelude::*;
use std::cell::Cell;
use std::f64::consts::{FRAC_PI_2, PI};
use testkit::sea::{Ground, Sea};
use units::LocalPoint;

const MPS: f64 = 1.5;

fn needs() -> Needs {
    Needs::depth_and_clearance(5.0, 10.0)
}

/// The power of a vessel that takes 30 W at rest and more with the cube of its speed.
fn power_w(mps: f64) -> f64 {
    30.0 + 60.0 * mps.powi(3)
}

fn still(aim: Aim) -> Objective {
    Objective { aim, ..Objective::shortest(MPS, Power::new(|mps| Some(power_w(mps)))) }
}

fn ask(router: &Router, objective: &Objective, from: LocalPoint, to: LocalPoint) -> Route {
    let request = Request { move_up_to_m: 0.0, ..Request::new(place(from), place(to)) };
    let router = router.by_objective(objective.clone()).unwrap();
    router.route(&request, &needs(), &Cancel::never()).unwrap()
}

fn costs(objective: &Objective, route: &Route) -> Vec<LegCost> {
    route.reckon(objective)
}

fn duration_s(objective: &Objective, route: &Route) -> f64 {
    costs(objective, route).iter().map(|leg| leg.duration_s.unwrap()).sum()
}

fn energy_j(objective: &Objective, route: &Route) -> f64 {
    costs(objective, route).iter().map(|leg| leg.energy_j.unwrap()).sum()
}

/// A grid of currents over the sea, of so many points each way, by metres north and east and by time.
fn field(points: u32, times_s: &[f64], current: impl Fn(f64, f64, f64) -> Flow) -> CurrentGrid {
    let reach_m = 1.2 * HALF_M;
    let along = |n: u32| -reach_m + 2.0 * reach_m * f64::from(n) / f64::from(points - 1);
    let lats: Vec<f64> = (0..points).map(|n| place(at(along(n), 0.0)).lat_deg()).collect();
    let lons: Vec<f64> = (0..points).map(|n| place(at(0.0, along(n))).lon_deg()).collect();
    let (mut east, mut north) = (Vec::new(), Vec::new());
    for time_s in times_s {
        for row in 0..points {
            for column in 0..points {
                let flow = current(along(row), along(column), *time_s);
                east.push(flow.east_mps as f32);
                north.push(flow.north_mps as f32);
            }
        }
    }
    CurrentGrid::new(times_s.to_vec(), lats, lons, &east, &north).unwrap()
}

/// To the east, strongest 400 m north of the middle.
fn jet(north_m: f64, drift_mps: f64) -> Flow {
    Flow { east_mps: drift_mps * (-((north_m - 400.0) / 250.0).powi(2)).exp(), north_mps: 0.0 }
}

/// Speed over ground by the vector triangle: the heading through the water is what is left of the course made good.
fn over_ground_mps(flow: Flow, from: LocalPoint, to: LocalPoint) -> f64 {
    let length_m = from.distance_m(to);
    let (n, e) = ((to.north_m - from.north_m) / length_m, (to.east_m - from.east_m) / length_m);
    let along = flow.north_mps * n + flow.east_mps * e;
    let square = MPS * MPS - flow.drift_mps().powi(2) + along * along;
    along + square.sqrt()
}

#[test]
fn in_the_same_current_everywhere_the_straight_way_is_the_fastest() {
    let router = router(&open_sea());
    for set_rad in [0.0, 1.0, FRAC_PI_2, PI] {
        let currents = Currents::Steady(Flow::set_and_drift(set_rad, 0.9));
        let objective = Objective { currents, ..still(Aim::Time) };
        let route = ask(&router, &objective, at(-300.0, -1_500.0), at(500.0, 1_500.0));
        assert!(route.shortest.is_none() && route.legs.len() == 1, "{:?}", route.legs.len());
        let along = Flow::set_and_drift(set_rad, 0.9);
        let expected_s = route.length_m / over_ground_mps(along, at(-300.0, -1_500.0), at(500.0, 1_500.0));
        let found_s = duration_s(&objective, &route);
        assert!((found_s / expected_s - 1.0).abs() < 1e-3, "{found_s} {expected_s}");
    }
}

/// The least time from west to east by lines between columns 100 m apart, of points 20 m apart: every one is tried.
fn brute_force_s(grid: &CurrentGrid, west_m: f64, east_m: f64) -> f64 {
    let rows: Vec<f64> = (0..60).map(|row| -200.0 + 20.0 * f64::from(row)).collect();
    let columns = ((east_m - west_m) / 100.0).round() as u32;
    let start = rows.iter().map(|row| if *row == 0.0 { 0.0 } else { f64::INFINITY });
    let mut best_s: Vec<f64> = start.collect();
    for column in 0..columns {
        let (x, next_x) = (west_m + 100.0 * f64::from(column), west_m + 100.0 * f64::from(column + 1));
        let to = |to_row: f64| {
            let by = rows.iter().zip(&best_s).filter(|(_, held_s)| held_s.is_finite());
            let each = by.map(|(from_row, held_s)| {
                let (from, to) = (at(*from_row, x), at(to_row, next_x));
                let piece_m = from.distance_m(to) / 4.0;
                let pieces_s = (0..4).map(|piece| {
                    let share = (f64::from(piece) + 0.5) / 4.0;
                    let here = at(from.north_m + (to.north_m - from.north_m) * share, x + 100.0 * share);
                    piece_m / over_ground_mps(grid.at(place(here), 0.0).unwrap(), from, to)
                });
                held_s + pieces_s.sum::<f64>()
            });
            each.fold(f64::INFINITY, f64::min)
        };
        best_s = rows.iter().map(|row| to(*row)).collect();
    }
    best_s[10]
}

#[test]
fn a_jet_is_taken_as_well_as_brute_force_takes_it_and_the_stream_is_avoided_the_other_way() {
    let grid = field(33, &[0.0], |north_m, _, _| jet(north_m, 1.0));
    let objective = Objective { currents: Currents::Grid(grid.clone()), ..still(Aim::Time) };
    let router = router(&open_sea());
    let (west, east) = (at(0.0, -1_700.0), at(0.0, 1_700.0));
    let route = ask(&router, &objective, west, east);
    let shortest = route.shortest.as_deref().unwrap();
    let (found_s, straight_s) = (duration_s(&objective, &route), duration_s(&objective, shortest));
    let best_s = brute_force_s(&grid, -1_700.0, 1_700.0);
    assert!(best_s < 0.9 * straight_s, "{best_s} {straight_s}");
    // Both are near the best way: brute force from above, by its steps.
    assert!(
        (0.985..1.005).contains(&(found_s / best_s)),
        "{found_s} s, brute force {best_s} s, straight {straight_s} s"
    );
    let northmost = route.places().map(|place| local(place).north_m).fold(0.0, f64::max);
    assert!((300.0..450.0).contains(&northmost), "{northmost}");
    // Back it keeps south of the jet, and the straight way costs more.
    let back = ask(&router, &objective, east, west);
    assert!(back.places().all(|place| local(place).north_m < 5.0));
    assert!(duration_s(&objective, &back) > found_s);
}

#[test]
fn a_current_that_turns_is_the_one_of_the_moment_and_beyond_its_times_it_is_not_known() {
    let grid = field(9, &[0.0, 7_200.0, 14_400.0], |_, _, time_s| Flow {
        east_mps: 0.5 * (1.0 - time_s / 7_200.0),
        north_mps: 0.0,
    });
    let router = router(&open_sea());
    let at_time = |depart_s: f64| {
        let currents = Currents::Grid(grid.clone());
        let objective = Objective { currents, depart_s, ..still(Aim::Time) };
        let route = ask(&router, &objective, at(0.0, -1_500.0), at(0.0, 1_500.0));
        (costs(&objective, &route), route)
    };
    let duration_s =
        |depart_s: f64| -> Option<f64> { at_time(depart_s).0.iter().map(|leg| leg.duration_s).sum() };
    // dx/dt = 1.5 + 0.5 (1 - t / 7200): x = 2 t - t² / 28800.
    let expected_s = (2.0 - (4.0 - 4.0 * 3_000.0 / 28_800.0_f64).sqrt()) * 14_400.0;
    let found_s = duration_s(0.0).unwrap();
    assert!((found_s / expected_s - 1.0).abs() < 2e-3, "{found_s} {expected_s}");
    assert!(duration_s(7_200.0).unwrap() > found_s + 500.0);
    let (late, route) = at_time(13_000.0);
    assert!(late.iter().any(|leg| leg.duration_s.is_none() && leg.energy_j.is_none()));
    let unknown_m: f64 = late.iter().map(|leg| leg.unknown_m).sum();
    assert!((500.0..route.length_m).contains(&unknown_m), "{unknown_m}");
    let (after, route) = at_time(20_000.0);
    let unknown_m: f64 = after.iter().map(|leg| leg.unknown_m).sum();
    assert!((unknown_m - route.length_m).abs() < 1e-6);
}

/// A round bank, 8 m deep, between start and goal.
fn bank() -> Sea {
    open_sea().with(Ground::Depth(8.0), at(0.0, 0.0), 500.0, 64)
}

/// The length of the shortest way round a circle between two points at the same distance on opposite sides.
fn round_m(radius_m: f64, off_m: f64) -> f64 {
    2.0 * (off_m * off_m - radius_m * radius_m).sqrt() + radius_m * (PI - 2.0 * (radius_m / off_m).acos())
}

#[test]
fn a_bank_is_rounded_where_its_factor_makes_that_cheaper_and_crossed_where_it_does_not() {
    let router = router(&bank());
    let (west, east) = (at(0.0, -1_500.0), at(0.0, 1_500.0));
    let by = |factor: f64| {
        let preferences = Preferences { depth_m: Some(10.0), factor, ..Preferences::default() };
        ask(&router, &Objective { preferences, ..still(Aim::Length) }, west, east)
    };
    let round_m = round_m(500.0, 1_500.0);
    let round = by(3.0);
    assert!((round.length_m / round_m - 1.0).abs() < 0.005, "{} {round_m}", round.length_m);
    assert!(round.legs.iter().all(|leg| leg.worst.water.least_m().unwrap() >= 8.0));
    assert!(round.places().all(|place| local(place).distance_m(at(0.0, 0.0)) > 495.0));
    // 3000 m + 1000 m × 0.05 is less than the way round.
    assert!(round_m > 3_050.0 && round_m < 5_000.0, "{round_m}");
    let across = by(1.05);
    assert!(across.shortest.is_none() && across.legs.len() == 1, "{}", across.legs.len());
    // Where the way round costs a hundredth less than the one across, it is taken, or one that is better than both.
    let between = by(1.2);
    let cost = |route: &Route| preferred_m(route, router.index(), 10.0, 1.2);
    let least = (3_000.0 + 0.2 * 1_000.0_f64).min(round_m);
    assert!(cost(&between) < 1.003 * least, "{} {least}", cost(&between));
}

/// Length with water shallower than a depth counted more, by steps of a metre.
fn preferred_m(route: &Route, index: &DepthIndex, depth_m: f64, factor: f64) -> f64 {
    let each = route.legs.iter().map(|leg| {
        let profile = index.profile(Leg { from: leg.from, to: leg.to }, 1.0);
        let steps = profile.windows(2).map(|pair| {
            let shallow = pair[0].1.least_m().is_none_or(|least_m| least_m < depth_m);
            (pair[1].0 - pair[0].0) * if shallow { factor } else { 1.0 }
        });
        steps.sum::<f64>()
    });
    each.sum()
}

#[test]
fn an_island_is_passed_at_the_preferred_distance() {
    let router = router(&open_sea().with(Ground::Land, at(100.0, 0.0), 300.0, 32));
    let preferences = Preferences { off_m: Some(150.0), ..Preferences::default() };
    let objective = Objective { preferences, ..still(Aim::Length) };
    let route = ask(&router, &objective, at(0.0, -1_500.0), at(0.0, 1_500.0));
    let shortest = route.shortest.as_deref().unwrap();
    assert!(shortest.least_clearance_m().unwrap() < 15.0 && route.length_m > shortest.length_m);
    assert!(route.least_clearance_m().unwrap() > 145.0, "{:?}", route.least_clearance_m());
    assert!(is_safe(&route, router.index(), &needs()));
}

#[test]
fn a_speed_limit_is_kept_and_the_fastest_way_goes_round_its_area() {
    let router = router(&open_sea());
    let corners = [(-400.0, -300.0), (-400.0, 300.0), (400.0, 300.0), (400.0, -300.0)];
    let corners = corners.map(|(north_m, east_m)| place(at(north_m, east_m))).to_vec();
    let limited = |most_mps: f64, aim: Aim| {
        let limits = vec![SpeedLimit { zone: Zone::new(corners.clone()).unwrap(), most_mps }];
        Objective { limits, ..still(aim) }
    };
    let (west, east) = (at(0.0, -1_500.0), at(0.0, 1_500.0));
    let slow = limited(0.5, Aim::Time);
    let round = ask(&router, &slow, west, east);
    let shortest = round.shortest.as_deref().unwrap();
    // 600 m at 0.5 m/s; round two corners at 1.5 m/s.
    assert!((duration_s(&slow, shortest) - (2_400.0 / MPS + 600.0 / 0.5)).abs() < 25.0);
    let round_m = 2.0 * 1_200.0_f64.hypot(400.0) + 600.0;
    assert!((duration_s(&slow, &round) / (round_m / MPS) - 1.0).abs() < 0.01, "{}", round.length_m);
    assert!(ask(&router, &limited(1.4, Aim::Time), west, east).shortest.is_none(), "not worth the way");
}

#[test]
fn the_least_energy_goes_by_the_speed_that_takes_least() {
    let router = router(&open_sea());
    let (west, east) = (at(0.0, -1_500.0), at(0.0, 1_500.0));
    for against_mps in [0.0, 0.5, 1.0] {
        let currents = Currents::Steady(Flow::set_and_drift(-FRAC_PI_2, against_mps));
        let objective = Objective { currents, ..still(Aim::Energy) };
        let route = ask(&router, &objective, west, east);
        let per_m = |mps: f64| power_w(mps) / (mps - against_mps);
        let paces = (3..=10).map(|tenth| 0.15 * f64::from(tenth)).filter(|mps| *mps > against_mps + 1e-3);
        let best = paces.min_by(|one, other| per_m(*one).total_cmp(&per_m(*other))).unwrap();
        let chosen = route.through_water_mps.unwrap();
        assert!((chosen - best).abs() < 1e-9, "{chosen} {best} against {against_mps}");
        let expected_j = route.length_m * per_m(best);
        assert!((energy_j(&objective, &route) / expected_j - 1.0).abs() < 1e-3);
    }
}

#[test]
fn the_time_goes_on_at_places_to_pass() {
    // For an hour it flows to the west, then to the east.
    let turn = |time_s: f64| if time_s < 3_600.0 { -1.0 } else { 1.0 };
    let grid = field(9, &[0.0, 3_599.0, 3_601.0, 7_200.0], |north_m, _, time_s| Flow {
        east_mps: turn(time_s) * jet(north_m, 1.0).east_mps,
        north_mps: 0.0,
    });
    let objective = Objective { currents: Currents::Grid(grid), depart_s: 1_000.0, ..still(Aim::Time) };
    let router = router(&open_sea()).by_objective(objective.clone()).unwrap();
    let (west, east) = (place(at(0.0, -1_800.0)), place(at(0.0, 1_800.0)));
    let request = Request { move_up_to_m: 0.0, ..Request::new(west, east) };
    let route = router.route_by(&[east, west, east], &request, &needs(), &Cancel::never()).unwrap();
    let shortest = route.shortest.as_deref().unwrap();
    assert_eq!((route.start, route.goal()), (shortest.start, shortest.goal()));
    let northmost = |route: &Route, half: usize| {
        let legs = route.legs.iter();
        let westward = legs.filter(|leg| (local(leg.to).east_m < local(leg.from).east_m) == (half == 0));
        westward.map(|leg| local(leg.to).north_m).fold(0.0, f64::max)
    };
    // Westward with the stream of the first hour; eastward with that of the second, which begins under way.
    assert!(northmost(&route, 0) > 200.0 && northmost(&route, 1) > 200.0, "{route:?}");
    assert!(duration_s(&objective, &route) < duration_s(&objective, shortest));
}

#[test]
fn a_way_is_not_drawn_into_water_whose_current_is_not_known() {
    // Against 1 m/s, with a strip north of the straight line of which nothing is known.
    let grid = field(33, &[0.0], |north_m, _, _| Flow {
        east_mps: if (300.0..900.0).contains(&north_m) { f64::NAN } else { -1.0 },
        north_mps: 0.0,
    });
    let router = router(&open_sea());
    for aim in [Aim::Time, Aim::Energy] {
        let objective = Objective { currents: Currents::Grid(grid.clone()), ..still(aim) };
        let route = ask(&router, &objective, at(0.0, -1_700.0), at(0.0, 1_700.0));
        assert!(route.shortest.is_none() && route.legs.len() == 1, "{aim:?} {:?}", route.length_m);
        assert!((duration_s(&objective, &route) / (route.length_m / 0.5) - 1.0).abs() < 0.5);
    }
    // Where both ends lie in it, a way out of it and back may be taken, and never one with more of it.
    let objective = Objective { currents: Currents::Grid(grid), ..still(Aim::Time) };
    let route = ask(&router, &objective, at(600.0, -1_700.0), at(600.0, 1_700.0));
    let unknown_m = |route: &Route| costs(&objective, route).iter().map(|leg| leg.unknown_m).sum::<f64>();
    if let Some(shortest) = &route.shortest {
        assert!(unknown_m(&route) <= unknown_m(shortest) + 50.0);
    }
}

#[test]
fn the_least_energy_out_and_back_takes_one_speed_that_is_enough_both_ways() {
    let currents = Currents::Steady(Flow::set_and_drift(FRAC_PI_2, 0.6));
    let objective = Objective { currents, ..still(Aim::Energy) };
    let router = router(&open_sea()).by_objective(objective.clone()).unwrap();
    let (west, east) = (place(at(0.0, -1_500.0)), place(at(0.0, 1_500.0)));
    let request = Request { move_up_to_m: 0.0, ..Request::new(west, east) };
    let route = router.route_by(&[west, east, west], &request, &needs(), &Cancel::never()).unwrap();
    // Of the speeds that are tried, the one that takes least out and back together.
    let whole = |mps: f64| power_w(mps) * (1.0 / (mps + 0.6) + 1.0 / (mps - 0.6));
    let paces = (3..=10).map(|tenth| 0.15 * f64::from(tenth)).filter(|mps| *mps > 0.601);
    let best = paces.min_by(|one, other| whole(*one).total_cmp(&whole(*other))).unwrap();
    let chosen = route.through_water_mps.unwrap();
    assert!((chosen - best).abs() < 1e-9, "{chosen} {best}");
    assert!((energy_j(&objective, &route) / (1_500.0 * 2.0 * whole(best)) - 1.0).abs() < 0.01);
}

#[test]
fn after_a_leg_of_an_unknown_time_a_current_that_changes_is_not_known_either() {
    let two_hours = [0.0, 7_200.0];
    let steady = |_: f64, _: f64, _: f64| Flow { east_mps: 0.2, north_mps: 0.0 };
    let objective = |times_s: &[f64], depart_s: f64| Objective {
        currents: Currents::Grid(field(9, times_s, steady)),
        depart_s,
        ..still(Aim::Time)
    };
    let changing = objective(&two_hours, 4_500.0);
    let (west, east) = (place(at(0.0, -1_500.0)), place(at(0.0, 1_500.0)));
    let request = Request { move_up_to_m: 0.0, ..Request::new(west, east) };
    let by = |objective: &Objective| {
        let router = router(&open_sea()).by_objective(objective.clone()).unwrap();
        router.route_by(&[west, east, west, east], &request, &needs(), &Cancel::never()).unwrap()
    };
    let route = by(&changing);
    assert_eq!(route.legs.len(), 3);
    // 3000 m at 1.7 m/s end at 6265 s; the grid ends on the second leg, and the third begins at an unknown time.
    let legs = costs(&changing, &route);
    assert!(legs[0].duration_s.is_some() && legs[0].unknown_m == 0.0);
    assert!(legs[1].duration_s.is_none() && (1_500.0..2_400.0).contains(&legs[1].unknown_m), "{legs:?}");
    assert_eq!((legs[2].duration_s, legs[2].unknown_m), (None, route.legs[2].length_m));
    // A current that is the same at any time is known whenever a leg begins.
    let lasting = objective(&[0.0], 0.0);
    assert!(costs(&lasting, &by(&lasting)).iter().all(|leg| leg.duration_s.is_some()));
}

#[test]
fn a_leg_says_which_speed_limit_it_enters_even_at_a_corner() {
    let corner = [(200.0, 0.0), (-1.0, 1.0), (200.0, 300.0)];
    let corners = corner.map(|(north_m, east_m)| place(at(north_m, east_m))).to_vec();
    let limits = vec![SpeedLimit { zone: Zone::new(corners).unwrap(), most_mps: 0.5 }];
    let router = router(&open_sea());
    let objective = Objective { limits, ..still(Aim::Length) };
    let limit = |from: LocalPoint, to: LocalPoint| {
        costs(&objective, &ask(&router, &objective, from, to))[0].limit_mps
    };
    assert_eq!(limit(at(0.0, -500.0), at(0.0, 500.0)), Some(0.5), "it clips 2 m of the area");
    assert_eq!(limit(at(-5.0, -500.0), at(-5.0, 500.0)), None);
    assert_eq!(limit(at(0.0, 500.0), at(0.0, -500.0)), Some(0.5));
}

#[test]
fn preferred_water_leaves_the_room_of_its_question_in_place() {
    let router = router(&open_sea()).keeping(1);
    let preferences = Preferences { off_m: Some(150.0), depth_m: Some(10.0), factor: 3.0 };
    let objective = Objective { preferences, ..still(Aim::Length) };
    ask(&router, &objective, at(0.0, -500.0), at(0.0, 500.0));
    assert_eq!(router.kept().0, 3, "water of the route, of the depth and of the distance");
    // The next question with other needs gives them up.
    let other = Needs::depth_and_clearance(4.0, 10.0);
    let request = Request::new(place(at(0.0, -500.0)), place(at(0.0, 500.0)));
    router.route(&request, &other, &Cancel::never()).unwrap();
    assert_eq!(router.kept().0, 1);
}

#[test]
fn weighing_ends_at_once_when_it_is_cancelled() {
    let grid = field(33, &[0.0], |north_m, _, _| jet(north_m, 1.0));
    let objective = Objective { currents: Currents::Grid(grid), ..still(Aim::Time) };
    let plain = router(&open_sea());
    let router = plain.by_objective(objective).unwrap();
    let request = Request::new(place(at(0.0, -1_700.0)), place(at(0.0, 1_700.0)));
    let looks = |router: &Router, most: usize| {
        let looked = Cell::new(0);
        let wanted = || {
            looked.set(looked.get() + 1);
            looked.get() <= most
        };
        (router.route(&request, &needs(), &Cancel::unless(&wanted)), looked.get())
    };
    let (_, of_shortest) = looks(&plain, usize::MAX);
    let (route, all) = looks(&router, usize::MAX);
    assert!(route.is_ok() && all > of_shortest + 20, "{all} {of_shortest}");
    for most in [of_shortest + 3, usize::midpoint(of_shortest, all), all - 1] {
        let (answer, looked) = looks(&router, most);
        assert!(matches!(answer, Err(Refusal::Plan(PlanError::Cancelled))), "{most}");
        assert_eq!(looked, most + 1, "it ends at once");
    }
}

#[test]
fn an_objective_out_of_range_is_refused_by_name() {
    let router = router(&open_sea());
    let base = || still(Aim::Time);
    let prefer = |preferences: Preferences| Objective { preferences, ..base() };
    for (objective, part) in [
        (Objective { through_water_mps: f64::NAN, ..base() }, "speed (m/s)"),
        (prefer(Preferences { depth_m: Some(-1.0), ..Preferences::default() }), "preferred depth"),
        (prefer(Preferences { off_m: Some(1e6), ..Preferences::default() }), "preferred distance"),
        (prefer(Preferences { factor: 0.5, ..Preferences::default() }), "factor of preferences"),
        (Objective { depart_s: f64::INFINITY, ..base() }, "time of departure"),
    ] {
        let refusal = router.by_objective(objective).unwrap_err().to_string();
        assert!(refusal.contains(part), "{refusal}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn no_route_is_worse_than_the_shortest_by_its_own_objective_and_every_leg_is_safe(
        shoals in shoals(10, 1_500.0, 50.0..400.0, -1.0..14.0), from in point(1_800.0), to in point(1_800.0), set_rad in 0.0..6.2f64, drift_mps in 0.0..1.2f64, by_energy: bool,
    ) {
        let router = router(&sea(&shoals));
        let swirl = field(9, &[0.0], |north_m, east_m, _| {
            Flow::set_and_drift(set_rad + north_m / 700.0 + east_m / 900.0, drift_mps)
        });
        let aim = if by_energy { Aim::Energy } else { Aim::Time };
        let objective = Objective { currents: Currents::Grid(swirl), ..still(aim) };
        let weighing = router.by_objective(objective.clone()).unwrap();
        let Ok(route) = weighing.route(&Request::new(place(from), place(to)), &needs(), &Cancel::never()) else {
            return Ok(());
        };
        prop_assert!(is_safe(&route, router.index(), &needs()));
        if let Some(shortest) = &route.shortest {
            prop_assert!(is_safe(shortest, router.index(), &needs()));
            // Joining corners makes either a little longer.
            prop_assert!(route.length_m > 0.98 * shortest.length_m - 30.0);
            if by_energy {
                prop_assert!(energy_j(&objective, &route) < 1.001 * energy_j(&objective, shortest));
            } else {
                prop_assert!(duration_s(&objective, &route) < 1.001 * duration_s(&objective, shortest));
            }
        }
    }

    #[test]
    fn preferred_water_costs_no_more_than_the_shortest_way_and_as_much_on_the_way_back(
        shoals in shoals(10, 1_500.0, 50.0..400.0, -1.0..14.0), from in point(1_800.0), to in point(1_800.0), factor in 1.1..5.0f64,
    ) {
        let router = router(&sea(&shoals));
        let preferences = Preferences { depth_m: Some(12.0), factor, ..Preferences::default() };
        let objective = Objective { preferences, ..still(Aim::Length) };
        let weighing = router.by_objective(objective).unwrap();
        let request = Request { least_leg_m: 0.0, ..Request::new(place(from), place(to)) };
        let Ok(route) = weighing.route(&request, &needs(), &Cancel::never()) else { return Ok(()) };
        prop_assert!(is_safe(&route, router.index(), &needs()));
        let cost = |route: &Route| preferred_m(route, router.index(), 12.0, factor);
        if let Some(shortest) = &route.shortest {
            prop_assert!(cost(&route) < 1.002 * cost(shortest) + 20.0 * (factor - 1.0), "{} {}", cost(&route), cost(shortest));
        }
        let back = Request { from: route.goal(), to: route.start, ..request };
        let back = weighing.route(&back, &needs(), &Cancel::never()).unwrap();
        prop_assert!((cost(&back) / cost(&route) - 1.0).abs() < 0.05, "{} {}", cost(&back), cost(&route));
    }
}
