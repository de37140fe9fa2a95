//! Messages of every kind: known and unknown, old and new, nested, damaged, without a believable time.

use crate::support::{OTTER, START_US, accept, packet, temperature, utc};
use detections::{Detection, Origin, Protocol};
use imc::catalogue::{self, FieldKind, MESSAGES};
use imc::messages::{LogBookEntry, LogBookEntryType, PowerChannelState, TBRFishTag, Temperature};
use imc::{Header, PacketView};
use store::{Cell, Order, Page, Reader, Source, Store, TimeRange, Transport};

fn header(time_us: i64) -> Header {
    Header { timestamp: utc(time_us).seconds(), src: OTTER, src_ent: 9, ..Header::default() }
}

/// A packet of any id with any payload, in the byte order of the sync number.
fn raw(big: bool, id: u16, header: &Header, payload: &[u8]) -> Vec<u8> {
    let size = payload.len() as u16;
    let mut bytes = Vec::new();
    let mut put = |le: &[u8]| if big { bytes.extend(le.iter().rev()) } else { bytes.extend(le) };
    put(&imc::SYNC.to_le_bytes());
    put(&id.to_le_bytes());
    put(&size.to_le_bytes());
    put(&header.timestamp.to_le_bytes());
    put(&header.src.0.to_le_bytes());
    put(&[header.src_ent]);
    put(&header.dst.0.to_le_bytes());
    put(&[header.dst_ent]);
    bytes.extend_from_slice(payload);
    let crc = imc::crc16(&bytes).to_le_bytes();
    if big {
        bytes.extend(crc.iter().rev());
    } else {
        bytes.extend(crc);
    }
    bytes
}

fn source(entity: u8, message: &str) -> Source {
    Source { system: OTTER, entity, message: message.to_owned() }
}

#[test]
fn every_flat_message_of_the_catalogue_is_stored() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let flat = |field: &catalogue::FieldDesc| !matches!(field.kind, FieldKind::Message | FieldKind::List);
    let flat: Vec<_> = MESSAGES.iter().filter(|desc| desc.fields.iter().all(flat)).collect();
    assert!(flat.len() > 250);
    for desc in &flat {
        let bytes = raw(false, desc.id, &header(START_US), &vec![0; desc.min_bytes()]);
        accept(&mut store, &bytes, START_US, Transport::Tcp);
    }
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    for desc in flat {
        let fields: Vec<&str> = desc.fields.iter().map(|field| field.abbrev).collect();
        let rows =
            reader.rows(&source(9, desc.abbrev), &fields, TimeRange::ALL, Page::first(10)).unwrap().items;
        assert_eq!(rows.len(), 1, "{}", desc.abbrev);
        assert!(!rows[0].cells.contains(&Cell::Nothing), "{}: {rows:?}", desc.abbrev);
    }
}

#[test]
fn nested_messages_are_the_json_of_the_protocol() {
    let Some(recording) = testkit::shared("data/imc/dune_capture_a.imc.gz") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    store.import(std::slice::from_ref(&recording), utc(START_US), &mut |_| true).unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let mut log = imc::lsf::LogReader::open(&recording).unwrap();
    let mut compared = 0;
    while let Some(item) = log.next_item().unwrap() {
        let imc::lsf::LogItem::Packet { view, .. } = item else { continue };
        let desc = catalogue::by_id(view.id()).unwrap();
        let nested =
            desc.fields.iter().filter(|one| matches!(one.kind, FieldKind::Message | FieldKind::List));
        for field in nested {
            let mut text = Vec::new();
            imc::json::write_packet(&mut text, &view, imc::ShortPayload::default()).unwrap();
            let expected =
                &serde_json::from_slice::<serde_json::Value>(&text).unwrap()["fields"][field.abbrev];
            let time_us = view.header().time().unwrap().micros();
            let range = TimeRange { from_us: time_us, to_us: time_us + 1 };
            let source =
                Source { system: view.src(), entity: view.src_ent(), message: desc.abbrev.to_owned() };
            let rows = reader.rows(&source, &[field.abbrev], range, Page::first(100)).unwrap().items;
            let found = rows.iter().any(|row| match &row.cells[0] {
                Cell::Text(text) => serde_json::from_str::<serde_json::Value>(text).unwrap() == *expected,
                Cell::Nothing => expected.is_null(),
                _ => false,
            });
            assert!(found, "{} {}: {expected} is not in {rows:?}", desc.abbrev, field.abbrev);
            compared += 1;
        }
    }
    assert!(compared > 10, "{compared}");
}

