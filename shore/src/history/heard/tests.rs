use super::spool::Bounded;
use super::*;
use imc::messages::{EstimatedState, TBRFishTag};
use imc::{Address, Header, Message, Packet};
use research::{FORMATS, Limits};
use rusqlite::Connection;
use std::process::Command;
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_S: u32 = 1_795_248_000;
const BOAT: u16 = 0x0814;

/// Two detections, the second without a place; positions with a break of ten minutes between the second and the third.
fn fill(data: &Path) {
    let mut store = Store::open(data).unwrap();
    let mut put = |second: u32, message: Message| {
        let received = UtcTime::from_micros(i64::from(START_S + second) * 1_000_000);
        let header =
            Header { timestamp: received.seconds(), src: Address(BOAT), src_ent: 2, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    };
    for (second, place) in [(0, Some((63.44_f64, 10.4_f64))), (1, None)] {
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: START_S + second,
            millis: 7,
            trans_protocol: 6_u8.into(),
            trans_id: 7,
            snr: 25,
            trans_freq: 69,
            lat: place.map(|(lat, _)| lat.to_radians()),
            lon: place.map(|(_, lon)| lon.to_radians()),
            ..TBRFishTag::default()
        };
        put(second, tag.into());
    }
    let positions = [(0, 63.44_f64, 10.4_f64), (1, 63.45, 10.41), (601, 63.46, 10.4), (602, 63.47, 10.42)];
    for (second, lat_deg, lon_deg) in positions {
        let state = EstimatedState {
            lat: lat_deg.to_radians(),
            lon: lon_deg.to_radians(),
            ..EstimatedState::default()
        };
        put(second, state.into());
    }
    store.close().unwrap();
}

fn written(data: &Path, file: &HeardFile) -> (Exported, Vec<u8>) {
    let names = BTreeMap::from([(BOAT, "Otter 1".to_owned())]);
    let mut out = Vec::new();
    let done = write(data, &asked(), &names, &Study::default(), file, &mut out).unwrap();
    (done, out)
}

fn file(name: &str) -> HeardFile {
    HeardFile::new(Some(name), None).unwrap()
}

fn number(blob: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(blob[at..at + 8].try_into().unwrap())
}

#[test]
fn a_geopackage_has_a_layer_of_detections_and_one_of_tracks() {
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    let (done, bytes) = written(data.path(), &file("geopackage"));
    assert_eq!((done.rows, done.bytes), (2, bytes.len() as u64));
    let left = std::fs::read_dir(data.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().starts_with(".tmp")), "nothing is left over");
    let path = data.path().join("found.gpkg");
    std::fs::write(&path, &bytes).unwrap();
    let found = Connection::open(&path).unwrap();
    let ask = |sql: &str| found.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!((ask("PRAGMA application_id"), ask("PRAGMA user_version")), (0x4750_4B47, 10_300));
    assert_eq!(ask("SELECT count(*) FROM pragma_integrity_check WHERE integrity_check='ok'"), 1);
    let row = "SELECT geom,tag,latitude_deg,snr_db,heard_utc,vessel FROM detections WHERE fid=1";
    let (blob, tag, lat_deg, snr_db, heard, vessel) = found
        .query_row(row, [], |row| {
            Ok((
                row.get::<_, Vec<u8>>(0)?,
                row.get::<_, String>(1)?,
                row.get::<_, f64>(2)?,
                row.get::<_, i64>(3)?,
                row.get::<_, String>(4)?,
                row.get::<_, String>(5)?,
            ))
        })
        .unwrap();
    assert_eq!((&*tag, lat_deg, snr_db, &*vessel), ("S256-7", 63.44, 25, "Otter 1"));
    assert_eq!(heard, "2026-11-21T08:00:00.007Z");
    assert_eq!((&blob[..8], &blob[8..13]), (&b"GP\0\x01\xE6\x10\0\0"[..], &[1, 1, 0, 0, 0][..]));
    assert!((number(&blob, 13) - 10.4).abs() < 1e-9 && (number(&blob, 21) - 63.44).abs() < 1e-9);
    assert_eq!(ask("SELECT count(*) FROM detections WHERE geom IS NULL AND latitude_deg IS NULL"), 1);
    assert_eq!(ask("SELECT count(*) FROM tracks WHERE positions=2"), 2, "no line over a break");
    let line: Vec<u8> = found.query_row("SELECT geom FROM tracks WHERE fid=2", [], |row| row.get(0)).unwrap();
    // Its envelope is west, east, south, north.
    assert!((number(&line, 24) - 63.46).abs() < 1e-6 && (number(&line, 32) - 63.47).abs() < 1e-6);
    assert_eq!(ask("SELECT count(*) FROM gpkg_contents WHERE min_x>10 AND max_y<64 AND srs_id=4326"), 2);
    assert_eq!(written(data.path(), &file("geopackage")).1, bytes, "the same rows give the same bytes");
}

