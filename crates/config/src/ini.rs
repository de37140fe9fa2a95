//! What a tree of `.ini` files says once all of them are read: sections of settings, every setting with its
//! value, where it comes from and everything that was assigned before.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::line::{COMMENT_MARKS, MAX_LINE_BYTES, trim};
use crate::problem::Place;

/// The sections of a configuration, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ini {
    sections: BTreeMap<String, IniSection>,
}

/// One section of settings, by key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IniSection {
    place: Place,
    settings: BTreeMap<String, Setting>,
}

/// One setting: its value and how it came about.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Setting {
    pub(crate) value: String,
    pub(crate) history: Vec<Change>,
    pub(crate) attributes: BTreeMap<String, String>,
}

/// One line, with its continuation lines, that had a part in a setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The first line.
    pub place: Place,
    /// The last line: that of the last continuation.
    pub last_line: u32,
    /// What it did.
    pub action: Action,
    /// The text it gave, continuation lines included.
    pub text: String,
}

/// What a line did to a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// `=`: replaced the value.
    Set,
    /// `+=`: added items to it.
    Append,
    /// `-=`: took items out of it.
    Remove,
    /// `= $(Section, Option)`: replaced it by another setting's value.
    Refer,
}

impl Action {
    /// The operator as written in a file.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Set | Self::Refer => "=",
            Self::Append => "+=",
            Self::Remove => "-=",
        }
    }
}

impl Ini {
    /// The section called exactly `name`.
    pub fn section(&self, name: &str) -> Option<&IniSection> {
        self.sections.get(name)
    }

    /// All sections, ordered by name.
    pub fn sections(&self) -> impl Iterator<Item = (&str, &IniSection)> {
        self.sections.iter().map(|(name, section)| (name.as_str(), section))
    }

    /// A setting by its section and key.
    pub fn setting(&self, section: &str, key: &str) -> Option<&Setting> {
        self.section(section)?.setting(key)
    }

    /// A value by its section and key.
    pub fn value(&self, section: &str, key: &str) -> Option<&str> {
        self.setting(section, key).map(Setting::value)
    }

    /// Gives a setting the value and history of another on top of its own.
    pub(crate) fn overlay(&mut self, section: &str, key: &str, above: &Setting) {
        let Some(section) = self.sections.get_mut(section) else { return };
        let setting = section.entry(key);
        setting.value.clone_from(&above.value);
        setting.history.extend_from_slice(&above.history);
        setting.attributes.extend(above.attributes.clone());
    }

    pub(crate) fn open(&mut self, name: &str, place: &Place) -> &mut IniSection {
        self.sections
            .entry(name.to_owned())
            .or_insert_with(|| IniSection { place: place.clone(), settings: BTreeMap::new() })
    }

    /// The same sections and values as one file without comments, which reads back to the same values.
    ///
    /// # Errors
    /// When some name or value cannot be written in the dialect.
    pub fn to_text(&self) -> Result<String, Unwritable> {
        let mut text = String::new();
        for (name, section) in &self.sections {
            write_header(&mut text, name)?;
            for (key, setting) in &section.settings {
                write_setting(&mut text, name, key, &setting.value)?;
            }
            text.push('\n');
        }
        Ok(text)
    }
}

impl IniSection {
    /// Where the section was opened first.
    pub const fn place(&self) -> &Place {
        &self.place
    }

    /// The setting called exactly `key`.
    pub fn setting(&self, key: &str) -> Option<&Setting> {
        self.settings.get(key)
    }

    /// All settings, ordered by key.
    pub fn settings(&self) -> impl Iterator<Item = (&str, &Setting)> {
        self.settings.iter().map(|(key, setting)| (key.as_str(), setting))
    }

    pub(crate) fn entry(&mut self, key: &str) -> &mut Setting {
        self.settings.entry(key.to_owned()).or_default()
    }
}

impl Setting {
    /// The value in force.
    pub fn value(&self) -> &str {
        &self.value
    }

    /// The line that decides the value.
    pub fn place(&self) -> Option<&Place> {
        self.history.last().map(|change| &change.place)
    }

    /// Every line that had a part in the value, oldest first; an assignment makes the earlier ones void.
    pub fn history(&self) -> &[Change] {
        &self.history
    }

    /// The attributes given in braces, such as `scope` and `visibility`.
    pub const fn attributes(&self) -> &BTreeMap<String, String> {
        &self.attributes
    }
}

