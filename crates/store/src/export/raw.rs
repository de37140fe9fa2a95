//! Messages that the catalogue does not explain, as a table: ids that it lacks, and payloads that do not fit their id.
//! They are kept as received (`_raw` in each month), so that another program that knows them can still read them.

use super::cells::{Writer, arrival, believed, header_start, receiver};
use super::options::{CsvOptions, Shape};
use super::select::{RAW, Selection};
use crate::error::{Result, StoreError};
use crate::history::Names;
use crate::reader::Reader;
use imc::Address;
use rusqlite::Row;
use tables::IsoTime;

pub(super) const COLUMNS: [(&str, &str); 3] = [
    ("id", "number of the message in the packet's header"),
    ("payload", "the payload in hexadecimal"),
    ("problem", "why it is not in a table of its own"),
];

/// An export of all that is kept raw.
pub(super) struct Raw<'s> {
    selection: &'s Selection,
    options: CsvOptions,
    names: Names,
}

impl<'s> Raw<'s> {
    /// # Errors
    /// When a row for each value is asked for: the values are unknown.
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
            self.options.format().next(out);
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
        if !self.selection.says(&self.names, src, src_ent, time_us) {
            return Ok(false);
        }
        let (address, format) = (Address(src), self.options.format());
        tables::stamp(out, iso, believed(time_us), format.dialect);
        format.next(out);
        tables::text(out, self.names.system(address).as_bytes(), format);
        format.next(out);
        out.extend_from_slice(format!("{src:#06x}").as_bytes());
        format.next(out);
        let label = self.names.entity(address, src_ent, time_us).unwrap_or_default();
        tables::text(out, label.as_bytes(), format);
        format.next(out);
        tables::integer(out, src_ent.into());
        receiver(out, row.get(7)?, row.get(8)?, format);
        if self.options.received {
            arrival(out, received, row.get(1)?, format);
        }
        format.next(out);
        tables::integer(out, row.get(4)?);
        format.next(out);
        let payload: Option<Vec<u8>> = row.get(5)?;
        tables::hex(out, &payload.unwrap_or_default());
        format.next(out);
        let problem: Option<String> = row.get(6)?;
        tables::text(out, problem.unwrap_or_default().as_bytes(), format);
        out.push(b'\n');
        Ok(true)
    }
}

/// How many messages a selection leaves out of its tables because the catalogue does not explain them: ids that it lacks, and
/// payloads that are not what their id says.
///
/// # Errors
/// When the selection names what does not exist or the history cannot be read.
pub fn unexplained(reader: &mut Reader, selection: &Selection) -> Result<u64> {
    let selection = selection.known(reader)?;
    let names = reader.names()?;
    let mut count = 0;
    for (key, part) in reader.parts(selection.range)? {
        let connection = reader.month(key)?;
        let ask = || -> rusqlite::Result<u64> {
            let mut groups = connection.prepare_cached("SELECT DISTINCT src,src_ent,id FROM _raw")?;
            let mut found = connection.prepare_cached(
                "SELECT count(*) FROM _raw WHERE src=?1 AND src_ent=?2 AND id=?3 AND time_us>=?4 AND time_us<?5",
            )?;
            let mut count = 0;
            let mut rows = groups.query(())?;
            while let Some(row) = rows.next()? {
                let (src, src_ent, id): (u16, u8, u16) = (row.get(0)?, row.get(1)?, row.get(2)?);
                if !selection.has_message(id) {
                    continue;
                }
                for span in selection.spans(&names, src, src_ent) {
                    let span = span.within(part);
                    let span = (src, src_ent, id, span.from_us, span.to_us);
                    count += found.query_row(span, |row| row.get::<_, i64>(0))?.cast_unsigned();
                }
            }
            Ok(count)
        };
        count += reader.named(key, ask())?;
    }
    Ok(count)
}
