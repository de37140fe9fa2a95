//! Samples as they are.

use super::page::Pager;
use super::{Page, Paged, Reader, Source};
use crate::error::{Result, StoreError};
use crate::history::Order;
use crate::history::columns::SENT;
use crate::history::rollup::number;
use crate::history::rows::{self, Question};
use crate::history::{ColumnKind, GroupKey, MonthKey};
use crate::range::TimeRange;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Transaction};
use std::ops::ControlFlow;
use units::UtcTime;

/// Numbers of a series, a list for each field.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// The samples' times (µs since 1970-01-01 UTC), rising; several can be equal.
    pub time_us: Vec<i64>,
    /// Per field as many values; NaN where there is none.
    pub values: Vec<Vec<f64>>,
    /// Whether there are more than were asked for.
    pub cut: bool,
}

/// One value of any field.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// None: a field that an older sender left out, or no nested message.
    Nothing,
    /// An integer.
    Integer(i64),
    /// A real; NaN too.
    Real(f64),
    /// Text, or nested messages as JSON.
    Text(String),
    /// Bytes.
    Raw(Vec<u8>),
}

impl Cell {
    fn of(value: ValueRef<'_>) -> Self {
        match value {
            ValueRef::Null => Self::Nothing,
            ValueRef::Integer(value) => Self::Integer(value),
            ValueRef::Real(value) => Self::Real(value),
            ValueRef::Text(text) => Self::Text(String::from_utf8_lossy(text).into_owned()),
            ValueRef::Blob(bytes) => Self::Raw(bytes.to_vec()),
        }
    }

    /// The number, if it is one.
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Integer(value) => Some(value as f64),
            Self::Real(value) => Some(value),
            Self::Nothing | Self::Text(_) | Self::Raw(_) => None,
        }
    }

    /// The text, if it is any.
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// One message of the history.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// When it was said, by the sender's clock.
    pub time: UtcTime,
    /// When it first came ashore, by the shore's clock.
    pub received: UtcTime,
    /// The values of the fields asked for.
    pub cells: Vec<Cell>,
}

impl Row {
    /// Bytes of its texts and raw data.
    pub(super) fn bytes(&self) -> usize {
        let bytes = |cell: &Cell| match cell {
            Cell::Text(text) => text.len(),
            Cell::Raw(bytes) => bytes.len(),
            Cell::Nothing | Cell::Integer(_) | Cell::Real(_) => 0,
        };
        self.cells.iter().map(bytes).sum()
    }
}

impl Reader {
    /// The numbers of some fields in a range, at most `limit` samples.
    ///
    /// # Errors
    /// When there is no such message or field, or the history cannot be read.
    pub fn samples(
        &mut self,
        source: &Source,
        fields: &[&str],
        range: TimeRange,
        limit: usize,
    ) -> Result<Samples> {
        let mut samples = Samples { values: vec![Vec::new(); fields.len()], ..Samples::default() };
        self.scan(source, fields, range, |row| {
            if samples.time_us.len() == limit {
                samples.cut = true;
                return Ok(ControlFlow::Break(()));
            }
            samples.time_us.push(row.time_us()?);
            for (at, values) in samples.values.iter_mut().enumerate() {
                values.push(number(row.value(at + FIELDS_AT)?).unwrap_or(f64::NAN));
            }
            Ok(ControlFlow::Continue(()))
        })?;
        Ok(samples)
    }

    /// A page of a series' messages with values of any type.
    ///
    /// # Errors
    /// When there is no such message or field, or the history cannot be read.
    pub fn rows(
        &mut self,
        source: &Source,
        fields: &[&str],
        range: TimeRange,
        page: Page,
    ) -> Result<Paged<Row>> {
        let mut found = Vec::new();
        let mut pager = Pager::new(page);
        let reals = self.reals(&source.message, fields)?;
        self.scan(source, fields, range, |row| {
            pager.step(row.time_us()?, || {
                let row = read_row(row, &reals)?;
                let bytes = row.bytes();
                found.push(row);
                Ok(bytes)
            })
        })?;
        Ok(pager.end(found))
    }

