//! Tables as CSV, in order of time, in constant memory.
//!
//! A single series is streamed. Several are read in slices of time that hold about a megabyte of
//! text; the rows of a slice are sorted and written. Rows of one time are in the order of message, system and
//! entity. The same question to the same history gives the same bytes.

use super::cells::{Exported, Writer, arrival, believed, header_start, receiver};
use super::columns::{Found, RECEIVED_AT, columns};
use super::options::{CsvOptions, Shape};
use super::plan::{Message, Plan};
use super::raw::Raw;
use super::select::Selection;
use crate::error::Result;
use crate::history::rows::{Order, Question, Row};
use crate::history::{ColumnKind, GroupKey, Table};
use crate::range::TimeRange;
use crate::reader::{Memory, Reader};
use imc::Address;
use rusqlite::Connection;
use rusqlite::types::ValueRef;
use std::io::Write;
use std::path::Path;
use tables::{Field, IsoTime};

/// Most bytes of a slice, unless all of it is of one microsecond.
const SLICE_BYTES: usize = 1 << 20;
/// The first slice, and the longest (µs).
const FIRST_SLICE_US: i64 = 60_000_000;
const LONGEST_SLICE_US: i64 = 86_400_000_000;

/// Writes a table: a header, and a row for each message or value, ended by line feeds. A value that is absent is an empty
/// cell, one that is not a number `NaN`.
///
/// # Errors
/// When the selection names what does not exist, the history cannot be read or `out` not be written. A table
/// that was begun then ends with a line that begins with `#ERROR`, as far as it can be written, and is not whole.
pub fn export_csv(
    data: &Path,
    selection: &Selection,
    options: &CsvOptions,
    out: &mut dyn Write,
) -> Result<Exported> {
    let mut reader = Reader::open_with(data, Memory::EXPORT)?;
    let selection = &selection.known(&mut reader)?;
    let mut writer = Writer::new(out);
    // The client gets the first byte before the first query to the database.
    writer.buffer.extend_from_slice(options.dialect.mark());
    let written = if selection.is_raw() {
        let table = Raw::new(&reader, selection, *options)?;
        table.header(&mut writer.buffer);
        writer.flush().and_then(|()| table.rows(&mut reader, &mut writer))
    } else {
        let plan = Plan::new(&mut reader, selection, *options)?;
        header(&mut writer.buffer, &plan, *options);
        writer.flush().and_then(|()| rows(&mut reader, &plan, *options, selection.range, &mut writer))
    };
    if let Err(error) = written.and_then(|()| writer.flush()) {
        writer.buffer.clear();
        let line = format!("#ERROR the export is cut here: {error}\n").replace('\r', " ");
        writer.out.write_all(line.as_bytes()).ok();
        return Err(error);
    }
    Ok(writer.exported)
}

fn header(out: &mut Vec<u8>, plan: &Plan, options: CsvOptions) {
    header_start(out, options);
    // Names and units of the catalogue hold nothing that would need quotes.
    let mut name = |name: &str| {
        options.format().next(out);
        out.extend_from_slice(name.as_bytes());
    };
    match options.shape {
        Shape::Long => ["message", "field", "value", "unit"].into_iter().for_each(&mut name),
        Shape::Wide => {
            if plan.is_mixed() {
                name("message");
            }
            let fields =
                plan.messages.iter().flat_map(|one| one.fields.iter().map(move |field| (one, field)));
            for (message, field) in fields {
                if options.units {
                    name(&tables::heading(message.name, field, plan.is_mixed()));
                } else {
                    name(&plan.column(message, field));
                }
            }
        }
    }
    out.push(b'\n');
}

/// One series of a month.
struct Series<'p, 'c> {
    group: GroupKey,
    /// When it is asked for.
    part: TimeRange,
    message: &'p Message,
    question: Question<'c>,
    /// Of each field its place among the columns that are asked for.
    places: Vec<usize>,
    system: Vec<u8>,
    /// The label, when it never changed.
    label: Option<Vec<u8>>,
    /// Time of the next row to be read; `None` after the last.
    next_us: Option<i64>,
    /// The span of the last row that was written, where only the first of each span is.
    span: Option<i64>,
}

