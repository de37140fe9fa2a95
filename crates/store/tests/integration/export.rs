//! Tables and logs out of a store.

use crate::support::{OTTER, START_US, accept, archived, packet, packet_of, temperature, utc};
use imc::Address;
use imc::messages::{
    EntityList, EntityListOp, EstimatedState, EulerAngles, LogBookEntry, TBRFishTag, Temperature,
};
use std::io::{self, Write};
use std::num::NonZeroI64;
use std::path::Path;
use store::{
    Angles, CsvOptions, Selection, Shape, Store, TimeRange, Transport, describe_csv, export_csv, export_lsf,
};

const OTHER: Address = Address(0x2811);

fn second(at: i64) -> i64 {
    START_US + at * 1_000_000
}

/// Two systems, three messages, an entity with a nasty label and a log book with worse.
fn small() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let list = EntityList { op: EntityListOp::Report, list: "=cmd()=5;AHRS=6".into() };
    let angles = EulerAngles { psi: std::f64::consts::PI, phi: f64::NAN, ..EulerAngles::default() };
    let entry = LogBookEntry { text: "=HYPERLINK(\"http://x\"),\nbye".into(), ..LogBookEntry::default() };
    let packets = [
        packet(second(0), 0, &list),
        temperature(second(3), 8.1),
        packet(second(2), 6, &angles),
        temperature(second(1), -7.25),
        packet(second(4), 0, &entry),
        packet_of(OTHER, second(2), 5, &Temperature { value: 1.5 }),
    ];
    for packet in &packets {
        accept(&mut store, packet, second(10), Transport::Tcp);
    }
    store.close().unwrap();
    folder
}

fn csv(folder: &Path, selection: &Selection, options: CsvOptions) -> String {
    let mut out = Vec::new();
    let exported = export_csv(folder, selection, &options, &mut out).unwrap();
    assert_eq!(exported.bytes, out.len() as u64);
    String::from_utf8(out).unwrap()
}

fn messages(names: &[&str]) -> Selection {
    Selection { messages: names.iter().map(|name| (*name).to_owned()).collect(), ..Selection::default() }
}

#[test]
fn a_wide_table_has_a_row_for_each_message_in_order_of_time() {
    let folder = small();
    assert_eq!(
        csv(folder.path(), &messages(&["Temperature"]), CsvOptions::default()),
        "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,value [°C]\n\
         2026-11-21T08:00:01.000000Z,1795248001.000000,ntnu-otter-01,0x2810,'=cmd(),5,0xffff,255,-7.25\n\
         2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-02,0x2811,,5,0xffff,255,1.5\n\
         2026-11-21T08:00:03.000000Z,1795248003.000000,ntnu-otter-01,0x2810,'=cmd(),5,0xffff,255,8.1\n"
    );
}

#[test]
fn several_messages_share_a_wide_table() {
    let folder = small();
    let mut selection = messages(&["EulerAngles", "Temperature"]);
    selection.fields = vec!["psi".to_owned(), "phi".to_owned(), "Temperature.value".to_owned()];
    selection.systems = vec![OTTER];
    let options = CsvOptions { angles: Angles::Degrees, ..CsvOptions::default() };
    assert_eq!(
        csv(folder.path(), &selection, options),
        "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,message,EulerAngles.phi [deg],EulerAngles.psi [deg],\
         Temperature.value [°C]\n\
         2026-11-21T08:00:01.000000Z,1795248001.000000,ntnu-otter-01,0x2810,'=cmd(),5,0xffff,255,Temperature,,,-7.25\n\
         2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-01,0x2810,AHRS,6,0xffff,255,EulerAngles,NaN,180.0,\n\
         2026-11-21T08:00:03.000000Z,1795248003.000000,ntnu-otter-01,0x2810,'=cmd(),5,0xffff,255,Temperature,,,8.1\n"
    );
    let described =
        describe_csv(&mut store::Reader::open(folder.path()).unwrap(), &selection, &options).unwrap();
    let units: Vec<&str> = described["columns"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|column| column["unit"].as_str())
        .collect();
    assert_eq!(units, ["s", "deg", "deg", "°C"]);
}