    /// The last message of a series in a range.
    ///
    /// # Errors
    /// When there is no such message or field, or the history cannot be read.
    pub fn last_row(&mut self, source: &Source, fields: &[&str], range: TimeRange) -> Result<Option<Row>> {
        let group = self.group(source)?;
        self.check_fields(source, fields)?;
        let reals = self.reals(&source.message, fields)?;
        for (key, part) in self.parts(range)?.into_iter().rev() {
            let read = || -> rusqlite::Result<Option<Row>> {
                let _moment = self.moment(key)?;
                let Some(mut question) = self.question(key, group, fields, Order::Newest)? else {
                    return Ok(None);
                };
                question.rows(part)?.next()?.map(|row| read_row(row, &reals)).transpose()
            };
            if let Some(row) = self.named(key, read())? {
                return Ok(Some(row));
            }
        }
        Ok(None)
    }

    /// Walks over a series' messages in order of time. Their columns: see [`Self::question`].
    pub(crate) fn scan(
        &mut self,
        source: &Source,
        fields: &[&str],
        range: TimeRange,
        mut visit: impl FnMut(rows::Row<'_>) -> rusqlite::Result<ControlFlow<()>>,
    ) -> Result<()> {
        let group = self.group(source)?;
        self.check_fields(source, fields)?;
        for (key, part) in self.parts(range)? {
            let mut read = || -> rusqlite::Result<ControlFlow<()>> {
                let _moment = self.moment(key)?;
                let Some(mut question) = self.question(key, group, fields, Order::Oldest)? else {
                    return Ok(ControlFlow::Continue(()));
                };
                let mut rows = question.rows(part)?;
                while let Some(row) = rows.next()? {
                    if visit(row)?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
                Ok(ControlFlow::Continue(()))
            };
            if self.named(key, read())?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Until it is dropped, all that a month is asked is of one moment: a row that comes late for a packed month moves others from
    /// a chunk into a table.
    pub(crate) fn moment(&self, key: MonthKey) -> rusqlite::Result<Option<Transaction<'_>>> {
        self.months.get(&key).map(Connection::unchecked_transaction).transpose()
    }

    /// A question to a month for the arrival, how many fields were sent, and these fields: what [`read_row`] reads.
    pub(super) fn question(
        &self,
        key: MonthKey,
        group: GroupKey,
        fields: &[&str],
        order: Order,
    ) -> rusqlite::Result<Option<Question<'_>>> {
        let (Some(connection), Some(table)) = (self.months.get(&key), self.table_of(group)) else {
            return Ok(None);
        };
        let columns = [&["received_us", SENT], fields].concat();
        Question::new(connection, table, group, &columns, order)
    }

    /// Of each field its place among those of the message, if it is a real, in which NULL is a NaN.
    pub(super) fn reals(&self, message: &str, fields: &[&str]) -> Result<Vec<Option<usize>>> {
        let columns = &self.table(message)?.columns;
        let real = |name: &&str| {
            let at = columns.iter().position(|column| column.name == *name)?;
            let is_own = columns[at].desc.is_some();
            (is_own && matches!(columns[at].kind, ColumnKind::Single | ColumnKind::Double)).then_some(at)
        };
        Ok(fields.iter().map(real).collect())
    }

    fn check_fields(&self, source: &Source, fields: &[&str]) -> Result<()> {
        let table = self.table(&source.message)?;
        match fields.iter().find(|field| table.column(field).is_none()) {
            None => Ok(()),
            Some(field) => {
                let names: Vec<&str> = table.columns.iter().map(|column| column.name).collect();
                Err(StoreError::Query(format!(
                    "{} has no field `{field}`; it has {}",
                    source.message,
                    names.join(", ")
                )))
            }
        }
    }
}

/// Where the fields begin among the columns: after the arrival, and how many fields were sent.
const FIELDS_AT: usize = 2;

/// A row of [`Reader::question`]; `reals` are the fields at these places of the message.
pub(super) fn read_row(row: rows::Row<'_>, reals: &[Option<usize>]) -> rusqlite::Result<Row> {
    let sent = row.get::<Option<u32>>(1)?.map_or(usize::MAX, |fields| fields as usize);
    let cell = |(at, real): (usize, &Option<usize>)| {
        let cell = Cell::of(row.value(at + FIELDS_AT)?);
        let is_nan = cell == Cell::Nothing && real.is_some_and(|at| at < sent);
        Ok(if is_nan { Cell::Real(f64::NAN) } else { cell })
    };
    Ok(Row {
        time: UtcTime::from_micros(row.time_us()?),
        received: UtcTime::from_micros(row.get(0)?),
        cells: reals.iter().enumerate().map(cell).collect::<rusqlite::Result<_>>()?,
    })
}
