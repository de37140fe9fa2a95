//! An alarm, its record, and what is kept over a restart.

use super::{Kind, LONGEST_SHELF, Priority, TEXT_CHARS};
use api::{AlarmSaying, Said, say};
use imc::Address;
use std::collections::VecDeque;
use units::{MonoTime, UtcTime};

/// An alarm's number; grows, and is never used again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AlarmId(pub u64);

/// The key of an alarm.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The vessel; `None` for the server itself.
    pub vessel: Option<Address>,
    /// The kind of alarm.
    pub kind: Kind,
    /// Which part of it; empty where there is only one.
    pub part: String,
}

/// Trouble that holds at the moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trouble {
    /// Its vessel, kind and part.
    pub key: Key,
    /// How urgent.
    pub priority: Priority,
    /// What, by codes with figures.
    pub says: Vec<AlarmSaying>,
}

impl Trouble {
    /// What, in English.
    pub fn text(&self) -> String {
        let one = |saying: &AlarmSaying| api::filled(saying.template(), &saying.values(day_and_time));
        let all: Vec<String> = self.says.iter().map(one).collect();
        let mut text = all.join("; ");
        super::shorten(&mut text);
        text
    }
}

/// Day and time of day (UTC), as alarms write them.
pub fn day_and_time(us: i64) -> [String; 2] {
    let at = UtcTime::from_micros(us).civil();
    [
        format!("{:04}-{:02}-{:02}", at.year, at.month, at.day),
        format!("{:02}:{:02}:{:02}Z", at.hour, at.minute, at.second),
    ]
}

/// Where an alarm is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Nothing is wrong.
    Normal,
    /// Wrong, and not acknowledged.
    Unacknowledged,
    /// Wrong, and known; or a caution.
    Acknowledged,
    /// Was wrong, and not acknowledged.
    Returned,
}

impl State {
    /// The word for people and machines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Unacknowledged => "unacknowledged",
            Self::Acknowledged => "acknowledged",
            Self::Returned => "returned",
        }
    }

    /// The state of this name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Normal, Self::Unacknowledged, Self::Acknowledged, Self::Returned]
            .into_iter()
            .find(|one| one.name() == name)
    }
}

/// Who did something, and when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signature {
    /// The person.
    pub by: String,
    /// Time of the action.
    pub at: UtcTime,
}

/// A shelved alarm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shelving {
    /// By whom and when.
    pub said: Signature,
    /// Until when, by UTC as it was then.
    pub until: UtcTime,
    /// The reason that the person gave.
    pub reason: String,
    pub(super) ends: MonoTime,
}

/// An alarm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alarm {
    /// Its number.
    pub id: AlarmId,
    /// Its vessel, kind and part.
    pub key: Key,
    /// Where it is in its life.
    pub state: State,
    /// How urgent.
    pub priority: Priority,
    /// What, by codes with figures.
    pub says: Vec<AlarmSaying>,
    /// The same in English.
    pub text: String,
    /// Since when it is wrong, or was.
    pub since: UtcTime,
    /// Since when it is not wrong any more; `None` while it is.
    pub over: Option<UtcTime>,
    /// How often it came since it was normal.
    pub count: u32,
    /// Who acknowledged it.
    pub acknowledged: Option<Signature>,
    /// Whether it became more urgent because it was not acknowledged.
    pub escalated: bool,
    /// Whether it comes and goes so fast that it is held.
    pub chatters: bool,
    /// Shelved for a time.
    pub shelved: Option<Shelving>,
    /// The alarm that it is part of at present, so that it is not reported itself.
    pub collapsed: Option<Kind>,
    /// How often it sounded; it sounds when this grows.
    pub sounded: u32,
    pub(super) revision: u64,
    pub(super) raised: MonoTime,
    pub(super) sounds_next: MonoTime,
    /// The last observation, and since when it holds.
    pub(super) holds: bool,
    pub(super) turned: MonoTime,
    pub(super) raises: VecDeque<MonoTime>,
}