#[test]
fn gdal_reads_both_layers() {
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    let path = data.path().join("found.gpkg");
    std::fs::write(&path, written(data.path(), &file("geopackage")).1).unwrap();
    let Ok(output) = Command::new("ogrinfo").args(["-al", "-ro"]).arg(&path).output() else {
        testkit::absent(testkit::Need::Gdal, "apt-get install gdal-bin");
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && output.stderr.is_empty(), "{said}");
    for part in
        ["Layer name: detections", "Layer name: tracks", "Geometry: Line String", "POINT (10.4", "EPSG"]
    {
        assert!(said.contains(part), "{part} in {said}");
    }
}

#[test]
fn who_gets_a_dataset_or_a_part_gets_no_tracks() {
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    let coarse = Limits::new(&[], "", Some(1_000), false).unwrap();
    for file in [
        HeardFile { is_closed: true, ..file("geopackage") },
        HeardFile { limits: coarse, ..file("geopackage") },
    ] {
        assert!(!file.messages().contains(&"EstimatedState".to_owned()));
        let path = data.path().join("found.gpkg");
        std::fs::write(&path, written(data.path(), &file).1).unwrap();
        let found = Connection::open(&path).unwrap();
        let tables = "SELECT count(*) FROM sqlite_master WHERE name='tracks'";
        assert_eq!(found.query_row(tables, [], |row| row.get::<_, i64>(0)).unwrap(), 0);
        let exact = "SELECT count(*) FROM detections WHERE abs(latitude_deg-63.44)<1e-6";
        let exact = found.query_row(exact, [], |row| row.get::<_, i64>(0)).unwrap();
        assert_eq!(exact, i64::from(file.is_closed), "a coarse place is coarse in every column");
    }
}

#[test]
fn every_format_is_written_with_its_own_ending_and_the_same_bytes_again() {
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    for format in FORMATS {
        let file = file(format.name);
        let (done, bytes) = written(data.path(), &file);
        assert_eq!(done.bytes, bytes.len() as u64, "{}", format.name);
        assert_eq!(written(data.path(), &file).1, bytes, "{}", format.name);
        let begins = if format.name == "lutra" { "heard_utc" } else { format.header };
        assert!(bytes.starts_with(begins.as_bytes()), "{}", format.name);
    }
    let names: Vec<String> = ["lutra", "vue", "dwca", "netcdf"].map(|name| file(name).name()).into();
    assert_eq!(names, ["detections.csv", "detections-vue.csv", "detections-dwca.zip", "detections.nc"]);
}

fn asked() -> DetectionsWanted {
    let systems = Some(vec![Address(BOAT)]);
    let range = TimeRange { from_us: 0, to_us: i64::from(START_S + 10_000) * 1_000_000 };
    DetectionsWanted { systems, range, came_from: None, tags: Vec::new() }
}

#[test]
fn a_refusal_for_want_of_room_says_what_to_do_over_http_too() {
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    for (name, most_waiting_bytes) in [("netcdf", 100), ("geopackage", 20_000)] {
        let file = HeardFile { most_waiting_bytes, ..file(name) };
        let (names, study, mut out) = (BTreeMap::new(), Study::default(), Vec::new());
        let failed = write(data.path(), &asked(), &names, &study, &file, &mut out).unwrap_err();
        let shown = crate::Error::from(failed);
        assert_eq!(shown.kind, crate::ErrorKind::Refused, "{name}: {shown}");
        assert!(shown.text.contains("ask for a shorter time"), "{name}: {shown}");
        assert!(out.is_empty(), "{name}: nothing goes out before");
    }
    // What the system says has its place in the log alone.
    let source = std::io::Error::from(std::io::ErrorKind::StorageFull);
    let of_system = StoreError::Io { path: data.path().into(), source };
    assert_eq!(crate::Error::from(of_system).kind, crate::ErrorKind::Internal);
}

