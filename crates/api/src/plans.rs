//! Plans ashore: as an operator draws them, as they are stored, and what it takes to sail them.
//!
//! Places are degrees, WGS 84; bearings degrees clockwise from north. A plan's name is its name aboard.

use crate::{Guard, ImportNote};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::{IntoParams, ToSchema};

/// A plan as an operator draws it: its maneuvers are sailed in their order.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanDocument {
    /// Its name, ashore and aboard; 1 to 60 bytes.
    pub name: String,
    /// What it is for; up to 500 letters.
    pub description: String,
    /// IMC address of the vessel it is for; null for any.
    pub vessel: Option<u16>,
    /// Whether it starts over at its end.
    pub repeat: bool,
    /// What to do, in this order.
    pub maneuvers: Vec<PlanStep>,
}

/// One maneuver of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanStep {
    /// Its name, which no other maneuver of the plan has; 1 to 60 bytes.
    pub id: String,
    /// How fast.
    pub speed: PlanSpeed,
    /// What to do.
    pub task: PlanTask,
}

/// A speed in a unit that IMC knows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanSpeed {
    /// How much of it.
    pub value: f64,
    /// Of what.
    pub unit: SpeedUnit,
}

/// Units of speeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum SpeedUnit {
    /// Metres per second over ground.
    Mps,
    /// Revolutions per minute of both motors.
    Rpm,
    /// Percent of full actuation.
    Percent,
}

/// A place, WGS 84.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanPlace {
    /// Latitude (°).
    pub lat_deg: f64,
    /// Longitude (°).
    pub lon_deg: f64,
}

/// What a maneuver does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum PlanTask {
    /// Go to a place.
    Goto {
        /// Where to.
        at: PlanPlace,
    },
    /// Go along points.
    FollowPath {
        /// The points; up to 2000.
        points: Vec<PlanPlace>,
    },
    /// Drift near a place, and drive back when too far from it.
    StationKeeping {
        /// Around where.
        at: PlanPlace,
        /// How far the vessel may drift (m).
        radius_m: f64,
        /// How long after the arrival (s); 0 until stopped.
        duration_s: u16,
    },
    /// Circle a place.
    Loiter {
        /// Around where.
        at: PlanPlace,
        /// Radius of the circle (m).
        radius_m: f64,
        /// How long on the circle (s); 0 until stopped.
        duration_s: u16,
        /// Which way round.
        clockwise: bool,
    },
    /// Sweep an area in parallel lines.
    Rows {
        /// Where the first row starts.
        at: PlanPlace,
        /// Direction of the first row (°).
        bearing_deg: f64,
        /// How far the sideways step is turned clockwise (°).
        cross_angle_deg: f64,
        /// Extent across the rows (m).
        width_m: f64,
        /// Length of a row (m).
        length_m: f64,
        /// Distance between rows (m).
        step_m: f64,
        /// How far rows are overrun before turning (m), 0 to 255.
        curve_offset_m: u8,
        /// Share of the step that is taken at the upper end of rows (%); 100 is the same at both.
        alternation_percent: u8,
        /// Turns are squares instead of diagonals.
        square_curve: bool,
        /// The first curve goes to the right.
        curve_right: bool,
    },
}

/// A stored plan, with what it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct StoredPlan {
    /// Its number ashore.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Grows with every change; a change names the one it was made from.
    pub revision: u32,
    /// Whether its latest changes were only saved automatically, not by a person.
    pub draft: bool,
    /// Who changed it last.
    pub author: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub updated_us: i64,
    /// What is drawn.
    pub plan: PlanDocument,
    /// What it takes, and what is wrong with it.
    pub check: PlanCheck,
}

