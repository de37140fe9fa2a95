//! Months of the history that were compressed: they answer as before, whatever still comes for them.

use crate::support::{OTTER, START_US, accept, packet, packet_of, state, temperature, utc};
use imc::messages::{LogBookEntry, TBRFishTag, Temperature};
use imc::{Address, Header};
use proptest::prelude::*;
use std::fs;
use std::num::NonZeroI64;
use std::path::{Path, PathBuf};
use store::{
    Adopted, CompressedMonth, CsvOptions, MonthKey, Order, PackableMonth, PackedMonth, Page, Reader,
    Readiness, Selection, Shape, Source, Store, TimeRange, Transport, doctor, export_csv, measure_csv,
    plan_months,
};

const DAY_US: i64 = 86_400_000_000;
const SECOND_US: i64 = 1_000_000;

/// Compresses every month that is due.
fn compress(store: &mut Store) -> Vec<CompressedMonth> {
    let folder = store.folder().to_owned();
    let months = plan_months(&folder, 0, utc(START_US + 90 * DAY_US)).unwrap();
    let one = |month: PackableMonth| {
        assert!(store.ready_month(month.key).unwrap());
        let packed = PackedMonth::make(&folder, &month, &mut |_| true).unwrap();
        store.adopt_month(packed).unwrap().done().unwrap()
    };
    months.into_iter().map(one).collect()
}

fn november(folder: &Path) -> PathBuf {
    folder.join("history/2026-11.sqlite")
}

fn version(file: &Path) -> i64 {
    let connection = rusqlite::Connection::open(file).unwrap();
    connection.query_row("PRAGMA user_version", (), |row| row.get(0)).unwrap()
}

fn form(file: &Path) -> String {
    let connection = rusqlite::Connection::open(file).unwrap();
    connection.query_row("PRAGMA journal_mode", (), |row| row.get(0)).unwrap()
}

/// The thermometer of [`temperature`].
fn source() -> Source {
    Source { system: OTTER, entity: 5, message: "Temperature".to_owned() }
}

fn sql(file: &Path, text: &str) {
    rusqlite::Connection::open(file).unwrap().execute_batch(text).unwrap();
}

/// Everything that can be asked, as text.
fn answers(folder: &Path) -> Vec<String> {
    let mut told = Vec::new();
    let all = Selection::default();
    for (shape, received, every_us) in [
        (Shape::Wide, true, None),
        (Shape::Long, false, None),
        (Shape::Wide, false, NonZeroI64::new(7 * SECOND_US)),
    ] {
        let options = CsvOptions { shape, received, every_us, ..CsvOptions::default() };
        let mut table = Vec::new();
        export_csv(folder, &all, &options, &mut table).unwrap();
        told.push(String::from_utf8(table).unwrap());
        told.push(format!("{:?}", measure_csv(folder, &all, &options).unwrap()));
    }
    let mut reader = Reader::open(folder).unwrap();
    for one in reader.series(None).unwrap() {
        told.push(format!("{one:?}"));
        let Some(message) = one.message else { continue };
        let group = one.group;
        let source =
            Source { system: Address(group.src), entity: group.src_ent, message: message.to_owned() };
        let table = reader.table_of(group).unwrap();
        let fields: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
        let numbers: Vec<&str> =
            table.columns.iter().filter(|column| column.is_number()).map(|column| column.name).collect();
        told.push(format!(
            "{:?}",
            reader.rows(&source, &fields, TimeRange::ALL, Page::first(usize::MAX)).unwrap()
        ));
        for part in [0, 3, 500, 40 * DAY_US / SECOND_US] {
            let range = TimeRange { from_us: i64::MIN, to_us: START_US + part * SECOND_US };
            told.push(format!("{:?}", reader.last_row(&source, &fields, range).unwrap()));
        }
        for field in numbers {
            for count in [3, 1_000] {
                told.push(format!("{:?}", reader.buckets(&source, field, TimeRange::ALL, count).unwrap()));
            }
        }
    }
    for order in [Order::Oldest, Order::Newest] {
        told.push(format!("{:?}", reader.log_book(None, TimeRange::ALL, order, Page::first(9)).unwrap()));
        told.push(format!(
            "{:?}",
            reader.detections(None, TimeRange::ALL, None, order, Page::first(99)).unwrap()
        ));
    }
    told.push(format!("{:?}", reader.silences(OTTER, TimeRange::ALL).unwrap()));
    told.push(format!("{:?}", reader.track(OTTER, TimeRange::ALL, 500, 0.0).unwrap()));
    told.push(format!("{}", store::table_version(&mut reader, &all).unwrap()));
    told
}

