//! Events, each of which matters: names of entities, tag detections, log books, gaps.

use crate::{DetectionFlag, Next};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// A label of an entity, and from when to when it was heard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Entity {
    /// Number of the entity.
    pub entity: u8,
    /// Its label.
    pub label: String,
    /// When it was first heard, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub from_us: i64,
    /// When it was last heard, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub last_us: i64,
}

/// Which entries.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct EventsQuery {
    /// From this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// At most so many, 1 to 10000; 1000 when left out. An answer has 8 MiB at most, so that it can hold fewer.
    pub limit: Option<u32>,
    /// Those to pass over, 0 to 100000; from the answer before.
    pub skip: Option<u32>,
    /// `oldest` or `newest` first; `oldest` when left out.
    pub order: Option<String>,
}

/// Which detections.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct DetectionsQuery {
    /// Reported from this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Reported before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// First received ashore from this time on, by the shore's clock, µs since 1970 UTC: for what came since an earlier
    /// query, however old it is. All when left out.
    pub received_since_us: Option<i64>,
    /// At most so many, 1 to 10000; 1000 when left out. An answer has 8 MiB at most, so that it can hold fewer.
    pub limit: Option<u32>,
    /// Those to pass over, 0 to 100000; from the answer before.
    pub skip: Option<u32>,
    /// `oldest` or `newest` first; `oldest` when left out.
    pub order: Option<String>,
}

/// Which detections of all vessels. Lists are separated by commas.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct FleetDetectionsQuery {
    /// Reported from this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Reported before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// Names or IMC addresses of vessels; all that one may see when left out or empty.
    pub vessel: Option<String>,
    /// Tags as protocol and number (`S256-101`) or as number alone (`101`); all when left out or empty.
    pub tag: Option<String>,
    /// Projects of the register by name, of the tag, or of the animal that carried it: the parameter once for each. A name that the register
    /// does not have is read as several with `;` between them. All when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub project: Vec<String>,
    /// Corners of an area on the chart, 3 to 100, as `lat,lon;lat,lon;…` in degrees; detections without a position are left
    /// out then. Everywhere when left out or empty.
    pub area: Option<String>,
    /// Whether each comes with the time to its nearest neighbour and its flags; false when left out.
    pub flags: Option<bool>,
    /// First received ashore from this time on, by the shore's clock, µs since 1970 UTC. All when left out.
    pub received_since_us: Option<i64>,
    /// At most so many, 1 to 10000; 1000 when left out. An answer has 8 MiB at most, so that it can hold fewer.
    pub limit: Option<u32>,
    /// Those to pass over, 0 to 100000; from the answer before.
    pub skip: Option<u32>,
    /// `oldest` or `newest` first; `oldest` when left out.
    pub order: Option<String>,
}

/// Which detections a file has. Lists are separated by commas.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct DetectionsFileQuery {
    /// Reported from this time on, µs since 1970 UTC; from the beginning when left out.
    pub from_us: Option<i64>,
    /// Reported before this time, µs since 1970 UTC; to the end when left out.
    pub to_us: Option<i64>,
    /// Vessels by name or IMC address; all that one may export when left out or empty.
    pub vessel: Option<String>,
    /// Tags as protocol and number (`S256-101`) or as number alone (`101`); all when left out or empty.
    pub tag: Option<String>,
    /// Projects of the register by name, of the tag, or of the animal that carried it: the parameter once for each. A name that the register
    /// does not have is read as several with `;` between them. All when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub project: Vec<String>,
    /// Corners of an area on the chart, 3 to 100, as `lat,lon;lat,lon;…` in degrees; detections without a position are left
    /// out then. Everywhere when left out or empty.
    pub area: Option<String>,
    /// `lutra` (all columns), or a portal's or package's: `vue`, `fathom`, `thelma`, `thelma-old`, `otn`, `etn`, `glatos`, `actel`,
    /// `actel-biometrics`, `yaps`, `movebank`, `darwin-core`, `dwca`, `dwca-all`; for maps `geojson`, `kml` and `geopackage`, for
    /// programs `parquet` and `netcdf`, all five with all columns. `lutra` when left out. See `docs/detections.md`.
    pub format: Option<String>,
    /// For spreadsheets, in the format `lutra`: `comma` or `point`, the decimal sign; for programs when left out.
    pub spreadsheet: Option<String>,
    /// Whether the file is packed by gzip; false when left out.
    pub gzip: Option<bool>,
}

/// Tags that were heard, by when they were reported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Detections {
    /// In order of the report, or the newest first.
    pub detections: Vec<Detection>,
    /// How to ask for those that did not fit; null when these are all.
    pub next: Option<Next>,
}

