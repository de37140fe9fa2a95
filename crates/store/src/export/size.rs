//! The estimated size of an export: its rows counted, its bytes by the length of the first ones.

use super::cells::Exported;
use super::csv::export_csv;
use super::options::{CsvOptions, Shape};
use super::plan::Plan;
use super::select::Selection;
use crate::error::Result;
use crate::history::Order;
use crate::history::rows::Question;
use crate::range::TimeRange;
use crate::reader::{Memory, Reader};
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
            let Some(table) = reader.schema.table(group.key.id) else { continue };
            let ask = |part: TimeRange| -> rusqlite::Result<u64> {
                let _moment = reader.moment(key)?;
                let Some(mut question) = Question::new(connection, table, group.key, &[], Order::Oldest)?
                else {
                    return Ok(0);
                };
                match options.every_us {
                    None => question.count(part),
                    Some(every_us) => spans(&mut question, part, every_us.get()),
                }
            };
            for span in &group.spans {
                sum += reader.named(key, ask(span.within(part)))?;
            }
        }
    }
    Ok(sum)
}

/// Spans of so many microseconds in which there is a row.
fn spans(question: &mut Question<'_>, part: TimeRange, every_us: i64) -> rusqlite::Result<u64> {
    let (mut last, mut count) = (None, 0);
    let mut rows = question.rows(part)?;
    while let Some(row) = rows.next()? {
        let span = row.time_us()?.div_euclid(every_us);
        count += u64::from(last.replace(span) != Some(span));
    }
    Ok(count)
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
