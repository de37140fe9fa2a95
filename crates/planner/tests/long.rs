//! Long ways, by a corridor of tiles, beside those that are found in all water at once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use charts::depth_index::{DepthIndex, Leg};
use planner::{Cancel, End, Needs, PlanError, Refusal, Request, Route, Router, Zone, Zones};
use std::sync::Arc;
use testkit::Numbers;
use testkit::sea::{Ground, Sea};
use units::{LatLon, LocalFrame, LocalPoint};

const HALF_M: f64 = 80_000.0;

fn middle() -> LatLon {
    LatLon::from_deg(58.0, 10.35).unwrap()
}

fn place(north_m: f64, east_m: f64) -> LatLon {
    LocalFrame::new(middle()).to_place(LocalPoint { north_m, east_m })
}

/// Both ways of planning on one chart: all water at once, and by corridors.
fn routers(index: &Arc<DepthIndex>) -> [Router; 2] {
    let long = Router::by_regions(Arc::clone(index)).preparing(10).in_corridors(1_000_000);
    [Router::new(Arc::clone(index)), long]
}

fn is_safe(route: &Route, index: &DepthIndex, needs: &Needs) -> bool {
    let places: Vec<LatLon> = route.places().collect();
    places.windows(2).all(|leg| {
        let leg = Leg { from: leg[0], to: leg[1] };
        index.shallowest_along(leg, needs.clearance_m, &needs.demand).navigable
    })
}

/// Land and shoals that lie over each other, so that there are ponds, needle gaps and detours.
fn islands(numbers: &mut Numbers, count: u32, most_m: f64) -> Sea {
    (0..count).fold(Sea::new(middle(), HALF_M, 30.0), |sea, _| {
        let (at, radius_m) = (numbers.point(HALF_M - most_m), numbers.within(200.0, most_m));
        let ground =
            if numbers.share() < 0.6 { Ground::Land } else { Ground::Depth(numbers.within(1.0, 9.0)) };
        sea.with(ground, at, radius_m, 3 + (6.0 * numbers.share()) as u32)
    })
}

/// Takes seconds: the water of a hundred and sixty kilometres is prepared twice for each chart. What it would find is a corridor
/// that leads the longer way round.
#[test]
fn long_ways_are_safe_and_as_short_as_in_all_water_at_once() {
    let (mut found, mut bent, mut parted, mut longer) = (0, 0, 0, 0);
    for seed in 1..=testkit::so_many(3, 24) {
        let mut numbers = Numbers(seed * 7_919);
        // Few large ones, then many small ones, then so many that there are ponds.
        let (count, most_m) = [(60, 14_000.0), (400, 5_000.0), (420, 9_000.0)][(seed % 3) as usize];
        let index = Arc::new(islands(&mut numbers, count, most_m).index());
        let needs = Needs::depth_and_clearance(5.0, [0.0, 25.0, 200.0][(seed % 3) as usize]);
        let [all, long] = routers(&index);
        for _ in 0..testkit::so_many(8, 40) {
            let [from, to] = [(); 2].map(|()| numbers.point(HALF_M - 2_000.0));
            let request = Request::new(place(from.north_m, from.east_m), place(to.north_m, to.east_m));
            if from.distance_m(to) < 25_000.0 {
                continue;
            }
            let one = all.route(&request, &needs, &Cancel::never());
            let other = long.route(&request, &needs, &Cancel::never());
            match (one, other) {
                (Ok(one), Ok(other)) => {
                    assert!(is_safe(&other, &index, &needs), "{request:?}");
                    assert!(other.of_corridor && !one.of_corridor);
                    let (best_m, length_m) = (one.length_m, other.length_m);
                    // No shorter but for the planes, which are not the same, and where tiles meet.
                    assert!(length_m > 0.9995 * best_m - 5.0, "{length_m} {best_m} {request:?}");
                    longer += usize::from(length_m > 1.001 * best_m + 5.0);
                    assert!(length_m < 1.01 * best_m + 5.0, "{seed}: {length_m} {best_m} {request:?}");
                    assert!(other.least_clearance_m().is_none_or(|clear_m| clear_m >= needs.clearance_m));
                    // Measured to all that lies near, be it outside of the corridor.
                    let [clear_m, other_m] =
                        [&one, &other].map(|route| route.least_clearance_m().unwrap_or(5_000.0));
                    assert!(
                        (clear_m - other_m).abs() < 60.0 || (length_m - best_m).abs() > 1.0,
                        "{clear_m} {other_m}"
                    );
                    found += 1;
                    bent += usize::from(one.legs.len() > 2);
                }
                // Corridors do not prove that there is no way.
                (Err(Refusal::NoWay { .. }), Err(Refusal::TooFar { .. })) => parted += 1,
                (Err(Refusal::Closed { .. }), Err(Refusal::TooFar { .. })) => {}
                (Err(Refusal::Closed { end, .. }), Err(Refusal::Closed { end: same, .. })) => {
                    assert_eq!(end, same);
                }
                (one, other) => panic!("{request:?} {needs:?}: {one:?} {other:?}"),
            }
        }
    }
    assert!(found > 8 && bent > 6 && parted >= testkit::so_many(0, 1), "{found} {bent} {parted}");
    assert!(longer * 50 <= found, "{longer} of {found} are longer by more than a thousandth");
}

