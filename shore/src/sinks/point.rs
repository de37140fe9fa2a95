//! A packet as named values, as other stores take them.
//!
//! `id` stands apart where a message has one, which tells port from starboard. What is no finite number is left out. Latitude and
//! longitude are also there in degrees, as `latdeg` and `londeg`. Of EstimatedState, whose `lat` and `lon` are a reference point,
//! those are where the vessel truly is, as are `true_lat_deg` and `true_lon_deg`, by which history and CSV call it. Nested
//! messages and lists are left to the history, which holds them as JSON.

use imc::PacketView;
use imc::catalogue::{FieldDesc, MessageDesc};
use imc::messages::{EstimatedState, Payload as _};
use imc::reflect::{self, Value, Visitor};
use units::UtcTime;

/// Longer texts are left out: InfluxDB refuses them.
const LONGEST_TEXT: usize = 60_000;

/// The values of one packet.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Point {
    pub(super) id: Option<i64>,
    pub(super) fields: Vec<(&'static str, Field)>,
    depth: usize,
    /// Latitude and longitude, radians, as the message has them.
    angles: Vec<(&'static str, f64)>,
}

/// One value; numbers are finite.
#[derive(Debug, PartialEq)]
pub(super) enum Field {
    Number(f64),
    /// The shortest decimal that is this single, not the double's many digits, is what it is written as.
    Single(f32),
    Text(String),
}

impl Point {
    /// The values of a packet; of a damaged or short one, those before the damage. `None` where the catalogue does not know it.
    pub(super) fn of(view: &PacketView<'_>) -> Option<Self> {
        let mut point = Self::default();
        reflect::walk_payload(view.desc()?, view.payload(), view.order(), true, &mut point).ok();
        point.degrees(view);
        Some(point)
    }

    /// A packet that the catalogue does not know: its payload as hexadecimal digits.
    pub(super) fn unknown(view: &PacketView<'_>) -> Self {
        let mut point = Self::default();
        point.text("payload", hex::encode(view.payload()));
        point
    }

    fn number(&mut self, name: &'static str, value: f64) {
        if value.is_finite() {
            self.fields.push((name, Field::Number(value)));
        }
    }

    fn text(&mut self, name: &'static str, text: String) {
        if text.len() <= LONGEST_TEXT {
            self.fields.push((name, Field::Text(text)));
        }
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

/// When a packet was said: by its sender's clock, or when it came where the sender gave no time.
pub(super) fn time(view: &PacketView<'_>, received: UtcTime) -> UtcTime {
    view.header().time().unwrap_or(received)
}

impl Visitor<'_> for Point {
    fn value(&mut self, field: &'static FieldDesc, value: Value<'_>) {
        if self.depth > 0 {
            return;
        }
        match (field.abbrev, value) {
            ("id", Value::Integer(id)) => self.id = Some(id),
            (name, Value::Text(text)) => self.text(name, String::from_utf8_lossy(text).into_owned()),
            (name, Value::Raw(bytes)) => self.text(name, hex::encode(bytes)),
            (name, Value::Single(value)) if value.is_finite() => {
                self.fields.push((name, Field::Single(value)));
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
