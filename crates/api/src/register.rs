//! The register of a study: whose tag was heard, by which receiver, for which project.
//!
//! One entry has one kind and one name, by which others refer to it. A text that is empty and a number that is null are not
//! known. Times are µs since 1970 UTC.

use crate::{LogWord, Wording};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// What an entry is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum RegisterKind {
    /// A study that animals, tags and deployments belong to.
    Project,
    /// A person who leads a project or is its contact.
    Person,
    /// An animal that carries a tag, or carried one.
    Animal,
    /// A transmitter.
    Tag,
    /// A hydrophone with its electronics.
    Receiver,
    /// A receiver on a vessel for a time.
    Deployment,
}

/// A study.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterProject {
    /// Its short name or code, as portals know it.
    pub name: String,
    /// Its title.
    pub title: String,
    /// The name of the person who leads it.
    pub principal_investigator: String,
    /// The name of the person who answers questions.
    pub contact: String,
    /// How to cite it.
    pub citation: String,
    /// The licence of its data, by SPDX, such as `CC-BY-4.0`.
    pub licence: String,
    /// Remarks.
    pub notes: String,
}

/// A person.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterPerson {
    /// The name as it is published.
    pub name: String,
    /// Where they work.
    pub affiliation: String,
    /// ORCID, such as `0000-0002-1825-0097`; its check digit is checked.
    pub orcid: String,
    /// Remarks.
    pub notes: String,
}

/// An animal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterAnimal {
    /// Its name or number in the study.
    pub name: String,
    /// The name of its project.
    pub project: String,
    /// Scientific name of the species.
    pub scientific_name: String,
    /// The species' number in WoRMS (AphiaID).
    #[cfg_attr(test, ts(type = "number | null"))]
    pub aphia_id: Option<i64>,
    /// Common name of the species.
    pub common_name: String,
    /// Length, mm.
    pub length_mm: Option<f64>,
    /// Which length that is, such as `total` or `fork`.
    pub length_type: String,
    /// Weight, g.
    pub weight_g: Option<f64>,
    /// `F`, `M` or `U` for unknown.
    pub sex: String,
    /// Stage of life, such as `smolt`.
    pub life_stage: String,
    /// When it was caught.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub capture_us: Option<i64>,
    /// Where it was caught, in words.
    pub capture_place: String,
    /// WGS-84 latitude of the catch, degrees.
    pub capture_lat_deg: Option<f64>,
    /// WGS-84 longitude of the catch, degrees.
    pub capture_lon_deg: Option<f64>,
    /// When it was released with its tag.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub release_us: Option<i64>,
    /// Where it was released, in words.
    pub release_place: String,
    /// WGS-84 latitude of the release, degrees.
    pub release_lat_deg: Option<f64>,
    /// WGS-84 longitude of the release, degrees.
    pub release_lon_deg: Option<f64>,
    /// The group with which it was released.
    pub release_group: String,
    /// Remarks.
    pub notes: String,
}

/// A tag, in one animal from when to when.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterTag {
    /// What people call it; protocol and number when left empty.
    pub name: String,
    /// The name of its project.
    pub project: String,
    /// Protocol as receivers name it, such as `R64K` or `OPs`.
    pub protocol: String,
    /// Its number.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub tag_id: Option<i64>,
    /// Carrier, kHz; any when null.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub frequency_khz: Option<i64>,
    /// Frequency and code space as portals write them, such as `A69-1303`; made of protocol and frequency when empty.
    pub codespace: String,
    /// Serial number of the maker.
    pub serial: String,
    /// Who made it.
    pub manufacturer: String,
    /// Its model.
    pub model: String,
    /// What it measures, such as `depth`.
    pub sensor_type: String,
    /// The value is slope · count + intercept.
    pub sensor_slope: Option<f64>,
    /// See the slope.
    pub sensor_intercept: Option<f64>,
    /// Unit of the value, such as `m`.
    pub sensor_unit: String,
    /// Least time from ping to ping, s.
    pub interval_min_s: Option<f64>,
    /// Greatest time from ping to ping, s.
    pub interval_max_s: Option<f64>,
    /// The name of the animal that carries it; empty for a reference tag.
    pub animal: String,
    /// From when on; from the beginning when null.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Until when; to the end when null.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// Remarks.
    pub notes: String,
}

