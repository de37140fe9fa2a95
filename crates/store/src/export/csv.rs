//! Tables as CSV, in order of time, in constant memory.
//!
//! A single series is written as it is read. Several are read in slices of time that hold about a megabyte of
//! text; the rows of a slice are sorted and written. Rows of one time stand in the order of message, system and
//! entity. The same question to the same history gives the same bytes.

use super::cell;
use super::number::{self, IsoTime};
use super::plan::{CsvOptions, Field, Message, Plan, Selection, Shape, is_raw};
use super::raw::Raw;
use crate::error::{Result, StoreError};
use crate::history::{ColumnKind, GroupKey, Table};
use crate::range::TimeRange;
use crate::reader::{Memory, Reader, has_group, select_list};
use imc::Address;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Row};
use std::io::Write;
use std::path::Path;

/// Bytes that are handed on at once.
const CHUNK_BYTES: usize = 1 << 16;
/// Most bytes of a slice, unless all of it is of one microsecond.
const SLICE_BYTES: usize = 1 << 20;
/// The first slice, and the longest (µs).
const FIRST_SLICE_US: i64 = 60_000_000;
const LONGEST_SLICE_US: i64 = 86_400_000_000;

/// What an export wrote.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exported {
    /// Rows of a table, or packets of a log.
    pub rows: u64,
    /// Bytes.
    pub bytes: u64,
}

/// Writes a table: a header, and a row for each message or value, ended by line feeds. A value that is absent or
/// no number is an empty cell.
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
    let mut writer =
        Writer { out, buffer: Vec::with_capacity(2 * CHUNK_BYTES), exported: Exported::default() };
    // Whoever waits for the first byte gets it before the first question to the database.
    let written = if is_raw(selection)? {
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

pub(super) struct Writer<'o> {
    out: &'o mut dyn Write,
    pub(super) buffer: Vec<u8>,
    pub(super) exported: Exported,
}

impl Writer<'_> {
    fn flush(&mut self) -> Result<()> {
        self.out.write_all(&self.buffer).and_then(|()| self.out.flush()).map_err(unwritable)?;
        self.exported.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
    }

    pub(super) fn flush_full(&mut self) -> Result<()> {
        if self.buffer.len() >= CHUNK_BYTES { self.flush() } else { Ok(()) }
    }
}

pub(super) fn unwritable(source: std::io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}

/// The names of the columns that every table begins with.
pub(super) fn header_start(out: &mut Vec<u8>, options: CsvOptions) {
    out.extend_from_slice(b"time,unix_s,system,system_id,entity,entity_id");
    if options.received {
        out.extend_from_slice(b",received,received_unix_s");
    }
}

fn header(out: &mut Vec<u8>, plan: &Plan, options: CsvOptions) {
    header_start(out, options);
    match options.shape {
        Shape::Long => out.extend_from_slice(b",message,field,value,unit"),
        Shape::Wide => {
            if plan.is_mixed() {
                out.extend_from_slice(b",message");
            }
            for message in &plan.messages {
                for field in &message.fields {
                    // Names and units of the catalogue hold nothing that would need quotes.
                    write!(out, ",{}", plan.column(message, field)).ok();
                    if let Some(unit) = field.unit.filter(|_| options.units) {
                        write!(out, " [{unit}]").ok();
                    }
                }
            }
        }
    }
    out.push(b'\n');
}

/// One series of a month.
struct Series<'p> {
    group: GroupKey,
    message: &'p Message,
    sql: String,
    system: Vec<u8>,
    /// The label, when it never changed.
    label: Option<Vec<u8>>,
    /// Time of the next row to be read; `None` after the last.
    next_us: Option<i64>,
    /// The span of the last row that was written, where only the first of each span is.
    span: Option<i64>,
}

impl Series<'_> {
    /// Whether the row of this time is written; `span` is that of the row before.
    fn takes(options: CsvOptions, span: &mut Option<i64>, time_us: i64) -> bool {
        let Some(every_us) = options.every_us else { return true };
        let here = time_us.div_euclid(every_us.get());
        span.replace(here) != Some(here)
    }
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
        for (group, message) in &plan.groups {
            let message = &plan.messages[*message];
            if let Some(table) = reader.schema.table(group.id) {
                let series = series(connection, plan, options, *group, message, table, part);
                there.extend(reader.named(key, series)?);
            }
        }
        let mut lines = Lines { plan, options, iso: IsoTime::new(), received: IsoTime::new() };
        if let [one] = there.as_slice() {
            stream(reader, key, connection, one, part, &mut lines, writer)?;
        } else {
            slices(reader, key, connection, &mut there, part, &mut lines, writer)?;
        }
        reader.named(key, snapshot.finish())?;
    }
    Ok(())
}

