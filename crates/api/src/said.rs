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
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub struct Wording {
    /// Like `There is no person {name}.`
    pub template: String,
    /// What is put in the places, by their names.
    #[serde(default)]
    pub values: BTreeMap<String, String>,
    /// Places that hold texts with words of their own, each text on a line; absent where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(no_recursion)]
    pub parts: Option<BTreeMap<String, Vec<Wording>>>,
}

/// A text that the catalogue has. A test of the web pages finds what is written within `say("…")`, and that Bokmål has it.
pub fn say(template: &'static str) -> Wording {
    Wording { template: template.to_owned(), values: BTreeMap::new(), parts: None }
}

/// A sentence without values that is kept as a constant; the catalogue has it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fixed(&'static str);

/// The same as [`say`] of a sentence without values that is kept as a constant.
pub const fn fixed(sentence: &'static str) -> Fixed {
    Fixed(sentence)
}

/// In English.
impl fmt::Display for Wording {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.in_words(&|english| english))
    }
}

impl Deref for Fixed {
    type Target = str;

    fn deref(&self) -> &str {
        self.0
    }
}

impl fmt::Display for Fixed {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.0)
    }
}

impl Wording {
    /// Puts a value in the place of `{name}`.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl fmt::Display) -> Self {
        self.values.insert(name.to_owned(), value.to_string());
        self
    }

    /// Puts a text that has words of its own in the place of `{name}`.
    #[must_use]
    pub fn with_said(self, name: &'static str, text: impl Into<Said>) -> Self {
        self.with_lines(name, [text.into()])
    }

    /// The same of several texts, each on a line.
    #[must_use]
    pub fn with_lines(mut self, name: &'static str, texts: impl IntoIterator<Item = Said>) -> Self {
        let lines = texts.into_iter().map(Said::into_wording).collect();
        self.parts.get_or_insert_default().insert(name.to_owned(), lines);
        self
    }

    /// The words in a language, with the values in their places. `words` gives those of an English template.
    pub fn in_words<'w>(&'w self, words: &dyn Fn(&'w str) -> &'w str) -> String {
        let lines = |lines: &'w Vec<Self>| {
            lines.iter().map(|line| line.in_words(words)).collect::<Vec<_>>().join("\n")
        };
        let parts: BTreeMap<&str, String> =
            self.parts.iter().flatten().map(|(name, wordings)| (name.as_str(), lines(wordings))).collect();
        filled_by(words(&self.template), |name| {
            parts.get(name).or_else(|| self.values.get(name)).map(String::as_str)
        })
    }
}

/// A text for people in English, with its wording. It is made of a [`Wording`], so that other languages have it too; what
/// vessels, other programs and operating systems say is English only, and marked by [`Said::as_is`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Said {
    text: String,
    wording: Option<Box<Wording>>,
}

impl Said {
    /// The words of a vessel, of another program or of the operating system, which no catalogue has.
    pub fn as_is(text: impl Into<String>) -> Self {
        Self { text: text.into(), wording: None }
    }

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

    /// A wording in any case: a text that is English only is a value.
    fn into_wording(self) -> Wording {
        let (text, wording) = self.into_parts();
        wording.unwrap_or_else(|| say("{text}").with("text", text))
    }

    /// Several texts, each on a line; one alone is itself.
    pub fn lines(texts: impl IntoIterator<Item = Self>) -> Self {
        let mut all: Vec<Self> = texts.into_iter().collect();
        match all.len() {
            0 => Self::default(),
            1 => all.remove(0),
            _ => say("{lines}").with_lines("lines", all).into(),
        }
    }

    /// The same of a field: its name stands before the text.
    #[must_use]
    pub fn of_field(self, field: &str) -> Self {
        say("{field}: {text}").with("field", field).with_said("text", self).into()
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
        Self { text: wording.to_string(), wording: Some(Box::new(wording)) }
    }
}

impl From<Fixed> for Said {
    fn from(sentence: Fixed) -> Self {
        say(sentence.0).into()
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

impl std::error::Error for Said {}

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

    /// The words of a small catalogue.
    fn bokmal(english: &str) -> &str {
        match english {
            "{who} asked {whom}." => "{whom} ble spurt av {who}.",
            "there are {n}" => "det er {n}",
            "has {n} problems:\n{problems}" => "har {n} feil:\n{problems}",
            english => english,
        }
    }

    #[test]
    fn a_text_has_its_values_once_whatever_they_contain_and_keeps_what_it_is_made_of() {
        let said = Said::from(say("{who} asked {whom}.").with("who", "{whom}").with("whom", "nils"));
        assert_eq!(said, "{whom} asked nils.");
        assert_eq!(said.wording().unwrap().in_words(&bokmal), "nils ble spurt av {whom}.");
        assert_eq!(Said::as_is("as it is").wording(), None);
        assert_eq!(Said::from(fixed("there are many")), Said::from(say("there are many")));
    }

    #[test]
    fn texts_within_a_text_have_their_own_words_and_foreign_ones_stay_as_they_are() {
        let one = Said::from(say("there are {n}").with("n", 3)).of_field("tags");
        let said = Said::from(
            say("has {n} problems:\n{problems}")
                .with("n", 2)
                .with_lines("problems", [one, Said::as_is("the disk says {n}")]),
        );
        assert_eq!(said, "has 2 problems:\ntags: there are 3\nthe disk says {n}");
        let sent = serde_json::to_string(said.wording().unwrap()).unwrap();
        let wording: Wording = serde_json::from_str(&sent).unwrap();
        assert_eq!(wording.in_words(&bokmal), "har 2 feil:\ntags: det er 3\nthe disk says {n}");
    }

    #[test]
    fn several_texts_stand_on_lines_of_their_own_and_one_alone_is_itself() {
        let one = Said::from(say("there are {n}").with("n", 1));
        assert_eq!(Said::lines([one.clone()]), one);
        let both = Said::lines([one.clone(), one]);
        assert_eq!(both, "there are 1\nthere are 1");
        assert_eq!(both.wording().unwrap().in_words(&bokmal), "det er 1\ndet er 1");
    }

    #[test]
    fn one_of_several_keeps_its_words_and_has_its_number() {
        let said = Said::from(say("there are {n}").with("n", 1)).numbered("area", 2);
        assert_eq!(said, "area 2, there are 1");
        let wording = said.wording().unwrap();
        assert_eq!((wording.template.as_str(), wording.values["area"].as_str()), ("there are {n}", "2"));
        assert_eq!(wording.in_words(&bokmal), "det er 1");
    }

    #[test]
    fn what_is_cut_off_has_no_wording() {
        let long = Said::from(say("{all}").with("all", "æøå"));
        assert_eq!(long.clone().at_most(3), long);
        let cut = long.at_most(2);
        assert_eq!((cut.as_str(), cut.wording()), ("æø", None));
    }
}
