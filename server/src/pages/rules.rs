//! A person's rules for messages about alarms, and the messages sent, as the page under their name shows them.

use super::words::{said, t};
use api::Vessel;
use operations::alarms::Priority;
use shore::clock::written;
use shore::identity::Language;
use shore::notices::{Delivery, Rule, RuleChange};
use std::time::Duration;
use units::UtcTime;

/// A rule as the page shows it.
pub(super) struct RuleRow {
    pub(super) id: i64,
    pub(super) target: String,
    pub(super) about: String,
    pub(super) when: String,
    pub(super) form: RuleForm,
    /// Whether the form shows what was refused.
    pub(super) refused: bool,
}

/// What stands in the form of a rule.
pub(super) struct RuleForm {
    pub(super) target: String,
    pub(super) least: Priority,
    /// Address, name, and whether it is this rule's; that one also where it has no name any more.
    pub(super) vessels: Vec<(u16, String, bool)>,
    pub(super) every_vessel: bool,
    /// For how long nobody acknowledged an alarm: seconds, words, and whether it is this rule's.
    pub(super) waits: Vec<(u64, String, bool)>,
    pub(super) also_over: bool,
    /// Whether where to was refused: the field is marked, and the page's problem says why.
    pub(super) wrong: bool,
}

/// What somebody typed and was refused: it stands in its form again.
#[derive(Clone)]
pub(super) struct Refused {
    /// The rule that was to change; `None` for a new one.
    pub(super) id: Option<i64>,
    /// How a new rule's messages were to go.
    pub(super) way: &'static str,
    pub(super) typed: RuleChange,
    /// Whether where to is what was refused.
    pub(super) target: bool,
}

/// What a form offers of times without an acknowledgement (s).
const WAITS_S: [u64; 4] = [0, 60, 300, 1_800];

/// The times that a rule's form offers, its own among them.
fn waits(language: Language, own_s: u64) -> Vec<(u64, String, bool)> {
    let mut all: Vec<u64> = WAITS_S.to_vec();
    if !all.contains(&own_s) {
        all.push(own_s);
        all.sort_unstable();
    }
    let words = |after_s: u64| match after_s {
        0 => t(language, "at once").to_string(),
        other => t(language, "not acknowledged for {min} min").with("min", minutes(other)).to_string(),
    };
    all.into_iter().map(|after_s| (after_s, words(after_s), after_s == own_s)).collect()
}

/// Whole minutes, or with a decimal.
fn minutes(seconds: u64) -> String {
    if seconds.is_multiple_of(60) {
        (seconds / 60).to_string()
    } else {
        format!("{:.1}", Duration::from_secs(seconds).as_secs_f64() / 60.0)
    }
}

pub(super) fn rule_row(
    language: Language,
    rule: &Rule,
    vessels: &[Vessel],
    refused: Option<&Refused>,
) -> RuleRow {
    let ask = &rule.ask;
    let least = match ask.least {
        Priority::Emergency => t(language, "emergencies").to_string(),
        other => {
            t(language, "{priority} and worse").with("priority", said(language, other.name())).to_string()
        }
    };
    let of = ask.vessel.map(|address| name_of(address, vessels));
    let after_s = ask.after.as_secs();
    let begin = match after_s {
        0 => t(language, "at once"),
        other => t(language, "not acknowledged for {min} min").with("min", minutes(other)),
    };
    let refused = refused.filter(|refused| refused.id == Some(rule.id));
    RuleRow {
        id: rule.id,
        target: ask.target.clone(),
        about: format!("{least}, {}", of.as_deref().unwrap_or(said(language, "all vessels"))),
        when: if ask.also_over {
            t(language, "{begin}; and when it is over").with("begin", begin).to_string()
        } else {
            begin.to_string()
        },
        form: match refused {
            Some(refused) => refused_form(language, refused, vessels),
            None => rule_form(language, &RuleChange::from(ask.clone()), vessels),
        },
        refused: refused.is_some(),
    }
}

/// The form of a new rule, and how its messages are to go.
pub(super) fn new_rule(
    language: Language,
    vessels: &[Vessel],
    refused: Option<&Refused>,
) -> (RuleForm, &'static str) {
    if let Some(refused) = refused.filter(|refused| refused.id.is_none()) {
        return (refused_form(language, refused, vessels), refused.way);
    }
    let (target, after) = (String::new(), Duration::ZERO);
    let empty = RuleChange { target, least: Priority::Alarm, vessel: None, after, also_over: false };
    (rule_form(language, &empty, vessels), "")
}

fn rule_form(language: Language, rule: &RuleChange, vessels: &[Vessel]) -> RuleForm {
    let mut choices: Vec<(u16, String, bool)> = vessels
        .iter()
        .map(|vessel| (vessel.address, vessel.name.clone(), rule.vessel == Some(vessel.address)))
        .collect();
    if let (Some(address), false) = (rule.vessel, choices.iter().any(|choice| choice.2)) {
        choices.push((address, name_of(address, vessels), true));
    }
    RuleForm {
        target: rule.target.clone(),
        least: rule.least,
        vessels: choices,
        every_vessel: rule.vessel.is_none(),
        waits: waits(language, rule.after.as_secs()),
        also_over: rule.also_over,
        wrong: false,
    }
}

/// With what was typed.
fn refused_form(language: Language, refused: &Refused, vessels: &[Vessel]) -> RuleForm {
    RuleForm { wrong: refused.target, ..rule_form(language, &refused.typed, vessels) }
}

/// A vessel's name, or its address where it has none.
fn name_of(address: u16, vessels: &[Vessel]) -> String {
    let named = vessels.iter().find(|vessel| vessel.address == address);
    named.map_or_else(|| format!("0x{address:04x}"), |vessel| vessel.name.clone())
}

/// A message as the page shows it.
pub(super) struct MessageRow {
    pub(super) made: String,
    pub(super) subject: String,
    pub(super) outcome: String,
}

pub(super) fn message_row(language: Language, message: Delivery) -> MessageRow {
    let outcome = match (message.outcome.as_str(), message.words.as_str()) {
        ("", "") => t(language, "waits").to_string(),
        ("", words) => t(language, "waits; the last attempt: {words}").with("words", words).to_string(),
        (outcome, "") => said(language, outcome).to_owned(),
        (outcome, words) => format!("{}: {words}", said(language, outcome)),
    };
    MessageRow { made: written(UtcTime::from_micros(message.made_us)), subject: message.subject, outcome }
}