#[test]
fn unknown_and_damaged_messages_are_kept_raw_and_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let unknown = raw(false, 3_999, &header(START_US), b"whatever");
    // Half of a field: no sender's layout.
    let damaged = raw(false, 263, &header(START_US), &[1, 2]);
    for _ in 0..2 {
        accept(&mut store, &unknown, START_US, Transport::Tcp);
        accept(&mut store, &damaged, START_US, Transport::Tcp);
        store.commit().unwrap();
    }
    let connection = rusqlite::Connection::open(folder.path().join("history/2026-11.sqlite")).unwrap();
    let mut rows = connection.prepare("SELECT id,payload,problem FROM _raw ORDER BY id").unwrap();
    let rows: Vec<(u16, Vec<u8>, String)> = rows
        .query_map((), |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!((rows[0].0, rows[0].1.as_slice(), rows.len()), (263, [1, 2].as_slice(), 2));
    assert!(rows[0].2.contains("past the end"), "{}", rows[0].2);
    assert_eq!(rows[1].1, b"whatever");
    let series = Reader::open(folder.path()).unwrap().series(None).unwrap();
    assert_eq!(series.iter().map(|one| (one.group.id, one.extent.count)).collect::<Vec<_>>(), [(3_999, 1)]);
}

#[test]
fn big_endian_senders_and_strange_values_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let big = raw(true, 263, &header(START_US), &8.5_f32.to_be_bytes());
    assert_eq!(PacketView::new(&big).unwrap().order(), imc::ByteOrder::Big);
    accept(&mut store, &big, START_US, Transport::Tcp);
    for (second, value) in [(1, f32::NAN), (2, f32::INFINITY), (3, f32::MIN_POSITIVE)] {
        let time_us = START_US + second * 1_000_000;
        accept(&mut store, &packet(time_us, 9, &Temperature { value }), START_US, Transport::Tcp);
    }
    let name = imc::Text::from_bytes([b'a', 0, 0xFF]);
    let channel = PowerChannelState { name, ..PowerChannelState::default() };
    accept(&mut store, &packet(START_US, 9, &channel), START_US, Transport::Tcp);
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let cells = |reader: &mut Reader, message, field| -> Vec<Cell> {
        let rows = reader.rows(&source(9, message), &[field], TimeRange::ALL, Page::first(10)).unwrap().items;
        rows.into_iter().flat_map(|row| row.cells).collect()
    };
    let values = cells(&mut reader, "Temperature", "value");
    assert!(matches!(values[1], Cell::Real(value) if value.is_nan()), "{values:?}");
    let others = [Cell::Real(8.5), Cell::Real(f64::INFINITY), Cell::Real(f32::MIN_POSITIVE.into())];
    assert_eq!([values[0].clone(), values[2].clone(), values[3].clone()], others);
    assert_eq!(cells(&mut reader, "PowerChannelState", "name"), [Cell::Raw(vec![b'a', 0, 0xFF])]);
    let buckets = reader.buckets(&source(9, "Temperature"), "value", TimeRange::ALL, 1).unwrap();
    assert_eq!((buckets.buckets[0].count, buckets.buckets[0].max), (2, 8.5), "infinity draws no line");
}

