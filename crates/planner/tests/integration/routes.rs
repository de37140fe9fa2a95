//! Routes against the guard, against the true shortest way found without any mesh, and against each other.

use crate::waters::{HALF_M, at, exact, is_safe, middle, place, point, router, sea, shoals};
use charts::depth_index::{DepthIndex, IndexBuilder, Leg};
use charts::s57::{Cell, NamedBytes};
use guard::{Area, GuardLimits, check_way};
use planner::{
    Cancel, End, Needs, Refusal, Request, Route, RouteLeg, Router, Turn, TurnTrouble, Zone, Zones,
};
use proptest::prelude::*;
use std::sync::Arc;
use testkit::sea::{Ground, Sea, open_water};
use units::{LatLon, LocalFrame, LocalPoint};

fn ask(router: &Router, from: LocalPoint, to: LocalPoint, needs: &Needs) -> Result<Route, Refusal> {
    router.route(&exact(from, to), needs, &Cancel::never())
}

/// The length of the shortest way by a graph of all that see each other, of points on circles around all corners: as slow
/// and as plain as can be. Circles have so many points outside of themselves that the way is at most `1/cos(π/64)` longer
/// there.
fn reference_m(sea: &Sea, from: LocalPoint, to: LocalPoint, needs: &Needs) -> Option<f64> {
    const AROUND: u32 = 64;
    let depth_m = needs.demand.needed_m();
    let clear_m = needs.clearance_m + 0.3;
    let closed: Vec<&testkit::sea::Patch> =
        sea.patches().iter().filter(|one| !one.ground.is_deep(depth_m)).collect();
    let outer_m = clear_m / (std::f64::consts::PI / f64::from(AROUND)).cos() + 0.01;
    let around = |corner: LocalPoint| {
        (0..AROUND)
            .map(move |n| corner.displaced(std::f64::consts::TAU * f64::from(n) / f64::from(AROUND), outer_m))
    };
    let free = |point: &LocalPoint| {
        HALF_M - point.north_m.abs().max(point.east_m.abs()) > clear_m
            && closed.iter().all(|patch| patch.distance_m(*point) >= clear_m)
    };
    let mut nodes = vec![from, to];
    nodes.extend(closed.iter().flat_map(|patch| patch.corners.iter().copied().flat_map(around)).filter(free));
    let clear = |a: LocalPoint, b: LocalPoint| closed.iter().all(|patch| segment_m(patch, a, b) >= clear_m);
    // Dijkstra without a heap.
    let mut best_m = vec![f64::INFINITY; nodes.len()];
    let mut done = vec![false; nodes.len()];
    best_m[0] = 0.0;
    loop {
        let next = (0..nodes.len()).filter(|n| !done[*n]).min_by(|a, b| best_m[*a].total_cmp(&best_m[*b]))?;
        if next == 1 || best_m[next].is_infinite() {
            return (next == 1 && best_m[1].is_finite()).then_some(best_m[1]);
        }
        done[next] = true;
        for other in 0..nodes.len() {
            let length_m = best_m[next] + nodes[next].distance_m(nodes[other]);
            if !done[other] && length_m < best_m[other] && clear(nodes[next], nodes[other]) {
                best_m[other] = length_m;
            }
        }
    }
}

