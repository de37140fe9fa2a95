//! Waters that are made by this bench, so that it needs no chart: a fjord of 6.1 million cells of 50 m, and a harbour of 5.5
//! million cells of 2 m. The same start and goal by the planner on the exact lines and by A* on the grid of the same water.
//! `cargo bench -p planner --bench grids`; `LUTRA_GRIDS=FOLDER` writes the grids for other planners, which `scripts/bench-routes` runs.

#![expect(clippy::disallowed_methods, reason = "a bench looks at the clock")]
#![expect(clippy::unwrap_used, reason = "a bench fails where it unwraps nothing")]
#![expect(clippy::print_stdout, reason = "this is what it is for")]

#[path = "common/grid.rs"]
mod grid;
#[path = "common/memory.rs"]
mod memory;
#[path = "common/table.rs"]
mod table;

use charts::depth_index::{DepthIndex, IndexBuilder};
use charts::s57::{Area, GeoPoint, Path as Ring};
use memory::memory;
use planner::classic::ClassicGrid;
use planner::{Cancel, Needs, Request, Route, Router};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use table::Row;
use testkit::Numbers;
use units::LatLon;

/// Times that a route is asked for again.
const AGAIN: u32 = 200;

/// Metres of a degree of latitude, near enough to lay out water.
const DEGREE_M: f64 = 111_320.0;

/// The middle of either water (degrees).
const MIDDLE: [f64; 2] = [63.5, 9.0];

fn main() {
    println!("times on one core; lengths on WGS 84, of A* in the plane of the grid\n");
    for water in [fjord(), harbour()] {
        measure(&water);
    }
}

/// A square of water with land in it. Places are metres east and north of the middle.
struct Made {
    name: &'static str,
    half_m: f64,
    spacing_m: f64,
    clearance_m: f64,
    land: Vec<Vec<[f64; 2]>>,
    /// Start and goals, the nearest first.
    start: [f64; 2],
    goals: Vec<[f64; 2]>,
}

/// 130 by 130 km with four spits that leave a passage at one end each, and islands between them.
fn fjord() -> Made {
    let half_m = 65_000.0;
    let mut numbers = Numbers(1);
    let mut land: Vec<Vec<[f64; 2]>> = [(-24e3, 18e3), (-8e3, -20e3), (9e3, 15e3), (25e3, -17e3)]
        .into_iter()
        .map(|(east, tip)| spit(&mut numbers, east, tip, half_m))
        .collect();
    islands(&mut numbers, &mut land, half_m, [2_400, 1_800], [150.0, 900.0]);
    let goals = vec![[-32e3, 4e3], [40e3, 0.0]];
    Made { name: "fjord", half_m, spacing_m: 50.0, clearance_m: 25.0, land, start: [-40e3, 0.0], goals }
}

/// 4.8 by 4.8 km with rows of piers, moored barges and skerries.
fn harbour() -> Made {
    let half_m = 2_400.0;
    let mut numbers = Numbers(2);
    let mut land = Vec::new();
    for row in 0..6_i32 {
        let north = -2_000.0 + 760.0 * f64::from(row);
        // A breakwater with a gap, at either end in turn, and piers along it.
        let (west, east) = if row % 2 == 0 { (-half_m, 1_900.0) } else { (-1_900.0, half_m) };
        land.push(block([west, north], [east, north + 12.0]));
        for pier in 0..40_i32 {
            let at = west + 60.0 + 100.0 * f64::from(pier);
            if at < east - 60.0 {
                land.push(block([at, north + 12.0], [at + 14.0, north + numbers.within(120.0, 260.0)]));
            }
        }
    }
    islands(&mut numbers, &mut land, half_m, [260, 200], [4.0, 25.0]);
    let goals = vec![[-1_500.0, -2_200.0], [2_200.0, 2_250.0]];
    Made {
        name: "harbour",
        half_m,
        spacing_m: 2.0,
        clearance_m: 3.0,
        land,
        start: [-2_200.0, -2_300.0],
        goals,
    }
}

/// A spit from the southern border to its tip, or from the northern one if the tip is south of the middle.
fn spit(numbers: &mut Numbers, east: f64, tip: f64, half_m: f64) -> Vec<[f64; 2]> {
    let root = -half_m.copysign(tip);
    let steps = ((tip - root).abs() / 150.0).ceil() as usize;
    let mut side = |off: f64| -> Vec<[f64; 2]> {
        let north = |step: usize| root + (tip - root) * step as f64 / steps as f64;
        (0..=steps).map(|step| [east + off * numbers.within(0.5, 1.0), north(step)]).collect()
    };
    let (mut ring, other) = (side(-1_200.0), side(1_200.0));
    ring.extend(other.into_iter().rev());
    ring
}

fn block([west, south]: [f64; 2], [east, north]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// Islands clear of the land so far and of each other: of so many places so many at most, with radii between these (m).
fn islands(
    numbers: &mut Numbers,
    land: &mut Vec<Vec<[f64; 2]>>,
    half_m: f64,
    [places, most]: [usize; 2],
    [least_m, most_m]: [f64; 2],
) {
    let boxed = |ring: &[[f64; 2]]| {
        ring.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |sides, at| {
            [sides[0].min(at[0]), sides[1].min(at[1]), sides[2].max(at[0]), sides[3].max(at[1])]
        })
    };
    let mut taken: Vec<[f64; 4]> = land.iter().map(|ring| boxed(ring)).collect();
    let before = land.len();
    for _ in 0..places {
        if land.len() >= before + most {
            break;
        }
        let radius = numbers.within(least_m, most_m);
        let inside = half_m - 2.0 * radius;
        let [east, north] = [numbers.within(-inside, inside), numbers.within(-inside, inside)];
        let corners = 12 + (numbers.share() * 24.0) as u32;
        let mut corner = |number: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(number) / f64::from(corners)).sin_cos();
            let off = radius * numbers.within(0.6, 1.0);
            [east + off * sin, north + off * cos]
        };
        let ring: Vec<[f64; 2]> = (0..corners).map(&mut corner).collect();
        let sides = boxed(&ring);
        let gap = least_m / 2.0;
        let meets = |other: &[f64; 4]| {
            sides[0] < other[2] + gap
                && other[0] < sides[2] + gap
                && sides[1] < other[3] + gap
                && other[1] < sides[3] + gap
        };
        if !taken.iter().any(meets) {
            taken.push(sides);
            land.push(ring);
        }
    }
}

