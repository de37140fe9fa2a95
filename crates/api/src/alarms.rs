//! What is wrong, and who knows of it.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// An alarm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Alarm {
    /// Its number; grows, and is never used again.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: u64,
    /// IMC address of the vessel; null for the server itself.
    pub vessel: Option<u16>,
    /// What the vessel calls itself, or its address; null for the server itself.
    pub vessel_name: Option<String>,
    /// What, for machines: `not_heard`, `position`, `battery`, …
    pub kind: String,
    /// Which part of the vessel; empty where there is only one.
    pub part: String,
    /// `unacknowledged`, `acknowledged`, `returned`, or `normal` for one that is over.
    pub state: String,
    /// `emergency`, `alarm`, `warning` or `caution`.
    pub priority: String,
    /// What, in words with figures.
    pub text: String,
    /// Why such an alarm comes.
    pub cause: String,
    /// What follows if nobody does anything.
    pub consequence: String,
    /// What to do.
    pub action: String,
    /// Since when it is wrong, or was, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub since_us: i64,
    /// Since when it is not wrong any more, µs since 1970 UTC; null while it is.
    #[serde(default)]
    #[cfg_attr(test, ts(type = "number | null"))]
    pub over_us: Option<i64>,
    /// How often it came since it was normal.
    pub count: u32,
    /// Who said they know; null for nobody.
    pub acknowledged: Option<AlarmWord>,
    /// Whether it became more urgent because nobody acknowledged it.
    pub escalated: bool,
    /// Whether it comes and goes so fast that it is held.
    pub chatters: bool,
    /// Put aside for a time; null for not.
    pub shelved: Option<AlarmShelf>,
    /// Of which other alarm it is part at present, and is not told besides; null for none.
    pub collapsed: Option<String>,
    /// How often it sounded: a client sounds when this grows.
    pub sounded: u32,
    /// Whether somebody has to say that they know.
    pub wants_acknowledgement: bool,
}

/// Somebody's word about an alarm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmWord {
    /// The person.
    pub by: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
}

/// An alarm put aside.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmShelf {
    /// By whom.
    pub by: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Until when, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub until_us: i64,
    /// Why.
    pub reason: String,
}

/// Something that happened to an alarm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmNote {
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// The alarm's number.
    #[cfg_attr(test, ts(type = "number"))]
    pub id: u64,
    /// IMC address of the vessel; null for the server itself.
    pub vessel: Option<u16>,
    /// What the vessel was called then; null for the server itself.
    pub vessel_name: Option<String>,
    /// What, for machines.
    pub kind: String,
    /// How urgent it was then.
    pub priority: String,
    /// `raised`, `again`, `more urgent`, `escalated`, `acknowledged`, `returned`, `over`, `shelved` or
    /// `off the shelf`.
    pub what: String,
    /// Who did it; empty for nobody.
    pub by: String,
    /// The alarm's words, or the person's.
    pub text: String,
}

/// What is wrong now, and what happened to alarms lately.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmList {
    /// What is not normal, and what is put aside; the most urgent first.
    pub standing: Vec<Alarm>,
    /// The latest changes since the server started, the newest first.
    pub history: Vec<AlarmNote>,
}

/// Which changes of alarms.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct AlarmHistoryQuery {
    /// IMC address of a vessel; all that one may see, and the server, when left out.
    pub vessel: Option<u16>,
    /// `emergency`, `alarm`, `warning` or `caution`; all when left out.
    pub priority: Option<String>,
    /// From this time on, µs since 1970 UTC.
    pub from_us: Option<i64>,
    /// Before this time, µs since 1970 UTC.
    pub to_us: Option<i64>,
    /// Older than the change with this number: `next` of the page before.
    pub before: Option<i64>,
    /// At most so many, 1 to 1000; 200 when left out.
    pub limit: Option<u32>,
}

/// What happened to alarms, over restarts of the server.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmHistory {
    /// The newest first.
    pub notes: Vec<AlarmNote>,
    /// What to ask for as `before` to get older ones; null where there are none.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub next: Option<i64>,
}

/// How an alarm is put aside.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ShelveAsk {
    /// For how many minutes, 1 to 720.
    pub minutes: u32,
    /// Why, in 1 to 300 characters.
    pub reason: String,
}
