//! The operators' log book: notes by people, beside the vessels' own logs.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// A note in the log book.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogNote {
    /// Its number; never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with each correction, from 1.
    pub revision: u32,
    /// The time it is about, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// IMC address of the vessel it is about; null for a note on no vessel.
    pub vessel: Option<u16>,
    /// What people call the vessel; null where it has no name.
    pub vessel_name: Option<String>,
    /// WGS 84 latitude of the place it is about, north positive; null without a place.
    pub lat_deg: Option<f64>,
    /// WGS 84 longitude of the place it is about, east positive; null without a place.
    pub lon_deg: Option<f64>,
    /// What it says.
    pub text: String,
    /// Who wrote it.
    pub by: String,
    /// When it was written, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub written_us: i64,
    /// Who corrected it last; null if no one did. `/api/v1/logbook/{id}/earlier` gives its earlier texts.
    pub corrected: Option<LogWord>,
    /// Who withdrew it; null while it is valid.
    pub withdrawn: Option<LogWord>,
    /// Media type of its photo; null without a photo.
    pub photo: Option<String>,
    /// Whether the requester may correct or withdraw it.
    pub may_change: bool,
}

/// Who did something to a note or a mission, and when.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogWord {
    /// The person.
    pub by: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
}

/// The contents of a note.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogNoteRequest {
    /// 1 to 4,000 characters.
    pub text: String,
    /// IMC address of the vessel it is about; null for a note on no vessel.
    pub vessel: Option<u16>,
    /// WGS 84 latitude of the place it is about; null without a place.
    pub lat_deg: Option<f64>,
    /// WGS 84 longitude, with the latitude.
    pub lon_deg: Option<f64>,
    /// The time it is about, µs since 1970 UTC; the present when left out.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub time_us: Option<i64>,
}

/// Parameters of a note.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
pub struct LogNoteQuery {
    /// Names this note, so that it can be sent again where no answer came: what the same person sends with the same key is
    /// one note, and the first is the answer. 1 to 64 characters, unique; without it each is a note of its own.
    pub key: Option<String>,
    /// How long ago its writer sent it for the first time, ms, where no try before was answered; at most an hour. A note
    /// without a time is about that moment.
    pub waited_ms: Option<u32>,
}

/// A corrected note: all of its fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogNoteChange {
    /// The revision that is corrected; 409 when there is a newer one.
    pub revision: u32,
    /// Its new text. The time stays unchanged when left out.
    pub note: LogNoteRequest,
}

/// A note before a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogNoteRevision {
    /// Its revision.
    pub revision: u32,
    /// The time it was about, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// IMC address of the vessel; null for a note on no vessel.
    pub vessel: Option<u16>,
    /// WGS 84 latitude; null without a place.
    pub lat_deg: Option<f64>,
    /// WGS 84 longitude; null without a place.
    pub lon_deg: Option<f64>,
    /// What it said.
    pub text: String,
    /// Who wrote that, and when.
    pub written: LogWord,
}

/// Which notes.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct LogNotesQuery {
    /// Names or IMC addresses of vessels, with commas; all that one may see, and notes on no vessel, when left out.
    pub vessel: Option<String>,
    /// Beside those of `vessel` also notes on no vessel.
    pub general: Option<bool>,
    /// About this time or later, µs since 1970 UTC.
    pub from_us: Option<i64>,
    /// About a time before this, µs since 1970 UTC.
    pub to_us: Option<i64>,
    /// With these words in the text, in capital or small letters.
    pub text: Option<String>,
    /// Also those that were withdrawn.
    pub withdrawn: Option<bool>,
    /// `next` of the page before.
    pub before: Option<String>,
    /// At most so many, 1 to 500; 100 when left out.
    pub limit: Option<u32>,
}

/// Which notes in a file: all of them, on one page.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct LogNotesFileQuery {
    /// Names or IMC addresses of vessels, with commas; all whose data one may take out, and notes on no vessel, when left out.
    pub vessel: Option<String>,
    /// Beside those of `vessel` also notes on no vessel.
    pub general: Option<bool>,
    /// About this time or later, µs since 1970 UTC.
    pub from_us: Option<i64>,
    /// About a time before this, µs since 1970 UTC.
    pub to_us: Option<i64>,
    /// With these words in the text, in capital or small letters.
    pub text: Option<String>,
    /// Also those that were withdrawn.
    pub withdrawn: Option<bool>,
}

/// A page of the log book.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LogNotes {
    /// The newest first, by the time they are about.
    pub notes: Vec<LogNote>,
    /// Give this as `before` to ask for older notes; null on the last page.
    pub next: Option<String>,
}
