//! Tables as Parquet: the columns of a wide CSV with their types. [`super::rows`] brings the rows in their order, `parquetfile`
//! writes them.
//!
//! Between the two a row is bytes: one [`Cell`] after the other, for each column of the table.

use super::cells::{CHUNK_BYTES, Exported, Writer, believed, unwritable};
use super::columns::RECEIVED_AT;
use super::describe;
use super::options::{CsvOptions, Shape};
use super::plan::Plan;
use super::rows::{self, Encode, Line, is_nan, sent};
use super::select::{RAW, Selection};
use crate::error::{Result, StoreError};
use crate::history::rows::Row;
use crate::history::{ColumnKind, GroupKey};
use crate::reader::{Memory, Reader};
use imc::Address;
use parquetfile::{Column, Kind, Table, Value};
use rusqlite::types::ValueRef;
use std::io::Write;
use std::path::Path;
use tables::{Computed, Dialect, Field};

/// Most columns: the footer keeps what it says of each column of each group in memory until the end.
const MOST_COLUMNS: usize = 128;

/// Writes a table as a Parquet file: the same columns and values as a wide [CSV](crate::export_csv) has, with their types. Times are
/// timestamps, bytes are bytes, and what a field's name stands for is in the footer (`lutra`, as JSON). A file that was cut has
/// no footer and is refused by its readers.
///
/// # Errors
/// The options are those of text alone (a row for each value, a spreadsheet's dialect, `_raw`), there would be more than 128
/// columns, the selection names what does not exist, the history cannot be read or `out` not be written.
pub fn export_parquet(
    data: &Path,
    selection: &Selection,
    options: &CsvOptions,
    out: &mut dyn Write,
) -> Result<Exported> {
    check_parquet(&selection.messages, options)?;
    let mut reader = Reader::open_with(data, Memory::EXPORT)?;
    let selection = &selection.known(&mut reader)?;
    let plan = Plan::new(&mut reader, selection, *options)?;
    let columns = columns(&plan, *options);
    if columns.len() > MOST_COLUMNS {
        let problem = format!(
            "message: this table has {} columns, and Parquet takes {MOST_COLUMNS} here: name fewer messages or fields, or ask \
             for CSV",
            columns.len()
        );
        return Err(StoreError::Query(problem));
    }
    let mut cells = Cells::new(&plan, &columns, selection, *options, out).map_err(unwritable)?;
    // The client gets the first bytes before the first query to the database.
    cells.table.drain(&mut cells.writer.buffer).map_err(unwritable)?;
    cells.writer.flush()?;
    let rows = rows::write(&mut reader, &plan, *options, selection.range, &mut cells)?;
    let Cells { table, mut writer, .. } = cells;
    table.end(&mut writer.buffer).map_err(unwritable)?;
    writer.flush()?;
    Ok(Exported { rows, bytes: writer.exported.bytes })
}

/// Whether a table of these messages can be had as Parquet.
///
/// # Errors
/// They cannot; the error names the parameter and what to do.
pub fn check_parquet(messages: &[String], options: &CsvOptions) -> Result<()> {
    let problem = if options.shape == Shape::Long {
        "shape: Parquet has a column for each field, not a row for each value: ask for a wide table, or for CSV"
    } else if options.dialect != Dialect::Plain {
        "spreadsheet: Parquet has numbers, not their texts: leave it out, or ask for CSV"
    } else if messages == [RAW] {
        "message: `_raw` is there as CSV and in the log (LSF) alone"
    } else {
        return Ok(());
    };
    Err(StoreError::Query(problem.to_owned()))
}

/// The columns of the table.
fn columns(plan: &Plan, options: CsvOptions) -> Vec<Column> {
    let column = |name: &str, kind| Column { name: name.to_owned(), kind };
    let mut columns = vec![
        column("time", Kind::Time),
        column("system", Kind::Text),
        column("system_id", Kind::Text),
        column("entity", Kind::Text),
        column("entity_id", Kind::Whole),
        column("dst", Kind::Text),
        column("dst_ent", Kind::Whole),
    ];
    if options.received {
        columns.push(column("received", Kind::Time));
    }
    if plan.is_mixed() {
        columns.push(column("message", Kind::Text));
    }
    columns.extend(plan.fields().map(|(message, field)| {
        let name = if options.units {
            tables::heading(message.name, field, plan.is_mixed())
        } else {
            plan.column(message, field)
        };
        Column { name, kind: kind(field) }
    }));
    columns
}

