//! A row of a table by the names of its columns.

use super::Wrong;
use super::lines::{LONGEST, Record};
use api::{Wording, say};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::str::FromStr;
use units::UtcTime;

/// Letters of a cell that are shown.
const SHOWN: usize = 60;
/// Letters of a header that are shown.
const HEADER_SHOWN: usize = 300;

/// The columns of a table, in lower case, without units in brackets.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    places: BTreeMap<String, usize>,
    names: Vec<String>,
}

impl Columns {
    pub(super) fn of(header: &Record) -> Self {
        Self::named((0..header.len()).map(|at| header.cell(at).to_owned()).collect())
    }

    pub(super) fn named(names: Vec<String>) -> Self {
        let bare = |name: &String| name.split_once(" [").map_or(&**name, |(name, _)| name).to_lowercase();
        // The first of two of the same name counts.
        let places = names.iter().enumerate().rev().map(|(at, name)| (bare(name), at));
        // R and pandas number the rows in a column without a name; makers' columns that a table lacks have the empty name too.
        let places = places.filter(|(name, _)| !name.is_empty()).collect();
        Self { places, names }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.places.contains_key(name)
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    pub(super) fn shown(&self) -> String {
        self.names.join(",").chars().take(HEADER_SHOWN).collect()
    }
}

/// A row.
pub(super) struct Row<'r> {
    pub(super) line: u32,
    /// The line as it came; empty where a file has none.
    pub(super) raw: &'r str,
    columns: &'r Columns,
    cells: Cells<'r>,
    decimal_comma: bool,
}

enum Cells<'r> {
    /// Of CSV, where texts are guarded from being taken for formulas.
    Record(&'r Record),
    Values(&'r [String]),
}

impl<'r> Row<'r> {
    pub(super) fn of_record(columns: &'r Columns, record: &'r Record, decimal_comma: bool) -> Self {
        Self { line: record.line, raw: &record.raw, columns, cells: Cells::Record(record), decimal_comma }
    }

    pub(super) fn of_values(columns: &'r Columns, line: u32, values: &'r [String]) -> Self {
        Self { line, raw: "", columns, cells: Cells::Values(values), decimal_comma: false }
    }

    /// Whether it has a cell for each column, and no text that no detection has.
    pub(super) fn is_whole(&self) -> Result<(), Wrong> {
        if let Cells::Values(values) = self.cells
            && let Some((at, text)) = values.iter().enumerate().find(|(_, text)| text.len() > LONGEST)
        {
            let column = self.columns.names.get(at).cloned().unwrap_or_default();
            let text = say("is {n} bytes long, a cell has at most {most}: take out what is not of the receiver, or leave the cell empty")
                .with("n", text.len())
                .with("most", LONGEST);
            return Err((column, text));
        }
        let n = match self.cells {
            Cells::Record(record) => record.len(),
            Cells::Values(values) => values.len(),
        };
        // Some programs leave empty cells at the end away. A file that was copied by half ends so too, but without a line end.
        let is_cut =
            n < self.columns.len() && matches!(self.cells, Cells::Record(record) if !record.is_ended);
        if is_cut {
            return Err((
                String::new(),
                say("the file is cut off here; copy it again, or end its last line if it is whole"),
            ));
        }
        if n <= self.columns.len() && n > 1 {
            return Ok(());
        }
        let text = say("has {n} cells, the header {header}; look for a quote or a separator that is missing");
        Err((String::new(), text.with("n", n).with("header", self.columns.len())))
    }

    /// A cell by the name of its column, in lower case; `None` where it says nothing.
    pub(super) fn cell(&self, name: &str) -> Option<&'r str> {
        let at = *self.columns.places.get(name)?;
        let text = match self.cells {
            Cells::Record(record) => record.cell(at),
            Cells::Values(values) => values.get(at).map_or("", |text| text),
        };
        Some(text).filter(|text| !matches!(*text, "" | "NA" | "-"))
    }

    /// A text of our own tables, as it was before it was written there.
    pub(super) fn text(&self, name: &str) -> Option<Cow<'r, str>> {
        let at = *self.columns.places.get(name)?;
        let text = match self.cells {
            Cells::Values(values) => Cow::from(values.get(at).map_or("", |text| text)),
            Cells::Record(record) => {
                let text = record.exact(at);
                let text = text.strip_prefix('\'').unwrap_or(text);
                match imc::text::unescape(text) {
                    Cow::Borrowed(_) => Cow::from(text),
                    Cow::Owned(bytes) => Cow::from(String::from_utf8_lossy(&bytes).into_owned()),
                }
            }
        };
        Some(text).filter(|text| !text.is_empty())
    }

    /// The same, which must be there.
    pub(super) fn needed(&self, name: &str) -> Result<Cow<'r, str>, Wrong> {
        self.text(name).ok_or_else(|| empty(name))
    }

    /// A whole number of the range of its type.
    pub(super) fn whole<T: FromStr>(&self, name: &str) -> Result<Option<T>, Wrong> {
        let Some(text) = self.cell(name) else { return Ok(None) };
        // Spreadsheets and R write 7 as 7.0.
        let digits = text.strip_suffix(if self.decimal_comma { ",0" } else { ".0" }).unwrap_or(text);
        digits.parse().map(Some).map_err(|_| {
            let wrong =
                say("`{text}` is not a whole number of this column; look for a shifted or rounded cell");
            (name.to_owned(), wrong.with("text", shown(text)))
        })
    }

    /// A number.
    pub(super) fn real(&self, name: &str) -> Result<Option<f64>, Wrong> {
        let Some(text) = self.cell(name) else { return Ok(None) };
        let plain = self.plain(text);
        let number = plain.parse::<f64>().ok().filter(|number| number.is_finite());
        number.map(Some).ok_or_else(|| (name.to_owned(), not_a_number(text)))
    }

    /// With a decimal point.
    pub(super) fn plain(&self, text: &str) -> String {
        if self.decimal_comma { text.replacen(',', ".", 1) } else { text.to_owned() }
    }

    /// A moment.
    pub(super) fn time(&self, name: &str) -> Result<Option<UtcTime>, Wrong> {
        let Some(text) = self.cell(name) else { return Ok(None) };
        let told = |wrong: Wording| (name.to_owned(), wrong.with("text", shown(text)));
        let parsed = self.plain(text).parse();
        if !has_seconds(text) && (parsed.is_ok() || text.contains(':')) {
            return Err(told(say(
                "`{text}` has no seconds: a spreadsheet cut them; take the file as the receiver's program wrote it",
            )));
        }
        parsed.map(Some).map_err(|_| {
            told(say("`{text}` is not a time such as 2026-11-21 08:00:00.125 (UTC) or 2026-11-21T09:00:00+01:00; take the file as the receiver's program wrote it"))
        })
    }
}

/// Whether a time has a clock with hours, minutes and seconds, after a date of ten letters and before an offset.
fn has_seconds(text: &str) -> bool {
    let clock = text.get(10..).unwrap_or_default();
    clock.split(['+', '-']).next().is_some_and(|clock| clock.matches(':').count() == 2)
}

/// What every detection has is not there.
pub(super) fn empty(name: &str) -> Wrong {
    (name.to_owned(), say("empty; each detection has it: export the file again"))
}

fn not_a_number(text: &str) -> Wording {
    let wrong = if text.contains(',') {
        say("`{text}` is not a number here: write a decimal point, and nothing between thousands")
    } else {
        say("`{text}` is not a number; write digits and a decimal point, without the unit")
    };
    wrong.with("text", shown(text))
}

pub(super) fn shown(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}
