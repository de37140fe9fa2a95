use super::*;
use crate::lag::{Lag, Lags};
use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
use ::parquet::record::Field;
use api::{
    RegisterAnimal, RegisterDeployment, RegisterPerson, RegisterProject, RegisterReceiver, RegisterRecord,
    RegisterTag,
};
use detections::{Detection, Effort, Noise, Origin, Pose, Protocol, ReceiverClock};
use imc::Address;
use units::{LatLon, UtcTime};

/// 2026-11-21 08:00 UTC.
pub(super) const START_S: u32 = 1_795_248_000;

pub(super) fn bare() -> Detection {
    let reported = UtcTime::from_micros(1_795_248_001_000_001);
    Detection {
        origin: Origin { system: Address(0x0814), entity: 2, reported, received: None },
        receiver: 1_024,
        maker: None,
        clock: ReceiverClock::read(600, 250),
        protocol: Protocol::named("R64K"),
        tag_id: 7,
        data: None,
        snr_db: Some(25),
        frequency_khz: Some(69),
        line: 3,
        pose: None,
        effort: Effort::default(),
        raw: None,
    }
}

pub(super) fn whole() -> Detection {
    let place = LatLon::from_deg(63.44, -10.4).unwrap();
    let received = Some(UtcTime::from_micros(1_795_248_002_000_000));
    Detection {
        origin: Origin { received, ..bare().origin },
        clock: ReceiverClock::read(START_S, 7),
        protocol: Protocol::named("S256"),
        data: Some(42),
        pose: Some(Pose { place, age_s: Some(0.4), sigma_m: Some(0.75) }),
        effort: Effort {
            lines_lost: Some(0),
            noise: Some(Noise { average: 0, peak: 40, age_s: 12.5 }),
            propeller_rpm: Some(0.0),
        },
        raw: Some("=1024,1".to_owned()),
        ..bare()
    }
}

pub(super) fn study() -> Study {
    let from_us = Some(i64::from(START_S) * 1_000_000);
    Study::new([
        RegisterRecord::Person(RegisterPerson { name: "Kari Nordmann".to_owned(), ..Default::default() }),
        RegisterRecord::Project(RegisterProject {
            name: "FJORD".to_owned(),
            principal_investigator: "kari nordmann".to_owned(),
            contact: "Kari Nordmann".to_owned(),
            citation: "Nordmann, K. (2026)".to_owned(),
            ..Default::default()
        }),
        RegisterRecord::Animal(RegisterAnimal {
            name: "Salmon 12".to_owned(),
            project: "FJORD".to_owned(),
            scientific_name: "Salmo salar".to_owned(),
            common_name: "Atlantic salmon".to_owned(),
            length_mm: Some(512.0),
            weight_g: Some(1_340.0),
            sex: "F".to_owned(),
            capture_place: "Lena".to_owned(),
            release_us: Some(1_795_161_600_000_000),
            release_place: "Lena, mouth".to_owned(),
            release_lat_deg: Some(63.4),
            release_lon_deg: Some(10.1),
            release_group: "spring".to_owned(),
            ..Default::default()
        }),
        RegisterRecord::Tag(RegisterTag {
            name: "S256-7 A".to_owned(),
            protocol: "s256".to_owned(),
            tag_id: Some(7),
            serial: "1290007".to_owned(),
            model: "D-LP13".to_owned(),
            sensor_type: "depth".to_owned(),
            sensor_slope: Some(0.2),
            sensor_unit: "m".to_owned(),
            animal: "salmon 12".to_owned(),
            from_us,
            ..Default::default()
        }),
        RegisterRecord::Receiver(RegisterReceiver {
            name: "TBR700-1024".to_owned(),
            serial: Some(1_024),
            model: "TBR700".to_owned(),
            ..Default::default()
        }),
        RegisterRecord::Deployment(RegisterDeployment {
            name: "Spring".to_owned(),
            receiver: "TBR700-1024".to_owned(),
            vessel: Some(0x0814),
            project: "FJORD".to_owned(),
            from_us,
            depth_m: Some(0.5),
            ..Default::default()
        }),
    ])
}

fn lag_of(lag_s: Option<f64>) -> Lag {
    lag_s.map_or(Lag::Nothing, Lag::Seconds)
}

