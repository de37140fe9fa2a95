//! Detections that are exported as a log, as CSV or as Parquet and imported elsewhere give the same tables, to the byte. A million of
//! them as a log: `scripts/bench-detections`.

use super::*;
use imc::messages::TBRFishTag;
use imc::{Address, Header, Packet};
use proptest::prelude::*;
use store::{Accepted, Selection, Store, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const DAY_US: i64 = 86_400_000_000;
/// When all of it comes ashore, there and elsewhere.
const CAME: UtcTime = UtcTime::from_micros(START_US + 2 * DAY_US);
const BOAT: u16 = 0x0814;

/// A detection: when it was reported (µs after the start), and what the receiver and the vessel said.
#[derive(Debug, Clone)]
struct Said {
    reported_us: i64,
    tag: TBRFishTag,
}

fn said() -> impl Strategy<Value = Said> {
    let place = proptest::option::of((-1.5..1.5_f64, -3.1..3.1_f64));
    (0..DAY_US, 0..1_000_u16, 0..=u16::MAX, 0..=u8::MAX, place).prop_map(
        |(reported_us, millis, data, snr, place)| {
            let unix_timestamp = u32::try_from((START_US + reported_us) / 1_000_000).unwrap();
            let tag = TBRFishTag {
                serial_no: 1_024,
                unix_timestamp,
                millis,
                trans_protocol: 6_u8.into(),
                trans_data: data,
                snr,
                trans_freq: 69,
                lat: place.map(|(lat, _)| lat),
                lon: place.map(|(_, lon)| lon),
                ..TBRFishTag::default()
            };
            Said { reported_us, tag }
        },
    )
}

fn recorded(data: &Path, all: &[Said]) {
    let mut store = Store::open(data).unwrap();
    for Said { reported_us, tag } in all {
        let timestamp = UtcTime::from_micros(START_US + reported_us).seconds();
        let header = Header { timestamp, src: Address(BOAT), src_ent: 9, ..Header::default() };
        let packet = Packet::new(header, tag.clone()).encode().unwrap();
        let accepted = Accepted { packet: &packet, received: CAME, transport: Transport::Tcp, link: None };
        store.accept(&accepted).unwrap();
    }
    store.close().unwrap();
}

fn table(data: &Path, format: Option<&str>) -> Vec<u8> {
    let range = TimeRange { from_us: 0, to_us: START_US + 10 * DAY_US };
    let wanted =
        DetectionsWanted { systems: Some(vec![Address(BOAT)]), range, came_from: None, tags: Vec::new() };
    let (file, mut out) = (HeardFile::new(format, None).unwrap(), Vec::new());
    write(data, &wanted, &BTreeMap::new(), &Study::default(), &file, &mut out).unwrap();
    out
}

/// Times of report (µs since 1970), tags and what these measured, from a table.
fn read(csv: &[u8]) -> Vec<(i64, String, String)> {
    let text = std::str::from_utf8(csv).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let at = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let (reported, tag, value) = (at("reported_utc"), at("tag_id"), at("sensor_value [count]"));
    let mut rows: Vec<_> = lines
        .map(|row| {
            let time: UtcTime = row[reported].parse().unwrap();
            (time.micros(), row[tag].to_owned(), row[value].to_owned())
        })
        .collect();
    rows.sort();
    rows
}

/// Takes a table elsewhere, as page and command line do.
fn taken(data: &Path, table: &[u8]) -> u64 {
    let (study, log) = (Study::default(), data.with_extension("lsf"));
    let file = data.with_extension("table");
    std::fs::write(&file, table).unwrap();
    let carriers = research::Carriers { system: Some(BOAT), address: &|_| Ok(BOAT), study: &study };
    let mut out = std::io::BufWriter::new(std::fs::File::create(&log).unwrap());
    let read = packets(&file, &carriers, &mut out).unwrap();
    out.flush().unwrap();
    assert_eq!(refusal(&read), None);
    let mut store = Store::open(data).unwrap();
    let imported = store.import(&[log], CAME, &mut |_| true).unwrap();
    store.close().unwrap();
    assert_eq!(imported.problems, Vec::<String>::new());
    imported.added
}

#[test]
fn tables_taken_elsewhere_give_the_same_tables() {
    // A million takes minutes: in `make test-long`.
    let count = testkit::so_many(1_000_u32, 1_000_000);
    let all: Vec<Said> = (0..count)
        .map(|number| {
            // Primes, so that times differ to the microsecond and values go through all that they can be.
            let reported_us = i64::from(number) * 86_243 % DAY_US;
            let tag = TBRFishTag {
                serial_no: 1_024 + number % 3,
                unix_timestamp: u32::try_from((START_US + reported_us) / 1_000_000).unwrap(),
                millis: u16::try_from(number * 7 % 1_000).unwrap(),
                trans_protocol: 6_u8.into(),
                trans_id: number,
                trans_data: u16::try_from(number * 31 % 65_536).unwrap(),
                snr: u8::try_from(number % 256).unwrap(),
                trans_freq: 69,
                lat: Some(1.1 + f64::from(number) * 1e-9),
                lon: Some(-0.2 - f64::from(number) * 1e-9),
                ..TBRFishTag::default()
            };
            Said { reported_us, tag }
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path().join("here");
    recorded(&here, &all);
    let (csv, parquet) = (table(&here, None), table(&here, Some("parquet")));
    for (name, taken_table) in [("csv", &csv), ("parquet", &parquet)] {
        let elsewhere = folder.path().join(name);
        assert_eq!(taken(&elsewhere, taken_table), u64::from(count));
        assert!(csv == table(&elsewhere, None), "CSV of {name} differs");
        assert!(parquet == table(&elsewhere, Some("parquet")), "Parquet of {name} differs");
        assert_eq!(taken(&elsewhere, taken_table), 0, "once, however often it comes");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]
    #[test]
    fn detections_come_back_as_they_were(mut all in prop::collection::vec(said(), 1..60)) {
        for (tag, number) in all.iter_mut().zip(1..) {
            tag.tag.trans_id = number;
        }
        let folder = tempfile::tempdir().unwrap();
        let (here, elsewhere) = (folder.path().join("here"), folder.path().join("elsewhere"));
        recorded(&here, &all);
        let log = folder.path().join("Data.lsf");
        let mut file = std::fs::File::create(&log).unwrap();
        store::export_lsf(&here, &Selection::default(), &mut file).unwrap();
        let mut store = Store::open(&elsewhere).unwrap();
        let imported = store.import(&[log], CAME, &mut |_| true).unwrap();
        store.close().unwrap();
        prop_assert_eq!((imported.added, imported.problems), (all.len() as u64, Vec::new()));

        let csv = table(&here, None);
        let mut expected: Vec<_> = all
            .iter()
            .map(|one| (START_US + one.reported_us, one.tag.trans_id.to_string(), one.tag.trans_data.to_string()))
            .collect();
        expected.sort();
        prop_assert_eq!(read(&csv), expected);
        prop_assert!(csv == table(&elsewhere, None), "CSV differs");
        prop_assert!(table(&here, Some("parquet")) == table(&elsewhere, Some("parquet")), "Parquet differs");
    }
}
