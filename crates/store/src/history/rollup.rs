//! Least, greatest, mean, first and last of every number per 10 s, minute and 10 min.
//!
//! A window of 10 minutes is rolled up as a whole from its samples when nothing more comes to it, so its
//! roll-ups are a function of the samples alone: in whatever order they came, late or twice, the same numbers
//! come out to the last bit. A window that gains samples later is marked stale in the same transaction;
//! readers look at the samples themselves there until it is rolled up again. Values that are not finite count
//! for nothing. The mean of angles is that of their directions: of 359° and 1° it is 0°, and not 180°.

use super::chunk;
use super::group::GroupKey;
use super::order::Order;
use super::rows::Question;
use super::schema::Table;
use crate::range::TimeRange;
use rusqlite::Connection;
use rusqlite::types::ValueRef;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

/// Seconds of each level, finest first; each divides the next.
pub(crate) const LEVELS_S: [i64; 3] = [10, 60, 600];
/// Microseconds of a window: the coarsest level.
pub(crate) const WINDOW_US: i64 = LEVELS_S[2] * 1_000_000;

/// The window of a time.
pub(crate) fn window(time_us: i64) -> i64 {
    time_us.div_euclid(WINDOW_US)
}

/// The roll-up of the values in a stretch of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) first_us: i64,
    pub(crate) count: u64,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) sum: f64,
    pub(crate) first: f64,
    pub(crate) last: f64,
    /// Of angles.
    pub(crate) direction: Option<Direction>,
}

/// The sums of the cosines and sines of angles, from which their mean follows (K. V. Mardia and P. E. Jupp, "Directional
/// Statistics", 2000, section 2.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Direction {
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl Cell {
    /// A value; `circle` is once around in the unit of an angle.
    pub(crate) fn of(time_us: i64, value: f64, circle: Option<f64>) -> Self {
        let direction = circle.map(|circle| {
            let (sin, cos) = (value / circle * TAU).sin_cos();
            Direction { cos, sin }
        });
        Self {
            first_us: time_us,
            count: 1,
            min: value,
            max: value,
            sum: value,
            first: value,
            last: value,
            direction,
        }
    }

    /// The mean; of angles it is counted as they are, from 0 or to both sides of it.
    pub(crate) fn mean(&self, circle: Option<f64>) -> f64 {
        let (Some(Direction { cos, sin }), Some(circle)) = (self.direction, circle) else {
            return self.sum / self.count as f64;
        };
        let mean = sin.atan2(cos) / TAU * circle;
        if mean < 0.0 && self.min >= 0.0 { mean + circle } else { mean }
    }

    /// Adds what comes later.
    pub(crate) fn merge(&mut self, later: &Self) {
        self.count += later.count;
        self.min = self.min.min(later.min);
        self.max = self.max.max(later.max);
        self.sum += later.sum;
        self.last = later.last;
        self.direction = self
            .direction
            .zip(later.direction)
            .map(|(own, later)| Direction { cos: own.cos + later.cos, sin: own.sin + later.sin });
    }
}

/// Adds what comes later to what may be nothing yet.
pub(crate) fn merge_into(cell: &mut Option<Cell>, later: &Cell) {
    match cell {
        Some(cell) => cell.merge(later),
        None => *cell = Some(*later),
    }
}

/// The finite number in a column.
pub(crate) fn number(value: ValueRef<'_>) -> Option<f64> {
    match value {
        ValueRef::Integer(value) => Some(value as f64),
        ValueRef::Real(value) => Some(value).filter(|value| value.is_finite()),
        ValueRef::Null | ValueRef::Text(_) | ValueRef::Blob(_) => None,
    }
}

