//! Tables and logs out of a store.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod support;

use imc::Address;
use imc::messages::{EntityList, EntityListOp, EulerAngles, LogBookEntry, Temperature};
use std::io::{self, Write};
use std::path::Path;
use store::{
    Angles, CsvOptions, Door, Selection, Shape, Store, TimeRange, describe_csv, export_csv, export_lsf,
};
use support::{OTTER, START_US, accept, archived, packet, packet_of, temperature, utc};

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
        accept(&mut store, packet, second(10), Door::Tcp);
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
        "time,unix_s,system,system_id,entity,entity_id,value [°C]\n\
         2026-11-21T08:00:01.000000Z,1795248001.000000,ntnu-otter-01,0x2810,'=cmd(),5,-7.25\n\
         2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-02,0x2811,,5,1.5\n\
         2026-11-21T08:00:03.000000Z,1795248003.000000,ntnu-otter-01,0x2810,'=cmd(),5,8.1\n"
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
        "time,unix_s,system,system_id,entity,entity_id,message,EulerAngles.phi [deg],EulerAngles.psi [deg],\
         Temperature.value [°C]\n\
         2026-11-21T08:00:01.000000Z,1795248001.000000,ntnu-otter-01,0x2810,'=cmd(),5,Temperature,,,-7.25\n\
         2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-01,0x2810,AHRS,6,EulerAngles,,180,\n\
         2026-11-21T08:00:03.000000Z,1795248003.000000,ntnu-otter-01,0x2810,'=cmd(),5,Temperature,,,8.1\n"
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
    assert_eq!(lines[0], "time,unix_s,system,system_id,entity,entity_id,message,field,value,unit");
    let psi = "2026-11-21T08:00:02.000000Z,1795248002.000000,ntnu-otter-01,0x2810,AHRS,6,EulerAngles,psi,\
               3.141592653589793,rad";
    assert!(lines.contains(&psi), "{table}");
    assert!(!table.contains(",phi,"), "a NaN has no row");
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
            Door::Tcp,
        );
        expected += 1;
        if at % 100 == 0 {
            // A burst of one microsecond, from many entities.
            for entity in 10..40 {
                let other = packet_of(OTHER, START_US + at * 50_000, entity, &EulerAngles::default());
                accept(&mut store, &other, START_US, Door::Tcp);
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
