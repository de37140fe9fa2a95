//! Texts in the reader's language: for pages, and messages about alarms.
//!
//! The English text is the key: code stays readable, and texts that the catalogue lacks are shown in English. The catalogue
//! (`words/nb.json`) is shared with the scripts; `web/test/words.test.mjs` finds missing and unused entries, and different
//! placeholders.

use crate::identity::Language;
use api::{AlarmSaying, Said};
use operations::alarms::day_and_time;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::LazyLock;

/// English texts and their Bokmål translations.
static BOKMAL: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../words/nb.json")).expect("a test reads the catalogue")
});

/// A translated text with its values.
#[derive(Debug, Clone)]
pub struct Text {
    text: &'static str,
    values: Vec<(&'static str, String)>,
}

impl Text {
    /// Replaces `{name}` by a value.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl fmt::Display) -> Self {
        self.values.push((name, value.to_string()));
        self
    }
}

impl fmt::Display for Text {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&api::filled(self.text, &self.values))
    }
}

/// `english` in `language`; itself where the catalogue lacks it.
pub fn t(language: Language, english: &'static str) -> Text {
    Text { text: said(language, english), values: Vec::new() }
}

/// As [`t`], for a text without placeholders that is chosen at run time.
pub fn said(language: Language, english: &str) -> &str {
    match language {
        Language::English => english,
        Language::Bokmal => BOKMAL.get(english).map_or(english, String::as_str),
    }
}

/// A text of which the server makes words here, and scripts in the browser: in `language` where the catalogue has it.
pub fn worded(language: Language, text: &Said) -> String {
    match text.wording() {
        Some(wording) => wording.in_words(&|english| said(language, english)),
        None => text.to_string(),
    }
}

/// What an alarm says; `text` where it was kept by an older server, without codes.
pub fn alarm(language: Language, says: &[AlarmSaying], text: &str) -> String {
    if says.is_empty() {
        return text.to_owned();
    }
    let all: Vec<String> = says.iter().map(|one| saying(language, one)).collect();
    all.join("; ")
}

fn saying(language: Language, saying: &AlarmSaying) -> String {
    let mut values = saying.values(day_and_time);
    for (name, value) in &mut values {
        if *name == "state" {
            *value = said(language, value).to_owned();
        }
    }
    api::filled(said(language, saying.template()), &values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogue_is_read_and_what_it_lacks_is_english() {
        assert_eq!(said(Language::Bokmal, "Fleet"), "Flåte");
        assert_eq!(said(Language::English, "Fleet"), "Fleet");
        assert_eq!(said(Language::Bokmal, "No catalogue has this."), "No catalogue has this.");
    }

    #[test]
    fn a_value_is_put_in_once_whatever_it_contains() {
        let text = t(Language::English, "{a} and {b}, {c}").with("a", "{b}").with("b", 2);
        assert_eq!(text.to_string(), "{b} and 2, {c}");
        assert_eq!(t(Language::English, "a { brace").to_string(), "a { brace");
    }

    #[test]
    fn a_refusal_is_said_in_the_reader_s_language() {
        let refused = api::Said::from(api::say("There is no person {name}.").with("name", "{name}"));
        assert_eq!(worded(Language::Bokmal, &refused), "Det er ingen person {name}.");
        assert_eq!(worded(Language::English, &refused), "There is no person {name}.");
        assert_eq!(worded(Language::Bokmal, &api::fixed("Fleet").into()), "Flåte");
        assert_eq!(worded(Language::Bokmal, &Said::as_is("Fleet")), "Fleet");
    }

    #[test]
    fn an_alarm_is_said_in_the_reader_s_language_and_a_vessel_s_words_as_they_are() {
        let says = [
            AlarmSaying::Charge { percent: 19 },
            AlarmSaying::Part {
                part: "Fuel".to_owned(),
                state: "error".to_owned(),
                words: "cell {percent} low".to_owned(),
            },
        ];
        assert_eq!(alarm(Language::English, &says, ""), "19 % charge left; Fuel: error: cell {percent} low");
        assert_eq!(alarm(Language::Bokmal, &says, ""), "19 % lading igjen; Fuel: feil: cell {percent} low");
        let silent = [AlarmSaying::NotHeard { since_us: 3_723_000_000 }];
        assert_eq!(alarm(Language::Bokmal, &silent, ""), "ikke hørt siden 01:02:03Z");
        assert_eq!(alarm(Language::Bokmal, &[], "kept before"), "kept before");
    }
}
