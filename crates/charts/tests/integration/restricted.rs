//! Areas whose entry is prohibited or restricted: what the index says of them, against a search that knows no index.

use charts::coverage::Source;
use charts::depth_index::{
    Demand, DepthIndex, EntryRule, EntryRules, GeoBox, IndexBuilder, IndexBytes, Leg, Restriction, Water,
};
use charts::s57::{Area, Attribute, AttributeCode, Feature, GeoPoint, Geometry, Path};
use std::sync::Arc;
use testkit::Numbers;
use testkit::sea::{Ground, Sea, open_water, restricted};
use units::{LatLon, LocalFrame, LocalPoint};

const PROHIBITED: u32 = 7;
const RESTRICTED: u32 = 8;
const TO_BE_AVOIDED: u32 = 14;

fn at(north_m: f64, east_m: f64) -> LocalPoint {
    LocalPoint { north_m, east_m }
}

fn middle() -> LatLon {
    LatLon::from_deg(63.4, 10.4).unwrap()
}

fn demand(prohibited: EntryRule, restricted: EntryRule) -> Demand {
    Demand { entry: EntryRules { prohibited, restricted }, ..Demand::least_depth(5.0) }
}

#[test]
fn an_area_is_told_beside_the_depth_and_closed_by_the_rule_for_it() {
    let sea = Sea::new(middle(), 1_000.0, 20.0);
    let sea = sea.with(Ground::Entry(PROHIBITED), at(0.0, 0.0), 100.0, 12);
    let sea = sea.with(Ground::Entry(TO_BE_AVOIDED), at(0.0, 500.0), 100.0, 12);
    let sea = sea.with(Ground::Entry(1), at(0.0, -500.0), 100.0, 12);
    let index = sea.index();
    let place = |east_m: f64| sea.frame().to_place(at(0.0, east_m));
    let usual = Demand::least_depth(5.0);
    let inside = index.depth_at(place(0.0), &usual);
    assert_eq!((inside.water.least_m(), inside.margin_m, inside.navigable), (Some(20.0), Some(15.0), false));
    let area = inside.area.unwrap();
    assert_eq!((area.restriction, area.rule), (Restriction::EntryProhibited, EntryRule::Refuse));
    let object = index.object(area.object).unwrap();
    assert_eq!(object.class.acronym(), Some("RESARE"));
    assert_eq!(object.restriction(), Some(Restriction::EntryProhibited));
    let avoided = index.depth_at(place(500.0), &usual);
    let area = avoided.area.unwrap();
    assert_eq!((area.restriction, area.rule), (Restriction::EntryRestricted, EntryRule::Warn));
    assert!(avoided.navigable);
    assert_eq!(index.depth_at(place(-500.0), &usual).area, None, "to anchor is another matter");
    // The way from west to east: the area that is refused counts, and the depth is that of the water.
    let leg = Leg { from: place(-300.0), to: place(800.0) };
    for (prohibited, restricted, restriction, navigable) in [
        (EntryRule::Refuse, EntryRule::Warn, Some(Restriction::EntryProhibited), false),
        (EntryRule::Warn, EntryRule::Warn, Some(Restriction::EntryProhibited), true),
        (EntryRule::Ignore, EntryRule::Warn, Some(Restriction::EntryRestricted), true),
        (EntryRule::Warn, EntryRule::Refuse, Some(Restriction::EntryRestricted), false),
        (EntryRule::Ignore, EntryRule::Ignore, None, true),
    ] {
        let demand = demand(prohibited, restricted);
        let answer = index.shallowest_along(leg, 10.0, &demand);
        assert_eq!(answer.area.map(|area| area.restriction), restriction);
        assert_eq!((answer.navigable, answer.water.least_m()), (navigable, Some(20.0)));
        assert_eq!(index.first_danger_along(leg, 10.0, &demand).is_none(), navigable);
        let barriers = index.barriers(&demand, &everywhere()).lines.len();
        let free = index.barriers(&Demand { entry: EntryRules::IGNORE, ..demand }, &everywhere()).lines.len();
        assert_eq!(barriers > free, !navigable, "what is refused is a barrier, and nothing else");
    }
    // 300 m to the middle, 100 m to the border, 10 m of half width; the polygon's corner lies on the way.
    let first = index.first_danger_along(leg, 10.0, &usual).unwrap();
    assert!((first.along_m - 190.0).abs() < 4.0, "{first:?}");
    assert!(matches!(first.water, Water::Depth { .. }));
}

