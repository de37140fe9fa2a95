//! Days that were compressed, as exports, the history and imports read them, and their sizes.

use crate::support::{OTTER, START_US, accept_link, dump, packet, state, temperature, utc};
use flate2::Compression;
use flate2::write::GzEncoder;
use imc::lsf::{LogItem, LogReader};
use link::{LinkSeq, Transport};
use std::fs;
use std::io::Write as _;
use std::path::Path;
use store::{
    Accepted, PackedMonth, Packing, Selection, Store, TimeRange, export_lsf, log_version, plan_months,
    plan_packing, usage,
};

const DAY_US: i64 = 86_400_000_000;

/// Compresses all that can be; how many days.
fn compress(store: &mut Store, folder: &Path) -> usize {
    let days = plan_packing(folder, 3, utc(START_US + 60 * DAY_US)).unwrap();
    for day in &days {
        let mut packing = Packing::begin(folder, day).unwrap();
        while packing.work(1 << 20).unwrap() {}
        store.adopt(&mut packing).unwrap().unwrap();
    }
    days.len()
}

/// Three days of one vessel, committed and settled.
fn fill(folder: &Path) -> Store {
    let mut store = Store::open(folder).unwrap();
    for seq in 0..3_000_u64 {
        let at_us = START_US + (seq / 1_000) as i64 * DAY_US + (seq % 1_000) as i64 * 100_000;
        let bytes =
            if seq % 2 == 0 { temperature(at_us, seq as f32) } else { packet(at_us, 7, &state(seq as f32)) };
        accept_link(&mut store, &bytes, at_us, seq);
    }
    store.commit().unwrap();
    store.settle().unwrap();
    store
}

fn exported(folder: &Path, selection: &Selection) -> (Vec<u8>, u64) {
    let mut log = Vec::new();
    export_lsf(folder, selection, &mut log).unwrap();
    (log, log_version(folder, selection).unwrap())
}

#[test]
fn exports_and_a_history_made_again_are_as_before_and_the_folder_is_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = fill(folder.path());
    let (all, some) = (
        Selection::default(),
        Selection {
            messages: vec!["Temperature".to_owned()],
            range: TimeRange {
                from_us: START_US + DAY_US + 1_000_000,
                to_us: START_US + DAY_US + 20_000_000,
            },
            ..Selection::default()
        },
    );
    let before = (exported(folder.path(), &all), exported(folder.path(), &some));
    let (rows, bytes) = (dump(folder.path()), usage(folder.path()).unwrap().archive[&OTTER].bytes);
    assert_eq!(compress(&mut store, folder.path()), 2);
    let after = (exported(folder.path(), &all), exported(folder.path(), &some));
    assert!(after == before, "an export differs, or its version, by which downloads are resumed");
    let used = usage(folder.path()).unwrap().archive[&OTTER];
    assert!(used.bytes < bytes * 6 / 10 && used.days == 3, "{} of {bytes} bytes", used.bytes);
    store.close().unwrap();
    assert_eq!(store::reindex(folder.path(), false, &mut |_| true).unwrap().samples, 3_000);
    assert!(dump(folder.path()) == rows, "the history differs");
}

#[test]
fn an_export_that_reads_a_day_while_it_is_compressed_is_whole() {
    struct Meanwhile<'a>(&'a mut dyn FnMut(usize), Vec<u8>);
    impl std::io::Write for Meanwhile<'_> {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.1.extend_from_slice(bytes);
            (self.0)(self.1.len());
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let mut store = fill(folder.path());
    let (before, _) = exported(folder.path(), &Selection::default());
    // Within the first day, and before the second is opened.
    let mut done = 0;
    let mut meanwhile = |written: usize| {
        if done == 0 && written > before.len() / 6 {
            done = compress(&mut store, folder.path());
        }
    };
    let mut out = Meanwhile(&mut meanwhile, Vec::new());
    export_lsf(folder.path(), &Selection::default(), &mut out).unwrap();
    assert!(out.1 == before, "the export differs");
    assert_eq!(done, 2);
}

#[test]
fn the_archive_of_another_server_is_imported_compressed_as_it_is() {
    let (from, to) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut store = fill(from.path());
    compress(&mut store, from.path());
    store.close().unwrap();
    let mut store = Store::open(to.path()).unwrap();
    let archive = [from.path().join("archive")];
    let imported = store.import(&archive, utc(START_US + 60 * DAY_US), &mut |_| true).unwrap();
    assert_eq!((imported.packets, imported.added, imported.problems), (3_000, 3_000, Vec::new()));
    let file = from.path().join("archive/0x2810/20261121/Data.lsf.zst");
    assert_eq!(store::beginning(&file).unwrap(), store::Beginning::Log);
    // One that is cut gives what it can and is named, and the next log is read all the same.
    let cut = from.path().join("cut.lsf.zst");
    let bytes = fs::read(&file).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let whole = from.path().join("archive/0x2810/20261122/Data.lsf.zst");
    let imported = store.import(&[cut, whole], utc(START_US + 60 * DAY_US), &mut |_| true).unwrap();
    assert_eq!((imported.files, imported.added), (2, 0));
    assert!(imported.packets >= 1_000, "{imported:?}");
    assert!(imported.problems[0].contains("cut.lsf.zst") && imported.problems.len() <= 2, "{imported:?}");
}

