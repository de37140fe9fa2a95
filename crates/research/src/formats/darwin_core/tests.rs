use super::super::tests::{START_S, bare, bytes, study, whole};
use super::super::{About, Writer, format, unzipped};
use super::*;
use crate::Limits;
use crate::lag::Lag;
use crate::study::Study;
use api::DatasetAuthor;
use detections::{Detection, Origin, ReceiverClock};
use std::collections::BTreeMap;
use units::UtcTime;

/// The same animal, so many seconds after the first detection.
fn after_s(second: u32) -> Detection {
    let reported = UtcTime::from_micros(i64::from(START_S + second) * 1_000_000 + 1);
    Detection {
        clock: ReceiverClock::read(START_S + second, 7),
        origin: Origin { reported, ..whole().origin },
        raw: None,
        ..whole()
    }
}

fn archive(name: &str, study: &Study, all: &[Detection]) -> BTreeMap<String, String> {
    let all: Vec<_> = all.iter().map(|one| (one.clone(), None)).collect();
    unzipped(&bytes(format(name).unwrap(), study, &all)).into_iter().collect()
}

/// The rows of a table, each by the names of its columns; no cell of these has a comma.
fn table(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    lines.map(|cells| header.iter().cloned().zip(cells).collect()).collect()
}

/// A table as `meta.xml` has it: its element, its file, the column of its key, and the term of each column.
type Table = (String, String, usize, Vec<String>);

fn described(meta: &str) -> Vec<Table> {
    let mut reader = quick_xml::Reader::from_str(meta);
    let (mut tables, mut is_location): (Vec<Table>, bool) = (Vec::new(), false);
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Start(tag) => match tag.name().as_ref() {
                name @ ("core" | "extension") => {
                    tables.push((name.to_owned(), String::new(), 0, Vec::new()));
                }
                name => is_location = name == "location",
            },
            quick_xml::events::Event::Text(text) if is_location => {
                tables.last_mut().unwrap().1.push_str(&text);
            }
            quick_xml::events::Event::End(_) => is_location = false,
            quick_xml::events::Event::Empty(tag) => {
                let of = |wanted: &str| {
                    let mut found = tag.attributes().map(Result::unwrap);
                    found.find(|one| one.key.as_ref() == wanted).map(|one| one.value.into_owned())
                };
                let at: usize = of("index").unwrap().parse().unwrap();
                let table = tables.last_mut().unwrap();
                match tag.name().as_ref() {
                    "id" | "coreid" => table.2 = at,
                    name => {
                        assert_eq!((name, at), ("field", table.3.len()), "columns in order");
                        table.3.push(of("term").unwrap());
                    }
                }
            }
            quick_xml::events::Event::Eof => return tables,
            _ => {}
        }
    }
}

#[test]
fn what_meta_says_of_the_tables_is_what_they_are() {
    let files = archive("dwca", &study(), &[after_s(0), after_s(4_000)]);
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(names, ["eml.xml", "extendedmeasurementorfact.csv", "meta.xml", "occurrence.csv"]);
    let tables = described(&files["meta.xml"]);
    let elements: Vec<&str> = tables.iter().map(|table| &*table.0).collect();
    assert_eq!(elements, ["core", "extension"]);
    for (_, file, key, terms) in &tables {
        let header: Vec<&str> = files[file].lines().next().unwrap().split(',').collect();
        let ends: Vec<&str> = terms.iter().map(|term| term.rsplit('/').next().unwrap()).collect();
        assert_eq!(ends, header, "{file}");
        assert_eq!(header[*key], "occurrenceID", "{file}");
    }
    let occurrences = table(&files["occurrence.csv"]);
    let facts = table(&files["extendedmeasurementorfact.csv"]);
    assert_eq!(occurrences.len(), 2);
    let ids: Vec<&String> = occurrences.iter().map(|row| &row["occurrenceID"]).collect();
    assert!(facts.iter().all(|fact| ids.contains(&&fact["occurrenceID"])), "{facts:?}");
    let told: Vec<(&str, &str, &str)> = facts
        .iter()
        .map(|fact| (&*fact["measurementType"], &*fact["measurementValue"], &*fact["measurementUnit"]))
        .collect();
    assert_eq!(
        told,
        [
            ("signal to noise ratio", "25", "dB"),
            ("depth", "8.4", "m"),
            ("length", "512", "mm"),
            ("weight", "1340", "g"),
            ("signal to noise ratio", "25", "dB"),
            ("depth", "8.4", "m"),
        ],
        "an animal is measured once"
    );
}