fn everywhere() -> GeoBox {
    GeoBox { west_deg: -180.0, south_deg: -90.0, east_deg: 180.0, north_deg: 90.0 }
}

#[test]
fn a_category_that_ships_keep_out_of_counts_only_without_a_restriction() {
    let with = |attributes: &[(AttributeCode, &str)]| {
        let mut area = restricted(1, square([10.0, 63.0, 10.1, 63.1]), PROHIBITED);
        area.attributes = attributes
            .iter()
            .map(|(code, value)| Attribute { code: *code, value: (*value).to_owned() })
            .collect();
        let (source, water) = open_water([10.0, 63.0, 10.1, 63.1], 20.0);
        let mut builder = IndexBuilder::new();
        builder.add_features(source, water.iter().chain([&area])).unwrap();
        let place = LatLon::from_deg(63.05, 10.05).unwrap();
        builder.build().unwrap().depth_at(place, &Demand::default()).area.map(|area| area.restriction)
    };
    let (category, restriction) = (AttributeCode::CATREA, AttributeCode::RESTRN);
    assert_eq!(with(&[(category, "9")]), Some(Restriction::EntryRestricted));
    assert_eq!(with(&[(category, "4")]), None, "a nature reserve is open unless the chart says otherwise");
    assert_eq!(with(&[(category, "9"), (restriction, "1")]), None);
    assert_eq!(with(&[(category, "4"), (restriction, "3,8,7")]), Some(Restriction::EntryProhibited));
}

/// The strictest restriction of a patch that comes within a distance of the way, and how far along it first does,
/// found by steps of a decimetre.
fn searched(sea: &Sea, (from, to): (LocalPoint, LocalPoint), reach_m: f64) -> Option<(Restriction, f64)> {
    let length_m = from.distance_m(to);
    let steps = (length_m / 0.1).ceil().max(1.0);
    let mut best: Option<(Restriction, f64)> = None;
    for patch in sea.patches() {
        let Ground::Entry(code) = patch.ground else { continue };
        let restriction =
            if code == PROHIBITED { Restriction::EntryProhibited } else { Restriction::EntryRestricted };
        let touches = |step: &u32| {
            let t = f64::from(*step) / steps;
            let north_m = from.north_m + t * (to.north_m - from.north_m);
            let east_m = from.east_m + t * (to.east_m - from.east_m);
            patch.distance_m(at(north_m, east_m)) <= reach_m
        };
        if let Some(step) = (0..=steps as u32).find(touches) {
            let found = (restriction, f64::from(step) / steps * length_m);
            best = Some(best.map_or(found, |best| if found < best { found } else { best }));
        }
    }
    best
}

#[test]
fn the_index_finds_what_a_search_of_all_polygons_finds() {
    let mut numbers = Numbers(31);
    let (mut prohibited, mut weaker, mut open) = (0, 0, 0);
    for _ in 0..testkit::so_many(6, 20) {
        let mut sea = Sea::new(middle(), 1_000.0, 20.0);
        for code in [PROHIBITED, RESTRICTED, TO_BE_AVOIDED] {
            let corners = 3 + (numbers.share() * 8.0) as u32;
            let radius_m = numbers.within(20.0, 200.0);
            sea = sea.with(Ground::Entry(code), numbers.point(700.0), radius_m, corners);
        }
        let index = sea.index();
        for _ in 0..40 {
            let (from, to) = (numbers.point(800.0), numbers.point(800.0));
            let half_width_m = numbers.within(0.0, 60.0);
            let leg = Leg { from: sea.frame().to_place(from), to: sea.frame().to_place(to) };
            let answer = index.shallowest_along(leg, half_width_m, &Demand::default());
            // What lies close to the corridor's edge may count either way.
            let (tight, wide) = (half_width_m - 0.3, answer.half_width_m + 0.3);
            let found = answer.area.map(|area| (area.restriction, area.along_m));
            let (least, most) = (searched(&sea, (from, to), tight), searched(&sea, (from, to), wide));
            let kind = |found: Option<(Restriction, f64)>| found.map(|found| found.0);
            assert!(
                kind(found) == kind(least) || kind(found) == kind(most),
                "{found:?}: {least:?}, {most:?}"
            );
            if let (Some((_, along_m)), Some((_, most_m)), Some((_, least_m))) = (found, most, least)
                && kind(least) == kind(most)
            {
                assert!(
                    (most_m - 0.5..=least_m + 0.5).contains(&along_m),
                    "{along_m}: {most_m} to {least_m}"
                );
            }
            match kind(found) {
                Some(Restriction::EntryProhibited) => prohibited += 1,
                Some(Restriction::EntryRestricted) => weaker += 1,
                None => open += 1,
            }
        }
    }
    println!("{prohibited} prohibited, {weaker} restricted, {open} open");
    assert!(prohibited > 30 && weaker > 30 && open > 30, "{prohibited} {weaker} {open}");
}

