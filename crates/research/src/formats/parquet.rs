//! Detections as a Parquet table, for pandas, polars, DuckDB and R's arrow: all columns with their types, packed by Snappy.
//!
//! At most 32,768 rows wait in memory, then they are written as a row group. The footer comes last: readers refuse a file that
//! was cut.

use super::columns::{ColumnKind, LUTRA_COLUMNS, Value, values};
use super::{Format, Rows};
use crate::study::Heard;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::io;
use std::sync::Arc;

/// Rows of a group.
const ROWS: usize = 32_768;

pub(super) const FORMAT: Format = Format {
    name: "parquet",
    about: "pandas, polars, DuckDB, R's arrow: every column with its type",
    // What the file begins with; see `Table::new`.
    header: "PAR1",
    absent: "",
    rows: Rows::Table,
    has_lag: true,
};

/// A table on its way into a file.
#[derive(Debug)]
pub(super) struct Table {
    file: SerializedFileWriter<Vec<u8>>,
    columns: Vec<Values>,
    rows: usize,
}

impl Table {
    /// Without a row yet.
    ///
    /// # Errors
    /// The writer of Parquet fails.
    pub(super) fn new() -> io::Result<Self> {
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(crate::SOFTWARE.to_owned())
            .build();
        let file = SerializedFileWriter::new(Vec::new(), schema().map_err(failed)?, Arc::new(properties));
        let columns = LUTRA_COLUMNS.iter().map(|column| Values::of(column.kind)).collect();
        Ok(Self { file: file.map_err(failed)?, columns, rows: 0 })
    }

    /// Takes the row of a detection.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn row(&mut self, heard: &Heard<'_>) -> io::Result<()> {
        let mut columns = self.columns.iter_mut();
        values(heard, &mut |value| {
            if let Some(column) = columns.next() {
                column.push(value);
            }
        });
        self.rows += 1;
        if self.rows < ROWS { Ok(()) } else { self.group().map_err(failed) }
    }

    /// Appends what is ready.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn drain(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        self.file.flush()?;
        out.append(self.file.inner_mut());
        Ok(())
    }

    /// Writes what still waits, and the footer.
    ///
    /// # Errors
    /// As [`Self::new()`].
    pub(super) fn end(mut self, out: &mut dyn io::Write) -> io::Result<()> {
        if self.rows > 0 {
            self.group().map_err(failed)?;
        }
        out.write_all(&self.file.into_inner().map_err(failed)?)
    }

    /// Makes a group of the rows.
    fn group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for column in &mut self.columns {
            column.write(&mut group)?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

fn failed(error: ParquetError) -> io::Error {
    io::Error::other(error)
}

/// All columns, each of which may have nothing.
fn schema() -> Result<TypePtr, ParquetError> {
    let fields = LUTRA_COLUMNS.iter().map(|column| {
        let (physical, logical) = match column.kind {
            ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            ColumnKind::Whole => (Physical::INT64, None),
            ColumnKind::Real => (Physical::DOUBLE, None),
            ColumnKind::Time => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        };
        let built = Type::primitive_type_builder(column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        Ok(Arc::new(built.build()?))
    });
    let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
    Ok(Arc::new(Type::group_type_builder("detections").with_fields(fields).build()?))
}

/// The values of a column in a group: those that are known, and of each row whether it has one.
#[derive(Debug)]
struct Known<T> {
    values: Vec<T>,
    /// 1 where a row has a value, else 0.
    has: Vec<i16>,
}

impl<T> Known<T> {
    const fn new() -> Self {
        Self { values: Vec::new(), has: Vec::new() }
    }

    fn push(&mut self, value: Option<T>) {
        self.has.push(i16::from(value.is_some()));
        self.values.extend(value);
    }

    fn write<D: DataType<T = T>>(
        &mut self,
        group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    ) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("a column more than the schema has".to_owned()));
        };
        column.typed::<D>().write_batch(&self.values, Some(&self.has), None)?;
        self.values.clear();
        self.has.clear();
        column.close()
    }
}

#[derive(Debug)]
enum Values {
    Text(Known<ByteArray>),
    Whole(Known<i64>),
    Real(Known<f64>),
}

impl Values {
    fn of(kind: ColumnKind) -> Self {
        match kind {
            ColumnKind::Text => Self::Text(Known::new()),
            ColumnKind::Whole | ColumnKind::Time => Self::Whole(Known::new()),
            ColumnKind::Real => Self::Real(Known::new()),
        }
    }

    /// Adds the value of a row; a value of another kind than the column's counts as not known.
    fn push(&mut self, value: Value<'_>) {
        match self {
            Self::Text(known) => known.push(text(value)),
            Self::Whole(known) => known.push(whole(value)),
            Self::Real(known) => known.push(real(value)),
        }
    }

    fn write(&mut self, group: &mut SerializedRowGroupWriter<'_, Vec<u8>>) -> Result<(), ParquetError> {
        match self {
            Self::Text(known) => known.write::<ByteArrayType>(group),
            Self::Whole(known) => known.write::<Int64Type>(group),
            Self::Real(known) => known.write::<DoubleType>(group),
        }
    }
}

fn text(value: Value<'_>) -> Option<ByteArray> {
    match value {
        Value::Text(text) if !text.is_empty() => Some(ByteArray::from(text)),
        _ => None,
    }
}

fn whole(value: Value<'_>) -> Option<i64> {
    if let Value::Whole(value) = value { value } else { value.micros() }
}

/// Whole numbers have a column of their own.
fn real(value: Value<'_>) -> Option<f64> {
    if let Value::Whole(_) = value { None } else { value.number() }
}