#[test]
fn of_an_hour_the_first_detection_stays_and_says_of_how_many() {
    // 08:00:00, 08:30:00 and 08:59:59 are one hour; 09:00:00 is the next; what has no place or animal is none.
    let all = [after_s(0), bare(), after_s(1_800), after_s(3_599), after_s(3_600)];
    let files = archive("dwca", &study(), &all);
    let rows = table(&files["occurrence.csv"]);
    let told = |rows: &[BTreeMap<String, String>]| -> Vec<(String, String)> {
        rows.iter().map(|row| (row["eventDate"].clone(), row["dataGeneralizations"].clone())).collect()
    };
    let first_of = |time: &str, of: u32| {
        (format!("2026-11-21T{time}.007Z"), format!("subsampled by hour: first of {of} record(s)"))
    };
    assert_eq!(told(&rows), [first_of("08:00:00", 3), first_of("09:00:00", 1)]);
    // What the table alone has stands in the archive of all, to the byte.
    let every = archive("dwca-all", &study(), &all);
    let alone: Vec<_> = all.iter().map(|one| (one.clone(), None)).collect();
    let alone = String::from_utf8(bytes(format("darwin-core").unwrap(), &study(), &alone)).unwrap();
    assert_eq!(every["occurrence.csv"], alone);
    assert_eq!(alone.lines().count(), 5);
}

#[test]
fn the_first_of_an_hour_is_the_one_that_was_heard_first() {
    // Heard at 08:40, 08:10 and 08:20, reported in this order.
    let late =
        |heard_s: u32, reported_s: u32| Detection { clock: after_s(heard_s).clock, ..after_s(reported_s) };
    let files = archive("dwca", &study(), &[late(2_400, 0), late(600, 1), late(1_200, 2)]);
    let rows = table(&files["occurrence.csv"]);
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0]["eventDate"], "2026-11-21T08:10:00.007Z");
    assert_eq!(rows[0]["dataGeneralizations"], "subsampled by hour: first of 3 record(s)");
    let facts = table(&files["extendedmeasurementorfact.csv"]);
    let of_row = facts.iter().all(|fact| fact["occurrenceID"] == rows[0]["occurrenceID"]);
    let kinds: Vec<&str> = facts.iter().map(|fact| &*fact["measurementType"]).collect();
    assert!(of_row && kinds == ["signal to noise ratio", "depth", "length", "weight"], "{facts:?}");
}

#[test]
fn an_hour_is_closed_two_hours_later_or_when_too_many_are_open() {
    let study = study();
    let mut hours = hours::Hours::default();
    let row = |of| hours::Row { of, ..hours::Row::default() };
    let (first, soon, late) = (after_s(0), after_s(7_200), after_s(7_202));
    let heard = |one| study.heard(one, "otter-1", Lag::Unknown);
    hours.open(&heard(&first), row(1));
    assert!(hours.count(&heard(&first)).is_some() && hours.next(Some(&heard(&soon))).is_none());
    assert_eq!(hours.next(Some(&heard(&late))).map(|row| row.of), Some(2));
    assert!(hours.count(&heard(&first)).is_none(), "it is closed");
    for hour in 0..=10_000_u32 {
        // Reported at once, heard in hours of their own.
        let clock = ReceiverClock::read(START_S + 3_600 * hour, 0);
        let one = Detection { clock, ..first.clone() };
        hours.open(&study.heard(&one, "otter-1", Lag::Unknown), row(u64::from(hour)));
    }
    assert_eq!(hours.next(Some(&heard(&first))).map(|row| row.of), Some(0), "the oldest makes room");
    assert!(hours.next(Some(&heard(&first))).is_none());
    assert!(hours.next(None).is_some(), "the end closes all");
}