#[test]
fn a_long_table_has_a_row_for_each_value() {
    let folder = small();
    let mut selection = messages(&["EulerAngles"]);
    selection.entities = vec!["AHRS".to_owned()];
    let options = CsvOptions { shape: Shape::Long, ..CsvOptions::default() };
    let table = csv(folder.path(), &selection, options);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,message,field,value,unit"
    );
    let psi = "2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-01,0x2810,AHRS,6,0xffff,255,EulerAngles,psi,\
               3.141592653589793,rad";
    assert!(lines.contains(&psi), "{table}");
    assert!(table.contains(",phi,NaN,rad\n"), "{table}");
}

/// `EulerAngles` has a field `time`, `FollowSystem` a field `system`.
#[test]
fn every_column_has_a_name_of_its_own_and_is_described_in_its_place() {
    let folder = small();
    for (named, shape) in [
        (&["EulerAngles"] as &[&str], Shape::Wide),
        (&["EulerAngles", "Temperature"], Shape::Wide),
        (&["EulerAngles"], Shape::Long),
        (&["FollowSystem"], Shape::Wide),
    ] {
        let selection = messages(named);
        let options = CsvOptions { units: false, shape, ..CsvOptions::default() };
        let table = csv(folder.path(), &selection, options);
        let columns: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let unlike: std::collections::BTreeSet<_> = columns.iter().collect();
        assert_eq!(unlike.len(), columns.len(), "{columns:?}");
        let mut reader = store::Reader::open(folder.path()).unwrap();
        let described = describe_csv(&mut reader, &selection, &options).unwrap();
        let described = described["columns"].as_array().unwrap().iter();
        let described: Vec<&str> = described.filter_map(|column| column["name"].as_str()).collect();
        assert_eq!(columns, described);
    }
}

#[test]
fn a_row_tells_when_its_message_came_where_that_is_wanted() {
    let folder = small();
    let mut selection = messages(&["Temperature"]);
    selection.systems = vec![OTHER];
    let options = CsvOptions { received: true, ..CsvOptions::default() };
    assert_eq!(
        csv(folder.path(), &selection, options),
        "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,received,received_unix_s,value [°C]\n\
         2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-02,0x2811,,5,0xffff,255,\
         2026-11-21T08:00:10.000000Z,1795248010.000000,1.5\n"
    );
    let long = csv(folder.path(), &selection, CsvOptions { shape: Shape::Long, ..options });
    assert!(
        long.ends_with(
            ",5,0xffff,255,2026-11-21T08:00:10.000000Z,1795248010.000000,Temperature,value,1.5,°C\n"
        ),
        "{long}"
    );
    let mut reader = store::Reader::open(folder.path()).unwrap();
    let described = describe_csv(&mut reader, &selection, &options).unwrap();
    assert_eq!(described["columns"][8]["name"], "received");
    assert_eq!(described["columns"].as_array().unwrap().len(), 11);
}

