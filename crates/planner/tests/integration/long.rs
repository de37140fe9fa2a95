//! Long ways, found tile by tile, beside those that are found in all water at once. Tiles are small here, so that one region holds
//! all water.

use crate::waters::{HALF_M, at, exact_places as exact, is_safe, middle, place, point, sea, shoals};
use charts::depth_index::{DepthIndex, IndexBuilder, Leg};
use charts::s57::{Area, GeoPoint, Path};
use planner::{
    Aim, Cancel, End, Needs, Objective, PlanError, Power, Progress, Refusal, Request, Route, Router,
    SpeedLimit, Spent, Zone, Zones,
};
use proptest::prelude::*;
use std::sync::Arc;
use std::time::Duration;
use testkit::sea::{Ground, Sea, open_water};
use units::{LatLon, LocalFrame, LocalPoint};

/// All water at once, and tile by tile.
fn both(index: &Arc<DepthIndex>, tile_m: f64) -> [Router; 2] {
    [Router::new(Arc::clone(index)), Router::by_tiles(Arc::clone(index), tile_m)]
}

/// Asks both ways of planning; whether there is a way, if they agree.
fn agree([whole, tiled]: &[Router; 2], request: &Request, needs: &Needs) -> Result<bool, String> {
    let [one, other] = [whole, tiled].map(|router| router.route(request, needs, &Cancel::never()));
    match (one, other) {
        (Ok(one), Ok(other)) => {
            if !is_safe(&other, tiled.index(), needs) {
                return Err(format!("not safe: {other:?}"));
            }
            let (one_m, other_m) = (one.length_m, other.length_m);
            let moved_m = |route: &Route| {
                let moved = [route.moved_start, route.moved_goal].into_iter().flatten();
                moved.map(|moved| moved.distance_m).sum::<f64>()
            };
            // Of two places for an end that are as near, either may be taken.
            if (moved_m(&one) - moved_m(&other)).abs() > 0.5 {
                return Err(format!("moved by {} m and {} m", moved_m(&one), moved_m(&other)));
            }
            let off_m = 0.001 * one_m + 0.5 + 2.0 * moved_m(&one);
            let same = (one_m - other_m).abs() <= off_m;
            if same {
                Ok(true)
            } else {
                Err(format!("{one_m} m and {other_m} m, of part: {}", other.of_part))
            }
        }
        (Err(Refusal::NoWay { gap_m, .. }), Err(Refusal::NoWay { gap_m: tiled_m, .. })) => {
            let same = (gap_m - tiled_m).abs() < 0.5 || request.move_up_to_m > 0.0;
            if same { Ok(false) } else { Err(format!("{gap_m} m and {tiled_m} m to the goal")) }
        }
        (Err(Refusal::Closed { end, water, .. }), Err(Refusal::Closed { end: same, water: here, .. }))
            if end == same && water == here =>
        {
            Ok(false)
        }
        (one, other) => Err(format!("{one:?}\n{other:?}")),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(testkit::so_many(8, 2_000)))]

    #[test]
    fn ways_of_tiles_are_those_of_all_water_at_once(
        shoals in shoals(40, 1_900.0, 20.0..600.0, -4.0..4.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 0.0..120.0f64, tile_m in 400.0..1_800.0f64,
    ) {
        let routers = both(&Arc::new(sea(&shoals).index()), tile_m);
        let needs = Needs::depth_and_clearance(5.0, clearance_m);
        for (from, to) in [(from, to), (to, from)] {
            if let Err(text) = agree(&routers, &exact(place(from), place(to)), &needs) {
                prop_assert!(false, "{}", text);
            }
        }
        // With ends that are moved, perhaps into another tile.
        let moved = Request { least_leg_m: 0.0, ..Request::new(place(from), place(to)) };
        if let Err(text) = agree(&routers, &moved, &needs) {
            prop_assert!(false, "moved: {}", text);
        }
    }
}

