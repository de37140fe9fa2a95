//! A season of recorded traffic as plain months and as compressed ones: how fast both answer what pages ask, what an export takes, how
//! large they are, and for how long compressing holds the recorder.
//!
//! The recording of a DUNE vehicle is three vessels' traffic: two turns of five minutes a day, on twenty days of a month (11 million
//! messages); and in each of nine months before, one turn. Each question is asked as the server does, by a reader of its own.

mod questions;

use crate::{Feeder, MONTH_US, OTTER, built, packet, testkit_shared};
use flate2::Compression;
use flate2::write::GzEncoder;
use imc::Address;
use imc::lsf::{LogItem, LogReader};
use imc::messages::{TBRFishTag, Temperature};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use store::{Accepted, PackableMonth, PackedMonth, Readiness, Store, Transport};
use units::UtcTime;

const VESSELS: u16 = 3;
const ROUND_US: i64 = 300_000_000;
const DAY_US: i64 = 86_400_000_000;
const HOUR_US: i64 = DAY_US / 24;
/// How much longer than a turn of the work the server's rest after it is.
const REST: u32 = 4;
/// Months that are compressed with these rests; the others without, or the largest alone takes a quarter of an hour.
const RESTED: usize = 3;

/// Runs it.
pub(crate) fn season() {
    let Some(recording) = testkit_shared() else {
        println!("season: skipped, the recorded traffic is absent");
        return;
    };
    let packets = packets(&recording);
    let plain = built("season", |folder| build(folder, &packets));
    let packed = built("season-compressed", |folder| {
        copy(&plain.join("history"), &folder.join("history"));
        std::fs::create_dir_all(folder.join("archive")).unwrap();
        compress(folder);
    });
    sizes(&plain, &packed);
    questions::ask(&plain, &packed);
}

/// The recorded packets, with their times as of the first one.
fn packets(recording: &Path) -> Vec<(i64, Vec<u8>)> {
    let mut log = LogReader::open(recording).unwrap();
    let mut packets: Vec<(i64, Vec<u8>)> = Vec::new();
    while let Some(item) = log.next_item().unwrap() {
        if let LogItem::Packet { view, .. } = item
            && let Some(time) = view.header().time()
        {
            packets.push((time.micros(), view.bytes().to_vec()));
        }
    }
    let first_us = packets[0].0;
    for (time_us, _) in &mut packets {
        *time_us -= first_us;
    }
    packets.retain(|(time_us, _)| (0..ROUND_US).contains(time_us));
    packets
}

/// The turns of a season: when each begins, and its vessel.
fn turns() -> Vec<(i64, u16)> {
    let mut turns = Vec::new();
    for month in (1..10).rev() {
        turns.extend((0..VESSELS).map(|vessel| (MONTH_US - month * 30 * DAY_US + 10 * HOUR_US, vessel)));
    }
    for turn in 0..40 {
        let start_us = MONTH_US + turn / 2 * DAY_US + (8 + turn % 2) * HOUR_US;
        turns.extend((0..VESSELS).map(|vessel| (start_us, vessel)));
    }
    turns
}

fn build(folder: &Path, packets: &[(i64, Vec<u8>)]) {
    let mut feeder = Feeder::new(folder);
    let mut zip = GzEncoder::new(Counted::default(), Compression::new(6));
    let mut tag = Vec::new();
    for (start_us, vessel) in turns() {
        for (after_us, recorded) in packets {
            let said = moved(recorded, start_us + after_us, vessel);
            zip.write_all(&said).unwrap();
            feeder.feed(&said, start_us + after_us);
        }
        for at in 0..15 {
            let time_us = start_us + at * 20_000_000;
            let said = TBRFishTag {
                serial_no: 1_000 + u32::from(vessel),
                unix_timestamp: (time_us / 1_000_000) as u32,
                millis: 250,
                trans_id: 100 + (at % 10) as u32,
                snr: 20 + at as u8,
                ..TBRFishTag::default()
            };
            packet(&mut tag, time_us, 60, &said);
            let said = moved(&tag, time_us, vessel);
            zip.write_all(&said).unwrap();
            feeder.feed(&said, time_us);
        }
    }
    feeder.finish("building the season");
    let zipped = zip.finish().unwrap().0;
    println!("its packets in LSF.gz (gzip -6): {:.1} MB", zipped as f64 / 1e6);
    std::fs::write(folder.join("gzip"), zipped.to_string()).unwrap();
}

/// A packet said at another time by another vessel.
fn moved(recorded: &[u8], time_us: i64, vessel: u16) -> Vec<u8> {
    let mut said = recorded.to_vec();
    said[6..14].copy_from_slice(&UtcTime::from_micros(time_us).seconds().to_le_bytes());
    let src = u16::from_le_bytes([said[14], said[15]]) + vessel * 0x100;
    said[14..16].copy_from_slice(&src.to_le_bytes());
    let end = said.len() - 2;
    let crc = imc::crc16(&said[..end]);
    said[end..].copy_from_slice(&crc.to_le_bytes());
    said
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for file in std::fs::read_dir(from).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), to.join(file.file_name())).unwrap();
    }
}