/// Distance of a segment to a convex polygon (m).
fn segment_m(patch: &testkit::sea::Patch, a: LocalPoint, b: LocalPoint) -> f64 {
    let cross = |o: LocalPoint, p: LocalPoint, q: LocalPoint| {
        (p.north_m - o.north_m) * (q.east_m - o.east_m) - (p.east_m - o.east_m) * (q.north_m - o.north_m)
    };
    let to_segment = |p: LocalPoint| {
        let (dn, de) = (b.north_m - a.north_m, b.east_m - a.east_m);
        let t = ((p.north_m - a.north_m) * dn + (p.east_m - a.east_m) * de) / (dn * dn + de * de).max(1e-12);
        let t = t.clamp(0.0, 1.0);
        p.distance_m(at(a.north_m + t * dn, a.east_m + t * de))
    };
    let corners = &patch.corners;
    let crossed = (0..corners.len()).any(|n| {
        let (c, d) = (corners[n], corners[(n + 1) % corners.len()]);
        cross(a, b, c) * cross(a, b, d) < 0.0 && cross(c, d, a) * cross(c, d, b) < 0.0
    });
    if crossed {
        return 0.0;
    }
    let ends = patch.distance_m(a).min(patch.distance_m(b));
    corners.iter().map(|corner| to_segment(*corner)).fold(ends, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_leg_is_safe_and_the_way_back_is_as_long(
        shoals in shoals(24, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 0.0..150.0f64, depth_m in 1.0..8.0f64,
    ) {
        let (sea, needs) = (sea(&shoals), Needs::depth_and_clearance(depth_m, clearance_m));
        let router = router(&sea);
        match ask(&router, from, to, &needs) {
            Ok(route) => {
                prop_assert!(is_safe(&route, router.index(), &needs));
                let straight_m = Leg { from: place(from), to: place(to) }.length_m();
                prop_assert!(route.length_m >= straight_m - 1e-3);
                prop_assert!(route.least_depth_m().is_none_or(|least_m| least_m >= depth_m));
                prop_assert!(route.least_clearance_m().unwrap() >= clearance_m);
                let back = ask(&router, to, from, &needs).unwrap();
                prop_assert!((back.length_m - route.length_m).abs() < 1e-3, "{} {}", back.length_m, route.length_m);
                // Joining corners keeps it safe and costs little.
                let request = Request::new(place(from), place(to));
                let tidy = router.route(&request, &needs, &Cancel::never()).unwrap();
                prop_assert!(is_safe(&tidy, router.index(), &needs));
                prop_assert!(tidy.length_m >= route.length_m - 1e-3);
                prop_assert!(tidy.length_m <= 1.02 * route.length_m + 30.0);
            }
            Err(Refusal::NoWay { .. } | Refusal::Closed { .. }) => {}
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    #[test]
    fn more_demands_make_no_way_shorter(
        shoals in shoals(16, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 5.0..80.0f64, depth_m in 1.0..5.0f64,
        deeper_m in 0.0..4.0f64, farther_m in 5.0..60.0f64,
    ) {
        let router = router(&sea(&shoals));
        let plain = ask(&router, from, to, &Needs::depth_and_clearance(depth_m, clearance_m));
        let deeper = ask(&router, from, to, &Needs::depth_and_clearance(depth_m + deeper_m, clearance_m));
        let farther = ask(&router, from, to, &Needs::depth_and_clearance(depth_m, clearance_m + farther_m));
        for strict in [deeper, farther].into_iter().flatten() {
            let plain = plain.as_ref().unwrap();
            // Lines are thinned by up to 1 m, by another share for another clearance.
            prop_assert!(strict.length_m >= plain.length_m - 4.0, "{} {}", strict.length_m, plain.length_m);
        }
    }
}

/// Where a vessel of a turning radius is while it turns: plain trigonometry in a local frame, not the planner's.
fn turning(legs: &[RouteLeg], radius_m: f64) -> Vec<LatLon> {
    let frame = LocalFrame::new(legs[0].to);
    let [a, c] = [legs[0].from, legs[1].to].map(|place| frame.to_local(place));
    let [to_a, to_c] = [a, c].map(|end| LocalPoint::default().bearing_rad(end));
    let half_rad = units::wrap_pi(to_c - to_a) / 2.0;
    let centre = LocalPoint::default().displaced(to_a + half_rad, radius_m / half_rad.sin().abs());
    let inwards_rad = centre.bearing_rad(LocalPoint::default());
    let wide_rad = std::f64::consts::FRAC_PI_2 - half_rad.abs();
    (-10..=10)
        .map(|n| centre.displaced(inwards_rad + wide_rad * f64::from(n) / 10.0, radius_m))
        .map(|point| frame.to_place(point))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn turns_keep_clear_or_say_so(
        shoals in shoals(16, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 5.0..80.0f64, radius_m in 2.0..120.0f64,
    ) {
        let needs = Needs::depth_and_clearance(5.0, clearance_m);
        let router = router(&sea(&shoals));
        let request = Request { turn_radius_m: Some(radius_m), ..Request::new(place(from), place(to)) };
        let Ok(route) = router.route(&request, &needs, &Cancel::never()) else { return Ok(()) };
        prop_assert!(is_safe(&route, router.index(), &needs));
        for legs in route.legs.windows(2) {
            let Some(Turn { trouble: None, change_rad }) = legs[0].turn else { continue };
            prop_assert!(change_rad < 3.0);
            for at in turning(legs, radius_m) {
                // The frame is no plane of the planner's: some centimetres.
                let water = router.index().shallowest_within(at, clearance_m - 0.05, &needs.demand);
                prop_assert!(water.navigable, "{water:?} {legs:?}");
            }
        }
    }

    #[test]
    fn what_is_said_to_pass_passes(
        shoals in shoals(24, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 50.0..400.0f64, depth_m in 2.0..8.0f64,
    ) {
        let needs = Needs::depth_and_clearance(depth_m, clearance_m);
        let router = router(&sea(&shoals));
        let request = Request::new(place(from), place(to));
        if !matches!(router.route(&request, &needs, &Cancel::never()), Err(Refusal::NoWay { .. })) {
            return Ok(());
        }
        let passable = router.passable(&request, &needs, &Cancel::never()).unwrap();
        // Nothing between what is said and what was asked gives a route; where an end is moved, it may be moved elsewhere.
        let moved = matches!(ask(&router, from, to, &needs), Err(Refusal::Closed { .. }));
        for shoal in shoals.iter().filter(|_| !moved) {
            let between_m = (shoal.depth_m * 10.0).floor() / 10.0;
            if between_m > passable.depth_m.unwrap_or(-1.0) && (0.0..depth_m).contains(&between_m) {
                let less = Needs::depth_and_clearance(between_m, clearance_m);
                prop_assert!(router.route(&request, &less, &Cancel::never()).is_err(), "{between_m} m would do");
            }
        }
        let nearer_m = passable.clearance_m.map_or(1.0, |clear_m| 1.02 * clear_m + 3.0);
        if nearer_m < clearance_m && !moved {
            let less = Needs::depth_and_clearance(depth_m, nearer_m);
            prop_assert!(router.route(&request, &less, &Cancel::never()).is_err(), "{nearer_m} m would do");
        }
        if let Some(passable_m) = passable.depth_m {
            let shallower = Needs::depth_and_clearance(passable_m, clearance_m);
            prop_assert!(router.route(&request, &shallower, &Cancel::never()).is_ok());
            prop_assert!(passable_m < depth_m);
        }
        if let Some(passable_m) = passable.clearance_m {
            let nearer = Needs::depth_and_clearance(depth_m, passable_m);
            prop_assert!(router.route(&request, &nearer, &Cancel::never()).is_ok());
            prop_assert!(passable_m < clearance_m);
        }
    }
}

#[test]
fn a_corner_is_moved_out_where_there_is_room_and_warned_of_where_there_is_none() {
    // A square island: the shortest way has one corner off each corner of it.
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 0.0), 600.0, 4);
    let router = router(&sea);
    let needs = Needs::depth_and_clearance(5.0, 10.0);
    let plain = Request::new(place(at(0.0, -1200.0)), place(at(0.0, 1200.0)));
    let request = Request { turn_radius_m: Some(80.0), ..plain };
    let sharp = router.route(&plain, &needs, &Cancel::never()).unwrap();
    let route = router.route(&request, &needs, &Cancel::never()).unwrap();
    let turns: Vec<Turn> = route.legs.iter().filter_map(|leg| leg.turn).collect();
    assert!(!turns.is_empty() && turns.iter().all(|turn| turn.trouble.is_none()), "{turns:?}");
    assert!(route.length_m > sharp.length_m && route.length_m < 1.02 * sharp.length_m);
    assert!(sharp.legs.iter().all(|leg| leg.turn.is_none()), "nobody asked");
    // By way of a place the course goes back.
    let back = [plain.from, plain.to, plain.from];
    let route = router.route_by(&back, &request, &needs, &Cancel::never()).unwrap();
    let trouble: Vec<TurnTrouble> = route.legs.iter().filter_map(|leg| leg.turn?.trouble).collect();
    assert_eq!(trouble, [TurnTrouble::ShortLegs]);
    let refusal = Request { turn_radius_m: Some(f64::NAN), ..plain };
    let refusal = router.route(&refusal, &needs, &Cancel::never()).unwrap_err();
    assert!(refusal.to_string().contains("turning radius"), "{refusal}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_way_is_shorter(shoals in shoals(9, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 5.0..100.0f64) {
        let (sea, needs) = (sea(&shoals), Needs::depth_and_clearance(5.0, clearance_m));
        let Ok(route) = ask(&router(&sea), from, to, &needs) else { return Ok(()) };
        let reference_m = reference_m(&sea, from, to, &needs);
        prop_assert!(reference_m.is_some(), "a way of {} m where the plain search finds none", route.length_m);
        let reference_m = reference_m.unwrap();
        // The planner's circles have 24 corners, the reference's 64; the plane of the reference is no geodesic.
        prop_assert!(route.length_m <= 1.001 * reference_m + 0.02 * clearance_m + 1.0, "{} {reference_m}", route.length_m);
        prop_assert!(route.length_m >= 0.999 * reference_m - 0.02 * clearance_m - 1.0, "{} {reference_m}", route.length_m);
    }
}

#[test]
fn an_island_is_rounded_on_the_shorter_side() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(100.0, 0.0), 400.0, 32);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let route = ask(&router(&sea), at(0.0, -1500.0), at(0.0, 1500.0), &needs).unwrap();
    let frame = LocalFrame::new(middle());
    let southmost = route.places().map(|place| frame.to_local(place).north_m).fold(0.0, f64::min);
    assert!((southmost + 325.0).abs() < 5.0, "{southmost}");
    assert!((25.0..26.5).contains(&route.least_clearance_m().unwrap()), "{:?}", route.least_clearance_m());
    assert_eq!(route.least_depth_m(), Some(30.0));
}

#[test]
fn legs_without_room_for_a_vessel_off_its_track_are_named() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(100.0, 0.0), 400.0, 32);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let route = ask(&router(&sea), at(0.0, -1500.0), at(0.0, 1500.0), &needs).unwrap();
    assert_eq!(route.narrow(25.0), None);
    let narrow = route.narrow(60.0).unwrap();
    let near: Vec<f64> =
        route.legs.iter().filter_map(|leg| leg.clearance_m).filter(|clear_m| *clear_m < 60.0).collect();
    assert_eq!((narrow.legs, Some(narrow.least_m)), (near.len(), route.least_clearance_m()));
    assert_eq!(route.legs[narrow.leg].clearance_m, Some(narrow.least_m));
    assert!(narrow.length_m > 0.0 && narrow.length_m <= route.length_m);
    // All of it may be too narrow.
    let all = route.narrow(5_000.0).unwrap();
    assert!(all.legs == route.legs.len() && (all.length_m - route.length_m).abs() < 1e-6);
}

#[test]
fn water_of_one_chart_is_prepared_on_the_next_in_the_room_that_is_left() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(100.0, 0.0), 400.0, 32);
    let changed = sea.clone().with(Ground::Land, at(-900.0, 0.0), 200.0, 12);
    let (before, after) = (router(&sea), router(&changed).keeping(3));
    let needs = |clearance_m: f64| Needs::depth_and_clearance(5.0, clearance_m);
    let (from, to) = (at(0.0, -1500.0), at(0.0, 1500.0));
    for clearance_m in [10.0, 20.0, 30.0, 10.0] {
        ask(&before, from, to, &needs(clearance_m)).unwrap();
    }
    let wanted = before.prepared();
    assert_eq!(wanted.len(), 3);
    // One that is called off leaves nothing.
    assert!(after.prepare(&wanted[0], &Cancel::unless(&|| false)).is_err());
    assert_eq!(after.kept().0, 0);
    // What was asked for last comes first: 10 m, which a question finds ready.
    assert!(after.prepare(&wanted[0], &Cancel::never()).unwrap());
    assert!(!after.prepare(&wanted[0], &Cancel::never()).unwrap(), "it is ready");
    let route = ask(&after, from, to, &needs(10.0)).unwrap();
    assert!(after.kept().0 == 1 && is_safe(&route, after.index(), &needs(10.0)));
    // It pushes nothing out, and goes first itself.
    ask(&after, from, to, &needs(15.0)).unwrap();
    assert!(after.prepare(&wanted[1], &Cancel::never()).unwrap());
    assert!(!after.prepare(&wanted[2], &Cancel::never()).unwrap(), "three are kept");
    ask(&after, from, to, &needs(16.0)).unwrap();
    assert!(after.kept().0 == 3 && after.prepared()[2] == wanted[0], "30 m went");
    // Regions are not those of a chart that is prepared as a whole.
    let by_regions = Router::by_regions(Arc::new(changed.index()));
    assert!(!by_regions.prepare(&wanted[0], &Cancel::never()).unwrap());
    ask(&by_regions, from, to, &needs(10.0)).unwrap();
    let next = Router::by_regions(Arc::new(sea.index()));
    assert!(next.prepare(&by_regions.prepared()[0], &Cancel::never()).unwrap());
}

