//! The sea chart: what the set holds, how deep it is, and what the guard against grounding says of a plan.
//!
//! Places are degrees, WGS 84; depths are metres below the chart's datum, negative where it dries.

use crate::PlanPlace;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// The chart set of the server.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartSet {
    /// Names its contents, for the address of tiles; null where there is no chart, which
    /// `lutra-server chart import` changes.
    pub set: Option<String>,
    /// Why the chart file cannot be used; null where all is well.
    pub trouble: Option<String>,
    /// The charts in it by name.
    pub cells: Vec<ChartCell>,
    /// The box that they cover; null where that is empty.
    pub bounds: Option<ChartBounds>,
    /// Whether a chart in it says of itself that it is not for navigation.
    pub not_for_navigation: bool,
    /// Least depth in which an operator may steer a vessel by hand (m).
    pub navigable_m: f64,
    /// Least depth in which it may sail autonomously (m).
    pub autonomous_m: f64,
}

/// One chart of the set.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartCell {
    /// Name of the cell, or of the file without its ending.
    pub name: String,
    /// Edition.
    pub edition: String,
    /// Number of the last update.
    pub update: String,
    /// Compilation scale, 1 : this; 0 if unknown.
    pub scale: u32,
    /// Usage band, 1 overview to 6 berthing; 0 for what is not a cell.
    pub band: u8,
    /// Date of issue (YYYYMMDD).
    pub issued: String,
    /// Its producer's comment.
    pub comment: String,
    /// Whether its depths and land tile what it covers, without gap or overlap; null for what is not a cell.
    pub whole: Option<bool>,
}

/// A box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartBounds {
    /// Least latitude (°).
    pub south_deg: f64,
    /// Least longitude (°).
    pub west_deg: f64,
    /// Greatest latitude (°).
    pub north_deg: f64,
    /// Greatest longitude (°).
    pub east_deg: f64,
}

/// Of which chart set a tile is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ChartTileQuery {
    /// The digest that `/api/v1/chart` gives as `set`. With it the answer may be kept for good.
    pub set: Option<String>,
}

/// A place on the chart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct ChartAtQuery {
    /// Latitude (°).
    pub lat_deg: f64,
    /// Longitude (°).
    pub lon_deg: f64,
    /// Objects within this distance are listed (m), 0 to 2000; 25 when left out.
    pub within_m: Option<f64>,
    /// Name or IMC address of the vessel whose own limits apply, where it reported them.
    pub vessel: Option<String>,
}

/// How deep it is, and what decides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartDepth {
    /// `land`, `obstacle`, `unknown-depth`, `no-data`, `too-low`, `intertidal` or `water`.
    pub kind: String,
    /// Least charted depth (m); null where it is not water of known depth.
    pub least_m: Option<f64>,
    /// Greatest charted depth of the area (m), where given.
    pub greatest_m: Option<f64>,
    /// Margin to the least depth for autonomous sailing (m): negative = too shallow.
    pub margin_m: Option<f64>,
    /// Whether a vessel may sail there autonomously.
    pub autonomous: bool,
    /// Whether it may be driven there.
    pub navigable: bool,
    /// Where that is: latitude (°).
    pub lat_deg: f64,
    /// Where that is: longitude (°).
    pub lon_deg: f64,
    /// The object that decides, numbered as in tiles; null where nothing is charted.
    pub object: Option<u32>,
    /// Its class, an acronym of S-57.
    pub class: Option<String>,
    /// Its class in words.
    pub words: Option<String>,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// The chart it is from.
    pub cell: Option<String>,
    /// Edition of that chart.
    pub edition: Option<String>,
    /// Last update of that chart.
    pub update: Option<String>,
    /// Compilation scale of that chart, 1 : this.
    pub scale: Option<u32>,
    /// Zone of confidence (CATZOC): 1 = A1, 2 = A2, 3 = B, 4 = C, 5 = D, 6 = unassessed.
    pub zone: Option<u8>,
}

/// What is charted at a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartNear {
    /// How deep it is.
    pub depth: ChartDepth,
    /// Objects nearby, the nearest first, then the areas that hold the place, the smallest first; up to 50 in all.
    pub objects: Vec<ChartObject>,
}