#[test]
fn times_that_cannot_be_are_kept_apart_and_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let not_a_time = raw(false, 263, &Header { timestamp: f64::NAN, ..header(0) }, &1.0_f32.to_le_bytes());
    for received_us in [START_US, START_US + 40 * 86_400_000_000] {
        accept(&mut store, &not_a_time, received_us, Transport::Tcp);
        accept(&mut store, &temperature(12_000_000, 2.0), received_us, Transport::Tcp);
        accept(&mut store, &temperature(START_US * 4, 3.0), received_us, Transport::Tcp);
        accept(&mut store, &temperature(START_US, 4.0), received_us, Transport::Tcp);
        store.commit().unwrap();
    }
    store.settle().unwrap();
    assert!(folder.path().join("history/undated.sqlite").exists());
    let mut reader = Reader::open(folder.path()).unwrap();
    let all = reader.samples(&source(5, "Temperature"), &["value"], TimeRange::ALL, 10).unwrap();
    assert_eq!(all.values[0], [2.0, 4.0, 3.0], "by the time that was stated");
    let nan = reader.samples(&source(9, "Temperature"), &["value"], TimeRange::ALL, 10).unwrap();
    assert_eq!((nan.time_us, nan.values[0].clone()), (vec![store::NO_TIME_US], vec![1.0]));
    let dated = TimeRange::new(Some(utc(START_US - 1)), Some(utc(START_US + 1)));
    assert_eq!(reader.samples(&source(5, "Temperature"), &["value"], dated, 10).unwrap().values[0], [4.0]);
    let last = reader.last_row(&source(5, "Temperature"), &["value"], dated).unwrap().unwrap();
    assert_eq!((last.time, last.received, last.cells), (utc(START_US), utc(START_US), vec![Cell::Real(4.0)]));
}

#[test]
fn detections_of_both_sizes_and_log_books_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let tag = TBRFishTag {
        serial_no: 1_024,
        unix_timestamp: 1_795_248_000,
        millis: 250,
        trans_id: 77,
        snr: 30,
        lat: Some(1.0),
        lon: Some(0.25),
        ..TBRFishTag::default()
    };
    let new = packet(START_US + 2_000_000, 9, &tag);
    // As in 2019: without a position.
    let view = PacketView::new(&new).unwrap();
    let old = raw(false, 2_007, &header(START_US + 1_000_000), &view.payload()[..21]);
    let entry = LogBookEntry {
        r#type: LogBookEntryType::Warning,
        htime: utc(START_US).seconds(),
        context: "Motor".into(),
        text: "hot".into(),
    };
    for packet in [&new, &old, &packet(START_US, 3, &entry)] {
        accept(&mut store, packet, START_US, Transport::Tcp);
    }
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let heard = reader.detections(None, TimeRange::ALL, None, Order::Oldest, Page::first(10)).unwrap().items;
    let places: Vec<_> =
        heard.iter().map(|one| one.pose.map(|pose| (pose.place.lat_rad(), pose.place.lon_rad()))).collect();
    assert_eq!(places, [None, Some((1.0, 0.25))]);
    let one = &heard[1];
    assert_eq!((one.clock.utc(), one.receiver), (Some(utc(START_US + 250_000)), 1_024));
    assert_eq!((one.tag_id, one.snr_db), (77, Some(30)));
    let count = |reader: &mut Reader, system, came, rows| {
        reader.detections(system, TimeRange::ALL, came, Order::Oldest, Page::first(rows)).unwrap().items.len()
    };
    assert_eq!(count(&mut reader, None, None, 1), 1);
    assert_eq!(count(&mut reader, Some(imc::Address(1)), None, 9), 0);
    let book = reader.log_book(Some(OTTER), TimeRange::ALL, Order::Oldest, Page::first(10)).unwrap().items;
    assert_eq!(book.len(), 1);
    assert_eq!((book[0].kind_name.as_deref(), book[0].text.as_str()), (Some("WARNING"), "hot"));
    assert_eq!(book[0].written, Some(utc(START_US)));
}

