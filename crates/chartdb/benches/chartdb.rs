//! How fast charts come in and how soon the index is there: `cargo bench -p chartdb --bench chartdb`.
//!
//! Each cell goes into a set of its own by a process of its own, so that the memory it took can be told. Beside
//! it stands what `ogr2ogr` takes for a GeoPackage of the same cell, where that is installed.

#![expect(clippy::unwrap_used, reason = "a benchmark fails where it unwraps nothing")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use chartdb::{ImportOptions, import, load_index};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use units::UtcTime;

const CELLS: [&str; 9] = [
    "US4MD81M", "US5WA22M", "US5MD1MC", "US1BS01M", "GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE",
    "GB5X02SE",
];
const ROUNDS: usize = 5;

fn bring(db: &Path, inputs: &[PathBuf]) -> Duration {
    let options = ImportOptions::new(UtcTime::from_micros(0));
    let start = Instant::now();
    let report = import(db, inputs, &options, &mut |_| true).unwrap();
    assert!(report.applied && report.failures.is_empty());
    start.elapsed()
}

/// The most memory that this process held, as Linux tells it.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|text| text.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    if let Ok(input) = std::env::var("LUTRA_BENCH_CELL") {
        let taken = bring(&folder.path().join("chart.gpkg"), &[PathBuf::from(input)]);
        println!("{} {}", taken.as_micros(), peak_kib());
        return;
    }
    let mut inputs = Vec::new();
    for name in CELLS {
        let Some(input) = testkit::shared(&format!("data/charts/{name}.000")) else { return };
        let (mut times, mut peak) = (Vec::new(), 0);
        for _ in 0..ROUNDS {
            let mut child = Command::new(std::env::current_exe().unwrap());
            let output = child.env("LUTRA_BENCH_CELL", &input).output().unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            let (us, kib) = text.trim().split_once(' ').unwrap();
            times.push(Duration::from_micros(us.parse().unwrap()));
            peak = peak.max(kib.parse::<u64>().unwrap());
        }
        let taken = median(times);
        let beside = ogr2ogr(&input, folder.path());
        println!("import {name}: {taken:.1?} with index, {} MiB at most; ogr2ogr: {beside}", peak >> 10);
        inputs.push(input);
    }
    let db = folder.path().join("all/chart.gpkg");
    println!("import all shared cells into one set: {:.1?}", bring(&db, &inputs));
    println!("import them again, all there already: {:.1?}", bring(&db, &inputs));
    let ready = || {
        let start = Instant::now();
        assert!(load_index(&db).unwrap().rebuilt.is_none());
        start.elapsed()
    };
    let times: Vec<Duration> = (0..ROUNDS).map(|_| ready()).collect();
    println!("index of all shared cells ready: {:.1?}", median(times));
}

fn ogr2ogr(input: &Path, folder: &Path) -> String {
    let output = folder.join("ogr.gpkg");
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        std::fs::remove_file(&output).ok();
        let start = Instant::now();
        let done = Command::new("ogr2ogr").args(["-f", "GPKG"]).arg(&output).arg(input).output();
        match done {
            Ok(done) if done.status.success() => times.push(start.elapsed()),
            Ok(done) => return String::from_utf8_lossy(&done.stderr).trim().to_owned(),
            Err(_) => return "not installed".to_owned(),
        }
    }
    format!("{:.1?}", median(times))
}