fn assert_same(one: &Path, other: &Path, when: &str) {
    for (own, new) in answers(one).iter().zip(&answers(other)) {
        let end = |text: &str| text.chars().take(2_000).collect::<String>();
        assert!(own == new, "{when}: {}\nand not {}", end(new), end(own));
    }
}

/// What vessels say in the seconds from one to another: of several kinds, some at one microsecond, some cut short.
fn said(from: i64, to: i64) -> Vec<Vec<u8>> {
    let mut packets = Vec::new();
    for second in from..to {
        let at_us = START_US + second * SECOND_US;
        packets.push(temperature(at_us, second as f32 * 0.1));
        packets.push(temperature(at_us, second as f32 + 0.5));
        packets.push(packet(at_us + 5, 7, &state(second as f32)));
        if second % 7 == 0 {
            let header =
                Header { timestamp: utc(at_us).seconds(), src: OTTER, src_ent: 9, ..Header::default() };
            // A message of an older release, a payload that does not fit its id, and an unknown id.
            let tag = packet(
                at_us,
                9,
                &TBRFishTag {
                    serial_no: 5,
                    unix_timestamp: 1_795_248_000,
                    millis: 7,
                    ..TBRFishTag::default()
                },
            );
            let view = imc::PacketView::new(&tag).unwrap();
            let payload = view.payload();
            packets.push(raw(&header, view.id(), &payload[..payload.len() - 16]));
            packets.push(raw(&header, 263, &[1]));
            packets.push(raw(&header, 65_000, &second.to_le_bytes()));
            packets.push(tag);
        }
        if second % 11 == 0 {
            let entry =
                LogBookEntry { text: format!("seen {second} «ø»").into(), ..LogBookEntry::default() };
            packets.push(packet_of(Address(0x2811), at_us, 3, &entry));
            packets.push(packet(at_us, 6, &Temperature { value: f32::INFINITY }));
            packets.push(packet(at_us + 1, 6, &Temperature { value: f32::NAN }));
        }
    }
    packets
}

