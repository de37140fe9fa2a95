//! Texts for people that can be said in other languages: an English template with the values in its places, of which pages make
//! their reader's words by the catalogue (`words/nb.json`). Scripts and logs have the English text.

use crate::alarms::filled_by;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Deref;
use utoipa::ToSchema;

/// An English text with places for values: the key of a catalogue of words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Wording {
    /// Like `There is no person {name}.`
    pub template: String,
    /// What is put in the places, by their names.
    #[serde(default)]
    pub values: BTreeMap<String, String>,
}

/// A text that the catalogue has. A test of the web pages finds what is written within `say("…")`, and that Bokmål has it.
pub fn say(template: &'static str) -> Wording {
    Wording { template: template.to_owned(), values: BTreeMap::new() }
}

/// The same of a sentence without values that is kept as a constant: it is its own wording.
pub const fn fixed(sentence: &'static str) -> &'static str {
    sentence
}

impl Wording {
    /// Puts a value in the place of `{name}`.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl fmt::Display) -> Self {
        self.values.insert(name.to_owned(), value.to_string());
        self
    }

    /// The words of this template, English or of another language, with the values in their places.
    pub fn filling(&self, template: &str) -> String {
        filled_by(template, |name| self.values.get(name).map(String::as_str))
    }
}

/// A text in English, with its wording where it has one. What vessels and operating systems say has none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Said {
    text: String,
    wording: Option<Box<Wording>>,
}

impl Said {
    /// The text in English.
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// Of what words in other languages are made; absent where it is English only.
    pub fn wording(&self) -> Option<&Wording> {
        self.wording.as_deref()
    }

    /// Both parts.
    pub fn into_parts(self) -> (String, Option<Wording>) {
        (self.text, self.wording.map(|wording| *wording))
    }

    /// The same of one of several, as `area 2, …`: the number stands in the text, and by this name among the wording's values.
    #[must_use]
    pub fn numbered(self, name: &'static str, number: usize) -> Self {
        let wording = self.wording.map(|wording| Box::new(wording.with(name, number)));
        Self { text: format!("{name} {number}, {}", self.text), wording }
    }

    /// The same, where it is longer than this only its first characters, in English.
    #[must_use]
    pub fn at_most(mut self, chars: usize) -> Self {
        if let Some((end, _)) = self.text.char_indices().nth(chars) {
            self.text.truncate(end);
            self.wording = None;
        }
        self
    }
}

impl From<Wording> for Said {
    fn from(wording: Wording) -> Self {
        Self { text: wording.filling(&wording.template), wording: Some(Box::new(wording)) }
    }
}

impl From<String> for Said {
    fn from(text: String) -> Self {
        Self { text, wording: None }
    }
}

impl From<&str> for Said {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<Said> for String {
    fn from(said: Said) -> Self {
        said.text
    }
}

impl Deref for Said {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Said {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

impl PartialEq<str> for Said {
    fn eq(&self, other: &str) -> bool {
        self.text == other
    }
}

impl PartialEq<&str> for Said {
    fn eq(&self, other: &&str) -> bool {
        self.text == *other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_has_its_values_once_whatever_they_contain_and_keeps_what_it_is_made_of() {
        let said = Said::from(say("{who} asked {whom}.").with("who", "{whom}").with("whom", "nils"));
        assert_eq!(said, "{whom} asked nils.");
        let wording = said.wording().unwrap();
        assert_eq!(wording.filling("{whom} ble spurt av {who}."), "nils ble spurt av {whom}.");
        assert_eq!(Said::from("as it is").wording(), None);
    }

    #[test]
    fn one_of_several_keeps_its_words_and_has_its_number() {
        let said = Said::from(say("there are {n}").with("n", 1)).numbered("area", 2);
        assert_eq!(said, "area 2, there are 1");
        let wording = said.wording().unwrap();
        assert_eq!((wording.template.as_str(), wording.values["area"].as_str()), ("there are {n}", "2"));
        assert_eq!(wording.filling("det er {n}"), "det er 1");
    }

    #[test]
    fn what_is_cut_off_has_no_wording() {
        let long = Said::from(say("{all}").with("all", "æøå"));
        assert_eq!(long.clone().at_most(3), long);
        let cut = long.at_most(2);
        assert_eq!((cut.as_str(), cut.wording()), ("æø", None));
    }
}