/// The type of a field's column.
fn kind(field: &Field) -> Kind {
    match (field.computed, field.kind) {
        (Some(Computed::Heard), _) => Kind::Time,
        _ if field.names.is_some() => Kind::Text,
        _ if field.factor.is_some() => Kind::Real,
        (_, ColumnKind::Integer) => Kind::Whole,
        (_, ColumnKind::Single) => Kind::Single,
        (_, ColumnKind::Double) => Kind::Real,
        (_, ColumnKind::Text) => Kind::Text,
        (_, ColumnKind::Raw) => Kind::Raw,
        (_, ColumnKind::Nested) => Kind::Json,
    }
}

/// The rows of the history as cells of the table.
struct Cells<'p, 'o> {
    plan: &'p Plan,
    options: CsvOptions,
    table: Table,
    writer: Writer<'o>,
}

impl<'p, 'o> Cells<'p, 'o> {
    fn new(
        plan: &'p Plan,
        columns: &[Column],
        selection: &Selection,
        options: CsvOptions,
        out: &'o mut dyn Write,
    ) -> std::io::Result<Self> {
        let about = [("lutra", describe::describe_fields(plan, selection).to_string())];
        let software = concat!("Lutra ", env!("CARGO_PKG_VERSION"));
        let table = Table::new(columns, &about, software)?;
        Ok(Self { plan, options, table, writer: Writer::new(out) })
    }
}

impl Encode for Cells<'_, '_> {
    fn head(&self, group: GroupKey, system: &str, label: Option<&str>) -> Vec<u8> {
        let mut head = Vec::new();
        text(&mut head, system);
        text(&mut head, &format!("{:#06x}", group.src));
        if let Some(label) = label {
            text(&mut head, label);
        }
        head
    }

    fn write(
        &mut self,
        out: &mut Vec<u8>,
        line: &Line<'_>,
        time_us: i64,
        row: Row<'_>,
    ) -> rusqlite::Result<u64> {
        put_whole(out, believed(time_us));
        out.extend_from_slice(line.head);
        if line.changes {
            let (address, entity) = (Address(line.group.src), line.group.src_ent);
            text(out, self.plan.names.entity(address, entity, time_us).unwrap_or_default());
        }
        put_whole(out, Some(line.group.src_ent.into()));
        let (dst, dst_ent): (Option<u16>, Option<u8>) = (row.get(1)?, row.get(2)?);
        match dst {
            Some(dst) => text(out, &format!("{dst:#06x}")),
            None => Cell::Value(Value::Absent).put(out),
        }
        put_whole(out, dst_ent.map(i64::from));
        if self.options.received {
            put_whole(out, row.get(RECEIVED_AT)?);
        }
        let message = line.message;
        if self.plan.is_mixed() {
            text(out, message.name);
        }
        Cell::Skip(message.first_column).put(out);
        let sent = sent(row)?;
        for (field, at) in message.fields.iter().zip(line.places) {
            put_field(out, field, row, *at, sent)?;
        }
        Cell::Skip(self.plan.columns - message.first_column - message.fields.len()).put(out);
        Ok(1)
    }

    fn pass_on(&mut self, rows: &mut Vec<u8>) -> Result<()> {
        let mut rest = rows.as_slice();
        while let Some(cell) = Cell::take(&mut rest) {
            match cell {
                Cell::Value(value) => self.table.push(value).map_err(unwritable)?,
                Cell::Skip(columns) => {
                    for _ in 0..columns {
                        self.table.push(Value::Absent).map_err(unwritable)?;
                    }
                }
            }
        }
        rows.clear();
        self.table.drain(&mut self.writer.buffer).map_err(unwritable)?;
        if self.writer.buffer.len() >= CHUNK_BYTES { self.writer.flush() } else { Ok(()) }
    }
}

fn put_whole(out: &mut Vec<u8>, value: Option<i64>) {
    Cell::Value(value.map_or(Value::Absent, Value::Whole)).put(out);
}

fn text(out: &mut Vec<u8>, text: &str) {
    Cell::Value(Value::Bytes(text.as_bytes())).put(out);
}