#[test]
fn what_the_catalogue_does_not_explain_comes_out_as_it_came() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let unknown = |src, at: i64, payload: &[u8]| {
        let header =
            imc::Header { timestamp: utc(second(at)).seconds(), src, src_ent: 5, ..imc::Header::default() };
        let body = imc::Body::Unknown { id: 60_001, payload: payload.to_vec() };
        imc::Packet { body, ..imc::Packet::new(header, Temperature::default()) }.encode().unwrap()
    };
    let said = [
        unknown(OTHER, 7, &[0xFF]),
        temperature(second(4), 8.5),
        unknown(OTTER, 5, &[1, 2, 0xAB]),
        unknown(OTTER, 5, &[]),
    ];
    for packet in &said {
        accept(&mut store, packet, second(10), Transport::Tcp);
    }
    store.close().unwrap();
    let table = csv(folder.path(), &messages(&["_raw"]), CsvOptions::default());
    let mut lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "time,unix_s,system,system_id,entity,entity_id,dst,dst_ent,id,payload,problem");
    // Messages of one microsecond are ordered by their fingerprint.
    lines[1..3].sort_unstable();
    let why = "the catalogue has no message with this id";
    let row = |at: i64, name: &str, payload: &str| {
        format!(
            "2026-11-21T08:00:0{at}.000000Z,{}.000000,{name},,5,0xffff,255,60001,{payload},{why}",
            second(at) / 1_000_000
        )
    };
    assert_eq!(
        lines[1..],
        [
            row(5, "ntnu-otter-01,0x2810", ""),
            row(5, "ntnu-otter-01,0x2810", "0102ab"),
            row(7, "ntnu-otter-02,0x2811", "ff")
        ]
    );
    let mut selection = Selection { systems: vec![OTHER], ..messages(&["_raw"]) };
    selection.range = TimeRange { from_us: second(6), to_us: second(9) };
    let options = CsvOptions { received: true, ..CsvOptions::default() };
    let table = csv(folder.path(), &selection, options);
    assert!(
        table.lines().count() == 2
            && table.contains(",2026-11-21T08:00:10.000000Z,1795248010.000000,60001,ff,")
    );
    let mut reader = store::Reader::open(folder.path()).unwrap();
    let described = describe_csv(&mut reader, &selection, &options).unwrap();
    assert_eq!(
        described["columns"].as_array().unwrap().len(),
        table.lines().next().unwrap().split(',').count()
    );

    let with_more =
        [messages(&["_raw", "Temperature"]), Selection { fields: vec!["id".into()], ..messages(&["_raw"]) }];
    for selection in with_more {
        let error = export_csv(folder.path(), &selection, &options, &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("ask for it alone"), "{error}");
    }
    let long = CsvOptions { shape: Shape::Long, ..options };
    let error = export_csv(folder.path(), &selection, &long, &mut Vec::new()).unwrap_err();
    assert!(error.to_string().contains("wide table"), "{error}");
}

#[test]
fn formulas_are_harmless_unless_wanted() {
    let folder = small();
    let mut selection = messages(&["LogBookEntry"]);
    selection.fields = vec!["text".to_owned(), "type".to_owned()];
    let options = CsvOptions { labels: true, ..CsvOptions::default() };
    let guarded = csv(folder.path(), &selection, options);
    assert!(guarded.ends_with(",INFO,\"'=HYPERLINK(\"\"http://x\"\"),\nbye\"\n"), "{guarded}");
    let plain = csv(folder.path(), &selection, CsvOptions { guard: false, ..CsvOptions::default() });
    assert!(plain.ends_with(",0,\"=HYPERLINK(\"\"http://x\"\"),\nbye\"\n"), "{plain}");
}

#[test]
fn what_does_not_exist_is_refused_before_anything_is_written() {
    let folder = small();
    let fields = Selection { fields: vec!["no_such".to_owned()], ..messages(&["Temperature"]) };
    for (selection, problem) in [(messages(&["Temprature"]), "Temprature"), (fields, "no_such")] {
        let mut out = Vec::new();
        let error = export_csv(folder.path(), &selection, &CsvOptions::default(), &mut out).unwrap_err();
        assert!(error.to_string().contains(problem), "{error}");
        assert!(out.is_empty());
    }
}

/// Takes so many bytes, refuses once and then takes what comes.
struct Cut {
    taken: Vec<u8>,
    room: usize,
    refused: bool,
}

