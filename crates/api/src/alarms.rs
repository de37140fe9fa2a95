//! What is wrong, and who has acknowledged it.

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
    /// What, by codes with figures, from which pages make words in a person's language; empty where it was kept by an older
    /// server.
    #[serde(default)]
    pub says: Vec<AlarmSaying>,
    /// The same in words: in English, for scripts and logs; in a webhook in the language of the person who asked for it.
    pub text: String,
    /// Why such an alarm comes.
    pub cause: String,
    /// What follows if no one acts on it.
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
    /// Who acknowledged it; null while no one has.
    pub acknowledged: Option<AlarmWord>,
    /// Whether it became more urgent because it was not acknowledged.
    pub escalated: bool,
    /// Whether it comes and goes so fast that it is held.
    pub chatters: bool,
    /// Shelved for a time; null if not.
    pub shelved: Option<AlarmShelving>,
    /// The alarm that it is part of at present, so that it is not reported itself; null for none.
    pub collapsed: Option<String>,
    /// How often it sounded: a client sounds when this grows.
    pub sounded: u32,
    /// Whether a person has to acknowledge it.
    pub wants_acknowledgement: bool,
}

/// One trouble, by its code and figures. Texts of a vessel or of the server's system are passed on unchanged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "code", rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum AlarmSaying {
    /// A part of the vessel reports a fault of its own.
    Part {
        /// Its label.
        part: String,
        /// `fault`, `error` or `failure`.
        state: String,
        /// Its own words; may be empty.
        words: String,
    },
    /// No position came since then.
    NoPosition {
        /// µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        since_us: i64,
    },
    /// Nothing came from the hydrophone since then.
    HydrophoneSilent {
        /// µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        since_us: i64,
    },
    /// Nothing came from the vessel since then.
    NotHeard {
        /// µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        since_us: i64,
    },
    /// Nothing came from the vessel since the server started.
    NeverHeard {
        /// When it started, µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        since_us: i64,
    },
    /// Another peer sends with the vessel's IMC address.
    OtherSource {
        /// Their address.
        peer: String,
        /// By which transport.
        transport: String,
    },
    /// Little charge is left.
    Charge {
        /// Percent.
        percent: i32,
    },
    /// The vessel's clock differs from the server's.
    Clock {
        /// The vessel's minus the server's (ms).
        #[cfg_attr(test, ts(type = "number"))]
        ahead_ms: i64,
    },
    /// The vessel has another sea chart than the shore.
    Chart {
        /// Whether it has any.
        held: bool,
        /// How they differ, and the state of the transfer.
        difference: ChartDifference,
    },
    /// The vessel wrote an error into its log book.
    LogBook {
        /// Which part did.
        part: String,
        /// What is said.
        words: String,
    },
    /// The server cannot record, or its history lags behind.
    Server {
        /// Why, in the words of its system.
        words: String,
    },
    /// The server's disk is nearly full.
    Disk {
        /// What is free (MiB).
        #[cfg_attr(test, ts(type = "number"))]
        free_mib: u64,
    },
    /// The server's certificate ends soon.
    CertificateEnds {
        /// Its file.
        file: String,
        /// When, µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        until_us: i64,
    },
    /// The server's certificate has ended.
    CertificateEnded {
        /// Its file.
        file: String,
        /// When, µs since 1970 UTC.
        #[cfg_attr(test, ts(type = "number"))]
        until_us: i64,
    },
    /// A new certificate or key cannot be used, and the earlier pair still is.
    CertificateRefused {
        /// Which file, why, and what to do, in the server's words.
        words: String,
    },
    /// The sea chart does not hold the no-go areas that people closed.
    NoGoAreas {
        /// Why, in the server's words.
        words: String,
    },
    /// There are more alarms than are kept.
    TooMany {
        /// Those without a place.
        #[cfg_attr(test, ts(type = "number"))]
        count: u64,
        /// How many are kept.
        #[cfg_attr(test, ts(type = "number"))]
        most: u64,
    },
}