#[test]
fn ends_in_one_tile_may_be_joined_by_other_tiles_only() {
    // A wall between the ends, longer than two tiles; as it is shifted, the ends lie in one tile or in two.
    let (mut joined, needs) = (0, Needs::depth_and_clearance(5.0, 10.0));
    for shift in 0..5 {
        let off_m = 120.0 * f64::from(shift);
        let wall = (-20..=20).fold(Sea::new(middle(), HALF_M, 30.0), |sea, n| {
            sea.with(Ground::Land, at(off_m, 60.0 * f64::from(n)), 50.0, 8)
        });
        let routers = both(&Arc::new(wall.index()), 600.0);
        let request = exact(place(at(off_m - 100.0, 0.0)), place(at(off_m + 100.0, 0.0)));
        assert!(agree(&routers, &request, &needs).unwrap());
        let length_m = routers[1].route(&request, &needs, &Cancel::never()).unwrap().length_m;
        joined += usize::from(length_m > 2_000.0);
    }
    assert_eq!(joined, 5);
}

#[test]
fn a_gap_at_the_border_of_tiles_is_passed_exactly_where_it_is_wide_enough() {
    let mut passed = [0, 0];
    for shift in 0..6 {
        let off_m = 90.0 * f64::from(shift);
        // Land from west to east with one gap 100 m wide.
        let square = |sea: Sea, east_m: f64| sea.with(Ground::Land, at(off_m, east_m), 1_000.0, 4);
        let sea = square(square(Sea::new(middle(), HALF_M, 30.0), off_m - 1_050.0), off_m + 1_050.0);
        let sea = [-2_300.0, 2_600.0].into_iter().fold(sea, square);
        let routers = both(&Arc::new(sea.index()), 500.0);
        let request = exact(place(at(-1_900.0, off_m)), place(at(1_900.0, off_m)));
        for (number, clearance_m) in [47.0, 51.0].into_iter().enumerate() {
            let needs = Needs::depth_and_clearance(5.0, clearance_m);
            passed[number] += usize::from(agree(&routers, &request, &needs).unwrap());
        }
    }
    assert_eq!(passed, [6, 0]);
}

#[test]
fn islands_on_the_corners_of_tiles_are_rounded() {
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let sea = (-3..=3).flat_map(|row| (-3..=3).map(move |column| (row, column))).fold(
        Sea::new(middle(), HALF_M, 30.0),
        |sea, (row, column)| {
            let point = at(500.0 * f64::from(row) + 20.0, 500.0 * f64::from(column) - 20.0);
            sea.with(Ground::Land, point, 180.0, 12)
        },
    );
    let routers = both(&Arc::new(sea.index()), 500.0);
    for (from, to) in [
        (at(-1_900.0, -1_900.0), at(1_900.0, 1_900.0)),
        (at(-1_900.0, 10.0), at(1_900.0, -30.0)),
        (at(270.0, -1_900.0), at(-270.0, 1_900.0)),
    ] {
        assert!(agree(&routers, &exact(place(from), place(to)), &needs).unwrap());
    }
}

#[test]
fn ways_over_the_date_line_and_near_the_pole() {
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let mut builder = IndexBuilder::new();
    for (west, east) in [(179.9, 180.0), (-180.0, -179.9)] {
        let (source, features) = open_water([west, -16.6, east, -16.4], 20.0);
        builder.add_features(source, &features).unwrap();
    }
    let ends = [179.95, -179.95].map(|lon_deg| LatLon::from_deg(-16.5, lon_deg).unwrap());
    let routers = both(&Arc::new(builder.build().unwrap()), 3_000.0);
    assert!(agree(&routers, &exact(ends[0], ends[1]), &needs).unwrap());
    let north = LatLon::from_deg(86.0, 40.0).unwrap();
    let frame = LocalFrame::new(north);
    let sea = Sea::new(north, HALF_M, 30.0).with(Ground::Land, at(0.0, 100.0), 900.0, 16);
    let routers = both(&Arc::new(sea.index()), 700.0);
    let [from, to] = [at(0.0, -1_500.0), at(100.0, 1_600.0)].map(|point| frame.to_place(point));
    assert!(agree(&routers, &exact(from, to), &needs).unwrap());
    assert!(agree(&routers, &exact(to, from), &needs).unwrap());
}

