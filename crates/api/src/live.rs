//! The present state of the fleet: `GET /api/v1/vessels` and the WebSocket `/api/live`.
//!
//! A client sends `{"subscribe": {…}}` and gets frames: first everything that matches, then what changed. Of a
//! series that changed several times between two frames it gets the latest, and how many it did not get; events
//! come one by one and in order. A stop goes by the same socket: `{"stop": {…}}`, answered by `{"stop": {…}}`.
//!
//! The compact form takes a fifteenth of the bytes: a series is described once, then only its values come, and all
//! frames of a connection are one stream of raw DEFLATE (RFC 1951) in binary messages. Each message ends at a sync
//! flush and holds one frame as JSON with a line feed after it.

use crate::{Alarm, Command, Detection, Lease, Ordered, Wording};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// What a client sends on the live socket.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum LiveRequest {
    /// The new subscription. Replaces the previous one; the next frame holds all of it.
    Subscribe(Subscription),
    /// Stops a vessel, as `POST /api/v1/vessels/{vessel}/abort` does. Both with one key are one stop, by whichever comes
    /// first. It needs no subscription.
    Stop(LiveStop),
}

/// A stop on the live socket.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LiveStop {
    /// IMC address of the vessel.
    pub vessel: u16,
    /// Distinguishes the windows of a person; empty for scripts. 64 bytes at most.
    #[serde(default)]
    pub window: String,
    /// Names this stop; 1 to 64 bytes.
    pub key: String,
}

/// What the server answers on the live socket, beside its frames.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum LiveAnswer {
    /// The result of a stop.
    Stop(LiveStopped),
}

/// The result of a stop on the live socket.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LiveStopped {
    /// IMC address of the vessel.
    pub vessel: u16,
    /// As it was sent.
    pub key: String,
    /// The order; null where it was refused.
    pub ordered: Option<Ordered>,
    /// Why it was refused; null where it was not.
    pub refused: Option<String>,
    /// Of what pages make `refused` in their reader's language; absent where it is English only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub says: Option<Wording>,
}

/// A client's subscription.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct Subscription {
    /// IMC addresses; null for all that the person may see.
    pub systems: Option<Vec<u16>>,
    /// Abbreviations of messages like `EstimatedState`; null for all, empty for none.
    pub messages: Option<Vec<String>>,
    /// Of systems that are not listed, these messages; null where nothing is wanted of them.
    pub of_others: Option<Vec<String>>,
    /// Whether events and detections are wanted.
    pub events: bool,
    /// Milliseconds between two frames at least, 2 to 10000.
    pub every_ms: u32,
    /// Whether frames come in the compact form: `series` and `samples` in place of `values`, in binary messages.
    pub compact: bool,
}

impl Default for Subscription {
    fn default() -> Self {
        Self { systems: None, messages: None, of_others: None, events: true, every_ms: 100, compact: false }
    }
}

/// What the server sends on the live socket, at least once a second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LiveFrame {
    /// The server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub now_us: i64,
    /// Whether this starts over: what is not in it is not there.
    pub snapshot: bool,
    /// Systems that changed since the last frame, ten times a second at most.
    pub systems: Vec<System>,
    /// Series with a new value; empty in the compact form.
    pub values: Vec<Update>,
    /// In the compact form, what the series are whose samples come for the first time since the snapshot.
    pub series: Vec<LiveSeries>,
    /// In the compact form, series with a new value.
    pub samples: Vec<LiveSample>,
    /// Events, in order.
    pub events: Vec<Update>,
    /// Tags that were heard, also those that a vessel reports late. One can come in several frames, with what was not
    /// known of it before, and is the same by vessel and id.
    pub detections: Vec<Detection>,
    /// Values that newer ones replaced before they were sent.
    #[cfg_attr(test, ts(type = "number"))]
    pub skipped: u64,
    /// Events that the server no longer had; the history has them.
    #[cfg_attr(test, ts(type = "number"))]
    pub events_missed: u64,
    /// Who has control of a vessel, where that changed.
    pub leases: Vec<Lease>,
    /// Commands that got further, each with all of its stages.
    pub commands: Vec<Command>,
    /// Alarms that changed; those that are over come once more, as `normal`.
    pub alarms: Vec<Alarm>,
    /// Why nothing is recorded, or why the history lags behind, and what to do; null while all is well.
    pub recording: Option<String>,
}