impl AlarmSaying {
    /// The English words, with places for the values. Catalogues of other languages have them as keys.
    pub fn template(&self) -> &'static str {
        match self {
            Self::Part { words, .. } if words.is_empty() => "{part}: {state}",
            Self::Part { .. } => "{part}: {state}: {words}",
            Self::NoPosition { .. } => "no position since {time}",
            Self::HydrophoneSilent { .. } => "the hydrophone is silent since {time}",
            Self::NotHeard { .. } => "not heard since {time}",
            Self::NeverHeard { .. } => "not heard since the server started at {day} {time}",
            Self::OtherSource { .. } => {
                "{peer} sends as this vessel by the transport {transport} and is refused: only the vessel's link is trusted"
            }
            Self::Charge { .. } => "{percent} % charge left",
            Self::Clock { ahead_ms } if *ahead_ms > 0 => {
                "the vessel's clock is {seconds} s ahead of the server's"
            }
            Self::Clock { .. } => "the vessel's clock is {seconds} s behind the server's",
            Self::Chart { held, difference } => difference.template(*held),
            Self::LogBook { .. } => "{part}: {words}",
            Self::Server { .. } => "{words}",
            Self::Disk { .. } => "{free} GiB are free on the server's disk",
            Self::CertificateEnds { .. } => "the certificate {file} ends on {day} at {time}",
            Self::CertificateEnded { .. } => "the certificate {file} ended on {day} at {time}",
            Self::CertificateRefused { .. } => {
                "a new certificate cannot be used, the earlier one still is: {words}"
            }
            Self::NoGoAreas { .. } => "the no-go areas are not in force: {words}",
            Self::TooMany { .. } => "{count} alarms have no place in the list of {most}",
        }
    }

    /// The values for the places, as people read them. `time` gives the day and the time of day of µs since 1970 UTC.
    pub fn values(&self, time: impl Fn(i64) -> [String; 2]) -> Vec<(&'static str, String)> {
        match self {
            Self::Part { part, state, words } => {
                vec![("part", part.clone()), ("state", state.clone()), ("words", words.clone())]
            }
            Self::NoPosition { since_us }
            | Self::HydrophoneSilent { since_us }
            | Self::NotHeard { since_us }
            | Self::NeverHeard { since_us } => {
                let [day, time] = time(*since_us);
                vec![("day", day), ("time", time)]
            }
            Self::OtherSource { peer, transport } => {
                vec![("peer", peer.clone()), ("transport", transport.clone())]
            }
            Self::Charge { percent } => vec![("percent", percent.to_string())],
            Self::Clock { ahead_ms } => vec![("seconds", format!("{:.1}", ahead_ms.abs() as f64 / 1e3))],
            Self::Chart { difference, .. } => difference.values(),
            Self::Server { words } | Self::CertificateRefused { words } | Self::NoGoAreas { words } => {
                vec![("words", words.clone())]
            }
            Self::CertificateEnds { file, until_us } | Self::CertificateEnded { file, until_us } => {
                let [day, time] = time(*until_us);
                vec![("file", file.clone()), ("day", day), ("time", time)]
            }
            Self::LogBook { part, words } => vec![("part", part.clone()), ("words", words.clone())],
            Self::Disk { free_mib } => vec![("free", format!("{:.1}", *free_mib as f64 / 1024.0))],
            Self::TooMany { count, most } => vec![("count", count.to_string()), ("most", most.to_string())],
        }
    }
}

/// How a vessel's sea chart differs from the shore's, and the state of the transfer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "stage", rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum ChartDifference {
    /// Nothing is done about it.
    Other,
    /// The shore's is on its way.
    Fetching {
        /// How much of it is aboard (%).
        percent: u8,
    },
    /// The shore's is aboard and not in force yet.
    Waiting {
        /// Why, in the vessel's words.
        why: String,
    },
    /// The shore's could not be taken over.
    Failed {
        /// Why, in the vessel's words.
        why: String,
    },
    /// The vessel is set up to take none from ashore.
    Declined,
    /// There is no chart ashore.
    NoneAshore,
}