fn series<'p>(
    connection: &Connection,
    plan: &Plan,
    options: CsvOptions,
    group: GroupKey,
    message: &'p Message,
    table: &Table,
    part: TimeRange,
) -> rusqlite::Result<Option<Series<'p>>> {
    if !has_group(connection, group)? {
        return Ok(None);
    }
    // What is computed here stands before what the table has.
    let computed: Vec<&str> = message.fields.iter().filter_map(|field| field.sql.as_deref()).collect();
    let computed: String = computed.iter().flat_map(|sql| [",", sql]).collect();
    let names: Vec<&str> =
        message.fields.iter().filter(|field| field.sql.is_none()).map(|field| field.name).collect();
    let sql = format!(
        "SELECT time_us{}{computed}{} FROM \"{}\" WHERE src=?1 AND src_ent=?2 AND time_us>=?3 AND time_us<?4 \
         ORDER BY time_us,hash",
        if options.received { ",received_us" } else { "" },
        select_list(connection, table, &names)?,
        table.desc.abbrev
    );
    let address = Address(group.src);
    let mut system = Vec::new();
    cell::text(&mut system, plan.names.system(address).as_bytes(), options.guard);
    system.extend_from_slice(format!(",{:#06x},", group.src).as_bytes());
    let runs = plan.names.entities.get(&(group.src, group.src_ent));
    let label = if runs.is_some_and(|runs| runs.runs.len() > 1) {
        None
    } else {
        let mut label = Vec::new();
        let name = runs.and_then(|runs| runs.latest()).map_or("", String::as_str);
        cell::text(&mut label, name.as_bytes(), options.guard);
        Some(label)
    };
    let mut series = Series { group, message, sql, system, label, next_us: None, span: None };
    let mut statement = connection.prepare_cached(&series.sql)?;
    let mut rows = statement.query((group.src, group.src_ent, part.from_us, part.to_us))?;
    series.next_us = rows.next()?.map(|row| row.get(0)).transpose()?;
    Ok(series.next_us.is_some().then_some(series))
}

/// One series: as it is read.
fn stream(
    reader: &Reader,
    key: crate::MonthKey,
    connection: &Connection,
    series: &Series<'_>,
    part: TimeRange,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let mut statement = reader.named(key, connection.prepare_cached(&series.sql))?;
    let span = (series.group.src, series.group.src_ent, part.from_us, part.to_us);
    let mut rows = reader.named(key, statement.query(span))?;
    let mut span = series.span;
    while let Some(row) = reader.named(key, rows.next())? {
        let time_us = reader.named(key, row.get(0))?;
        if !Series::takes(lines.options, &mut span, time_us) {
            continue;
        }
        writer.exported.rows += reader.named(key, lines.write(&mut writer.buffer, series, time_us, row))?;
        writer.flush_full()?;
    }
    Ok(())
}