/// A system that communicates by IMC.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct System {
    /// IMC address.
    pub address: u16,
    /// Its name as announced, or as given by people; null while it has none.
    pub name: Option<String>,
    /// Kind by its Announce, like `USV` or `CCU`.
    pub kind: Option<String>,
    /// How long it has been silent, in words.
    pub liveness: Liveness,
    /// Its last packet by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub heard_us: i64,
    /// Transports through which it was heard, the latest first.
    pub transports: Vec<String>,
    /// Its position, where it reported one.
    pub fix: Option<Fix>,
    /// Entities' labels by number.
    pub entities: BTreeMap<u8, String>,
}

/// How long a system has been silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Liveness {
    /// Heard as often as it sends.
    Live,
    /// Expected, but not there yet.
    Late,
    /// Its shown values are old.
    Stale,
    /// Gone.
    Lost,
}

/// A true position, with what is known of the motion there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Fix {
    /// When, by the vessel's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// WGS-84 latitude, degrees, north positive.
    pub lat_deg: f64,
    /// WGS-84 longitude, degrees, east positive.
    pub lon_deg: f64,
    /// True heading, radians clockwise from north.
    pub heading_rad: Option<f64>,
    /// Course over ground, radians clockwise from north.
    pub course_rad: Option<f64>,
    /// Speed over ground, m/s.
    pub speed_mps: Option<f64>,
}

/// A message, decoded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Update {
    /// IMC address of the source.
    pub system: u16,
    /// Number of the message.
    pub id: u16,
    /// Its abbreviation, like `EstimatedState`.
    pub abbrev: String,
    /// Number of the entity within the source; 255 for none.
    pub entity: u8,
    /// Distinguishes several series of one entity, like port and starboard; null where there is one.
    pub instance: Option<u8>,
    /// The source's time, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Arrival by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub received_us: i64,
    /// Packets of the series since the server started; 0 for an event.
    #[cfg_attr(test, ts(type = "number"))]
    pub count: u64,
    /// Usual time between two of them, seconds; null while that is unknown.
    pub period_s: Option<f64>,
    /// Values by field, in the order of the message.
    pub fields: Vec<Field>,
}

/// The description of a series, in the compact form.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LiveSeries {
    /// Its number on this connection, until the next snapshot.
    pub series: u32,
    /// IMC address of the source.
    pub system: u16,
    /// Number of the message.
    pub id: u16,
    /// Its abbreviation.
    pub abbrev: String,
    /// Number of the entity within the source; 255 for none.
    pub entity: u8,
    /// Distinguishes several series of one entity; null where there is one.
    pub instance: Option<u8>,
    /// Names of its fields, in the order of the message. A series that is described again has more of them.
    pub names: Vec<String>,
    /// Their units; empty for none.
    pub units: Vec<String>,
}

/// The latest of a series, in the compact form: what [`Update`] has beside what [`LiveSeries`] says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LiveSample {
    /// The number of its series.
    pub series: u32,
    /// The source's time, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Arrival by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub received_us: i64,
    /// Packets of the series since the server started.
    #[cfg_attr(test, ts(type = "number"))]
    pub count: u64,
    /// Usual time between two of them, seconds; null while that is unknown.
    pub period_s: Option<f64>,
    /// Values of the fields, in their order; of a message that ends early, of the first fields only.
    #[cfg_attr(test, ts(type = "unknown[]"))]
    pub values: Vec<serde_json::Value>,
    /// Labels of the values, in their order; empty where none has one.
    pub meanings: Vec<Option<String>>,
}

/// A value of a message.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Field {
    /// Name in the message.
    pub name: String,
    /// Number, text or nested message; null where it is not a number (NaN).
    #[cfg_attr(test, ts(type = "unknown"))]
    pub value: serde_json::Value,
    /// Unit, like `rad`; empty for none.
    pub unit: String,
    /// The number's label, where it has one.
    pub meaning: Option<String>,
}