pub(super) fn bytes(format: Format, study: &Study, all: &[(Detection, Option<f64>)]) -> Vec<u8> {
    let spool = Box::new(std::io::Cursor::new(Vec::new()));
    let (mut writer, mut out) = (Writer::new(format, Dialect::Plain).with_spool(spool), Vec::new());
    writer.header(&mut out).unwrap();
    for (one, lag) in all {
        writer.row(&mut out, &study.heard(one, "otter-1", lag_of(*lag))).unwrap();
    }
    writer.end(&mut out, study, &About::default()).unwrap();
    out
}

fn file(format: Format, study: &Study, all: &[(Detection, Option<f64>)]) -> String {
    String::from_utf8(bytes(format, study, all)).unwrap()
}

/// The rows of a format for a detection that is known whole and one of which little is known, without its header.
fn rows(name: &str) -> Vec<String> {
    let format = format(name).unwrap();
    let text = file(format, &study(), &[(whole(), Some(7.25)), (bare(), None)]);
    text.strip_prefix(format.header).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn headers_are_those_of_the_fact_sheet() {
    let Some(facts) =
        testkit::shared("facts/acoustics_exports.md").map(|path| std::fs::read_to_string(path).unwrap())
    else {
        return;
    };
    let of_others = |format: &&Format| format.is_csv() && !["lutra", "fathom"].contains(&format.name);
    for format in FORMATS.iter().filter(of_others) {
        // Of GLATOS the sheet has 1.3, and what 1.4 adds.
        let header = format.header.trim_end().trim_end_matches(",record_status");
        // Of actel's biometrics too it names the columns one after another; of Movebank each in backticks of its own.
        let facts = if format.name == "movebank" {
            facts.replace("` (UTC, .SSS), `", ",").replace("`, `", ",")
        } else {
            facts.clone()
        };
        assert!(facts.contains(&format!("`{header}`")), "{}: {header}", format.name);
    }
    assert!(
        facts.contains("1.4 adds record_status")
            && format("glatos").unwrap().header.ends_with(",record_status\n")
    );
    let fathom = format("fathom").unwrap().header;
    let (first, header) = fathom.split_once('\n').unwrap();
    assert!(first.starts_with("VEMCO DATA LOG,2.0.0,") && facts.contains(&format!("`{}`", header.trim())));
}

#[test]
fn every_row_has_a_cell_for_each_column() {
    for format in FORMATS.into_iter().filter(Format::is_csv) {
        let study = study();
        let text = file(format, &study, &[(Detection { raw: None, ..whole() }, Some(1.0)), (bare(), None)]);
        let plain = text.replace("\"Lena, mouth\"", "").replace("\"Nordmann, K. (2026)\"", "");
        let lines: Vec<&str> = plain.lines().skip(usize::from(format.name == "fathom")).collect();
        let cells = |line: &str| line.split(',').count();
        assert!(lines.len() > 1, "{}", format.name);
        for line in &lines[1..] {
            assert_eq!(cells(line), cells(lines[0]), "{}: {line}", format.name);
        }
    }
}

#[test]
fn rows_of_vue_and_fathom() {
    assert_eq!(
        rows("vue"),
        [
            "2026-11-21 08:00:00.007,TBR700-1024,A69-1105-7,S256-7 A,1290007,8.4,m,otter-1,63.44000000,-10.40000000",
            // The receiver's clock was never set: the vessel's time stands in.
            "2026-11-21 08:00:01.000,TBR700-1024,A69-1303-7,,,,,otter-1,,",
        ]
    );
    assert_eq!(
        rows("fathom"),
        [
            "DET,2026-11-21 08:00:00.007,2026-11-21 08:00:00.007,0.00,0.000,TBR700,1024,,PPM,A69-1105-7,7,42,1290007,,,,,otter-1,63.44000000,-10.40000000,",
            "DET,1970-01-01 00:10:00.250,2026-11-21 08:00:01.000,0.00,1795247400.750,TBR700,1024,,PPM,A69-1303-7,7,,,,,,,otter-1,,,",
        ]
    );
}

#[test]
fn rows_of_thelma() {
    assert_eq!(
        rows("thelma"),
        [
            "2026-11-21 08:00:00.007,1795248000.007,7,42,S256-69kHz,25,1024",
            "2026-11-21 08:00:01.000,1795248001.000,7,-,R64K-69kHz,25,1024",
        ]
    );
    assert_eq!(
        rows("thelma-old"),
        [
            "2026-11-21 08:00:00,1024,1795248000,7,S256,7,42,25",
            "2026-11-21 08:00:01,1024,1795248001,0,R64K,7,-,25"
        ]
    );
}

#[test]
fn rows_of_networks() {
    assert_eq!(
        rows("otn"),
        [
            "FJORD,Salmon 12,Salmon 12,Salmo salar,Atlantic salmon,2026-11-21T08:00:02Z,FJORD,otter-1,1024,,0.5,A69-1105-7,\
             A69-1105,depth,42,depth,8.4,m,2026-11-21T08:00:00.007Z,2026-11-21T08:00:00.007Z,-10.40000000,63.44000000,\
             EPSG:4326,POINT (-10.40000000 63.44000000),,\"Nordmann, K. (2026)\",\
             LUTRA-0814-1024-1795248000.007-S256-7-2-1795248001000001,Kari Nordmann,Kari Nordmann",
            ",,,,,,FJORD,otter-1,1024,,0.5,A69-1303-7,A69-1303,,,,,,2026-11-21T08:00:01.000Z,1970-01-01T00:10:00.250Z,,,,,,,\
             LUTRA-0814-1024-600.250-R64K-7-2-1795248001000001,,",
        ]
        .map(str::to_owned)
    );
    assert_eq!(
        rows("etn"),
        [
            "0814-1024-1795248000.007-S256-7-2-1795248001000001,2026-11-21T08:00:00Z,1290007,A69-1105-7,FJORD,Salmon 12,\
             Salmo salar,FJORD,TBR700-1024,otter-1,63.44000000,-10.40000000,8.4,m,,,25,,,Spring",
            "0814-1024-600.250-R64K-7-2-1795248001000001,2026-11-21T08:00:01Z,,A69-1303-7,,,,FJORD,TBR700-1024,otter-1,,,,,,,25,,,Spring",
        ]
    );
    assert_eq!(
        rows("glatos"),
        [
            "Salmon 12,2026-11-21 08:00:00.007,FJORD,otter-1,A69-1105,7,8.4,m,63.44000000,-10.40000000,1024,depth,D-LP13,\
             1290007,Atlantic salmon,Lena,0.512,1.34,F,spring,\"Lena, mouth\",63.40000000,10.10000000,2026-11-20 08:00:00,\
             FJORD,FJORD,,,otter-1,7.25,",
            ",2026-11-21 08:00:01.000,FJORD,otter-1,A69-1303,7,,,,,1024,,,,,,,,,,,,,,,FJORD,,,otter-1,,",
        ]
    );
}

#[test]
fn rows_of_packages() {
    assert_eq!(
        rows("actel"),
        ["2026-11-21 08:00:00.007,1024,A69-1105,7,8.4,m", "2026-11-21 08:00:01.000,1024,A69-1303,7,NA,NA"]
    );
    assert_eq!(rows("actel-biometrics"), ["2026-11-20 08:00:00,\"Lena, mouth\",1290007,7,spring,512,1340"]);
    // A clock that was never set gives no arrival times; an event keeps its place.
    assert_eq!(rows("yaps"), ["2026-11-21 08:00:00.007,S256-7,1795248000,0.007,1024"]);
    assert_eq!(
        rows("movebank"),
        [
            "2026-11-21 08:00:00.007,-10.40000000,63.44000000,Salmon 12,S256-7 A,acoustic-telemetry,Salmo salar"
        ]
    );
}

#[test]
fn rows_of_darwin_core() {
    // A detection without an animal or without a place is no occurrence.
    assert_eq!(
        rows("darwin-core"),
        [
            "Event,,,,,FJORD,,MachineObservation,,0814-1024-1795248000.007-S256-7-2-1795248001000001,female,,present,Salmon 12,\
             Salmon 12,0814-1024-1795248000.007-S256-7-2-1795248001000001,,2026-11-21T08:00:00.007Z,acoustic telemetry,,,Spring,\
             63.44000000,-10.40000000,EPSG:4326,1002,,,Salmo salar,Animalia"
        ]
    );
}

/// The cells of the format `lutra` of the same detections, as plain texts: what other formats of all columns must say too.
fn cells(all: &[(Detection, Option<f64>)]) -> Vec<Vec<String>> {
    let text = file(LUTRA, &study(), all).replace("\"'=1024,1\"", "=1024;1");
    let cells = |line: &str| line.split(',').map(|cell| cell.replace(';', ",")).collect();
    text.lines().skip(1).map(cells).collect()
}

#[test]
fn geojson_has_every_column_and_a_place_where_one_is_known() {
    let all = [(whole(), Some(7.25)), (bare(), None)];
    let text = file(format("geojson").unwrap(), &study(), &all);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let features = json["features"].as_array().unwrap();
    assert_eq!((&json["type"], features.len()), (&"FeatureCollection".into(), 2));
    for (feature, cells) in features.iter().zip(cells(&all)) {
        for (column, cell) in LUTRA_COLUMNS.iter().zip(cells) {
            let value = &feature["properties"][column.name];
            match column.kind {
                _ if cell.is_empty() => assert!(value.is_null(), "{}", column.name),
                ColumnKind::Text | ColumnKind::Time => assert_eq!(value, &cell, "{}", column.name),
                ColumnKind::Whole | ColumnKind::Real => {
                    assert_eq!(value.as_f64(), cell.parse().ok(), "{}", column.name);
                }
            }
        }
    }
    assert_eq!(features[0]["geometry"], serde_json::json!({"type": "Point", "coordinates": [-10.4, 63.44]}));
    assert!(features[1]["geometry"].is_null());
    let none: serde_json::Value =
        serde_json::from_str(&file(format("geojson").unwrap(), &study(), &[])).unwrap();
    assert_eq!(none["features"], serde_json::json!([]));
}

#[test]
fn kml_is_whole_and_escapes_what_vessels_said() {
    let raw = Some("<1024 & \"1\"\u{7}>".to_owned());
    let text =
        file(format("kml").unwrap(), &study(), &[(Detection { raw, ..whole() }, None), (bare(), None)]);
    let mut reader = quick_xml::Reader::from_str(&text);
    let (mut depth, mut marks) = (0, 0);
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Start(start) => {
                depth += 1;
                marks += usize::from(start.name().as_ref() == "Placemark");
            }
            quick_xml::events::Event::End(_) => depth -= 1,
            quick_xml::events::Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!((depth, marks), (0, 1), "what has no place is left out");
    assert!(text.contains("<value>&lt;1024 &amp; &quot;1&quot; &gt;</value>"), "{text}");
    assert!(text.contains("<when>2026-11-21T08:00:00.007Z</when>"));
    assert!(text.contains("<coordinates>-10.40000000,63.44000000</coordinates>"));
    assert!(text.contains("<Placemark><name>Salmon 12</name>"));
}

#[test]
fn a_table_of_parquet_has_the_same_values_with_their_types() {
    let all: Vec<_> =
        (0..32_800).map(|at| if at % 3 == 0 { (bare(), None) } else { (whole(), Some(7.25)) }).collect();
    let bytes = bytes(format("parquet").unwrap(), &study(), &all);
    let file = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
    assert_eq!(file.metadata().num_row_groups(), 2);
    let (mut rows, wanted) = (file.get_row_iter(None).unwrap(), cells(&all));
    for wanted in &wanted {
        let row = rows.next().unwrap().unwrap();
        for ((name, field), (column, cell)) in row.get_column_iter().zip(LUTRA_COLUMNS.iter().zip(wanted)) {
            assert_eq!(name, column.name);
            match (column.kind, field) {
                (_, Field::Null) => assert!(cell.is_empty(), "{name}"),
                (ColumnKind::Text, Field::Str(text)) => assert_eq!(text, cell),
                (ColumnKind::Whole, Field::Long(value)) => assert_eq!(value, &cell.parse::<i64>().unwrap()),
                (ColumnKind::Real, Field::Double(value)) => {
                    assert_eq!(value.to_bits(), cell.parse::<f64>().unwrap().to_bits());
                }
                (ColumnKind::Time, Field::TimestampMicros(us)) => {
                    assert_eq!(UtcTime::from_micros(*us), cell.parse().unwrap(), "{name}");
                }
                (kind, field) => panic!("{name}: {field:?} is not a {kind:?}"),
            }
        }
    }
    assert!(rows.next().is_none());
}

#[test]
fn a_count_without_a_meaning_says_that_it_is_one() {
    for (name, cells) in
        [("etn", ",42,ADC,"), ("actel", ",42,ADC\n"), ("vue", ",42,ADC,"), ("glatos", ",42,ADC,")]
    {
        let text = file(format(name).unwrap(), &Study::default(), &[(whole(), None)]);
        assert!(text.contains(cells), "{name}: {text}");
    }
}

#[test]
fn what_no_message_carried_is_an_empty_cell() {
    let text = file(LUTRA, &Study::default(), &[(bare(), None)]);
    let row = text.lines().nth(1).unwrap().replace("otter-1", "otter");
    assert_eq!(
        row,
        ",R64K-7,1024,otter,,,,,25,,69,not set,600.250,2026-11-21T08:00:01.000001Z,,R64K,7,,,,,,3,,\
         1024-600.250-R64K-7-2-1795248001000001,,,,,,,"
    );
}

#[test]
fn a_row_tells_everything_that_was_carried_and_what_the_register_knows() {
    let text = file(LUTRA, &study(), &[(whole(), Some(7.25))]);
    assert_eq!(
        text.lines().nth(1).unwrap(),
        "2026-11-21T08:00:00.007Z,S256-7,1024,otter-1,63.44000000,-10.40000000,0.4,0.75,25,42,69,set,1795248000.007,\
         2026-11-21T08:00:01.000001Z,2026-11-21T08:00:02.000000Z,S256,7,0,0,40,12.5,0.0,3,\"'=1024,1\",\
         1024-1795248000.007-S256-7-2-1795248001000001,S256-7 A,Salmon 12,Salmo salar,8.4,m,7.25,"
    );
    let (mut writer, mut out) = (Writer::new(LUTRA, Dialect::SpreadsheetComma), Vec::new());
    writer.header(&mut out).unwrap();
    let (study, one) = (study(), whole());
    writer.row(&mut out, &study.heard(&one, "otter-1", Lag::Unknown)).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(
        text.starts_with("\u{FEFF}heard_utc;tag;") && text.contains(";63,44000000;-10,40000000;0,4;"),
        "{text}"
    );
}

#[test]
fn what_nothing_confirms_is_doubted_where_the_register_knows_how_often_the_tag_pings() {
    let pings = |interval_min_s, interval_max_s| {
        Study::new([RegisterRecord::Tag(RegisterTag {
            protocol: "S256".to_owned(),
            tag_id: Some(7),
            interval_min_s,
            interval_max_s,
            ..RegisterTag::default()
        })])
    };
    let doubt = |study: &Study, lag_s| study.heard(&whole(), "o", lag_of(lag_s)).doubt();
    let often = pings(Some(90.0), Some(150.0));
    assert_eq!(doubt(&often, Some(3_600.0)), None);
    let told = "no other detection of this tag by this receiver within 3600 s, 30 ping intervals of 120 s";
    assert_eq!(doubt(&often, Some(3_600.5)).as_deref(), Some(told));
    assert_eq!(doubt(&often, None).as_deref(), Some(told));
    assert_eq!(doubt(&pings(None, None), None), None);
    assert_eq!(doubt(&pings(Some(3_000.0), None), None), None, "a day does not tell");
}

#[test]
fn a_tag_is_found_by_code_carrier_and_time() {
    let study = study();
    let named = |one: &Detection| study.heard(one, "otter-1", Lag::Unknown).tag.map(|tag| tag.name.clone());
    assert_eq!(named(&whole()).as_deref(), Some("S256-7 A"));
    let before = Detection { clock: ReceiverClock::read(START_S - 1, 0), ..whole() };
    assert_eq!(named(&before), None, "before it was in the animal");
    assert_eq!(named(&Detection { protocol: Protocol::named("OPs"), ..whole() }), None);
    let elsewhere = Detection { origin: Origin { system: Address(7), ..whole().origin }, ..whole() };
    assert!(
        study.heard(&elsewhere, "otter-2", Lag::Unknown).deployment.is_none(),
        "deployed on another vessel"
    );
}

#[test]
fn protocols_without_a_number_keep_their_name() {
    let one = Detection { protocol: Protocol::named("R01M"), tag_id: 802_761, ..bare() };
    let study = Study::default();
    let other = Detection { frequency_khz: Some(71), protocol: Protocol::named("S256"), ..bare() };
    assert_eq!(study.heard(&one, "o", Lag::Unknown).codespace(), "A69-R01M");
    assert_eq!(
        study.heard(&other, "o", Lag::Unknown).codespace(),
        "A71-S256",
        "the numbers stand for 69 kHz"
    );
    let unknown = Detection { frequency_khz: None, ..one.clone() };
    assert_eq!(study.heard(&unknown, "o", Lag::Unknown).codespace(), "R01M", "no carrier is made up");
    let bare = Detection { snr_db: None, ..unknown };
    let thelma = file(format("thelma").unwrap(), &study, &[(bare, None)]);
    assert!(thelma.contains(",802761,-,R01M,-,1024\n"), "{thelma}");
    let etn = file(format("etn").unwrap(), &study, &[(one, None)]);
    assert!(etn.contains(",R01M-802761,") && etn.contains(",TBR-1024,"), "{etn}");
}

#[test]
fn the_nearest_other_detection_is_found_and_what_waits_comes_in_order() {
    let at = |second: u32, id: u32| Detection {
        tag_id: id,
        clock: ReceiverClock::read(START_S + second, 0),
        origin: Origin {
            reported: UtcTime::from_micros(i64::from(START_S + second) * 1_000_000),
            ..bare().origin
        },
        ..bare()
    };
    let mut lags = Lags::default();
    let mut told = Vec::new();
    let all = [at(0, 1), at(10, 2), at(100, 1), at(130, 1), at(200_000, 3)];
    for one in all.clone() {
        lags.push(one);
        while let Some((one, lag)) = lags.pop() {
            told.push((one.clock.seconds - START_S, one.tag_id, lag.seconds()));
        }
    }
    assert_eq!(told, [(0, 1, Some(100.0)), (10, 2, None), (100, 1, Some(30.0)), (130, 1, Some(30.0))]);
    let (last, lag) = lags.take().unwrap();
    assert_eq!((last.tag_id, lag), (3, Lag::Nothing));
    assert!(lags.take().is_none() && lags.pop().is_none());
    // A neighbour of more than a day ago does not count.
    lags.push(at(0, 9));
    lags.push(at(100_000, 9));
    assert_eq!(lags.take().map(|(_, lag)| lag), Some(Lag::Nothing));
}

#[test]
fn a_receiver_whose_clock_is_far_off_disturbs_no_other_and_what_is_not_known_is_not_doubted() {
    let at = |second: u32, receiver: u32, ahead_s: u32| Detection {
        receiver,
        clock: ReceiverClock::read(START_S + second + ahead_s, 0),
        origin: Origin {
            reported: UtcTime::from_micros(i64::from(START_S + second) * 1_000_000),
            ..bare().origin
        },
        ..whole()
    };
    let three_days_s = 3 * 86_400;
    let mut lags = Lags::default();
    let mut told = Vec::new();
    let all = [at(0, 1, 0), at(10, 2, three_days_s), at(60, 1, 0), at(70, 2, three_days_s)];
    for one in all {
        lags.push(one);
        told.extend(std::iter::from_fn(|| lags.pop()));
    }
    told.extend(std::iter::from_fn(|| lags.take()));
    assert_eq!(told.iter().map(|(_, lag)| *lag).collect::<Vec<_>>(), [Lag::Seconds(60.0); 4]);

    // Too many wait behind one without a neighbour.
    let mut lags = Lags::default();
    lags.push(at(0, 1, 0));
    (0..50_000).for_each(|_| lags.push(at(1, 2, 0)));
    let (one, lag) = lags.pop().unwrap();
    assert_eq!((one.receiver, lag), (1, Lag::Unknown));
    let often = Study::new([RegisterRecord::Tag(RegisterTag {
        protocol: "S256".to_owned(),
        tag_id: Some(7),
        interval_min_s: Some(60.0),
        ..RegisterTag::default()
    })]);
    assert_eq!(often.heard(&one, "o", lag).doubt(), None);
}

#[test]
fn a_tag_without_a_begin_is_in_its_animal_from_the_release_on() {
    let with = |release_us, capture_us| {
        let animal = RegisterAnimal { name: "A".to_owned(), release_us, capture_us, ..Default::default() };
        let tag = RegisterTag {
            protocol: "S256".to_owned(),
            tag_id: Some(7),
            animal: "A".to_owned(),
            ..Default::default()
        };
        let study = Study::new([RegisterRecord::Animal(animal), RegisterRecord::Tag(tag)]);
        let one = whole();
        let heard = study.heard(&one, "o", Lag::Unknown);
        (heard.tag.is_some(), heard.animal.is_some())
    };
    let start_us = i64::from(START_S) * 1_000_000;
    let (before, after) = (Some(start_us - 1_000_000), Some(start_us + 1_000_000));
    assert_eq!(with(before, None), (true, true));
    assert_eq!(with(after, before), (true, false), "heard while it was tested ashore");
    assert_eq!(with(None, after), (true, false));
    assert_eq!(with(None, None), (true, true));
}

#[test]
fn an_unknown_format_is_told_with_those_that_there_are() {
    let told = format("vemco").unwrap_err();
    assert!(told.starts_with("`vemco` is not a format; there are lutra, vue, fathom, thelma"), "{told}");
}
