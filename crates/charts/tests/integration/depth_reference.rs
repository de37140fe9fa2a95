//! The depth index against a reference that looks at every object of every cell, without any index.
//!
//! The reference is slow and plain: even-odd over all vertices in degrees, distances in a frame at the sample.
//! A corridor is sampled along its leg every 0.1 m.

use charts::depth_index::{ChartTrust, Demand, DepthIndex, IndexBuilder, Leg, Restriction, Water};
use charts::s57::{AttributeCode, Cell, Feature, GeoPoint, Geometry, NamedBytes, ObjectClass, SKIN_CLASSES};
use std::sync::OnceLock;
use units::{LatLon, LocalFrame, LocalPoint};

struct Charts {
    /// The best first.
    cells: Vec<Cell>,
    index: DepthIndex,
}

fn read(name: &str, updates: u32) -> Option<Cell> {
    let names: Vec<String> = (0..=updates).map(|number| format!("{name}.{number:03}")).collect();
    let mut files = Vec::new();
    for name in &names {
        files.push(std::fs::read(testkit::shared(&format!("data/charts/{name}"))?).unwrap());
    }
    let named: Vec<NamedBytes<'_>> =
        names.iter().zip(&files).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Some(Cell::read(named[0], &named[1..]).unwrap())
}

/// Cells that overlap, and one alone with a rugged shore.
fn charts() -> Option<&'static Charts> {
    static CHARTS: OnceLock<Option<Charts>> = OnceLock::new();
    let make = || {
        let mut cells = Vec::new();
        for (name, updates) in
            [("GB4X0000", 0), ("GB5X01NE", 0), ("GB5X01NW", 0), ("GB5X01SE", 0), ("US5WA22M", 4)]
        {
            cells.push(read(name, updates)?);
        }
        cells.sort_by_key(|cell| {
            (
                std::cmp::Reverse(cell.id.band),
                cell.parameters.scale,
                std::cmp::Reverse(cell.id.issue_date.clone()),
                cell.id.name.clone(),
            )
        });
        let mut builder = IndexBuilder::new();
        cells.iter().rev().for_each(|cell| builder.add_cell(cell).unwrap());
        Some(Charts { cells, index: builder.build().unwrap() })
    };
    CHARTS.get_or_init(make).as_ref()
}

