//! The rows of messages' tables: the one place that reads them.
//!
//! A [`Question`] is for the rows of one group in one month: which columns, from which end. Its [`Rows`] come in the order of
//! the key, by time and, within a microsecond, by the payload's fingerprint, whether they are in a table or in [chunks](chunk).

use super::chunk::{self, Chunks, Open};
use super::columns::{SENT, columns_of};
use super::group::GroupKey;
use super::order::Order;
use super::schema::Table;
use crate::range::TimeRange;
use rusqlite::fallible_streaming_iterator::FallibleStreamingIterator;
use rusqlite::types::{FromSql, ValueRef};
use rusqlite::{CachedStatement, Connection, OptionalExtension as _};

/// A question for the rows of a group in a month. Beside a writer it is asked within a transaction.
pub(crate) struct Question<'c> {
    connection: &'c Connection,
    group: GroupKey,
    order: Order,
    /// For ordinary rows; a packed month has tables only of messages that came late.
    ordinary: Option<CachedStatement<'c>>,
    chunks: Option<Chunks<'c>>,
    table: &'static str,
    columns: usize,
}

impl<'c> Question<'c> {
    /// A question for these columns of a message's table, which may be [`SENT`]; those that the month's table, of an older
    /// catalogue, lacks are NULL. `None` when the month has nothing of the group.
    pub(crate) fn new(
        connection: &'c Connection,
        table: &Table,
        group: GroupKey,
        columns: &[&str],
        order: Order,
    ) -> rusqlite::Result<Option<Self>> {
        if !has_group(connection, group)? {
            return Ok(None);
        }
        let chunks = if chunk::is_packed(connection)? {
            Chunks::new(connection, group, columns, order)?
        } else {
            None
        };
        let name = table.desc.abbrev;
        let ordinary = match sql(connection, name, group, columns, order)? {
            Some(sql) => Some(connection.prepare_cached(&sql)?),
            None => None,
        };
        let columns = columns.len();
        // What could not be read as its message lies raw, and has no table.
        let has_rows = ordinary.is_some() || chunks.is_some();
        Ok(has_rows.then_some(Self { connection, group, order, ordinary, chunks, table: name, columns }))
    }

    /// The rows in a part of the month.
    pub(crate) fn rows(&mut self, part: TimeRange) -> rusqlite::Result<Rows<'_, 'c>> {
        let span = (self.group.src, self.group.src_ent, part.from_us, part.to_us);
        let ordinary = self.ordinary.as_mut().map(|statement| statement.query(span)).transpose()?;
        if let Some(chunks) = &mut self.chunks {
            chunks.begin(part)?;
        }
        let (order, hash_at) = (self.order, self.columns + 1);
        Ok(Rows { ordinary, chunks: self.chunks.as_mut(), order, hash_at, given: Given::Neither })
    }

    /// Bytes of what it keeps unpacked between two parts.
    pub(crate) fn held_bytes(&self) -> usize {
        self.chunks.as_ref().map_or(0, Chunks::open_bytes)
    }

    /// Gives that up; it is unpacked again when needed.
    pub(crate) fn release(&mut self) {
        if let Some(chunks) = &mut self.chunks {
            chunks.release();
        }
    }

    /// How many rows there are in a part of the month.
    pub(crate) fn count(&mut self, part: TimeRange) -> rusqlite::Result<u64> {
        let mut count = self.chunks.as_mut().map_or(Ok(0), |chunks| chunks.count(part))?;
        if self.ordinary.is_some() {
            let sql = format!(
                "SELECT count(*) FROM \"{}\" WHERE src=?1 AND src_ent=?2 AND time_us>=?3 AND time_us<?4",
                self.table
            );
            let span = (self.group.src, self.group.src_ent, part.from_us, part.to_us);
            let mut find = self.connection.prepare_cached(&sql)?;
            count += find.query_row(span, |row| row.get::<_, i64>(0))?.cast_unsigned();
        }
        Ok(count)
    }
}

/// The question for ordinary rows: their time, the columns, and the fingerprint. `None` when there is no such table.
fn sql(
    connection: &Connection,
    table: &str,
    group: GroupKey,
    columns: &[&str],
    order: Order,
) -> rusqlite::Result<Option<String>> {
    let present = columns_of(connection, table)?;
    if present.is_empty() {
        return Ok(None);
    }
    let mut sql = "SELECT time_us".to_owned();
    for name in columns {
        sql.push(',');
        if *name == SENT {
            sql.push_str(&sent(connection, group)?);
        } else if present.iter().any(|one| one.eq_ignore_ascii_case(name)) {
            sql.extend(["\"", name, "\""]);
        } else {
            sql.push_str("NULL");
        }
    }
    let down = if order == Order::Newest { " DESC" } else { "" };
    Ok(Some(format!(
        "{sql},hash FROM \"{table}\" AS message WHERE src=?1 AND src_ent=?2 AND time_us>=?3 AND time_us<?4 \
         ORDER BY time_us{down},hash{down}"
    )))
}

