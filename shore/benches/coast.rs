//! Charts at the scale of a coast: `cargo bench -p shore --bench coast`.
//!
//! Writes 1,500 cells (`LUTRA_COAST_CELLS` says how many) into a temporary folder, or into `LUTRA_COAST_KEEP`, where they
//! and the set stay for the next run; `LUTRA_COAST_STEPS` names the steps that run, with commas between them: the shared cells and those of the
//! archipelago, moved side by side in blocks and renamed; the two largest are in each fourth block only. Each step is its
//! own process, so that its memory can be measured. Needs about 6 GB of disk while it runs.

#![expect(clippy::unwrap_used, reason = "a benchmark fails where it unwraps nothing")]

use chartdb::{ImportOptions, import, load_index};
use charts::depth_index::{Demand, Leg};
use planner::{Cancel, Needs, Request};
use shore::charts::{ChartPackage, Set};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;
use units::{LatLon, UtcTime};

const LARGE: [&str; 2] = ["US4MD81M", "US5WA22M"];
const SMALL: [&str; 6] = ["US5MD1MC", "GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X02SE", "GB5X01SE"];
const STEP: &str = "LUTRA_COAST_STEP";
const FOLDER: &str = "LUTRA_COAST_FOLDER";

/// In this order.
const STEPS: [&str; 19] = [
    "whole import",
    "one small cell",
    "one small cell taken out",
    "one large cell",
    "one large cell taken out",
    "index opened",
    "depth",
    "corridor of 20 km",
    "many places",
    "first tile of a harbour",
    "overviews",
    "first tiles of zoom 0 to 16",
    "forty harbours and their tiles",
    "what vessels are offered",
    "routes of 1 km",
    "routes of 18 km",
    "routes of 90 km",
    "routes of 180 km",
    "one small cell",
];

fn main() {
    if let (Ok(step), Some(folder)) = (std::env::var(STEP), std::env::var_os(FOLDER)) {
        return run(&step, Path::new(&folder));
    }
    let wanted = std::env::var("LUTRA_COAST_CELLS").map_or(1_500, |text| text.parse().unwrap());
    let kept = std::env::var_os("LUTRA_COAST_KEEP").map(PathBuf::from);
    let temporary = tempfile::tempdir().unwrap();
    let folder = kept.as_deref().unwrap_or(temporary.path());
    if !folder.join("chart.gpkg").exists() {
        let Some((count, bytes)) = write_cells(folder, wanted) else { return };
        write_more(folder).unwrap();
        println!("{count} cells, {} MB", bytes / 1_000_000);
    }
    let only = std::env::var("LUTRA_COAST_STEPS").ok();
    let wanted = |step: &&str| only.as_deref().is_none_or(|only| only.split(',').any(|one| one == *step));
    for step in STEPS.into_iter().filter(wanted) {
        let mut child = Command::new(std::env::current_exe().unwrap());
        assert!(child.env(STEP, step).env(FOLDER, folder).status().unwrap().success());
    }
    for name in ["chart.gpkg", "chart.lutra-index", "chart.lutra-changes", "chart.lutra-overviews"] {
        let bytes = fs::metadata(folder.join(name)).map_or(0, |about| about.len());
        println!("{name}: {} MB", bytes / 1_000_000);
    }
}

fn run(step: &str, folder: &Path) {
    let db = folder.join("chart.gpkg");
    // Within a harbour of the first block.
    let at = place(0);
    let start = Instant::now();
    match step {
        "whole import" => bring(&db, &folder.join("cells")),
        "one small cell" => bring(&db, &folder.join("small")),
        "one large cell" => bring(&db, &folder.join("large")),
        "one small cell taken out" => take_out(&db, &folder.join("small")),
        "one large cell taken out" => take_out(&db, &folder.join("large")),
        "index opened" => assert!(load_index(&db).unwrap().rebuilt.is_none()),
        "depth" => {
            let index = load_index(&db).unwrap().sealed.index;
            assert!(index.depth_at(at, &Demand::default()).water.least_m().is_some());
        }
        "corridor of 20 km" => {
            let index = load_index(&db).unwrap().sealed.index;
            let to = LatLon::from_deg(at.lat_deg(), at.lon_deg() + 0.4).unwrap();
            index.shallowest_along(Leg { from: at, to }, 25.0, &Demand::default());
        }
        // Two hundred circles in the waters of forty blocks, as users of a server ask for them.
        "many places" => {
            let index = load_index(&db).unwrap().sealed.index;
            for number in 0..200 {
                index.shallowest_within(place(number % 40), 500.0, &Demand::default());
            }
        }
        "first tile of a harbour" => assert!(tile(&served(&db), 14, at) > 100),
        "overviews" => served(&db).sheet().unwrap().prepare(|| true).unwrap(),
        "first tiles of zoom 0 to 16" => {
            let set = served(&db);
            for zoom in 0..=16 {
                let start = Instant::now();
                let bytes = tile(&set, zoom, at);
                println!("  zoom {zoom}: {:.1} ms, {bytes} bytes", start.elapsed().as_secs_f64() * 1e3);
            }
        }
        "forty harbours and their tiles" => {
            let set = served(&db);
            for block in 0..40 {
                set.index.shallowest_within(place(block), 500.0, &Demand::default());
                (10..=16).for_each(|zoom| assert!(tile(&set, zoom, place(block)) > 0));
            }
        }
        // Between places 1 km apart, harbours 18 km apart, and such five blocks apart.
        "routes of 1 km" => {
            routes(&served(&db), at, LatLon::from_deg(at.lat_deg() - 0.004, at.lon_deg() - 0.01).unwrap());
        }
        "routes of 18 km" => routes(&served(&db), at, place(1)),
        "routes of 90 km" => routes(&served(&db), at, place(5)),
        "routes of 180 km" => routes(&served(&db), at, place(10)),
        // A server reads its index once from end to end, after the set is in force.
        _ => assert!(ChartPackage::open(&db, &load_index(&db).unwrap()).unwrap().offer().bytes > 0),
    }
    let taken = start.elapsed();
    let (taken_s, worked_s) = (taken.as_secs_f64(), processor_s());
    println!("{step}: {taken_s:.3} s, of the processor {worked_s:.2} s; {} MiB at most", peak_kib() >> 10);
}