/// A polygon of land around a place.
fn islet(north_deg: f64, east_deg: f64, radius_m: f64) -> Area {
    let frame = LocalFrame::new(LatLon::from_deg(north_deg, east_deg).unwrap());
    let points = (0..=16).map(|n| {
        let corner = LocalPoint::default().displaced(std::f64::consts::TAU * f64::from(n) / 16.0, radius_m);
        let place = frame.to_place(corner);
        GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() }
    });
    Area { exteriors: vec![Path { points: points.collect(), edges: Vec::new() }], holes: Vec::new() }
}

#[test]
fn wide_clearances_are_kept_hundreds_of_kilometres_from_the_middle() {
    // At both ends of 680 km a gap between islets that is hardly wide enough: in the plane it is 0.07 % wider there.
    let (source, features) = open_water([5.0, 61.9, 15.0, 68.3], 200.0);
    let mut builder = IndexBuilder::new();
    builder.add_features(source, &features).unwrap();
    let mut land = Vec::new();
    for lat_deg in [62.2_f64, 67.9] {
        let half_deg = (2_000.0 + 500.0 + 8.0) / 111_320.0 / lat_deg.to_radians().cos();
        for east in [-3, -1, 1, 3] {
            land.push(islet(lat_deg, 10.0 + half_deg * f64::from(east), 2_000.0));
        }
    }
    builder.add_land("land", &land).unwrap();
    let index = Arc::new(builder.build().unwrap());
    let router = Router::by_tiles(Arc::clone(&index), 100_000.0);
    let needs = Needs::depth_and_clearance(5.0, 500.0);
    let [from, to] = [62.1, 68.0].map(|lat_deg| LatLon::from_deg(lat_deg, 10.0).unwrap());
    let route = router.route(&exact(from, to), &needs, &Cancel::never()).unwrap();
    assert!(is_safe(&route, &index, &needs));
    let straight_m = Leg { from, to }.length_m();
    assert!(straight_m > 650_000.0 && route.length_m < straight_m + 50.0, "{} {straight_m}", route.length_m);
    assert!(!route.of_part, "no way is shorter than straight");
    let clear_m = route.least_clearance_m().unwrap();
    assert!((500.0..512.0).contains(&clear_m), "measured on the sea: {clear_m}");
}

/// Land from west to east, with water of more than thirty tiles on both sides.
fn parted() -> Arc<DepthIndex> {
    let wall = (-20..=20).fold(Sea::new(middle(), HALF_M, 30.0), |sea, n| {
        sea.with(Ground::Land, at(0.0, 110.0 * f64::from(n)), 150.0, 8)
    });
    Arc::new(wall.index())
}

