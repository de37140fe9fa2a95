//! One dialect of CSV: what a table says of a value, and that a log's tables are those of the store.

use crate::support::{OTTER, START_US, accept, packet, packet_of, utc};
use imc::catalogue::{FieldKind, MESSAGES, MessageDesc};
use imc::json::{self, ReadDefaults};
use imc::lsf::{LogItem, LogReader};
use imc::messages::{
    EntityList, EntityListOp, EulerAngles, LogBookEntry, Payload as _, Rpm, TBRFishTag, Temperature,
};
use imc::names::Names;
use imc::{Address, Header, PacketView};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use store::{CsvOptions, Reader, Selection, Shape, Store, TimeRange, Transport, export_csv};
use tables::{Dialect, Format, PacketRow, Style};

pub(crate) fn table(folder: &Path, selection: &Selection, options: CsvOptions) -> String {
    let mut out = Vec::new();
    export_csv(folder, selection, &options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

pub(crate) fn messages(names: &[&str]) -> Selection {
    Selection { messages: names.iter().map(|name| (*name).to_owned()).collect(), ..Selection::default() }
}

pub(crate) fn stored(packets: &[Vec<u8>]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for packet in packets {
        accept(&mut store, packet, START_US, Transport::Tcp);
    }
    store.close().unwrap();
    folder
}

/// A packet of any bytes as payload.
pub(crate) fn packet_with(desc: &MessageDesc, timestamp: f64, payload: &[u8]) -> Vec<u8> {
    let header = Header { timestamp, src: OTTER, src_ent: 9, dst: Address(0x4001), dst_ent: 3 };
    let body = imc::Body::Unknown { id: desc.id, payload: payload.to_vec() };
    imc::Packet { body, ..imc::Packet::new(header, Temperature::default()) }.encode().unwrap()
}

/// A payload of a message with values of `entropy`.
pub(crate) fn payload(desc: &MessageDesc, entropy: &mut dyn Iterator<Item = u8>, depth: u8) -> Vec<u8> {
    let mut out = Vec::new();
    let mut byte = || entropy.next().unwrap_or_default();
    for field in desc.fields {
        match field.kind {
            FieldKind::Text | FieldKind::Raw => {
                let bytes: Vec<u8> =
                    (0..byte() % 9).map(|_| b"\\x4a\xE6\0=\"\n;,"[usize::from(byte() % 11)]).collect();
                out.extend((bytes.len() as u16).to_le_bytes());
                out.extend(bytes);
            }
            FieldKind::Message if depth > 0 || byte() % 2 == 0 => out.extend([0xFF, 0xFF]),
            FieldKind::Message => {
                out.extend(LogBookEntry::ID.to_le_bytes());
                let nested = imc::catalogue::by_id(LogBookEntry::ID).unwrap();
                out.extend(payload(nested, &mut std::iter::from_fn(|| Some(byte())), depth + 1));
            }
            FieldKind::List => out.extend([0, 0]),
            // A NaN, an infinity, a whole number or any bits.
            FieldKind::F32 => out.extend(match byte() % 4 {
                0 => f32::NAN.to_le_bytes(),
                1 => f32::NEG_INFINITY.to_le_bytes(),
                2 => f32::from(byte()).to_le_bytes(),
                _ => [byte(), byte(), byte(), byte()],
            }),
            FieldKind::F64 => out.extend(match byte() % 4 {
                0 => f64::NAN.to_le_bytes(),
                1 => f64::INFINITY.to_le_bytes(),
                2 => f64::from(byte()).to_le_bytes(),
                _ => std::array::from_fn(|_| byte()),
            }),
            kind => out.extend((0..kind.width().unwrap()).map(|_| byte())),
        }
    }
    out
}

/// The table that a log's packets make.
fn table_of_log(desc: &'static MessageDesc, packets: &[Vec<u8>]) -> String {
    let mut names = Names::default();
    let mut rows = PacketRow::new(Format::default());
    let fields = tables::fields(desc, Style::default());
    let mut out = Vec::new();
    for packet in packets {
        let view = PacketView::new(packet).unwrap();
        names.hear(&view, view.header().time().map_or(i64::MIN, units::UtcTime::micros));
        rows.write(&mut out, &view, (desc, &fields), &names).unwrap();
    }
    String::from_utf8(out).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: testkit::so_many(40, 400) as u32, ..ProptestConfig::default() })]

    #[test]
    fn a_log_and_the_store_write_the_same_rows(
        at in 0..MESSAGES.len(),
        entropies in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..300), 1..4),
    ) {
        let desc = MESSAGES[at];
        prop_assume!(![2007, 2008, 3, 5, 151].contains(&desc.id));
        let said: Vec<Vec<u8>> = entropies.iter().zip(1..).map(|(entropy, second)| {
            let timestamp = utc(START_US + second * 1_000_000).seconds();
            packet_with(desc, timestamp, &payload(desc, &mut entropy.iter().copied(), 0))
        }).collect();
        let folder = stored(&said);
        let table = table(folder.path(), &messages(&[desc.abbrev]), CsvOptions::default());
        let rows = table.split_once('\n').unwrap().1;
        prop_assert_eq!(rows, table_of_log(desc, &said));
    }

    /// A cell read by the rules in `docs/history.md` gives the value that was sent.
    #[test]
    fn text_and_reals_come_back_from_a_table(text in proptest::collection::vec(any::<u8>(), 0..30), bits: u64) {
        let said = LogBookEntry {
            htime: f64::from_bits(bits),
            text: imc::Text::from_bytes(text.clone()),
            ..LogBookEntry::default()
        };
        let folder = stored(&[packet(START_US, 9, &said)]);
        let selection = Selection { fields: vec!["htime".into(), "text".into()], ..messages(&["LogBookEntry"]) };
        let table = table(folder.path(), &selection, CsvOptions::default());
        let row = cells(table.split_once('\n').unwrap().1);
        let [.., htime, cell] = &row[..] else { panic!("{row:?}") };
        let htime: f64 = htime.parse().unwrap();
        prop_assert!(htime.to_bits() == bits || htime.is_nan() && f64::from_bits(bits).is_nan() || htime == 0.0);
        let cell = cell.strip_prefix('\'').unwrap_or(cell);
        prop_assert_eq!(&*imc::text::unescape(cell), &text[..]);
    }
}