/// What is not read any more after it was flushed so often: it takes bytes, and says so when it is flushed again.
struct Unread {
    bytes: usize,
    flushed: usize,
    until: usize,
}

impl Unread {
    fn after(until: usize) -> Self {
        Self { bytes: 0, flushed: 0, until }
    }
}

impl std::io::Write for Unread {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.flushed += 1;
        if self.flushed > self.until { Err(std::io::ErrorKind::BrokenPipe.into()) } else { Ok(()) }
    }
}

#[test]
fn the_tracks_of_a_file_end_early_where_it_is_not_read_any_more() {
    let data = tempfile::tempdir().unwrap();
    let mut store = Store::open(data.path()).unwrap();
    // In November, December and January.
    for month in 0..3 {
        let received = UtcTime::from_micros(i64::from(START_S + month * 30 * 86_400) * 1_000_000);
        let header =
            Header { timestamp: received.seconds(), src: Address(BOAT), src_ent: 2, ..Header::default() };
        let packet = Packet::new(header, EstimatedState::default()).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    }
    store.close().unwrap();
    let read = |until: usize| {
        let (names, study, mut unread) = (BTreeMap::new(), Study::default(), Unread::after(until));
        let wanted = DetectionsWanted { range: TimeRange::ALL, ..asked() };
        let done = write(data.path(), &wanted, &names, &study, &file("geopackage"), &mut unread).map(drop);
        (done, unread)
    };
    let (whole, asked) = read(usize::MAX);
    whole.unwrap();
    assert_eq!(asked.flushed, 7, "each month for latitudes and longitudes, and the end");
    for until in 0..6 {
        let (failed, unread) = read(until);
        assert!(matches!(failed, Err(StoreError::Io { .. })), "{until}");
        assert_eq!((unread.bytes, unread.flushed), (0, until + 1), "it is not made to its end");
    }
}

#[test]
fn a_file_that_is_made_at_its_end_ends_early_where_it_is_not_read_any_more() {
    let data = tempfile::tempdir().unwrap();
    let mut store = Store::open(data.path()).unwrap();
    for second in 0..1_100 {
        let received = UtcTime::from_micros(i64::from(START_S + second) * 1_000_000);
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: START_S + second,
            trans_protocol: 6_u8.into(),
            trans_id: 7,
            lat: Some(1.1),
            lon: Some(0.2),
            ..TBRFishTag::default()
        };
        let header =
            Header { timestamp: received.seconds(), src: Address(BOAT), src_ent: 2, ..Header::default() };
        let packet = Packet::new(header, tag).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    }
    store.close().unwrap();
    for name in ["netcdf", "geopackage"] {
        let (names, study, mut unread) = (BTreeMap::new(), Study::default(), Unread::after(0));
        let failed = write(data.path(), &asked(), &names, &study, &file(name), &mut unread).unwrap_err();
        assert!(matches!(failed, StoreError::Io { .. }), "{name}: {failed}");
        assert_eq!(unread.bytes, 0, "{name} is not made to its end");
    }
}

#[test]
fn a_file_that_is_larger_than_may_wait_is_refused_with_what_to_do() {
    let data = tempfile::tempdir().unwrap();
    let mut writer = research::Writer::new(research::format("netcdf").unwrap(), tables::Dialect::Plain)
        .with_spool(Box::new(Bounded::new(data.path(), 100_000).unwrap()));
    writer.header(&mut Vec::new()).unwrap();
    let place = units::LatLon::from_deg(63.44, 10.4).unwrap();
    let one = detections::Detection {
        origin: detections::Origin {
            system: Address(BOAT),
            entity: 2,
            reported: UtcTime::from_micros(i64::from(START_S) * 1_000_000),
            received: None,
        },
        receiver: 1,
        maker: None,
        clock: detections::ReceiverClock::read(START_S, 0),
        protocol: detections::Protocol::named("S256"),
        tag_id: 7,
        data: None,
        snr_db: Some(20),
        frequency_khz: Some(69),
        line: 0,
        pose: Some(detections::Pose { place, age_s: None, sigma_m: None }),
        effort: detections::Effort::default(),
        raw: None,
    };
    let study = Study::default();
    let heard = study.heard(&one, "otter", research::Lag::Unknown);
    let failed = (0..10_000).find_map(|_| writer.row(&mut Vec::new(), &heard).err()).unwrap();
    assert!(failed.to_string().contains("ask for a shorter time"), "{failed}");
}