/// Rolls up one window of a group; how many samples it has.
pub(crate) fn roll_up(
    connection: &Connection,
    table: &Table,
    group: GroupKey,
    window: i64,
) -> rusqlite::Result<u64> {
    if table.numbers.is_empty() {
        return Ok(0);
    }
    let fields = table.numbers.len();
    let circles: Vec<Option<f64>> = table.numbers.iter().map(|at| table.columns[*at].circle()).collect();
    // Per field the finished cells of the finest level, and the one being filled.
    let mut finished: Vec<Vec<(i64, Cell)>> = vec![Vec::new(); fields];
    let mut filling: Vec<Option<Cell>> = vec![None; fields];
    let (mut at, mut samples) = (i64::MIN, 0);
    let finest_us = LEVELS_S[0] * 1_000_000;
    let names: Vec<&str> = table.numbers.iter().map(|at| table.columns[*at].name).collect();
    let Some(mut question) = Question::new(connection, table, group, &names, Order::Oldest)? else {
        return Ok(0);
    };
    let span = TimeRange { from_us: window * WINDOW_US, to_us: (window + 1) * WINDOW_US };
    let mut rows = question.rows(span)?;
    while let Some(row) = rows.next()? {
        let time_us = row.time_us()?;
        let cell_at = time_us.div_euclid(finest_us);
        if cell_at != at {
            finish(&mut filling, &mut finished, at);
            at = cell_at;
        }
        samples += 1;
        for (field, cell) in filling.iter_mut().enumerate() {
            if let Some(value) = number(row.value(field)?) {
                merge_into(cell, &Cell::of(time_us, value, circles[field]));
            }
        }
    }
    finish(&mut filling, &mut finished, at);
    drop(rows);
    let mut insert = connection
        .prepare_cached("INSERT OR REPLACE INTO _rollup VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)")?;
    let mut insert_direction =
        connection.prepare_cached("INSERT OR REPLACE INTO _direction VALUES (?1,?2,?3,?4,?5,?6)")?;
    for (field, cells) in finished.into_iter().enumerate() {
        if cells.is_empty() {
            continue;
        }
        let series = series(connection, group, table.columns[table.numbers[field]].name)?;
        let mut cells = cells;
        for (level, level_s) in LEVELS_S.iter().enumerate() {
            for (at, cell) in &cells {
                let Cell { first_us, count, min, max, sum, first, last, direction } = *cell;
                insert.execute((series, level_s, at, first_us, count as i64, min, max, sum, first, last))?;
                if let Some(Direction { cos, sin }) = direction {
                    insert_direction.execute((series, level_s, at, count as i64, cos, sin))?;
                }
            }
            if let Some(next) = LEVELS_S.get(level + 1) {
                cells = coarser(&cells, next / level_s);
            }
        }
    }
    Ok(samples)
}

/// The cells of a level in a range of them, those of `angles` with their directions. A direction that is not of the same samples is not there: a version that knew of none
/// rolled up again.
pub(crate) fn stored(
    connection: &Connection,
    series: i64,
    level_s: i64,
    cells: Range<i64>,
    angles: bool,
    seen: &mut chunk::Seen,
) -> rusqlite::Result<BTreeMap<i64, Cell>> {
    let mut found = BTreeMap::new();
    chunk::add_rolled(connection, series, level_s, cells.clone(), seen, &mut found)?;
    let mut statement = connection.prepare_cached(if angles { ANGLES } else { NUMBERS })?;
    let mut rows = statement.query((series, level_s, cells.start, cells.end))?;
    while let Some(row) = rows.next()? {
        let direction = row.get::<_, Option<f64>>(8)?.zip(row.get(9)?);
        let cell = Cell {
            first_us: row.get(1)?,
            count: row.get::<_, i64>(2)?.cast_unsigned(),
            min: row.get(3)?,
            max: row.get(4)?,
            sum: row.get(5)?,
            first: row.get(6)?,
            last: row.get(7)?,
            direction: direction.map(|(cos, sin)| Direction { cos, sin }),
        };
        found.insert(row.get(0)?, cell);
    }
    Ok(found)
}

/// Directions are of angles alone, and a month of version 0.1.0 keeps none.
const NUMBERS: &str = "SELECT cell,first_us,count,min,max,sum,first,last,NULL,NULL FROM _rollup \
     WHERE series=?1 AND level_s=?2 AND cell>=?3 AND cell<?4 ORDER BY cell";
const ANGLES: &str = "SELECT r.cell,r.first_us,r.count,r.min,r.max,r.sum,r.first,r.last,d.cos,d.sin FROM _rollup r \
     LEFT JOIN _direction d ON d.series=r.series AND d.level_s=r.level_s AND d.cell=r.cell AND d.count=r.count \
     WHERE r.series=?1 AND r.level_s=?2 AND r.cell>=?3 AND r.cell<?4 ORDER BY r.cell";

fn finish(filling: &mut [Option<Cell>], finished: &mut [Vec<(i64, Cell)>], at: i64) {
    for (cell, finished) in filling.iter_mut().zip(finished) {
        finished.extend(cell.take().map(|cell| (at, cell)));
    }
}

fn coarser(cells: &[(i64, Cell)], factor: i64) -> Vec<(i64, Cell)> {
    let mut out: Vec<(i64, Cell)> = Vec::new();
    for (at, cell) in cells {
        let at = at.div_euclid(factor);
        match out.last_mut() {
            Some((last, sum)) if *last == at => sum.merge(cell),
            _ => out.push((at, *cell)),
        }
    }
    out
}

/// The number that stands for a field of a group, made when it is first needed.
fn series(connection: &Connection, group: GroupKey, field: &str) -> rusqlite::Result<i64> {
    let key = (group.id, group.src, group.src_ent, field);
    let mut find = connection
        .prepare_cached("SELECT series FROM _field WHERE id=?1 AND src=?2 AND src_ent=?3 AND field=?4")?;
    match find.query_row(key, |row| row.get(0)) {
        Err(rusqlite::Error::QueryReturnedNoRows) => {
            let mut add = connection
                .prepare_cached("INSERT INTO _field (id,src,src_ent,field) VALUES (?1,?2,?3,?4)")?;
            add.insert(key)
        }
        other => other,
    }
}