impl Write for Cut {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.taken.len() + bytes.len() > self.room && !self.refused {
            self.refused = true;
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.taken.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_table_that_is_cut_says_so() {
    let folder = small();
    let mut out = Cut { taken: Vec::new(), room: 100, refused: false };
    let error = export_csv(folder.path(), &messages(&["Temperature"]), &CsvOptions::default(), &mut out);
    assert!(error.unwrap_err().is_disk_full());
    let text = String::from_utf8(out.taken).unwrap();
    assert!(text.lines().last().unwrap().starts_with("#ERROR the export is cut here"), "{text}");
}

#[test]
fn many_series_come_in_order_of_time_whole() {
    // Enough for many slices, at very different rates.
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let mut expected = 0;
    for at in 0..20_000_i64 {
        accept(
            &mut store,
            &packet(START_US + at * 50_000, 1, &Temperature { value: at as f32 }),
            START_US,
            Transport::Tcp,
        );
        expected += 1;
        if at % 100 == 0 {
            // A burst of one microsecond, from many entities.
            for entity in 10..40 {
                let other = packet_of(OTHER, START_US + at * 50_000, entity, &EulerAngles::default());
                accept(&mut store, &other, START_US, Transport::Tcp);
                expected += 1;
            }
        }
    }
    store.close().unwrap();
    let table = csv(folder.path(), &Selection::default(), CsvOptions::default());
    let times: Vec<&str> = table.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(times.len(), expected);
    assert!(times.is_sorted());
    assert!(table.len() > 2_000_000, "{} bytes are more than one slice", table.len());
    let half = Selection {
        range: TimeRange::new(Some(utc(second(500))), Some(utc(second(750)))),
        ..messages(&["Temperature"])
    };
    assert_eq!(csv(folder.path(), &half, CsvOptions::default()).lines().count(), 1 + 5_000);
}

#[test]
fn a_log_comes_out_byte_for_byte() {
    let folder = small();
    let mut out = Vec::new();
    let otter = Selection { systems: vec![OTTER], ..Selection::default() };
    let exported = export_lsf(folder.path(), &otter, &mut out).unwrap();
    assert_eq!((exported.rows, exported.bytes), (5, out.len() as u64));
    assert_eq!(out, archived(folder.path(), OTTER));
    let mut out = Vec::new();
    let some = Selection {
        entities: vec!["5".to_owned()],
        range: TimeRange::new(Some(utc(second(2))), None),
        ..messages(&["Temperature"])
    };
    export_lsf(folder.path(), &some, &mut out).unwrap();
    assert_eq!(
        out,
        [temperature(second(3), 8.1), packet_of(OTHER, second(2), 5, &Temperature { value: 1.5 })].concat()
    );
}

/// One state each half second for five seconds; `lat` and `lon` stay those of the reference point.
fn sailing() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..10 {
        let time_us = START_US + at * 500_000 + 20_000;
        let state = EstimatedState { lat: 1.1, lon: 0.18, x: at as f32 * 100.0, ..EstimatedState::default() };
        accept(&mut store, &packet(time_us, 5, &state), time_us, Transport::Tcp);
        accept(&mut store, &temperature(time_us, 8.0), time_us, Transport::Tcp);
    }
    let tag = |unix_timestamp, millis| TBRFishTag { unix_timestamp, millis, ..TBRFishTag::default() };
    for (at, tag) in [(20, tag(1_795_248_000, 7)), (21, tag(77, 0)), (22, tag(1_795_248_000, 26_742))] {
        accept(&mut store, &packet(second(at), 9, &tag), second(at), Transport::Tcp);
    }
    store.close().unwrap();
    folder
}

#[test]
fn the_place_of_a_vessel_stands_before_its_reference_point() {
    let folder = sailing();
    let table = csv(folder.path(), &messages(&["EstimatedState"]), CsvOptions::default());
    let mut lines = table.lines();
    let header = lines.next().unwrap();
    assert!(
        header.contains(",entity_id,dst,dst_ent,true_lat_deg [deg],true_lon_deg [deg],lat [rad],lon [rad],"),
        "{header}"
    );
    let place = |line: &str| line.split(',').skip(8).take(4).map(str::to_owned).collect::<Vec<_>>();
    let (first, last) = (place(lines.next().unwrap()), place(lines.last().unwrap()));
    assert_eq!(first[2..], last[2..], "the reference point stays");
    let moved: f64 = last[0].parse::<f64>().unwrap() - first[0].parse::<f64>().unwrap();
    assert!((moved - 900.0 / 111_500.0).abs() < 1e-4, "{moved}");
    let mut reader = store::Reader::open(folder.path()).unwrap();
    let described =
        describe_csv(&mut reader, &messages(&["EstimatedState"]), &CsvOptions::default()).unwrap();
    let columns = described["columns"].as_array().unwrap();
    let meaning = |name: &str| columns.iter().find(|one| one["name"] == name).unwrap()["description"].clone();
    assert!(meaning("lat").as_str().unwrap().contains("reference point"));
    assert!(meaning("true_lat_deg").as_str().unwrap().contains("of the vessel"));
}

#[test]
fn the_time_of_a_tag_is_the_receivers_own_where_its_clock_is_set() {
    let folder = sailing();
    let mut selection = messages(&["TBRFishTag"]);
    selection.fields = vec!["heard".to_owned(), "heard_unix_s".to_owned(), "millis".to_owned()];
    let table = csv(folder.path(), &selection, CsvOptions::default());
    let cells: Vec<&str> = table.lines().map(|line| line.splitn(9, ',').last().unwrap()).collect();
    assert_eq!(
        cells,
        [
            "heard,heard_unix_s [s],millis [ms]",
            "2026-11-21T08:00:00.007Z,1795248000.007,7",
            ",,0",
            // As both columns have it, although no receiver should say so.
            "2026-11-21T08:00:26.742Z,1795248026.742,26742",
        ]
    );
    assert!(
        describe_csv(&mut store::Reader::open(folder.path()).unwrap(), &selection, &CsvOptions::default())
            .is_ok()
    );
}

/// Both as one series is streamed and as several are merged, in slices that are read again when they are too long.
#[test]
fn of_each_series_the_first_row_of_each_span_is_written() {
    let folder = sailing();
    let options = CsvOptions { every_us: NonZeroI64::new(1_000_000), ..CsvOptions::default() };
    let seconds = |table: &str| {
        let times = table.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().to_owned());
        times.collect::<Vec<_>>()
    };
    let one = csv(folder.path(), &messages(&["EstimatedState"]), options);
    let expected: Vec<String> = (0..5).map(|at| format!("{}.020000", START_US / 1_000_000 + at)).collect();
    assert_eq!(seconds(&one), expected);
    let both = csv(folder.path(), &messages(&["EstimatedState", "Temperature"]), options);
    let twice: Vec<String> = expected.iter().flat_map(|time| [time.clone(), time.clone()]).collect();
    assert_eq!(seconds(&both), twice);
}