impl Alarm {
    /// Whether it is reported: neither normal, nor shelved, nor part of another.
    pub fn is_told(&self) -> bool {
        self.state != State::Normal && self.shelved.is_none() && self.collapsed.is_none()
    }

    /// Whether a person has to acknowledge it.
    pub fn wants_acknowledgement(&self) -> bool {
        self.is_told() && matches!(self.state, State::Unacknowledged | State::Returned)
    }
}

/// An event of an alarm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Number of the change, growing.
    pub revision: u64,
    /// Time of the event.
    pub at: UtcTime,
    /// The alarm.
    pub id: AlarmId,
    /// Its vessel, kind and part.
    pub key: Key,
    /// How urgent it was then.
    pub priority: Priority,
    /// `raised`, `again`, `more urgent`, `escalated`, `acknowledged`, `returned`, `over`, `shelved` or `off the shelf`.
    pub what: &'static str,
    /// The person who did it; empty where no person did.
    pub by: String,
    /// The alarm's words by codes; empty where the words are a person's.
    pub says: Vec<AlarmSaying>,
    /// The alarm's words, or a person's.
    pub text: String,
}

/// Why an alarm stays unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AlarmRefused {
    /// There is no such alarm.
    #[error("there is no such alarm any more")]
    Gone,
    /// It needs no acknowledgement.
    #[error("this alarm is acknowledged already, or a caution, which needs no acknowledgement")]
    Known,
    /// It must be seen.
    #[error("an emergency cannot be shelved: acknowledge it")]
    Emergency,
    /// The time is invalid.
    #[error("an alarm can be shelved for 1 minute to {n} hours", n = LONGEST_SHELF.as_secs() / 3600)]
    Time,
    /// The reason is missing or too long.
    #[error("say why, in 1 to {TEXT_CHARS} characters")]
    Reason,
}

impl AlarmRefused {
    /// The same with its wording.
    pub fn said(self) -> Said {
        match self {
            Self::Gone => say("there is no such alarm any more"),
            Self::Known => {
                say("this alarm is acknowledged already, or a caution, which needs no acknowledgement")
            }
            Self::Emergency => say("an emergency cannot be shelved: acknowledge it"),
            Self::Time => say("an alarm can be shelved for 1 minute to {n} hours")
                .with("n", LONGEST_SHELF.as_secs() / 3600),
            Self::Reason => say("say why, in 1 to {most} characters").with("most", TEXT_CHARS),
        }
        .into()
    }
}

/// What is kept of an alarm over a restart of the server.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Saved {
    /// Its number.
    pub id: AlarmId,
    /// Its vessel, kind and part.
    pub key: Key,
    /// Where it was in its life.
    pub state: State,
    /// How urgent.
    pub priority: Priority,
    /// Its words by codes.
    pub says: Vec<AlarmSaying>,
    /// Its words.
    pub text: String,
    /// Since when.
    pub since: UtcTime,
    /// Since when not any more.
    pub over: Option<UtcTime>,
    /// How often it came.
    pub count: u32,
    /// Who acknowledged it.
    pub acknowledged: Option<Signature>,
    /// Whether it became more urgent by waiting.
    pub escalated: bool,
    /// Shelved: by whom, until when, and why.
    pub shelved: Option<(Signature, UtcTime, String)>,
}

impl From<&Alarm> for Saved {
    fn from(alarm: &Alarm) -> Self {
        let shelf = |shelf: &Shelving| (shelf.said.clone(), shelf.until, shelf.reason.clone());
        Self {
            id: alarm.id,
            key: alarm.key.clone(),
            state: alarm.state,
            priority: alarm.priority,
            says: alarm.says.clone(),
            text: alarm.text.clone(),
            since: alarm.since,
            over: alarm.over,
            count: alarm.count,
            acknowledged: alarm.acknowledged.clone(),
            escalated: alarm.escalated,
            shelved: alarm.shelved.as_ref().map(shelf),
        }
    }
}