/// The cells of one row by RFC 4180.
fn cells(row: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut letters = row.strip_suffix('\n').unwrap().chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                cells.last_mut().unwrap().push(letters.next().unwrap());
            }
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            letter => cells.last_mut().unwrap().push(letter),
        }
    }
    cells
}

/// Of each message of a recorded log: `imc lsf csv` uses the rows of `PacketRow`.
#[test]
fn a_recorded_log_gives_the_same_tables_by_both_ways() {
    let Some(recording) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    store.import(std::slice::from_ref(&recording), utc(START_US), &mut |_| true).unwrap();
    store.close().unwrap();
    let mut log = LogReader::open(&recording).unwrap();
    let mut packets = Vec::new();
    while let Some(LogItem::Packet { view, .. }) = log.next_item().unwrap() {
        packets.push(view.bytes().to_vec());
    }
    let mut names = Names::default();
    let mut by_message: BTreeMap<u16, Vec<Vec<u8>>> = BTreeMap::new();
    for packet in packets {
        let view = PacketView::new(&packet).unwrap();
        names.hear(&view, view.header().time().unwrap().micros());
        by_message.entry(view.id()).or_default().push(packet);
    }
    assert!(by_message.len() > 30);
    for (id, packets) in by_message {
        let desc = imc::catalogue::by_id(id).unwrap();
        let fields = tables::fields(desc, Style::default());
        let mut rows = PacketRow::new(Format::default());
        let mut lines: Vec<String> = Vec::new();
        for packet in &packets {
            let mut out = Vec::new();
            rows.write(&mut out, &PacketView::new(packet).unwrap(), (desc, &fields), &names).unwrap();
            lines.push(String::from_utf8(out).unwrap());
        }
        // A log may hold a message twice, the history has it once; the order within a microsecond is another.
        lines.sort();
        lines.dedup();
        let table = table(folder.path(), &messages(&[desc.abbrev]), CsvOptions::default());
        let mut exported: Vec<String> = table.split_inclusive('\n').skip(1).map(str::to_owned).collect();
        exported.sort();
        assert_eq!(exported.concat(), lines.concat(), "{}", desc.abbrev);
    }
}

