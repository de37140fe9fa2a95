//! Missions recorded by people: who did what with which vessels, from when to when.

use crate::LogWord;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// The contents of a mission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MissionRequest {
    /// 1 to 120 characters in one line.
    pub name: String,
    /// Who took part; at most 500 characters.
    pub people: String,
    /// Its purpose; at most 2,000 characters.
    pub purpose: String,
    /// Remarks; at most 4,000 characters.
    pub notes: String,
    /// IMC addresses of its vessels, 1 to 32.
    pub vessels: Vec<u16>,
    /// From this time on, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub from_us: i64,
    /// Before this time, µs since 1970 UTC; null while it lasts.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub to_us: Option<i64>,
}

/// A mission.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Mission {
    /// Its number; never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with each change, from 1.
    pub revision: u32,
    /// Its contents; of its vessels those that the requester may see.
    pub mission: MissionRequest,
    /// Who wrote it down first, and when.
    pub written: LogWord,
    /// Who changed it last; null if no one did.
    pub changed: Option<LogWord>,
    /// Who withdrew it; null while it is valid.
    pub withdrawn: Option<LogWord>,
    /// Whether the requester may change or withdraw it.
    pub may_change: bool,
}

/// A changed mission: all of its fields.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MissionChange {
    /// The revision that is changed; 409 when there is a newer one.
    pub revision: u32,
    /// Its new contents.
    pub mission: MissionRequest,
}

/// Parameters of a new mission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
pub struct MissionQuery {
    /// Names this mission, so that it can be sent again where no answer came: what the same person sends with the same key is
    /// one mission, and the first is the answer. 1 to 64 characters, unique; without it each is its own.
    pub key: Option<String>,
}

/// Which missions.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct MissionsQuery {
    /// Also those that were withdrawn.
    pub withdrawn: Option<bool>,
    /// `next` of the page before.
    pub before: Option<String>,
    /// At most so many, 1 to 500; 100 when left out.
    pub limit: Option<u32>,
}

/// A page of missions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Missions {
    /// Those that began last first.
    pub missions: Vec<Mission>,
    /// Give this as `before` to ask for older missions; null on the last page.
    pub next: Option<String>,
}

/// A mission's summary from the history.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MissionSummary {
    /// Up to when, µs since 1970 UTC: its end, or the present while it lasts.
    #[cfg_attr(test, ts(type = "number"))]
    pub to_us: i64,
    /// Vessel by vessel, of those that the requester may see.
    pub vessels: Vec<MissionVessel>,
}

/// What one vessel did in a mission.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MissionVessel {
    /// IMC address.
    pub vessel: u16,
    /// What people call it; null where it has no name.
    pub vessel_name: Option<String>,
    /// Time of its first recorded position, µs since 1970 UTC; null without positions.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub first_us: Option<i64>,
    /// Time of its last recorded position, µs since 1970 UTC; null without positions.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub last_us: Option<i64>,
    /// Distance from position to position, one a second (m); over gaps the straight way.
    pub distance_m: f64,
    /// Time with recorded positions (s): gaps of more than a minute do not count.
    pub recorded_s: f64,
    /// The battery's first charge (%), by FuelLevel; null if it was not recorded.
    pub battery_first_percent: Option<f64>,
    /// Its last charge (%).
    pub battery_last_percent: Option<f64>,
    /// Energy taken from its batteries (Wh), by voltage and current of each that reports its charge; null if none reports all three.
    /// Gaps of more than a minute do not count.
    pub energy_wh: Option<f64>,
    /// Names of the plans that it sailed, in the order in which they were begun first.
    pub plans: Vec<String>,
    /// Detections.
    #[cfg_attr(test, ts(type = "number"))]
    pub detections: u64,
    /// Different tags among them.
    #[cfg_attr(test, ts(type = "number"))]
    pub tags: u64,
}