#[test]
fn the_guard_takes_what_was_planned_by_its_own_limits() {
    let limits = GuardLimits::default();
    let sea = Sea::new(middle(), HALF_M, 30.0)
        .with(Ground::Land, at(0.0, 0.0), 300.0, 24)
        .with(Ground::Depth(3.0), at(400.0, 300.0), 200.0, 7)
        .with(Ground::Danger, at(-500.0, 100.0), 60.0, 5);
    let index = Arc::new(sea.index());
    let needs = Needs { demand: limits.demand(limits.autonomous_m), clearance_m: limits.half_width_m() };
    let router = Router::new(Arc::clone(&index));
    let route = ask(&router, at(-100.0, -1000.0), at(200.0, 1200.0), &needs).unwrap();
    assert!(route.legs.len() > 1);
    for leg in &route.legs {
        let check = check_way("leg", leg.from, leg.to, &index, &limits);
        assert_eq!(check.reason, None, "{check}");
    }
}

#[test]
fn a_route_goes_round_an_area_that_may_not_be_entered_and_says_when_it_blocks() {
    let sea = Sea::new(middle(), HALF_M, 30.0);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let (from, to) = (at(0.0, -1000.0), at(0.0, 1000.0));
    let closed = router(&sea.clone().with(Ground::Entry(7), at(50.0, 0.0), 300.0, 24));
    let around = ask(&closed, from, to, &needs).unwrap();
    assert!(around.legs.len() > 1 && around.least_clearance_m().unwrap() >= 25.0, "{around:?}");
    assert_eq!(around.least_depth_m(), Some(30.0), "the area has the depth that it has");
    let warned = router(&sea.clone().with(Ground::Entry(8), at(50.0, 0.0), 300.0, 24));
    let straight = ask(&warned, from, to, &needs).unwrap();
    assert_eq!(straight.legs.len(), 1);
    assert!(straight.legs[0].worst.area.is_some(), "the leg says that it enters it");
    let Err(refusal @ Refusal::Closed { .. }) = ask(&closed, at(0.0, 0.0), to, &needs) else {
        panic!("it begins within")
    };
    assert!(refusal.to_string().contains("in an area where entry is prohibited"), "{refusal}");
    // From shore to shore of the chart: the rule alone is in the way.
    let across = router(&sea.with(Ground::Entry(7), at(0.0, 0.0), 2_500.0, 4));
    let (from, to) = (at(-1_900.0, -1_900.0), at(1_900.0, 1_900.0));
    assert!(matches!(ask(&across, from, to, &needs), Err(Refusal::NoWay { .. })));
    let passable = across.passable(&exact(from, to), &needs, &Cancel::never()).unwrap();
    assert!(passable.by_rule_alone && passable.depth_m.is_none() && passable.clearance_m.is_none());
}