/// Appends a field's value, which is at this place of the row; `sent` fields of the message were there.
fn put_field(out: &mut Vec<u8>, field: &Field, row: Row<'_>, at: usize, sent: usize) -> rusqlite::Result<()> {
    if let Some(Computed::Heard | Computed::HeardUnix) = field.computed {
        let (unix_s, millis): (Option<u32>, Option<u16>) = (row.get(at)?, row.get(at + 1)?);
        let heard = unix_s.zip(millis).and_then(|(unix_s, millis)| Computed::heard(unix_s, millis));
        let ms = heard.map(|(unix_s, millis)| i64::from(unix_s) * 1_000 + i64::from(millis));
        let value = ms.map_or(Value::Absent, |ms| match kind(field) {
            Kind::Time => Value::Whole(ms * 1_000),
            _ => Value::Real(ms as f64 / 1_000.0),
        });
        Cell::Value(value).put(out);
        return Ok(());
    }
    let real = |value: f64| Value::Real(field.factor.map_or(value, |factor| value * factor));
    let is_real = matches!(field.kind, ColumnKind::Single | ColumnKind::Double);
    match row.value(at)? {
        ValueRef::Null if is_nan(field, sent) => Cell::Value(Value::Real(f64::NAN)).put(out),
        ValueRef::Null => Cell::Value(Value::Absent).put(out),
        ValueRef::Integer(value) => match field.names {
            Some(names) => match names.label(value) {
                Some(label) => text(out, &label),
                None => text(out, &value.to_string()),
            },
            // A column of reals gives whole numbers as integers where it is computed.
            None if is_real || field.factor.is_some() => Cell::Value(real(value as f64)).put(out),
            None => Cell::Value(Value::Whole(value)).put(out),
        },
        ValueRef::Real(value) => Cell::Value(real(value)).put(out),
        ValueRef::Blob(bytes) if field.kind == ColumnKind::Raw => Cell::Value(Value::Bytes(bytes)).put(out),
        ValueRef::Text(json) if field.kind == ColumnKind::Nested => Cell::Value(Value::Bytes(json)).put(out),
        ValueRef::Text(bytes) | ValueRef::Blob(bytes) => text(out, &imc::text::escape(bytes)),
    }
    Ok(())
}

/// A value on its way from a row of the history to its column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cell<'c> {
    Value(Value<'c>),
    /// So many columns without a value.
    Skip(usize),
}

impl<'c> Cell<'c> {
    fn put(self, out: &mut Vec<u8>) {
        let mut fixed = |tag: u8, bytes: [u8; 8]| {
            out.push(tag);
            out.extend_from_slice(&bytes);
        };
        match self {
            Self::Value(Value::Absent) => out.push(0),
            Self::Value(Value::Whole(value)) => fixed(1, value.to_le_bytes()),
            Self::Value(Value::Real(value)) => fixed(2, value.to_le_bytes()),
            Self::Value(Value::Bytes(bytes)) => {
                fixed(3, (bytes.len() as u64).to_le_bytes());
                out.extend_from_slice(bytes);
            }
            Self::Skip(columns) => fixed(4, (columns as u64).to_le_bytes()),
        }
    }

    /// The next cell of what [`Self::put()`] wrote; `None` at its end.
    fn take(from: &mut &'c [u8]) -> Option<Self> {
        let tag = *from.split_off_first()?;
        if tag == 0 {
            return Some(Self::Value(Value::Absent));
        }
        let bytes = *from.split_off(..8)?.first_chunk()?;
        Some(match tag {
            1 => Self::Value(Value::Whole(i64::from_le_bytes(bytes))),
            2 => Self::Value(Value::Real(f64::from_le_bytes(bytes))),
            3 => Self::Value(Value::Bytes(from.split_off(..u64::from_le_bytes(bytes) as usize)?)),
            _ => Self::Skip(u64::from_le_bytes(bytes) as usize),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_back_as_they_were_put() {
        let cells = [
            Cell::Value(Value::Absent),
            Cell::Value(Value::Whole(-1)),
            Cell::Value(Value::Real(f64::INFINITY)),
            Cell::Value(Value::Bytes(b"")),
            Cell::Value(Value::Bytes(b"\x00\x03text")),
            Cell::Skip(0),
            Cell::Skip(3_000),
        ];
        let mut bytes = Vec::new();
        for cell in cells {
            cell.put(&mut bytes);
        }
        let mut rest = bytes.as_slice();
        let back: Vec<Cell<'_>> = std::iter::from_fn(|| Cell::take(&mut rest)).collect();
        assert_eq!(back, cells);
    }
}
