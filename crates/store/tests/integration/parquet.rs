//! Tables as Parquet have the columns and the values of tables as CSV, with types.

use crate::dialect::{messages, packet_with, payload, stored, table};
use crate::support::{OTTER, START_US, packet, utc};
use bytes::Bytes;
use imc::catalogue::MESSAGES;
use imc::messages::{EntityList, EntityListOp, EulerAngles, TBRFishTag, Temperature};
use parquet::basic::{LogicalType, Type as Physical};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::{Field, Row};
use proptest::prelude::*;
use std::path::Path;
use store::{Angles, CsvOptions, Selection, Shape, StoreError, export_parquet};
use tables::{Dialect, Format, IsoTime};

type Reader = SerializedFileReader<Bytes>;

fn parquet(folder: &Path, selection: &Selection, options: CsvOptions) -> Reader {
    let mut out = Vec::new();
    let exported = export_parquet(folder, selection, &options, &mut out).unwrap();
    assert_eq!(exported.bytes, out.len() as u64);
    let reader = SerializedFileReader::new(Bytes::from(out)).unwrap();
    assert_eq!(exported.rows, reader.metadata().file_metadata().num_rows() as u64);
    reader
}

fn columns(reader: &Reader) -> Vec<(String, Physical, Option<LogicalType>)> {
    let schema = reader.metadata().file_metadata().schema_descr();
    let column = |column: &parquet::schema::types::ColumnDescPtr| {
        (column.name().to_owned(), column.physical_type(), column.logical_type_ref().cloned())
    };
    schema.columns().iter().map(column).collect()
}

/// A cell as a CSV without apostrophes has it.
fn cell(out: &mut Vec<u8>, name: &str, value: &Field) {
    let format = Format { guard: false, ..Format::default() };
    match value {
        Field::Null => {}
        Field::Long(value) => tables::integer(out, *value),
        Field::Float(value) => tables::single(out, *value, Dialect::Plain),
        Field::Double(value) => tables::double(out, *value, Dialect::Plain),
        Field::Str(text) => tables::quoted(out, text, format),
        Field::Bytes(bytes) => tables::hex(out, bytes.data()),
        Field::TimestampMicros(us) if name.ends_with("heard") => IsoTime::new().write_ms(out, *us),
        other => panic!("{name}: {other:?}"),
    }
}

/// A row as a line of that CSV.
fn line(row: &Row) -> String {
    let mut out = Vec::new();
    for (at, (name, value)) in row.get_column_iter().enumerate() {
        match (at, value) {
            (0, Field::TimestampMicros(us)) => {
                tables::stamp(&mut out, &mut IsoTime::new(), Some(*us), Dialect::Plain);
            }
            (0, _) => out.push(b','),
            (_, value) => {
                out.push(b',');
                cell(&mut out, name, value);
            }
        }
    }
    out.push(b'\n');
    String::from_utf8(out).unwrap()
}

fn lines(reader: &Reader) -> String {
    reader.get_row_iter(None).unwrap().map(|row| line(&row.unwrap())).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: testkit::so_many(40, 400) as u32, ..ProptestConfig::default() })]

    #[test]
    fn every_message_has_the_values_of_its_csv(
        at in 0..MESSAGES.len(),
        entropies in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..300), 1..4),
        degrees: bool,
        labels: bool,
    ) {
        let desc = MESSAGES[at];
        let said: Vec<Vec<u8>> = entropies.iter().zip(1..).map(|(entropy, second)| {
            let timestamp = utc(START_US + second * 1_000_000).seconds();
            packet_with(desc, timestamp, &payload(desc, &mut entropy.iter().copied(), 0))
        }).collect();
        let folder = stored(&said);
        let angles = if degrees { Angles::Degrees } else { Angles::Radians };
        let options = CsvOptions { guard: false, angles, labels, ..CsvOptions::default() };
        let selection = messages(&[desc.abbrev]);
        let csv = table(folder.path(), &selection, options);
        let (header, rows) = csv.split_once('\n').unwrap();
        let reader = parquet(folder.path(), &selection, options);
        prop_assert_eq!(lines(&reader), rows);
        let names: Vec<String> = columns(&reader).into_iter().map(|(name, ..)| name).collect();
        prop_assert_eq!(names.join(","), header.replace("time,unix_s,", "time,").replace('"', ""));
    }
}

