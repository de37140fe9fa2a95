//! The estimated size of an export: its rows counted, its bytes by the length of the first ones.

use super::cells::Exported;
use super::csv::export_csv;
use super::options::{CsvOptions, Shape};
use super::plan::Plan;
use super::select::Selection;
use crate::error::Result;
use crate::range::TimeRange;
use crate::reader::{Memory, Reader, has_group};
use std::io::{self, Write};
use std::path::Path;

/// So much of the table is written to learn how long its rows are, bytes.
const SAMPLE_BYTES: usize = 1 << 17;

/// The rows of a table, and about how many bytes it will have. A long table has about as many rows as values; of what the
/// catalogue does not explain nothing is counted.
///
/// # Errors
/// As the export itself.
pub fn measure_csv(data: &Path, selection: &Selection, options: &CsvOptions) -> Result<Exported> {
    let mut sample = Sample::default();
    match export_csv(data, selection, options, &mut sample) {
        // All of it fits into the sample.
        Ok(exported) => return Ok(exported),
        Err(error) if sample.bytes < SAMPLE_BYTES => return Err(error),
        Err(_) => {}
    }
    let mut reader = Reader::open_with(data, Memory::EXPORT)?;
    let selection = &selection.known(&mut reader)?;
    let messages = if selection.is_raw() { 0 } else { count(&mut reader, selection, *options)? };
    let rows = if options.shape == Shape::Long {
        // By the share of the sample that one message fills.
        messages.saturating_mul(values(&mut reader, selection, *options)?)
    } else {
        messages
    };
    let bytes = (rows as f64 * sample.bytes as f64 / sample.lines.max(1) as f64) as u64;
    Ok(Exported { rows, bytes })
}

/// Messages, or spans with one.
fn count(reader: &mut Reader, selection: &Selection, options: CsvOptions) -> Result<u64> {
    let plan = Plan::new(reader, selection, options)?;
    let mut sum = 0;
    for (key, part) in reader.parts(selection.range)? {
        let connection = reader.month(key)?;
        for group in &plan.groups {
            let name = plan.messages[group.message].name;
            let what = match options.every_us {
                Some(every_us) => format!("count(DISTINCT time_us / {every_us})"),
                None => "count(*)".to_owned(),
            };
            let sql = format!(
                "SELECT {what} FROM \"{name}\" WHERE src=?1 AND src_ent=?2 AND time_us>=?3 AND time_us<?4"
            );
            let ask = |span: TimeRange| -> rusqlite::Result<u64> {
                if !has_group(connection, group.key)? {
                    return Ok(0);
                }
                let span = (group.key.src, group.key.src_ent, span.from_us, span.to_us);
                connection.query_row(&sql, span, |row| row.get::<_, i64>(0)).map(i64::cast_unsigned)
            };
            for span in &group.spans {
                sum += reader.named(key, ask(span.within(part)))?;
            }
        }
    }
    Ok(sum)
}

/// Fields of a message, of those asked for; the mean of several messages.
fn values(reader: &mut Reader, selection: &Selection, options: CsvOptions) -> Result<u64> {
    let plan = Plan::new(reader, selection, options)?;
    let fields: usize = plan.messages.iter().map(|message| message.fields.len()).sum();
    Ok((fields / plan.messages.len().max(1)) as u64)
}

#[derive(Default)]
struct Sample {
    bytes: usize,
    lines: usize,
}

impl Write for Sample {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.bytes >= SAMPLE_BYTES {
            return Err(io::ErrorKind::WriteZero.into());
        }
        self.bytes += bytes.len();
        self.lines += bytes.split(|byte| *byte == b'\n').count() - 1;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