/// What the lines of a series have in common.
struct Line<'s> {
    group: GroupKey,
    message: &'s Message,
    places: &'s [usize],
    system: &'s [u8],
    label: Option<&'s [u8]>,
}

/// Whether the row of this time is written; `span` is that of the row before.
fn takes(options: CsvOptions, span: &mut Option<i64>, time_us: i64) -> bool {
    let Some(every_us) = options.every_us else { return true };
    let here = time_us.div_euclid(every_us.get());
    span.replace(here) != Some(here)
}

fn rows(
    reader: &mut Reader,
    plan: &Plan,
    options: CsvOptions,
    range: TimeRange,
    writer: &mut Writer<'_>,
) -> Result<()> {
    for (key, part) in reader.parts(range)? {
        let connection = reader.month(key)?;
        connection.set_prepared_statement_cache_capacity(512);
        // All of a month is of one moment, however long the export takes.
        let snapshot = reader.named(key, connection.unchecked_transaction())?;
        let mut there = Vec::new();
        for group in &plan.groups {
            let message = &plan.messages[group.message];
            let Some(table) = reader.schema.table(group.key.id) else { continue };
            for span in group.spans.iter().map(|span| span.within(part)).filter(|span| !span.is_empty()) {
                let series = series(connection, plan, options, group.key, message, table, span);
                there.extend(reader.named(key, series)?);
            }
        }
        let mut lines = Lines { plan, options, iso: IsoTime::new(), received: IsoTime::new() };
        if let [one] = there.as_mut_slice() {
            stream(reader, key, one, &mut lines, writer)?;
        } else {
            slices(reader, key, &mut there, part.to_us, &mut lines, writer)?;
        }
        drop(there);
        reader.named(key, snapshot.finish())?;
    }
    Ok(())
}

fn series<'p, 'c>(
    connection: &'c Connection,
    plan: &Plan,
    options: CsvOptions,
    group: GroupKey,
    message: &'p Message,
    table: &Table,
    part: TimeRange,
) -> rusqlite::Result<Option<Series<'p, 'c>>> {
    let (columns, places) = columns(message, options);
    let Some(question) = Question::new(connection, table, group, &columns, Order::Oldest)? else {
        return Ok(None);
    };
    let address = Address(group.src);
    let mut system = Vec::new();
    let format = options.format();
    tables::text(&mut system, plan.names.system(address).as_bytes(), format);
    format.next(&mut system);
    system.extend_from_slice(format!("{:#06x}", group.src).as_bytes());
    format.next(&mut system);
    let runs = plan.names.entities.get(&(group.src, group.src_ent));
    let label = if runs.is_some_and(|runs| runs.runs.len() > 1) {
        None
    } else {
        let mut label = Vec::new();
        let name = runs.and_then(|runs| runs.latest()).map_or("", String::as_str);
        tables::text(&mut label, name.as_bytes(), format);
        Some(label)
    };
    let mut series =
        Series { group, part, message, question, places, system, label, next_us: None, span: None };
    series.next_us = series.question.rows(part)?.next()?.map(Row::time_us).transpose()?;
    Ok(series.next_us.is_some().then_some(series))
}

/// One series: streamed.
fn stream(
    reader: &Reader,
    key: crate::MonthKey,
    series: &mut Series<'_, '_>,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let Series { group, part, message, question, places, system, label, span, .. } = series;
    let line = Line { group: *group, message, places, system, label: label.as_deref() };
    let mut rows = reader.named(key, question.rows(*part))?;
    while let Some(row) = reader.named(key, rows.next())? {
        let time_us = reader.named(key, row.time_us())?;
        if !takes(lines.options, span, time_us) {
            continue;
        }
        writer.exported.rows += reader.named(key, lines.write(&mut writer.buffer, &line, time_us, row))?;
        writer.flush_full()?;
    }
    Ok(())
}