#[test]
fn what_two_messages_tell_of_a_detection_is_one_on_every_page() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let mut accept_both = |number: u16, arrived_us: i64| {
        // Several of one moment.
        let time_us = START_US + i64::from(number / 3) * 1_000_000;
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: 1_795_248_000,
            millis: number,
            trans_protocol: imc::messages::TBRFishTagTransProtocol::R64K,
            trans_id: 77,
            ..TBRFishTag::default()
        };
        let origin = Origin { system: OTTER, entity: 9, reported: utc(time_us), received: None };
        let mut whole = Detection::from_fish_tag(origin, &tag);
        whole.raw = Some(format!("line {number}"));
        if number % 5 == 4 {
            whole.protocol = Protocol::named("OPi");
        }
        accept(&mut store, &packet(time_us, 9, &whole.report()), arrived_us + 1, Transport::Tcp);
        if let Some(tag) = whole.fish_tag() {
            accept(&mut store, &packet(time_us, 9, &tag), arrived_us, Transport::Tcp);
        }
    };
    for number in 0..20 {
        accept_both(number, START_US + i64::from(number) * 1_000_000);
    }
    let other = imc::messages::Event { topic: "Dive".into(), data: "receiver=1".into() };
    accept(&mut store, &packet(START_US, 9, &other), START_US, Transport::Tcp);
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let mut ask = |range, came, order, page| reader.detections(None, range, came, order, page).unwrap();
    let all = ask(TimeRange::ALL, None, Order::Oldest, Page::first(100));
    assert_eq!((all.items.len(), all.next), (20, None));
    assert!(all.items.iter().all(|one| one.raw == Some(format!("line {}", one.clock.millis))));
    assert_eq!(all.items.iter().filter(|one| one.protocol.name() == Some("OPi")).count(), 4);
    assert_eq!(all.items[0].origin.received, Some(utc(START_US)), "the earlier of both");
    for rows in [1, 2, 7] {
        let (mut found, mut range, mut skip) = (Vec::new(), TimeRange::ALL, 0);
        loop {
            let page = ask(range, None, Order::Newest, Page { skip, rows, bytes: 1_000 });
            found.extend(page.items);
            let Some(next) = page.next else { break };
            (range.to_us, skip) = (next.time_us + 1, next.skip);
        }
        found.reverse();
        assert_eq!(found, all.items, "{rows} rows");
    }
    let came = Some(utc(START_US + 17_000_000));
    let late = ask(TimeRange::ALL, came, Order::Oldest, Page::first(100)).items;
    assert_eq!(late.iter().map(|one| one.clock.millis).collect::<Vec<_>>(), [17, 18, 19]);
}

#[test]
fn pages_together_hold_everything_once_and_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    // Two entities, often at the same time, across the end of a month.
    let month_end_us = utc("2026-12-01T00:00:00Z".parse::<units::UtcTime>().unwrap().micros()).micros();
    for number in 0..40_u8 {
        let entry = LogBookEntry { text: format!("{number:03}").into(), ..LogBookEntry::default() };
        let time_us = month_end_us + i64::from(number / 7) * 1_000_000 - 3_000_000;
        accept(&mut store, &packet(time_us, 3 + number % 2, &entry), time_us, Transport::Tcp);
    }
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let all = reader.log_book(None, TimeRange::ALL, Order::Oldest, Page::first(100)).unwrap();
    assert_eq!((all.items.len(), all.next), (40, None));
    assert!(all.items.is_sorted_by_key(|entry| (entry.sent, entry.entity)));
    for (rows, bytes) in [(1, 1_000), (3, 1_000), (16, 1_000), (100, 1), (100, 10)] {
        let mut found = Vec::new();
        let (mut range, mut skip) = (TimeRange::ALL, 0);
        loop {
            let page = reader.log_book(None, range, Order::Oldest, Page { skip, rows, bytes }).unwrap();
            assert!(!page.items.is_empty() && page.items.len() <= rows.min(bytes.div_ceil(3)));
            found.extend(page.items);
            let Some(next) = page.next else { break };
            (range.from_us, skip) = (next.time_us, next.skip);
        }
        assert_eq!(found, all.items, "{rows} rows, {bytes} bytes");
        let mut back = Vec::new();
        let (mut range, mut skip) = (TimeRange::ALL, 0);
        loop {
            let page = reader.log_book(None, range, Order::Newest, Page { skip, rows, bytes }).unwrap();
            assert!(!page.items.is_empty() && page.items.len() <= rows.min(bytes.div_ceil(3)));
            back.extend(page.items);
            let Some(next) = page.next else { break };
            (range.to_us, skip) = (next.time_us + 1, next.skip);
        }
        back.reverse();
        assert_eq!(back, all.items, "the newest first: {rows} rows, {bytes} bytes");
        let one =
            reader.rows(&source(3, "LogBookEntry"), &["text"], TimeRange::ALL, Page { skip: 2, rows, bytes });
        let texts = all.items.iter().filter(|entry| entry.entity == 3).map(|entry| &entry.text);
        let read = one.unwrap().items;
        assert!(read.iter().filter_map(|row| row.cells[0].as_text()).eq(texts.skip(2).take(read.len())));
    }
}

