//! How fast the store is: `cargo bench -p store --bench store [-- ingest|month|year|hour|csv|compressed|season]`.
//!
//! The stores of a month at 10 Hz and of a year at 1 Hz are built once, under `target/store-bench`; remove that
//! folder to build them again.

#![expect(clippy::unwrap_used, reason = "a benchmark fails where it unwraps nothing")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

mod season;

use imc::lsf::{LogItem, LogReader};
use imc::messages::{EstimatedState, EulerAngles, Payload, Temperature};
use imc::{Address, Header};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use store::{Accepted, CsvOptions, Reader, Selection, Source, Store, TimeRange, Transport, export_csv};
use units::UtcTime;

/// 2026-10-01T00:00:00Z.
const MONTH_US: i64 = 1_790_812_800_000_000;
/// 2025-01-01T00:00:00Z.
const YEAR_US: i64 = 1_735_689_600_000_000;
const DAY_US: i64 = 86_400_000_000;
const OTTER: Address = Address(0x2810);
const COMMIT_EVERY: Duration = Duration::from_millis(250);
/// At 100,000 messages a second as many come in that time.
const COMMIT_PACKETS: u64 = 25_000;

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load of the machine before: {}", load.trim());
    for (name, run) in [
        ("ingest", ingest as fn()),
        ("month", month as fn()),
        ("year", year as fn()),
        ("hour", hour as fn()),
        ("csv", csv as fn()),
        ("compressed", compressed as fn()),
        ("season", season::season as fn()),
    ] {
        if wanted.is_empty() || wanted.iter().any(|one| one == name) {
            run();
        }
    }
}

fn built(name: &str, build: impl FnOnce(&Path)) -> PathBuf {
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/store-bench");
    let folder = target.join(name);
    if !folder.exists() {
        let unfinished = target.join(format!("{name}.part"));
        std::fs::remove_dir_all(&unfinished).ok();
        std::fs::create_dir_all(&unfinished).unwrap();
        build(&unfinished);
        // Only the history is asked; what the archive takes is left to others.
        std::fs::remove_dir_all(unfinished.join("archive")).unwrap();
        std::fs::rename(&unfinished, &folder).unwrap();
    }
    folder
}

fn packet<T: Payload>(out: &mut Vec<u8>, time_us: i64, entity: u8, message: &T) {
    let timestamp = UtcTime::from_micros(time_us).seconds();
    let header = Header { timestamp, src: OTTER, src_ent: entity, ..Header::default() };
    out.clear();
    imc::encode_into(out, &header, message).unwrap();
}

/// Feeds a store as a server does, committing four times a second.
struct Feeder {
    store: Store,
    packets: u64,
    started: Instant,
    committed: Instant,
    commits: Vec<Duration>,
}

impl Feeder {
    fn new(folder: &Path) -> Self {
        let now = Instant::now();
        Self {
            store: Store::open(folder).unwrap(),
            packets: 0,
            started: now,
            committed: now,
            commits: Vec::new(),
        }
    }

    fn feed(&mut self, packet: &[u8], received_us: i64) {
        let received = UtcTime::from_micros(received_us);
        self.store.accept(&Accepted { packet, received, transport: Transport::Tcp, link: None }).unwrap();
        self.packets += 1;
        let many = self.packets.is_multiple_of(COMMIT_PACKETS);
        // Reading the clock costs as much as taking a packet.
        if many || self.packets.is_multiple_of(64) && self.committed.elapsed() >= COMMIT_EVERY {
            self.commit();
        }
    }

    fn commit(&mut self) {
        let committed = self.store.commit().unwrap();
        assert_eq!(committed.history_behind, None);
        let now = Instant::now();
        self.commits.push(now - self.committed);
        self.committed = now;
    }

    fn finish(mut self, what: &str) {
        self.commit();
        let taken = self.started.elapsed();
        let longest =
            self.commits.iter().enumerate().max_by_key(|(_, took)| **took).map_or(0, |(at, _)| at + 1);
        self.commits.sort();
        let worst = self.commits.last().copied().unwrap_or_default();
        let middle = self.commits[self.commits.len() / 2];
        println!(
            "{what}: {} messages in {:.1} s = {:.0} messages/s; {} commits, \
             from one to the next median {} ms, 99 of 100 within {} ms, longest {} ms (commit {longest})",
            self.packets,
            taken.as_secs_f64(),
            self.packets as f64 / taken.as_secs_f64(),
            self.commits.len(),
            middle.as_millis(),
            self.commits[self.commits.len() * 99 / 100].as_millis(),
            worst.as_millis(),
        );
        let start = Instant::now();
        self.store.settle().unwrap();
        println!("{what}: rolled up and saved the rest in {:.1} s", start.elapsed().as_secs_f64());
        self.store.close().unwrap();
    }
}

