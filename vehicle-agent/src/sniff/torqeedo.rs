//! The motors' CAN bus as lines: frames from a candump log, as `ID#DATA`, or from a serial adapter (slcan), also mixed in
//! one input, as each line shows its format.
//!
//! Every frame is one [`Found`] with `what`, `source` and `destination` (addresses in hexadecimal) and its values in SI
//! units; `t` (ISO 8601 UTC, as the log counts) where the line has it, `stamp_s` where the adapter gives the time within its
//! minute.

use super::{Decoder, Found};
use devices::can::{CanFrame, CanId};
use devices::line_splitter::{Line, LineSplitter};
use devices::torqeedo::{CARD, COMPUTER, FULL_THROTTLE, Message, Received};
use devices::{candump, slcan};
use serde_json::{Value, json};

const BELL: u8 = 7;

/// Reads the bus of motors and batteries. It keeps one line, of [`candump::MOST_LINE`] bytes at most.
#[derive(Debug)]
pub(crate) struct Torqeedo {
    lines: LineSplitter,
}

impl Torqeedo {
    /// A new decoder.
    pub(crate) fn new() -> Self {
        Self { lines: LineSplitter::new(&[b'\r', b'\n', BELL], candump::MOST_LINE) }
    }
}

impl Decoder for Torqeedo {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        self.lines.feed(bytes, |line| read_line(line, found));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        self.lines.end(|line| read_line(line, found));
    }
}

/// One line of any of the three forms; empty ones are left out.
fn read_line(line: Line<'_>, found: &mut Vec<Found>) {
    let text = line.bytes.trim_ascii();
    if line.too_long {
        found.push(damaged(line.offset, &candump::LineError::TooLong));
    } else if text.starts_with(b"(") || text.contains(&b'#') {
        found.push(match candump::Entry::parse(text) {
            Ok(entry) => frame(&entry.frame, entry.at.map(|at| ("t", json!(at.to_string())))),
            Err(error) => damaged(line.offset, &error),
        });
    } else if !text.is_empty() {
        found.push(match slcan::Line::parse(text) {
            Ok(answer) => adapter(&answer),
            Err(error) => damaged(line.offset, &error),
        });
    }
    if line.end == Some(BELL) {
        found.push(adapter(&slcan::Line::Refused));
    }
}

fn damaged(offset: u64, error: &dyn std::error::Error) -> Found {
    let error = error.to_string();
    Found { text: format!("byte {offset}: {error}"), json: json!({ "error": error, "offset": offset }) }
}

/// A line of a serial adapter: a frame, or a command or answer.
fn adapter(line: &slcan::Line) -> Found {
    let (answer, text) = match line {
        slcan::Line::Frame { frame: one, stamp_ms } => {
            return frame(one, stamp_ms.map(|ms| ("stamp_s", json!(f64::from(ms) / 1e3))));
        }
        slcan::Line::Done => (json!("done"), "done".to_owned()),
        slcan::Line::Sent => (json!("sent"), "frame sent".to_owned()),
        slcan::Line::Refused => (json!("refused"), "refused".to_owned()),
        slcan::Line::Status(flags) => (json!({ "flags": flags }), format!("flags {flags:02X}")),
        slcan::Line::Version(version) => (json!({ "version": version }), format!("version {version}")),
        slcan::Line::Serial(serial) => (json!({ "serial": serial }), format!("serial number {serial}")),
        slcan::Line::Command(command) => {
            (json!({ "command": command.to_string() }), format!("command {command}"))
        }
    };
    Found { json: json!({ "what": "adapter", "answer": answer }), text: format!("adapter: {text}") }
}

