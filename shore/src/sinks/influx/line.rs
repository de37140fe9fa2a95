//! Packets as lines of InfluxDB's protocol.
//!
//! A measurement for each message; tags `src` and `ent` are the numbers of system and entity, and `id` where the
//! message has one. The fields are those of a [`Point`]. All numbers are floats, as InfluxDB holds a field to the
//! type that it had first. The time is the sender's in microseconds, or of arrival where the sender gave none.

use crate::sinks::point::{self, Field, Point};
use imc::PacketView;
use std::fmt::Write as _;
use units::UtcTime;

/// Appends the line of a packet that came at `received`, with its line end.
pub(crate) fn write(out: &mut String, view: &PacketView<'_>, received: UtcTime) {
    let (ent, src, time_us) = (view.src_ent(), view.src().0, point::time(view, received).micros());
    let (Some(desc), Some(point)) = (view.desc(), Point::of(view)) else {
        let (id, payload) = (view.id(), hex::encode(view.payload()));
        writeln!(out, "unknown,ent={ent},id={id},src={src} payload=\"{payload}\" {time_us}").ok();
        return;
    };
    write!(out, "{},ent={ent}", desc.abbrev).ok();
    if let Some(id) = point.id {
        write!(out, ",id={id}").ok();
    }
    write!(out, ",src={src} ").ok();
    for (index, (name, field)) in point.fields.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        // InfluxDB keeps that name for itself.
        let mark = if *name == "time" { "_" } else { "" };
        write!(out, "{comma}{name}{mark}=").ok();
        match field {
            Field::Number(value) => drop(write!(out, "{value}")),
            Field::Single(value) => drop(write!(out, "{value}")),
            Field::Text(text) => quote(out, text),
        }
    }
    if point.fields.is_empty() {
        // A line needs a field; there are messages that have none.
        out.push_str("present=1");
    }
    writeln!(out, " {time_us}").ok();
}

fn quote(out: &mut String, text: &str) {
    out.push('"');
    for character in text.chars() {
        if matches!(character, '"' | '\\') {
            out.push('\\');
        }
        out.push(character);
    }
    out.push('"');
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{EstimatedState, GpsFix, Heartbeat, LogBookEntry, SetThrusterActuation};
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
