//! Orders of people to vessels.

use crate::{GuardReason, Wording};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// An order that the server has written into the audit log and passed on. Whether the vessel carries it out is known
/// only from the vessel's later messages.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Ordered {
    /// The command's number. What was sent several times with one key has one number.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: u64,
    /// When it was handed on, by the server's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Whether it was sent: a transport leads to the vessel.
    pub reached: bool,
    /// Whether the vessel was not heard lately: the order is sent, perhaps once more, as soon as the vessel is heard
    /// within ten minutes.
    pub waits: bool,
    /// Whether a vessel of this address has a name here or was heard since the server started. Where not, the address may be
    /// a mistake; the stop is sent all the same.
    pub known: bool,
}

/// Parameters of a stop.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(default, deny_unknown_fields)]
pub struct StopQuery {
    /// Distinguishes the windows of a person; empty for scripts. 64 bytes at most.
    pub window: String,
    /// Names this stop, so that it can be sent again, and by the live socket too, and is carried out once: what comes
    /// with the same key from the same person for the same vessel within 10 minutes gets the same answer. Empty for a
    /// stop of its own. 64 bytes at most.
    pub key: String,
}

/// A request about the control of a vessel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct LeaseRequest {
    /// What to do with the control.
    pub action: LeaseAction,
    /// Why, for the one who has control; needed to take over. 200 characters at most.
    #[serde(default)]
    pub reason: String,
    /// Distinguishes the windows of a person; empty for scripts. 64 characters at most.
    #[serde(default)]
    pub window: String,
}

/// What is requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum LeaseAction {
    /// To have it: at once where it is free, else when its holder agrees or does not answer for 30 s.
    Request,
    /// To grant it to the requester.
    Grant,
    /// To decline the request; by the requester: to withdraw it.
    Decline,
    /// To give it back.
    Release,
    /// To keep it: it ends 60 s after the last of these.
    Renew,
    /// To have it at once.
    Take,
}

/// Who has control of a vessel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Lease {
    /// IMC address of the vessel.
    pub vessel: u16,
    /// Who has it; null while it is free.
    pub holder: Option<LeaseHolder>,
    /// Who asked for it; null while no one has.
    pub waiting: Option<LeaseWaiting>,
    /// What happened last; null while nothing has since the server started.
    pub last: Option<LeaseChange>,
}

/// The one who has control.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LeaseHolder {
    /// The person's name.
    pub name: String,
    /// Which of the person's windows.
    pub window: String,
    /// Since when, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub since_us: i64,
    /// Until when unless it is renewed, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub until_us: i64,
}

/// A pending request for control.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LeaseWaiting {
    /// The person's name.
    pub name: String,
    /// Which of the person's windows.
    pub window: String,
    /// Why, in the person's words; may be empty.
    pub reason: String,
    /// When it is granted without an answer, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub granted_us: i64,
}

/// A change of the control of a vessel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LeaseChange {
    /// `granted`, `requested`, `handed over`, `granted without an answer`, `declined`, `withdrawn`, `released`,
    /// `expired` or `taken over`.
    pub change: String,
    /// Who did it, or whom it concerns where it happened automatically.
    pub who: String,
    /// Who had control before, or whose request it was; null for no other person.
    pub from: Option<String>,
    /// Why, in their words; may be empty.
    pub reason: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
}

/// An order to a vessel, from the window that has control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct OrderRequest {
    /// What to do.
    pub order: Order,
    /// The window that has control; empty for scripts.
    #[serde(default)]
    pub window: String,
}

/// Orders to a vessel. Queries need no control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Order {
    /// Start a plan that is stored aboard.
    #[serde(rename = "plan.start")]
    PlanStart {
        /// Its name.
        plan_id: String,
    },
    /// Stop the plan that runs.
    #[serde(rename = "plan.stop")]
    PlanStop {},
    /// Go to a place and stay there.
    #[serde(rename = "goto")]
    Goto {
        /// WGS-84 latitude, degrees, north positive.
        lat_deg: f64,
        /// WGS-84 longitude, degrees, east positive.
        lon_deg: f64,
        /// Speed, m/s, 0.1 to 5.
        speed_mps: f32,
    },
    /// Remove a plan from the vessel.
    #[serde(rename = "plan.delete")]
    PlanDelete {
        /// Its name.
        plan_id: String,
    },
    /// Ask which plans are stored aboard; asks only.
    #[serde(rename = "plan.list")]
    PlanList {},
    /// Ask for a plan; asks only.
    #[serde(rename = "plan.get")]
    PlanGet {
        /// Its name.
        plan_id: String,
    },
    /// Ask for the parameters of an entity; asks only.
    #[serde(rename = "parameters.query")]
    ParametersQuery {
        /// The entity's label.
        entity: String,
    },
    /// Change parameters of an entity.
    #[serde(rename = "parameters.set")]
    ParametersSet {
        /// The entity's label.
        entity: String,
        /// Names and values.
        values: Vec<Parameter>,
    },
    /// Keep the parameters of an entity over restarts. Vessels do not answer this.
    #[serde(rename = "parameters.save")]
    ParametersSave {
        /// The entity's label.
        entity: String,
    },
}

/// A parameter of an entity.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value, as text.
    pub value: String,
}

/// An order and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Command {
    /// Its number; grows.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: u64,
    /// IMC address of the vessel.
    pub vessel: u16,
    /// Who ordered it.
    pub by: String,
    /// Like `plan.start`.
    pub order: String,
    /// Its subject, in words; may be empty.
    pub subject: String,
    /// The stages reached, in order.
    pub steps: Vec<CommandStep>,
    /// Whether nothing more is expected.
    pub over: bool,
    /// The plan that was asked for; only where a single command is asked for.
    pub plan: Option<PlanGiven>,
    /// The parameters that the vessel reported; only where a single command is asked for.
    pub parameters: Option<Vec<Parameter>>,
}

/// A stage that a command has reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct CommandStep {
    /// `accepted`, `sent`, `received`, `executing`, `effect seen`, or the end of another kind: `refused`, `expired`,
    /// `timed out`.
    pub stage: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// The vessel's words, or why; may be empty.
    pub text: String,
    /// Of what pages make `text` in their reader's language; absent of a vessel's own words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub says: Option<Wording>,
    /// Whether it was reached after the command had timed out; `text` begins with `late` then.
    #[serde(default)]
    pub late: bool,
    /// The leg for which the vessel's guard refused it, where it named one; null else.
    pub leg: Option<GuardReason>,
}

/// A plan as a vessel has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanGiven {
    /// Its name.
    pub plan_id: String,
    /// MD5 of its specification as IMC has it, hexadecimal.
    pub md5: String,
    /// How many maneuvers it has.
    pub maneuvers: u32,
    /// Latitude and longitude where its first maneuver begins, degrees; null where that is not a place.
    pub first_deg: Option<[f64; 2]>,
    /// All of it, as IMC JSON.
    #[cfg_attr(test, ts(type = "unknown"))]
    pub specification: serde_json::Value,
}

/// The plans that a vessel stores, as last reported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlansAboard {
    /// When they were reported, µs since 1970 UTC; null if never.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub time_us: Option<i64>,
    /// By name.
    pub plans: Vec<PlanAboard>,
}

/// A plan that a vessel stores.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct PlanAboard {
    /// Its name.
    pub plan_id: String,
    /// Bytes of its specification.
    pub size: u16,
    /// When it was changed, by the vessel's clock, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub changed_us: Option<i64>,
    /// Who changed it.
    pub changed_by: String,
    /// MD5 of its specification as IMC has it, hexadecimal.
    pub md5: String,
}
