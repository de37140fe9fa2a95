//! The values of a column that wait to become a part of a group.

use crate::{Kind, Value};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::writer::SerializedRowGroupWriter;
use std::io;

/// Those that are known, and of each row whether it has one.
#[derive(Debug)]
pub(crate) struct Known<T> {
    values: Vec<T>,
    /// Definition levels: 1 where a row has a value, else 0.
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

/// The values of a column, by what Parquet stores.
#[derive(Debug)]
pub(crate) enum Values {
    Text(Known<ByteArray>),
    Raw(Known<ByteArray>),
    Whole(Known<i64>),
    Single(Known<f32>),
    Real(Known<f64>),
}

impl Values {
    pub(crate) fn of(kind: Kind) -> Self {
        match kind {
            Kind::Text | Kind::Json => Self::Text(Known::new()),
            Kind::Raw => Self::Raw(Known::new()),
            Kind::Whole | Kind::Time => Self::Whole(Known::new()),
            Kind::Single => Self::Single(Known::new()),
            Kind::Real => Self::Real(Known::new()),
        }
    }

    /// Adds the value of a row.
    pub(crate) fn push(&mut self, value: Value<'_>) -> io::Result<()> {
        match (self, value) {
            (Self::Text(known) | Self::Raw(known), Value::Absent) => known.push(None),
            (Self::Whole(known), Value::Absent) => known.push(None),
            (Self::Single(known), Value::Absent) => known.push(None),
            (Self::Real(known), Value::Absent) => known.push(None),
            (Self::Text(known), Value::Bytes(text)) => {
                let text = str::from_utf8(text).map_err(|_| io::Error::other("a text is not UTF-8"))?;
                known.push(Some(ByteArray::from(text)));
            }
            (Self::Raw(known), Value::Bytes(bytes)) => known.push(Some(ByteArray::from(bytes.to_vec()))),
            (Self::Whole(known), Value::Whole(value)) => known.push(Some(value)),
            (Self::Single(known), Value::Real(value)) => known.push(Some(value as f32)),
            (Self::Real(known), Value::Real(value)) => known.push(Some(value)),
            (_, value) => {
                return Err(io::Error::other(format!("{value:?} is of another kind than its column")));
            }
        }
        Ok(())
    }

    pub(crate) fn write(
        &mut self,
        group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    ) -> Result<(), ParquetError> {
        match self {
            Self::Text(known) | Self::Raw(known) => known.write::<ByteArrayType>(group),
            Self::Whole(known) => known.write::<Int64Type>(group),
            Self::Single(known) => known.write::<FloatType>(group),
            Self::Real(known) => known.write::<DoubleType>(group),
        }
    }
}
