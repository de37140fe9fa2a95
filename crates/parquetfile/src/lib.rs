//! Tables as Parquet files, for pandas, polars, DuckDB and R's arrow: every column with its type, packed by Snappy.
//!
//! A [`Table`] has [`Column`]s, takes [`Value`]s row by row and gives the bytes of the file as they are ready. It knows nothing of
//! what the columns mean and opens no file. Rows wait in memory until they are a group: [`ROWS`] of them, [`CELLS`] or
//! [`BYTES`], whichever comes first. The footer comes last, so that readers refuse a file that was cut.

mod values;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use std::io;
use std::sync::Arc;
use values::Values;

/// Most rows of a group.
pub const ROWS: usize = 32_768;
/// Most cells of a group, also empty ones: a table may have thousands of columns.
pub const CELLS: usize = 1 << 21;
/// Most bytes of texts and raw bytes in a group, unless one row alone has more.
pub const BYTES: usize = 8 << 20;

/// The media type of a file.
pub const MEDIA: &str = "application/vnd.apache.parquet";
/// What every Parquet file begins with.
pub const MAGIC: &str = "PAR1";

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// UTF-8.
    Text,
    /// A JSON document.
    Json,
    /// Bytes without a meaning.
    Raw,
    /// A whole number of 64 bits.
    Whole,
    /// A number of 32 bits.
    Single,
    /// A number of 64 bits.
    Real,
    /// A moment, UTC, in microseconds.
    Time,
}

/// A column. Each row may have nothing in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
}

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'v> {
    /// Not known.
    Absent,
    /// For [`Kind::Whole`], and µs since 1970-01-01 UTC for [`Kind::Time`].
    Whole(i64),
    /// For [`Kind::Real`] and [`Kind::Single`].
    Real(f64),
    /// For [`Kind::Text`], [`Kind::Json`] and [`Kind::Raw`]; the first two must be UTF-8.
    Bytes(&'v [u8]),
}

/// A table on its way into a file.
#[derive(Debug)]
pub struct Table {
    file: SerializedFileWriter<Vec<u8>>,
    columns: Vec<Values>,
    /// The column of the next value.
    column: usize,
    /// Rows that wait.
    rows: usize,
    /// Bytes of texts that wait.
    bytes: usize,
}

impl Table {
    /// A table without a row yet. `about` are pairs of name and text that stand in the file's footer.
    ///
    /// # Errors
    /// The writer of Parquet fails.
    pub fn new(columns: &[Column], about: &[(&str, String)], software: &str) -> io::Result<Self> {
        let about =
            about.iter().map(|(name, text)| KeyValue::new((*name).to_owned(), text.clone())).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(software.to_owned())
            .set_key_value_metadata(Some(about))
            .build();
        let schema = schema(columns).map_err(failed)?;
        let file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties)).map_err(failed)?;
        let columns = columns.iter().map(|column| Values::of(column.kind)).collect();
        Ok(Self { file, columns, column: 0, rows: 0, bytes: 0 })
    }

    /// Takes the next value. Rows come one after the other, each with a value for each column, in their order.
    ///
    /// # Errors
    /// It is of another kind than its column, or the writer of Parquet fails. The table is of no use after that.
    pub fn push(&mut self, value: Value<'_>) -> io::Result<()> {
        let Some(column) = self.columns.get_mut(self.column) else {
            return Err(io::Error::other("the table has no columns"));
        };
        column.push(value)?;
        if let Value::Bytes(bytes) = value {
            self.bytes += bytes.len();
        }
        self.column += 1;
        if self.column < self.columns.len() {
            return Ok(());
        }
        self.column = 0;
        self.rows += 1;
        let is_full = self.rows >= ROWS || self.rows * self.columns.len() >= CELLS || self.bytes >= BYTES;
        if is_full { self.group().map_err(failed) } else { Ok(()) }
    }

    /// Appends the bytes of the file that are ready.
    ///
    /// # Errors
    /// The writer of Parquet fails.
    pub fn drain(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        self.file.flush()?;
        out.append(self.file.inner_mut());
        Ok(())
    }

    /// Appends what still waits, and the footer.
    ///
    /// # Errors
    /// The last row is not whole, or the writer of Parquet fails.
    pub fn end(mut self, out: &mut Vec<u8>) -> io::Result<()> {
        if self.column > 0 {
            return Err(io::Error::other("the last row has fewer values than columns"));
        }
        if self.rows > 0 {
            self.group().map_err(failed)?;
        }
        out.append(&mut self.file.into_inner().map_err(failed)?);
        Ok(())
    }

    /// Makes a group of the rows that wait.
    fn group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for column in &mut self.columns {
            column.write(&mut group)?;
        }
        group.close()?;
        (self.rows, self.bytes) = (0, 0);
        Ok(())
    }
}

