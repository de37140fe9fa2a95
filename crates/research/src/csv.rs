//! Entries as CSV: a header of names of fields, and a line for each entry.
//!
//! Written by the rules of `tables`. Read more leniently, as people's spreadsheets write it: with or without a byte order mark,
//! with commas, semicolons or tabs, and with decimal commas where semicolons separate the cells. Nothing ambiguous is
//! guessed, and every problem of a file is reported at once.

use crate::check::{check, folded};
use crate::column::{Slot, shown};
use crate::fields::{blank, columns, kind_of, name_of, slots};
use api::{RegisterKind, RegisterRecord, Said, Wording, say};
use std::collections::BTreeMap;
use std::str::FromStr as _;
use tables::Format;
use units::UtcTime;

/// Lines that a file may have.
pub const ROWS: usize = 10_000;
/// Cells that a header may have: more than twice as many as any kind has columns.
const CELLS: usize = 64;
/// Problems that are reported; more of them are of no use.
const PROBLEMS: usize = 1_000;

/// What R writes for a missing value.
const ABSENT: &str = "NA";

/// The names of vessels.
pub struct Names<'n> {
    /// The address of a vessel by its name or address.
    pub address: &'n dyn Fn(&str) -> Result<u16, Said>,
    /// Its name, or its address.
    pub name: &'n dyn Fn(u16) -> String,
}

/// A problem with a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrongCell {
    /// Line, the header being 1.
    pub line: u32,
    /// Column; empty where the line is meant.
    pub column: String,
    /// What is wrong, and what to do.
    pub text: Wording,
}

/// A line that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadRow {
    /// Line of the file, the header being 1.
    pub line: u32,
    /// The entry that it changes, by its place among the known ones; `None` for a new one.
    pub known: Option<usize>,
    /// The entry's new contents.
    pub record: RegisterRecord,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Read {
    /// Its lines, as far as they can be understood.
    pub rows: Vec<ReadRow>,
    /// What is wrong.
    pub wrong: Vec<WrongCell>,
}

/// A field that says something else than before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Its column.
    pub column: &'static str,
    /// The old value.
    pub before: String,
    /// The new value.
    pub after: String,
}

/// The differences between two entries of one kind.
pub fn differences(before: &RegisterRecord, after: &RegisterRecord, names: &Names<'_>) -> Vec<Difference> {
    let (before, after) = (cells(before, names), cells(after, names));
    let fields = before.into_iter().zip(after).filter(|((_, before), (_, after))| before != after);
    fields.map(|((column, before), (_, after))| Difference { column, before, after }).collect()
}

/// The cells of an entry by their columns.
fn cells(record: &RegisterRecord, names: &Names<'_>) -> Vec<(&'static str, String)> {
    let mut record = record.clone();
    let fields = columns(kind_of(&record));
    fields.iter().zip(slots(&mut record)).map(|(column, slot)| (column.name, slot.cell(names.name))).collect()
}

/// A table of entries of one kind.
pub fn write_csv<'r>(
    kind: RegisterKind,
    records: impl IntoIterator<Item = &'r RegisterRecord>,
    names: &Names<'_>,
) -> Vec<u8> {
    let mut out = header(kind).into_bytes();
    let (text, number) = (Format::default(), Format { guard: false, ..Format::default() });
    for record in records {
        let mut record = record.clone();
        for (at, slot) in slots(&mut record).iter().enumerate() {
            if at > 0 {
                text.next(&mut out);
            }
            let format = if matches!(slot, Slot::Text(_) | Slot::Vessel(_)) { text } else { number };
            let cell = slot.cell(names.name);
            if at > 0 && cell == ABSENT {
                // A text that says so, guarded from being taken for nothing.
                out.push(b'\'');
            }
            tables::quoted(&mut out, &cell, format);
        }
        out.push(b'\n');
    }
    out
}

/// The first line of a table.
pub(crate) fn header(kind: RegisterKind) -> String {
    let names: Vec<&str> = columns(kind).iter().map(|column| column.name).collect();
    format!("{}\n", names.join(","))
}

