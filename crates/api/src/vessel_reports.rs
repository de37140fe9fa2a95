//! What vessels report on request: their parameters, and the plan that they sail.

use crate::PlanPlace;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A query to a vessel. It commands nothing, so it needs no control of the vessel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "about", rename_all = "lowercase", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum VesselQuery {
    /// Parameters.
    Parameters {
        /// Labels of entities; none for all that the vessel has.
        entities: Vec<String>,
    },
    /// Which plans are stored aboard.
    Plans {},
    /// A plan.
    Plan {
        /// Its name.
        plan_id: String,
    },
}

/// A query as sent. Its answer comes later on its own, or never.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct VesselQuerySent {
    /// When it was sent, by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// How many packets it took; 0 where the same was asked less than 2 s ago.
    pub packets: u32,
    /// Whether a transport leads to the vessel at present; else the query reached no one.
    pub reached: bool,
    /// Labels of the entities that were asked for their parameters.
    pub entities: Vec<String>,
}

/// The parameters of a vessel, as last reported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct VesselParameters {
    /// By the entity's label.
    pub entities: Vec<EntityReport>,
    /// Whether they come from the history: the vessel has reported none since the server started.
    pub recorded: bool,
}

/// The parameters of an entity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct EntityReport {
    /// Its label.
    pub entity: String,
    /// When it last reported any of them, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// By name.
    pub parameters: Vec<ParameterReport>,
    /// How many more it reported than are kept.
    pub left_out: u32,
}

/// A parameter as it was reported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ParameterReport {
    /// Its name.
    pub name: String,
    /// Its value, as text.
    pub value: String,
    /// Its value from the next start; null where the vessel does not report it.
    pub saved: Option<String>,
    /// Whether the value is longer than what is kept of it, so that it is not to be written back.
    pub cut: bool,
    /// When it was reported, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// What it means; null for parameters of other programs than Lutra's.
    pub about: Option<ParameterAbout>,
}

/// The meaning and valid values of a parameter of Lutra.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ParameterAbout {
    /// Its section of the configuration.
    pub section: String,
    /// Its effect, in a line.
    pub doc: String,
    /// Symbol of its unit; empty for pure numbers.
    pub unit: String,
    /// How many numbers it is, with commas between; null for text.
    pub items: Option<u32>,
    /// The least allowed; null for any.
    pub min: Option<f64>,
    /// The greatest allowed; null for any.
    pub max: Option<f64>,
    /// Its value where the configuration says nothing.
    pub default: String,
    /// Whether it can be changed while the vessel runs; else in its configuration file only.
    pub live: bool,
    /// Why a change deserves a second look; null for none.
    pub caution: Option<String>,
}

/// The plan that a vessel sails, as far as known ashore.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanUnderWay {
    /// Its name; null while the vessel sails none, or has not reported one.
    pub plan_id: Option<String>,
    /// The maneuver that the vessel is at; empty where it does not say.
    pub maneuver: String,
    /// From where the plan is known: `vessel`, `shore` (the vessel's digest is that of a plan kept ashore), or null for
    /// not at all.
    pub source: Option<String>,
    /// MD5 of its specification as IMC has it, hexadecimal; null while it is not known.
    pub digest: Option<String>,
    /// Where its maneuvers lead, in the order in which they are sailed.
    pub legs: Vec<RouteLeg>,
    /// Whether it begins again at its end.
    pub repeats: bool,
    /// Why it is not drawn; null where it is.
    pub trouble: Option<String>,
}

/// Where a maneuver leads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RouteLeg {
    /// Its name.
    pub id: String,
    /// What it is, in a word.
    pub kind: String,
    /// Its places, in order; none for one that follows another system or stays.
    pub places: Vec<PlanPlace>,
    /// The circle that the vessel keeps within, m; null for none.
    pub radius_m: Option<f64>,
}