/// A receiver.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterReceiver {
    /// What people call it; model and serial number when left empty.
    pub name: String,
    /// Serial number, as in its lines.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub serial: Option<i64>,
    /// Model as portals write it, such as `TBR700`.
    pub model: String,
    /// Who made it.
    pub manufacturer: String,
    /// Remarks.
    pub notes: String,
}

/// A receiver on a vessel for a time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterDeployment {
    /// What people call it; receiver and begin when left empty.
    pub name: String,
    /// The name of the receiver.
    pub receiver: String,
    /// IMC address of the vessel.
    pub vessel: Option<u16>,
    /// The name of the project.
    pub project: String,
    /// From when on.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub from_us: Option<i64>,
    /// Until when; null while it lasts.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
    /// Depth of the hydrophone below the surface, m.
    pub depth_m: Option<f64>,
    /// WGS 84 latitude of a fixed station, degrees; null on a vessel that moves.
    pub lat_deg: Option<f64>,
    /// Its longitude, degrees.
    pub lon_deg: Option<f64>,
    /// Remarks.
    pub notes: String,
}

/// The contents of an entry, by its kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum RegisterRecord {
    /// A project.
    Project(RegisterProject),
    /// A person.
    Person(RegisterPerson),
    /// An animal.
    Animal(RegisterAnimal),
    /// A tag.
    Tag(RegisterTag),
    /// A receiver.
    Receiver(RegisterReceiver),
    /// A deployment.
    Deployment(RegisterDeployment),
}

/// An entry of the register.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterEntry {
    /// Its number; never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with each change, from 1.
    pub revision: u32,
    /// Its contents.
    pub record: RegisterRecord,
    /// Who changed it last, and when.
    pub written: LogWord,
    /// Whether the requester may change or delete it.
    pub may_change: bool,
}

/// The register, or one kind of it, by name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterAnswer {
    /// Counts changes of the whole register.
    #[cfg_attr(test, ts(type = "number"))]
    pub version: i64,
    /// Entries, by kind and name.
    pub entries: Vec<RegisterEntry>,
}

/// Which entries.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
pub struct RegisterQuery {
    /// `project`, `person`, `animal`, `tag`, `receiver` or `deployment`; all when left out.
    pub kind: Option<String>,
}

/// An entry that is changed: all of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterChange {
    /// The revision that is changed; 409 when there is a newer one.
    pub revision: u32,
    /// Its new content. The kind cannot change.
    pub record: RegisterRecord,
}

/// Which state of an entry is deleted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct RegisterDeleteQuery {
    /// The revision that is deleted; 409 when there is a newer one.
    pub revision: u32,
}

/// How a file of entries is taken.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct RegisterImportQuery {
    /// The kind of its lines: `project`, `person`, `animal`, `tag`, `receiver` or `deployment`.
    pub kind: String,
    /// Whether it is done. Otherwise the answer says what would be changed, and nothing is.
    pub apply: Option<bool>,
    /// `version` of the answer that said what would be changed: 409 when the register was changed since.
    pub version: Option<i64>,
}

/// The changes by a file of entries, made or only planned.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterImport {
    /// Whether it is done.
    pub applied: bool,
    /// Counts changes of the whole register.
    #[cfg_attr(test, ts(type = "number"))]
    pub version: i64,
    /// Entries that are new.
    pub added: u32,
    /// Entries that say something else.
    pub changed: u32,
    /// Unchanged entries.
    pub same: u32,
    /// Problems of the file; nothing is imported while there is one.
    pub problems: Vec<RegisterProblem>,
    /// New and changed entries, line by line.
    pub changes: Vec<RegisterImportChange>,
}

/// What is wrong, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterProblem {
    /// Line of the file, the header being 1; null where an entry that is not in the file would be wrong.
    pub line: Option<u32>,
    /// Column; empty where the whole line is meant.
    pub column: String,
    /// What is wrong, and what to do.
    pub text: String,
    /// Of what pages make `text` in their reader's language; absent where it is English only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub says: Option<Wording>,
}

/// The changes by one line of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterImportChange {
    /// Line of the file, the header being 1.
    pub line: u32,
    /// Name of the entry.
    pub name: String,
    /// Whether it is new.
    pub is_new: bool,
    /// Values that differ, or are new.
    pub fields: Vec<RegisterFieldChange>,
}

/// A field that says something else.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RegisterFieldChange {
    /// Its column.
    pub column: String,
    /// Its old value, as in a file.
    pub before: String,
    /// Its new value.
    pub after: String,
}