/// Numbers in [0, 1) that are the same in every run.
fn numbers(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn holds(feature: &Feature, at: GeoPoint) -> bool {
    let Geometry::Area(area) = &feature.geometry else { return false };
    let mut odd = false;
    for pair in area.rings().flat_map(|ring| ring.points.windows(2)) {
        let (a, b) = (pair[0], pair[1]);
        if (a.lat_deg > at.lat_deg) != (b.lat_deg > at.lat_deg) {
            let t = (at.lat_deg - a.lat_deg) / (b.lat_deg - a.lat_deg);
            odd ^= a.lon_deg + t * (b.lon_deg - a.lon_deg) > at.lon_deg;
        }
    }
    odd
}

fn segment_distance_m(frame: &LocalFrame, a: GeoPoint, b: GeoPoint) -> f64 {
    let (a, b) = (frame.to_local(a.place().unwrap()), frame.to_local(b.place().unwrap()));
    let (dn, de) = (b.north_m - a.north_m, b.east_m - a.east_m);
    let square = dn * dn + de * de;
    let t = if square > 0.0 { (-(a.north_m * dn + a.east_m * de) / square).clamp(0.0, 1.0) } else { 0.0 };
    (a.north_m + t * dn).hypot(a.east_m + t * de)
}

/// Worst first; depths by their value. The same table in other words than the index has it.
fn severity(feature: &Feature) -> Option<f64> {
    const LAND: [&str; 10] =
        ["LNDARE", "PONTON", "HULKES", "FLODOC", "SLCONS", "COALNE", "DAMCON", "CAUSWY", "DYKCON", "DRYDOC"];
    const OBSTACLES: [&str; 17] = [
        "BUISGL", "CRANES", "FORSTC", "FSHFAC", "GATCON", "ICEARE", "LITFLT", "LITVES", "LNDMRK", "LOGPON",
        "MARCUL", "MORFAC", "OFSPLF", "OILBAR", "PILPNT", "PYLONS", "SILTNK",
    ];
    let class = feature.class.acronym().unwrap_or_default();
    let number = |code| feature.number(code);
    if LAND.contains(&class) {
        return Some(-4000.0);
    }
    if OBSTACLES.contains(&class) || class.starts_with("BCN") || class.starts_with("BOY") || class == "DISMAR"
    {
        return Some(-3000.0);
    }
    match class {
        "UNSARE" => Some(-2000.0),
        "DEPARE" | "DRGARE" => Some(number(AttributeCode::DRVAL1).unwrap_or(-2000.0)),
        "UWTROC" | "WRECKS" | "OBSTRN" => {
            let within = feature.text(AttributeCode::WATLEV) == Some("3")
                && feature.text(AttributeCode::EXPSOU) == Some("1");
            let unknown = feature.list(AttributeCode::QUASOU).any(|code| code == 2);
            match number(AttributeCode::VALSOU).filter(|_| !unknown) {
                Some(depth) => Some(depth),
                None if within => None,
                None => Some(-2000.0),
            }
        }
        _ => None,
    }
}

fn of_water(water: Water) -> f64 {
    match water {
        Water::Land => -4000.0,
        Water::Obstacle => -3000.0,
        Water::UnknownDepth => -2000.0,
        Water::NoData => -1000.0,
        Water::TooLow { .. } => -500.0,
        Water::Depth { least_m, .. } => least_m,
    }
}

impl Charts {
    fn answering(&self, at: GeoPoint) -> Option<usize> {
        let covers = |feature: &Feature| {
            feature.class == ObjectClass::M_COVR
                && feature.code(AttributeCode::CATCOV) == Some(1)
                && holds(feature, at)
        };
        self.cells.iter().position(|cell| cell.features.iter().any(covers))
    }

    /// The worst at a point, single dangers left out.
    fn state(&self, at: GeoPoint) -> f64 {
        let Some(cell) = self.answering(at) else { return -1000.0 };
        let inside = self.cells[cell].features.iter().filter(|one| severity(one).is_some() && holds(one, at));
        let (mut skin, mut worst) = (false, f64::INFINITY);
        for feature in inside {
            skin |= SKIN_CLASSES.contains(&feature.class);
            worst = worst.min(severity(feature).unwrap());
        }
        if skin { worst } else { worst.min(-1000.0) }
    }

    /// The strictest restriction at a point.
    fn restriction(&self, at: GeoPoint) -> Option<Restriction> {
        let cell = &self.cells[self.answering(at)?];
        let here: Vec<&Feature> =
            cell.features.iter().filter(|one| severity(one).is_none() && holds(one, at)).collect();
        let all = |code| here.iter().flat_map(move |one| one.list(code));
        let codes: Vec<u32> = all(AttributeCode::RESTRN).collect();
        // Offshore safety zones, military areas and minefields that are not restricted in another way.
        let unsaid = here.iter().filter(|one| one.list(AttributeCode::RESTRN).next().is_none());
        let areas = unsaid.filter(|one| one.class.acronym() == Some("RESARE"));
        let kept_out_of =
            areas.flat_map(|one| one.list(AttributeCode::CATREA)).any(|code| [1, 9, 14].contains(&code));
        if codes.contains(&7) {
            return Some(Restriction::EntryProhibited);
        }
        (kept_out_of || codes.iter().any(|code| [8, 14].contains(code)))
            .then_some(Restriction::EntryRestricted)
    }

    /// Objects of a cell near a place, with their severity.
    fn near(&self, cell: usize, at: GeoPoint, reach_m: f64) -> Vec<(&Feature, f64)> {
        let (dlat, dlon) = (reach_m / 111_000.0, reach_m / 111_000.0 / at.lat_deg.to_radians().cos());
        let touches = |feature: &&Feature| {
            let mut low = (f64::INFINITY, f64::INFINITY);
            let mut high = (f64::NEG_INFINITY, f64::NEG_INFINITY);
            for point in feature.geometry.points() {
                low = (low.0.min(point.lon_deg), low.1.min(point.lat_deg));
                high = (high.0.max(point.lon_deg), high.1.max(point.lat_deg));
            }
            low.0 <= at.lon_deg + dlon
                && high.0 >= at.lon_deg - dlon
                && low.1 <= at.lat_deg + dlat
                && high.1 >= at.lat_deg - dlat
        };
        let features = self.cells[cell].features.iter().filter(touches);
        features
            .filter_map(|one| {
                let severity = if one.class == ObjectClass::SOUNDG { Some(f64::NAN) } else { severity(one) };
                severity.map(|severity| (one, severity))
            })
            .collect()
    }

    /// The worst object that comes within `reach_m` of a leg's samples, among the objects of one cell.
    fn corridor(&self, cell: usize, samples: &[LatLon], reach_m: f64) -> f64 {
        let middle = samples[samples.len() / 2];
        let all_m =
            LocalFrame::new(middle).to_local(samples[0]).distance_m(LocalPoint::default()) + reach_m + 5.0;
        let at = GeoPoint { lon_deg: middle.lon_deg(), lat_deg: middle.lat_deg() };
        let near = self.near(cell, at, all_m);
        // Segments once, so that 0.1 m steps stay affordable.
        let mut pieces: Vec<(GeoPoint, GeoPoint, f64)> = Vec::new();
        let frame = LocalFrame::new(middle);
        for (feature, severity) in &near {
            let mut add = |points: &[GeoPoint]| {
                let close = |pair: &&[GeoPoint]| segment_distance_m(&frame, pair[0], pair[1]) <= all_m;
                pieces.extend(points.windows(2).filter(close).map(|pair| (pair[0], pair[1], *severity)));
            };
            match &feature.geometry {
                Geometry::Point(point) => pieces.push((*point, *point, *severity)),
                Geometry::Soundings(list) => {
                    pieces.extend(list.iter().map(|one| (one.at, one.at, one.depth_m)));
                }
                Geometry::Lines(paths) => paths.iter().for_each(|path| add(&path.points)),
                Geometry::Area(area) => area.rings().for_each(|ring| add(&ring.points)),
                Geometry::None | Geometry::Unreadable { .. } => {}
            }
        }
        let mut worst = f64::INFINITY;
        for (at, sample) in samples.iter().enumerate() {
            let frame = LocalFrame::new(*sample);
            for (a, b, severity) in &pieces {
                if *severity < worst && segment_distance_m(&frame, *a, *b) <= reach_m {
                    worst = *severity;
                }
            }
            // The state changes only where a border is crossed, which the pieces show.
            if at == 0 {
                let point = GeoPoint { lon_deg: sample.lon_deg(), lat_deg: sample.lat_deg() };
                worst = worst.min(self.state(point));
            }
        }
        worst
    }
}

fn samples(leg: Leg) -> Vec<LatLon> {
    let frame = LocalFrame::new(leg.from);
    let to = frame.to_local(leg.to);
    let count = (to.distance_m(LocalPoint::default()) / 0.1).ceil().max(1.0) as usize;
    let at = |step: usize| {
        let t = step as f64 / count as f64;
        frame.to_place(LocalPoint { north_m: to.north_m * t, east_m: to.east_m * t })
    };
    (0..=count).map(at).collect()
}

/// Boxes (south, west, north, east) with the cell that answers everywhere within, if one does.
const TACOMA: [f64; 4] = [47.231, -122.552, 47.325, -122.354];
const MICKLEFIRTH: [f64; 4] = [-32.64, 60.75, -32.30, 61.35];

fn within(area: [f64; 4], next: &mut impl FnMut() -> f64) -> LatLon {
    let [south, west, north, east] = area;
    LatLon::from_deg(south + (north - south) * next(), west + (east - west) * next()).unwrap()
}

#[test]
fn points_have_the_depth_that_a_scan_of_all_polygons_finds() {
    let Some(charts) = charts() else { return };
    let mut next = numbers(7);
    let mut closed = 0;
    let count = testkit::so_many(3_000, 10_000);
    for at in 0..count {
        let area = if at % 2 == 0 { TACOMA } else { MICKLEFIRTH };
        let place = within(area, &mut next);
        let expected = charts.state(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() });
        let found = charts.index.depth_at(place, &Demand::default());
        assert!(
            (of_water(found.water) - expected).abs() < 1e-9,
            "{place:?}: {found:?} instead of {expected}"
        );
        let area = charts.restriction(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() });
        assert_eq!(found.area.map(|area| area.restriction), area, "{place:?}");
        closed += usize::from(area.is_some());
    }
    println!("{closed} of {count} places lie where entry is prohibited or restricted");
}

