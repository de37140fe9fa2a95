//! No-go areas: what people close to all vessels, beside what the chart closes.

use crate::LogWord;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// A no-go area as requested.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NoGoAreaRequest {
    /// What people call it: 1 to 80 characters in one line.
    pub name: String,
    /// Why it is closed; at most 500 characters.
    #[serde(default)]
    pub reason: String,
    /// Latitude and longitude (°) of its corners, 3 to 200; the last joins the first, and its sides do not cross. Sides are
    /// straight on a Mercator map.
    pub corners: Vec<[f64; 2]>,
}

/// No-go areas to be closed together: all of them, or none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NoGoAreasRequest {
    /// 1 to 200 of them.
    pub areas: Vec<NoGoAreaRequest>,
}

/// A no-go area.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NoGoArea {
    /// Its number; never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with each change, from 1.
    pub revision: u32,
    /// What it is.
    pub area: NoGoAreaRequest,
    /// Who closed it first, and when.
    pub written: LogWord,
    /// Who last changed it or closed it again; null if no one did.
    pub changed: Option<LogWord>,
    /// Who lifted it; null while it is closed.
    pub lifted: Option<LogWord>,
}

/// No-go areas, and whether vessels are kept out of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NoGoAreas {
    /// Those that are closed, by name; then, where they were asked for, those that were lifted last, newest first.
    pub areas: Vec<NoGoArea>,
    /// Whether plans and routes ashore are checked against exactly the closed ones. Vessels check by the sea chart
    /// aboard, which they get from here.
    pub in_force: bool,
    /// Why they are not in force, for people; null where they are.
    pub trouble: Option<String>,
    /// Whether the requester may close, change and lift areas.
    pub may_change: bool,
}

/// Which no-go areas.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct NoGoAreasQuery {
    /// Whether lifted areas are listed too; false if not given.
    pub lifted: Option<bool>,
}

/// A request to close areas, sent again by the same key, closes them once.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct NoGoAreaQuery {
    /// 1 to 64 characters that name this request.
    pub key: Option<String>,
}

/// A changed no-go area: all of its fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct NoGoAreaChange {
    /// The revision that is changed; 409 when there is a newer one.
    pub revision: u32,
    /// Its new content.
    pub area: NoGoAreaRequest,
    /// Whether it is closed from now on; false lifts it.
    pub closed: bool,
}