impl Made {
    fn degrees([east, north]: [f64; 2]) -> [f64; 2] {
        let [lat, lon] = MIDDLE;
        [lat + north / DEGREE_M, lon + east / (DEGREE_M * lat.to_radians().cos())]
    }

    fn place(at: [f64; 2]) -> LatLon {
        let [lat, lon] = Self::degrees(at);
        LatLon::from_deg(lat, lon).unwrap()
    }

    fn index(&self) -> Arc<DepthIndex> {
        let [[south, west], [north, east]] =
            [-self.half_m, self.half_m].map(|side| Self::degrees([side, side]));
        let area = |ring: &Vec<[f64; 2]>| {
            let points = ring.iter().chain(ring.first()).map(|at| {
                let [lat_deg, lon_deg] = Self::degrees(*at);
                GeoPoint { lat_deg, lon_deg }
            });
            Area { exteriors: vec![Ring { points: points.collect(), edges: Vec::new() }], holes: Vec::new() }
        };
        let land: Vec<Area> = self.land.iter().map(area).collect();
        let sea = testkit::sea::open_water([west, south, east, north], 100.0);
        let mut builder = IndexBuilder::new();
        builder.add_features(sea.0, &sea.1).unwrap();
        builder.add_land("land", &land).unwrap();
        Arc::new(builder.build().unwrap())
    }
}

fn measure(water: &Made) {
    let index = water.index();
    println!(
        "{}: {:.0} by {:.0} km, {} pieces of land, {} vertices",
        water.name,
        water.half_m / 500.0,
        water.half_m / 500.0,
        water.land.len(),
        index.vertex_count()
    );
    let requests: Vec<Request> =
        water.goals.iter().map(|goal| Request::new(Made::place(water.start), Made::place(*goal))).collect();
    for clearance_m in [0.0, water.clearance_m] {
        let needs = Needs::depth_and_clearance(5.0, clearance_m);
        let router = Router::new(Arc::clone(&index));
        for (number, request) in requests.iter().enumerate() {
            by_lines(&format!("{}-{number}", water.name), &router, request, &needs);
        }
    }
    by_grid(water, &index, &requests);
}

/// By the planner, every leg asked of the depth index again.
fn by_lines(water: &str, router: &Router, request: &Request, needs: &Needs) {
    let ask = || router.route(request, needs, &Cancel::never()).unwrap();
    let begun = Instant::now();
    let untaught = ask();
    let first_ms = begun.elapsed().as_secs_f64() * 1e3;
    let begun = Instant::now();
    let learned = if router.learn(&Cancel::never()).unwrap() {
        let effort = untaught.effort.intervals;
        format!(" ({effort} before it learned for {:.0} ms)", begun.elapsed().as_secs_f64() * 1e3)
    } else {
        String::new()
    };
    let route: Route = ask();
    assert!((route.length_m - untaught.length_m).abs() < 1e-3, "{} m before it learned", untaught.length_m);
    let begun = Instant::now();
    (0..AGAIN).for_each(|_| drop(ask()));
    let again_ms = begun.elapsed().as_secs_f64() * 1e3 / f64::from(AGAIN);
    let planner = format!("Lutra, {} m clear, every leg checked", needs.clearance_m);
    let (length_m, nodes) = (route.length_m, route.effort.intervals);
    let row = Row {
        water,
        planner: &planner,
        first_ms,
        again_ms: Some(again_ms),
        length_m,
        nodes,
        prepared_ms: None,
    };
    row.note();
    println!(
        "  Lutra, {} m clear: {:.1} m in {} legs; first {first_ms:.0} ms, again {again_ms:.2} ms, {} intervals{learned}; {}",
        needs.clearance_m,
        route.length_m,
        route.legs.len(),
        route.effort.intervals,
        memory()
    );
}

fn by_grid(water: &Made, index: &DepthIndex, requests: &[Request]) {
    let demand = Needs::depth_and_clearance(5.0, 0.0).demand;
    let begun = Instant::now();
    let middle = Made::place([0.0, 0.0]);
    let grid =
        ClassicGrid::new(index, &demand, middle, (water.half_m, water.spacing_m), &Cancel::never()).unwrap();
    let laid_s = begun.elapsed().as_secs_f64();
    println!(
        "  grid of {} m: {} open cells, laid out in {laid_s:.1} s; {}",
        water.spacing_m,
        grid.open_cells(),
        memory()
    );
    for (number, request) in requests.iter().enumerate() {
        let ends = [request.from, request.to];
        grid::by_a_star(&format!("{}-{number}", water.name), (&grid, laid_s * 1e3), ends);
        if let Some(folder) = std::env::var_os("LUTRA_GRIDS") {
            let file = Path::new(&folder).join(format!("{}-{number}", water.name));
            let lines = serde_json::json!({
                "half_m": water.half_m,
                "land": water.land,
                "from": water.start,
                "to": water.goals[number],
            });
            grid::write(&file, &grid, water.spacing_m, ends, &lines);
        }
    }
}