/// A packet with any payload.
fn raw(header: &Header, id: u16, payload: &[u8]) -> Vec<u8> {
    let mut bytes = packet_of(header.src, utc_us(header), header.src_ent, &Temperature { value: 0.0 });
    let body = bytes.len() - 2 - 4;
    bytes.truncate(body);
    bytes[2..4].copy_from_slice(&id.to_le_bytes());
    bytes[4..6].copy_from_slice(&(payload.len() as u16).to_le_bytes());
    bytes.extend_from_slice(payload);
    let sum = imc::crc16(&bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}

fn utc_us(header: &Header) -> i64 {
    units::UtcTime::from_seconds(header.timestamp).unwrap().micros()
}

fn take(store: &mut Store, packets: &[Vec<u8>], received_us: i64) {
    for (at, packet) in packets.iter().enumerate() {
        accept(store, packet, received_us + at as i64, Transport::Tcp);
    }
    store.commit().unwrap();
    store.settle().unwrap();
}

/// A plain store and one that is compressed, with the same in both.
struct Pair {
    folders: [tempfile::TempDir; 2],
    stores: [Store; 2],
}

impl Pair {
    fn new() -> Self {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let stores = [0, 1].map(|at: usize| Store::open(folders[at].path()).unwrap());
        Self { folders, stores }
    }

    fn take(&mut self, packets: &[Vec<u8>], received_us: i64) {
        self.stores.iter_mut().for_each(|store| take(store, packets, received_us));
    }

    fn assert_same(&self, when: &str) {
        assert_same(self.folders[0].path(), self.folders[1].path(), when);
    }
}

// Takes some seconds: several chunks of each series, and every question asked of both histories after each of seven changes.
#[test]
fn a_compressed_month_answers_as_before_and_so_when_a_vessel_comes_home_late() {
    let mut pair = Pair::new();
    let all = said(0, 2_600);
    // What came first came late of some, and of some twice.
    let (live, late): (Vec<_>, Vec<_>) = all.iter().cloned().enumerate().partition(|(at, _)| at % 9 != 0);
    let of = |list: Vec<(usize, Vec<u8>)>| list.into_iter().map(|(_, packet)| packet).collect::<Vec<_>>();
    let (live, late) = (of(live), of(late));
    pair.take(&live, START_US);
    let before = fs::metadata(november(pair.folders[1].path())).unwrap().len();
    let done = compress(&mut pair.stores[1]);
    assert_eq!((done.len(), done[0].bytes), (1, before));
    assert!(done[0].packed_bytes * 3 < before, "{done:?}");
    assert_eq!(version(&november(pair.folders[1].path())), 3, "earlier programs must refuse it");
    assert_eq!(form(&november(pair.folders[1].path())), "wal", "or it could be replaced below its readers");
    assert!(compress(&mut pair.stores[1]).is_empty(), "it is compressed");
    pair.assert_same("compressed");
    // The same again: nothing is there twice.
    pair.take(&live[..3_000], START_US + DAY_US);
    pair.assert_same("the same again");
    // Earlier arrivals than were known, by another way.
    pair.take(&live[100..200], START_US - DAY_US);
    pair.assert_same("earlier arrivals");
    pair.take(&late, START_US + 20 * DAY_US);
    pair.assert_same("late packets");
    assert_eq!(compress(&mut pair.stores[1]).len(), 1);
    pair.assert_same("compressed again");
    pair.take(&said(2_600, 2_700), START_US + 21 * DAY_US);
    pair.assert_same("a later part");
    let folder = pair.folders[1].path();
    let copy = tempfile::tempdir().unwrap();
    fs::create_dir(copy.path().join("history")).unwrap();
    for file in store::backup_files(folder).unwrap() {
        if file.path.extension().is_some_and(|end| end == "sqlite") {
            store::copy_database(&folder.join(&file.path), &copy.path().join(&file.path), &mut || true)
                .unwrap();
        }
    }
    assert_same(pair.folders[0].path(), copy.path(), "a backup's copy");
    let Pair { folders, stores } = pair;
    for store in stores {
        store.close().unwrap();
    }
    let samples = store::reindex(folders[1].path(), false, &mut |_| true).unwrap();
    assert_eq!(samples.samples, samples.before);
    assert_same(folders[0].path(), folders[1].path(), "made again from the archive");
    assert_eq!(version(&november(folders[1].path())), 1);
}

#[test]
fn a_month_that_is_read_or_written_meanwhile_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &said(0, 50), START_US);
    let make = |store: &mut Store| {
        let month = plan_months(folder.path(), 0, utc(START_US + 90 * DAY_US)).unwrap()[0];
        store.ready_month(month.key).unwrap();
        PackedMonth::make(folder.path(), &month, &mut |_| true).unwrap()
    };
    let part = folder.path().join("history/packing.sqlite");
    let packed = make(&mut store);
    take(&mut store, &said(60, 61), START_US + DAY_US);
    assert!(matches!(store.adopt_month(packed).unwrap(), Adopted::Changed), "it lacks what came");
    assert!(!part.exists());
    let packed = make(&mut store);
    let mut reader = Reader::open(folder.path()).unwrap();
    let before = reader.series(None).unwrap();
    reader.samples(&source(), &["value"], TimeRange::ALL, 10).unwrap();
    let busy = |adopted: Adopted| match adopted {
        Adopted::Busy(packed) => packed,
        other => panic!("something reads it: {other:?}"),
    };
    let packed = busy(store.adopt_month(packed).unwrap());
    let packed = busy(store.adopt_month(packed).unwrap());
    assert_eq!((version(&november(folder.path())), reader.series(None).unwrap()), (1, before.clone()));
    take(&mut store, &said(61, 62), START_US + DAY_US);
    drop(reader);
    assert!(matches!(store.adopt_month(packed).unwrap(), Adopted::Changed), "it came while it waited");
    let packed = busy({
        let packed = make(&mut store);
        let mut reader = Reader::open(folder.path()).unwrap();
        reader.samples(&source(), &["value"], TimeRange::ALL, 10).unwrap();
        store.adopt_month(packed).unwrap()
    });
    let before = Reader::open(folder.path()).unwrap().series(None).unwrap();
    // It is handed back until then, and a try after that does it. One that asks only what there is does not keep it open.
    let mut reader = Reader::open(folder.path()).unwrap();
    assert_eq!(reader.series(None).unwrap(), before);
    assert!(!reader.systems().unwrap().is_empty());
    assert!(store.adopt_month(packed).unwrap().done().is_some());
    assert_eq!(reader.series(None).unwrap(), before);
    assert_eq!(version(&november(folder.path())), 3);
}