#[test]
fn a_gap_is_passed_as_long_as_it_is_wide_enough() {
    // Two islands 100 m apart, and walls of shallow water to both sides of them.
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 1050.0), 1000.0, 4).with(
        Ground::Land,
        at(0.0, -1050.0),
        1000.0,
        4,
    );
    let router = router(&sea);
    let (from, to) = (at(-1000.0, 0.0), at(1000.0, 0.0));
    let through = ask(&router, from, to, &Needs::depth_and_clearance(5.0, 45.0)).unwrap();
    assert!(through.length_m < 2_010.0, "{}", through.length_m);
    // Past the outer corners there is no room either: the sea ends 2000 m off.
    let needs = Needs::depth_and_clearance(5.0, 60.0);
    let Err(Refusal::NoWay { gap_m, .. }) = ask(&router, from, to, &needs) else { panic!("too narrow") };
    assert!(gap_m > 900.0, "{gap_m}");
    let passable = router.passable(&exact(from, to), &needs, &Cancel::never()).unwrap();
    let clear_m = passable.clearance_m.unwrap();
    assert!((44.0..50.5).contains(&clear_m), "{clear_m}");
    assert!(ask(&router, from, to, &Needs::depth_and_clearance(5.0, clear_m)).is_ok(), "what would do does");
    assert_eq!(passable.depth_m, None, "land is not a question of depth");
    assert!(!passable.by_rule_alone, "nor one of a rule");
}

#[test]
fn a_bar_says_which_depth_would_pass() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Depth(3.4), at(0.0, 0.0), 2_800.0, 4);
    let sea = sea.with(Ground::Depth(30.0), at(-1990.0, 0.0), 5.0, 4);
    let router = router(&sea);
    let needs = Needs::depth_and_clearance(5.0, 10.0);
    let corner = 1_950.0;
    let answer = ask(&router, at(-corner, -corner), at(corner, corner), &needs);
    assert!(matches!(answer, Err(Refusal::NoWay { .. })), "{answer:?}");
    let passable =
        router.passable(&exact(at(-corner, -corner), at(corner, corner)), &needs, &Cancel::never()).unwrap();
    assert_eq!(passable.depth_m, Some(3.4));
    let less = Needs::depth_and_clearance(3.4, 10.0);
    assert!(ask(&router, at(-corner, -corner), at(corner, corner), &less).is_ok(), "what would do does");
}

#[test]
fn ends_in_closed_water_are_moved_or_refused_with_the_way_out() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 0.0), 300.0, 24);
    let router = router(&sea);
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let request =
        Request { move_up_to_m: 400.0, ..Request::new(place(at(0.0, -250.0)), place(at(0.0, 1500.0))) };
    let route = router.route(&request, &needs, &Cancel::never()).unwrap();
    let moved = route.moved_start.unwrap();
    assert!((68.0..76.0).contains(&moved.distance_m), "{moved:?}");
    assert_eq!(route.start, moved.to);
    assert!(is_safe(&route, router.index(), &needs));
    let strict = Request { move_up_to_m: 50.0, ..request };
    let Err(Refusal::Closed { end, nearest_m, .. }) = router.route(&strict, &needs, &Cancel::never()) else {
        panic!("too far to be moved")
    };
    assert_eq!(end, End::Start);
    assert!((68.0..76.0).contains(&nearest_m.unwrap()));
    let off_chart = Request::new(place(at(0.0, 1500.0)), LatLon::from_deg(50.0, 0.0).unwrap());
    let refusal = router.route(&off_chart, &needs, &Cancel::never()).unwrap_err();
    assert!(refusal.to_string().contains("the goal lies where nothing is charted"), "{refusal}");
}

