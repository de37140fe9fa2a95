//! How fast charts come in and how soon the index is there: `cargo bench -p chartdb --bench chartdb`.
//!
//! Each cell is imported into a set of its own by a process of its own, so that the memory it took is known. The
//! figures of `ogr2ogr` for a GeoPackage of the same cell are listed too, where that is installed.

#![expect(clippy::unwrap_used, reason = "a benchmark fails where it unwraps nothing")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use chartdb::{ImportOptions, ImportProgress, import, load_index};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use units::UtcTime;

const CELLS: [&str; 9] = [
    "US4MD81M", "US5WA22M", "US5MD1MC", "US1BS01M", "GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE",
    "GB5X02SE",
];
const ROUNDS: usize = 5;

/// Until all features are in the database, which is as far as `ogr2ogr` goes, and until the index is there too.
fn bring(db: &Path, inputs: &[PathBuf]) -> [Duration; 2] {
    let options = ImportOptions::new(UtcTime::from_micros(0));
    let start = Instant::now();
    let mut stored = Duration::ZERO;
    let mut progress = |progress: &ImportProgress<'_>| {
        stored = start.elapsed();
        progress.done <= progress.of
    };
    let report = import(db, inputs, &options, &mut progress).unwrap();
    assert!(report.applied && report.failures.is_empty());
    [stored, start.elapsed()]
}

/// Peak memory of a process, as Linux reports it.
fn peak_kib(process: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
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
        let [stored, taken] = bring(&folder.path().join("chart.gpkg"), &[PathBuf::from(input)]);
        println!("{} {} {}", stored.as_micros(), taken.as_micros(), peak_kib("self"));
        return;
    }
    let mut inputs = Vec::new();
    for name in CELLS {
        let Some(input) = testkit::shared(&format!("data/charts/{name}.000")) else { return };
        let (mut stored, mut taken, mut peak) = (Vec::new(), Vec::new(), 0);
        for _ in 0..ROUNDS {
            let mut child = Command::new(std::env::current_exe().unwrap());
            let output = child.env("LUTRA_BENCH_CELL", &input).output().unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            let figures: Vec<u64> = text.split_whitespace().map(|figure| figure.parse().unwrap()).collect();
            stored.push(Duration::from_micros(figures[0]));
            taken.push(Duration::from_micros(figures[1]));
            peak = peak.max(figures[2]);
        }
        let beside = ogr2ogr(&input, folder.path());
        let (stored, taken) = (median(stored), median(taken));
        println!(
            "import {name}: {stored:.1?}, {taken:.1?} with index, {} MiB at most; ogr2ogr: {beside}",
            peak >> 10
        );
        inputs.push(input);
    }
    let db = folder.path().join("all/chart.gpkg");
    let [stored, taken] = bring(&db, &inputs);
    println!("import all shared cells into one set: {stored:.1?}, {taken:.1?} with index");
    println!("import them again, all there already: {:.1?}", bring(&db, &inputs)[1]);
    let ready = || {
        let start = Instant::now();
        assert!(load_index(&db).unwrap().rebuilt.is_none());
        start.elapsed()
    };
    let times: Vec<Duration> = (0..ROUNDS).map(|_| ready()).collect();
    println!("index of all shared cells ready: {:.1?}", median(times));
}

/// Time and memory of `ogr2ogr`; the memory is sampled each millisecond, so a last rise may be missed.
fn ogr2ogr(input: &Path, folder: &Path) -> String {
    let output = folder.join("ogr.gpkg");
    let (mut times, mut peak) = (Vec::new(), 0);
    for _ in 0..ROUNDS {
        std::fs::remove_file(&output).ok();
        let start = Instant::now();
        let mut ogr = Command::new("ogr2ogr");
        let ogr =
            ogr.args(["-f", "GPKG"]).arg(&output).arg(input).stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(mut child) = ogr.spawn() else { return "not installed".to_owned() };
        let done = loop {
            if let Some(done) = child.try_wait().unwrap() {
                break done;
            }
            peak = peak.max(peak_kib(&child.id().to_string()));
            std::thread::sleep(Duration::from_millis(1));
        };
        if !done.success() {
            return format!("ends with {done}");
        }
        times.push(start.elapsed());
    }
    format!("{:.1?}, {} MiB at most", median(times), peak >> 10)
}