#[test]
fn nan_absent_and_infinite_are_told_apart() {
    let tag =
        TBRFishTag { serial_no: 7, lat: Some(f64::NAN), lon: Some(f64::INFINITY), ..TBRFishTag::default() };
    let whole = packet(START_US + 1_000_000, 9, &tag);
    let of_2019 = &PacketView::new(&whole).unwrap().payload()[..21];
    let desc = imc::catalogue::by_id(TBRFishTag::ID).unwrap();
    let old = packet_with(desc, utc(START_US).seconds(), of_2019);
    let folder = stored(&[whole.clone(), old]);
    let selection = Selection { fields: vec!["lat".into(), "lon".into()], ..messages(&["TBRFishTag"]) };
    let ends = |table: &str| -> Vec<String> {
        table.lines().skip(1).map(|line| line.splitn(9, ',').last().unwrap().to_owned()).collect()
    };
    assert_eq!(ends(&table(folder.path(), &selection, CsvOptions::default())), [",", "NaN,inf"]);
    let long = CsvOptions { shape: Shape::Long, ..CsvOptions::default() };
    assert_eq!(
        ends(&table(folder.path(), &selection, long)),
        ["TBRFishTag,lat,NaN,rad", "TBRFishTag,lon,inf,rad"]
    );
    let mut reader = Reader::open(folder.path()).unwrap();
    let source = store::Source { system: OTTER, entity: 9, message: "TBRFishTag".into() };
    let rows = reader.rows(&source, &["lat", "lon"], TimeRange::ALL, store::Page::first(9)).unwrap().items;
    assert_eq!(rows[0].cells, [store::Cell::Nothing, store::Cell::Nothing]);
    assert!(
        matches!(rows[1].cells[..], [store::Cell::Real(lat), store::Cell::Real(lon)] if lat.is_nan() && lon > 1.0)
    );

    // A month of an earlier version does not know; once it is written to, the later fields count as left out.
    let month = folder.path().join("history/2026-11.sqlite");
    rusqlite::Connection::open(&month).unwrap().execute_batch("DROP TABLE _short").unwrap();
    assert_eq!(ends(&table(folder.path(), &selection, CsvOptions::default())), [",", ",inf"]);
    let mut store = Store::open(folder.path()).unwrap();
    accept(&mut store, &packet(START_US + 2_000_000, 9, &EulerAngles::default()), START_US, Transport::Tcp);
    store.close().unwrap();
    assert_eq!(ends(&table(folder.path(), &selection, CsvOptions::default())), [",", "NaN,inf"]);
}

#[test]
fn a_stamp_that_is_no_time_is_not_1970() {
    let desc = imc::catalogue::by_id(Temperature::ID).unwrap();
    let payload = 8.0_f32.to_le_bytes();
    let stamps = [f64::NAN, f64::INFINITY, 0.0];
    let packets = stamps.map(|stamp| packet_with(desc, stamp, &payload));
    let folder = stored(&packets);
    let all = table(folder.path(), &messages(&["Temperature"]), CsvOptions::default());
    let times: Vec<&str> = all.lines().skip(1).map(|line| line.split(",ntnu").next().unwrap()).collect();
    // The two without a time are equal and are one row.
    assert_eq!(times, [",", "1970-01-01T00:00:00.000000Z,0.000000"]);
    let until = TimeRange::new(None, Some(utc(START_US)));
    let until = Selection { range: until, ..messages(&["Temperature"]) };
    assert_eq!(
        table(folder.path(), &until, CsvOptions::default()).lines().count(),
        2,
        "no time is before nothing"
    );
    let mut store = Store::open(folder.path()).unwrap();
    accept(&mut store, &packet(START_US, 9, &Temperature { value: 8.0 }), START_US, Transport::Tcp);
    store.close().unwrap();
    let systems = Reader::open(folder.path()).unwrap().systems().unwrap();
    assert_eq!(
        (systems[0].extent.first_us, systems[0].extent.count),
        (START_US, 3),
        "nor when it was heard first"
    );
    let mut log = Vec::new();
    store::export_lsf(folder.path(), &Selection::default(), &mut log).unwrap();
    assert!(log.starts_with(&packets.concat()), "the log has them as they came");
}

