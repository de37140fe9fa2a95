//! Reads tables of a TOML file key by key: what is not understood is reported with its line and place, and reading
//! continues.

use super::problem::Problem;
use std::fmt::Display;
use std::net::IpAddr;
use std::ops::RangeInclusive;
use std::str::FromStr;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Problems that are reported; a file full of errors has many.
const MOST: usize = 200;

/// The file's text and what is wrong with it.
#[derive(Debug)]
pub(super) struct Report<'t> {
    text: &'t str,
    problems: Vec<Problem>,
}

impl<'t> Report<'t> {
    pub(super) const fn new(text: &'t str) -> Self {
        Self { text, problems: Vec::new() }
    }

    /// Reports what is wrong at this byte.
    pub(super) fn tell(&mut self, at: usize, text: impl Into<String>, remedy: impl Into<String>) {
        if self.problems.len() >= MOST {
            return;
        }
        let before = self.text.as_bytes().iter().take(at);
        let line = before.filter(|byte| **byte == b'\n').count() + 1;
        self.problems.push(Problem { line, text: text.into(), remedy: remedy.into() });
    }

    pub(super) const fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    /// All, in the file's order.
    pub(super) fn into_problems(mut self) -> Vec<Problem> {
        self.problems.sort();
        self.problems.dedup();
        self.problems
    }
}

/// A value and its byte offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found<T> {
    pub(super) value: T,
    pub(super) at: usize,
}

/// One table.
#[derive(Debug, Clone)]
pub(super) struct Fields<'a, 't> {
    table: &'a DeTable<'t>,
    /// As `vessel 2`.
    pub(super) place: String,
    /// Byte where the table begins.
    pub(super) at: usize,
}

impl<'a, 't> Fields<'a, 't> {
    /// A table that may have these keys; others are reported.
    pub(super) fn new(
        report: &mut Report<'_>,
        table: Found<&'a DeTable<'t>>,
        place: String,
        known: &[&str],
    ) -> Self {
        for key in table.value.keys() {
            let name: &str = key.get_ref();
            if known.contains(&name) {
                continue;
            }
            let remedy = match suggest::nearest(name, known.iter().copied()) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => format!("known here: {}", known.join(", ")),
            };
            report.tell(key.span().start, format!("{place}: unknown key `{name}`"), remedy);
        }
        Self { table: table.value, place, at: table.at }
    }

    /// What is wrong with a key of this table.
    pub(super) fn wrong(
        &self,
        report: &mut Report<'_>,
        at: usize,
        key: &str,
        text: impl Display,
        remedy: impl Into<String>,
    ) {
        report.tell(at, format!("{}: {key}: {text}", self.place), remedy);
    }

    /// Reports that a key is absent, if it is.
    pub(super) fn require(&self, report: &mut Report<'_>, key: &str, example: &str) {
        if !self.table.contains_key(key) {
            report.tell(
                self.at,
                format!("{}: `{key}` is missing", self.place),
                format!("write {key} = {example}"),
            );
        }
    }

    pub(super) fn text(&self, report: &mut Report<'_>, key: &str) -> Option<Found<&'a str>> {
        self.take(report, key, "a text in quotes", DeValue::as_str)
    }

    pub(super) fn flag(&self, report: &mut Report<'_>, key: &str) -> Option<Found<bool>> {
        self.take(report, key, "true or false", DeValue::as_bool)
    }

    pub(super) fn table(&self, report: &mut Report<'_>, key: &str) -> Option<Found<&'a DeTable<'t>>> {
        self.take(report, key, "a table", DeValue::as_table)
    }

    /// A whole number within a range.
    pub(super) fn whole<N: TryFrom<i64> + Into<i64> + Copy>(
        &self,
        report: &mut Report<'_>,
        key: &str,
        within: RangeInclusive<N>,
    ) -> Option<Found<N>> {
        let found = self.take(report, key, "a whole number", whole)?;
        let (least, most) = (*within.start(), *within.end());
        match N::try_from(found.value) {
            Ok(value) if (least.into()..=most.into()).contains(&value.into()) => {
                Some(Found { value, at: found.at })
            }
            _ => {
                let remedy = format!("take {} to {}", least.into(), most.into());
                self.wrong(report, found.at, key, format!("{} cannot be", found.value), remedy);
                None
            }
        }
    }

    /// A number within a range, in the unit that the key ends with.
    pub(super) fn number(
        &self,
        report: &mut Report<'_>,
        key: &str,
        within: RangeInclusive<f64>,
    ) -> Option<f64> {
        let found = self.take(report, key, "a number", number)?;
        if within.contains(&found.value) {
            return Some(found.value);
        }
        let remedy = format!("take {} to {}", within.start(), within.end());
        self.wrong(report, found.at, key, format!("{} cannot be", found.value), remedy);
        None
    }

    /// Texts of a list.
    pub(super) fn texts(&self, report: &mut Report<'_>, key: &str) -> Vec<Found<&'a str>> {
        let what = "a list of texts, like [\"udp/6001\"]";
        let Some(list) = self.take(report, key, what, DeValue::as_array) else { return Vec::new() };
        let mut texts = Vec::new();
        for one in list.value {
            match one.get_ref().as_str() {
                Some(value) => texts.push(Found { value, at: one.span().start }),
                None => self.wrong(report, one.span().start, key, "not a text", format!("write {what}")),
            }
        }
        texts
    }

    /// Tables of a list (`[[key]]`).
    pub(super) fn tables(&self, report: &mut Report<'_>, key: &str) -> Vec<Found<&'a DeTable<'t>>> {
        let what = format!("tables, each begun by [[{key}]]");
        let Some(list) = self.take(report, key, &what, DeValue::as_array) else { return Vec::new() };
        let mut tables = Vec::new();
        for one in list.value {
            match one.get_ref().as_table() {
                Some(value) => tables.push(Found { value, at: one.span().start }),
                None => self.wrong(report, one.span().start, key, "not a table", format!("write {what}")),
            }
        }
        tables
    }

    /// Every key with its value, as text.
    pub(super) fn values(&self, report: &mut Report<'_>) -> Vec<(Found<&'a str>, String)> {
        let mut values = Vec::new();
        for (key, value) in self.table {
            match plain(value) {
                Some(text) => {
                    values.push((Found { value: key.get_ref().as_ref(), at: key.span().start }, text));
                }
                None => self.wrong(
                    report,
                    value.span().start,
                    key.get_ref(),
                    "not a text, a number, true or false",
                    "write lists as the .ini file has them, like \"1, 2\"",
                ),
            }
        }
        values
    }

    /// Every key whose value is a table.
    pub(super) fn inner(&self, report: &mut Report<'_>) -> Vec<(Found<&'a str>, Found<&'a DeTable<'t>>)> {
        let mut inner = Vec::new();
        for (key, value) in self.table {
            let (name, at): (&str, _) = (key.get_ref(), key.span().start);
            match value.get_ref().as_table() {
                Some(table) => inner.push((Found { value: name, at }, Found { value: table, at })),
                None => {
                    self.wrong(report, at, name, "not a table", "write settings.\"Section\".\"Key\" = value");
                }
            }
        }
        inner
    }

    fn take<T>(
        &self,
        report: &mut Report<'_>,
        key: &str,
        what: &str,
        read: impl FnOnce(&'a DeValue<'t>) -> Option<T>,
    ) -> Option<Found<T>> {
        let value = self.table.get(key)?;
        let at = value.span().start;
        let found = read(value.get_ref()).map(|value| Found { value, at });
        if found.is_none() {
            let text = format!("that is {}", value.get_ref().type_str());
            self.wrong(report, at, key, text, format!("write {what}"));
        }
        found
    }
}

/// A text that is valid in a line of an .ini file.
pub(super) fn line<'a>(
    report: &mut Report<'_>,
    fields: &Fields<'a, '_>,
    key: &str,
) -> Option<Found<&'a str>> {
    let found = fields.text(report, key)?;
    if is_plain(found.value) && !found.value.trim().is_empty() {
        return Some(found);
    }
    let text = format!("{:?} cannot stand in an .ini file", found.value);
    fields.wrong(report, found.at, key, text, "write a text without [ ] # ; and line ends");
    None
}