/// Which of the two was given last, so that it goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Given {
    Neither,
    Ordinary,
    Chunk,
}

/// Rows on their way: ordinary ones and those of chunks.
pub(crate) struct Rows<'q, 'c> {
    ordinary: Option<rusqlite::Rows<'q>>,
    chunks: Option<&'q mut Chunks<'c>>,
    order: Order,
    hash_at: usize,
    given: Given,
}

impl Rows<'_, '_> {
    /// The next row.
    pub(crate) fn next(&mut self) -> rusqlite::Result<Option<Row<'_>>> {
        let Some(chunks) = &mut self.chunks else {
            let Some(rows) = &mut self.ordinary else { return Ok(None) };
            return Ok(rows.next()?.map(Row::Ordinary));
        };
        if let Some(rows) = self.ordinary.as_mut().filter(|_| self.given != Given::Chunk) {
            rows.advance()?;
        }
        if self.given == Given::Chunk {
            chunks.advance()?;
        }
        let ordinary = self.ordinary.as_ref().and_then(FallibleStreamingIterator::get);
        let chunk = chunks.row();
        let is_chunk = match (ordinary, chunk) {
            (None, chunk) => chunk.is_some(),
            (Some(_), None) => false,
            (Some(row), Some((key, ..))) => {
                let own = (row.get(0)?, row.get(self.hash_at)?);
                if self.order == Order::Oldest { key < own } else { key > own }
            }
        };
        self.given = if is_chunk { Given::Chunk } else { Given::Ordinary };
        Ok(match chunk {
            Some((_, open, row)) if is_chunk => Some(Row::Chunk(open, row)),
            _ => ordinary.map(Row::Ordinary),
        })
    }
}

/// A row: its time, and the columns that were asked for.
#[derive(Clone, Copy)]
pub(crate) enum Row<'r> {
    /// Of a table.
    Ordinary(&'r rusqlite::Row<'r>),
    /// Of a chunk, and which of it.
    Chunk(&'r Open, usize),
}

impl<'r> Row<'r> {
    /// When it was said (µs since 1970-01-01 UTC).
    pub(crate) fn time_us(self) -> rusqlite::Result<i64> {
        match self {
            Self::Ordinary(row) => row.get(0),
            Self::Chunk(open, row) => Ok(open.time_us(row)),
        }
    }

    /// The value at a place among the columns that were asked for.
    pub(crate) fn value(self, at: usize) -> rusqlite::Result<ValueRef<'r>> {
        match self {
            Self::Ordinary(row) => row.get_ref(at + 1),
            Self::Chunk(open, row) => Ok(open.value(row, at)),
        }
    }

    /// The same as a type of Rust.
    pub(crate) fn get<T: FromSql>(self, at: usize) -> rusqlite::Result<T> {
        let value = self.value(at)?;
        T::column_result(value).map_err(|error| {
            rusqlite::Error::FromSqlConversionFailure(at, value.data_type(), Box::new(error))
        })
    }
}

/// Whether a month has samples of a group.
fn has_group(connection: &Connection, group: GroupKey) -> rusqlite::Result<bool> {
    let mut find = connection.prepare_cached("SELECT 1 FROM _group WHERE id=?1 AND src=?2 AND src_ent=?3")?;
    find.query_row((group.id, group.src, group.src_ent), |_| Ok(())).optional().map(|found| found.is_some())
}

/// [`SENT`] as SQL, for a SELECT from a table called `message`.
fn sent(connection: &Connection, group: GroupKey) -> rusqlite::Result<String> {
    if columns_of(connection, "_short")?.is_empty() {
        return Ok("0".to_owned());
    }
    let mut find =
        connection.prepare_cached("SELECT 1 FROM _short WHERE id=?1 AND src=?2 AND src_ent=?3 LIMIT 1")?;
    let some = find.query_row((group.id, group.src, group.src_ent), |_| Ok(())).optional()?.is_some();
    Ok(if some {
        format!(
            "(SELECT fields FROM _short AS short WHERE short.id={} AND short.src=message.src AND \
             short.src_ent=message.src_ent AND short.time_us=message.time_us AND short.hash=message.hash)",
            group.id
        )
    } else {
        "NULL".to_owned()
    })
}
