//! Packets as lines of InfluxDB's protocol.
//!
//! A measurement for each message; tags `src` and `ent` are the numbers of system and entity, and `id` where the
//! message has one, which keeps port and starboard apart. All numbers are floats, as InfluxDB holds a field to the
//! type that it had first; what is no finite number is left out. Latitude and longitude are also there in degrees, as
//! `latdeg` and `londeg`. Of EstimatedState, whose `lat` and `lon` are a reference point, those are where the vessel
//! truly is, as are `true_lat_deg` and `true_lon_deg`, by which history and CSV call it.
//! The time is the sender's in microseconds, or of arrival where the sender gave none.

use imc::PacketView;
use imc::catalogue::{FieldDesc, MessageDesc};
use imc::messages::{EstimatedState, Payload as _};
use imc::reflect::{self, Value, Visitor};
use std::fmt::Write as _;
use units::UtcTime;

/// InfluxDB refuses longer texts.
const LONGEST_TEXT: usize = 60_000;

/// Appends the line of a packet that came at `received`, with its line end.
pub(crate) fn write(out: &mut String, view: &PacketView<'_>, received: UtcTime) {
    let Some(desc) = view.desc() else {
        let payload = hex::encode(view.payload());
        let (id, src, ent) = (view.id(), view.src().0, view.src_ent());
        write!(out, "unknown,ent={ent},id={id},src={src} payload=\"{payload}\"").ok();
        return end(out, view, received);
    };
    let mut line = Line { tag: None, fields: String::new(), depth: 0, angles: Vec::new() };
    // Of a damaged or short packet, the fields before the damage.
    reflect::walk_payload(desc, view.payload(), view.order(), true, &mut line).ok();
    write!(out, "{},ent={}", desc.abbrev, view.src_ent()).ok();
    if let Some(id) = line.tag {
        write!(out, ",id={id}").ok();
    }
    write!(out, ",src={} ", view.src().0).ok();
    line.degrees(view);
    if line.fields.is_empty() {
        // A line needs a field; there are messages that have none.
        line.number("present", 1.0);
    }
    out.push_str(&line.fields);
    end(out, view, received);
}

fn end(out: &mut String, view: &PacketView<'_>, received: UtcTime) {
    let time_us = view.header().time().unwrap_or(received).micros();
    writeln!(out, " {time_us}").ok();
}

/// The fields of one line.
struct Line {
    tag: Option<i64>,
    fields: String,
    /// Nested messages and lists around the present place. They are left to the history, which holds them as JSON.
    depth: usize,
    /// Latitude and longitude, radians, as the message has them.
    angles: Vec<(&'static str, f64)>,
}

impl Line {
    fn name(&mut self, name: &str) {
        if !self.fields.is_empty() {
            self.fields.push(',');
        }
        self.fields.push_str(name);
        if name == "time" {
            // InfluxDB keeps that name for itself.
            self.fields.push('_');
        }
        self.fields.push('=');
    }

    fn number(&mut self, name: &str, value: f64) {
        if value.is_finite() {
            self.name(name);
            write!(self.fields, "{value}").ok();
        }
    }

    fn text(&mut self, name: &str, text: &str) {
        if text.len() > LONGEST_TEXT {
            return;
        }
        self.name(name);
        self.fields.push('"');
        for character in text.chars() {
            if matches!(character, '"' | '\\') {
                self.fields.push('\\');
            }
            self.fields.push(character);
        }
        self.fields.push('"');
    }

    /// Where the message says that something is, in degrees; of an estimated state, where the vessel truly is.
    fn degrees(&mut self, view: &PacketView<'_>) {
        if view.id() == EstimatedState::ID {
            let state = imc::decode::<EstimatedState>(view).ok().flatten();
            if let Some(place) = state.and_then(|state| imc::position::place(&state).ok()) {
                self.number("latdeg", place.lat_deg());
                self.number("londeg", place.lon_deg());
                self.number("true_lat_deg", place.lat_deg());
                self.number("true_lon_deg", place.lon_deg());
            }
            return;
        }
        for (name, angle_rad) in std::mem::take(&mut self.angles) {
            self.number(name, angle_rad.to_degrees());
        }
    }
}

impl Visitor<'_> for Line {
    fn value(&mut self, field: &'static FieldDesc, value: Value<'_>) {
        if self.depth > 0 {
            return;
        }
        match (field.abbrev, value) {
            ("id", Value::Integer(id)) => self.tag = Some(id),
            (name, Value::Text(text)) => self.text(name, &String::from_utf8_lossy(text)),
            (name, Value::Raw(bytes)) => self.text(name, &hex::encode(bytes)),
            // The shortest decimal that is this single, not the double's many digits.
            (name, Value::Single(value)) if value.is_finite() => {
                self.name(name);
                write!(self.fields, "{value}").ok();
            }
            (name, value) => {
                let Some(number) = value.as_f64() else { return };
                self.number(name, number);
                match name {
                    "lat" => self.angles.push(("latdeg", number)),
                    "lon" => self.angles.push(("londeg", number)),
                    _ => {}
                }
            }
        }
    }