#[test]
fn places_to_pass_are_moved_or_refused_by_their_number() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(500.0, 0.0), 200.0, 16).with(
        Ground::Land,
        at(-600.0, 0.0),
        200.0,
        16,
    );
    let (router, needs) = (router(&sea), Needs::depth_and_clearance(5.0, 25.0));
    let [start, first, second, goal] =
        [(0.0, -1_500.0), (500.0, 100.0), (-600.0, 50.0), (0.0, 1_500.0)].map(|(n, e)| at(n, e));
    let by = |via: &[LocalPoint], move_up_to_m: f64| {
        let places: Vec<LatLon> = [&[start], via, &[goal]].concat().into_iter().map(place).collect();
        let request = Request { move_up_to_m, ..exact(start, goal) };
        router.route_by(&places, &request, &needs, &Cancel::never())
    };
    let route = by(&[first, at(0.0, 0.0), second], 500.0).unwrap();
    assert!(is_safe(&route, router.index(), &needs));
    let moved: Vec<usize> = route.moved_via.iter().map(|(number, _)| *number).collect();
    assert_eq!(moved, [1, 3]);
    assert!(route.moved_via.iter().all(|(_, moved)| (50.0..250.0).contains(&moved.distance_m)));
    assert!(route.moved_via.iter().all(|(_, moved)| route.places().any(|corner| corner == moved.to)));
    assert_eq!((route.moved_start, route.moved_goal), (None, None));
    for (via, number, part) in [
        (vec![first, second], 1, "place 1 on the way lies on land"),
        (vec![at(0.0, 0.0), second], 2, "place 2 on the way lies on land"),
        (vec![at(9_000.0, 0.0)], 1, "place 1 on the way lies where nothing is charted"),
    ] {
        let (_, refusal) = by(&via, 10.0).unwrap_err();
        assert!(matches!(refusal, Refusal::Closed { end: End::Via(n), .. } if n == number), "{refusal:?}");
        assert!(refusal.to_string().starts_with(part), "{refusal}");
    }
}

#[test]
fn what_nobody_waits_for_is_given_up() {
    let router = router(&Sea::new(middle(), HALF_M, 30.0));
    let request = exact(at(0.0, 0.0), at(100.0, 0.0));
    let needs = Needs::depth_and_clearance(5.0, 10.0);
    let answer = router.route(&request, &needs, &Cancel::unless(&|| false));
    assert!(matches!(answer, Err(Refusal::Plan(planner::PlanError::Cancelled))), "{answer:?}");
    assert!(router.route(&request, &needs, &Cancel::never()).is_ok(), "nothing half-made stays");
}

#[test]
fn needs_that_nothing_meets_are_refused_by_name() {
    let router = router(&Sea::new(middle(), HALF_M, 30.0));
    for (depth_m, clearance_m, name) in [
        (f64::NAN, 10.0, "least depth"),
        (5.0, f64::INFINITY, "clearance"),
        (5.0, -1.0, "clearance"),
        (1e9, 5.0, "least depth"),
    ] {
        let needs = Needs::depth_and_clearance(depth_m, clearance_m);
        let refusal = ask(&router, at(0.0, 0.0), at(100.0, 0.0), &needs).unwrap_err();
        assert!(refusal.to_string().contains(name), "{refusal}");
    }
}

#[test]
fn without_charts_there_is_no_way() {
    let router = Router::new(Arc::new(DepthIndex::default()));
    let refusal =
        ask(&router, at(0.0, 0.0), at(100.0, 0.0), &Needs::depth_and_clearance(5.0, 10.0)).unwrap_err();
    assert!(matches!(refusal, Refusal::Closed { .. }), "{refusal}");
}

#[test]
fn a_way_over_the_date_line() {
    // Charts end at ±180°, and go on on the other side.
    let mut builder = IndexBuilder::new();
    for (west, east) in [(179.9, 180.0), (-180.0, -179.9)] {
        let (source, features) = open_water([west, -16.6, east, -16.4], 20.0);
        builder.add_features(source, &features).unwrap();
    }
    let router = Router::new(Arc::new(builder.build().unwrap()));
    let (from, to) = (LatLon::from_deg(-16.5, 179.95).unwrap(), LatLon::from_deg(-16.5, -179.95).unwrap());
    let needs = Needs::depth_and_clearance(5.0, 20.0);
    let route = router.route(&Request::new(from, to), &needs, &Cancel::never()).unwrap();
    assert!((10_660.0..10_680.0).contains(&route.length_m), "{}", route.length_m);
}

/// On the demonstration's chart: all legs safe by the guard's own question, and region by region as on the whole.
#[test]
fn regions_give_the_ways_of_the_whole_chart() {
    let mut builder = IndexBuilder::new();
    for file in charts::demo::archipelago().unwrap() {
        let named = NamedBytes { name: file.name, bytes: &file.bytes };
        builder.add_cell(&Cell::read(named, &[]).unwrap()).unwrap();
    }
    let index = Arc::new(builder.build().unwrap());
    let (whole, parts) = (Router::new(Arc::clone(&index)), Router::by_regions(Arc::clone(&index)));
    agree(&index, &whole, &parts, 60);
}

/// The same on real cells.
#[test]
fn ways_on_real_charts_are_safe_whatever_is_asked() {
    let names = ["GB4X0000.000", "GB5X01NE.000", "GB5X01NW.000", "GB5X01SE.000", "GB5X02SE.000"];
    let mut builder = IndexBuilder::new();
    for name in names {
        let Some(path) = testkit::shared(&format!("data/charts/{name}")) else { return };
        let bytes = std::fs::read(path).unwrap();
        builder.add_cell(&Cell::read(NamedBytes { name, bytes: &bytes }, &[]).unwrap()).unwrap();
    }
    let index = Arc::new(builder.build().unwrap());
    let (whole, parts) = (Router::new(Arc::clone(&index)), Router::by_regions(Arc::clone(&index)));
    agree(&index, &whole, &parts, 60);
}

