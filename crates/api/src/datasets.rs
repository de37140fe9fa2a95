//! Datasets: the detections of a query, frozen so that they can be cited, and links that share them.
//!
//! Times are µs since 1970 UTC. An empty text or a null number means no value.

use crate::{FlagCode, LogWord};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// How far a dataset is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum DatasetState {
    /// Nothing of it is published.
    Draft,
    /// It has a version that can be cited.
    Published,
    /// Its maker withdrew it: its name is still listed, but its data is no longer available.
    Withdrawn,
}

/// Which detections a dataset has. What is empty or null leaves nothing out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetQuery {
    /// Reported from this time on.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Reported before this time; where it is null or later than the publication, that is the end.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// Vessels by IMC address; empty for all: that needs the role on all vessels.
    pub vessels: Vec<u16>,
    /// Tags as protocol and number (`S256-101`) or as number alone (`101`).
    pub tags: Vec<String>,
    /// Projects of the register by name: of the tag, or of the animal that carried it.
    pub projects: Vec<String>,
    /// Corners of an area, 3 to 100, as `lat,lon;lat,lon;…` in degrees.
    pub area: String,
    /// Detections with one of these flags are left out.
    pub without: Vec<FlagCode>,
}

/// A dataset before it is published; each field may still change.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetDraft {
    /// Its title.
    pub title: String,
    /// What it is, how it was made, what to know before it is used.
    pub description: String,
    /// Who publishes it: the institution. Citation and DataCite need it.
    pub publisher: String,
    /// Names of people of the register, in the order in which they are cited.
    pub authors: Vec<String>,
    /// `CC-BY-4.0` (also where left empty), `CC0-1.0`, `CC-BY-NC-4.0`, or own words.
    pub licence: String,
    /// Day from which others get the data, such as `2027-01-31`, from its beginning in UTC; at once when empty.
    pub embargo_until: String,
    /// DOI that a registry has given, such as `10.5281/zenodo.1234`; empty where it has none.
    pub doi: String,
    /// Which detections.
    pub query: DatasetQuery,
}

/// An author as they stood in the register at publication.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetAuthor {
    /// The name.
    pub name: String,
    /// ORCID; empty where they have none.
    pub orcid: String,
    /// Where they work; empty where the register does not say.
    pub affiliation: String,
}

/// A vessel of a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetVessel {
    /// IMC address.
    pub system: u16,
    /// Its name at publication; empty where it had none.
    pub name: String,
}

/// The extent of detections.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetCovered {
    /// When the first was heard; null without detections.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub first_us: Option<i64>,
    /// When the last was.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub last_us: Option<i64>,
    /// WGS-84 latitude of the southernmost place, degrees; null where no place is known.
    pub south_deg: Option<f64>,
    /// Of the northernmost.
    pub north_deg: Option<f64>,
    /// WGS-84 longitude of the westernmost place, degrees.
    pub west_deg: Option<f64>,
    /// Of the easternmost.
    pub east_deg: Option<f64>,
}

/// A file as it was computed: the canonical CSV, which is the format `lutra` without anything for spreadsheets.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetContent {
    /// Detections.
    #[cfg_attr(test, ts(type = "number"))]
    pub rows: u64,
    /// Bytes of the canonical CSV.
    #[cfg_attr(test, ts(type = "number"))]
    pub bytes: u64,
    /// SHA-256 of it, in hexadecimal digits.
    pub sha256: String,
    /// Their extent.
    pub covered: DatasetCovered,
    /// The number of the canonical format: bytes of another number are not compared. 0 where it was not kept.
    #[serde(default)]
    pub format: u32,
    /// The program that wrote it, like `Lutra 0.1.0`.
    #[serde(default)]
    pub software: String,
}

/// A published version. It never changes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetVersion {
    /// 1, 2, …
    pub number: u32,
    /// Its title.
    pub title: String,
    /// What it is.
    pub description: String,
    /// Who publishes it.
    pub publisher: String,
    /// In the order in which they are cited.
    pub authors: Vec<DatasetAuthor>,
    /// An SPDX identifier, or own words.
    pub licence: String,
    /// Day from which others get the data; empty where at once.
    pub embargo_until: String,
    /// DOI; empty where it has none.
    pub doi: String,
    /// Which detections, with the vessels and the end of the time that publication gave it.
    pub query: DatasetQuery,
    /// Its vessels.
    pub vessels: Vec<DatasetVessel>,
    /// What it had at publication.
    pub content: DatasetContent,
    /// Who published it, and when.
    pub published: LogWord,
    /// How to cite it.
    pub citation: String,
}

/// Why a dataset was withdrawn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetWithdrawn {
    /// Who did it, and when.
    pub written: LogWord,
    /// The reason.
    pub reason: String,
}

/// A dataset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Dataset {
    /// Its number; never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with each change, from 1.
    pub revision: u32,
    /// How far it is.
    pub state: DatasetState,
    /// Who made it, and when.
    pub made: LogWord,
    /// The unpublished draft; null if the dataset has no draft.
    pub draft: Option<DatasetDraft>,
    /// Published versions, the newest first.
    pub versions: Vec<DatasetVersion>,
    /// Why it was withdrawn; null where it was not.
    pub withdrawn: Option<DatasetWithdrawn>,
    /// Whether the requester may change, publish, share and download it.
    pub may_change: bool,
}