#[test]
fn that_there_is_no_way_is_said_only_where_all_water_was_looked_at() {
    let (index, needs) = (parted(), Needs::depth_and_clearance(5.0, 10.0));
    let request = exact(place(at(-1_500.0, 0.0)), place(at(1_500.0, 200.0)));
    let all = Router::by_tiles(Arc::clone(&index), 400.0);
    let answer = all.route(&request, &needs, &Cancel::never());
    let Err(Refusal::NoWay { gap_m, .. }) = answer else { panic!("{answer:?}") };
    assert!((1_500.0..1_900.0).contains(&gap_m), "{gap_m}");
    let answer = all.looking_at(27).route(&request, &needs, &Cancel::never());
    let Err(refusal @ Refusal::GaveUp { tiles, looked_km, spent: Spent::Tiles }) = answer else {
        panic!("{answer:?}")
    };
    assert!((27..60).contains(&tiles) && (0.5..4.0).contains(&looked_km), "{tiles} {looked_km}");
    assert!(refusal.to_string().contains("add places on the way"), "{refusal}");
    // The pond of the goal is small: it is enclosed however little is looked at elsewhere.
    let ring = (0..16).map(|n| (f64::from(n) / 16.0 * std::f64::consts::TAU).sin_cos());
    let pond = ring.fold(Sea::new(middle(), HALF_M, 30.0), |sea, (sin, cos)| {
        sea.with(Ground::Land, at(1_000.0 + 300.0 * sin, 300.0 * cos), 90.0, 8)
    });
    let router = Router::by_tiles(Arc::new(pond.index()), 300.0).looking_at(1);
    for (from, to) in [(at(-1_500.0, 0.0), at(1_000.0, 0.0)), (at(1_000.0, 0.0), at(-1_500.0, 0.0))] {
        let answer = router.route(&exact(place(from), place(to)), &needs, &Cancel::never());
        let is_no_way = matches!(answer, Err(Refusal::NoWay { gap_m, .. }) if gap_m > 60.0);
        let from_pond = from.north_m > 0.0;
        assert!(is_no_way || from_pond && matches!(answer, Err(Refusal::GaveUp { .. })), "{answer:?}");
        let Err(refusal @ Refusal::NoWay { looked_km, .. }) = answer else { continue };
        // The pond itself is looked at as a whole; of the sea around it a part.
        assert_eq!(looked_km.is_none(), from_pond, "{refusal}");
        assert_eq!(refusal.to_string().contains("km around the start"), !from_pond, "{refusal}");
    }
}

#[test]
fn a_corridor_of_too_much_chart_is_refused_with_places_on_the_way() {
    let index =
        Arc::new(Sea::new(middle(), 6_000.0, 30.0).with(Ground::Land, at(0.0, 0.0), 900.0, 12).index());
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let request = exact(place(at(-5_500.0, -5_500.0)), place(at(5_500.0, 5_400.0)));
    let router = Router::by_tiles(Arc::clone(&index), 1_000.0);
    let little = router.in_zones(Zones::default()).in_corridors(0);
    let answer = little.route(&request, &needs, &Cancel::never());
    let Err(refusal @ Refusal::TooFar { .. }) = &answer else { panic!("{answer:?}") };
    assert!(refusal.to_string().contains(", such as "), "{refusal}");
    let Refusal::TooFar { by, most_km, .. } = refusal else { panic!() };
    let places: Vec<LatLon> = [request.from].iter().chain(by).chain([&request.to]).copied().collect();
    assert!(!by.is_empty() && (most_km - 4.0).abs() < 1e-9, "{places:?}");
    let longest_m =
        places.windows(2).map(|ends| Leg { from: ends[0], to: ends[1] }.length_m()).fold(0.0, f64::max);
    assert!(longest_m < 5_500.0, "{longest_m}");
    let way = router.route_by(&places, &request, &needs, &Cancel::never()).unwrap();
    let shortest_m = router.route(&request, &needs, &Cancel::never()).unwrap().length_m;
    assert!(
        is_safe(&way, &index, &needs) && way.length_m < 1.05 * shortest_m,
        "{} {shortest_m}",
        way.length_m
    );
}

