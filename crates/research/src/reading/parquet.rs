//! Our own table as Parquet, row by row. Its pages are measured before any is unpacked ([`super::pages`]).
//!
//! The library that reads it panics on some damaged files: that is caught here and is damage like any other.

use super::pages;
use super::row::{Columns, Row};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::file::reader::{ChunkReader, FileReader as _, SerializedFileReader};
use parquet::record::Field;
use std::io;
use std::panic::{self, AssertUnwindSafe};
use units::UtcTime;

/// The columns of a file.
///
/// # Errors
/// It is not a whole file of Parquet.
pub(super) fn columns<R: ChunkReader + 'static>(input: &R) -> io::Result<Columns> {
    caught(|| {
        let footer = footer(input)?;
        let fields = footer.file_metadata().schema().get_fields();
        Ok(Columns::named(fields.iter().map(|field| field.name().to_owned()).collect()))
    })
}

fn footer<R: ChunkReader>(input: &R) -> io::Result<ParquetMetaData> {
    ParquetMetaDataReader::new().parse_and_finish(input).map_err(|error| damaged(&error))
}

/// Hands over each row; the first has number 1.
///
/// # Errors
/// The file is damaged, or `take` fails.
pub(super) fn each<R: ChunkReader + 'static>(
    input: R,
    columns: &Columns,
    take: &mut dyn FnMut(&Row<'_>) -> io::Result<()>,
) -> io::Result<()> {
    caught(|| pages::measure(&input, &footer(&input)?))?;
    let file = caught(|| SerializedFileReader::new(input).map_err(|error| damaged(&error)))?;
    let at_row =
        |number: u32| move |error: io::Error| io::Error::new(error.kind(), format!("row {number}: {error}"));
    let rows = caught(|| file.get_row_iter(None).map_err(|error| damaged(&error)));
    let mut rows = rows.map_err(at_row(1))?;
    let mut values: Vec<String> = Vec::new();
    for number in 1.. {
        let next = caught(|| rows.next().transpose().map_err(|error| damaged(&error)));
        let Some(row) = next.map_err(at_row(number))? else { break };
        values.clear();
        values.extend(row.get_column_iter().map(|(_, field)| text(field)));
        take(&Row::of_values(columns, number, &values))?;
    }
    Ok(())
}

/// Runs a step of the library. After a panic nothing of it is used any more.
fn caught<T>(step: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    panic::catch_unwind(AssertUnwindSafe(step)).unwrap_or_else(|_| {
        Err(damaged(&ParquetError::General("its pages contradict each other".to_owned())))
    })
}

/// As a CSV file has it.
fn text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::TimestampMicros(time_us) => UtcTime::from_micros(*time_us).to_string(),
        Field::Long(value) => value.to_string(),
        Field::Double(value) => value.to_string(),
        other => other.to_string(),
    }
}

fn damaged(error: &ParquetError) -> io::Error {
    let text = format!("this is not a whole file of Parquet, download it again ({error})");
    io::Error::new(io::ErrorKind::InvalidData, text)
}