/// A DNS name or an address, without anything around it.
pub(super) fn is_host(text: &str) -> bool {
    let label = |label: &str| {
        (1..=63).contains(&label.len())
            && label.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
            && !label.starts_with('-')
            && !label.ends_with('-')
    };
    text.parse::<IpAddr>().is_ok() || (text.len() <= 253 && text.split('.').all(label))
}

/// An address of a family.
pub(super) fn ip_of<A: FromStr>(
    report: &mut Report<'_>,
    fields: &Fields<'_, '_>,
    key: &str,
    what: &str,
    example: &str,
) -> Option<Found<A>> {
    let found = fields.text(report, key)?;
    let address = found.value.parse().ok().map(|value| Found { value, at: found.at });
    if address.is_none() {
        let text = format!("{:?} is not {what}", found.value);
        fields.wrong(report, found.at, key, text, format!("write one like {example}"));
    }
    address
}

/// Whether a text is valid in an .ini file.
pub(super) fn is_plain(text: &str) -> bool {
    text.len() <= 1_000 && !text.contains(['[', ']', '#', ';', '\\']) && !text.contains(char::is_control)
}

fn whole(value: &DeValue<'_>) -> Option<i64> {
    let written = value.as_integer()?;
    i64::from_str_radix(written.as_str(), written.radix()).ok()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value.as_float() {
        Some(written) => written.as_str().parse().ok(),
        None => whole(value).map(|whole| whole as f64),
    }
}

/// A value as an .ini file has it.
fn plain(value: &Spanned<DeValue<'_>>) -> Option<String> {
    let value = value.get_ref();
    let text = value.as_str().map(str::to_owned);
    text.or_else(|| value.as_bool().map(|flag| flag.to_string()))
        .or_else(|| number(value).map(|number| number.to_string()))
}