/// A plan in the list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanSummary {
    /// Its number ashore.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: i64,
    /// Its name, ashore and aboard.
    pub name: String,
    /// IMC address of the vessel it is for; null for any.
    pub vessel: Option<u16>,
    /// Grows with every change.
    pub revision: u32,
    /// Whether its latest changes were only saved automatically.
    pub draft: bool,
    /// Who changed it last.
    pub author: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub updated_us: i64,
    /// How many maneuvers.
    pub maneuvers: u32,
    /// How many problems keep it from being sailed.
    pub problems: u32,
    /// MD5 of the plan as it would be aboard, 32 hexadecimal digits; null where it cannot be.
    pub digest: Option<String>,
    /// What all of it takes.
    pub total: PlanCost,
}

/// What a plan takes and what is wrong with it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanCheck {
    /// Errors that keep it from being sailed; none for a valid plan. A vessel's own limits may be narrower.
    pub problems: Vec<PlanTrouble>,
    /// Warnings for its author.
    pub warnings: Vec<PlanTrouble>,
    /// What all of it takes, from its first place on; of a plan that repeats, one round. Empty while it has problems.
    pub total: PlanCost,
    /// What each maneuver takes, and where it leads, in their order. Empty while there are problems.
    pub maneuvers: Vec<PlanLeg>,
    /// MD5 of the plan as it would be aboard, 32 hexadecimal digits; null while it has problems.
    pub digest: Option<String>,
    /// The guard's verdict, the way to its first place left out; null while it has problems
    /// and where there is no chart. An upload or start is judged again with the way from where the vessel is.
    pub guard: Option<Guard>,
}

/// A problem or warning of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanTrouble {
    /// Name of the maneuver; null for the plan itself.
    pub maneuver: Option<String>,
    /// What, for programs; `other` where there are words only.
    pub code: String,
    /// The code's subject: a quantity, a kind of maneuver; null where it is the whole plan.
    pub about: Option<String>,
    /// The figures of the code by their names, SI units.
    pub values: BTreeMap<String, f64>,
    /// What, in words.
    pub text: String,
}

/// What a maneuver or plan takes; null where that is unknown, as where it lasts until it is stopped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanCost {
    /// Way (m).
    pub length_m: Option<f64>,
    /// Time (s).
    pub duration_s: Option<f64>,
    /// Energy from the battery (J), an estimate.
    pub energy_j: Option<f64>,
}

/// What a maneuver takes and where it leads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanLeg {
    /// Its name.
    pub id: String,
    /// What it takes, with the way to it.
    pub cost: PlanCost,
    /// Where it leads, to be drawn.
    pub places: Vec<PlanPlace>,
}

/// A change of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanChange {
    /// The revision that the change was made from. Another in the store refuses the change: 409, with the newer
    /// plan as `newer` beside `error`.
    pub revision: u32,
    /// Whether it is only kept, not saved. What is saved must have no problems.
    pub draft: bool,
    /// All of it as it shall be.
    pub plan: PlanDocument,
}

/// A plan that is to be brought aboard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct PlanUploadRequest {
    /// IMC address of the vessel.
    pub vessel: u16,
    /// The revision that is meant; another in the store refuses the upload: 409.
    pub revision: u32,
    /// The window that has control of the vessel; empty for scripts.
    #[serde(default)]
    pub window: String,
}

/// One state that a plan had.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanRevision {
    /// Its number.
    pub revision: u32,
    /// Who made it.
    pub author: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub saved_us: i64,
    /// Whether it was only kept, not saved.
    pub draft: bool,
}

/// A plan from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ImportedPlan {
    /// The stored plan.
    pub stored: StoredPlan,
    /// Parts of the file that were left out, and what is odd.
    pub notes: Vec<ImportNote>,
}

/// Which state of a plan.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct PlanQuery {
    /// Its revision; the latest when left out.
    pub revision: Option<u32>,
}

/// How a plan is written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct PlanExportQuery {
    /// `imc` (JSON of a PlanSpecification), `geojson` or `gpx`; the last holds places only.
    pub format: String,
}

/// The plan to upload.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct PlanImportQuery {
    /// The file's name, by which the plan is called where the file has no better one; 1 to 200 letters.
    pub name: String,
}