impl ChartDifference {
    /// The English words, with places for the values; `held` says whether the vessel has any chart.
    pub const fn template(&self, held: bool) -> &'static str {
        match (self, held) {
            (Self::Other, true) => "another sea chart than ashore",
            (Self::Other, false) => "no sea chart aboard",
            (Self::Fetching { .. }, true) => {
                "another sea chart than ashore; {percent} % of the shore's is transferred"
            }
            (Self::Fetching { .. }, false) => {
                "no sea chart aboard; {percent} % of the shore's is transferred"
            }
            (Self::Waiting { .. }, true) => {
                "another sea chart than ashore; the shore's is aboard and waits: {why}"
            }
            (Self::Waiting { .. }, false) => "no sea chart aboard; the shore's is aboard and waits: {why}",
            (Self::Failed { .. }, true) => {
                "another sea chart than ashore; the chart from shore could not be used: {why}"
            }
            (Self::Failed { .. }, false) => {
                "no sea chart aboard; the chart from shore could not be used: {why}"
            }
            (Self::Declined, true) => {
                "another sea chart than ashore; the vessel is set up not to take charts from ashore"
            }
            (Self::Declined, false) => {
                "no sea chart aboard; the vessel is set up not to take charts from ashore"
            }
            (Self::NoneAshore, true) => "there is no sea chart ashore to compare the vessel's with",
            (Self::NoneAshore, false) => "no sea chart aboard and no sea chart ashore",
        }
    }

    /// The values for the places.
    pub fn values(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Fetching { percent } => vec![("percent", percent.to_string())],
            Self::Waiting { why } | Self::Failed { why } => vec![("why", why.clone())],
            Self::Other | Self::Declined | Self::NoneAshore => Vec::new(),
        }
    }

    /// All of it in English.
    pub fn english(&self, held: bool) -> String {
        filled(self.template(held), &self.values())
    }
}

/// Puts each value in its place, `{name}`, once and from the left: what a value contains is never taken for a place.
pub fn filled(template: &str, values: &[(&'static str, String)]) -> String {
    filled_by(template, |name| {
        values.iter().find(|(known, _)| *known == name).map(|(_, value)| value.as_str())
    })
}

/// The same; `value` knows what belongs in a place.
pub(crate) fn filled_by<'a>(template: &str, value: impl Fn(&str) -> Option<&'a str>) -> String {
    let (mut text, mut rest) = (String::new(), template);
    while let Some((before, (after, value))) = rest.split_once('{').and_then(|(before, from)| {
        let (name, after) = from.split_once('}')?;
        Some((before, (after, value(name)?)))
    }) {
        text.push_str(before);
        text.push_str(value);
        rest = after;
    }
    text + rest
}

/// A person's acknowledgement of an alarm.
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
pub struct AlarmShelving {
    /// By whom.
    pub by: String,
    /// When, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub time_us: i64,
    /// Until when, µs since 1970 UTC.
    #[cfg_attr(test, ts(type = "number"))]
    pub until_us: i64,
    /// The reason that the person gave.
    pub reason: String,
}

/// An event of an alarm.
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
    /// The vessel's name then; null for the server itself.
    pub vessel_name: Option<String>,
    /// What, for machines.
    pub kind: String,
    /// How urgent it was then.
    pub priority: String,
    /// `raised`, `again`, `more urgent`, `escalated`, `acknowledged`, `returned`, `over`, `shelved` or
    /// `off the shelf`.
    pub what: String,
    /// The person who did it; empty where no person did.
    pub by: String,
    /// The alarm's words by codes with figures; empty where the words are a person's.
    #[serde(default)]
    pub says: Vec<AlarmSaying>,
    /// The alarm's words, or the person's.
    pub text: String,
}

/// The present alarms, and their latest events.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmList {
    /// Alarms that are not normal, and shelved ones; the most urgent first.
    pub standing: Vec<Alarm>,
    /// The latest changes since the server started, the newest first.
    pub history: Vec<AlarmNote>,
}

/// Which changes of alarms.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct AlarmHistoryQuery {
    /// Name or IMC address of a vessel; all that one may see, and the server, when left out.
    pub vessel: Option<String>,
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

/// The history of alarms, over restarts of the server.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AlarmHistory {
    /// The newest first.
    pub notes: Vec<AlarmNote>,
    /// The `before` of a query for older entries; null if these are the oldest.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub next: Option<i64>,
}

/// How an alarm is put aside.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ShelveRequest {
    /// For how many minutes, 1 to 720.
    pub minutes: u32,
    /// Why, in 1 to 300 characters.
    pub reason: String,
}