#[test]
fn what_is_not_finished_leaves_the_month_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &said(0, 50), START_US);
    let part = folder.path().join("history/packing.sqlite");
    let stopped = PackedMonth::make(
        folder.path(),
        &plan_months(folder.path(), 0, utc(START_US + 90 * DAY_US)).unwrap()[0],
        &mut |_| false,
    );
    assert!(matches!(stopped, Err(store::StoreError::Cancelled)) && !part.exists());
    assert_eq!(compress(&mut store).len(), 1);
    // The newest month, and one that ended not so long ago.
    let (_, ended) = MonthKey::of(START_US).range_us().unwrap();
    assert_eq!(plan_months(folder.path(), 5, utc(ended + 5 * DAY_US - 1)).unwrap(), []);
}

#[test]
fn a_damaged_chunk_is_named_and_all_others_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let packets: Vec<Vec<u8>> =
        (0..5_000).map(|at| temperature(START_US + at * SECOND_US, at as f32)).collect();
    take(&mut store, &packets, START_US);
    compress(&mut store);
    store.close().unwrap();
    let file = november(folder.path());
    let connection = rusqlite::Connection::open(&file).unwrap();
    let mut body: Vec<u8> =
        connection.query_row("SELECT body FROM _chunk WHERE chunk=2", (), |row| row.get(0)).unwrap();
    let middle = body.len() / 2;
    body[middle] ^= 1;
    connection.execute("UPDATE _chunk SET body=?1 WHERE chunk=2", [body]).unwrap();
    drop(connection);
    let source = Source { system: OTTER, entity: 5, message: "Temperature".to_owned() };
    let ask = |from: i64, to: i64| {
        let range = TimeRange { from_us: START_US + from * SECOND_US, to_us: START_US + to * SECOND_US };
        Reader::open(folder.path()).unwrap().samples(&source, &["value"], range, 10_000)
    };
    assert_eq!(ask(0, 1_024).unwrap().values[0].len(), 1_024);
    assert_eq!(ask(2_048, 5_000).unwrap().values[0].len(), 2_952);
    let error = ask(0, 5_000).unwrap_err().to_string();
    for part in [
        "2026-11.sqlite",
        "Temperature of 0x2810, entity 5",
        "2026-11-21T08:17:04",
        "2026-11-21T08:34:07",
        "reindex",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let checks = doctor(folder.path(), utc(START_US), true, &mut |_| true).unwrap();
    assert!(checks.iter().any(|check| check.found.contains("Temperature of 0x2810")), "{checks:?}");
    store::reindex(folder.path(), false, &mut |_| true).unwrap();
    assert_eq!(ask(0, 5_000).unwrap().values[0].len(), 5_000);
}

