use super::super::tests::{bare, bytes, study, whole};
use super::super::{LUTRA_COLUMNS, format};
use super::*;
use crate::study::Study;
use api::TrackPoint;
use detections::Detection;
use std::collections::BTreeMap;

/// A reader of the classic format, written from its grammar and not from its writer.
struct Reader<'b> {
    bytes: &'b [u8],
    at: usize,
}

/// A variable as a header has it.
struct Found {
    dimensions: Vec<usize>,
    attributes: BTreeMap<String, String>,
    kind: u32,
    size: u64,
    begins: usize,
}

struct File<'b> {
    bytes: &'b [u8],
    records: usize,
    dimensions: Vec<(String, u32)>,
    attributes: BTreeMap<String, String>,
    variables: BTreeMap<String, Found>,
}

impl Reader<'_> {
    fn word(&mut self) -> u32 {
        self.at += 4;
        u32::from_be_bytes(self.bytes[self.at - 4..self.at].try_into().unwrap())
    }

    fn long(&mut self) -> u64 {
        u64::from(self.word()) << 32 | u64::from(self.word())
    }

    fn text(&mut self) -> String {
        let length = self.word() as usize;
        let text = String::from_utf8(self.bytes[self.at..self.at + length].to_vec()).unwrap();
        self.at += length.next_multiple_of(4);
        text
    }

    /// The number of elements of a list.
    fn list(&mut self, tag: u32) -> u32 {
        let (found, elements) = (self.word(), self.word());
        assert!(found == tag || (found, elements) == (0, 0), "{found:#x} is not {tag:#x}");
        elements
    }

    fn attributes(&mut self) -> BTreeMap<String, String> {
        let count = self.list(0x0C);
        let one = |reader: &mut Self| {
            let name = reader.text();
            let value = match reader.word() {
                2 => reader.text(),
                6 => {
                    assert_eq!(reader.word(), 1);
                    f64::from_bits(reader.long()).to_string()
                }
                kind => panic!("{name} has values of kind {kind}"),
            };
            (name, value)
        };
        (0..count).map(|_| one(self)).collect()
    }
}

fn opened(bytes: &[u8]) -> File<'_> {
    assert_eq!(&bytes[..4], b"CDF\x02");
    let mut reader = Reader { bytes, at: 4 };
    let records = reader.word() as usize;
    let count = reader.list(0x0A);
    let dimensions = (0..count).map(|_| (reader.text(), reader.word())).collect();
    let attributes = reader.attributes();
    let count = reader.list(0x0B);
    let variable = |reader: &mut Reader<'_>| {
        let name = reader.text();
        let over = reader.word();
        let dimensions = (0..over).map(|_| reader.word() as usize).collect();
        let attributes = reader.attributes();
        let (kind, size) = (reader.word(), u64::from(reader.word()));
        let begins = reader.long() as usize;
        (name, Found { dimensions, attributes, kind, size, begins })
    };
    let variables = (0..count).map(|_| variable(&mut reader)).collect();
    File { bytes, records, dimensions, attributes, variables }
}

impl File<'_> {
    /// Bytes of a record.
    fn stride(&self) -> usize {
        let of_records = self.variables.values().filter(|one| one.dimensions.first() == Some(&0));
        of_records.map(|one| one.size as usize).sum()
    }

    fn place(&self, name: &str, record: usize) -> usize {
        self.variables[name].begins + record * self.stride()
    }

    fn number(&self, name: &str, record: usize) -> f64 {
        let at = self.place(name, record);
        assert_eq!(self.variables[name].kind, 6, "{name}");
        f64::from_be_bytes(self.bytes[at..at + 8].try_into().unwrap())
    }

    fn text(&self, name: &str, record: usize) -> &str {
        let found = &self.variables[name];
        let length = self.dimensions[*found.dimensions.last().unwrap()].1 as usize;
        let at = self.place(name, record);
        std::str::from_utf8(&self.bytes[at..at + length]).unwrap().trim_end_matches('\0')
    }
}