/// A draft that is changed: all of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetChange {
    /// The revision that is changed; 409 when there is a newer one.
    pub revision: u32,
    /// Its new content.
    pub draft: DatasetDraft,
}

/// Publishes the draft, or makes the next one of the newest version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetStep {
    /// The revision that is meant; 409 when there is a newer one.
    pub revision: u32,
}

/// Withdraws a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetWithdrawal {
    /// The revision that is meant; 409 when there is a newer one.
    pub revision: u32,
    /// Why, for those who cited it.
    pub reason: String,
}

/// The archive's present answer to a published query.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetCheck {
    /// When that was computed.
    #[cfg_attr(test, ts(type = "number"))]
    pub checked_us: i64,
    /// Whether the bytes are those that were published.
    pub is_same: bool,
    /// Detections at publication.
    #[cfg_attr(test, ts(type = "number"))]
    pub rows: u64,
    /// Detections now.
    #[cfg_attr(test, ts(type = "number"))]
    pub rows_now: u64,
    /// SHA-256 of the canonical CSV now.
    pub sha256_now: String,
    /// What wrote the bytes that were published, where its canonical format is another one than now: other bytes say nothing of the
    /// archive then.
    pub written_by: Option<String>,
    /// In words.
    pub text: String,
}

/// How a file of a dataset is written.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
pub struct DatasetFileQuery {
    /// The format by name, as of `/api/v1/detections.csv`; the canonical CSV (`lutra`) when left out.
    pub format: Option<String>,
    /// Whether it is packed by gzip.
    pub gzip: Option<bool>,
}

/// A link that is made for others. What is empty or null narrows nothing.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetShareRequest {
    /// Which version; the newest when null.
    pub version: Option<u32>,
    /// For whom it is.
    pub label: String,
    /// How many days it opens, 1 to 730.
    pub days: u32,
    /// A password that is also required; none when empty.
    pub password: String,
    /// Name of the one account that can open it. Null: anyone with the address.
    pub person: Option<String>,
    /// Only what was reported from this time on.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Only what was reported before this time.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// Only these tags.
    pub tags: Vec<String>,
    /// Only within this area; where places are coarsened, the coarsened place counts.
    pub area: String,
    /// Places are given as the middle of a cell of about 100, 1000 or 10000 m; as they are when null.
    pub precision_m: Option<u32>,
}

/// A link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetShare {
    /// Its number.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// The version that it gives.
    pub version: u32,
    /// For whom it is.
    pub label: String,
    /// Whether it asks for a password.
    pub has_password: bool,
    /// The one account that can open it. Null: anyone with the address.
    #[serde(default)]
    pub person: Option<String>,
    /// When it ends.
    #[cfg_attr(test, ts(type = "number"))]
    pub expires_us: i64,
    /// Only what was reported from this time on.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Only what was reported before this time.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// Only these tags.
    pub tags: Vec<String>,
    /// Only within this area.
    pub area: String,
    /// About how long the side of a cell is; null where places are given as they are.
    pub precision_m: Option<u32>,
    /// What it gives.
    pub content: DatasetContent,
    /// Whether the archive gave other bytes than were published when the link was made.
    #[serde(default)]
    pub had_changed: bool,
    /// Who made it, and when.
    pub made: LogWord,
    /// Who revoked it, and when; null while it holds.
    pub revoked: Option<LogWord>,
    /// How often it was viewed.
    #[cfg_attr(test, ts(type = "number"))]
    pub views: i64,
    /// How often something was downloaded.
    #[cfg_attr(test, ts(type = "number"))]
    pub downloads: i64,
    /// When it was used last; null where never.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub used_us: Option<i64>,
}

/// A link that was made, with its address, which is shown this once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct DatasetShareMade {
    /// The link.
    pub share: DatasetShare,
    /// Its path on this server: `/s/…`. It gives access to the data without a login, unless it is for one account.
    pub path: String,
}

/// What was shared with the account that asks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SharedDataset {
    /// The path of its page on this server; its files lie below.
    pub path: String,
    /// The title of the dataset.
    pub title: String,
    /// The version that is shared.
    pub version: u32,
    /// How to cite it.
    pub citation: String,
    /// Detections that it gives.
    #[cfg_attr(test, ts(type = "number"))]
    pub rows: u64,
    /// Day on which the embargo ends. Empty: no embargo.
    pub embargo_until: String,
    /// Who shared it, and when.
    pub made: LogWord,
    /// When the share ends.
    #[cfg_attr(test, ts(type = "number"))]
    pub expires_us: i64,
}

/// What a visitor did by a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum ShareVisitKind {
    /// Looked at its page.
    View,
    /// Downloaded a file.
    Download,
    /// Gave a wrong password.
    WrongPassword,
}

/// A use of a link.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ShareVisit {
    /// Time of the visit.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// From which network address.
    pub address: String,
    /// What the visitor did.
    pub what: ShareVisitKind,
    /// Which file; empty where none.
    pub file: String,
}