/// A name or value that the dialect cannot hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unwritable {
    /// The name of a section.
    #[error("the section name `{0}` cannot be written")]
    Section(String),
    /// The name of a key.
    #[error("the key `{key}` of [{section}] cannot be written")]
    Key {
        /// The section.
        section: String,
        /// The key.
        key: String,
    },
    /// A value.
    #[error("the value of `{key}` in [{section}] holds `;`, `|`, `#`, a line end or outer blanks")]
    Value {
        /// The section.
        section: String,
        /// The key.
        key: String,
    },
    /// A value too long for one line and without a place where it can be broken.
    #[error("the value of `{key}` in [{section}] is too long to be written")]
    TooLong {
        /// The section.
        section: String,
        /// The key.
        key: String,
    },
}

/// Writes `[name]`.
pub(crate) fn write_header(text: &mut String, name: &str) -> Result<(), Unwritable> {
    let trailing = trim(name).len() < name.trim_start_matches(' ').len();
    let keyword = name.starts_with("Require ") || name.starts_with("Include ");
    let bad = name.is_empty() || name.contains([']', '\n', '\0']) || trailing || keyword;
    if bad || name.len() + 2 > MAX_LINE_BYTES || trim(name).is_empty() {
        return Err(Unwritable::Section(name.to_owned()));
    }
    let _ = writeln!(text, "[{name}]");
    Ok(())
}

/// Writes `key = value`, broken into continuation lines at blanks where it is too long for one.
pub(crate) fn write_setting(
    text: &mut String,
    section: &str,
    key: &str,
    value: &str,
) -> Result<(), Unwritable> {
    let names = || (section.to_owned(), key.to_owned());
    let foreign = |part: &str| part.contains(COMMENT_MARKS) || part.contains(['\n', '\0']);
    let bad_key = key.is_empty()
        || foreign(key)
        || key.contains('=')
        || key.starts_with('[')
        || key.ends_with(['+', '-', '}'])
        || trim(key) != key
        || key.len() > MAX_LINE_BYTES / 2;
    if bad_key {
        let (section, key) = names();
        return Err(Unwritable::Key { section, key });
    }
    if foreign(value) || trim(value) != value || value.starts_with("$(") {
        let (section, key) = names();
        return Err(Unwritable::Value { section, key });
    }
    let mut line = format!("{key} =");
    let mut broken = String::new();
    for word in value.split(' ').filter(|_| !value.is_empty()) {
        if line.len() + 1 + word.len() <= MAX_LINE_BYTES {
            line.push(' ');
            line.push_str(word);
            continue;
        }
        let starts_well = word.starts_with(|first: char| first.is_ascii_alphanumeric());
        let ends_well = line.ends_with(|last: char| !last.is_whitespace());
        if !starts_well || !ends_well || value.contains(['=', '{']) || word.len() > MAX_LINE_BYTES {
            let (section, key) = names();
            return Err(Unwritable::TooLong { section, key });
        }
        broken.push_str(&line);
        broken.push('\n');
        word.clone_into(&mut line);
    }
    let _ = writeln!(text, "{broken}{line}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(key: &str, value: &str) -> Result<String, Unwritable> {
        let mut text = String::new();
        write_setting(&mut text, "S", key, value).map(|()| text)
    }

    #[test]
    fn writes_what_can_be_read_back() {
        assert_eq!(written("Gain", "1, 2").unwrap(), "Gain = 1, 2\n");
        assert_eq!(written("Empty", "").unwrap(), "Empty =\n");
    }

    #[test]
    fn refuses_what_would_read_back_differently() {
        for value in ["a;b", "a|b", "a # b", "a\nb", " a", "$(A, B)"] {
            assert!(matches!(written("Key", value), Err(Unwritable::Value { .. })), "{value}");
        }
        for key in ["", "a=b", "a+", "a-", "#a", "[a", "a {b}"] {
            assert!(matches!(written(key, "v"), Err(Unwritable::Key { .. })), "{key}");
        }
        for name in ["", " ", "a]b", "Require x", "a "] {
            assert!(write_header(&mut String::new(), name).is_err(), "{name}");
        }
    }

    #[test]
    fn breaks_long_values_at_blanks() {
        let text = written("List", &["Item,"; 400].join(" ")).unwrap();
        assert!(text.lines().count() > 1);
        assert!(text.lines().all(|line| line.len() <= MAX_LINE_BYTES));
        assert!(matches!(written("Long", &"x".repeat(2000)), Err(Unwritable::TooLong { .. })));
    }
}