/// A compressed month of so many seconds, closed.
fn compressed(folder: &Path, seconds: i64) {
    let mut store = Store::open(folder).unwrap();
    let packets: Vec<Vec<u8>> =
        (0..seconds).map(|at| temperature(START_US + at * SECOND_US, at as f32)).collect();
    take(&mut store, &packets, START_US);
    compress(&mut store);
    store.close().unwrap();
}

fn samples(folder: &Path) -> u64 {
    Reader::open(folder).unwrap().series(None).unwrap().iter().map(|series| series.extent.count).sum()
}

fn told(folder: &Path, part: &str) -> bool {
    let checks = doctor(folder, utc(START_US + 60 * DAY_US), true, &mut |_| true).unwrap();
    checks.iter().any(|check| check.found.contains(part))
}

#[test]
fn what_was_in_a_damaged_chunk_comes_from_the_archive_when_a_packet_falls_into_it() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 1_500);
    sql(&november(folder.path()), "UPDATE _chunk SET body=x'00' WHERE chunk=1");
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &[temperature(START_US + 5, 3.0)], START_US + DAY_US);
    assert_eq!(store.behind(), None);
    assert_eq!(samples(folder.path()), 1_501);
    assert!(!folder.path().join("history.aside").exists(), "only the chunk is set aside");
    assert!(told(folder.path(), "1 damaged chunks were read again from the archive"));
    assert_eq!(compress(&mut store).len(), 1, "it is no month of late packets for ever");
    assert_eq!(compress(&mut store).len(), 0);
    assert_eq!(samples(folder.path()), 1_501);
}

#[test]
fn where_the_archive_is_pruned_only_the_damaged_chunk_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 5_000);
    fs::remove_dir_all(folder.path().join("archive/0x2810/20261121")).unwrap();
    // Of the ten minutes after the late packet too, which are rolled up again.
    sql(&november(folder.path()), "UPDATE _chunk SET body=x'00' WHERE chunk=2");
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &[temperature(START_US + 1_023 * SECOND_US + 5, 3.0)], START_US + DAY_US);
    assert_eq!(store.behind(), None);
    assert_eq!(samples(folder.path()), 5_000 - 1_024 + 1);
    assert!(!folder.path().join("history.aside").exists());
    assert!(told(
        folder.path(),
        "1024 samples are missing, of 1 damaged chunks that were set aside, the first Temperature of 0x2810"
    ));
    let range = TimeRange { from_us: START_US + 2_048 * SECOND_US, to_us: i64::MAX };
    let rest = Reader::open(folder.path()).unwrap().samples(&source(), &["value"], range, 10_000).unwrap();
    assert_eq!(rest.values[0].len(), 5_000 - 2_048);
}

#[test]
fn a_month_with_damaged_chunks_is_compressed_again_without_them() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 3_000);
    let mut reader = Reader::open(folder.path()).unwrap();
    let before = reader.buckets(&source(), "value", TimeRange::ALL, 3).unwrap();
    drop(reader);
    fs::remove_dir_all(folder.path().join("archive/0x2810/20261121")).unwrap();
    sql(&november(folder.path()), "UPDATE _rolled SET body=x'00'");
    let mut store = Store::open(folder.path()).unwrap();
    let late: Vec<Vec<u8>> =
        (0..1_000).map(|at| temperature(START_US + (9_000 + at) * SECOND_US, 3.0)).collect();
    take(&mut store, &late, START_US + DAY_US);
    let month = plan_months(folder.path(), 0, utc(START_US + 90 * DAY_US)).unwrap()[0];
    let mut tries = 0;
    let packed = loop {
        assert!(store.ready_month(month.key).unwrap());
        match PackedMonth::make(folder.path(), &month, &mut |_| true) {
            Ok(packed) => break packed,
            Err(error) => assert!(store.mend(&error).unwrap(), "{error}"),
        }
        while store.is_behind() {
            store.commit().unwrap();
        }
        tries += 1;
    };
    assert!(tries > 0, "the roll-ups were damaged");
    assert!(store.adopt_month(packed).unwrap().done().is_some());
    assert_eq!(samples(folder.path()), 4_000);
    let range = TimeRange { from_us: i64::MIN, to_us: START_US + 3_000 * SECOND_US };
    let after = Reader::open(folder.path()).unwrap().buckets(&source(), "value", range, 3).unwrap();
    assert_eq!(format!("{after:?}"), format!("{before:?}"));
}