#[test]
fn coarse_places_stay_coarse_and_are_said_to_be() {
    let coarse = study().without_places(1_000);
    let limits = Limits::new(&[], "", Some(1_000), false).unwrap();
    let exact = after_s(0);
    let given = limits.given(&coarse.heard(&exact, "otter-1", Lag::Unknown)).unwrap().into_owned();
    let lat = |one: &Detection| format!("{:.8}", one.pose.unwrap().place.lat_deg());
    let files = archive("dwca", &coarse, std::slice::from_ref(&given));
    let rows = table(&files["occurrence.csv"]);
    assert_eq!(rows[0]["decimalLatitude"], lat(&given));
    assert_ne!(lat(&exact), lat(&given));
    assert!(files.values().all(|text| !text.contains(&lat(&exact))), "in no file of the archive");
    let said = "subsampled by hour: first of 1 record(s); places are middles of cells of about 1000 m";
    assert_eq!(rows[0]["dataGeneralizations"], said);
    assert_eq!(rows[0]["locality"], "");
    assert!(files["eml.xml"].contains("each is the middle of a fixed cell of about 1000 m"));
}

fn eml_of(about: &About, study: &Study, all: &[Detection]) -> String {
    let spool = Box::new(std::io::Cursor::new(Vec::new()));
    let mut writer = Writer::new(format("dwca").unwrap(), Dialect::Plain).with_spool(spool);
    let mut out = Vec::new();
    writer.header(&mut out).unwrap();
    for one in all {
        writer.row(&mut out, &study.heard(one, "otter-1", Lag::Unknown)).unwrap();
    }
    writer.end(&mut out, study, about).unwrap();
    let mut files: BTreeMap<String, String> = unzipped(&out).into_iter().collect();
    files.remove("eml.xml").unwrap()
}

#[test]
fn the_description_names_people_licence_and_extent_and_is_whole_xml() {
    let about = About {
        title: "Salmon & <trout>".to_owned(),
        summary: "First.\n\nSecond.".to_owned(),
        creators: vec![DatasetAuthor {
            name: "Kari Nordmann".to_owned(),
            orcid: "0000-0002-1825-0097".to_owned(),
            affiliation: "NTNU".to_owned(),
        }],
        licence: "CC-BY-4.0".to_owned(),
        citation: "Nordmann, K. (2026)".to_owned(),
        published_us: Some(i64::from(START_S) * 1_000_000),
        ..About::default()
    };
    let text = eml_of(&about, &study(), &[after_s(0), after_s(90_000)]);
    for part in [
        "<title>Salmon &amp; &lt;trout&gt;</title>",
        "<creator><individualName><givenName>Kari</givenName><surName>Nordmann</surName></individualName>\
         <organizationName>NTNU</organizationName>",
        "<pubDate>2026-11-21</pubDate>",
        "<abstract><para>First.</para><para>Second.</para></abstract>",
        "<intellectualRights><para>CC-BY-4.0</para></intellectualRights>",
        "<westBoundingCoordinate>-10.40000000</westBoundingCoordinate>",
        "<beginDate><calendarDate>2026-11-21</calendarDate></beginDate><endDate><calendarDate>2026-11-22</calendarDate>",
        "<taxonRankValue>Salmo salar</taxonRankValue>",
        "<citation>Nordmann, K. (2026)</citation>",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    for text in [text, eml_of(&About::default(), &Study::default(), &[])] {
        let mut reader = quick_xml::Reader::from_str(&text);
        let mut depth = 0;
        loop {
            match reader.read_event().unwrap() {
                quick_xml::events::Event::Start(_) => depth += 1,
                quick_xml::events::Event::End(_) => depth -= 1,
                quick_xml::events::Event::Eof => break,
                _ => {}
            }
        }
        assert_eq!(depth, 0);
    }
    let turned = DatasetAuthor { name: "Nordmann, Kari Anne".to_owned(), ..DatasetAuthor::default() };
    let turned = About { creators: vec![turned], ..About::default() };
    let turned = eml_of(&turned, &study(), &[after_s(0)]);
    let names = "<givenName>Kari Anne</givenName><surName>Nordmann</surName>";
    assert!(turned.contains(names), "the family name stands first: {turned}");
    let of_register = eml_of(&About::default(), &study(), &[after_s(0)]);
    assert!(of_register.contains("<surName>Nordmann</surName>"), "who leads the project: {of_register}");
    let of_nobody = eml_of(&About::default(), &Study::default(), &[]);
    assert!(of_nobody.contains("<positionName>not named in the register</positionName>"), "{of_nobody}");
}

#[test]
fn without_a_place_to_wait_in_it_is_an_error() {
    let mut writer = Writer::new(format("dwca").unwrap(), Dialect::Plain);
    assert!(writer.header(&mut Vec::new()).is_err());
}