#[test]
fn absurd_times_do_not_stretch_what_is_dated() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for time_us in [1_000_000, START_US, START_US + 2_000_000] {
        let temperature = imc::messages::Temperature { value: 4.0 };
        accept(&mut store, &packet(time_us, 9, &temperature), START_US, Transport::Tcp);
    }
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let series = reader.series(None).unwrap().remove(0);
    assert_eq!((series.extent.count, series.extent.first_us), (3, 1_000_000));
    assert_eq!((series.dated.count, series.dated.first_us, series.period_s()), (2, START_US, Some(2.0)));
    // However absurd the range.
    for range in [TimeRange::ALL, TimeRange { from_us: i64::MIN + 1, to_us: i64::MAX - 1 }] {
        let buckets = reader.buckets(&source(9, "Temperature"), "value", range, 10).unwrap().buckets;
        assert_eq!(buckets.iter().map(|bucket| bucket.count).sum::<u64>(), 2, "{range:?}");
    }
}

/// Newer DUNE says ValidatePlan by the id of TBRFishTag: its type, and a plan within.
#[test]
fn a_plan_of_a_newer_dune_makes_no_fish() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    let mut plan = vec![0];
    plan.extend(551_u16.to_le_bytes());
    plan.extend([0; 300]);
    for (at, payload) in [&plan[..], &plan[..3], &[0; 36], &[0; 38]].into_iter().enumerate() {
        let time_us = START_US + at as i64 * 1_000_000;
        accept(&mut store, &raw(false, 2007, &header(time_us), payload), time_us, Transport::Tcp);
    }
    let tag = raw(false, 2007, &header(START_US + 9_000_000), &[1; 37]);
    accept(&mut store, &tag, START_US, Transport::Tcp);
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let tags =
        reader.rows(&source(9, "TBRFishTag"), &["serial_no"], TimeRange::ALL, Page::first(10)).unwrap();
    assert_eq!(tags.items.len(), 1, "the one that is as long as a tag");
    let found = reader.detections(None, TimeRange::ALL, None, Order::Oldest, Page::first(10)).unwrap();
    assert_eq!(found.items.len(), 1);
    // Its bytes are kept, with the reason.
    let connection = rusqlite::Connection::open(folder.path().join("history/2026-11.sqlite")).unwrap();
    let mut rows = connection.prepare("SELECT problem FROM _raw WHERE id=2007").unwrap();
    let problems: Vec<String> = rows.query_map((), |row| row.get(0)).unwrap().map(Result::unwrap).collect();
    let is_said =
        |problem: &String| problem.contains("is not that of TBRFishTag: another message has this id");
    assert!(problems.len() == 4 && problems.iter().all(is_said), "{problems:?}");
}