#[test]
fn columns_that_changed_their_names_by_a_fault_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 100);
    let valve = "SET columns=replace(columns,'value','valve')";
    sql(&november(folder.path()), &format!("UPDATE _layout {valve}; UPDATE _layout_copy {valve}"));
    let asked = Reader::open(folder.path())
        .unwrap()
        .samples(&source(), &["value"], TimeRange::ALL, 1_000)
        .unwrap_err();
    assert!(asked.to_string().contains("its sum is wrong"), "{asked}");
    sql(&november(folder.path()), "DELETE FROM _layout; DELETE FROM _layout_copy");
    assert!(told(folder.path(), "the list of its columns is gone"));
}

#[test]
fn a_damaged_list_of_columns_makes_nothing_unreadable() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = 3_000;
    compressed(folder.path(), all);
    let assert_whole = |all: i64, when: &str| {
        let mut reader = Reader::open(folder.path()).unwrap();
        let samples = reader.samples(&source(), &["value"], TimeRange::ALL, 10_000).unwrap();
        let expected: Vec<f64> = (0..all).map(|at| at as f64).collect();
        assert_eq!(samples.values[0], expected, "{when}");
    };
    for damage in [
        "UPDATE _layout SET columns=replace(columns,'value','valve')",
        "DELETE FROM _layout",
        "UPDATE _layout_copy SET columns=''",
        "DELETE FROM _layout_copy",
    ] {
        sql(&november(folder.path()), damage);
        assert_whole(all, damage);
        assert!(!told(folder.path(), "damaged"), "{damage}");
        // Compressing the month again writes both again.
        let mut store = Store::open(folder.path()).unwrap();
        let late: Vec<Vec<u8>> =
            (all..all + 200).map(|at| temperature(START_US + at * SECOND_US, at as f32)).collect();
        take(&mut store, &late, START_US + DAY_US);
        all += 200;
        assert_eq!(compress(&mut store).len(), 1, "{damage}");
        store.close().unwrap();
        assert_whole(all, damage);
    }
}

#[test]
fn chunks_without_a_list_of_columns_are_set_aside_at_once() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 5_000);
    sql(&november(folder.path()), "DELETE FROM _layout; DELETE FROM _layout_copy");
    let mut store = Store::open(folder.path()).unwrap();
    accept(&mut store, &temperature(START_US + 5, 3.0), START_US + DAY_US, Transport::Tcp);
    store.commit().unwrap();
    let left = || -> i64 {
        let connection = rusqlite::Connection::open(november(folder.path())).unwrap();
        connection.query_row("SELECT count(*) FROM _chunk", (), |row| row.get(0)).unwrap()
    };
    assert_eq!(left(), 0, "the first that was met tells of all");
    store.settle().unwrap();
    assert_eq!((store.behind(), samples(folder.path())), (None, 5_001));
    assert!(told(folder.path(), "5 damaged chunks were read again from the archive"));
}

