//! Long ways over much chart: `cargo bench -p planner --bench long`. The shared cell US4MD81M lies side by side in rows, 14 million
//! vertices over 640 by 560 km, in open water of an overview chart; without it nothing is measured. `LUTRA_LONG_ROWS` says how
//! many rows, `LUTRA_LONG_MOST` how many vertices regions may have that are prepared as a whole.

#![expect(clippy::disallowed_methods, reason = "a bench looks at the clock")]
#![expect(clippy::unwrap_used, reason = "a bench fails where it unwraps nothing")]
#![expect(clippy::print_stdout, reason = "this is what it is for")]

#[path = "common/memory.rs"]
mod memory;

use charts::coverage::Source;
use charts::depth_index::{DepthIndex, IndexBuilder, Leg};
use charts::s57::{Area, Cell, Feature, GeoPoint, Geometry, NamedBytes, Path};
use memory::memory;
use planner::{Cancel, Needs, Request, Route, Router};
use std::sync::Arc;
use std::time::Instant;
use units::LatLon;

/// How far apart cells lie (degrees), and how long their rows are.
const STEP_DEG: [f64; 2] = [0.75, 0.9];
const COLUMNS: usize = 8;

fn main() {
    let Some(file) = testkit::shared("data/charts/US4MD81M.000") else {
        println!("the shared charts are absent: nothing is measured");
        return;
    };
    let bytes = std::fs::read(file).unwrap();
    let cell = Cell::read(NamedBytes { name: "US4MD81M.000", bytes: &bytes }, &[]).unwrap();
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<usize>().unwrap());
    let index = Arc::new(coast(&cell, number("LUTRA_LONG_ROWS").unwrap_or(7)));
    let extent = index.extent().unwrap();
    println!("{} vertices, {extent:?}; {}", index.vertex_count(), memory());
    for (depth_m, clearance_m) in [(5.0, 25.0), (2.0, 100.0)] {
        let router = Router::new(Arc::clone(&index));
        let router = number("LUTRA_LONG_MOST").into_iter().fold(router, Router::preparing);
        let needs = Needs::depth_and_clearance(depth_m, clearance_m);
        println!("\n{depth_m} m deep, {clearance_m} m clear:\n");
        println!("| straight | route | first | again | dragged |\n|---|---|---|---|---|");
        let (south, north) = (extent.south_deg + 0.02, extent.north_deg - 0.02);
        let (west, east) = (extent.west_deg + 0.02, extent.east_deg - 0.02);
        for [lat, lon, to_lat, to_lon] in [
            [south, west, f64::midpoint(south, north), east],
            [south, west, north, f64::midpoint(west, east)],
            [f64::midpoint(south, north), west, f64::midpoint(south, north), east],
            [south + 1.2, west + 0.7, north - 0.8, west + 3.1],
        ] {
            asked(&router, &needs, [lat, lon], [to_lat, to_lon]);
        }
        let (rooms, kept) = router.kept();
        println!("\n{rooms} waters of {} MiB are kept; {}", kept >> 20, memory());
    }
}

/// One way for the first time, again, and while its goal is dragged.
fn asked(router: &Router, needs: &Needs, from: [f64; 2], to: [f64; 2]) {
    let at = |[lat, lon]: [f64; 2]| LatLon::from_deg(lat, lon).unwrap();
    let request = Request { move_up_to_m: 8_000.0, ..Request::new(at(from), at(to)) };
    let straight_km = Leg { from: request.from, to: request.to }.length_m() / 1e3;
    let ask = |request: &Request| {
        let begun = Instant::now();
        let answer = router.route(request, needs, &Cancel::never());
        (begun.elapsed().as_secs_f64() * 1e3, answer)
    };
    let (cold_ms, answer) = ask(&request);
    let again_ms = (0..5).map(|_| ask(&request).0).fold(f64::INFINITY, f64::min);
    let dragged = (1..=10).map(|step| {
        let to = at([to[0], to[1] - 0.0005 * f64::from(step)]);
        ask(&Request { to, ..request }).0
    });
    let dragged_ms: Vec<f64> = dragged.collect();
    let result = match &answer {
        Ok(Route { length_m, legs, of_part, moved_start, moved_goal, .. }) => {
            let moved = [("start", moved_start), ("goal", moved_goal)];
            let moved = moved.into_iter().filter_map(|(end, moved)| Some((end, moved.as_ref()?.distance_m)));
            let moved: Vec<String> =
                moved.map(|(end, moved_m)| format!(", the {end} moved by {moved_m:.0} m")).collect();
            let moved = moved.concat();
            let part = if *of_part { ", of part of the water" } else { ", shown to be the shortest" };
            format!("{:.1} km in {} legs{part}{moved}", length_m / 1e3, legs.len())
        }
        Err(refusal) => refusal.to_string(),
    };
    println!(
        "| {straight_km:.0} km | {result} | {:.1} s | {again_ms:.0} ms | {:.0} ms |",
        cold_ms / 1e3,
        dragged_ms.into_iter().fold(0.0, f64::max),
    );
}

/// Copies of a cell side by side, and open water around them and between.
fn coast(cell: &Cell, rows: usize) -> DepthIndex {
    let points = || cell.features.iter().flat_map(|feature| feature.geometry.points());
    let [west, south] = [|at: GeoPoint| at.lon_deg, |at: GeoPoint| at.lat_deg]
        .map(|of| points().map(of).fold(f64::INFINITY, f64::min));
    let mut builder = IndexBuilder::new();
    for (row, column) in (0..rows).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let shift = [STEP_DEG[0] * row as f64, STEP_DEG[1] * column as f64];
        let features: Vec<Feature> = cell.features.iter().map(|feature| moved(feature, shift)).collect();
        let source =
            Source { name: format!("XX{row:02}{column:02}"), band: 4, scale: 80_000, ..Source::default() };
        builder.add_features(source, &features).unwrap();
    }
    let (north, east) = (south + STEP_DEG[0] * rows as f64 + 0.3, west + STEP_DEG[1] * COLUMNS as f64 + 0.3);
    let (source, water) = testkit::sea::open_water([west - 0.3, south - 0.3, east, north], 100.0);
    builder.add_features(Source { band: 1, scale: 1_000_000, ..source }, &water).unwrap();
    builder.build().unwrap()
}

fn moved(feature: &Feature, [north_deg, east_deg]: [f64; 2]) -> Feature {
    let at = |at: &GeoPoint| GeoPoint { lat_deg: at.lat_deg + north_deg, lon_deg: at.lon_deg + east_deg };
    let path = |path: &Path| Path { points: path.points.iter().map(at).collect(), edges: path.edges.clone() };
    let paths = |paths: &[Path]| paths.iter().map(path).collect::<Vec<Path>>();
    let geometry = match &feature.geometry {
        Geometry::None => Geometry::None,
        Geometry::Point(point) => Geometry::Point(at(point)),
        Geometry::Soundings(soundings) => Geometry::Soundings(
            soundings.iter().map(|one| charts::s57::Sounding { at: at(&one.at), ..*one }).collect(),
        ),
        Geometry::Lines(lines) => Geometry::Lines(paths(lines)),
        Geometry::Area(area) => {
            Geometry::Area(Area { exteriors: paths(&area.exteriors), holes: paths(&area.holes) })
        }
        Geometry::Unreadable { paths: lines, reason } => {
            Geometry::Unreadable { paths: paths(lines), reason: reason.clone() }
        }
    };
    Feature { geometry, ..feature.clone() }
}