/// Reads a table of entries of one kind, beside those that are known: a line with the name of a known one changes it. Columns
/// that a table does not have stay unchanged.
pub fn read_csv(kind: RegisterKind, bytes: &[u8], known: &[&RegisterRecord], names: &Names<'_>) -> Read {
    let mut read = Read::default();
    match Table::of(bytes) {
        Ok(table) => {
            let table = foreign::ours(kind, table);
            if let Some(places) = places(kind, &table, &mut read.wrong) {
                Rows { kind, places, known, names, decimal_comma: table.separator == b';' }
                    .read(&table, &mut read);
            }
        }
        Err(wrong) => read.wrong.push(wrong),
    }
    read.wrong.truncate(PROBLEMS);
    read
}

/// How the lines of a table are read.
struct Rows<'r> {
    kind: RegisterKind,
    /// For each cell of a line, which field it is.
    places: Vec<Option<usize>>,
    known: &'r [&'r RegisterRecord],
    names: &'r Names<'r>,
    decimal_comma: bool,
}

impl Rows<'_> {
    fn read(&self, table: &Table, read: &mut Read) {
        let known: BTreeMap<String, usize> =
            self.known.iter().enumerate().map(|(at, record)| (folded(name_of(record)), at)).collect();
        let mut lines: BTreeMap<String, u32> = BTreeMap::new();
        for (line, cells) in &table.rows {
            let mut wrong = Vec::new();
            let mut record = self.row(cells, &mut wrong);
            // Gives it its name, by which it is found among the known ones.
            check(&mut record);
            let name = folded(name_of(&record));
            let at = known.get(&name).copied();
            if let Some(before) = at.and_then(|at| self.known.get(at)) {
                record = self.onto((*before).clone(), &mut record);
            }
            let told: Vec<&str> = wrong.iter().map(|(column, _)| *column).collect();
            let more = check(&mut record)
                .into_iter()
                .filter(|(column, _)| !told.contains(column))
                .collect::<Vec<_>>();
            wrong.extend(more);
            if cells.len() != self.places.len() {
                let text = say(
                    "has {n} cells, the header {header}; look for a quote or a separator that is missing",
                )
                .with("n", cells.len())
                .with("header", self.places.len());
                wrong = vec![("", text)];
            } else if let Some(first) = lines.insert(name, *line).filter(|_| !name_of(&record).is_empty()) {
                wrong.push((
                    "name",
                    say("`{name}` stands in line {first} too; keep one")
                        .with("name", shown(name_of(&record)))
                        .with("first", first),
                ));
            }
            if wrong.is_empty() {
                read.rows.push(ReadRow { line: *line, known: at, record });
            }
            read.wrong.extend(wrong.into_iter().map(|(column, text)| WrongCell {
                line: *line,
                column: column.to_owned(),
                text,
            }));
        }
    }

    /// The contents of a line alone.
    fn row(&self, cells: &[String], wrong: &mut Vec<(&'static str, Wording)>) -> RegisterRecord {
        let mut record = blank(self.kind);
        let fields = columns(self.kind);
        let mut slots = slots(&mut record);
        for (cell, place) in cells.iter().zip(&self.places) {
            let Some((column, slot)) = place.and_then(|at| fields.get(at).zip(slots.get_mut(at))) else {
                continue;
            };
            let cell = cell.trim();
            let is_absent = cell.is_empty() || cell == ABSENT && column.name != "name";
            if is_absent {
                continue;
            }
            if let Err(text) = self.cell(slot, cell) {
                wrong.push((column.name, text));
            }
        }
        drop(slots);
        record
    }

    fn cell(&self, slot: &mut Slot<'_>, text: &str) -> Result<(), Wording> {
        if let Slot::Text(value) = slot {
            // The guard against formulas.
            text.strip_prefix('\'').unwrap_or(text).clone_into(value);
            return Ok(());
        }
        match slot {
            Slot::Text(_) => {}
            Slot::Real(value) => **value = Some(self.number(text)?),
            Slot::Whole(value) => {
                let number = text
                    .parse()
                    .map_err(|_| say("`{text}` is not a whole number").with("text", shown(text)))?;
                **value = Some(number);
            }
            Slot::Time(value) => {
                let time = UtcTime::from_str(text).map_err(|error| {
                    say("`{text}`: {error}").with("text", shown(text)).with("error", error)
                })?;
                **value = Some(time.micros());
            }
            Slot::Vessel(value) => {
                **value =
                    Some((self.names.address)(text).map_err(|said| say("{text}").with_said("text", said))?);
            }
        }
        Ok(())
    }

    fn number(&self, text: &str) -> Result<f64, Wording> {
        if self.decimal_comma && has_thousands(text) {
            let text = shown(text);
            let (whole, real) = (text.replace('.', ""), text.replacen('.', ",", 1));
            return Err(say("`{text}` can be {whole} or {real} here: write one of these")
                .with("text", text)
                .with("whole", whole)
                .with("real", real));
        }
        let plain = if self.decimal_comma { text.replacen(',', ".", 1) } else { text.to_owned() };
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte));
        let number = plain.parse::<f64>().ok().filter(|number| number.is_finite() && digits(&plain));
        number.ok_or_else(|| {
            if text.contains(',') {
                say("`{text}` is not a number here: write a decimal point, and nothing between thousands")
                    .with("text", shown(text))
            } else {
                say("`{text}` is not a number; write digits and a decimal point, without the unit")
                    .with("text", shown(text))
            }
        })
    }

    /// A known entry with the fields of which the table has columns.
    fn onto(&self, mut before: RegisterRecord, row: &mut RegisterRecord) -> RegisterRecord {
        for (at, (old, new)) in slots(&mut before).into_iter().zip(slots(row)).enumerate() {
            if !self.places.contains(&Some(at)) {
                continue;
            }
            match (old, new) {
                (Slot::Text(old), Slot::Text(new)) => new.clone_into(old),
                (Slot::Real(old), Slot::Real(new)) => *old = *new,
                (Slot::Whole(old), Slot::Whole(new)) | (Slot::Time(old), Slot::Time(new)) => *old = *new,
                (Slot::Vessel(old), Slot::Vessel(new)) => *old = *new,
                // Both are of one kind.
                _ => {}
            }
        }
        before
    }
}