#[test]
fn a_log_that_is_imported_again_adds_nothing_where_a_chunk_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 3_000);
    let log = folder.path().join("vessel.lsf");
    let all: Vec<u8> = (0..3_000).flat_map(|at| temperature(START_US + at * SECOND_US, at as f32)).collect();
    fs::write(&log, [all, temperature(START_US + 5, 3.0)].concat()).unwrap();
    sql(&november(folder.path()), "UPDATE _chunk SET body=x'00' WHERE chunk IN (1, 2)");
    let mut store = Store::open(folder.path()).unwrap();
    let logs = [log];
    let imported = store.import(&logs, utc(START_US + DAY_US), &mut |_| true).unwrap();
    assert_eq!((imported.packets, imported.added, imported.problems), (3_001, 1, Vec::new()));
    assert_eq!(samples(folder.path()), 3_001);
    // Slices, as a server takes them between its commits.
    sql(&november(folder.path()), "UPDATE _chunk SET body=x'00' WHERE chunk=3");
    store.close().unwrap();
    let mut store = Store::open_at_once(folder.path()).unwrap();
    let mut import = store::LogImport::begin(&mut store, &logs[0], utc(START_US + DAY_US)).unwrap();
    let mut tries = 0;
    loop {
        match import.read_some(&mut store, 500, u64::MAX) {
            Ok(true) => {}
            Ok(false) => break,
            Err(store::StoreError::Behind(_)) => tries += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!((import.imported().packets, import.imported().added), (3_001, 0));
    assert!(tries > 0, "the chunk was met");
    store.settle().unwrap();
    assert_eq!(samples(folder.path()), 3_001);
}

#[test]
fn a_month_of_the_trial_version_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    compressed(folder.path(), 100);
    sql(&november(folder.path()), "PRAGMA user_version=2");
    let asked = Reader::open(folder.path()).unwrap().series(None).unwrap_err().to_string();
    assert!(asked.contains("trial version") && asked.contains("start the server"), "{asked}");
    let mut store = Store::open(folder.path()).unwrap();
    store.settle().unwrap();
    assert_eq!((version(&november(folder.path())), samples(folder.path())), (1, 100));
    assert!(folder.path().join("history.aside/2026-11.sqlite").exists());
}

#[test]
fn a_month_whose_file_is_another_by_then_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &said(0, 50), START_US);
    let file = november(folder.path());
    let make = |store: &mut Store| {
        let month = plan_months(folder.path(), 0, utc(START_US + 90 * DAY_US)).unwrap()[0];
        assert!(store.ready_month(month.key).unwrap());
        PackedMonth::make(folder.path(), &month, &mut |_| true).unwrap()
    };
    let packed = make(&mut store);
    let copy = folder.path().join("copy");
    fs::copy(&file, &copy).unwrap();
    fs::rename(&copy, &file).unwrap();
    assert!(matches!(store.adopt_month(packed).unwrap(), Adopted::Changed));
    let packed = make(&mut store);
    fs::rename(&file, &copy).unwrap();
    assert!(matches!(store.adopt_month(packed).unwrap(), Adopted::Changed));
    assert!(!file.exists(), "no empty month is made");
}

#[test]
fn a_month_is_made_ready_by_small_steps() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let packets: Vec<Vec<u8>> =
        (0..30_000).map(|at| temperature(START_US + at * SECOND_US, at as f32)).collect();
    take(&mut store, &packets, START_US);
    sql(
        &november(folder.path()),
        "INSERT OR IGNORE INTO _stale WITH RECURSIVE w(at) AS (SELECT first_us/600000000 FROM _group UNION ALL SELECT at+1 FROM w \
         WHERE at < (SELECT last_us/600000000 FROM _group)) SELECT id,src,src_ent,at FROM _group, w",
    );
    store.close().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let (mut steps, key) = (0, MonthKey::of(START_US));
    loop {
        match store.ready_month_some(key).unwrap() {
            Readiness::Ready => break,
            Readiness::Unfinished => steps += 1,
            Readiness::Behind => panic!("nothing is missing"),
        }
    }
    assert!(steps >= 5, "all was rolled up in {steps} steps");
}