/// Three messages of two kinds, a label that changed, and a receiver's clock that was never set.
fn several() -> tempfile::TempDir {
    let list = |label: &str| EntityList { op: EntityListOp::Report, list: format!("{label}=5").into() };
    let second = |at: i64| START_US + at * 1_000_000;
    stored(&[
        packet(second(0), 0, &list("Port")),
        packet(second(1), 5, &Temperature { value: f32::NAN }),
        packet(second(2), 5, &EulerAngles { psi: 1.5, ..EulerAngles::default() }),
        packet(second(3), 0, &list("Starboard")),
        packet(second(4), 5, &Temperature { value: 8.25 }),
        packet(second(5), 5, &TBRFishTag { unix_timestamp: 3, millis: 250, ..TBRFishTag::default() }),
        packet(
            second(6),
            5,
            &TBRFishTag { unix_timestamp: 1_795_248_006, millis: 250, ..TBRFishTag::default() },
        ),
    ])
}

#[test]
fn several_messages_stand_in_one_table_in_order_of_time() {
    let folder = several();
    let selection = messages(&["Temperature", "EulerAngles", "TBRFishTag"]);
    let options = CsvOptions { guard: false, units: false, ..CsvOptions::default() };
    let reader = parquet(folder.path(), &selection, options);
    let csv = table(folder.path(), &selection, options);
    assert_eq!(lines(&reader), csv.split_once('\n').unwrap().1);
    assert!(lines(&reader).contains(",Port,5,") && lines(&reader).contains(",Starboard,5,"));

    let micros = |column: &(String, Physical, Option<LogicalType>)| {
        matches!(column.2, Some(LogicalType::Timestamp(_))) && column.1 == Physical::INT64
    };
    let times: Vec<String> =
        columns(&reader).iter().filter(|one| micros(one)).map(|one| one.0.clone()).collect();
    assert_eq!(times, ["time", "TBRFishTag.heard"]);
    let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap().clone();
    let about = pairs.iter().find(|pair| pair.key == "lutra").unwrap().value.clone().unwrap();
    assert!(
        about.contains(r#""field":"psi","message":"EulerAngles","name":"EulerAngles.psi","unit":"rad""#),
        "{about}"
    );
}

#[test]
fn when_it_came_ashore_is_there_if_it_is_asked_for() {
    let folder = several();
    let options = CsvOptions { received: true, ..CsvOptions::default() };
    let reader = parquet(folder.path(), &messages(&["Temperature"]), options);
    let row = reader.get_row_iter(None).unwrap().next().unwrap().unwrap();
    let received = row.get_column_iter().find(|(name, _)| *name == "received").unwrap().1;
    assert_eq!(*received, Field::TimestampMicros(START_US));
}

#[test]
fn a_table_without_rows_has_its_columns() {
    let folder = several();
    let selection = Selection { systems: vec![OTTER], ..messages(&["Rpm"]) };
    let reader = parquet(folder.path(), &selection, CsvOptions::default());
    assert_eq!(lines(&reader), "");
    assert_eq!(columns(&reader).last().unwrap().0, "value [rpm]");
}

#[test]
fn what_is_text_alone_is_refused_with_what_to_do() {
    let folder = several();
    let refused = |names: &[&str], options: CsvOptions| {
        let mut out = Vec::new();
        let error = export_parquet(folder.path(), &messages(names), &options, &mut out).unwrap_err();
        assert!(matches!(error, StoreError::Query(_)) && out.is_empty(), "{error}");
        error.to_string()
    };
    let long = CsvOptions { shape: Shape::Long, ..CsvOptions::default() };
    assert!(refused(&["Temperature"], long).contains("ask for a wide table"));
    let comma = CsvOptions { dialect: Dialect::SpreadsheetComma, ..CsvOptions::default() };
    assert!(refused(&["Temperature"], comma).contains("leave it out"));
    let all: Vec<&str> = MESSAGES.iter().map(|desc| desc.abbrev).collect();
    assert!(refused(&all, CsvOptions::default()).contains("name fewer messages"));
    assert!(refused(&["_raw"], CsvOptions::default()).contains("as CSV"));
}