/// A tag that a receiver heard. What no message carried is null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Detection {
    /// The entity that reported it.
    pub entity: u8,
    /// When its line came to the vessel and was reported, by the vessel's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// When the receiver heard it, by the receiver's clock, to the millisecond, µs since 1970 UTC; null where that clock was
    /// never set, or was lost.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub heard_us: Option<i64>,
    /// When the report first came ashore, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub received_us: i64,
    /// Serial number of the receiver.
    #[cfg_attr(test, ts(type = "number"))]
    pub serial_no: i64,
    /// Its maker in one word, such as `innovasea`, where a file of another receiver said it: makers give the same numbers. Null
    /// for what vessels report.
    pub maker: Option<String>,
    /// Number of the tag's protocol, by IMC; null where IMC has none.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub protocol: Option<i64>,
    /// Its name, such as `R64K`.
    pub protocol_name: Option<String>,
    /// The tag's number.
    #[cfg_attr(test, ts(type = "number"))]
    pub tag_id: i64,
    /// The tag's measurement, as it was sent; null where it sent none.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub data: Option<i64>,
    /// Signal to noise ratio, dB; null where the receiver, or the file it came by, does not say it.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub snr_db: Option<i64>,
    /// Frequency, kHz; null likewise.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub frequency_khz: Option<i64>,
    /// Place in the receiver's memory, which is the running number of its line.
    #[cfg_attr(test, ts(type = "number"))]
    pub memory_address: i64,
    /// WGS-84 latitude of the vessel then, degrees, north positive; null where it did not know.
    pub lat_deg: Option<f64>,
    /// WGS-84 longitude of the vessel then, degrees, east positive; null where it did not know.
    pub lon_deg: Option<f64>,
    /// Names it among those of its vessel: the same live and from the history.
    pub id: String,
    /// IMC address of the vessel.
    pub system: u16,
    /// What is known of the receiver's clock.
    pub clock: ReceiverClock,
    /// What the receiver's clock counted, µs: since 1970 UTC where it is set, else since an unknown moment.
    #[cfg_attr(test, ts(type = "number"))]
    pub clock_us: i64,
    /// Time between the detection and the vessel's nearest measured position, s.
    pub pose_age_s: Option<f64>,
    /// Standard deviation of the place on each axis, m.
    pub pose_sigma_m: Option<f64>,
    /// Lines of the receiver that were lost right before this one.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub lines_lost: Option<u16>,
    /// Mean noise that the receiver reported last, in its own counts.
    pub noise_average: Option<u8>,
    /// Peak noise, likewise.
    pub noise_peak: Option<u8>,
    /// How long before that was, s.
    pub noise_age_s: Option<f64>,
    /// Speed of the vessel's faster propeller, rpm, without direction.
    pub propeller_rpm: Option<f64>,
    /// The receiver's line as it came, without its end.
    pub raw: Option<String>,
    /// Time to the nearest other detection of the tag by the same receiver, s; null where none is within a day, and where
    /// it was not computed.
    pub min_lag_s: Option<f64>,
    /// Why it is doubtful; null where that was not computed, as in live detections.
    pub flags: Option<Vec<DetectionFlag>>,
}

/// What is known of a receiver's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum ReceiverClock {
    /// It was set at some time; its accuracy is not known.
    Set,
    /// It was never set since power-up.
    NotSet,
    /// It was set by the vessel, and kept since.
    Disciplined,
    /// It was good and is not known to be any more.
    Lost,
}

/// A vessel's log book.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogBook {
    /// In the order in which they were sent, or the newest first.
    pub entries: Vec<LogBookEntry>,
    /// How to ask for those that did not fit; null when these are all.
    pub next: Option<Next>,
}

/// An entry of a vessel's log book.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogBookEntry {
    /// The entity that wrote it.
    pub entity: u8,
    /// When it was sent, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// When it was written, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub written_us: Option<i64>,
    /// How serious it is: 0 information, 1 warning, 2 error, 3 critical, 4 debug.
    #[cfg_attr(test, ts(type = "number"))]
    pub kind: i64,
    /// The name of that.
    pub kind_name: Option<String>,
    /// The part of the vessel's program.
    pub context: String,
    /// What it says.
    pub text: String,
}

/// Which gaps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct GapsQuery {
    /// From this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC.
    pub to_us: i64,
}

/// A stretch of a vessel's time from which something is missing, as it was declared or as nothing was heard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Gap {
    /// From when, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub from_us: i64,
    /// Until when, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub to_us: i64,
    /// Why the packets are missing.
    pub kind: GapKind,
    /// Why, in words.
    pub reason: String,
    /// When it was declared, by the shore's clock, µs since 1970 UTC; of a silence, when it ended.
    #[cfg_attr(test, ts(type = "number"))]
    pub declared_us: i64,
}

/// Why something is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum GapKind {
    /// It was never recorded.
    NotRecorded,
    /// The vessel has it and has yet to send it.
    NotDelivered,
    /// It was recorded and is gone.
    Lost,
}
