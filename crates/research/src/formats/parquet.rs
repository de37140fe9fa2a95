//! Detections as a Parquet table, for pandas, polars, DuckDB and R's arrow: all columns with their types, packed by Snappy.
//!
//! The columns are those of our CSV; [`parquetfile`] writes them.

use super::columns::{ColumnKind, LUTRA_COLUMNS, Value, values};
use super::{Format, Rows};
use crate::study::Heard;
use parquetfile::{Column, Kind};
use std::io;

pub(super) const FORMAT: Format = Format {
    name: "parquet",
    about: "pandas, polars, DuckDB, R's arrow: every column with its type",
    // What the file begins with; see `Table::new`.
    header: parquetfile::MAGIC,
    absent: "",
    rows: Rows::Table,
    has_lag: true,
};

/// A table on its way into a file.
#[derive(Debug)]
pub(super) struct Table(parquetfile::Table);

impl Table {
    /// Without a row yet.
    ///
    /// # Errors
    /// The writer of Parquet fails.
    pub(super) fn new() -> io::Result<Self> {
        let columns =
            LUTRA_COLUMNS.map(|column| Column { name: column.name.to_owned(), kind: kind(column.kind) });
        parquetfile::Table::new(&columns, &[], crate::SOFTWARE).map(Self)
    }

    /// Takes the row of a detection.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn row(&mut self, heard: &Heard<'_>) -> io::Result<()> {
        let mut pushed = Ok(());
        let mut columns = LUTRA_COLUMNS.iter();
        values(heard, &mut |value| {
            if let (Ok(()), Some(column)) = (&pushed, columns.next()) {
                pushed = self.0.push(known(column.kind, value));
            }
        });
        pushed
    }

    /// Appends what is ready.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn drain(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        self.0.drain(out)
    }

    /// Writes what still waits, and the footer.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn end(self, out: &mut dyn io::Write) -> io::Result<()> {
        let mut last = Vec::new();
        self.0.end(&mut last)?;
        out.write_all(&last)
    }
}

fn kind(kind: ColumnKind) -> Kind {
    match kind {
        ColumnKind::Text => Kind::Text,
        ColumnKind::Whole => Kind::Whole,
        ColumnKind::Real => Kind::Real,
        ColumnKind::Time => Kind::Time,
    }
}

/// A value as its column has it; one of another kind counts as not known, and whole numbers have a column of their own.
fn known(kind: ColumnKind, value: Value<'_>) -> parquetfile::Value<'_> {
    let whole = |value: Option<i64>| value.map_or(parquetfile::Value::Absent, parquetfile::Value::Whole);
    match (kind, value) {
        (ColumnKind::Text, Value::Text(text)) if !text.is_empty() => {
            parquetfile::Value::Bytes(text.as_bytes())
        }
        (ColumnKind::Whole | ColumnKind::Time, Value::Whole(value)) => whole(value),
        (ColumnKind::Whole | ColumnKind::Time, value) => whole(value.micros()),
        (ColumnKind::Real, Value::Whole(_)) | (ColumnKind::Text, _) => parquetfile::Value::Absent,
        (ColumnKind::Real, value) => {
            value.number().map_or(parquetfile::Value::Absent, parquetfile::Value::Real)
        }
    }
}