fn bring(db: &Path, input: &Path) {
    let options = ImportOptions::new(UtcTime::from_micros(0));
    let report = import(db, &[input.to_owned()], &options, &mut |_| true).unwrap();
    assert!(report.applied && report.failures.is_empty(), "{:?}", report.failures.first());
}

fn take_out(db: &Path, input: &Path) {
    let name = |entry: std::io::Result<fs::DirEntry>| {
        entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned()
    };
    let names: Vec<String> = fs::read_dir(input).unwrap().map(name).collect();
    chartdb::remove(db, &names, UtcTime::from_micros(0)).unwrap();
}

/// Requests a route for the first time and again, and one between unconnected waters.
fn routes(set: &Set, from: LatLon, to: LatLon) {
    let needs = Needs::depth_and_clearance(2.0, 25.0);
    for turn in ["first", "again"] {
        let start = Instant::now();
        let answer = set.router.route(&Request::new(from, to), &needs, &Cancel::never());
        let told = answer
            .map_or_else(|refusal| refusal.to_string(), |route| format!("{:.1} km", route.length_m / 1e3));
        let (rooms, bytes) = set.router.kept();
        let took_ms = start.elapsed().as_secs_f64() * 1e3;
        println!("  {turn}: {took_ms:.1} ms, {rooms} waters of {} MiB are kept: {told}", bytes >> 20);
    }
}

/// Within a harbour of a block.
fn place(block: u32) -> LatLon {
    let [north_deg, east_deg] = shift(block).map(|units| f64::from(units) / 1e7);
    LatLon::from_deg(63.446 + north_deg, 10.345 + east_deg).unwrap()
}

/// The set as a server loads it before it reads its index for the vessels.
fn served(db: &Path) -> Arc<Set> {
    Set::open(db, 64 << 20).unwrap()
}

/// Bytes of the packed tile of a place.
fn tile(set: &Set, zoom: u8, at: LatLon) -> usize {
    let wide = f64::from(1_u32 << zoom);
    let y = (1.0 - at.lat_deg().to_radians().tan().asinh() / std::f64::consts::PI) / 2.0;
    let tile = set.tile(zoom, ((at.lon_deg() + 180.0) / 360.0 * wide) as u32, (y * wide) as u32);
    tile.map_or(0, |bytes| bytes.len())
}

/// Processor time of this process (s), including system time, from Linux.
fn processor_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().skip(11).take(2);
    // A hundred in a second.
    ticks.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Peak memory of this process, from Linux.
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

/// Cells by name.
type Cells = Vec<(&'static str, Vec<u8>)>;

/// The cells that are moved: small ones with the archipelago, and large ones; `None` without the shared cells.
fn bases() -> Option<[Cells; 2]> {
    let read = |name: &&'static str| {
        let path: PathBuf = testkit::shared(&format!("data/charts/{name}.000"))?;
        Some((*name, fs::read(path).unwrap()))
    };
    let mut small: Cells = SMALL.iter().map(read).collect::<Option<_>>()?;
    for file in charts::demo::archipelago().unwrap() {
        small.push((file.name.trim_end_matches(".000"), file.bytes));
    }
    Some([small, LARGE.iter().map(read).collect::<Option<_>>()?])
}

/// Writes the cells; `None` without the shared ones.
fn write_cells(folder: &Path, wanted: usize) -> Option<(usize, u64)> {
    let [small, large] = bases()?;
    fs::create_dir_all(folder.join("cells")).unwrap();
    let (mut count, mut bytes) = (0, 0);
    for block in 0.. {
        let more = if block % 4 == 0 { &large[..] } else { &[] };
        for (name, base) in small.iter().chain(more) {
            if count == wanted {
                return Some((count, bytes));
            }
            count += 1;
            bytes += base.len() as u64;
            write_cell(&folder.join("cells"), name, base, block, shift(block));
        }
    }
    None
}

/// Writes a small and a large cell, for the import of one.
fn write_more(folder: &Path) -> Option<()> {
    let [small, large] = bases()?;
    for (part, (name, base)) in [("small", &small[5]), ("large", &large[0])] {
        fs::create_dir_all(folder.join(part)).unwrap();
        write_cell(&folder.join(part), name, base, 0xff, shift(3));
    }
    Some(())
}

/// Writes a cell under another name, moved.
fn write_cell(folder: &Path, name: &str, base: &[u8], block: u32, shift: [i32; 2]) {
    let mut bytes = base.to_vec();
    // The rest of the name identifies the cell within a block.
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