fn agree(index: &DepthIndex, whole: &Router, parts: &Router, count: usize) {
    let extent = index.extent().unwrap();
    let mut numbers = testkit::Numbers(3);
    let (mut found, mut bent) = (0, 0);
    for number in 0..count {
        let needs = Needs::depth_and_clearance([2.0, 10.0][number % 2], [10.0, 30.0][number % 2]);
        let mut place = || {
            let lat = numbers.within(extent.south_deg, extent.north_deg);
            LatLon::from_deg(lat, numbers.within(extent.west_deg, extent.east_deg)).unwrap()
        };
        let request = Request::new(place(), place());
        let one = whole.route(&request, &needs, &Cancel::never());
        // Each region is prepared again, which is what takes time here.
        if number % 20 > 0 {
            assert!(one.is_err() || is_safe(&one.unwrap(), index, &needs));
            continue;
        }
        let other = parts.route(&request, &needs, &Cancel::never());
        match (one, other) {
            (Ok(one), Ok(other)) => {
                assert!(is_safe(&one, index, &needs) && is_safe(&other, index, &needs));
                assert!(
                    (one.length_m - other.length_m).abs() < 2.0 + 1e-3 * one.length_m,
                    "{} {}",
                    one.length_m,
                    other.length_m
                );
                found += 1;
                bent += usize::from(one.legs.len() > 2);
            }
            (
                Err(Refusal::NoWay { .. } | Refusal::Closed { .. }),
                Err(Refusal::NoWay { .. } | Refusal::Closed { .. }),
            ) => {}
            (one, other) => panic!("{request:?} {needs:?}: {one:?} {other:?}"),
        }
    }
    assert!(found > 0 && bent > 0, "{found} {bent}");
}

#[test]
fn a_route_that_is_longer_than_is_of_use_is_refused_with_its_length() {
    // Round a wall, in water that is prepared region by region, with one room kept.
    let wall = Sea::new(middle(), HALF_M, 20.0).with(Ground::Land, at(0.0, 0.0), 800.0, 16);
    let router = Router::by_regions(Arc::new(wall.index())).keeping(0);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let any = Request::new(place(at(-1000.0, 0.0)), place(at(1000.0, 0.0)));
    let length_m = router.route(&any, &needs, &Cancel::never()).unwrap().length_m;
    let of = |longest_m: f64| {
        let request = Request { longest_m: Some(longest_m), ..any };
        router.route(&request, &needs, &Cancel::never())
    };
    assert!((of(length_m + 1.0).unwrap().length_m - length_m).abs() < 1e-6);
    assert!(matches!(of(length_m - 1.0), Err(Refusal::TooLong { most_m, .. }) if most_m < length_m));
    assert!(matches!(of(f64::NAN), Err(Refusal::Needs(_))));
    // What is too far in any case is refused before anything is prepared for it.
    let far = Request { to: LatLon::from_deg(60.0, 5.0).unwrap(), longest_m: Some(20_000.0), ..any };
    let cancelled = Cancel::unless(&|| false);
    assert!(matches!(router.route(&far, &needs, &cancelled), Err(Refusal::TooLong { .. })));
    let two = [any.from, any.to, any.from];
    let request = Request { longest_m: Some(1.5 * length_m), ..any };
    assert!(matches!(
        router.route_by(&two, &request, &needs, &Cancel::never()),
        Err((_, Refusal::TooLong { .. }))
    ));
}

#[test]
fn a_pond_is_not_looked_out_of_in_ever_larger_regions() {
    // A ring of land around the goal, in water that reaches beyond the smallest region.
    let ring = (0..16).map(|n| (f64::from(n) / 16.0 * std::f64::consts::TAU).sin_cos());
    let sea = ring.fold(Sea::new(middle(), 30_000.0, 20.0), |sea, (sin, cos)| {
        sea.with(Ground::Land, at(600.0 * sin, 600.0 * cos), 200.0, 12)
    });
    let router = Router::by_regions(Arc::new(sea.index()));
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    for (from, to) in [(at(-3_000.0, 0.0), at(0.0, 0.0)), (at(0.0, 0.0), at(-3_000.0, 0.0))] {
        assert!(matches!(ask(&router, from, to, &needs), Err(Refusal::NoWay { .. })));
        assert_eq!(router.kept().0, 1, "only the smallest region was prepared");
    }
    // Out of it, a way that is there is found as before.
    assert!(ask(&router, at(-3_000.0, 0.0), at(3_000.0, 0.0), &needs).is_ok());
}

#[test]
fn requests_near_each_other_share_the_water_that_is_prepared() {
    let sea = Sea::new(middle(), 30_000.0, 20.0).with(Ground::Land, at(0.0, 0.0), 500.0, 16);
    let router = Router::by_regions(Arc::new(sea.index()));
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    // As a place is dragged: the middle between the ends moves by some metres.
    for step in 0..20 {
        let to = at(1_000.0 + 3.0 * f64::from(step), 700.0);
        assert!(ask(&router, at(-1_000.0, 300.0), to, &needs).is_ok());
    }
    assert!(router.kept().0 <= 2, "{:?}", router.kept());
}