/// A number below `most` that looks like chance, the same in every run.
fn chance(number: i64, most: i64) -> i64 {
    let mixed = (number as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((mixed >> 33) % most as u64) as i64
}

/// Prints the sizes (`--nocapture`) of a recording of a DUNE vehicle, taken as over a vessel's link.
#[test]
fn a_recording_takes_less_than_its_gzip_and_its_index_a_few_bytes_a_packet() {
    let Some(recording) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let mut log = LogReader::open(&recording).unwrap();
    let (mut packets, mut plain, mut first_us, mut received_us) = (0_u64, Vec::new(), None, START_US);
    while let Some(item) = log.next_item().unwrap() {
        let LogItem::Packet { view, .. } = item else { continue };
        // As by the link: a burst about every 50 ms, in which each packet is read some microseconds after the one before.
        let said_us = view.header().time().unwrap().micros();
        let since_us = (said_us - *first_us.get_or_insert(said_us)).max(0);
        let burst_us = since_us / 50_000 * 50_000 + 80_000 + chance(since_us / 50_000, 20_000);
        received_us = (received_us + 5 + chance(packets as i64, 55)).max(START_US + burst_us);
        let received = utc(received_us);
        let accepted = Accepted {
            packet: view.bytes(),
            received,
            transport: Transport::Link,
            link: Some(LinkSeq { stream: 0x1234_5678_9ABC_DEF0, seq: packets }),
        };
        store.accept(&accepted).unwrap();
        plain.extend_from_slice(view.bytes());
        packets += 1;
        if packets % 20_000 == 0 {
            store.commit().unwrap();
        }
    }
    accept_link(&mut store, &temperature(START_US + DAY_US, 1.0), START_US + DAY_US, 0);
    store.commit().unwrap();
    store.settle().unwrap();
    let sizes = |store: &Store| {
        let mut found = [0_u64; 4];
        for system in fs::read_dir(store.folder().join("archive")).unwrap().map(|entry| entry.unwrap().path())
        {
            for (name, sum) in
                ["Data.lsf", "Arrivals.idx", "Data.lsf.zst", "Arrivals.zst"].iter().zip(&mut found)
            {
                *sum += fs::metadata(system.join("20261121").join(name)).map_or(0, |file| file.len());
            }
        }
        found
    };
    let [data, arrivals, ..] = sizes(&store);
    assert_eq!((data, arrivals), (plain.len() as u64, packets * 32));
    assert!(compress(&mut store, folder.path()) > 0);
    let [no_data, no_arrivals, packed_data, packed_arrivals] = sizes(&store);
    assert_eq!((no_data, no_arrivals), (0, 0));
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&plain).unwrap();
    let gzip = gzip.finish().unwrap().len() as u64;
    let history = |folder: &Path| {
        let (mut months, mut catalogue) = (0, 0);
        for (name, bytes) in usage(folder).unwrap().history {
            *(if name == "catalogue.sqlite" { &mut catalogue } else { &mut months }) += bytes;
        }
        [months, catalogue]
    };
    // Its last log is written back.
    store.close().unwrap();
    let [plain_months, catalogue] = history(folder.path());
    let mut store = Store::open(folder.path()).unwrap();
    for month in plan_months(folder.path(), 1, utc(START_US + 90 * DAY_US)).unwrap() {
        assert!(store.ready_month(month.key).unwrap());
        let packed = PackedMonth::make(folder.path(), &month, &mut |_| true).unwrap();
        store.adopt_month(packed).unwrap().done().unwrap();
    }
    store.close().unwrap();
    let [packed_months, _] = history(folder.path());
    let each = |bytes: u64| bytes as f64 / packets as f64;
    println!("{packets} packets of {}; bytes a packet:", recording.display());
    for (what, bytes) in [
        ("Data.lsf", data),
        ("Data.lsf.gz (gzip -6)", gzip),
        ("Data.lsf.zst", packed_data),
        ("Arrivals.idx", arrivals),
        ("Arrivals.zst", packed_arrivals),
        ("history, months", plain_months),
        ("months, compressed", packed_months),
        ("history, catalogue", catalogue),
        ("all, compressed", packed_data + packed_arrivals + packed_months + catalogue),
    ] {
        println!(
            "{what:<22} {bytes:>9} bytes, {:>6.2} a packet, {:>5.2} of the gzip",
            each(bytes),
            bytes as f64 / gzip as f64
        );
    }
    assert!(packed_data <= gzip, "{packed_data} bytes, by gzip {gzip}");
    assert!(each(packed_arrivals) < 4.0, "{} bytes a packet", each(packed_arrivals));
    assert!(each(packed_months) < 30.0, "{} bytes a packet", each(packed_months));
}
