//! Queries to the history and their answers.

use crate::Update;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// A kind of message that the history holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Recorded {
    /// IMC address of the source.
    pub system: u16,
    /// Abbreviation of the message.
    pub abbrev: String,
    /// How many.
    #[cfg_attr(test, ts(type = "number"))]
    pub count: u64,
    /// Time of the first, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub first_us: i64,
    /// Time of the last, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub last_us: i64,
}

/// Data received from a vessel on one day: live, late or by an import.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RecordedDay {
    /// IMC address of the source.
    pub system: u16,
    /// Its name, as it announced itself last; its address where it never did.
    pub name: String,
    /// Midnight of the UTC day on which it came, µs since 1970.
    #[cfg_attr(test, ts(type = "number"))]
    pub day_us: i64,
    /// First time by the source's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub first_us: i64,
    /// Last time by the source's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub last_us: i64,
    /// How many packets.
    #[cfg_attr(test, ts(type = "number"))]
    pub packets: u64,
    /// Bytes of these packets in the archive; 0 for a day that was removed there, and is in the history still.
    #[cfg_attr(test, ts(type = "number"))]
    pub bytes: u64,
}

/// How large an export will be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ExportSize {
    /// Rows; of a long table about so many.
    #[cfg_attr(test, ts(type = "number"))]
    pub rows: u64,
    /// About so many bytes, not packed.
    #[cfg_attr(test, ts(type = "number"))]
    pub bytes: u64,
    /// Whether that may be learnt from a sample; else it is counted.
    pub estimated: bool,
}

/// Which part of a track.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct TrackQuery {
    /// From this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// At most so many points, 2 to 20000; when left out 2000, and 20000 in a file.
    pub points: Option<u32>,
}

/// A place on a track.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TrackPoint {
    /// When, by the vessel's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// WGS-84 latitude, degrees, north positive.
    pub lat_deg: f64,
    /// WGS-84 longitude, degrees, east positive.
    pub lon_deg: f64,
}

/// Which time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct AtQuery {
    /// The time, by the vessel's clock, µs since 1970 UTC.
    pub time_us: i64,
}

/// How a vessel was at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct At {
    /// The time asked for, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// The last sample of every series at or before it, of 31 days at most; its age is `time_us` less its own. The
    /// history does not distinguish instances within an entity.
    pub values: Vec<Update>,
    /// Whether there were more series than fit.
    pub cut: bool,
}
