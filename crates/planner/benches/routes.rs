//! How long routes take: preparing the water, asking, and the classic grid beside. `cargo bench -p planner` runs this on
//! the shared charts; without them it says so and measures nothing. `LUTRA_GRID=FILE` writes the classic grid for other planners:
//! `scripts/bench-routes` runs those beside. With `-- refusals` only what would do where there is no way is measured.

#![expect(clippy::disallowed_methods, reason = "a bench looks at the clock")]
#![expect(clippy::unwrap_used, reason = "a bench fails where it unwraps nothing")]
#![expect(clippy::print_stdout, reason = "this is what it is for")]

#[path = "common/grid.rs"]
mod grid;
#[path = "common/table.rs"]
mod table;

use charts::depth_index::{DepthIndex, IndexBuilder, Leg};
use charts::s57::{Area, Cell, GeoPoint, NamedBytes, Path};
use planner::classic::ClassicGrid;
use planner::{Cancel, Needs, Refusal, Request, Route, Router, SeaRoom};
use std::path::Path as FilePath;
use std::sync::Arc;
use std::time::{Duration, Instant};
use table::Row;
use testkit::Numbers;
use units::LatLon;

/// The name of the coast in the table.
const COAST: &str = "land of Trøndelag";
/// Routes that are asked for on each chart.
const ROUTES: usize = 1_000;

fn main() {
    let Some(folder) = testkit::shared("data/charts") else {
        println!("the shared charts are absent: nothing is measured");
        return;
    };
    if std::env::args().any(|argument| argument == "refusals") {
        return refusals(&folder);
    }
    println!("needs: 5 m deep, 25 m clear unless told; times on one core; lengths on WGS 84\n");
    for cells in
        [&["GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE", "GB5X02SE"][..], &["US5WA22M"], &["US4MD81M"]]
    {
        let index = of_cells(&folder, cells);
        let mut longest = None;
        for clearance_m in [0.0, 10.0, 60.0, 190.0, 500.0, 25.0] {
            longest = chart(&cells.join("+"), &index, 5.0, clearance_m);
        }
        if let Some(longest) = longest {
            beside_grids(cells[0], &index, &longest);
        }
    }
    refusals(&folder);
    let coast = coast(&folder);
    chart(COAST, &coast, 0.0, 25.0);
    across_trondelag(&coast);
}

/// What would do where there is no way.
fn refusals(folder: &FilePath) {
    for (name, index, depth_m, clearance_m) in [
        ("archipelago", archipelago(), 5.0, 190.0),
        ("archipelago", archipelago(), 8.0, 60.0),
        ("US4MD81M", of_cells(folder, &["US4MD81M"]), 5.0, 100.0),
    ] {
        let needs = Needs::depth_and_clearance(depth_m, clearance_m);
        what_would_do(name, &index, &needs, f64::INFINITY);
        what_would_do(name, &index, &needs, 5_000.0);
    }
}

