//! What the catalogue does not explain, as a table: ids that it lacks, and payloads that are not what their id says.
//! Such messages are kept as they came (`_raw` in each month), so that whoever knows them can still read them.

use super::cell;
use super::csv::{Writer, arrival, header_start};
use super::number::{self, IsoTime};
use super::plan::{CsvOptions, RAW, Selection, Shape, described, described_start, says};
use crate::error::{Result, StoreError};
use crate::history::Names;
use crate::reader::Reader;
use imc::Address;
use rusqlite::Row;
use serde_json::{Value, json};

const COLUMNS: [(&str, &str); 5] = [
    ("id", "number of the message in the packet's header"),
    ("payload", "the payload in hexadecimal"),
    ("problem", "why it is not in a table of its own"),
    ("dst", "IMC address of the system that it was said to"),
    ("dst_ent", "number of the entity that it was said to"),
];

/// An export of all that is kept raw.
pub(super) struct Raw<'s> {
    selection: &'s Selection,
    options: CsvOptions,
    names: Names,
}

impl<'s> Raw<'s> {
    /// # Errors
    /// When a row for each value is asked for: nobody knows the values.
    pub(super) fn new(reader: &Reader, selection: &'s Selection, options: CsvOptions) -> Result<Self> {
        if options.shape == Shape::Long {
            let problem = format!("`{RAW}` has no values to give a row each: ask for a wide table");
            return Err(StoreError::Query(problem));
        }
        Ok(Self { selection, options, names: reader.names()? })
    }

    pub(super) fn header(&self, out: &mut Vec<u8>) {
        header_start(out, self.options);
        for (name, _) in COLUMNS {
            out.push(b',');
            out.extend_from_slice(name.as_bytes());
        }
        out.push(b'\n');
    }

    /// Writes a row for each message, in order of time. The database sorts them, on disk if they are many.
    pub(super) fn rows(&self, reader: &mut Reader, writer: &mut Writer<'_>) -> Result<()> {
        let (mut iso, mut received) = (IsoTime::new(), IsoTime::new());
        for (key, part) in reader.parts(self.selection.range)? {
            let connection = reader.month(key)?;
            let sql = "SELECT time_us,received_us,src,src_ent,id,payload,problem,dst,dst_ent FROM _raw \
                       WHERE time_us>=?1 AND time_us<?2 ORDER BY time_us,src,src_ent,id,hash";
            let mut statement = reader.named(key, connection.prepare(sql))?;
            let mut rows = reader.named(key, statement.query((part.from_us, part.to_us)))?;
            while let Some(row) = reader.named(key, rows.next())? {
                let written = self.row(&mut writer.buffer, row, (&mut iso, &mut received));
                writer.exported.rows += u64::from(reader.named(key, written)?);
                writer.flush_full()?;
            }
        }
        Ok(())
    }

    /// Writes a message that is asked for; whether it is.
    fn row(
        &self,
        out: &mut Vec<u8>,
        row: &Row<'_>,
        (iso, received): (&mut IsoTime, &mut IsoTime),
    ) -> rusqlite::Result<bool> {
        let (time_us, src, src_ent) = (row.get(0)?, row.get(2)?, row.get(3)?);
        if !says(&self.names, self.selection, src, src_ent) {
            return Ok(false);
        }
        let address = Address(src);
        iso.write(out, time_us);
        out.push(b',');
        number::epoch(out, time_us);
        out.push(b',');
        cell::text(out, self.names.system(address).as_bytes(), self.options.guard);
        out.extend_from_slice(format!(",{src:#06x},").as_bytes());
        let label = self.names.entity(address, src_ent, time_us).unwrap_or_default();
        cell::text(out, label.as_bytes(), self.options.guard);
        out.push(b',');
        number::integer(out, src_ent.into());
        if self.options.received {
            arrival(out, received, row.get(1)?);
        }
        out.push(b',');
        number::integer(out, row.get(4)?);
        out.push(b',');
        let payload: Option<Vec<u8>> = row.get(5)?;
        cell::hex(out, &payload.unwrap_or_default());
        out.push(b',');
        let problem: Option<String> = row.get(6)?;
        cell::text(out, problem.unwrap_or_default().as_bytes(), self.options.guard);
        out.extend_from_slice(format!(",{:#06x},", row.get::<_, u16>(7)?).as_bytes());
        number::integer(out, row.get(8)?);
        out.push(b'\n');
        Ok(true)
    }
}

/// What stands in each column.
pub(super) fn describe(selection: &Selection, options: CsvOptions) -> Value {
    let mut columns = described_start(options);
    columns.extend(
        COLUMNS.iter().map(|(name, meaning)| json!({"name": name, "description": meaning, "unit": null})),
    );
    described(&columns, selection, options)
}