fn square([west, south, east, north]: [f64; 4]) -> Geometry {
    let corners = [(west, south), (west, north), (east, north), (east, south), (west, south)];
    let points = corners.map(|(lon_deg, lat_deg)| GeoPoint { lon_deg, lat_deg }).to_vec();
    Geometry::Area(Area { exteriors: vec![Path { points, edges: Vec::new() }], holes: Vec::new() })
}

/// A finer chart in the west over a coarser one, which alone has the area.
fn seam() -> DepthIndex {
    let mut builder = IndexBuilder::new();
    let (fine, features) = open_water([10.0, 63.0, 10.05, 63.1], 20.0);
    builder.add_features(fine, &features).unwrap();
    let (coarse, features) = open_water([10.0, 63.0, 10.1, 63.1], 20.0);
    let coarse = Source { name: "XX4COARSE".to_owned(), band: 4, scale: 50_000, ..coarse };
    let area: Feature = restricted(7, square([10.02, 63.04, 10.08, 63.06]), PROHIBITED);
    builder.add_features(coarse, features.iter().chain([&area])).unwrap();
    builder.build().unwrap()
}

#[derive(Debug)]
struct Bytes(Vec<u8>);

impl IndexBytes for Bytes {
    fn length(&self) -> u64 {
        self.0.len() as u64
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        let from = offset as usize;
        self.0.get(from..from + length).map(<[u8]>::to_vec).ok_or_else(|| "it ends before".to_owned())
    }
}

#[test]
fn where_charts_meet_an_area_begins_at_the_seam() {
    let index = seam();
    let place = |lon_deg: f64| LatLon::from_deg(63.05, lon_deg).unwrap();
    let usual = Demand::least_depth(5.0);
    assert_eq!(index.depth_at(place(10.04), &usual).area, None, "the finer chart answers");
    assert!(index.depth_at(place(10.06), &usual).area.is_some());
    // From the finer chart over the seam, not as far as any other border of the area.
    let leg = Leg { from: place(10.045), to: place(10.055) };
    let to_seam_m = LocalFrame::new(leg.from).to_local(place(10.05)).distance_m(LocalPoint::default());
    let answer = index.shallowest_along(leg, 5.0, &usual);
    let area = answer.area.unwrap();
    assert!((area.along_m - (to_seam_m - 5.0)).abs() < 1.0, "{area:?}");
    assert!(!answer.navigable && answer.water.least_m() == Some(20.0));
    let object = index.object(area.object).unwrap();
    assert_eq!((object.record, index.source(&object).name.as_str()), (7, "XX4COARSE"));
    let beside = Leg { from: place(10.03), to: place(10.045) };
    assert_eq!(index.shallowest_along(beside, 5.0, &usual).area, None);
    // Read piece by piece it answers the same.
    let bytes = index.to_bytes();
    assert!(DepthIndex::from_bytes(&bytes).unwrap() == index);
    let regional = DepthIndex::open(Arc::new(Bytes(bytes)), 0, 1).unwrap();
    let mut numbers = Numbers(8);
    let mut entered = 0;
    for _ in 0..300 {
        let mut any =
            || LatLon::from_deg(numbers.within(63.03, 63.07), numbers.within(10.01, 10.09)).unwrap();
        let leg = Leg { from: any(), to: any() };
        let whole = index.shallowest_along(leg, 20.0, &usual);
        assert_eq!(whole, regional.shallowest_along(leg, 20.0, &usual), "{leg:?}");
        assert_eq!(
            index.first_danger_along(leg, 20.0, &usual),
            regional.first_danger_along(leg, 20.0, &usual)
        );
        entered += usize::from(whole.area.is_some());
    }
    assert!((50..250).contains(&entered), "{entered}");
}
