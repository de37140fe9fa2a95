//! What a message tells, and its words.

use super::settings::Settings;
use crate::clock;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use units::UtcTime;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum What {
    /// An alarm stands.
    #[serde(rename = "alarm.raised")]
    Raised,
    /// An alarm that was told is over.
    #[serde(rename = "alarm.over")]
    Over,
    /// A person tries whether messages come.
    #[serde(rename = "test")]
    Test,
}

impl What {
    /// The word for machines and app.db.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Raised => "alarm.raised",
            Self::Over => "alarm.over",
            Self::Test => "test",
        }
    }
}

/// A message as it is kept and as a webhook gets it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Content {
    /// What happened.
    pub(super) event: What,
    /// When it was written, µs since 1970 UTC.
    pub(super) time_us: i64,
    /// The alarm as it was then.
    pub(super) alarm: Option<api::Alarm>,
    /// Whether this is the last message for an hour.
    #[serde(default)]
    pub(super) last_for_an_hour: bool,
}

impl Content {
    /// One line.
    pub(super) fn subject(&self) -> String {
        let Some(alarm) = &self.alarm else { return "[Lutra] Test message".to_owned() };
        let who = alarm.vessel_name.as_deref().unwrap_or("server");
        let over = if self.event == What::Over { "over: " } else { "" };
        let words = format!("[Lutra] {who}: {over}{} ({})", alarm.text, alarm.priority);
        // A vessel's words may hold anything; a subject is one line.
        words.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).take(200).collect()
    }

    /// The whole, as mail.
    pub(super) fn text(&self, settings: &Settings) -> String {
        let mut text = String::new();
        let written = |us| clock::written(UtcTime::from_micros(us));
        if let Some(alarm) = &self.alarm {
            let who = alarm.vessel_name.as_deref().unwrap_or("the server itself");
            writeln!(text, "{}: {}", alarm.priority, alarm.text).ok();
            writeln!(text, "Vessel: {who}\nSince: {} UTC", written(alarm.since_us)).ok();
            if self.event == What::Over {
                writeln!(text, "Over: {} UTC", written(alarm.over_us.unwrap_or(self.time_us))).ok();
            } else {
                writeln!(text, "\nWhat to do: {}\nIf ignored: {}", alarm.action, alarm.consequence).ok();
            }
            let page = alarm.vessel.map_or("/".to_owned(), |vessel| format!("/vessels/{vessel}"));
            if !settings.url.is_empty() {
                writeln!(text, "\n{}{page}", settings.url.trim_end_matches('/')).ok();
            }
        } else {
            writeln!(text, "Messages about alarms come to you by this way.").ok();
        }
        if self.last_for_an_hour {
            writeln!(
                text,
                "\nMany alarms came: this is the last message for an hour. Look at the page for what happens meanwhile."
            )
            .ok();
        }
        writeln!(text, "\nYou asked for this message under your name on the pages, Messages about alarms.")
            .ok();
        text
    }
}