#[test]
fn the_water_of_a_corridor_is_prepared_once_and_kept_while_an_end_is_dragged() {
    let index = Arc::new(islands(&mut Numbers(5), 60, 8_000.0).index());
    let [_, long] = routers(&index);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let looks = |to: LatLon| {
        let looks = std::cell::Cell::new(0);
        let wanted = || {
            looks.set(looks.get() + 1);
            true
        };
        let request = Request::new(place(-76_000.0, -70_000.0), to);
        long.route(&request, &needs, &Cancel::unless(&wanted)).unwrap();
        looks.get()
    };
    let cold = looks(place(76_000.0, 70_000.0));
    let rooms = long.kept().0;
    for step in 0..20 {
        let warm = looks(place(76_000.0 - 20.0 * f64::from(step), 70_000.0));
        assert!(warm * 3 < cold, "{warm} {cold}");
    }
    assert_eq!(long.kept().0, rooms, "nothing more was prepared");
    let called_off = Request::new(place(-76_000.0, -70_000.0), place(76_000.0, 60_000.0));
    let other = Needs::depth_and_clearance(5.0, 40.0);
    let answer = long.route(&called_off, &other, &Cancel::unless(&|| false));
    assert_eq!(answer, Err(Refusal::Plan(PlanError::Cancelled)));
}

#[test]
fn to_a_pond_at_the_end_of_a_long_way_none_is_found_and_none_is_said_not_to_exist() {
    let ring = (0..24).map(|n| (f64::from(n) / 24.0 * std::f64::consts::TAU).sin_cos());
    let sea = ring.fold(Sea::new(middle(), HALF_M, 20.0), |sea, (sin, cos)| {
        let at = LocalPoint { north_m: 60_000.0 + 3_000.0 * sin, east_m: 3_000.0 * cos };
        sea.with(Ground::Land, at, 700.0, 12)
    });
    let [_, long] = routers(&Arc::new(sea.index()));
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let (open, pond) = (place(-60_000.0, 0.0), place(60_000.0, 0.0));
    for (from, to) in [(open, pond), (pond, open)] {
        let refusal = long.route(&Request::new(from, to), &needs, &Cancel::never());
        assert!(matches!(refusal, Err(Refusal::TooFar { .. })), "{refusal:?}");
    }
    // What would do is not looked for among so many lines.
    let would_do = long.passable(&Request::new(open, pond), &needs, &Cancel::never()).unwrap();
    assert_eq!((would_do.depth_m, would_do.clearance_m), (None, None));
    let ashore = place(63_000.0, 0.0);
    match long.route(&Request { move_up_to_m: 100.0, ..Request::new(open, ashore) }, &needs, &Cancel::never())
    {
        Err(Refusal::Closed { end: End::Goal, nearest_m: Some(_), .. } | Refusal::TooFar { .. }) => {}
        other => panic!("{other:?}"),
    }
    let moved = long.route(&Request::new(ashore, open), &needs, &Cancel::never()).unwrap();
    assert!((700.0..1_000.0).contains(&moved.moved_start.unwrap().distance_m), "{moved:?}");
}

#[test]
fn long_ways_keep_to_zones_and_to_a_wall_of_many_tiles_with_one_gap() {
    // A wall from west to east whose gap lies far to the east, then a zone across the gap.
    let wall = (0..70).fold(Sea::new(middle(), HALF_M, 20.0), |sea, n| {
        let at = LocalPoint { north_m: 300.0, east_m: -78_500.0 + 2_000.0 * f64::from(n) };
        sea.with(Ground::Land, at, 1_600.0, 8)
    });
    let index = Arc::new(wall.index());
    let [all, long] = routers(&index);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let request = Request::new(place(-30_000.0, -50_000.0), place(30_000.0, -50_000.0));
    let [one, other] = [&all, &long].map(|router| router.route(&request, &needs, &Cancel::never()).unwrap());
    assert!(is_safe(&other, &index, &needs));
    assert!((one.length_m / other.length_m - 1.0).abs() < 1e-3, "{} {}", one.length_m, other.length_m);
    let corners = [(-2_000.0, 50_000.0), (-2_000.0, 79_980.0), (2_000.0, 79_980.0), (2_000.0, 50_000.0)];
    let closed = Zone::new(corners.map(|(north_m, east_m)| place(north_m, east_m)).to_vec()).unwrap();
    let zoned = long.in_zones(Zones::new(None, vec![closed], 60.0).unwrap());
    assert!(matches!(zoned.route(&request, &needs, &Cancel::never()), Err(Refusal::TooFar { .. })));
    let corners = [(-2_000.0, 58_000.0), (-2_000.0, 70_000.0), (2_000.0, 70_000.0), (2_000.0, 58_000.0)];
    let narrowed = Zone::new(corners.map(|(north_m, east_m)| place(north_m, east_m)).to_vec()).unwrap();
    let zoned = long.in_zones(Zones::new(None, vec![narrowed], 60.0).unwrap());
    let around = zoned.route(&request, &needs, &Cancel::never()).unwrap();
    assert!(is_safe(&around, &index, &needs) && around.length_m > other.length_m + 1_000.0);
}

#[test]
fn a_corridor_of_too_much_chart_is_refused_with_how_far_apart_ends_may_lie() {
    let index = Arc::new(islands(&mut Numbers(9), 60, 8_000.0).index());
    let [_, long] = routers(&index);
    let needs = Needs::depth_and_clearance(5.0, 25.0);
    let request = Request::new(place(-76_000.0, -70_000.0), place(76_000.0, 70_000.0));
    for most in [0, 3] {
        let small = long.in_zones(Zones::default()).in_corridors(most);
        let refusal = small.route(&request, &needs, &Cancel::never());
        assert!(matches!(refusal, Err(Refusal::TooFar { .. })), "{refusal:?}");
    }
}
