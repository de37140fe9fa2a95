//! Content and text of a message.

use super::settings::Settings;
use crate::clock;
use crate::identity::Language;
use crate::words::{self, said, t};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use units::UtcTime;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) enum What {
    /// An alarm is active.
    #[serde(rename = "alarm.raised")]
    Raised,
    /// An alarm that was reported is over.
    #[serde(rename = "alarm.over")]
    Over,
    /// A person tests whether messages arrive.
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

/// A message, as stored and as a webhook gets it.
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
    pub(super) fn subject(&self, language: Language) -> String {
        let Some(alarm) = &self.alarm else { return format!("[Lutra] {}", said(language, "Test message")) };
        let who = alarm.vessel_name.as_deref().unwrap_or(said(language, "server"));
        let text = words::alarm(language, &alarm.says, &alarm.text);
        let over = if self.event == What::Over { said(language, "over") } else { "" };
        let mark = if over.is_empty() { String::new() } else { format!("{over}: ") };
        let words = format!("[Lutra] {who}: {mark}{text} ({})", said(language, &alarm.priority));
        // A vessel's text may contain anything; a subject must be one line.
        words.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).take(200).collect()
    }

    /// The whole, as mail.
    pub(super) fn text(&self, language: Language, settings: &Settings) -> String {
        let mut text = match &self.alarm {
            Some(alarm) => self.of_alarm(language, alarm, settings),
            None => format!("{}\n", t(language, "Messages about alarms come to you by this way.")),
        };
        if self.last_for_an_hour {
            let last = t(
                language,
                "Many alarms came: this is the last message for an hour. Look at the page for what happens meanwhile.",
            );
            writeln!(text, "\n{last}").ok();
        }
        let why =
            t(language, "You asked for this message under your name on the pages, Messages about alarms.");
        writeln!(text, "\n{why}").ok();
        text
    }

    fn of_alarm(&self, language: Language, alarm: &api::Alarm, settings: &Settings) -> String {
        let mut text = String::new();
        let say = |english| said(language, english);
        let written = |us| clock::written(UtcTime::from_micros(us));
        let who = alarm.vessel_name.as_deref().unwrap_or(say("the server itself"));
        let what = words::alarm(language, &alarm.says, &alarm.text);
        writeln!(text, "{}: {what}", say(&alarm.priority)).ok();
        writeln!(text, "{}: {who}", say("Vessel")).ok();
        writeln!(text, "{}: {} UTC", say("Since"), written(alarm.since_us)).ok();
        if self.event == What::Over {
            writeln!(text, "{}: {} UTC", say("Over"), written(alarm.over_us.unwrap_or(self.time_us))).ok();
        } else {
            writeln!(text, "\n{}: {}", say("What to do"), say(&alarm.action)).ok();
            writeln!(text, "{}: {}", say("If ignored"), say(&alarm.consequence)).ok();
        }
        let page = alarm.vessel.map_or("/".to_owned(), |vessel| format!("/vessels/{vessel}"));
        if !settings.url.is_empty() {
            writeln!(text, "\n{}{page}", settings.url.trim_end_matches('/')).ok();
        }
        text
    }

    /// As a webhook gets it: the alarm's text in the language of the rule's owner.
    pub(super) fn posted(&self, language: Language) -> Self {
        let say = |english: &str| said(language, english).to_owned();
        let alarm = self.alarm.clone().map(|alarm| api::Alarm {
            text: words::alarm(language, &alarm.says, &alarm.text),
            cause: say(&alarm.cause),
            consequence: say(&alarm.consequence),
            action: say(&alarm.action),
            ..alarm
        });
        Self { alarm, ..self.clone() }
    }
}
