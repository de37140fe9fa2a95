//! Charts at the scale of a coast: `cargo bench -p chartdb --bench coast`.
//!
//! Writes 1,500 cells (`LUTRA_COAST_CELLS` says how many) into a temporary folder: the shared cells and those of the
//! archipelago, moved side by side in blocks and renamed; the two largest are in each fourth block only. Each step is
//! a process of its own, so that the memory it took can be told. Needs about 4 GB of disk while it runs.

#![expect(clippy::unwrap_used, reason = "a benchmark fails where it unwraps nothing")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use chartdb::{ImportOptions, import, load_index};
use charts::depth_index::{Demand, Leg};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use units::{LatLon, UtcTime};

const LARGE: [&str; 2] = ["US4MD81M", "US5WA22M"];
const SMALL: [&str; 6] = ["US5MD1MC", "GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X02SE", "GB5X01SE"];
const STEP: &str = "LUTRA_COAST_STEP";
const FOLDER: &str = "LUTRA_COAST_FOLDER";

fn main() {
    if let (Ok(step), Some(folder)) = (std::env::var(STEP), std::env::var_os(FOLDER)) {
        return run(&step, Path::new(&folder));
    }
    let wanted = std::env::var("LUTRA_COAST_CELLS").map_or(1_500, |text| text.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let Some((count, bytes)) = write_cells(folder.path(), wanted) else { return };
    println!("{count} cells, {} MB", bytes / 1_000_000);
    for step in ["whole import", "one small cell", "first look", "depth", "corridor of 20 km", "many places"]
    {
        let mut child = Command::new(std::env::current_exe().unwrap());
        assert!(child.env(STEP, step).env(FOLDER, folder.path()).status().unwrap().success());
    }
    let size = |name: &str| fs::metadata(folder.path().join(name)).unwrap().len() / 1_000_000;
    println!("database {} MB, index {} MB", size("chart.gpkg"), size("chart.lutra-index"));
}

fn run(step: &str, folder: &Path) {
    let db = folder.join("chart.gpkg");
    let options = ImportOptions::new(UtcTime::from_micros(0));
    let start = Instant::now();
    // Within a harbour of the first block.
    let at = LatLon::from_deg(63.446, 10.345 - 20.0).unwrap();
    match step {
        "whole import" | "one small cell" => {
            let input = if step == "whole import" { "cells" } else { "one" };
            let report = import(&db, &[folder.join(input)], &options, &mut |_| true).unwrap();
            assert!(report.applied && report.failures.is_empty(), "{:?}", report.failures.first());
        }
        "first look" => {
            assert!(load_index(&db).unwrap().rebuilt.is_none());
        }
        "depth" => {
            let index = load_index(&db).unwrap().sealed.index;
            assert!(index.depth_at(at, &Demand::default()).water.least_m().is_some());
        }
        "corridor of 20 km" => {
            let index = load_index(&db).unwrap().sealed.index;
            let to = LatLon::from_deg(63.446, 10.345 - 19.6).unwrap();
            index.shallowest_along(Leg { from: at, to }, 25.0, &Demand::default());
        }
        // Two hundred circles in the waters of forty blocks, as users of a server ask for them.
        _ => {
            let index = load_index(&db).unwrap().sealed.index;
            for place in 0..200 {
                let [north_deg, east_deg] = shift(place % 40).map(|units| f64::from(units) / 1e7);
                let place = LatLon::from_deg(63.446 + north_deg, 10.345 + east_deg).unwrap();
                index.shallowest_within(place, 500.0, &Demand::default());
            }
        }
    }
    let taken = start.elapsed();
    let (taken_s, worked_s) = (taken.as_secs_f64(), processor_s());
    println!("{step}: {taken_s:.3} s, of the processor {worked_s:.2} s; {} MiB at most", peak_kib() >> 10);
}

/// How long this process kept a processor busy (s), the system's work for it included, as Linux tells it.
fn processor_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().skip(11).take(2);
    // A hundred in a second.
    ticks.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// The most memory that this process held, as Linux tells it.
fn peak_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|text| text.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

/// How far a block is moved, north and east (units of 1e-7 degrees).
fn shift(block: u32) -> [i32; 2] {
    let (row, column) = ((block / 40) as i32, (block % 40) as i32);
    [-row * 6_500_000, column * 3_700_000 - 200_000_000]
}

/// Writes the cells, and one more for the import of one; `None` without the shared cells.
fn write_cells(folder: &Path, wanted: usize) -> Option<(usize, u64)> {
    let read = |name: &&'static str| {
        let path: PathBuf = testkit::shared(&format!("data/charts/{name}.000"))?;
        Some((*name, fs::read(path).unwrap()))
    };
    let mut bases: Vec<(&str, Vec<u8>)> = SMALL.iter().map(read).collect::<Option<_>>()?;
    for file in charts::demo::archipelago().unwrap() {
        bases.push((file.name.trim_end_matches(".000"), file.bytes));
    }
    let large: Vec<(&str, Vec<u8>)> = LARGE.iter().map(read).collect::<Option<_>>()?;
    for part in ["cells", "one"] {
        fs::create_dir(folder.join(part)).unwrap();
    }
    let (mut count, mut bytes) = (0, 0);
    for block in 0.. {
        let more = if block % 4 == 0 { &large[..] } else { &[] };
        for (name, base) in bases.iter().chain(more) {
            if count == wanted {
                let (name, base) = &bases[5];
                write_cell(&folder.join("one"), name, base, 0xff, shift(3));
                return Some((count, bytes));
            }
            count += 1;
            bytes += base.len() as u64;
            write_cell(&folder.join("cells"), name, base, block, shift(block));
        }
    }
    None
}

