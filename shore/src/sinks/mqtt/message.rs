//! Packets as messages of MQTT: a topic for each series, and JSON with all values of one moment.
//!
//! `<prefix>/<vessel>/<message>/<entity>`, and `/<id>` behind it where the message has one: `lutra/0x2810/EulerAngles/7`. The vessel
//! is its IMC address, which stays when people call it otherwise, and the entity its number. One message holds all fields, as they
//! belong to one moment: a topic for each field would be some ten times as many messages, and a subscriber would have to guess
//! which values belong together. The fields are those of a [`Point`], in an object of their own, as IMC has fields that are called `time`.

use crate::sinks::point::{self, Field, Point};
use imc::PacketView;
use serde_json::Value;
use std::fmt::Write as _;
use units::UtcTime;

/// What is published of a packet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Message {
    /// Below the prefix.
    pub(super) topic: String,
    pub(super) payload: String,
    /// By what the newest value of a topic is told, µs since 1970 UTC: see [`order_us`].
    pub(super) order_us: i64,
}

impl Message {
    /// That of a packet which came at `received`.
    pub(super) fn of(view: &PacketView<'_>, received: UtcTime) -> Self {
        let (src, ent, time) = (view.src().0, view.src_ent(), point::time(view, received));
        let (name, point) = match (view.desc(), Point::of(view)) {
            (Some(desc), Some(point)) => (desc.abbrev.to_owned(), point),
            _ => (format!("unknown-{}", view.id()), Point::unknown(view)),
        };
        let mut topic = format!("{}/{name}/{ent}", vessel(src));
        let (time_us, received_us) = (time.micros(), received.micros());
        let mut payload = format!(
            r#"{{"time":"{time}","time_us":{time_us},"received_us":{received_us},"src":{src},"ent":{ent},"message":"{name}""#
        );
        if let Some(id) = point.id {
            write!(topic, "/{id}").ok();
            write!(payload, r#","id":{id}"#).ok();
        }
        payload.push_str(r#","fields":{"#);
        for (index, (name, field)) in point.fields.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(payload, r#"{comma}"{name}":"#).ok();
            match field {
                Field::Number(value) => drop(write!(payload, "{value}")),
                Field::Single(value) => drop(write!(payload, "{value}")),
                Field::Text(text) => drop(write!(payload, "{}", Value::from(text.as_str()))),
            }
        }
        payload.push_str("}}");
        Self { topic, payload, order_us: order_us(time_us, received_us) }
    }

    /// The first level of its topic.
    pub(super) fn vessel(&self) -> &str {
        self.topic.split('/').next().unwrap_or_default()
    }
}

fn vessel(src: u16) -> String {
    format!("{src:#06x}")
}

/// When a value counts as said: by its sender's clock, but no later than it came. A clock that is years ahead must not stand in the
/// way of all that comes after.
const fn order_us(time_us: i64, received_us: i64) -> i64 {
    if time_us < received_us { time_us } else { received_us }
}

/// The order of a value that a broker kept; `None` where the payload is none of ours.
pub(super) fn order_of(payload: &[u8]) -> Option<i64> {
    let value: Value = serde_json::from_slice(payload).ok()?;
    Some(order_us(value.get("time_us")?.as_i64()?, value.get("received_us")?.as_i64()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{GpsFix, Heartbeat, LogBookEntry, SetThrusterActuation};
    use imc::{Address, Body, Header, Packet};

    const RECEIVED: UtcTime = UtcTime::from_micros(1_500_000_002_000_000);

    fn message(message: impl Into<imc::Message>) -> Message {
        let header = Header { timestamp: 1.5e9, src: Address(0x2810), src_ent: 7, ..Header::default() };
        message_of(&Packet::new(header, message))
    }

    fn message_of(packet: &Packet) -> Message {
        let bytes = packet.encode().unwrap();
        Message::of(&PacketView::new(&bytes).unwrap(), RECEIVED)
    }

    #[test]
    fn a_series_has_a_topic_and_a_moment_one_message() {
        let Message { topic, payload, order_us } = message(SetThrusterActuation { id: 1, value: 0.1 });
        assert_eq!(topic, "0x2810/SetThrusterActuation/7/1");
        assert_eq!(
            payload,
            r#"{"time":"2017-07-14T02:40:00.000000Z","time_us":1500000000000000,"received_us":1500000002000000,"src":10256,"ent":7,"message":"SetThrusterActuation","id":1,"fields":{"value":0.1}}"#
        );
        assert_eq!(order_us, 1_500_000_000_000_000);
        assert_eq!(order_of(payload.as_bytes()), Some(order_us));
        assert_eq!(message(Heartbeat).topic, "0x2810/Heartbeat/7");
        assert!(message(Heartbeat).payload.ends_with(r#","fields":{}}"#));
    }

    #[test]
    fn whatever_a_packet_says_the_payload_is_json() {
        let entry = LogBookEntry { text: "said \"no\"\n\\ \u{1}\u{7f}ø".into(), ..LogBookEntry::default() };
        let fix = GpsFix { lat: 1.0, lon: f64::NAN, hdop: f32::INFINITY, ..GpsFix::default() };
        let unknown = Packet {
            body: Body::Unknown { id: 60_001, payload: vec![1, 255] },
            ..Packet::new(Header { src: Address(1), ..Header::default() }, Heartbeat)
        };
        let all = [message(entry), message(fix), message_of(&unknown)];
        let read = all.each_ref().map(|one| serde_json::from_str::<Value>(&one.payload).unwrap());
        assert_eq!(read[0]["fields"]["text"], "said \"no\"\n\\ \u{1}\u{7f}ø");
        assert_eq!(read[1]["fields"]["lat"], 1.0);
        assert!(
            read[1]["fields"]["latdeg"].as_f64().is_some_and(|degrees| (degrees - 57.295_78).abs() < 1e-5)
        );
        assert!(read[1]["fields"].get("lon").is_none() && read[1]["fields"].get("hdop").is_none());
        assert_eq!(
            (&*all[2].topic, &read[2]["fields"]["payload"]),
            ("0x0001/unknown-60001/255", &"01ff".into())
        );
    }

    #[test]
    fn a_clock_that_is_ahead_does_not_stand_before_what_comes_after() {
        let header = Header { timestamp: 1.9e9, src: Address(0x2810), ..Header::default() };
        let ahead = message_of(&Packet::new(header, Heartbeat));
        assert_eq!(ahead.order_us, RECEIVED.micros());
        assert_eq!(order_of(ahead.payload.as_bytes()), Some(RECEIVED.micros()));
        assert_eq!(order_of(b"23.5"), None);
    }
}
