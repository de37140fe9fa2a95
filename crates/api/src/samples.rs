//! Series of samples: a list of them, and their values for plots and tables.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// Which series.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct SeriesQuery {
    /// Name or IMC address of the source; all that one may see when left out.
    pub system: Option<String>,
}

/// The samples of one message of one entity of one system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Series {
    /// IMC address of the source.
    pub system: u16,
    /// Abbreviation of the message, or its number where the catalogue has none.
    pub message: String,
    /// Number of the message.
    pub id: u16,
    /// Number of the entity; 255 for none.
    pub entity: u8,
    /// The entity's last label.
    pub label: Option<String>,
    /// The values of each sample, in order; empty where the catalogue does not know the message.
    pub fields: Vec<SeriesField>,
    /// How many samples.
    #[cfg_attr(test, ts(type = "number"))]
    pub count: u64,
    /// How many of them have no believable time (before 2000, or from 2100 on); plots leave them out.
    #[cfg_attr(test, ts(type = "number"))]
    pub undated: u64,
    /// Time of the first that has a believable time, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub first_us: Option<i64>,
    /// Time of the last that has a believable time, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub last_us: Option<i64>,
    /// Mean time between two of them, seconds; null for fewer than two.
    pub period_s: Option<f64>,
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeriesField {
    /// Name in the message, such as `psi`.
    pub name: String,
    /// What it is, in words.
    pub title: String,
    /// Unit, like `rad`; empty for none.
    pub unit: String,
    /// The type of its values.
    pub kind: ValueKind,
    /// Labels of its numbers; empty where they are plain numbers. Of bit fields, the bits.
    pub labels: Vec<Label>,
}

/// The label of a number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Label {
    /// The number.
    #[cfg_attr(test, ts(type = "number"))]
    pub value: i64,
    /// Its name.
    pub name: String,
}

/// The type of a field's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum ValueKind {
    /// Whole numbers.
    Integer,
    /// Whole numbers, each with a label.
    Enumeration,
    /// Whole numbers, each bit with a label.
    Bits,
    /// Real numbers.
    Real,
    /// Text.
    Text,
    /// Bytes, in hexadecimal.
    Raw,
    /// A message or a list of messages.
    Nested,
}

/// Which buckets.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct BucketsQuery {
    /// Abbreviation of the message.
    pub message: String,
    /// Number of the entity.
    pub entity: u8,
    /// The field; it holds numbers.
    pub field: String,
    /// From this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// About how many buckets: as many as the plot has pixels, 1 to 10000; 1000 when left out.
    pub pixels: Option<u32>,
}

/// What the samples of each stretch of time have in common; stretches without any are left out. All lists are
/// equally long and in order of time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Buckets {
    /// Unit of the values; empty for none.
    pub unit: String,
    /// How long each bucket is, µs. Where it is shorter than the samples are apart, each holds one.
    #[cfg_attr(test, ts(type = "number"))]
    pub width_us: i64,
    /// Where each begins, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number[]"))]
    pub start_us: Vec<i64>,
    /// Time of the first sample of each, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number[]"))]
    pub first_us: Vec<i64>,
    /// How many samples; those that are not a number count for nothing.
    #[cfg_attr(test, ts(type = "number[]"))]
    pub count: Vec<u64>,
    /// The least.
    pub min: Vec<f64>,
    /// The greatest.
    pub max: Vec<f64>,
    /// The mean; null where the sum is beyond what a double holds.
    pub mean: Vec<Option<f64>>,
    /// The first.
    pub first: Vec<f64>,
    /// The last.
    pub last: Vec<f64>,
}

/// Which samples.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct SamplesQuery {
    /// Abbreviation of the message.
    pub message: String,
    /// Number of the entity.
    pub entity: u8,
    /// Fields, separated by commas; all when left out or empty.
    pub fields: Option<String>,
    /// From this time on, µs since 1970 UTC.
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC.
    pub to_us: i64,
    /// At most so many, 1 to 10000; 1000 when left out. An answer has 8 MiB at most, so that it can hold fewer.
    pub limit: Option<u32>,
    /// Samples to pass over, 0 to 100000; from the answer before.
    pub skip: Option<u32>,
}

/// Samples as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Samples {
    /// The columns of a row.
    pub fields: Vec<SeriesField>,
    /// The samples, in order of time.
    pub rows: Vec<SampleRow>,
    /// How to ask for those that did not fit; null when these are all.
    pub next: Option<Next>,
}

/// One sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SampleRow {
    /// Its time, by the sender's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// When it first came ashore, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub received_us: i64,
    /// Numbers, texts, nested messages; null for what is not a number or absent.
    #[cfg_attr(test, ts(type = "unknown[]"))]
    pub values: Vec<serde_json::Value>,
}

/// Where the rest of an answer begins: the same question with these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Next {
    /// The new `from_us`.
    #[cfg_attr(test, ts(type = "number"))]
    pub from_us: i64,
    /// The new `to_us`.
    #[cfg_attr(test, ts(type = "number"))]
    pub to_us: i64,
    /// The new `skip`.
    pub skip: u32,
}