#[test]
fn the_size_of_a_table_is_told_before_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for at in 0..6_000 {
        accept(&mut store, &temperature(second(at), 8.0 + at as f32 / 1_000.0), second(at), Transport::Tcp);
    }
    store.close().unwrap();
    for every_us in [None, NonZeroI64::new(2_000_000)] {
        let options = CsvOptions { every_us, ..CsvOptions::default() };
        for range in [TimeRange::ALL, TimeRange::new(None, Some(utc(second(40))))] {
            let selection = Selection { range, ..messages(&["Temperature"]) };
            let table = csv(folder.path(), &selection, options);
            let told = store::measure_csv(folder.path(), &selection, &options).unwrap();
            assert_eq!(told.rows, table.lines().count() as u64 - 1);
            let off = (told.bytes as f64 - table.len() as f64).abs() / table.len() as f64;
            assert!(off < 0.05, "{} for {}", told.bytes, table.len());
        }
    }
    let unknown = store::measure_csv(folder.path(), &messages(&["Nothing"]), &CsvOptions::default());
    assert!(unknown.unwrap_err().to_string().contains("Nothing"));
}

#[test]
fn what_came_is_listed_by_day_and_vessel() {
    let folder = sailing();
    let reader = store::Reader::open(folder.path()).unwrap();
    let days = reader.recorded_days().unwrap();
    let [day] = &days[..] else { panic!("{days:?}") };
    assert_eq!((day.system, day.extent.count), (OTTER, 23));
    assert_eq!((day.extent.first_us, day.extent.last_us), (START_US + 20_000, second(22)));
    assert!(day.bytes > 0 && day.day.micros() <= START_US && START_US - day.day.micros() < 86_400_000_000);
}