#[test]
fn points_have_the_values_of_the_table_and_the_attributes_of_the_conventions() {
    let raw = Some("æ".repeat(200));
    let all = [(whole(), Some(7.25)), (bare(), None), (Detection { raw, data: None, ..whole() }, None)];
    let bytes = bytes(format("netcdf").unwrap(), &study(), &all);
    let file = opened(&bytes);
    assert_eq!(file.records, 2, "what has no place is left out");
    assert_eq!(bytes.len(), file.place("time", 2), "nothing stands behind the last record");
    let known = |name: &str| file.attributes.get(name).map(String::as_str);
    assert_eq!(known("Conventions"), Some("CF-1.10, ACDD-1.3"));
    assert_eq!(known("featureType"), Some("point"));
    assert_eq!((known("creator_name"), known("project")), (Some("Kari Nordmann"), Some("FJORD")));
    assert_eq!((known("geospatial_lat_min"), known("geospatial_lon_max")), (Some("63.44"), Some("-10.4")));
    assert_eq!(known("time_coverage_start"), Some("2026-11-21T08:00:00.007Z"));
    assert_eq!(known("date_created"), Some("2026-11-21T08:00:02.000Z"));
    for name in ["title", "summary", "keywords", "source", "history"] {
        assert!(known(name).is_some_and(|text| !text.is_empty()), "{name}");
    }
    for (name, standard, units) in [
        ("time", "time", "seconds since 1970-01-01T00:00:00Z"),
        ("latitude", "latitude", "degrees_north"),
        ("longitude", "longitude", "degrees_east"),
    ] {
        let found = &file.variables[name].attributes;
        assert_eq!((&*found["standard_name"], &*found["units"]), (standard, units));
        assert!(!found.contains_key("_FillValue") && !found.contains_key("coordinates"), "{name}");
    }
    for column in LUTRA_COLUMNS.iter().map(|column| column.bare_name().replace("_utc", "_time")) {
        assert!(file.variables.contains_key(&column), "{column}");
    }
    assert_eq!(file.variables["snr"].attributes["coordinates"], "time latitude longitude");
    // A decibel is a tenth of a bel.
    assert_eq!(file.variables["snr"].attributes["units"], "0.1 lg(re 1)");
    let reading = &file.variables["sensor_reading"].attributes;
    assert!(!reading.contains_key("units") && reading["long_name"].ends_with("sensor_unit"), "{reading:?}");
    assert_eq!(
        (file.text("sensor_unit", 0), file.variables["tag_id"].attributes["units"].as_str()),
        ("m", "1")
    );
    assert_eq!((file.number("time", 0), file.number("latitude", 1)), (1_795_248_000.007, 63.44));
    // To the microsecond.
    assert_eq!((file.number("reported_time", 0) * 1e6).round() as i64, 1_795_248_001_000_001);
    assert_eq!((file.number("snr", 0), file.number("sensor_value", 0)), (25.0, 42.0));
    assert!(file.number("sensor_value", 1).is_nan(), "not known is not a number");
    assert_eq!((file.text("tag", 0), file.text("vessel", 1)), ("S256-7", "otter-1"));
    assert_eq!(file.text("raw_line", 0), "=1024,1");
    assert_eq!(file.text("raw_line", 1), "æ".repeat(127), "cut between letters");
    assert_eq!((file.number("min_lag", 0), file.text("doubt", 0)), (7.25, ""));
}

#[test]
fn without_a_detection_it_is_a_file_without_records() {
    let bytes = bytes(format("netcdf").unwrap(), &Study::default(), &[]);
    let file = opened(&bytes);
    assert_eq!((file.records, bytes.len()), (0, file.place("time", 0)));
    assert!(!file.attributes.contains_key("geospatial_lat_min"));
}

#[test]
fn a_track_is_a_trajectory_of_its_positions() {
    let point = |s: i64, lat_deg: f64| TrackPoint { time_us: s * 1_000_000 + 1, lat_deg, lon_deg: 10.25 };
    let points = [point(1_795_248_000, 63.5), point(1_795_248_060, 63.25)];
    let bytes = write_track(&TrackOf { vessel: "Øtter", points: &points, step_us: 1_000_000 });
    let file = opened(&bytes);
    assert_eq!((file.records, bytes.len()), (2, file.place("time", 2)));
    assert_eq!(file.attributes["featureType"], "trajectory");
    assert_eq!(file.attributes["time_coverage_duration"], "PT60S");
    assert_eq!(file.variables["trajectory"].attributes["cf_role"], "trajectory_id");
    assert_eq!(file.text("trajectory", 0), "Øtter");
    let read: Vec<(f64, f64)> =
        (0..2).map(|at| (file.number("latitude", at), file.number("longitude", at))).collect();
    assert_eq!(read, [(63.5, 10.25), (63.25, 10.25)]);
    assert_eq!((file.number("time", 1) * 1e6).round() as i64, points[1].time_us);
    let none = write_track(&TrackOf { vessel: "", points: &[], step_us: 0 });
    assert_eq!(opened(&none).records, 0);
}
