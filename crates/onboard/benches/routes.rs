//! The cost of searching for routes aboard: memory and time of a process that holds nothing but the chart of all shared
//! cells and searches for routes on it as the vessel does. `cargo bench -p onboard --bench routes`.
//!
//! The chart is made by another process, so that what making it took is not counted.

#![expect(clippy::disallowed_methods, reason = "a bench looks at the clock")]
#![expect(clippy::unwrap_used, reason = "a bench fails where it unwraps nothing")]
#![expect(clippy::print_stdout, reason = "this is what it is for")]

use charts::depth_index::{DepthIndex, IndexBuilder};
use charts::s57::{Cell, NamedBytes};
use guard::GuardLimits;
use onboard::{Chart, RouteRequest, Routes};
use planner::{Cancel, Needs, Zones};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use testkit::Numbers;
use units::LatLon;

/// Says to the process that it is the one that is measured.
const MEASURED: &str = "LUTRA_MEASURED_CHART";
/// Cells that are searched, far from each other, and routes in each.
const WATERS: [&str; 3] = ["GB5X01NE", "US5WA22M", "US4MD81M"];
const ROUTES: u32 = 200;
/// Goals lie so far from the start at most (m).
const FAR_M: f64 = 9_000.0;

fn main() {
    if let Some(path) = std::env::var_os(MEASURED) {
        let waters: Vec<String> = std::env::args().skip(1).filter(|text| text.contains(',')).collect();
        return measure(Path::new(&path), &waters);
    }
    let Some(folder) = testkit::shared("data/charts") else {
        println!("the shared charts are absent: nothing is measured");
        return;
    };
    let path = std::env::temp_dir().join(format!("lutra-{}.lutra-index", std::process::id()));
    make(&cells(&folder), &path);
    let waters = WATERS.map(|name| {
        let extent = index(&[folder.join(format!("{name}.000"))]).extent().unwrap();
        format!("{},{},{},{}", extent.west_deg, extent.south_deg, extent.east_deg, extent.north_deg)
    });
    let mut measured = Command::new(std::env::current_exe().unwrap());
    let done = measured.env(MEASURED, &path).args(waters).status().unwrap();
    std::fs::remove_file(&path).unwrap();
    assert!(done.success());
}

fn cells(folder: &Path) -> Vec<PathBuf> {
    let mut cells: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    cells.retain(|path| path.extension().is_some_and(|extension| extension == "000"));
    cells.sort();
    cells
}

fn index(cells: &[PathBuf]) -> DepthIndex {
    let mut builder = IndexBuilder::new();
    for cell in cells {
        let updates = (1..1_000).map(|number| cell.with_extension(format!("{number:03}")));
        let files: Vec<PathBuf> =
            std::iter::once(cell.clone()).chain(updates.take_while(|path| path.exists())).collect();
        let bytes: Vec<(String, Vec<u8>)> =
            files.iter().map(|path| (path.display().to_string(), std::fs::read(path).unwrap())).collect();
        let named: Vec<NamedBytes<'_>> =
            bytes.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
        builder.add_cell(&Cell::read(named[0], &named[1..]).unwrap()).unwrap();
    }
    builder.build().unwrap()
}

fn make(cells: &[PathBuf], path: &Path) {
    let index = index(cells);
    println!("{} cells, {} vertices", cells.len(), index.vertex_count());
    std::fs::write(path, index.to_bytes()).unwrap();
}

fn measure(path: &Path, waters: &[String]) {
    let chart = Chart::read("shared cells", &std::fs::read(path).unwrap());
    assert!(chart.digest().is_some());
    tell("with the chart");
    let limits = GuardLimits::default();
    let mut routes = Routes::default();
    for clearance_m in [25.0, limits.half_width_m()] {
        let needs = Needs { demand: limits.demand(limits.autonomous_m), clearance_m };
        for (name, extent) in WATERS.iter().zip(waters) {
            let sides: Vec<f64> = extent.split(',').map(|side| side.parse().unwrap()).collect();
            look(&chart, &mut routes, &needs, &sides);
            tell(&format!("{name}, {clearance_m:.1} m clear"));
        }
    }
}

/// Between places within west, south, east and north (degrees).
fn look(chart: &Chart, routes: &mut Routes, needs: &Needs, sides: &[f64]) {
    let [west, south, east, north] = sides else { panic!("four sides") };
    let mut numbers = Numbers(7);
    let (mut found, mut slowest_ms) = (0, 0.0_f64);
    for number in 0..ROUTES {
        let from = LatLon::from_deg(numbers.within(*south, *north), numbers.within(*west, *east)).unwrap();
        let frame = units::LocalFrame::new(from);
        let away = units::LocalPoint {
            north_m: numbers.within(-FAR_M, FAR_M),
            east_m: numbers.within(-FAR_M, FAR_M),
        };
        let request = RouteRequest {
            number,
            from,
            to: frame.to_place(away),
            needs: *needs,
            zones: Zones::default(),
            longest_m: 20_000.0,
        };
        let begun = Instant::now();
        let answer = routes.answer(chart, &request, &Cancel::never()).unwrap();
        slowest_ms = slowest_ms.max(begun.elapsed().as_secs_f64() * 1e3);
        found += u32::from(answer.outcome.is_ok());
    }
    println!("  {found} of {ROUTES} found, the slowest answer took {slowest_ms:.0} ms");
}

fn tell(when: &str) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let of = |key: &str| {
        let line = status.lines().find(|line| line.starts_with(key)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1024.0
    };
    println!("{when}: {:.0} MiB now, {:.0} MiB at most", of("VmRSS"), of("VmHWM"));
}
