//! The roll-ups of packed months: rows of `_rollup` and `_direction` as chunks, of several series each. One that is rolled up again
//! stands in the tables, and counts instead of that in a chunk.

use super::codec::{self, Body, Column, Damaged, ROWS};
use super::{DamagedChunk, Place, is_packed};
use crate::history::rollup::{self, Cell, Direction, LEVELS_S};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::BTreeMap;
use std::ops::Range;

pub(crate) const TABLE: &str = "
CREATE TABLE IF NOT EXISTS _rolled (
  rolled INTEGER PRIMARY KEY, series INTEGER NOT NULL, level_s INTEGER NOT NULL, cell INTEGER NOT NULL,
  last_series INTEGER NOT NULL, last_level_s INTEGER NOT NULL, last_cell INTEGER NOT NULL, body BLOB NOT NULL);
CREATE UNIQUE INDEX IF NOT EXISTS _rolled_key ON _rolled (
  series, level_s, cell, last_series, last_level_s, last_cell);
";
/// Series, seconds of the level, cell; then first time, count, least, greatest, sum, first, last, cosine and sine.
const COLUMNS: usize = 12;
/// Cells that are read at once where all are.
const AT_ONCE: i64 = 1 << 15;

type Key = (i64, i64, i64);

/// The chunk that was unpacked last: a question for several levels mostly needs it again. Of one month, and one moment.
#[derive(Default)]
pub(crate) struct Seen(Option<(i64, Open)>);

impl Seen {
    fn read(&mut self, connection: &Connection, rolled: i64) -> rusqlite::Result<&Open> {
        let one = if let Some(one) = self.0.take().filter(|(seen, _)| *seen == rolled) {
            one
        } else {
            let mut find = connection.prepare_cached("SELECT body FROM _rolled WHERE rolled=?1")?;
            let body = find.query_row([rolled], |row| {
                Ok(open(row.get_ref(0)?.as_blob()?).map_err(|why| damaged(rolled, why)))
            })?;
            (rolled, body?)
        };
        Ok(&self.0.insert(one).1)
    }
}

/// Adds the cells of a level that are in chunks.
pub(crate) fn add(
    connection: &Connection,
    series: i64,
    level_s: i64,
    cells: Range<i64>,
    seen: &mut Seen,
    found: &mut BTreeMap<i64, Cell>,
) -> rusqlite::Result<()> {
    if !is_packed(connection)? || cells.is_empty() {
        return Ok(());
    }
    let (from, to) = ((series, level_s, cells.start), (series, level_s, cells.end));
    for rolled in chunks(connection, from, to)? {
        let columns = seen.read(connection, rolled)?;
        for row in 0..columns.rows {
            if (from..to).contains(&columns.key(row)) {
                found.insert(columns.key(row).2, columns.cell(row));
            }
        }
    }
    Ok(())
}

/// The chunks that may have what is between two keys.
fn chunks(connection: &Connection, from: Key, to: Key) -> rusqlite::Result<Vec<i64>> {
    // They do not overlap: one begins before, the others within.
    let mut before = connection.prepare_cached(
        "SELECT rolled,last_series,last_level_s,last_cell FROM _rolled WHERE (series,level_s,cell)<=(?1,?2,?3) \
         ORDER BY series DESC,level_s DESC,cell DESC LIMIT 1",
    )?;
    let first = before
        .query_row(from, |row| Ok((row.get(0)?, (row.get(1)?, row.get(2)?, row.get(3)?))))
        .optional()?
        .filter(|(_, last): &(i64, Key)| *last >= from);
    let mut found: Vec<i64> = first.into_iter().map(|(rolled, _)| rolled).collect();
    let mut within = connection.prepare_cached(
        "SELECT rolled FROM _rolled WHERE (series,level_s,cell)>(?1,?2,?3) AND (series,level_s,cell)<(?4,?5,?6) \
         ORDER BY series,level_s,cell",
    )?;
    for rolled in within.query_map((from.0, from.1, from.2, to.0, to.1, to.2), |row| row.get(0))? {
        found.push(rolled?);
    }
    Ok(found)
}

/// Reads all chunks.
pub(crate) fn check(connection: &Connection) -> rusqlite::Result<()> {
    let mut statement = connection.prepare("SELECT rolled,body FROM _rolled")?;
    let mut rows = statement.query(())?;
    while let Some(row) = rows.next()? {
        let rolled = row.get(0)?;
        open(&row.get::<_, Vec<u8>>(1)?).map_err(|why| damaged(rolled, why))?;
    }
    Ok(())
}

fn damaged(rolled: i64, why: Damaged) -> rusqlite::Error {
    DamagedChunk { place: Place::Rolled(rolled), text: format!("of roll-ups: {why}") }.into()
}