/// The recorded traffic of a DUNE vehicle, again and again, each time five minutes later.
fn ingest() {
    const ROUNDS: i64 = 30;
    let Some(recording) = testkit_shared() else {
        println!("ingest: skipped, the recorded traffic is absent");
        return;
    };
    let mut log = LogReader::open(&recording).unwrap();
    let mut packets: Vec<Vec<u8>> = Vec::new();
    while let Some(item) = log.next_item().unwrap() {
        if let LogItem::Packet { view, .. } = item {
            packets.push(view.bytes().to_vec());
        }
    }
    let folder = tempfile::tempdir_in(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target")).unwrap();
    let mut feeder = Feeder::new(folder.path());
    for round in 0..ROUNDS {
        for packet in &mut packets {
            let timestamp = f64::from_le_bytes(packet[6..14].try_into().unwrap()) + 300.0;
            packet[6..14].copy_from_slice(&timestamp.to_le_bytes());
            let end = packet.len() - 2;
            let crc = imc::crc16(&packet[..end]);
            packet[end..].copy_from_slice(&crc.to_le_bytes());
            feeder.feed(packet, MONTH_US + round);
        }
    }
    feeder.finish("ingest of recorded traffic");
}

fn testkit_shared() -> Option<PathBuf> {
    testkit::shared("data/imc/dune_capture_a.imc.gz")
}

fn build_temperature(folder: &Path, start_us: i64, days: i64, period_us: i64) {
    let mut feeder = Feeder::new(folder);
    let mut bytes = Vec::new();
    for at in 0..days * DAY_US / period_us {
        let time_us = start_us + at * period_us;
        let value = 8.0 + 4.0 * (at as f64 * 1e-5).sin() as f32 + (at % 17) as f32 * 0.01;
        packet(&mut bytes, time_us, 5, &Temperature { value });
        feeder.feed(&bytes, time_us);
    }
    feeder.finish("building it");
}

fn month() {
    let folder = built("month", |folder| build_temperature(folder, MONTH_US, 30, 100_000));
    ask("month at 10 Hz", &folder, MONTH_US, 30);
    let mut reader = Reader::open(&folder).unwrap();
    let hour = TimeRange { from_us: MONTH_US + 5 * DAY_US, to_us: MONTH_US + 5 * DAY_US + DAY_US / 24 };
    warm("raw hour at 10 Hz, one field", || {
        reader.samples(&temperature(), &["value"], hour, usize::MAX).unwrap().time_us.len()
    });
}

fn year() {
    let folder = built("year", |folder| build_temperature(folder, YEAR_US, 365, 1_000_000));
    ask("year at 1 Hz", &folder, YEAR_US, 365);
}

fn temperature() -> Source {
    Source { system: OTTER, entity: 5, message: "Temperature".to_owned() }
}

/// A thousand buckets over ranges of all lengths.
fn ask(what: &str, folder: &Path, start_us: i64, days: i64) {
    let mut reader = Reader::open(folder).unwrap();
    let end_us = start_us + days * DAY_US;
    let ranges_s: [i64; 12] = [
        600,
        3_600,
        9_000,
        10_100,
        21_600,
        59_000,
        86_400,
        7 * 86_400,
        599_000,
        14 * 86_400,
        30 * 86_400,
        365 * 86_400,
    ];
    for length_s in ranges_s.into_iter().filter(|length_s| *length_s <= days * 86_400) {
        // Not aligned to anything.
        let from_us = (end_us - length_s * 1_000_000 - 12_345_678).max(start_us);
        let range = TimeRange { from_us, to_us: from_us + length_s * 1_000_000 };
        warm(&format!("{what}, 1000 buckets over {:.2} days", length_s as f64 / 86_400.0), || {
            reader.buckets(&temperature(), "value", range, 1_000).unwrap().buckets.len()
        });
    }
}

fn build_hour(folder: &Path) {
    let mut feeder = Feeder::new(folder);
    let mut bytes = Vec::new();
    for at in 0..36_000 {
        let state = EstimatedState {
            lat: 1.1 + f64::from(at) * 1e-9,
            lon: 0.18,
            x: at as f32 * 0.01,
            psi: at as f32 * 1e-4,
            ..EstimatedState::default()
        };
        let time_us = MONTH_US + i64::from(at) * 100_000;
        packet(&mut bytes, time_us, 39, &state);
        feeder.feed(&bytes, time_us);
    }
    feeder.finish("building it");
}

fn hour() {
    ask_hour(&built("hour", build_hour));
}

fn ask_hour(folder: &Path) {
    let mut reader = Reader::open(folder).unwrap();
    let source = Source { system: OTTER, entity: 39, message: "EstimatedState".to_owned() };
    warm("raw hour of EstimatedState at 10 Hz, three fields", || {
        reader
            .samples(&source, &["psi", "u", "true_lat_deg"], TimeRange::ALL, usize::MAX)
            .unwrap()
            .time_us
            .len()
    });
    warm("the hour's track, 1000 points", || {
        reader.track(OTTER, TimeRange::ALL, 1_000, 0.5).unwrap().points.len()
    });
}

/// Counts bytes and says when the first came.
struct Counter {
    started: Instant,
    first: Option<Duration>,
    bytes: u64,
}

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.first.get_or_insert_with(|| self.started.elapsed());
        self.bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A figure of this process in `/proc/self/status` (KiB).
fn memory_kib(name: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(name)).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

fn csv() {
    let folder = built("month", |folder| build_temperature(folder, MONTH_US, 30, 100_000));
    let days = |count: i64| Selection {
        messages: vec!["Temperature".to_owned()],
        range: TimeRange { from_us: MONTH_US, to_us: MONTH_US + count * DAY_US },
        ..Selection::default()
    };
    table("CSV of one series with one field", &folder, &days(5));
    ask_mixed(&built("mixed", build_mixed));
}

fn build_mixed(folder: &Path) {
    let mut feeder = Feeder::new(folder);
    let mut bytes = Vec::new();
    for at in 0..500_000_i64 {
        let time_us = MONTH_US + at * 100_000;
        let psi = at as f64 * 1e-4;
        packet(&mut bytes, time_us, 6, &EulerAngles { psi, phi: psi * 0.1, ..EulerAngles::default() });
        feeder.feed(&bytes, time_us);
        for entity in 10..13 {
            packet(&mut bytes, time_us + i64::from(entity), entity, &Temperature { value: psi as f32 });
            feeder.feed(&bytes, time_us);
        }
    }
    feeder.finish("building it");
}

fn ask_mixed(folder: &Path) {
    let angles = Selection { messages: vec!["EulerAngles".to_owned()], ..Selection::default() };
    table("CSV of one series with all five fields", folder, &angles);
    table("CSV of four series with two messages in order of time", folder, &Selection::default());
}

/// The same questions to months that are compressed and to the same that are not.
fn compressed() {
    let hour = [built("hour", build_hour), built("hour-compressed", |folder| compress(folder, build_hour))];
    let mixed =
        [built("mixed", build_mixed), built("mixed-compressed", |folder| compress(folder, build_mixed))];
    for (what, hour, mixed) in [("plain", &hour[0], &mixed[0]), ("compressed", &hour[1], &mixed[1])] {
        println!("{what}:");
        ask_hour(hour);
        ask_mixed(mixed);
    }
}

fn compress(folder: &Path, build: impl FnOnce(&Path)) {
    build(folder);
    let mut store = Store::open(folder).unwrap();
    let now = UtcTime::from_micros(MONTH_US + 90 * DAY_US);
    for month in store::plan_months(folder, 1, now).unwrap() {
        store.ready_month(month.key).unwrap();
        let started = Instant::now();
        let packed = store::PackedMonth::make(folder, &month, &mut |_| true).unwrap();
        let done = store.adopt_month(packed).unwrap().done().unwrap();
        println!(
            "compressing {} messages: {:.1} s, {} MB, now {} MB",
            done.rows,
            started.elapsed().as_secs_f64(),
            done.bytes / 1_000_000,
            done.packed_bytes / 1_000_000
        );
    }
    store.close().unwrap();
}

fn table(what: &str, folder: &Path, selection: &Selection) {
    // Writing 5 resets the peak.
    std::fs::write("/proc/self/clear_refs", "5").unwrap();
    let before = memory_kib("VmRSS");
    let started = Instant::now();
    let mut out = Counter { started, first: None, bytes: 0 };
    let exported = export_csv(folder, selection, &CsvOptions::default(), &mut out).unwrap();
    let taken = started.elapsed().as_secs_f64();
    println!(
        "{what}: {} rows, {} MB in {taken:.1} s = {:.0} rows/s; first byte after {:.1} ms; {:.1} MB more memory",
        exported.rows,
        out.bytes / 1_000_000,
        exported.rows as f64 / taken,
        out.first.unwrap_or_default().as_secs_f64() * 1e3,
        memory_kib("VmHWM").saturating_sub(before) as f64 / 1e3,
    );
}

/// Asks eleven times and prints the first and the median of the others.
fn warm(what: &str, mut ask: impl FnMut() -> usize) {
    let mut took = Vec::new();
    let mut answers = 0;
    for _ in 0..11 {
        let start = Instant::now();
        answers = ask();
        took.push(start.elapsed());
    }
    let cold = took.remove(0);
    took.sort();
    println!(
        "{what}: {answers} answers, first {:.1} ms, then {:.1} ms (longest {:.1} ms)",
        cold.as_secs_f64() * 1e3,
        took[took.len() / 2].as_secs_f64() * 1e3,
        took[took.len() - 1].as_secs_f64() * 1e3
    );
}