/// Two motors whose numbers a restart swapped.
fn swapped() -> tempfile::TempDir {
    let at = |second: i64| START_US + second * 1_000_000;
    let list = |text: &str| EntityList { op: EntityListOp::Report, list: text.into() };
    let rpm = |second, entity, value| packet(at(second), entity, &Rpm { value });
    stored(&[
        packet(at(0), 0, &list("Motor - Port=48;Motor - Starboard=49")),
        rpm(1, 48, 100),
        rpm(1, 49, 200),
        packet(at(10), 0, &list("Motor - Starboard=48;Motor - Port=49")),
        rpm(11, 48, 201),
        rpm(11, 49, 101),
        rpm(12, 49, 102),
    ])
}

#[test]
fn a_label_is_that_of_whoever_had_it_then() {
    let folder = swapped();
    let port = Selection { entities: vec!["motor - port".into()], ..messages(&["Rpm"]) };
    let values = |table: &str| -> Vec<String> {
        table.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().to_owned()).collect()
    };
    let exported = table(folder.path(), &port, CsvOptions::default());
    assert_eq!(values(&exported), ["100", "101", "102"]);
    assert!(exported.lines().skip(1).all(|line| line.contains(",Motor - Port,")), "{exported}");
    let size = store::measure_csv(folder.path(), &port, &CsvOptions::default()).unwrap();
    assert_eq!(size.rows, 3);
    let by_number = Selection { entities: vec!["49".into()], ..messages(&["Rpm"]) };
    assert_eq!(values(&table(folder.path(), &by_number, CsvOptions::default())), ["200", "101", "102"]);
    let mut log = Vec::new();
    store::export_lsf(folder.path(), &port, &mut log).unwrap();
    let mut packets = LogReader::new(&log[..]);
    let mut said = Vec::new();
    while let Some(LogItem::Packet { view, .. }) = packets.next_item().unwrap() {
        said.push(imc::decode::<Rpm>(&view).unwrap().unwrap().value);
    }
    assert_eq!(said, [100, 101, 102]);
}

#[test]
fn a_spreadsheet_gets_a_mark_and_its_decimal_sign() {
    let folder = stored(&[packet_of(OTTER, START_US, 5, &Temperature { value: 7.5 })]);
    let of =
        |dialect| table(folder.path(), &messages(&["263"]), CsvOptions { dialect, ..CsvOptions::default() });
    assert_eq!(
        of(Dialect::SpreadsheetComma),
        "\u{FEFF}time;unix_s;system;system_id;entity;entity_id;dst;dst_ent;value [°C]\n\
         2026-11-21T08:00:00.000000Z;1795248000,000000;ntnu-otter-01;0x2810;;5;0xffff;255;7,5\n"
    );
    let point = of(Dialect::SpreadsheetPoint);
    assert_eq!(point.strip_prefix('\u{FEFF}').unwrap(), of(Dialect::Plain));
}

