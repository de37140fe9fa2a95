//! What is wrong with a request's values, in words for people: the place, what stands there, and what belongs there.
//!
//! `serde` asks for the words of its errors here, for queries, forms and JSON alike.

use api::{Said, say};
use serde::de::{self, Expected, Unexpected};
use std::fmt;

/// Most characters of a value that are shown.
const SHOWN: usize = 60;
/// Most names that are listed.
const LISTED: usize = 30;

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wrong {
    /// Like `plan.legs[2].speed_mps`; empty for the whole.
    place: String,
    what: Said,
}

impl Wrong {
    /// Of the whole, or of a place that is put before it.
    pub(super) fn new(what: impl Into<Said>) -> Self {
        Self { place: String::new(), what: what.into() }
    }

    /// The same below a field.
    pub(super) fn below(self, field: &str) -> Self {
        let place = match self.place.as_str() {
            "" => field.to_owned(),
            place if place.starts_with('[') => format!("{field}{place}"),
            place => format!("{field}.{place}"),
        };
        Self { place, ..self }
    }

    /// A text that is not what belongs there, by Rust's name of the type.
    pub(super) fn value(value: &str, rust: &str) -> Self {
        Self::new(
            say("give {wanted}, not {found}").with_said("wanted", wanted(rust)).with("found", quoted(value)),
        )
    }

    /// Place and text.
    pub(crate) fn said(self) -> Said {
        if self.place.is_empty() { self.what } else { self.what.of_field(&self.place) }
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() { self.what.fmt(out) } else { write!(out, "{}: {}", self.place, self.what) }
    }
}

impl std::error::Error for Wrong {}

impl de::Error for Wrong {
    fn custom<T: fmt::Display>(text: T) -> Self {
        Self::new(Said::as_is(text.to_string()))
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let text = say("give {wanted}, not {found}").with_said("wanted", wanted(&expected.to_string()));
        Self::new(text.with_said("found", told(&found)))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        let text = say("give {wanted}, not {n} values").with_said("wanted", wanted(&expected.to_string()));
        Self::new(text.with("n", length))
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(say("this is missing")).below(field)
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::new(say("give it once")).below(field)
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let alike = suggest::alike(field, expected.iter().copied());
        let text = if expected.is_empty() {
            say("{name} is not known here, where nothing is expected")
        } else if alike.is_empty() {
            say("{name} is not known here; there are {all}").with("all", list(expected))
        } else {
            say("{name} is not known here; did you mean {all}?").with("all", list(&alike))
        };
        Self::new(text.with("name", quoted(field)))
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        let text = say("{value} is not one of {all}").with("value", quoted(variant));
        Self::new(text.with("all", list(expected)))
    }
}

fn list(names: &[&str]) -> String {
    names.iter().take(LISTED).copied().collect::<Vec<_>>().join(", ")
}

fn quoted(text: &str) -> String {
    let shown: String = text.chars().take(SHOWN).collect();
    format!("`{shown}{}`", if shown.len() < text.len() { "…" } else { "" })
}

/// What belongs there, by the words that `serde` has for it.
fn wanted(expected: &str) -> Said {
    let range = |first: i64, last: i64| {
        say("a whole number, {first} to {last}").with("first", first).with("last", last).into()
    };
    match expected {
        "u8" => range(0, u8::MAX.into()),
        "u16" => range(0, u16::MAX.into()),
        "u32" => range(0, u32::MAX.into()),
        "i8" => range(i8::MIN.into(), i8::MAX.into()),
        "i16" => range(i16::MIN.into(), i16::MAX.into()),
        "i32" => range(i32::MIN.into(), i32::MAX.into()),
        "u64" | "usize" => say("a whole number, 0 or more").into(),
        "i64" | "isize" => say("a whole number").into(),
        "f32" | "f64" => say("a number").into(),
        "bool" | "a boolean" => say("true or false").into(),
        "a string" | "a borrowed string" | "a character" | "string" | "variant identifier" => {
            say("a text").into()
        }
        other if other.starts_with("struct ") || other.contains("map") || other.contains("tagged enum") => {
            say("a JSON object").into()
        }
        other
            if ["a sequence", "tuple", "a tuple", "an array"].iter().any(|list| other.starts_with(list)) =>
        {
            say("a JSON list").into()
        }
        other => Said::as_is(other),
    }
}

/// What stands there.
fn told(found: &Unexpected<'_>) -> Said {
    match found {
        Unexpected::Bool(value) => Said::as_is(value.to_string()),
        Unexpected::Unsigned(value) => Said::as_is(value.to_string()),
        Unexpected::Signed(value) => Said::as_is(value.to_string()),
        Unexpected::Float(value) => Said::as_is(value.to_string()),
        Unexpected::Str(text) => Said::as_is(quoted(text)),
        Unexpected::Unit | Unexpected::Option => say("null").into(),
        Unexpected::Seq => say("a JSON list").into(),
        Unexpected::Map => say("a JSON object").into(),
        other => Said::as_is(other.to_string()),
    }
}