/// Writes a cell under another name, moved.
fn write_cell(folder: &Path, name: &str, base: &[u8], block: u32, shift: [i32; 2]) {
    let mut bytes = base.to_vec();
    // What is left of the name tells which of a block it is.
    let renamed = format!("{}{block:02X}{}", &name[..3], &name[5..]);
    assert_eq!(renamed.len(), name.len());
    let text = format!("{name}.000");
    let at = bytes.windows(text.len()).position(|window| window == text.as_bytes()).unwrap();
    bytes[at..at + renamed.len()].copy_from_slice(renamed.as_bytes());
    move_cell(&mut bytes, shift);
    fs::write(folder.join(format!("{renamed}.000")), bytes).unwrap();
}

/// Adds to all coordinates of a cell (ISO 8211: leader, directory and fields of each record; S-57: SG2D and SG3D).
fn move_cell(bytes: &mut [u8], shift: [i32; 2]) {
    let number = |bytes: &[u8]| std::str::from_utf8(bytes).unwrap().trim().parse::<usize>().unwrap();
    let (mut record, mut factor) = (0, 1);
    while record < bytes.len() {
        let length = number(&bytes[record..record + 5]);
        let area = record + number(&bytes[record + 12..record + 17]);
        let digit = |at: usize| number(&bytes[record + at..=record + at]);
        let (of_length, of_place, of_tag) = (digit(20), digit(21), digit(23));
        let mut fields = Vec::new();
        let mut entry = record + 24;
        while record > 0 && bytes[entry] != 0x1e {
            let (length, place) = (entry + of_tag, entry + of_tag + of_length);
            let tag = &bytes[entry..length];
            let row = if tag == b"SG2D" { 8 } else { 12 };
            let from = area + number(&bytes[place..place + of_place]);
            if tag == b"DSPM" {
                // COMF, after five bytes, three bytes and two numbers.
                factor = i64::from(i32::from_le_bytes(bytes[from + 16..from + 20].try_into().unwrap()));
            }
            if tag == b"SG2D" || tag == b"SG3D" {
                fields.push((from, from + number(&bytes[length..place]) - 1, row));
            }
            entry = place + of_place;
        }
        for (from, to, row) in fields {
            for at in (from..to).step_by(row).flat_map(|at| [(at, shift[0]), (at + 4, shift[1])]) {
                let (at, by) = at;
                let by = (i64::from(by) * factor / 10_000_000) as i32;
                let moved = i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) + by;
                bytes[at..at + 4].copy_from_slice(&moved.to_le_bytes());
            }
        }
        record += length;
    }
}
