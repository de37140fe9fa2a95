//! A field of an entry: its name in files, its valid values, and its form in a cell.

use api::{RegisterKind, Wording, say};
use units::UtcTime;

/// The valid values of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// A text in one line of so many letters at most.
    Line(usize),
    /// A text of so many letters at most.
    Text(usize),
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// The name of an entry of another kind.
    Name(RegisterKind),
    /// An ORCID.
    Orcid,
    /// A number from, to.
    Real(f64, f64),
    /// A whole number from, to.
    Whole(i64, i64),
    /// A time.
    Time,
    /// A vessel.
    Vessel,
}

/// A field of a kind of entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Its name in files and in the API.
    pub name: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// Its valid values.
    pub rule: Rule,
    /// Whether it must say something.
    pub needed: bool,
}

impl Column {
    /// Its meaning, in words of any language.
    pub fn meaning(&self) -> Wording {
        say(self.about)
    }
}

/// The place of a field's value in an entry.
#[derive(Debug, PartialEq)]
pub enum Slot<'r> {
    /// A text; empty where it is not known.
    Text(&'r mut String),
    /// A number.
    Real(&'r mut Option<f64>),
    /// A whole number.
    Whole(&'r mut Option<i64>),
    /// A time, µs since 1970 UTC.
    Time(&'r mut Option<i64>),
    /// A vessel's IMC address.
    Vessel(&'r mut Option<u16>),
}

impl Slot<'_> {
    /// Whether nothing is known.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Text(text) => text.is_empty(),
            Self::Real(value) => value.is_none(),
            Self::Whole(value) | Self::Time(value) => value.is_none(),
            Self::Vessel(value) => value.is_none(),
        }
    }

    /// As it stands in a cell; vessels are called by `vessel`.
    pub(crate) fn cell(&self, vessel: &dyn Fn(u16) -> String) -> String {
        match self {
            Self::Text(text) => (*text).clone(),
            Self::Real(value) => value.map_or_else(String::new, |value| value.to_string()),
            Self::Whole(value) => value.map_or_else(String::new, |value| value.to_string()),
            Self::Time(value) => {
                value.map_or_else(String::new, |value| short(&UtcTime::from_micros(value).to_string()))
            }
            Self::Vessel(value) => value.map_or_else(String::new, vessel),
        }
    }
}

impl Rule {
    /// The fault of a value, and the remedy; `None` where it is valid. References are checked elsewhere.
    pub(crate) fn wrong(self, slot: &Slot<'_>) -> Option<Wording> {
        match (self, slot) {
            (Self::Line(most) | Self::Text(most), Slot::Text(text)) => {
                wrong_text(text, most, matches!(self, Self::Line(_)))
            }
            (Self::Name(_), Slot::Text(text)) => wrong_text(text, NAME_LETTERS, true),
            (Self::OneOf(words), Slot::Text(text)) => (!text.is_empty() && !words.contains(&text.as_str()))
                .then(|| say("`{text}` is not one of {words}; write one of them, or leave it empty").with("text", shown(text)).with("words", words.join(", "))),
            (Self::Orcid, Slot::Text(text)) => (!text.is_empty() && !crate::is_orcid(text)).then(|| {
                say("`{text}` is not an ORCID, or a digit of it is wrong; write it like 0000-0002-1825-0097, as it stands on orcid.org").with("text", shown(text))
            }),
            (Self::Real(from, to), Slot::Real(Some(value))) => (!(from..=to).contains(value))
                .then(|| say("{value} is not within {from} to {to}; look at its unit").with("value", value).with("from", from).with("to", to)),
            (Self::Whole(from, to), Slot::Whole(Some(value))) => (!(from..=to).contains(value))
                .then(|| say("{value} is not within {from} to {to}").with("value", value).with("from", from).with("to", to)),
            (Self::Time, Slot::Time(Some(value))) => (!TIMES_US.contains(value))
                .then(|| say("{value} is not a time from 1970 to 2255; give µs since 1970 UTC").with("value", value)),
            _ => None,
        }
    }
}

/// Letters of a name.
pub(crate) const NAME_LETTERS: usize = 80;
/// Times that JavaScript holds exactly (µs since 1970 UTC).
const TIMES_US: std::ops::RangeInclusive<i64> = 0..=9_007_199_254_740_991;

fn wrong_text(text: &str, most: usize, one_line: bool) -> Option<Wording> {
    let letters = text.chars().count();
    if letters > most {
        return Some(
            say("has {letters} characters; at most {most} are allowed: shorten it")
                .with("letters", letters)
                .with("most", most),
        );
    }
    if one_line && text.contains(['\n', '\t']) {
        return Some(say("has several lines: write one"));
    }
    text.chars()
        .any(|letter| letter.is_control() && letter != '\n' && letter != '\t')
        .then(|| say("has control characters in it: write it without them"))
}

/// The beginning of a user's text, enough to find it by.
pub(crate) fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

/// A time without decimals that say nothing.
fn short(text: &str) -> String {
    text.strip_suffix(".000000Z").map_or_else(|| text.to_owned(), |whole| format!("{whole}Z"))
}