#[test]
fn what_was_prepared_for_a_long_way_is_used_again_and_a_cancelled_one_leaves_nothing() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 0.0), 500.0, 12);
    let router = Router::by_tiles(Arc::new(sea.index()), 700.0);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let looks = |to: LocalPoint| {
        let looks = std::cell::Cell::new(0);
        let wanted = || {
            looks.set(looks.get() + 1);
            true
        };
        let request = exact(place(at(-1_500.0, 0.0)), place(to));
        router.route(&request, &needs, &Cancel::unless(&wanted)).unwrap();
        looks.get()
    };
    let cold = looks(at(1_500.0, 0.0));
    let kept = router.kept();
    for step in 0..10 {
        let warm = looks(at(1_500.0 - f64::from(step), 0.0));
        assert!(warm * 3 < cold, "{warm} {cold}");
    }
    assert_eq!(router.kept(), kept, "nothing more was prepared");
    let other = Needs::depth_and_clearance(5.0, 40.0);
    let request = exact(place(at(-1_500.0, 0.0)), place(at(1_500.0, 0.0)));
    for most in [0, 1, 5, 20, 60] {
        let looks = std::cell::Cell::new(0);
        let wanted = || {
            looks.set(looks.get() + 1);
            looks.get() <= most
        };
        let answer = router.route(&request, &other, &Cancel::unless(&wanted));
        assert_eq!(answer, Err(Refusal::Plan(PlanError::Cancelled)), "{most}");
        assert_eq!(looks.get(), most + 1, "it ends at the first look that says so");
    }
    assert!(router.route(&request, &other, &Cancel::never()).is_ok(), "nothing half-made stays");
}

#[test]
fn zones_close_tiles_and_ends_ashore_are_moved_or_refused() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(900.0, 0.0), 300.0, 12);
    let [whole, tiled] = both(&Arc::new(sea.index()), 450.0);
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let corners = [(-300.0, -1_990.0), (-300.0, 1_200.0), (200.0, 1_200.0), (200.0, -1_990.0)];
    let zone = Zone::new(corners.map(|(north_m, east_m)| place(at(north_m, east_m))).to_vec()).unwrap();
    let zones = Zones::new(None, vec![zone], 30.0).unwrap();
    let zoned = [whole.in_zones(zones.clone()), tiled.in_zones(zones)];
    let request = exact(place(at(-1_500.0, -1_000.0)), place(at(1_500.0, -1_000.0)));
    assert!(agree(&zoned, &request, &needs).unwrap());
    assert!(zoned[1].route(&request, &needs, &Cancel::never()).unwrap().length_m > 4_000.0);
    let ashore = Request { move_up_to_m: 500.0, ..Request::new(request.from, place(at(850.0, 0.0))) };
    let routers = [whole, tiled];
    assert!(agree(&routers, &ashore, &needs).unwrap());
    let strict = Request { move_up_to_m: 50.0, ..ashore };
    assert!(!agree(&routers, &strict, &needs).unwrap());
    let refusal = routers[1].route(&strict, &needs, &Cancel::never());
    assert!(
        matches!(refusal, Err(Refusal::Closed { end: End::Goal, nearest_m: Some(near_m), .. }) if (200.0..330.0).contains(&near_m)),
        "{refusal:?}"
    );
}

#[test]
fn a_search_that_takes_too_long_gives_up_and_goes_on_when_it_is_asked_again() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 0.0), 500.0, 12);
    let index = Arc::new(sea.index());
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let request = exact(place(at(-1_500.0, 0.0)), place(at(1_500.0, 0.0)));
    // A clock that goes on by 1 ms each time it is read; the answer, the time and the tiles that were reported.
    let ask = |router: &Router, most_ms: u64| {
        let (clock, reported) = (std::cell::Cell::new(0), std::cell::Cell::new(0));
        let spent = || {
            clock.set(clock.get() + 1);
            Duration::from_millis(clock.get())
        };
        let report = |progress: Progress| {
            assert!(progress.tiles > reported.get() && progress.tiles <= progress.most_tiles);
            reported.set(progress.tiles);
        };
        let cancel = Cancel::never().within(Duration::from_millis(most_ms), &spent).reporting(&report);
        (router.route(&request, &needs, &cancel), clock.get(), reported.get())
    };
    let (answer, all_ms, _) = ask(&Router::by_tiles(Arc::clone(&index), 500.0), u64::MAX);
    let shortest = answer.unwrap();
    let router = Router::by_tiles(index, 500.0);
    let (answer, spent_ms, reported) = ask(&router, all_ms / 3);
    let Err(refusal @ Refusal::GaveUp { tiles, spent: Spent::Time, .. }) = answer else {
        panic!("{answer:?}")
    };
    assert_eq!(spent_ms, all_ms / 3 + 1, "it ends at once");
    assert!(reported > 1 && (reported..=reported + 1).contains(&tiles), "{reported} {tiles}");
    assert!(refusal.to_string().contains("its time is used up"), "{refusal}");
    let (answer, again_ms, _) = ask(&router, u64::MAX);
    assert_eq!(answer.unwrap().legs, shortest.legs);
    assert!(
        again_ms < all_ms - all_ms / 6,
        "what was searched is not searched again: {again_ms} of {all_ms} ms"
    );
}