/// Removes a damaged chunk, and has what its series hold rolled up again from their samples.
pub(crate) fn remove(connection: &Connection, rolled: i64) -> rusqlite::Result<()> {
    connection.execute(
        "INSERT OR IGNORE INTO _stale WITH RECURSIVE
         own AS (SELECT DISTINCT id,src,src_ent FROM _field JOIN _rolled ON _field.series>=_rolled.series \
           AND _field.series<=last_series WHERE rolled=?1),
         span (id,src,src_ent,window,last) AS (
           SELECT id,src,src_ent,first_us/?2,last_us/?2 FROM _group JOIN own USING (id,src,src_ent)
           UNION ALL SELECT id,src,src_ent,window+1,last FROM span WHERE window<last)
         SELECT id,src,src_ent,window FROM span",
        (rolled, rollup::WINDOW_US),
    )?;
    connection.execute("DELETE FROM _rolled WHERE rolled=?1", [rolled]).map(drop)
}

/// A chunk's columns.
struct Open {
    rows: usize,
    integers: [Vec<i64>; 5],
    reals: [Column; COLUMNS - 5],
}

fn open(body: &[u8]) -> Result<Open, Damaged> {
    let body = Body::open(body, "")?;
    let integers = |at: usize| {
        body.column(at).and_then(|column| column.integers().map(<[i64]>::to_vec).ok_or(Damaged::KEYS))
    };
    Ok(Open {
        rows: body.rows(),
        integers: [integers(0)?, integers(1)?, integers(2)?, integers(3)?, integers(4)?],
        reals: [
            body.column(5)?,
            body.column(6)?,
            body.column(7)?,
            body.column(8)?,
            body.column(9)?,
            body.column(10)?,
            body.column(11)?,
        ],
    })
}

impl Open {
    fn key(&self, row: usize) -> Key {
        (self.integers[0][row], self.integers[1][row], self.integers[2][row])
    }

    fn cell(&self, row: usize) -> Cell {
        let real = |at: usize| match self.reals[at].value(row) {
            ValueRef::Real(value) => Some(value),
            _ => None,
        };
        let number = |at: usize| real(at).unwrap_or(f64::NAN);
        Cell {
            first_us: self.integers[3][row],
            count: self.integers[4][row].cast_unsigned(),
            min: number(0),
            max: number(1),
            sum: number(2),
            first: number(3),
            last: number(4),
            direction: real(5).zip(real(6)).map(|(cos, sin)| Direction { cos, sin }),
        }
    }
}

/// Calls `each` with the cells of all series, some of one level at a time, until it returns false.
pub(crate) fn each(
    connection: &Connection,
    each: &mut dyn FnMut(i64, i64, BTreeMap<i64, Cell>) -> rusqlite::Result<bool>,
) -> rusqlite::Result<()> {
    let mut statement = connection.prepare("SELECT series FROM _field ORDER BY 1")?;
    let all: Vec<i64> = statement.query_map((), |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    let mut extent = connection.prepare(
        "SELECT min(first_us),max(last_us) FROM _group JOIN _field USING (id,src,src_ent) WHERE series=?1",
    )?;
    let mut seen = Seen::default();
    for series in all {
        let (first_us, last_us): (Option<i64>, Option<i64>) =
            extent.query_row([series], |row| Ok((row.get(0)?, row.get(1)?)))?;
        let Some((first_us, last_us)) = first_us.zip(last_us) else { continue };
        for level_s in LEVELS_S {
            let at = |time_us: i64| time_us.div_euclid(level_s * 1_000_000);
            let end = at(last_us) + 1;
            for first in (at(first_us)..end).step_by(AT_ONCE as usize) {
                let cells = first..end.min(first + AT_ONCE);
                let cells = rollup::stored(connection, series, level_s, cells, true, &mut seen)?;
                if !each(series, level_s, cells)? {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

/// Cells on their way into chunks.
pub(crate) struct Growing {
    columns: Vec<Column>,
    keys: Vec<Key>,
}

impl Growing {
    pub(crate) fn new() -> Self {
        Self { columns: vec![Column::default(); COLUMNS], keys: Vec::new() }
    }

    pub(crate) fn add(&mut self, target: &Connection, key: Key, cell: &Cell) -> rusqlite::Result<()> {
        let Cell { first_us, count, min, max, sum, first, last, direction } = *cell;
        let integers = [key.0, key.1, key.2, first_us, count.cast_signed()].map(ValueRef::Integer);
        let reals = [min, max, sum, first, last].map(ValueRef::Real);
        let angles = [direction.map(|one| one.cos), direction.map(|one| one.sin)]
            .map(|value| value.map_or(ValueRef::Null, ValueRef::Real));
        let values = integers.into_iter().chain(reals).chain(angles);
        self.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        self.keys.push(key);
        if self.keys.len() == ROWS { self.write(target) } else { Ok(()) }
    }

    /// Writes what waits.
    pub(crate) fn write(&mut self, target: &Connection) -> rusqlite::Result<()> {
        let (Some(first), Some(last)) = (self.keys.first(), self.keys.last()) else { return Ok(()) };
        let body = codec::encode(&self.columns, "")
            .map_err(|error| rusqlite::Error::ToSqlConversionFailure(Box::new(error)))?;
        target
            .prepare_cached("INSERT INTO _rolled VALUES (NULL,?1,?2,?3,?4,?5,?6,?7)")?
            .execute((first.0, first.1, first.2, last.0, last.1, last.2, body))?;
        *self = Self::new();
        Ok(())
    }
}