#[test]
fn regions_of_too_much_chart_are_not_prepared() {
    let sea = Sea::new(middle(), 60_000.0, 20.0).with(Ground::Land, at(0.0, 0.0), 500.0, 16);
    let router = Router::by_regions(Arc::new(sea.index())).preparing(10);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let ends = [at(-30_000.0, 0.0), at(30_000.0, 0.0)];
    assert!(router.is_long(&ends.map(place), &needs) && !router.is_long(&[place(ends[0]); 2], &needs));
    let refused = router.in_zones(Zones::default()).in_corridors(0);
    let far = ask(&refused, ends[0], ends[1], &needs);
    assert!(
        matches!(&far, Err(Refusal::TooFar { straight_km, most_km, by }) if *straight_km > 59.0 && (most_km - 20.0).abs() < 1e-9 && by.len() >= 2),
        "{far:?}"
    );
    let at_once = ask(&router.in_zones(Zones::default()).looking_at(0), ends[0], ends[1], &needs);
    assert!(matches!(at_once, Err(Refusal::TooFar { by, .. }) if by.is_empty()));
    // A corridor holds less; around the island no other way can be shorter.
    let long = ask(&router, ends[0], ends[1], &needs).unwrap();
    assert!(is_safe(&long, router.index(), &needs) && !long.of_part, "{}", long.length_m);
    assert!((60_000.0..60_060.0).contains(&long.length_m), "{}", long.length_m);
    // The smallest region is prepared whatever it holds, and a way by way of places that lie near each other is found.
    assert!(ask(&router, at(-5_000.0, 0.0), at(5_000.0, 0.0), &needs).is_ok());
    let places = [-30_000.0, -15_000.0, 0.0, 15_000.0, 30_000.0].map(|north_m| place(at(north_m, 900.0)));
    let request = exact(at(0.0, 0.0), at(0.0, 0.0));
    let by = router.route_by(&places, &request, &needs, &Cancel::never()).unwrap();
    assert!((by.length_m - 60_000.0).abs() < 200.0, "{}", by.length_m);
    assert!(router.kept().1 > 0);
}

/// How often a question looks whether it is still wanted: many times while water is prepared, seldom where it is kept.
fn looks(router: &Router, needs: &Needs) -> u32 {
    let looks = std::cell::Cell::new(0);
    let wanted = || {
        looks.set(looks.get() + 1);
        true
    };
    let request = Request::new(place(at(0.0, -1_500.0)), place(at(0.0, 1_500.0)));
    router.route(&request, needs, &Cancel::unless(&wanted)).unwrap();
    looks.get()
}

#[test]
fn a_preparation_that_is_called_off_takes_no_place_of_water_that_is_kept() {
    let router = Router::new(Arc::new(
        Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(0.0, 0.0), 200.0, 24).index(),
    ));
    let router = router.keeping(1);
    let (kept, other) = (Needs::depth_and_clearance(5.0, 25.0), Needs::depth_and_clearance(5.0, 50.0));
    let cold = looks(&router, &kept);
    let warm = looks(&router, &kept);
    assert!(warm < cold, "{warm} {cold}");
    let request = Request::new(place(at(0.0, -1_500.0)), place(at(0.0, 1_500.0)));
    let called_off = router.route(&request, &other, &Cancel::unless(&|| false));
    assert_eq!(called_off, Err(Refusal::Plan(planner::PlanError::Cancelled)));
    assert_eq!(looks(&router, &kept), warm, "it is still kept");
    looks(&router, &other);
    assert_eq!(looks(&router, &kept), cold, "one room is kept");
}

/// A star around a place: corners in order of their direction, so that it does not cross itself.
fn drawn() -> impl Strategy<Value = Vec<LatLon>> {
    let corners = prop::collection::vec(60.0..900.0f64, 3..9);
    (point(1_900.0), corners).prop_map(|(middle, radii_m)| {
        let step_rad = std::f64::consts::TAU / radii_m.len() as f64;
        let corner = |(n, radius_m): (u32, &f64)| place(middle.displaced(step_rad * f64::from(n), *radius_m));
        (0..).zip(&radii_m).map(corner).collect()
    })
}

/// Places along a route, a metre apart, and its corners.
fn along(route: &Route) -> Vec<LatLon> {
    let places: Vec<LatLon> = route.places().collect();
    let leg = |pair: &[LatLon]| {
        let frame = LocalFrame::new(pair[0]);
        let end = frame.to_local(pair[1]);
        let steps = end.distance_m(LocalPoint::default()).ceil().max(1.0) as u32;
        let share = move |step: u32| f64::from(step) / f64::from(steps);
        (0..=steps)
            .map(move |step| frame.to_place(at(share(step) * end.north_m, share(step) * end.east_m)))
            .collect::<Vec<_>>()
    };
    places.windows(2).flat_map(leg).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn no_way_leads_into_a_forbidden_zone_or_out_of_the_allowed_one_and_zones_shorten_none(
        shoals in shoals(12, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0), clearance_m in 0.0..60.0f64, margin_m in 0.0..40.0f64,
        forbidden in prop::collection::vec(drawn(), 0..4), allowed in prop::option::of(drawn()),
    ) {
        let zone = |corners: &Vec<LatLon>| Zone::new(corners.clone()).unwrap();
        let area = |corners: &Vec<LatLon>| Area::new(corners).unwrap();
        let needs = Needs::depth_and_clearance(4.0, clearance_m);
        let plain = router(&sea(&shoals));
        let some = Zones::new(None, forbidden.iter().take(1).map(zone).collect(), margin_m).unwrap();
        let all = Zones::new(allowed.as_ref().map(zone), forbidden.iter().map(zone).collect(), margin_m).unwrap();
        let (some, all) = (plain.in_zones(some), plain.in_zones(all));
        let tidy = all.route(&Request::new(place(from), place(to)), &needs, &Cancel::never());
        for route in [ask(&all, from, to, &needs), tidy].into_iter().filter_map(|route| match route {
            Ok(route) => Some(route),
            Err(Refusal::NoWay { .. } | Refusal::Closed { .. }) => None,
            Err(other) => panic!("{other}"),
        }) {
            prop_assert!(is_safe(&route, plain.index(), &needs));
            for place in along(&route) {
                prop_assert!(forbidden.iter().all(|zone| area(zone).depth_m(place) <= -margin_m + 0.05));
                prop_assert!(allowed.iter().all(|zone| area(zone).depth_m(place) >= margin_m - 0.05));
            }
        }
        // Fewer zones first: each further one can only close water.
        let lengths_m = [&plain, &some, &all].map(|router| ask(router, from, to, &needs).map(|route| route.length_m));
        for pair in lengths_m.windows(2) {
            if let Ok(more_m) = pair[1] {
                prop_assert!(more_m >= pair[0].as_ref().unwrap() - 0.05, "{lengths_m:?}");
            }
        }
    }
}

