use super::*;
use crate::history::explore::{Explorer, FoundRanks};
use crate::history::export;
use imc::messages::TBRFishTag;
use imc::{Address, Header, Packet};
use research::{Narrowed, Question};
use store::{Accepted, Reader, Store, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_S: u32 = 1_795_248_000;
const BOAT: u16 = 0x0814;
/// Number of detections of the previous day, and of the requested range.
const BEFORE: u32 = 1_500;
const WITHIN: u32 = 3_000;

/// One detection a second: those of the day before, then rows that are long, and rows without a place, which are short.
fn fill(data: &Path) {
    let mut store = Store::open(data).unwrap();
    for at in 0..BEFORE + WITHIN {
        let is_long = at < BEFORE + WITHIN / 3 || at % 10 == 0;
        let seconds = START_S - BEFORE + at;
        let tag = TBRFishTag {
            serial_no: if is_long { 1_000_024 } else { 7 },
            unix_timestamp: seconds,
            trans_protocol: 6_u8.into(),
            // One of 500 is rare.
            trans_id: if at % 500 == 9 { 9 } else { 100 + at.wrapping_mul(2_654_435_761) % 30 },
            lat: is_long.then_some(1.1 + f64::from(at % 1_000) * 1e-7),
            lon: is_long.then_some(0.2),
            ..TBRFishTag::default()
        };
        let received = UtcTime::from_micros(i64::from(seconds) * 1_000_000);
        let header = Header {
            timestamp: received.seconds(),
            src: Address(BOAT),
            src_ent: 2,
            dst: Address(0xFFFF),
            dst_ent: 255,
        };
        let packet = Packet::new(header, tag).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    }
    store.close().unwrap();
}

/// The estimated size of a file, from at most so many detections, and the actual size.
fn sizes(
    data: &Path,
    (from_s, to_s): (u32, u32),
    tags: &str,
    format: &str,
    most: u64,
) -> (ExportSize, ExportSize) {
    let us = |seconds: u32| i64::from(seconds) * 1_000_000;
    let range = TimeRange { from_us: us(from_s), to_us: us(to_s) };
    let tags = export::tags(Some(tags)).unwrap();
    let question = Question {
        vessels: [BOAT].into(),
        from_us: range.from_us,
        to_us: range.to_us,
        tags: tags.clone(),
        narrowed: Narrowed::default(),
        whole_axis: false,
    };
    let (explorer, study) = (Explorer::new(data), Study::default());
    let prepared =
        explorer.prepare(&mut Reader::open(data).unwrap(), question, Duration::from_mins(1)).unwrap();
    let FoundRanks::Whole(ranks) = explorer.ranks(&prepared, &study, PARTS) else { panic!("it is not read") };
    let wanted = DetectionsWanted { systems: Some(vec![Address(BOAT)]), range, came_from: None, tags };
    let (names, file) = (BTreeMap::new(), HeardFile::new(Some(format), None).unwrap());
    let measured = Measured { wanted: &wanted, names: &names, study: &study, file: &file };
    let told = measured.size_by(data, &ranks, most).unwrap().unwrap();
    let mut bytes = Vec::new();
    let written = heard::write(data, &wanted, &names, &study, &file, &mut bytes).unwrap();
    assert_eq!(written.bytes, bytes.len() as u64);
    (told, ExportSize { rows: written.rows, bytes: written.bytes, estimated: false })
}

#[test]
fn a_short_file_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    for (tags, format) in [
        ("", "lutra"),
        ("9", "lutra"),
        ("", "vue"),
        ("99999", "vue"),
        ("", "actel-biometrics"),
        ("", "netcdf"),
        ("", "dwca"),
    ] {
        let (told, file) = sizes(folder.path(), (START_S, START_S + 100), tags, format, 50_000);
        assert_eq!(told, file, "{tags} {format}");
    }
}

/// A tag that was not heard, among more detections than are sampled: the header alone.
#[test]
fn a_file_without_detections_is_its_header_however_many_others_lie_between() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    for format in ["lutra", "vue", "fathom", "glatos", "thelma", "actel-biometrics", "netcdf", "dwca"] {
        let (told, file) = sizes(folder.path(), (START_S, START_S + WITHIN), "99999", format, 100);
        assert_eq!(told, file, "{format}");
    }
}

#[test]
fn the_size_of_a_long_file_of_uneven_rows_is_told_within_a_tenth() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    // With more detections on the previous day than are sampled, and for a rare tag.
    for (tags, format) in
        [("", "lutra"), ("9", "lutra"), ("100,101,102", "glatos"), ("", "vue"), ("", "thelma")]
    {
        let (told, file) = sizes(folder.path(), (START_S, START_S + WITHIN), tags, format, 1_000);
        assert!(told.estimated, "{tags} {format}");
        let far = |told: u64, file: u64| told.abs_diff(file) * 10 > file;
        assert!(
            !far(told.rows, file.rows) && !far(told.bytes, file.bytes),
            "{tags} {format}: {told:?} of {file:?}"
        );
    }
}

/// Its tracks are not counted: it is never said to be exact.
#[test]
fn the_size_of_a_geopackage_is_an_estimate_however_short_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    for (tags, within_s) in [("", 100), ("99999", 100), ("", WITHIN)] {
        let range = (START_S, START_S + within_s);
        let (told, file) = sizes(folder.path(), range, tags, "geopackage", 2_000);
        assert!(told.estimated, "{tags} {within_s}");
        // Databases grow by whole pages, and of a short file the tracks are a third.
        let far = |told: u64, file: u64| told.abs_diff(file) * 2 > file;
        assert!(!far(told.rows, file.rows) && !far(told.bytes, file.bytes), "{told:?} of {file:?}");
    }
}

/// What its header says of all rows is written for each part that is looked at.
#[test]
fn the_size_of_a_long_netcdf_file_is_about_right() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let (told, file) = sizes(folder.path(), (START_S, START_S + WITHIN), "", "netcdf", 2_000);
    assert!(told.estimated);
    let far = |told: u64, file: u64| told.abs_diff(file) * 5 > file;
    assert!(!far(told.rows, file.rows) && !far(told.bytes, file.bytes), "{told:?} of {file:?}");
}

/// A header as long as ten rows is there once, however many rows there are.
#[test]
fn the_header_is_counted_once() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let of = |to_s: u32| sizes(folder.path(), (START_S - BEFORE, to_s), "", "lutra", 250);
    let (told, file) = of(START_S - BEFORE + 300);
    assert!(told.estimated);
    assert!(told.bytes.abs_diff(file.bytes) * 10 <= file.bytes, "{told:?} of {file:?}");
}
