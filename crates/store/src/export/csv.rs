//! Tables as CSV, in order of time, in constant memory.
//!
//! A single series is streamed. Several are read in slices of time that hold about a megabyte of
//! text; the rows of a slice are sorted and written. Rows of one time are in the order of message, system and
//! entity. The same question to the same history gives the same bytes.

use super::cells::{Exported, Writer, arrival, believed, header_start, receiver};
use super::options::{CsvOptions, Shape};
use super::plan::{Message, Plan};
use super::raw::Raw;
use super::select::Selection;
use crate::error::Result;
use crate::history::{ColumnKind, GroupKey, Table};
use crate::range::TimeRange;
use crate::reader::{Memory, Reader, fields_sent, has_group, select_list};
use imc::Address;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Row};
use std::io::Write;
use std::path::Path;
use tables::{Computed, Field, IsoTime};

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
struct Series<'p> {
    group: GroupKey,
    /// When it is asked for.
    part: TimeRange,
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
        for group in &plan.groups {
            let message = &plan.messages[group.message];
            let Some(table) = reader.schema.table(group.key.id) else { continue };
            for span in group.spans.iter().map(|span| span.within(part)).filter(|span| !span.is_empty()) {
                let series = series(connection, plan, options, group.key, message, table, span);
                there.extend(reader.named(key, series)?);
            }
        }
        let mut lines = Lines { plan, options, iso: IsoTime::new(), received: IsoTime::new() };
        if let [one] = there.as_slice() {
            stream(reader, key, connection, one, &mut lines, writer)?;
        } else {
            slices(reader, key, connection, &mut there, part.to_us, &mut lines, writer)?;
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
    let sql = select(connection, group, message, table, options)?;
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
    let mut series = Series { group, part, message, sql, system, label, next_us: None, span: None };
    let mut statement = connection.prepare_cached(&series.sql)?;
    let mut rows = statement.query((group.src, group.src_ent, part.from_us, part.to_us))?;
    series.next_us = rows.next()?.map(|row| row.get(0)).transpose()?;
    Ok(series.next_us.is_some().then_some(series))
}

/// Columns of a row before its fields: time, fields that were sent, receiver, and when it came.
const BEFORE_FIELDS: usize = 4;

/// The question for a series' rows: what [`Lines::start`] writes, then the fields.
fn select(
    connection: &Connection,
    group: GroupKey,
    message: &Message,
    table: &Table,
    options: CsvOptions,
) -> rusqlite::Result<String> {
    let field = |field: &Field| match field.computed {
        Some(Computed::Heard) => Ok(format!(
            ",{}",
            if_heard(
                "strftime('%Y-%m-%dT%H:%M:%S', unix_timestamp, 'unixepoch') || printf('.%03dZ', millis)"
            )
        )),
        Some(Computed::HeardUnix) => Ok(format!(",{}", if_heard("unix_timestamp + millis / 1000.0"))),
        Some(Computed::TrueLat | Computed::TrueLon) | None => select_list(connection, table, &[field.name]),
    };
    let fields: String = message.fields.iter().map(field).collect::<rusqlite::Result<_>>()?;
    Ok(format!(
        "SELECT time_us,{},dst,dst_ent{}{fields} FROM \"{}\" AS message WHERE src=?1 AND src_ent=?2 AND \
         time_us>=?3 AND time_us<?4 ORDER BY time_us,hash",
        fields_sent(connection, group)?,
        if options.received { ",received_us" } else { "" },
        table.desc.abbrev
    ))
}

/// The computed columns of a receiver's clock; empty where that was never set.
fn if_heard(sql: &str) -> String {
    format!("CASE WHEN unix_timestamp >= {} THEN {sql} END", detections::SET_AFTER_S)
}

/// One series: streamed.
fn stream(
    reader: &Reader,
    key: crate::MonthKey,
    connection: &Connection,
    series: &Series<'_>,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let mut statement = reader.named(key, connection.prepare_cached(&series.sql))?;
    let span = (series.group.src, series.group.src_ent, series.part.from_us, series.part.to_us);
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
    to_us: i64,
    lines: &mut Lines<'_>,
    writer: &mut Writer<'_>,
) -> Result<()> {
    let mut slice = Slice::default();
    let mut width_us = FIRST_SLICE_US;
    while let Some(start_us) = there.iter().filter_map(|series| series.next_us).min() {
        let end_us = start_us.saturating_add(width_us).min(to_us);
        let whole = reader.named(key, slice.read(connection, there, end_us, width_us > 1, lines))?;
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
            let mut rows =
                statement.query((series.group.src, series.group.src_ent, next_us, series.part.to_us))?;
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
        let (message, format) = (series.message, self.options.format());
        self.start(out, series, time_us, row)?;
        if self.plan.is_mixed() {
            format.next(out);
            out.extend_from_slice(message.name.as_bytes());
        }
        format.skip(out, message.first_column);
        let sent = sent(row)?;
        for (at, field) in message.fields.iter().enumerate() {
            format.next(out);
            self.value(out, field, row.get_ref(at + self.first_value())?, sent);
        }
        format.skip(out, self.plan.columns - message.first_column - message.fields.len());
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
        let (sent, format) = (sent(row)?, self.options.format());
        let mut written = 0;
        for (at, field) in series.message.fields.iter().enumerate() {
            let value = row.get_ref(at + self.first_value())?;
            if value == ValueRef::Null && !is_nan(field, sent) {
                continue;
            }
            self.start(out, series, time_us, row)?;
            for name in [series.message.name, field.name] {
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
        series: &Series<'_>,
        time_us: i64,
        row: &Row<'_>,
    ) -> rusqlite::Result<()> {
        let format = self.options.format();
        tables::stamp(out, &mut self.iso, believed(time_us), format.dialect);
        format.next(out);
        out.extend_from_slice(&series.system);
        if let Some(label) = &series.label {
            out.extend_from_slice(label);
        } else {
            let (address, entity) = (Address(series.group.src), series.group.src_ent);
            let label = self.plan.names.entity(address, entity, time_us).unwrap_or_default();
            tables::text(out, label.as_bytes(), format);
        }
        format.next(out);
        tables::integer(out, series.group.src_ent.into());
        receiver(out, row.get(2)?, row.get(3)?, format);
        if self.options.received {
            arrival(out, &mut self.received, row.get(BEFORE_FIELDS)?, format);
        }
        Ok(())
    }

    /// Where the fields begin in a row of the database.
    fn first_value(&self) -> usize {
        BEFORE_FIELDS + usize::from(self.options.received)
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
fn sent(row: &Row<'_>) -> rusqlite::Result<usize> {
    Ok(row.get::<_, Option<u32>>(1)?.map_or(usize::MAX, |fields| fields as usize))
}

/// Whether a NULL is a NaN: of a real that was sent.
fn is_nan(field: &Field, sent: usize) -> bool {
    matches!(field.kind, ColumnKind::Single | ColumnKind::Double) && field.at.is_some_and(|at| at < sent)
}