#[test]
fn an_end_in_a_zone_is_moved_out_of_it_or_refused_by_it() {
    let corners = [at(-200.0, -200.0), at(-200.0, 200.0), at(200.0, 200.0), at(200.0, -200.0)].map(place);
    let forbidden = Zone::new(corners.to_vec()).unwrap();
    let router = router(&sea(&[])).in_zones(Zones::new(None, vec![forbidden], 10.0).unwrap());
    let needs = Needs::depth_and_clearance(5.0, 5.0);
    let refused = ask(&router, at(0.0, 0.0), at(0.0, 900.0), &needs).unwrap_err();
    assert!(refused.to_string().contains("or in a forbidden one"), "{refused}");
    let request = Request::new(place(at(0.0, 150.0)), place(at(0.0, 900.0)));
    let moved = router.route(&request, &needs, &Cancel::never()).unwrap().moved_start.unwrap();
    assert!((moved.distance_m - 60.0).abs() < 1.5, "{moved:?}");
}

fn with_alternatives(router: &Router, from: LocalPoint, to: LocalPoint, needs: &Needs) -> Route {
    let request = Request { alternatives: 3, ..exact(from, to) };
    router.route(&request, needs, &Cancel::never()).unwrap()
}

/// The farthest that a route goes north of the middle, and south of it (m).
fn north_and_south(route: &Route) -> (f64, f64) {
    let frame = LocalFrame::new(middle());
    let north = route.places().map(|place| frame.to_local(place).north_m);
    north.fold((f64::MIN, f64::MAX), |(most, least), north_m| (most.max(north_m), least.min(north_m)))
}

#[test]
fn the_other_side_of_an_island_is_an_alternative() {
    let sea = Sea::new(middle(), HALF_M, 30.0).with(Ground::Land, at(100.0, 0.0), 400.0, 32);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let router = router(&sea);
    let route = with_alternatives(&router, at(0.0, -1500.0), at(0.0, 1500.0), &needs);
    let [other] = route.alternatives.as_slice() else { panic!("{} alternatives", route.alternatives.len()) };
    assert!(north_and_south(&route).1 < -300.0 && north_and_south(other).0 > 500.0);
    assert!(is_safe(other, router.index(), &needs) && other.length_m > route.length_m);
    // Where nothing lies between, and where nobody asks, there is none.
    assert!(
        with_alternatives(&router, at(-1500.0, -300.0), at(-1500.0, 300.0), &needs).alternatives.is_empty()
    );
    assert!(ask(&router, at(0.0, -1500.0), at(0.0, 1500.0), &needs).unwrap().alternatives.is_empty());
    // Nor by way of other places, nor one that is longer than is of use.
    let request = Request { alternatives: 3, ..exact(at(0.0, -1500.0), at(0.0, 1500.0)) };
    let places = [request.from, place(at(-900.0, 0.0)), request.to];
    assert!(router.route_by(&places, &request, &needs, &Cancel::never()).unwrap().alternatives.is_empty());
    let short = Request { longest_m: Some(route.length_m + 1.0), ..request };
    assert!(router.route(&short, &needs, &Cancel::never()).unwrap().alternatives.is_empty());
}

/// Both banks of a fjord are one shore: the passages on both sides of its island join the same two shores.
#[test]
fn the_other_side_of_an_island_in_a_fjord_is_an_alternative() {
    let fjord = (0..=12).flat_map(|step| {
        let east_m = -1_500.0 + 250.0 * f64::from(step);
        [at(1_000.0, east_m), at(-1_000.0, east_m)]
    });
    let head = (0..=8).map(|step| at(-1_000.0 + 250.0 * f64::from(step), 1_600.0));
    let land = fjord
        .chain(head)
        .fold(Sea::new(middle(), HALF_M, 30.0), |sea, at| sea.with(Ground::Land, at, 300.0, 12));
    let sea = land.with(Ground::Land, at(60.0, 0.0), 350.0, 24);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let router = router(&sea);
    let route = with_alternatives(&router, at(0.0, -1_200.0), at(0.0, 1_000.0), &needs);
    let [other] = route.alternatives.as_slice() else { panic!("{} alternatives", route.alternatives.len()) };
    assert!(north_and_south(&route).1 < -250.0 && north_and_south(other).0 > 400.0);
    assert!(is_safe(other, router.index(), &needs));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn alternatives_are_safe_differ_and_come_by_length(shoals in shoals(9, 1_700.0, 10.0..400.0, -1.0..7.0), from in point(1_900.0), to in point(1_900.0)) {
        let (sea, needs) = (sea(&shoals), Needs::depth_and_clearance(5.0, 20.0));
        let router = router(&sea);
        let request = Request { alternatives: 3, ..exact(from, to) };
        let Ok(route) = router.route(&request, &needs, &Cancel::never()) else { return Ok(()) };
        let alone = ask(&router, from, to, &needs).unwrap();
        prop_assert_eq!(&alone.legs, &route.legs);
        let mut before_m = route.length_m;
        for other in &route.alternatives {
            prop_assert!(is_safe(other, router.index(), &needs));
            prop_assert!(other.length_m >= before_m - 0.01, "{} after {before_m}", other.length_m);
            prop_assert!(other.length_m <= 2.0 * route.length_m + 1.0);
            before_m = other.length_m;
        }
        let ways: Vec<Vec<LatLon>> = std::iter::once(&route).chain(&route.alternatives).map(|route| route.places().collect()).collect();
        prop_assert!((1..ways.len()).all(|at| !ways[..at].contains(&ways[at])));
    }
}