/// Compresses all months while a vessel sends for another one, as a server does.
fn compress(folder: &Path) {
    let mut store = Store::open(folder).unwrap();
    let now = UtcTime::from_micros(MONTH_US + 90 * DAY_US);
    let mut live = Live { now_us: now.micros(), commits: Vec::new() };
    live.record(&mut store, &mut |done| done < 20);
    println!("commits of a thousand messages a second, without compression: {}", live.told());
    live.commits.clear();
    let (mut longest, mut bytes, mut packed_bytes, mut rows) = (Duration::ZERO, 0, 0, 0);
    let (mut work, mut largest, mut adopting) = (Duration::ZERO, 0, Duration::ZERO);
    for (at, month) in store::plan_months(folder, 1, now).unwrap().into_iter().enumerate() {
        let rest = if at < RESTED { REST } else { 0 };
        loop {
            let began = Instant::now();
            let ready = store.ready_month_some(month.key).unwrap();
            longest = longest.max(began.elapsed());
            match ready {
                Readiness::Ready => break,
                Readiness::Unfinished => {}
                Readiness::Behind => panic!("the history lacks nothing"),
            }
        }
        let began = Instant::now();
        let made = make_beside(folder, (month, rest), &mut store, &mut live);
        if month.bytes > largest {
            (largest, work) = (month.bytes, began.elapsed());
        }
        let began = Instant::now();
        let store::Adopted::Done(done, replaced) = store.adopt_month(made).unwrap() else {
            panic!("nothing reads it");
        };
        adopting = adopting.max(began.elapsed());
        drop(replaced);
        if at + 1 == RESTED {
            println!("commits beside compression with the server's rests: {}", live.told());
            live.commits.clear();
        }
        (bytes, packed_bytes, rows) =
            (bytes + done.bytes, packed_bytes + done.packed_bytes, rows + done.rows);
    }
    store.close().unwrap();
    println!("commits beside compression without a rest: {}", live.told());
    println!(
        "compressed {rows} messages, {:.1} MB, now {:.1} MB; the largest month ({:.1} MB) took {:.1} s without a rest; longest hold of \
         the recorder {:.1} ms to make a month ready, {:.1} ms to replace it",
        bytes as f64 / 1e6,
        packed_bytes as f64 / 1e6,
        largest as f64 / 1e6,
        work.as_secs_f64(),
        longest.as_secs_f64() * 1e3,
        adopting.as_secs_f64() * 1e3
    );
}

/// Makes a compressed month in a thread of its own while the store records.
fn make_beside(
    folder: &Path,
    (month, rest): (PackableMonth, u32),
    store: &mut Store,
    live: &mut Live,
) -> PackedMonth {
    let is_done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let making = scope.spawn(|| {
            let mut began = Instant::now();
            let made = PackedMonth::make(folder, &month, &mut |_| {
                std::thread::sleep((began.elapsed() * rest).min(Duration::from_millis(500)));
                began = Instant::now();
                true
            });
            is_done.store(true, Ordering::Relaxed);
            made.unwrap()
        });
        live.record(store, &mut |_| !is_done.load(Ordering::Relaxed));
        making.join().unwrap()
    })
}

/// A vessel that sends a thousand messages a second.
struct Live {
    now_us: i64,
    commits: Vec<Duration>,
}

impl Live {
    /// Records while `goes_on`, which gets the commits so far, says so.
    fn record(&mut self, store: &mut Store, goes_on: &mut dyn FnMut(usize) -> bool) {
        let mut bytes = Vec::new();
        let mut done = 0;
        while goes_on(done) {
            let began = Instant::now();
            for at in 0..250 {
                self.now_us += 1_000;
                packet(&mut bytes, self.now_us, at as u8, &Temperature { value: at as f32 });
                let received = UtcTime::from_micros(self.now_us);
                let (transport, link) = (Transport::Tcp, None);
                store.accept(&Accepted { packet: &bytes, received, transport, link }).unwrap();
            }
            store.commit().unwrap();
            self.commits.push(began.elapsed());
            done += 1;
            std::thread::sleep(Duration::from_millis(250).saturating_sub(began.elapsed()));
        }
    }

    fn told(&self) -> String {
        let mut commits = self.commits.clone();
        commits.sort();
        let at = |share: usize| commits.get((commits.len() * share / 100).min(commits.len() - 1)).unwrap();
        let ms = |took: &Duration| took.as_secs_f64() * 1e3;
        format!(
            "{} of them, median {:.1} ms, 99 of 100 within {:.1} ms, longest {:.1} ms",
            commits.len(),
            ms(at(50)),
            ms(at(99)),
            ms(at(100))
        )
    }
}

fn sizes(plain: &Path, packed: &Path) {
    let months = |folder: &Path| -> u64 {
        let files = std::fs::read_dir(folder.join("history")).unwrap().map(|file| file.unwrap());
        // What was recorded beside the compression is a month that the plain season lacks.
        let is_own = |name: &str| plain.join("history").join(name).exists() && !name.starts_with("catalogue");
        files
            .filter(|file| is_own(&file.file_name().to_string_lossy()))
            .map(|file| file.metadata().unwrap().len())
            .sum()
    };
    let zipped: u64 = std::fs::read_to_string(plain.join("gzip")).unwrap().parse().unwrap();
    let told =
        |bytes: u64| format!("{:.1} MB, {:.2} of LSF.gz", bytes as f64 / 1e6, bytes as f64 / zipped as f64);
    println!("months plain: {}; compressed: {}", told(months(plain)), told(months(packed)));
}

/// Counts bytes.
#[derive(Default)]
struct Counted(u64);

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The system of a vessel whose address the recording has.
fn main_system(folder: &Path) -> Address {
    let mut reader = store::Reader::open(folder).unwrap();
    let series = reader.series(None).unwrap();
    let states =
        series.iter().filter(|one| one.message == Some("EstimatedState") && one.group.src != OTTER.0);
    states.max_by_key(|one| one.extent.count).map(|one| Address(one.group.src)).unwrap()
}

/// Where something of the season lies.
type Folders = [PathBuf; 2];