/// Whether points of a number can stand between thousands: `1.340`.
fn has_thousands(text: &str) -> bool {
    let mut parts = text.trim_start_matches(['+', '-']).split('.');
    let is_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let begins = parts.next().is_some_and(|part| (1..=3).contains(&part.len()) && is_digits(part));
    let mut rest = parts.peekable();
    begins && rest.peek().is_some() && rest.all(|part| part.len() == 3 && is_digits(part))
}

/// For each cell of a line, which field it is; `None` where the header cannot be used at all.
fn places(kind: RegisterKind, table: &Table, wrong: &mut Vec<WrongCell>) -> Option<Vec<Option<usize>>> {
    let fields = columns(kind);
    let mut problem =
        |column: &str, text: Wording| wrong.push(WrongCell { line: 1, column: shown(column), text });
    let mut places = Vec::new();
    for cell in &table.header {
        let name = folded(cell);
        let at = fields.iter().position(|column| column.name == name);
        if at.is_some() && places.contains(&at) {
            problem(cell, say("stands in the header twice; keep one"));
        }
        if at.is_none() {
            let remedy = match suggest::alike(&name, fields.iter().map(|column| column.name)).as_slice() {
                [] => say("the columns are {columns}").with("columns", header(kind).trim()),
                names => say("did you mean `{names}`?").with("names", names.join("` or `")),
            };
            problem(cell, say("is not a column of this table; {remedy}").with_said("remedy", remedy));
        }
        places.push(at);
    }
    let missing = |at: &usize| fields[*at].needed && !places.contains(&Some(*at));
    for at in (0..fields.len()).filter(missing).collect::<Vec<_>>() {
        problem(
            fields[at].name,
            say("the header lacks this column: {about}").with_said("about", fields[at].meaning()),
        );
    }
    places.iter().any(Option::is_some).then_some(places)
}