/// Random pairs in open water; the longest route between them.
fn chart(name: &str, index: &Arc<DepthIndex>, depth_m: f64, clearance_m: f64) -> Option<Route> {
    let needs = Needs::depth_and_clearance(depth_m, clearance_m);
    let begun = Instant::now();
    let room = SeaRoom::of_chart(index, &needs, &Arc::default(), &Cancel::never()).unwrap();
    println!(
        "{name}, {clearance_m} m clear: {} vertices, prepared in {:.0} ms, {} triangles, {:.1} MiB",
        index.vertex_count(),
        begun.elapsed().as_secs_f64() * 1e3,
        room.triangles(),
        room.bytes() as f64 / f64::from(1 << 20)
    );
    drop(room);
    let router = Router::new(Arc::clone(index));
    let extent = index.extent().unwrap();
    let mut numbers = Numbers(7);
    let mut asked: Vec<(Duration, Route)> = Vec::new();
    for _ in 0..20 * ROUTES {
        if asked.len() >= ROUTES {
            break;
        }
        let mut place = || {
            let lat = numbers.within(extent.south_deg, extent.north_deg);
            LatLon::from_deg(lat, numbers.within(extent.west_deg, extent.east_deg)).unwrap()
        };
        let request = Request { move_up_to_m: 0.0, ..Request::new(place(), place()) };
        let begun = Instant::now();
        if let Ok(route) = router.route(&request, &needs, &Cancel::never()) {
            asked.push((begun.elapsed(), route));
        }
    }
    if asked.len() < 2 {
        println!("  {} routes were found: nothing to tell", asked.len());
        return None;
    }
    // The first one prepared the water.
    asked.remove(0);
    asked.sort_by_key(|(took, _)| *took);
    let at = |share: f64| asked[((asked.len() - 1) as f64 * share) as usize].0.as_secs_f64() * 1e3;
    let mean_m = asked.iter().map(|(_, route)| route.length_m).sum::<f64>() / asked.len() as f64;
    println!(
        "  {} routes of {:.1} km on average, checked leg by leg: median {:.2} ms, 90 % {:.2} ms, 99 % {:.2} ms",
        asked.len(),
        mean_m / 1e3,
        at(0.5),
        at(0.9),
        at(0.99)
    );
    alternatives(&router, &needs, asked.iter().map(|(_, route)| route));
    let routes = asked.into_iter().map(|(_, route)| route);
    routes.max_by(|one, other| one.length_m.total_cmp(&other.length_m))
}

/// The same questions with two other routes each.
fn alternatives<'a>(router: &Router, needs: &Needs, routes: impl Iterator<Item = &'a Route>) {
    let mut took_ms = Vec::new();
    let mut found = [0; 3];
    for route in routes {
        let request =
            Request { move_up_to_m: 0.0, alternatives: 2, ..Request::new(route.start, route.goal()) };
        let begun = Instant::now();
        if let Ok(route) = router.route(&request, needs, &Cancel::never()) {
            took_ms.push(begun.elapsed().as_secs_f64() * 1e3);
            found[route.alternatives.len()] += 1;
        }
    }
    took_ms.sort_by(f64::total_cmp);
    let at = |share: f64| took_ms[((took_ms.len() - 1) as f64 * share) as usize];
    println!(
        "  the same with up to two alternatives: {} have one, {} have two: median {:.2} ms, 90 % {:.2} ms, 99 % {:.2} ms",
        found[1],
        found[2],
        at(0.5),
        at(0.9),
        at(0.99)
    );
}

