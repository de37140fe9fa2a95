//! What pages ask, of plain and of compressed months in turn.

use super::{DAY_US, Folders, HOUR_US, main_system};
use crate::{MONTH_US, memory_kib};
use std::fmt::Debug;
use std::path::Path;
use std::time::Instant;
use store::{CsvOptions, DetectionsWanted, Order, Page, Reader, Selection, Source, TimeRange, export_csv};
use units::UtcTime;

/// Times that each question is asked of each.
const TIMES: usize = 11;

pub(super) fn ask(plain: &Path, packed: &Path) {
    let folders: Folders = [plain.to_owned(), packed.to_owned()];
    let system = main_system(plain);
    let state = source_of(plain, system, "EstimatedState");
    let range = |from_us: i64, length_us: i64| TimeRange { from_us, to_us: from_us + length_us };
    let month = range(MONTH_US, 30 * DAY_US);
    let day = range(MONTH_US + 9 * DAY_US, DAY_US);
    let turn = range(MONTH_US + 9 * DAY_US + 8 * HOUR_US + 1_234_567, 300_000_000);
    let season = range(MONTH_US - 300 * DAY_US, 330 * DAY_US);
    println!("| question | plain | compressed | ratio of medians |\n|---|---|---|---|");
    for (what, part) in [("five minutes", turn), ("a day", day), ("a month", month), ("ten months", season)] {
        both(&format!("plot of one field over {what}, 1000 buckets"), &folders, |reader| {
            reader.buckets(&state, "psi", part, 1_000).unwrap().buckets
        });
        both(&format!("track over {what}, 1000 points"), &folders, |reader| {
            reader.track(system, part, 1_000, 0.5).unwrap().points
        });
    }
    both("latest message of a series", &folders, |reader| {
        reader.last_row(&state, &["lat", "lon", "psi", "u"], season).unwrap()
    });
    both("latest of every series at a time", &folders, |reader| {
        reader.then(system, day.to_us - 12 * HOUR_US, 1_000, 4 << 20).unwrap().last.len()
    });
    both("raw samples of five minutes, three fields", &folders, |reader| {
        reader.samples(&state, &["psi", "u", "true_lat_deg"], turn, usize::MAX).unwrap().time_us.len()
    });
    both("a page of 500 messages with all fields", &folders, |reader| {
        let fields = ["lat", "lon", "height", "x", "y", "z", "phi", "theta", "psi", "u", "v", "w"];
        reader.rows(&state, &fields, turn, Page::first(500)).unwrap().items
    });
    both("detections of a month", &folders, |reader| {
        reader.detections(None, month, None, Order::Oldest, Page::first(10_000)).unwrap().items
    });
    both("the newest 50 detections of ten months", &folders, |reader| {
        reader.detections(None, season, None, Order::Newest, Page::first(50)).unwrap().items
    });
    both("detections that came on one day, in ten months", &folders, |reader| {
        let came_from = Some(UtcTime::from_micros(day.from_us));
        let wanted = DetectionsWanted { systems: None, range: season, came_from, tags: Vec::new() };
        reader.detections_of(&wanted, Order::Newest, Page::first(500)).unwrap().items
    });
    both("log book of ten months", &folders, |reader| {
        reader.log_book(None, season, Order::Newest, Page::first(100)).unwrap().items
    });
    both("silences of a month", &folders, |reader| reader.silences(system, month).unwrap());
    both("systems", &folders, |reader| {
        let mut systems = reader.systems().unwrap();
        systems.retain(|one| one.address != crate::OTTER);
        systems.len()
    });
    both("series", &folders, |reader| reader.series(Some(system)).unwrap());
    println!();
    exports(&folders, system, day, month);
}

fn source_of(folder: &Path, system: imc::Address, message: &str) -> Source {
    let mut reader = Reader::open(folder).unwrap();
    let all = reader.series(Some(system)).unwrap();
    let found = all.iter().filter(|one| one.message == Some(message)).max_by_key(|one| one.extent.count);
    Source { system, entity: found.unwrap().group.src_ent, message: message.to_owned() }
}

/// Asks both in turn; their answers must be the same.
fn both<T: Debug>(what: &str, folders: &Folders, ask: impl Fn(&mut Reader) -> T) {
    let mut took = [Vec::new(), Vec::new()];
    let mut answers = [String::new(), String::new()];
    for _ in 0..TIMES {
        for (at, folder) in folders.iter().enumerate() {
            let began = Instant::now();
            let mut reader = Reader::open(folder).unwrap();
            let answer = ask(&mut reader);
            drop(reader);
            took[at].push(began.elapsed().as_secs_f64() * 1e3);
            answers[at] = format!("{answer:?}");
        }
    }
    assert!(answers[0] == answers[1], "{what}: {} and {}", answers[0], answers[1]);
    for took in &mut took {
        took.sort_by(f64::total_cmp);
    }
    let [plain, packed] = &took;
    println!(
        "| {what} | {:.1} ms (longest {:.1}) | {:.1} ms (longest {:.1}) | {:.2} |",
        plain[TIMES / 2],
        plain[TIMES - 1],
        packed[TIMES / 2],
        packed[TIMES - 1],
        packed[TIMES / 2] / plain[TIMES / 2]
    );
}

fn exports(folders: &Folders, system: imc::Address, day: TimeRange, month: TimeRange) {
    let messages = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let one = Selection { messages: messages(&["EstimatedState"]), range: month, ..Selection::default() };
    let selections = [
        (
            "CSV of EstimatedState over a month, one vessel",
            Selection { systems: vec![system], ..one.clone() },
        ),
        ("CSV of EstimatedState over a month, all vessels", one),
        ("CSV of everything of a day", Selection { range: day, ..Selection::default() }),
        ("CSV of everything of a month", Selection { range: month, ..Selection::default() }),
    ];
    println!("| export | plain | compressed | ratio |\n|---|---|---|---|");
    for (what, selection) in selections {
        let told: Vec<(f64, String)> = folders
            .iter()
            .map(|folder| {
                // Writing 5 resets the peak.
                std::fs::write("/proc/self/clear_refs", "5").unwrap();
                let before = memory_kib("VmRSS");
                let began = Instant::now();
                let exported =
                    export_csv(folder, &selection, &CsvOptions::default(), &mut std::io::sink()).unwrap();
                let took = began.elapsed().as_secs_f64();
                let more = memory_kib("VmHWM").saturating_sub(before) as f64 / 1e3;
                let speed = exported.rows as f64 / took;
                (took, format!("{} rows in {took:.1} s, {speed:.0}/s, {more:.1} MB more", exported.rows))
            })
            .collect();
        println!("| {what} | {} | {} | {:.2} |", told[0].1, told[1].1, told[1].0 / told[0].0);
    }
}