/// Several series: a slice of time after the other.
fn slices(
    reader: &Reader,
    key: crate::MonthKey,
    there: &mut [Series<'_, '_>],
    to_us: i64,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let mut slice = Slice::default();
    let mut width_us = FIRST_SLICE_US;
    while let Some(start_us) = there.iter().filter_map(|series| series.next_us).min() {
        let end_us = start_us.saturating_add(width_us).min(to_us);
        let whole = reader.named(key, slice.read(there, end_us, width_us > 1, lines))?;
        if !whole {
            // Too much: the same again, shorter.
            width_us = (width_us / 4).max(1);
            continue;
        }
        slice.order.sort_unstable_by_key(|line| (line.time_us, line.series, line.start));
        for line in &slice.order {
            writer.buffer.extend_from_slice(&slice.text[line.start..line.end]);
            writer.flush_full()?;
        }
        writer.exported.rows += slice.rows;
        for ((series, next_us), span) in there.iter_mut().zip(&slice.next_us).zip(&slice.spans) {
            (series.next_us, series.span) = (*next_us, *span);
        }
        if slice.text.len() < SLICE_BYTES / 4 {
            width_us = (width_us * 2).min(LONGEST_SLICE_US);
        }
    }
    Ok(())
}

#[derive(Default)]
struct Slice {
    text: Vec<u8>,
    order: Vec<Written>,
    next_us: Vec<Option<i64>>,
    spans: Vec<Option<i64>>,
    rows: u64,
}

/// A line in a slice's text.
struct Written {
    time_us: i64,
    series: usize,
    start: usize,
    end: usize,
}