#[test]
fn no_corridor_is_deeper_than_its_samples_and_none_shallower_than_its_margin() {
    let Some(charts) = charts() else { return };
    let tacoma = charts.cells.iter().position(|cell| cell.id.name == "US5WA22M.000").unwrap();
    let mut next = numbers(11);
    let mut tested = 0;
    while tested < testkit::so_many(150, 400) {
        let from = within(TACOMA, &mut next);
        let way = LocalPoint::default().displaced(std::f64::consts::TAU * next(), 5.0 + 200.0 * next());
        let leg = Leg { from, to: LocalFrame::new(from).to_place(way) };
        let half_width_m = 30.0 * next();
        let samples = samples(leg);
        let inside = |place: &LatLon| {
            charts.answering(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() }) == Some(tacoma)
        };
        // Borders of coverage are another test's; most of the box is well within.
        if !inside(&leg.from) || !inside(&leg.to) {
            continue;
        }
        let found = charts.index.shallowest_along(leg, half_width_m, &Demand::default());
        if found.water == Water::NoData {
            continue;
        }
        tested += 1;
        let exact = charts.corridor(tacoma, &samples, half_width_m);
        let wide = charts.corridor(tacoma, &samples, found.half_width_m + 0.2);
        let value = of_water(found.water);
        assert!(value <= exact + 1e-9, "{leg:?} {half_width_m}: {found:?} but samples find {exact}");
        assert!(
            value >= wide - 1e-9,
            "{leg:?} {half_width_m}: {found:?} but nothing within the margin is below {wide}"
        );
        assert!(found.half_width_m - half_width_m < 0.15, "{found:?}");
        for depth_m in [0.0, 1.0, 5.0, 20.0] {
            let danger = charts.index.first_danger_along(leg, half_width_m, &Demand::least_depth(depth_m));
            let Some(danger) = danger else {
                assert!(value >= depth_m, "{leg:?}: {found:?} is below {depth_m}, but no danger was found");
                continue;
            };
            assert!(value < depth_m && !danger.navigable, "{leg:?}: {danger:?} {found:?}");
            check_that_nothing_comes_before(charts, tacoma, &samples, half_width_m, depth_m, danger.along_m);
        }
    }
}