#[test]
fn compressing_stops_wherever_it_is_asked_to() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let hours: Vec<Vec<u8>> =
        (0..9_000).map(|at| temperature(START_US + at * 10 * SECOND_US, at as f32)).collect();
    take(&mut store, &hours, START_US);
    let month = plan_months(folder.path(), 0, utc(START_US + 90 * DAY_US)).unwrap()[0];
    assert!(store.ready_month(month.key).unwrap());
    let mut looks = Vec::new();
    PackedMonth::make(folder.path(), &month, &mut |rows| {
        looks.push(rows);
        true
    })
    .unwrap();
    let first = looks.iter().position(|rows| *rows > 0).unwrap();
    let tables = looks[..first].len();
    // Four tables, the end of the roll-ups, and two looks among those.
    assert!(tables > 5, "roll-ups too are copied with looks between: {looks:?}");
    for stop_at in [0, tables - 1, first, looks.len() - 2, looks.len() - 1] {
        let mut look = 0;
        let stopped = PackedMonth::make(folder.path(), &month, &mut |_| {
            look += 1;
            look <= stop_at
        });
        assert!(matches!(stopped, Err(store::StoreError::Cancelled)), "{stop_at}");
        assert!(!folder.path().join("history/packing.sqlite").exists());
    }
}

#[test]
fn a_column_that_the_catalogue_lost_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &said(0, 50), START_US);
    store.close().unwrap();
    let sql = |text: &str| {
        let connection = rusqlite::Connection::open(november(folder.path())).unwrap();
        connection.execute_batch(text).unwrap();
    };
    sql(
        "ALTER TABLE Temperature ADD COLUMN \"lost\" TEXT; UPDATE Temperature SET lost = 'as ' || hash WHERE src_ent = 5",
    );
    // And a message.
    sql(
        "CREATE TABLE OldOne (src INTEGER, a TEXT, PRIMARY KEY (src)) WITHOUT ROWID; INSERT INTO OldOne VALUES (7, 'kept')",
    );
    let mut store = Store::open(folder.path()).unwrap();
    assert_eq!(compress(&mut store).len(), 1);
    take(&mut store, &[temperature(START_US + 5, 3.0)], START_US + DAY_US);
    assert_eq!(compress(&mut store).len(), 1, "one in so many of its rows is ordinary now");
    take(&mut store, &[temperature(START_US + 6, 3.0)], START_US + DAY_US);
    store.close().unwrap();
    let connection = rusqlite::Connection::open(november(folder.path())).unwrap();
    let count = |text: &str| connection.query_row(text, (), |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(count("SELECT count(*) FROM Temperature WHERE lost = 'as ' || hash"), 100);
    assert_eq!(count("SELECT count(*) FROM OldOne WHERE a = 'kept'"), 1);
}

#[test]
fn retention_removes_a_compressed_month() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    take(&mut store, &said(0, 50), START_US);
    compress(&mut store);
    let retention =
        store::Retention { history_before: Some(utc(START_US + 60 * DAY_US)), archive_before: None };
    assert_eq!(store.retain(&retention).unwrap().len(), 1);
    assert!(!november(folder.path()).exists());
}

proptest! {
    // Each case asks both histories every question after each step: some tenths of a second.
    #![proptest_config(ProptestConfig::with_cases(testkit::so_many(8, 200) as u32))]
    /// In whatever order packets come, and whenever months are compressed, the history is the same.
    #[test]
    fn whenever_months_are_compressed_the_history_is_the_same(
        steps in prop::collection::vec((0_i64..60, 1_i64..40, -5_i64..5, any::<bool>()), 1..6),
        wide in any::<bool>(),
    ) {
        let mut pair = Pair::new();
        for (from, seconds, day, pack) in steps {
            // Over the end of a month too.
            let shift = if wide { 86_400 * 9 + 57_600 - 30 } else { 0 };
            pair.take(&said(shift + from, shift + from + seconds), START_US + (20 + day) * DAY_US);
            if pack {
                compress(&mut pair.stores[1]);
            }
            pair.assert_same("after a step");
        }
    }
}