#[test]
fn what_there_is_not_is_refused_with_what_was_meant() {
    let folder = swapped();
    let refused = |selection: Selection| {
        let mut out = Vec::new();
        let csv = export_csv(folder.path(), &selection, &CsvOptions::default(), &mut out).unwrap_err();
        assert!(out.is_empty());
        let log = store::export_lsf(folder.path(), &selection, &mut out).unwrap_err();
        assert_eq!(csv.to_string(), log.to_string());
        csv.to_string()
    };
    let entity = |name: &str| Selection { entities: vec![name.into()], ..messages(&["Rpm"]) };
    let field = |name: &str| Selection { fields: vec![name.into()], ..messages(&["Rpm", "EulerAngles"]) };
    let only = |text: &str| field(text);
    for (selection, told) in [
        (messages(&["Rmp"]), "message: IMC has no message `Rmp`; did you mean `Rpm`"),
        (entity("Moter - Port"), "entity: no entity is called `Moter - Port`; did you mean `Motor - Port`?"),
        (
            entity("Rudder"),
            "entity: no entity is called `Rudder`; there are Motor - Port, Motor - Starboard; or give a number",
        ),
        (only("vaule"), "field: none of Rpm, EulerAngles has a field `vaule`; did you mean `value`?"),
        (
            only("EulerAngle.psi"),
            "field: `EulerAngle.psi`: IMC has no message `EulerAngle`; did you mean `EulerAngles`",
        ),
        (only("EulerAngles.pssi"), "field: EulerAngles has no field `pssi`; did you mean `psi`"),
        (only("Temperature.value"), "field: Temperature is not among the messages asked for"),
        (
            Selection { systems: vec![Address(0x0815)], ..Selection::default() },
            "vessel: nothing is recorded of 0x0815 (0x0815)",
        ),
    ] {
        let text = refused(selection);
        assert!(text.starts_with(told), "{text}");
    }
    let known = BTreeMap::from([(OTTER, vec!["otter".to_owned(), "ntnu-otter-01".to_owned()])]);
    for text in ["Otter", "NTNU-otter-01", "0x2810", "10256", " otter "] {
        assert_eq!(store::system(&known, text).unwrap(), OTTER, "{text}");
    }
    let told = store::system(&known, "oter").unwrap_err().to_string();
    assert_eq!(told, "vessel: nothing is recorded of `oter`; did you mean `otter`?");
    assert_eq!(
        store::system(&known, "2069").unwrap_err().to_string(),
        "vessel: nothing is recorded of `2069`; there are otter (0x2810)"
    );
}

#[test]
fn what_is_left_out_of_tables_is_counted() {
    let desc = imc::catalogue::by_id(TBRFishTag::ID).unwrap();
    let plan = packet_with(desc, utc(START_US).seconds(), &[1, 2, 3]);
    let folder = stored(&[plan, packet(START_US, 5, &Temperature { value: 7.5 })]);
    let mut reader = Reader::open(folder.path()).unwrap();
    let mut count = |selection: &Selection| store::unexplained(&mut reader, selection).unwrap();
    assert_eq!(count(&Selection::default()), 1);
    assert_eq!((count(&messages(&["TBRFishTag"])), count(&messages(&["Temperature"]))), (1, 0));
    let entity = |entity: &str| Selection { entities: vec![entity.into()], ..Selection::default() };
    assert_eq!((count(&entity("9")), count(&entity("8"))), (1, 0));
}

/// Nested messages are JSON of their own, which has its own escapes and is read back by `imc::json`.
#[test]
fn a_cell_of_json_is_json() {
    let nested = r#"{"abbrev":"PlanControl","fields":{"arg":{"abbrev":"LogBookEntry","fields":{"text":"\\xe6","htime":"NaN"}}}}"#;
    let value = serde_json::from_str(nested).unwrap();
    let defaults = ReadDefaults {
        header: Header { timestamp: utc(START_US).seconds(), src: OTTER, ..Header::default() },
        order: None,
    };
    let said = json::read_packet(&value, &defaults).unwrap().encode().unwrap();
    let folder = stored(&[said]);
    let selection = Selection { fields: vec!["arg".into()], ..messages(&["PlanControl"]) };
    let table = table(folder.path(), &selection, CsvOptions::default());
    let row = cells(table.split_once('\n').unwrap().1);
    let cell: serde_json::Value = serde_json::from_str(row.last().unwrap()).unwrap();
    assert_eq!(cell["fields"]["text"], "\\xe6");
    let back = json::message_from_value(&cell).unwrap();
    let imc::Message::LogBookEntry(entry) = back else { panic!("{back:?}") };
    assert_eq!(entry.text.as_bytes(), b"\xe6");
    assert!(entry.htime.is_nan());
}