/// Several series: a slice of time after the other.
fn slices(
    reader: &Reader,
    key: crate::MonthKey,
    connection: &Connection,
    there: &mut [Series<'_>],
    part: TimeRange,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let mut slice = Slice::default();
    let mut width_us = FIRST_SLICE_US;
    while let Some(start_us) = there.iter().filter_map(|series| series.next_us).min() {
        let end_us = start_us.saturating_add(width_us).min(part.to_us);
        let whole = reader.named(key, slice.read(connection, there, part, end_us, width_us > 1, lines))?;
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
    order: Vec<Line>,
    next_us: Vec<Option<i64>>,
    spans: Vec<Option<i64>>,
    rows: u64,
}

struct Line {
    time_us: i64,
    series: usize,
    start: usize,
    end: usize,
}

impl Slice {
    /// Reads all series up to a time; false when that is too much for one slice.
    fn read(
        &mut self,
        connection: &Connection,
        there: &[Series<'_>],
        part: TimeRange,
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
        for (at, series) in there.iter().enumerate() {
            let Some(next_us) = series.next_us.filter(|next_us| *next_us < end_us) else { continue };
            let mut statement = connection.prepare_cached(&series.sql)?;
            let mut rows = statement.query((series.group.src, series.group.src_ent, next_us, part.to_us))?;
            self.next_us[at] = None;
            while let Some(row) = rows.next()? {
                let time_us = row.get(0)?;
                if time_us >= end_us {
                    self.next_us[at] = Some(time_us);
                    break;
                }
                if !Series::takes(lines.options, &mut self.spans[at], time_us) {
                    continue;
                }
                let start = self.text.len();
                self.rows += lines.write(&mut self.text, series, time_us, row)?;
                self.order.push(Line { time_us, series: at, start, end: self.text.len() });
                if bounded && self.text.len() > SLICE_BYTES {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}

/// Rows of the database as lines of the table.
struct Lines<'p> {
    plan: &'p Plan,
    options: CsvOptions,
    iso: IsoTime,
    received: IsoTime,
}

/// Writes the columns of an arrival; empty for rows of a history that did not know it.
pub(super) fn arrival(out: &mut Vec<u8>, iso: &mut IsoTime, received_us: Option<i64>) {
    out.push(b',');
    if let Some(received_us) = received_us {
        iso.write(out, received_us);
    }
    out.push(b',');
    if let Some(received_us) = received_us {
        number::epoch(out, received_us);
    }
}

impl Lines<'_> {
    /// Writes a message; how many lines that made.
    fn write(
        &mut self,
        out: &mut Vec<u8>,
        series: &Series<'_>,
        time_us: i64,
        row: &Row<'_>,
    ) -> rusqlite::Result<u64> {
        if self.options.shape == Shape::Long {
            return self.write_long(out, series, time_us, row);
        }
        self.start(out, series, time_us, row)?;
        let message = series.message;
        if self.plan.is_mixed() {
            out.push(b',');
            out.extend_from_slice(message.name.as_bytes());
        }
        out.extend(std::iter::repeat_n(b',', message.first_column));
        for (at, field) in message.fields.iter().enumerate() {
            out.push(b',');
            self.value(out, field, row.get_ref(at + self.first_value())?);
        }
        let after = self.plan.columns - message.first_column - message.fields.len();
        out.extend(std::iter::repeat_n(b',', after));
        out.push(b'\n');
        Ok(1)
    }

    fn write_long(
        &mut self,
        out: &mut Vec<u8>,
        series: &Series<'_>,
        time_us: i64,
        row: &Row<'_>,
    ) -> rusqlite::Result<u64> {
        let mut written = 0;
        for (at, field) in series.message.fields.iter().enumerate() {
            let value = row.get_ref(at + self.first_value())?;
            if value == ValueRef::Null {
                continue;
            }
            self.start(out, series, time_us, row)?;
            for name in [series.message.name, field.name] {
                out.push(b',');
                out.extend_from_slice(name.as_bytes());
            }
            out.push(b',');
            self.value(out, field, value);
            out.push(b',');
            out.extend_from_slice(field.unit.unwrap_or_default().as_bytes());
            out.push(b'\n');
            written += 1;
        }
        Ok(written)
    }

    /// What every line begins with.
    fn start(
        &mut self,
        out: &mut Vec<u8>,
        series: &Series<'_>,
        time_us: i64,
        row: &Row<'_>,
    ) -> rusqlite::Result<()> {
        self.iso.write(out, time_us);
        out.push(b',');
        number::epoch(out, time_us);
        out.push(b',');
        out.extend_from_slice(&series.system);
        if let Some(label) = &series.label {
            out.extend_from_slice(label);
        } else {
            let (address, entity) = (Address(series.group.src), series.group.src_ent);
            let label = self.plan.names.entity(address, entity, time_us).unwrap_or_default();
            cell::text(out, label.as_bytes(), self.options.guard);
        }
        out.push(b',');
        number::integer(out, series.group.src_ent.into());
        if self.options.received {
            arrival(out, &mut self.received, row.get(1)?);
        }
        Ok(())
    }

    /// Where the fields begin in a row of the database.
    fn first_value(&self) -> usize {
        1 + usize::from(self.options.received)
    }

    fn value(&self, out: &mut Vec<u8>, field: &Field, value: ValueRef<'_>) {
        match value {
            ValueRef::Null => {}
            ValueRef::Integer(value) => match field.names.and_then(|names| names.label(value)) {
                Some(label) => cell::text(out, label.as_bytes(), self.options.guard),
                // A column of reals gives whole numbers as integers.
                None => match field.factor {
                    Some(factor) => number::double(out, value as f64 * factor),
                    None => number::integer(out, value),
                },
            },
            ValueRef::Real(value) => match (field.factor, field.kind) {
                (Some(factor), _) => number::double(out, value * factor),
                (None, ColumnKind::Single) => number::single(out, value as f32),
                (None, _) => number::double(out, value),
            },
            ValueRef::Text(text) => cell::text(out, text, self.options.guard),
            ValueRef::Blob(bytes) => cell::hex(out, bytes),
        }
    }
}