/// One frame, with the time under its key.
fn frame(frame: &CanFrame, time: Option<(&str, Value)>) -> Found {
    let (what, mut fields, words) = match Received::decode(frame) {
        Ok(received) => {
            let (what, mut fields) = message(&received.message, frame);
            let words = words(&what, &fields);
            fields["source"] = address(received.source);
            fields["destination"] = address(received.destination);
            (what, fields, format!("{} -> {}: {words}", name(received.source), name(received.destination)))
        }
        Err(error) => {
            let mut fields = raw(frame);
            // The address is in the same bits of every extended identifier, whatever the rest means.
            if let CanId::Extended(id) = frame.full_id() {
                fields["source"] = address((id >> 8) as u8);
            }
            fields["reason"] = json!(error.to_string());
            ("unread".to_owned(), fields, format!("{error}: {}", hex_text(frame)))
        }
    };
    fields["what"] = json!(what);
    let mut text = words;
    if let Some((key, time)) = time {
        text = format!("{} {text}", time.as_str().map_or_else(|| time.to_string(), str::to_owned));
        fields[key] = time;
    }
    Found { json: fields, text }
}

/// An address as text, as `0xAB`.
fn address(address: u8) -> Value {
    json!(format!("0x{address:02X}"))
}

/// An address for people.
fn name(address: u8) -> String {
    match address {
        CARD => "card".to_owned(),
        COMPUTER => "computer".to_owned(),
        0xFF => "all".to_owned(),
        other => format!("0x{other:02X}"),
    }
}

fn hex_text(frame: &CanFrame) -> String {
    hex::encode_upper(frame.data())
}

/// A frame as it came.
fn raw(frame: &CanFrame) -> Value {
    let mut fields = json!({ "id": frame.full_id().to_string(), "data": hex_text(frame) });
    if frame.is_request() {
        fields["requested_bytes"] = json!(frame.stated_len());
    }
    fields
}

/// Name and fields of a message.
fn message(message: &Message, frame: &CanFrame) -> (String, Value) {
    let (what, fields) = match message {
        Message::Text(text) => ("text", json!({ "text": String::from_utf8_lossy(text.bytes()) })),
        Message::Rail(r) => ("rail", rail(r)),
        Message::Outputs { rail, channels } => ("outputs", outputs(*rail, *channels)),
        Message::OutputSet { rail, channel, on } => {
            ("output_set", json!({ "rail": rail, "channel": channel, "on": on }))
        }
        Message::Uptime { uptime_s, reset_cause } => {
            ("uptime", json!({ "uptime_s": uptime_s, "reset_cause": reset_cause }))
        }
        Message::MotorDrive(drive) => ("motor_drive", motor_drive(drive)),
        Message::MotorSet(throttles) => ("motor_set", motor_set(*throttles)),
        Message::BatteryStatus(status) => ("battery_status", battery_status(status)),
        Message::BatteryControl { battery, master_error, error_count, firmware } => {
            let fields = json!({
                "battery": battery,
                "master_error": master_error,
                "error_count": error_count,
                "firmware": firmware,
            });
            ("battery_control", fields)
        }
        Message::MotorStatus { motor, errors, status } => {
            ("motor_status", json!({ "motor": motor, "errors": errors, "status": status }))
        }
        Message::Id { company, product, serial, firmware } => {
            let fields =
                json!({ "company": company, "product": product, "serial": serial, "firmware": firmware });
            ("id", fields)
        }
        Message::Other(id) => {
            let what = id.name().map_or_else(|| id.number().to_string(), str::to_lowercase);
            return (what, raw(frame));
        }
    };
    (what.to_owned(), fields)
}

/// Fields as `what key value, key value`.
fn words(what: &str, fields: &Value) -> String {
    let fields = fields.as_object().into_iter().flatten();
    let fields: Vec<String> = fields.map(|(key, value)| format!("{key} {value}")).collect();
    format!("{what} {}", fields.join(", "))
}

fn rail(rail: &devices::RailReading) -> Value {
    json!({
        "rail": rail.number,
        "voltage_v": rail.voltage_v,
        "current_a": rail.current_a,
        "fuse_a": rail.fuse_a,
        "flags": rail.flags,
    })
}