/// Random pairs, at most so far apart, between which there is no way: which smaller depth and clearance would give one.
fn what_would_do(name: &str, index: &Arc<DepthIndex>, needs: &Needs, apart_m: f64) {
    const PAIRS: usize = 12;
    let router = Router::new(Arc::clone(index));
    let extent = index.extent().unwrap();
    let mut numbers = Numbers(11);
    let mut request = || {
        let lat = numbers.within(extent.south_deg, extent.north_deg);
        let from = LatLon::from_deg(lat, numbers.within(extent.west_deg, extent.east_deg)).unwrap();
        let around_deg = (apart_m / 111_000.0).min(90.0);
        let lat = numbers
            .within((lat - around_deg).max(extent.south_deg), (lat + around_deg).min(extent.north_deg));
        let around_deg = (around_deg / from.lat_rad().cos()).min(180.0);
        let [west, east] = [from.lon_deg() - around_deg, from.lon_deg() + around_deg];
        let lon = numbers.within(west.max(extent.west_deg), east.min(extent.east_deg));
        Request::new(from, LatLon::from_deg(lat, lon).unwrap())
    };
    let apart = |request: &Request| {
        matches!(router.route(request, needs, &Cancel::never()), Err(Refusal::NoWay { .. }))
    };
    let requests: Vec<Request> =
        std::iter::repeat_with(&mut request).take(20 * ROUTES).filter(apart).take(PAIRS).collect();
    let mut took_ms: Vec<f64> = Vec::new();
    let (mut depths, mut clearances) = (0, 0);
    for request in &requests {
        let begun_ms = processor_ms();
        let passable = router.passable(request, needs, &Cancel::never()).unwrap();
        took_ms.push(processor_ms() - begun_ms);
        depths += usize::from(passable.depth_m.is_some());
        clearances += usize::from(passable.clearance_m.is_some());
    }
    took_ms.sort_by(f64::total_cmp);
    let at = |share: f64| {
        took_ms.get(((took_ms.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0)
    };
    println!(
        "{name}: what would do instead of {:.0} m deep and {:.0} m clear, up to {:.0} km apart: {} asked, {depths} with another \
         depth, {clearances} with another clearance: median {:.0} ms, 90 % {:.0} ms, longest {:.0} ms of processor time",
        needs.demand.needed_m(),
        needs.clearance_m,
        apart_m / 1e3,
        requests.len(),
        at(0.5),
        at(0.9),
        at(1.0)
    );
}

/// Processor time of this thread (ms), which other jobs on the computer lengthen little.
fn processor_ms() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    told.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}

fn archipelago() -> Arc<DepthIndex> {
    let mut builder = IndexBuilder::new();
    for file in charts::demo::archipelago().unwrap() {
        let named = NamedBytes { name: file.name, bytes: &file.bytes };
        builder.add_cell(&Cell::read(named, &[]).unwrap()).unwrap();
    }
    Arc::new(builder.build().unwrap())
}

/// The thesis' kind of question: 80 km with detours, beside the classic grid of 100 m.
fn across_trondelag(index: &Arc<DepthIndex>) {
    let ends = [(63.4489, 10.4093), (63.6700, 9.0800)].map(|(lat, lon)| LatLon::from_deg(lat, lon).unwrap());
    let request = Request::new(ends[0], ends[1]);
    println!(
        "\nfrom Trondheim out to sea, {:.1} km straight:",
        Leg { from: ends[0], to: ends[1] }.length_m() / 1e3
    );
    let mut moved = ends;
    for clearance_m in [0.0, 25.0] {
        let router = Router::new(Arc::clone(index));
        let needs = Needs::depth_and_clearance(0.0, clearance_m);
        let ask = || router.route(&request, &needs, &Cancel::never());
        by_lines((COAST, clearance_m), ask);
        if let Ok(route) = ask() {
            moved = [route.start, route.goal()];
        }
    }
    let demand = Needs::depth_and_clearance(0.0, 0.0).demand;
    let middle = LatLon::from_deg(63.56, 9.75).unwrap();
    let begun = Instant::now();
    let grid = ClassicGrid::new(index, &demand, middle, (50_000.0, 100.0), &Cancel::never()).unwrap();
    let prepared = begun.elapsed();
    println!("  classic grid of 100 m: {} open cells in {:.1} s", grid.open_cells(), prepared.as_secs_f64());
    if let Some(file) = std::env::var_os("LUTRA_GRID") {
        grid::write(FilePath::new(&file), &grid, 100.0, moved, &serde_json::Value::Null);
    }
    grid::by_a_star(COAST, (&grid, prepared.as_secs_f64() * 1e3), moved);
}

/// One route, cold and warm, and on a grid of 50 m over its water, which other planners get too.
fn beside_grids(name: &str, index: &Arc<DepthIndex>, longest: &Route) {
    let ends = [longest.start, longest.goal()];
    let request = Request { move_up_to_m: 0.0, ..Request::new(ends[0], ends[1]) };
    println!("\nthe longest of these routes in {name}, beside others:");
    for clearance_m in [0.0, 25.0] {
        let router = Router::new(Arc::clone(index));
        let needs = Needs::depth_and_clearance(5.0, clearance_m);
        by_lines((name, clearance_m), || router.route(&request, &needs, &Cancel::never()));
    }
    let places: Vec<LatLon> = longest.places().collect();
    let demand = Needs::depth_and_clearance(5.0, 0.0).demand;
    let begun = Instant::now();
    let grid =
        ClassicGrid::covering(index, &demand, (ends[0], &places), (2_000.0, 50.0), &Cancel::never()).unwrap();
    let laid_ms = begun.elapsed().as_secs_f64() * 1e3;
    if ends.iter().any(|end| grid.cell_of(*end).is_none()) {
        return println!("  an end lies in a closed cell: no grid is searched");
    }
    if let Some(folder) = std::env::var_os("LUTRA_GRIDS") {
        grid::write(&FilePath::new(&folder).join(name), &grid, 50.0, ends, &serde_json::Value::Null);
    }
    grid::by_a_star(name, (&grid, laid_ms), ends);
}

/// A route asked for once in water that is not prepared, and again.
fn by_lines((water, clearance_m): (&str, f64), ask: impl Fn() -> Result<Route, Refusal>) {
    const AGAIN: u32 = 100;
    let begun = Instant::now();
    let route = match ask() {
        Ok(route) => route,
        Err(refusal) => return println!("  {clearance_m:>2} m clear: {refusal}"),
    };
    let first_ms = begun.elapsed().as_secs_f64() * 1e3;
    let begun = Instant::now();
    (0..AGAIN).for_each(|_| drop(ask()));
    let again_ms = begun.elapsed().as_secs_f64() * 1e3 / f64::from(AGAIN);
    let (length_m, nodes) = (route.length_m, route.effort.intervals);
    println!(
        "  {clearance_m:>2} m clear: {length_m:.1} m in {} legs; cold {first_ms:.0} ms, warm {again_ms:.2} ms, {nodes} intervals",
        route.legs.len()
    );
    let planner = format!("Lutra, {clearance_m} m clear, every leg checked");
    let (planner, again_ms) = (planner.as_str(), Some(again_ms));
    Row { water, planner, prepared_ms: None, first_ms, again_ms, length_m, nodes }.note();
}

fn of_cells(folder: &FilePath, names: &[&str]) -> Arc<DepthIndex> {
    let mut builder = IndexBuilder::new();
    for name in names {
        let file = |number: u32| format!("{name}.{number:03}");
        let read = |name: String| (std::fs::read(folder.join(&name)).unwrap(), name);
        let files: Vec<(Vec<u8>, String)> =
            (0..1_000).map(file).take_while(|name| folder.join(name).exists()).map(read).collect();
        let named: Vec<NamedBytes<'_>> =
            files.iter().map(|(bytes, name)| NamedBytes { name, bytes }).collect();
        builder.add_cell(&Cell::read(named[0], &named[1..]).unwrap()).unwrap();
    }
    Arc::new(builder.build().unwrap())
}

/// Water of one depth around the land of a file.
fn coast(folder: &FilePath) -> Arc<DepthIndex> {
    let text = std::fs::read_to_string(folder.join("trondelag_land_osm.geojson")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let ring = |ring: &serde_json::Value| Path {
        points: ring
            .as_array()
            .unwrap()
            .iter()
            .map(|at| GeoPoint { lon_deg: at[0].as_f64().unwrap(), lat_deg: at[1].as_f64().unwrap() })
            .collect(),
        edges: Vec::new(),
    };
    let area = |polygon: &serde_json::Value| {
        let rings: Vec<Path> = polygon.as_array().unwrap().iter().map(ring).collect();
        Area { exteriors: vec![rings[0].clone()], holes: rings[1..].to_vec() }
    };
    let mut land = Vec::new();
    for feature in file["features"].as_array().unwrap() {
        let geometry = &feature["geometry"];
        match geometry["type"].as_str().unwrap() {
            "Polygon" => land.push(area(&geometry["coordinates"])),
            "MultiPolygon" => land.extend(geometry["coordinates"].as_array().unwrap().iter().map(area)),
            _ => {}
        }
    }
    let points = || land.iter().flat_map(|area| area.exteriors.iter()).flat_map(|ring| &ring.points);
    let least = |value: fn(&GeoPoint) -> f64| points().map(value).fold(f64::INFINITY, f64::min);
    let most = |value: fn(&GeoPoint) -> f64| points().map(value).fold(f64::NEG_INFINITY, f64::max);
    let (west, east) = (least(|at| at.lon_deg), most(|at| at.lon_deg));
    let (south, north) = (least(|at| at.lat_deg), most(|at| at.lat_deg));
    let sea = testkit::sea::open_water([west, south, east, north], 100.0);
    let mut builder = IndexBuilder::new();
    builder.add_features(sea.0, &sea.1).unwrap();
    builder.add_land("land", &land).unwrap();
    Arc::new(builder.build().unwrap())
}