/// The cells of a file.
struct Table {
    separator: u8,
    header: Vec<String>,
    /// Each with its line.
    rows: Vec<(u32, Vec<String>)>,
}

impl Table {
    fn of(bytes: &[u8]) -> Result<Self, WrongCell> {
        let whole = |line: usize, text: Wording| WrongCell { line: line as u32, column: String::new(), text };
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]);
            let line = 1 + before.matches('\n').count();
            whole(line, say("is not UTF-8 from here on; save the file as \"CSV UTF-8\""))
        })?;
        let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
        if text.contains('\0') {
            return Err(whole(1, say("this is not text; save the table as CSV")));
        }
        let first = text.lines().next().unwrap_or_default();
        let count = |separator: &u8| first.bytes().filter(|byte| byte == separator).count();
        // The first of those that are equally frequent: a header with one column has none.
        let separator = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
        let too_many = |count: usize| {
            whole(
                1,
                say("the header has {count} cells, and a table at most {most} columns; look at its separators")
                    .with("count", count)
                    .with("most", CELLS),
            )
        };
        if count(&separator) >= CELLS {
            return Err(too_many(count(&separator) + 1));
        }
        let mut lines = split(text, separator).map_err(|line| {
            whole(line, say("a quote that opens here is never closed; look for a `\"` too many"))
        })?;
        if lines.is_empty() {
            return Err(whole(1, say("the file is empty; its first line names the columns")));
        }
        let (_, header) = lines.remove(0);
        if header.len() > CELLS {
            return Err(too_many(header.len()));
        }
        if lines.len() > ROWS {
            return Err(whole(
                ROWS + 2,
                say("has more than {most} lines; divide the file").with("most", ROWS),
            ));
        }
        Ok(Self { separator, header, rows: lines })
    }
}

/// Lines with their cells, by RFC 4180; empty lines are left out, and so is what comes after one line too many. `Err` is the line in which a quote opens that never closes.
fn split(text: &str, separator: u8) -> Result<Vec<(u32, Vec<String>)>, usize> {
    let mut lines = Vec::new();
    let (mut cells, mut cell): (Vec<String>, String) = (Vec::new(), String::new());
    let (mut line, mut begun, mut quoted) = (1_usize, 1_usize, None);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted.is_some() => {
                if letters.next_if_eq(&'"').is_some() {
                    cell.push('"');
                } else {
                    quoted = None;
                }
            }
            '"' if cell.is_empty() => quoted = Some(line),
            '\r' if quoted.is_none() && letters.peek() == Some(&'\n') => {}
            '\n' | '\r' if quoted.is_none() => {
                end_line(&mut lines, &mut cells, &mut cell, begun);
                // The header, and one too many.
                if lines.len() > ROWS + 1 {
                    return Ok(lines);
                }
                line += 1;
                begun = line;
            }
            letter if quoted.is_none() && letter as u32 == u32::from(separator) => {
                cells.push(std::mem::take(&mut cell));
            }
            letter => {
                line += usize::from(letter == '\n');
                cell.push(letter);
            }
        }
    }
    if let Some(line) = quoted {
        return Err(line);
    }
    end_line(&mut lines, &mut cells, &mut cell, begun);
    Ok(lines)
}

fn end_line(lines: &mut Vec<(u32, Vec<String>)>, cells: &mut Vec<String>, cell: &mut String, line: usize) {
    cells.push(std::mem::take(cell));
    let cells = std::mem::take(cells);
    // A spreadsheet leaves lines of nothing but separators behind.
    if cells.iter().any(|cell| !cell.trim().is_empty()) {
        lines.push((u32::try_from(line).unwrap_or(u32::MAX), cells));
    }
}

mod foreign;
#[cfg(test)]
mod tests;