    fn null(&mut self, _: &'static FieldDesc) {}

    fn enter_message(&mut self, _: &'static FieldDesc, _: &'static MessageDesc) {
        self.depth += 1;
    }

    fn leave_message(&mut self) {
        self.depth -= 1;
    }

    fn enter_list(&mut self, _: &'static FieldDesc, _: usize) {
        self.depth += 1;
    }

    fn leave_list(&mut self) {
        self.depth -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{GpsFix, Heartbeat, LogBookEntry, SetThrusterActuation};
    use imc::{Address, Body, Header, Message, Packet};

    fn line(message: impl Into<Message>) -> String {
        line_of(&Packet::new(header(), message))
    }

    fn header() -> Header {
        Header { timestamp: 1.5e9, src: Address(0x2810), src_ent: 7, ..Header::default() }
    }

    fn line_of(packet: &Packet) -> String {
        let bytes = packet.encode().unwrap();
        let mut out = String::new();
        write(&mut out, &PacketView::new(&bytes).unwrap(), UtcTime::from_micros(9));
        out
    }

    #[test]
    fn port_and_starboard_are_kept_apart_and_numbers_are_as_short_as_they_are() {
        assert_eq!(
            line(SetThrusterActuation { id: 1, value: 0.1 }),
            "SetThrusterActuation,ent=7,id=1,src=10256 value=0.1 1500000000000000\n"
        );
    }

    #[test]
    fn what_is_no_number_is_left_out_and_places_are_also_in_degrees() {
        let fix = line(GpsFix { lat: 1.0, lon: f64::NAN, hdop: f32::INFINITY, ..GpsFix::default() });
        assert!(fix.contains(",lat=1,") && fix.contains(",latdeg=57.29577951308232"), "{fix}");
        assert!(!fix.contains("lon=") && !fix.contains("londeg") && !fix.contains("hdop"), "{fix}");
    }

    #[test]
    fn an_estimated_state_has_the_raw_reference_and_the_true_place_by_the_names_of_the_history() {
        let reference = EstimatedState {
            lat: 63.44_f64.to_radians(),
            lon: 10.35_f64.to_radians(),
            x: 1_000.0,
            y: -500.0,
            ..EstimatedState::default()
        };
        let text = line(reference.clone());
        let field = |name: &str| -> f64 {
            let found = text.split([',', ' ']).find_map(|one| one.strip_prefix(name)?.strip_prefix('='));
            found.unwrap_or_else(|| panic!("{name} is not in {text}")).parse().unwrap()
        };
        assert_eq!((field("lat"), field("lon"), field("x")), (reference.lat, reference.lon, 1_000.0));
        // 1 000 m are 0.00897 degrees north at 63.44, 500 m are 0.01002 degrees east (WGS-84).
        assert!((field("true_lat_deg") - 63.448_97).abs() < 2e-5, "{text}");
        assert!((field("true_lon_deg") - 10.339_98).abs() < 2e-5, "{text}");
        assert_eq!((field("latdeg"), field("londeg")), (field("true_lat_deg"), field("true_lon_deg")));
        // A place that is not valid has no true place.
        let nowhere = line(EstimatedState { lat: f64::NAN, ..reference });
        assert!(!nowhere.contains("true_lat_deg") && nowhere.contains(",x=1000,"), "{nowhere}");
    }

    #[test]
    fn texts_cannot_end_their_line_or_become_fields() {
        let entry = LogBookEntry {
            context: "a\\".into(),
            text: "said \"no\",x=1\nHeartbeat present=2 1".into(),
            ..LogBookEntry::default()
        };
        let text = line(entry);
        assert!(text.contains(r#"context="a\\","#), "{text}");
        assert!(text.contains("text=\"said \\\"no\\\",x=1\nHeartbeat present=2 1\" 15"), "{text}");
    }

    #[test]
    fn messages_without_fields_or_without_a_name_have_lines_too() {
        assert_eq!(line(Heartbeat), "Heartbeat,ent=7,src=10256 present=1 1500000000000000\n");
        let unknown = Packet {
            body: Body::Unknown { id: 60_001, payload: vec![1, 255] },
            ..Packet::new(header(), Heartbeat)
        };
        assert_eq!(line_of(&unknown), "unknown,ent=7,id=60001,src=10256 payload=\"01ff\" 1500000000000000\n");
        let untimed = Packet::new(Header { timestamp: f64::NAN, ..header() }, Heartbeat);
        assert!(line_of(&untimed).ends_with(" 9\n"));
    }
}
