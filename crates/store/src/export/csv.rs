//! Tables as CSV: header, lines, cells. [`super::rows`] brings them in their order.

use super::cells::{Exported, Writer, arrival, believed, header_start, receiver};
use super::columns::{Found, RECEIVED_AT};
use super::options::{CsvOptions, Shape};
use super::plan::Plan;
use super::raw::Raw;
use super::rows::{self, Encode, Line, is_nan, sent};
use super::select::Selection;
use crate::error::Result;
use crate::history::rows::Row;
use crate::history::{ColumnKind, GroupKey};
use crate::reader::{Memory, Reader};
use imc::Address;
use rusqlite::types::ValueRef;
use std::io::Write;
use std::path::Path;
use tables::{Field, IsoTime};

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
        writer.flush().and_then(|()| {
            let mut lines = Lines::new(&plan, *options, &mut writer);
            let written = rows::write(&mut reader, &plan, *options, selection.range, &mut lines)?;
            writer.exported.rows = written;
            Ok(())
        })
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
            for (message, field) in plan.fields() {
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

/// Rows of the history as lines of the table.
struct Lines<'p, 'w, 'o> {
    plan: &'p Plan,
    options: CsvOptions,
    iso: IsoTime,
    received: IsoTime,
    writer: &'w mut Writer<'o>,
}

impl Encode for Lines<'_, '_, '_> {
    fn head(&self, group: GroupKey, system: &str, label: Option<&str>) -> Vec<u8> {
        let (mut head, format) = (Vec::new(), self.options.format());
        tables::text(&mut head, system.as_bytes(), format);
        format.next(&mut head);
        head.extend_from_slice(format!("{:#06x}", group.src).as_bytes());
        format.next(&mut head);
        if let Some(label) = label {
            tables::text(&mut head, label.as_bytes(), format);
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

    fn pass_on(&mut self, rows: &mut Vec<u8>) -> Result<()> {
        self.writer.buffer.append(rows);
        self.writer.flush()
    }
}

impl<'p, 'w, 'o> Lines<'p, 'w, 'o> {
    fn new(plan: &'p Plan, options: CsvOptions, writer: &'w mut Writer<'o>) -> Self {
        Self { plan, options, iso: IsoTime::new(), received: IsoTime::new(), writer }
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
        out.extend_from_slice(line.head);
        if line.changes {
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