impl Slice {
    /// Reads all series up to a time; false when that is too much for one slice.
    fn read(
        &mut self,
        there: &mut [Series<'_, '_>],
        end_us: i64,
        bounded: bool,
        lines: &mut Lines<'_>,
    ) -> rusqlite::Result<bool> {
        self.text.clear();
        self.order.clear();
        self.rows = 0;
        self.next_us.clear();
        self.next_us.extend(there.iter().map(|series| series.next_us));
        self.spans.clear();
        self.spans.extend(there.iter().map(|series| series.span));
        for (at, one) in there.iter_mut().enumerate() {
            let Some(next_us) = one.next_us.filter(|next_us| *next_us < end_us) else { continue };
            let Series { group, part, message, question, places, system, label, .. } = one;
            let line = Line { group: *group, message, places, system, label: label.as_deref() };
            let mut rows = question.rows(TimeRange { from_us: next_us, to_us: part.to_us })?;
            self.next_us[at] = None;
            while let Some(row) = rows.next()? {
                let time_us = row.time_us()?;
                if time_us >= end_us {
                    self.next_us[at] = Some(time_us);
                    break;
                }
                if !takes(lines.options, &mut self.spans[at], time_us) {
                    continue;
                }
                let start = self.text.len();
                self.rows += lines.write(&mut self.text, &line, time_us, row)?;
                self.order.push(Written { time_us, series: at, start, end: self.text.len() });
                if bounded && self.text.len() > SLICE_BYTES {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}

/// Rows of the history as lines of the table.
struct Lines<'p> {
    plan: &'p Plan,
    options: CsvOptions,
    iso: IsoTime,
    received: IsoTime,
}

impl Lines<'_> {
    /// Writes a message; how many lines that made.
    fn write(
        &mut self,
        out: &mut Vec<u8>,
        line: &Line<'_>,
        time_us: i64,
        row: Row<'_>,
    ) -> rusqlite::Result<u64> {
        if self.options.shape == Shape::Long {
            return self.write_long(out, line, time_us, row);
        }
        let (message, format) = (line.message, self.options.format());
        self.start(out, line, time_us, row)?;
        if self.plan.is_mixed() {
            format.next(out);
            out.extend_from_slice(message.name.as_bytes());
        }
        format.skip(out, message.first_column);
        let sent = sent(row)?;
        for (field, at) in message.fields.iter().zip(line.places) {
            format.next(out);
            self.value(out, field, Found::read(row, field, *at)?.value(), sent);
        }
        format.skip(out, self.plan.columns - message.first_column - message.fields.len());
        out.push(b'\n');
        Ok(1)
    }

    fn write_long(
        &mut self,
        out: &mut Vec<u8>,
        line: &Line<'_>,
        time_us: i64,
        row: Row<'_>,
    ) -> rusqlite::Result<u64> {
        let (sent, format) = (sent(row)?, self.options.format());
        let mut written = 0;
        for (field, at) in line.message.fields.iter().zip(line.places) {
            let found = Found::read(row, field, *at)?;
            let value = found.value();
            if value == ValueRef::Null && !is_nan(field, sent) {
                continue;
            }
            self.start(out, line, time_us, row)?;
            for name in [line.message.name, field.name] {
                format.next(out);
                out.extend_from_slice(name.as_bytes());
            }
            format.next(out);
            self.value(out, field, value, sent);
            format.next(out);
            out.extend_from_slice(field.unit.as_deref().unwrap_or_default().as_bytes());
            out.push(b'\n');
            written += 1;
        }
        Ok(written)
    }

    /// The cells at the start of every line.
    fn start(
        &mut self,
        out: &mut Vec<u8>,
        line: &Line<'_>,
        time_us: i64,
        row: Row<'_>,
    ) -> rusqlite::Result<()> {
        let format = self.options.format();
        tables::stamp(out, &mut self.iso, believed(time_us), format.dialect);
        format.next(out);
        out.extend_from_slice(line.system);
        if let Some(label) = line.label {
            out.extend_from_slice(label);
        } else {
            let (address, entity) = (Address(line.group.src), line.group.src_ent);
            let label = self.plan.names.entity(address, entity, time_us).unwrap_or_default();
            tables::text(out, label.as_bytes(), format);
        }
        format.next(out);
        tables::integer(out, line.group.src_ent.into());
        receiver(out, row.get(1)?, row.get(2)?, format);
        if self.options.received {
            arrival(out, &mut self.received, row.get(RECEIVED_AT)?, format);
        }
        Ok(())
    }

    fn value(&self, out: &mut Vec<u8>, field: &Field, value: ValueRef<'_>, sent: usize) {
        let format = self.options.format();
        let is_real = matches!(field.kind, ColumnKind::Single | ColumnKind::Double);
        match value {
            ValueRef::Null if is_nan(field, sent) => field.write_real(out, f64::NAN, format),
            ValueRef::Null => {}
            // A column of reals gives whole numbers as integers where it is computed.
            ValueRef::Integer(value) if is_real => field.write_real(out, value as f64, format),
            ValueRef::Integer(value) => field.write_integer(out, value, format),
            ValueRef::Real(value) => field.write_real(out, value, format),
            ValueRef::Text(text) if field.kind == ColumnKind::Nested => {
                tables::quoted(out, str::from_utf8(text).unwrap_or_default(), format);
            }
            ValueRef::Blob(bytes) if field.kind == ColumnKind::Raw => tables::hex(out, bytes),
            ValueRef::Text(text) | ValueRef::Blob(text) => tables::text(out, text, format),
        }
    }
}

/// How many fields a message had.
fn sent(row: Row<'_>) -> rusqlite::Result<usize> {
    Ok(row.get::<Option<u32>>(0)?.map_or(usize::MAX, |fields| fields as usize))
}

/// Whether a NULL is a NaN: of a real that was sent.
fn is_nan(field: &Field, sent: usize) -> bool {
    matches!(field.kind, ColumnKind::Single | ColumnKind::Double) && field.at.is_some_and(|at| at < sent)
}