/// Up to 0.3 m before the first danger the corridor is free of it.
fn check_that_nothing_comes_before(
    charts: &Charts,
    cell: usize,
    samples: &[LatLon],
    half_width_m: f64,
    depth_m: f64,
    along_m: f64,
) {
    let before = ((along_m - 0.3) / 0.1).floor();
    if before > 1.0 {
        let worst = charts.corridor(cell, &samples[..before as usize], half_width_m);
        assert!(
            worst >= depth_m,
            "{worst} lies before {along_m} m, where {depth_m} m is said to be missed first"
        );
    }
}

#[test]
fn where_cells_overlap_and_end_no_point_of_a_corridor_is_worse_than_it() {
    let Some(charts) = charts() else { return };
    let mut next = numbers(13);
    // Round the finer cells' borders, where scales meet, and round the outer border, where data end.
    let borders: Vec<GeoPoint> = charts
        .cells
        .iter()
        .flat_map(|cell| cell.of_class(ObjectClass::M_COVR))
        .flat_map(|one| one.geometry.points().collect::<Vec<_>>())
        .collect();
    let mut seams = 0;
    for _ in 0..120 {
        let pick = (next() * (borders.len() - 1) as f64) as usize;
        let (a, b, t) = (borders[pick], borders[pick + 1], next());
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let Ok(near) = LatLon::from_deg(mix(a.lat_deg, b.lat_deg), mix(a.lon_deg, b.lon_deg)) else {
            continue;
        };
        let frame = LocalFrame::new(near);
        let mut beside =
            || frame.to_place(LocalPoint { north_m: 160.0 * next() - 80.0, east_m: 160.0 * next() - 80.0 });
        let leg = Leg { from: beside(), to: beside() };
        let half_width_m = 25.0 * next();
        let found = charts.index.shallowest_along(leg, half_width_m, &Demand::default());
        let value = of_water(found.water);
        let (from, to) = (frame.to_local(leg.from), frame.to_local(leg.to));
        let mut answering = std::collections::BTreeSet::new();
        for _ in 0..60 {
            let t = next();
            let on = LocalPoint {
                north_m: from.north_m + t * (to.north_m - from.north_m),
                east_m: from.east_m + t * (to.east_m - from.east_m),
            };
            let at = on.displaced(std::f64::consts::TAU * next(), half_width_m * next().sqrt());
            let place = frame.to_place(at);
            let point = GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() };
            answering.insert(charts.answering(point));
            let worst = charts.state(point);
            assert!(value <= worst + 1e-9, "{leg:?} {half_width_m}: {found:?}, but {place:?} has {worst}");
        }
        // And what is found is there: a point within 10 cm of the answer's has it, or it is a single danger or
        // a line, which no point holds.
        let object = found.object.and_then(|id| charts.index.object(id));
        let skin = object.is_none_or(|object| SKIN_CLASSES.contains(&object.class));
        if skin {
            let frame = LocalFrame::new(found.at);
            let around = (0..16).map(|at| f64::from(at) * std::f64::consts::TAU / 16.0);
            let states: Vec<f64> = around
                .map(|bearing| {
                    let place = frame.to_place(LocalPoint::default().displaced(bearing, 0.1));
                    charts.state(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() })
                })
                .collect();
            assert!(
                states.iter().any(|state| *state <= value + 1e-9),
                "{leg:?}: {found:?}, but around it {states:?}"
            );
        }
        seams += usize::from(answering.len() > 1);
    }
    assert!(seams > 30, "only {seams} corridors ran over a seam");
}

/// 1 km of shore has no zone of confidence, and needs none: land is land.
#[test]
fn land_beside_a_survey_does_not_make_the_survey_worse() {
    let Some(charts) = charts() else { return };
    let demand = Demand { trust: ChartTrust::AllErrors(ChartTrust::STANDARD), ..Demand::least_depth(5.0) };
    let place = LatLon::from_deg(47.306_099, -122.456_875).unwrap();
    let found = charts.index.shallowest_within(place, 0.0, &demand);
    assert_eq!((found.zone, found.navigable), (Some(1), true), "{found:?}");
    assert!(found.half_width_m < 6.0, "{found:?}");
}