fn failed(error: ParquetError) -> io::Error {
    io::Error::other(error)
}

fn schema(columns: &[Column]) -> Result<TypePtr, ParquetError> {
    let fields = columns.iter().map(|column| {
        let (physical, logical) = match column.kind {
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Kind::Json => (Physical::BYTE_ARRAY, Some(LogicalType::Json)),
            Kind::Raw => (Physical::BYTE_ARRAY, None),
            Kind::Whole => (Physical::INT64, None),
            Kind::Single => (Physical::FLOAT, None),
            Kind::Real => (Physical::DOUBLE, None),
            Kind::Time => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        };
        let built = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        Ok(Arc::new(built.build()?))
    });
    let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
    Ok(Arc::new(Type::group_type_builder("table").with_fields(fields).build()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    fn column(name: &str, kind: Kind) -> Column {
        Column { name: name.to_owned(), kind }
    }

    fn file(columns: &[Column], rows: &[Vec<Value<'_>>]) -> SerializedFileReader<Bytes> {
        let mut table = Table::new(columns, &[("units", "{}".to_owned())], "test").unwrap();
        let mut out = Vec::new();
        for row in rows {
            for value in row {
                table.push(*value).unwrap();
            }
            table.drain(&mut out).unwrap();
        }
        table.end(&mut out).unwrap();
        SerializedFileReader::new(Bytes::from(out)).unwrap()
    }

    #[test]
    fn each_kind_of_value_comes_back_and_so_does_its_absence() {
        let columns = [
            column("text", Kind::Text),
            column("json", Kind::Json),
            column("raw", Kind::Raw),
            column("whole", Kind::Whole),
            column("single", Kind::Single),
            column("real", Kind::Real),
            column("time", Kind::Time),
        ];
        let given = vec![
            Value::Bytes("blåkveite".as_bytes()),
            Value::Bytes(b"{}"),
            Value::Bytes(&[0, 255]),
            Value::Whole(i64::MIN),
            Value::Real(f64::from(0.1_f32)),
            Value::Real(f64::NEG_INFINITY),
            Value::Whole(1_795_248_000_000_001),
        ];
        let read = file(&columns, &[given, vec![Value::Absent; columns.len()]]);
        let about = read.metadata().file_metadata();
        assert_eq!(about.created_by(), Some("test"));
        assert!(about.key_value_metadata().unwrap().iter().any(|pair| pair.key == "units"));
        let rows: Vec<_> = read.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows[0].get_string(0).unwrap(), "blåkveite");
        assert_eq!(rows[0].get_string(1).unwrap(), "{}");
        assert_eq!(rows[0].get_bytes(2).unwrap().data(), [0, 255]);
        assert_eq!(rows[0].get_long(3).unwrap(), i64::MIN);
        assert_eq!(rows[0].get_float(4).unwrap().to_bits(), 0.1_f32.to_bits());
        assert_eq!(rows[0].get_double(5).unwrap().to_bits(), f64::NEG_INFINITY.to_bits());
        assert_eq!(rows[0].get_timestamp_micros(6).unwrap(), 1_795_248_000_000_001);
        assert!(rows[1].get_column_iter().all(|(_, value)| matches!(value, parquet::record::Field::Null)));
    }

    #[test]
    fn a_group_ends_by_rows_by_cells_and_by_bytes() {
        let narrow = [column("a", Kind::Whole)];
        let read = file(&narrow, &vec![vec![Value::Whole(1)]; ROWS + 1]);
        assert_eq!(read.num_row_groups(), 2);

        let wide: Vec<Column> = (0..1_024).map(|at| column(&format!("c{at}"), Kind::Real)).collect();
        let mut table = Table::new(&wide, &[], "test").unwrap();
        for _ in 0..CELLS + 1_024 {
            table.push(Value::Absent).unwrap();
        }
        assert_eq!(table.rows, 1, "the rows before are a group");

        let text = vec![b'x'; BYTES / 2];
        let read = file(&[column("a", Kind::Text)], &vec![vec![Value::Bytes(&text)]; 3]);
        assert_eq!(read.num_row_groups(), 2);
    }

    #[test]
    fn a_value_of_another_kind_and_half_a_row_are_refused() {
        let columns = [column("a", Kind::Whole), column("b", Kind::Text)];
        let refused = |values: &[Value<'_>]| {
            let mut table = Table::new(&columns, &[], "test").unwrap();
            let pushed = values.iter().try_for_each(|value| table.push(*value));
            pushed.and_then(|()| table.end(&mut Vec::new())).unwrap_err().to_string()
        };
        assert_eq!(refused(&[Value::Whole(1)]), "the last row has fewer values than columns");
        assert!(refused(&[Value::Real(1.0)]).contains("another kind"));
        assert!(refused(&[Value::Absent, Value::Bytes(&[255])]).contains("UTF-8"));
    }
}