/// An object of the chart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartObject {
    /// Its number, as in tiles.
    pub id: u32,
    /// Its class, an acronym of S-57.
    pub class: String,
    /// Its class in words.
    pub words: String,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// `point`, `line`, `area` or `sounding`.
    pub geometry: String,
    /// How far it is (m); 0 within an area.
    pub distance_m: f64,
    /// Depth of a sounding (m).
    pub depth_m: Option<f64>,
    /// What the chart says of it.
    pub attributes: Vec<ChartAttribute>,
    /// The chart it is from.
    pub cell: String,
    /// Edition of that chart.
    pub edition: String,
    /// Last update of that chart.
    pub update: String,
    /// Compilation scale of that chart, 1 : this; 0 if unknown.
    pub scale: u32,
}

/// One attribute of an object.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartAttribute {
    /// Its acronym in S-57.
    pub name: String,
    /// What it is, in words.
    pub words: String,
    /// Its value as charted.
    pub value: String,
    /// Its value in words, with its unit.
    pub text: String,
}

/// A way to be checked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartCorridorRequest {
    /// Latitude and longitude of its points (°), 2 to 500.
    pub points: Vec<[f64; 2]>,
    /// Half the width of the corridor (m), 0 to 1000.
    pub half_width_m: f64,
}

/// How deep it is along a way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartCorridor {
    /// Length of all of it (m).
    pub length_m: f64,
    /// From point to point.
    pub pieces: Vec<ChartPiece>,
    /// The charted depth right below the way, at its points and evenly between them.
    pub profile: Vec<ChartProfilePoint>,
}

/// One piece of a way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartPiece {
    /// Where it begins along the way (m).
    pub from_m: f64,
    /// Its length (m).
    pub length_m: f64,
    /// How far along the way its worst spot is (m).
    pub along_m: f64,
    /// The worst spot within the width.
    pub worst: ChartDepth,
}

/// One point of a profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ChartProfilePoint {
    /// How far along the way (m).
    pub along_m: f64,
    /// Least charted depth (m); null where it is not water of known depth.
    pub depth_m: Option<f64>,
    /// What is there, as in ChartDepth.
    pub kind: String,
}

/// The guard's verdict on a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Guard {
    /// `ok`, `warnings` or `refused`.
    pub outcome: String,
    /// Why it is refused where no leg is the reason: `too-large` for the guard, `chart-unreadable`, or `no-go-areas` where the
    /// chart lacks some; null else.
    pub cause: Option<String>,
    /// All of it in one line.
    pub text: String,
    /// Least depth in which the vessel may sail autonomously (m), against which the plan is checked.
    pub autonomous_m: f64,
    /// Whether these are limits that the vessel reported; else they are those of the server.
    pub of_vessel: bool,
    /// Why it is refused: a leg each; up to 100.
    pub reasons: Vec<GuardReason>,
    /// Parts that were not checked, or not well; up to 100.
    pub warnings: Vec<GuardWarning>,
}

/// A leg that is refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct GuardReason {
    /// Name of the maneuver.
    pub maneuver: String,
    /// Which part of it: `transit`, `track`, `circle`, `station` or `drift`.
    pub part: String,
    /// Where the leg begins; null where only a vessel's sentence is known of it.
    pub from: Option<PlanPlace>,
    /// Where it ends; null like `from`.
    pub to: Option<PlanPlace>,
    /// Number of the leg within the part, from 0.
    pub number: u32,
    /// `land`, `obstacle`, `unknown-depth`, `no-data`, `too-low`, `too-shallow`, `too-shallow-alone`, `entry-prohibited` or
    /// `entry-restricted`.
    pub code: String,
    /// In words.
    pub text: String,
    /// Where it is worst: latitude (°).
    pub lat_deg: f64,
    /// Where it is worst: longitude (°).
    pub lon_deg: f64,
    /// Least charted depth there (m); null where it is not water of known depth.
    pub depth_m: Option<f64>,
    /// Class of the object that decides, an acronym of S-57.
    pub object: Option<String>,
    /// Name of the area that may not be entered, where it has one and that is why.
    pub area: Option<String>,
    /// The chart it is from.
    pub cell: Option<String>,
    /// Compilation scale of that chart, 1 : this.
    pub scale: Option<u32>,
    /// Margin of the depth (m): negative = too shallow.
    pub margin_m: Option<f64>,
}

/// A part that was not checked, or not well.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct GuardWarning {
    /// Name of the maneuver; null for the plan itself.
    pub maneuver: Option<String>,
    /// `start-unknown`, `unchecked`, `drifts-on`, `poor-chart`, `entry-prohibited` or `entry-restricted`.
    pub code: String,
    /// What the code is about: of `unchecked` the kind of maneuver, of `poor-chart` the chart, of an area its name and chart;
    /// null where nothing more is known.
    pub about: Option<String>,
    /// In words.
    pub text: String,
}