/// The channels that are on, by number.
fn outputs(rail: u8, channels: u32) -> Value {
    let on: Vec<u32> = (0..u32::BITS).filter(|channel| channels >> channel & 1 == 1).collect();
    json!({ "rail": rail, "channels_on": on })
}

fn motor_drive(drive: &devices::torqeedo::MotorDrive) -> Value {
    json!({
        "motor": drive.motor,
        "power_w": drive.power_w,
        "temperature_c": drive.temperature_c,
        "motor_rpm": drive.motor_rpm,
        "propeller_rpm": drive.propeller_rpm(),
    })
}

/// Throttles of both motors by number. Which of them is port depends on the vessel's cables.
fn motor_set(per_mille: [i16; 2]) -> Value {
    let [motor_0, motor_1] = per_mille.map(|value| f64::from(value) / f64::from(FULL_THROTTLE));
    json!({ "throttle_0": motor_0, "throttle_1": motor_1 })
}

fn battery_status(status: &devices::torqeedo::BatteryStatus) -> Value {
    let reading = &status.reading;
    json!({
        "battery": reading.number,
        "temperature_c": reading.temperature_c,
        "voltage_v": reading.voltage_v,
        "current_a": reading.current_a,
        "charge_percent": reading.charge_percent,
        "error_number": status.error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::UtcTime;

    fn sniff(pieces: &[&[u8]]) -> Vec<Found> {
        let mut decoder = Torqeedo::new();
        let mut found = Vec::new();
        for piece in pieces {
            decoder.feed(piece, &mut found);
        }
        decoder.end(&mut found);
        found
    }

    fn one(line: &str) -> Value {
        let found = sniff(&[line.as_bytes()]);
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].json.clone()
    }

    /// Values that are both in the test vectors and in the output, by their names in each.
    const SAME: [(&str, &str); 11] = [
        ("voltage_v", "voltage_v"),
        ("current_a", "current_a"),
        ("current_a_signed24", "current_a"),
        ("soc_pct", "charge_percent"),
        ("temperature_c", "temperature_c"),
        ("fuse_a", "fuse_a"),
        ("power_w", "power_w"),
        ("motor_rpm", "motor_rpm"),
        ("propeller_rpm", "propeller_rpm"),
        ("error", "error_number"),
        ("flags", "flags"),
    ];

    fn compare(line: &str, kind: &str, meaning: &Value, json: &Value) {
        let what = match kind {
            "TQ_BAT_STATUS" => "battery_status",
            "RAIL" => "rail",
            "TQ_MOTOR_DRIVE" => "motor_drive",
            "TQ_MOTOR_SET(tx)" => "motor_set",
            "OUTPUT_SET(tx)" => "output_set",
            other => panic!("{other} is not expected"),
        };
        assert_eq!(json["what"], what, "{line}");
        let source = if kind.ends_with("(tx)") { "0xFE" } else { "0xAB" };
        assert_eq!(json["source"], source, "{line}");
        for (theirs, ours) in SAME.iter().filter(|(theirs, _)| meaning.get(theirs).is_some()) {
            assert_eq!(meaning[theirs].as_f64(), json[ours].as_f64(), "{line}: {ours}");
        }
        if what == "motor_set" {
            for (side, key) in [("port", "throttle_0"), ("starboard", "throttle_1")] {
                let difference = meaning[side].as_f64().unwrap() - json[key].as_f64().unwrap();
                assert!(difference.abs() < 1e-3, "{line}: {key}");
            }
        }
        if what == "output_set" {
            assert_eq!(meaning["on"], json["on"], "{line}");
        }
    }

    #[test]
    fn every_vector_is_read_in_all_three_forms() {
        let Some(path) = testkit::shared("data/onboard/torqeedo_can_vectors.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut count = 0;
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.splitn(4, ',').collect();
            let meaning: Value =
                serde_json::from_str(&fields[3].trim_matches('"').replace("\"\"", "\"")).unwrap();
            let id = u32::from_str_radix(fields[0], 16).unwrap();
            let frame = CanFrame::new(id, &hex::decode(fields[1]).unwrap()).unwrap();
            let at = UtcTime::from_micros(1_436_509_052_249_713);
            let entry = candump::Entry { at: Some(at), interface: Some("can0".to_owned()), frame };
            let short = one(&format!("{}#{}", fields[0], fields[1]));
            let mut log = one(&entry.to_string());
            let mut adapter = one(&String::from_utf8(slcan::encode(&frame)).unwrap().replace('\r', "07D0\r"));
            compare(line, fields[2], &meaning, &short);
            assert_eq!(log.as_object_mut().unwrap().remove("t"), Some(json!("2015-07-10T06:17:32.249713Z")));
            assert_eq!(adapter.as_object_mut().unwrap().remove("stamp_s"), Some(json!(2.0)));
            assert_eq!(log, short, "{line}");
            assert_eq!(adapter, short, "{line}");
            count += 1;
        }
        assert!(count >= 20);
    }

    #[test]
    fn what_is_not_used_comes_out_by_name_or_number() {
        let cells = one("0070ABFF#0102");
        assert_eq!(cells["what"], "batcells");
        assert_eq!((&cells["data"], &cells["source"]), (&json!("0102"), &json!("0xAB")));
        assert_eq!(one("1030ABFF#00")["what"], "259");
        assert_eq!(one("0080ABFF#0305000080")["channels_on"], json!([0, 2, 31]));
        assert_eq!(one("0000ABFF#626F6F74")["text"], "boot");
        let foreign = one("123#AA");
        assert_eq!((&foreign["what"], &foreign["id"]), (&json!("unread"), &json!("123")));
        let short = one("0030AAFF#00");
        assert_eq!((&short["what"], &short["source"]), (&json!("unread"), &json!("0xAA")));
        assert!(short["reason"].as_str().unwrap().contains("RAIL (3) has 1 bytes"));
        assert_eq!(one("z\r")["answer"], "sent");
        assert_eq!(one("\x07")["answer"], "refused");
    }

    #[test]
    fn damaged_lines_stand_in_their_place() {
        let found = sniff(&[b"00D0FEAB#0102\n\n00D0FEAB#010\nnonsense\nT00D0FEAB20102\r\n(1.5) can0"]);
        let errors: Vec<_> = found.iter().map(|found| found.json.get("offset").cloned()).collect();
        assert_eq!(errors, [None, Some(json!(15)), Some(json!(28)), None, Some(json!(53))]);
        let long = [b'#'; 10_000];
        assert_eq!(sniff(&[&long])[0].json["offset"], 0);
    }

    #[test]
    fn people_read_who_says_what_to_whom() {
        let text = &sniff(&[b"(12.5) can0 0030ABFF#005274FDFFFF2300"])[0].text;
        let expected = "1970-01-01T00:00:12.500000Z card -> all: \
                        rail current_a -0.003, flags 0, fuse_a 17.5, rail 0, voltage_v 29.778";
        assert_eq!(text, expected);
    }

    proptest! {
        // Every outcome is JSON, which is slow without optimisation.
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_bytes_in_any_pieces_give_the_same(
            bytes in proptest::collection::vec(prop_oneof![
                Just(b'#'), Just(b'('), Just(b'T'), Just(b'\r'), Just(b'\n'), Just(BELL), Just(b'0'), any::<u8>(),
            ], 0..300),
        ) {
            let bytes = [&bytes[..], b"\n00D0FEAB#E803E803"].concat();
            let found = sniff(&[&bytes]);
            prop_assert_eq!(&found, &sniff(&bytes.chunks(1).collect::<Vec<_>>()));
            prop_assert_eq!(&found.last().unwrap().json["throttle_0"], &json!(1.0));
        }
    }
}
