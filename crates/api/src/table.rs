//! Rows for programs that draw tables: Grafana, notebooks, spreadsheets. All rows of a table have the same columns, and no value is nested.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// Which series, and from when to when.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct TableQuery {
    /// From this time on: milliseconds since 1970 UTC, as `${__from}` of Grafana, or ISO 8601.
    pub from: String,
    /// Before this time, likewise.
    pub to: String,
    /// Series as on the pages: `Voltage.2.value`, by message, number of the entity and field. Instead of the number its label
    /// (`Voltage.Battery.value`); without either (`EstimatedState.psi`) the entity of the vessel that sent the message most often. Several:
    /// the parameter once for each, or with commas between them; a comma within a label is written `\,` (`Voltage.Motor\, left.value`). 500
    /// names at most.
    pub series: Vec<String>,
    /// Vessels by name or IMC address: the parameter once for each, or with commas between them (`\,` within a name); all that one may see
    /// when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub vessel: Vec<String>,
    /// About how many rows of each series of a vessel: as many as the plot has pixels, 1 to 10000; 1000 when left out. More than about 50,000
    /// rows in all, or more than 500 series of vessels, are refused.
    pub points: Option<u32>,
    /// `rad` or `deg`, the unit of angles; `rad` when left out.
    pub angles: Option<String>,
    /// `json` or `csv`; when left out what `Accept` prefers, and else `json`.
    pub format: Option<String>,
}

/// What the samples of a series have in common in one stretch of time. Rows are in order of time, then of vessel and series; stretches without
/// samples have no row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableRow {
    /// ISO 8601 UTC with milliseconds: the middle of the stretch, or of its only sample.
    pub time: String,
    /// Name of the vessel.
    pub vessel: String,
    /// The series: message, number of the entity, field.
    pub series: String,
    /// The entity's last label; its number where it has none.
    pub entity: String,
    /// Unit of the values; empty for none.
    pub unit: String,
    /// The least value.
    pub min: f64,
    /// The mean value; of angles that of their directions. Null where the sum is beyond what a double holds.
    pub mean: Option<f64>,
    /// The greatest value.
    pub max: f64,
    /// How many samples.
    pub count: u64,
}

/// Something to choose, for a variable of a dashboard.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
pub struct TableChoice {
    /// What people read.
    pub text: String,
    /// What the table is asked for.
    pub value: String,
}

/// Whose series.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct TableSeriesQuery {
    /// Vessels by name or IMC address: the parameter once for each, or with commas between them (`\,` within a name); all that one may see
    /// when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub vessel: Vec<String>,
}

/// Which detections.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct TableDetectionsQuery {
    /// Reported from this time on: milliseconds since 1970 UTC, as `${__from}` of Grafana, or ISO 8601.
    pub from: String,
    /// Reported before this time, likewise.
    pub to: String,
    /// Vessels by name or IMC address: the parameter once for each, or with commas between them (`\,` within a name); all that one may see
    /// when left out or empty.
    #[serde(default)]
    #[param(required = false)]
    pub vessel: Vec<String>,
    /// Tags as protocol and number (`S256-101`) or as number alone (`101`), with commas between them; all when left out or empty.
    pub tag: Option<String>,
    /// `oldest` or `newest`, which report comes first; `oldest` when left out.
    pub order: Option<String>,
    /// At most so many rows, 1 to 10000; 10000 when left out. `next` in JSON, and the header `Link` with `rel="next"`, have the address of the
    /// rest.
    pub limit: Option<u32>,
    /// Detections to pass over, 0 to 100000; from the address of the rest.
    pub skip: Option<u32>,
    /// `json` or `csv`; when left out what `Accept` prefers, and else `json`.
    pub format: Option<String>,
}

/// Tags that receivers heard, in the order that was asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableDetections {
    /// A row for each.
    pub rows: Vec<TableDetection>,
    /// Path and query of the rows that did not fit; null where these are all.
    pub next: Option<String>,
}

/// A tag that a receiver heard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableDetection {
    /// When the vessel reported it, ISO 8601 UTC with milliseconds.
    pub time: String,
    /// Name of the vessel.
    pub vessel: String,
    /// The tag, such as `S256-101`.
    pub tag: String,
    /// The tag's measurement, as it was sent; null where it sent none.
    pub data: Option<u16>,
    /// WGS-84 latitude of the vessel then, degrees, north positive; null where it did not know.
    pub latitude: Option<f64>,
    /// WGS-84 longitude of the vessel then, degrees, east positive; null where it did not know.
    pub longitude: Option<f64>,
    /// Signal to noise ratio, dB; null where the receiver, or the file it came by, does not say it.
    pub snr_db: Option<u8>,
}