#[test]
fn ends_near_each_other_are_joined_by_a_long_way_where_no_region_holds_one() {
    // A wall through the smallest region and beyond; the next region holds too much chart.
    let wall = (-13..=13).fold(Sea::new(middle(), 60_000.0, 30.0), |sea, n| {
        sea.with(Ground::Land, at(0.0, 2_000.0 * f64::from(n)), 1_500.0, 8)
    });
    let router = Router::by_regions(Arc::new(wall.index())).preparing(10);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let ends = [place(at(-3_000.0, 0.0)), place(at(3_000.0, 0.0))];
    assert!(!router.is_long(&ends, &needs));
    let request = exact(ends[0], ends[1]);
    let short = router.without_long().route(&request, &needs, &Cancel::never());
    assert!(matches!(short, Err(Refusal::Unknown { .. })), "{short:?}");
    let route = router.route(&request, &needs, &Cancel::never()).unwrap();
    assert!(is_safe(&route, router.index(), &needs));
    assert!((54_000.0..58_000.0).contains(&route.length_m), "{}", route.length_m);
}

#[test]
fn the_fastest_long_way_goes_round_a_slow_area_as_it_does_in_all_water_at_once() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(-900.0, 0.0), 300.0, 12);
    let corners = [(-400.0, -500.0), (-400.0, 500.0), (400.0, 500.0), (400.0, -500.0)];
    let corners = corners.map(|(north_m, east_m)| place(at(north_m, east_m))).to_vec();
    let limits = vec![SpeedLimit { zone: Zone::new(corners).unwrap(), most_mps: 0.5 }];
    let still = Objective::shortest(1.5, Power::new(|_| Some(100.0)));
    let fastest = Objective { aim: Aim::Time, limits, ..still };
    let request = exact(place(at(0.0, -1_800.0)), place(at(0.0, 1_800.0)));
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let durations_s = both(&Arc::new(sea.index()), 700.0).map(|router| {
        let ask = |objective: &Objective| {
            let router = router.by_objective(objective.clone()).unwrap();
            router.route(&request, &needs, &Cancel::never()).unwrap()
        };
        let route = ask(&fastest);
        assert!(is_safe(&route, router.index(), &needs) && route.shortest.is_some());
        let duration_s =
            |route: &Route| -> f64 { route.reckon(&fastest).iter().map(|leg| leg.duration_s.unwrap()).sum() };
        // The shortest way through the area is slowed down too.
        let shortest = ask(&Objective { aim: Aim::Length, ..fastest.clone() });
        assert!(duration_s(&shortest) > 3_600.0 / 1.5 + 1_000.0 / 0.5 - 1_000.0 / 1.5 - 5.0);
        assert!(duration_s(&route) < 0.75 * duration_s(&shortest));
        duration_s(&route)
    });
    // The corridor has less room for the detour.
    let longer = durations_s[1] / durations_s[0];
    assert!((0.99..1.05).contains(&longer), "{durations_s:?}");
}
