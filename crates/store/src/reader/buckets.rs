//! Least, greatest and mean per stretch of time, whatever range is asked for, from the coarsest roll-ups that
//! answer exactly.
//!
//! Buckets as wide as roll-ups or wider are a multiple of the coarsest level not wider than what was asked for, so
//! every roll-up lies in one bucket, and there are at least half as many as were asked for. The ends of the range, and windows whose roll-ups are stale, are answered
//! from finer levels and the samples themselves. The answer is what the samples would give.

use super::{Reader, Source};
use crate::error::{Result, StoreError};
use crate::history::Order;
use crate::history::chunk::Seen;
use crate::history::rollup::{self, Cell, LEVELS_S, WINDOW_US, merge_into, number, window};
use crate::history::rows::Question;
use crate::history::{Column, Extent, GroupKey, MonthKey};
use crate::range::TimeRange;
use rusqlite::{Connection, OptionalExtension as _};

/// Most buckets of an answer.
const MAX_BUCKETS: usize = 100_000;

/// What the samples of a stretch of time have in common. Values that are not finite count for nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bucket {
    /// Where it begins (µs since 1970-01-01 UTC).
    pub start_us: i64,
    /// Time of its first sample.
    pub first_us: i64,
    /// How many samples it has.
    pub count: u64,
    /// The least value.
    pub min: f64,
    /// The greatest value.
    pub max: f64,
    /// The mean value; of angles that of their directions.
    pub mean: f64,
    /// The first value.
    pub first: f64,
    /// The last value.
    pub last: f64,
}

/// Buckets of one field, in order of time; empty ones are left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Buckets {
    /// How long each is (µs). The first and last can reach beyond the range; what is outside does not count.
    pub width_us: i64,
    /// Those that hold samples.
    pub buckets: Vec<Bucket>,
}

impl Reader {
    /// The field's values in a range as at most `count` buckets and one: as many as pixels, say.
    ///
    /// A range without an end is taken as far as there are samples. Undated samples are left out.
    ///
    /// # Errors
    /// When there is no such message or field, the field holds no numbers, or the history cannot be read.
    pub fn buckets(
        &mut self,
        source: &Source,
        field: &str,
        range: TimeRange,
        count: usize,
    ) -> Result<Buckets> {
        let (grid, cells) = self.cells(source, field, range, count)?;
        let circle = self.table(&source.message)?.column(field).and_then(Column::circle);
        let bucket = |(at, cell): (usize, &Option<Cell>)| {
            cell.map(|cell| Bucket {
                start_us: grid.origin_us + at as i64 * grid.width_us,
                first_us: cell.first_us,
                count: cell.count,
                min: cell.min,
                max: cell.max,
                mean: cell.mean(circle),
                first: cell.first,
                last: cell.last,
            })
        };
        Ok(Buckets {
            width_us: grid.width_us,
            buckets: cells.iter().enumerate().filter_map(bucket).collect(),
        })
    }

    pub(super) fn cells(
        &mut self,
        source: &Source,
        field: &str,
        range: TimeRange,
        count: usize,
    ) -> Result<(Grid, Vec<Option<Cell>>)> {
        self.cells_while(source, field, (range, count), &mut || Ok(()))
    }

    /// The same; before each month `goes_on` is asked, whose error ends it.
    pub(super) fn cells_while(
        &mut self,
        source: &Source,
        field: &str,
        (range, count): (TimeRange, usize),
        goes_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<(Grid, Vec<Option<Cell>>)> {
        let group = self.group(source)?;
        let column = self.table(&source.message)?.column(field).filter(|column| column.is_number());
        let Some((name, circle)) = column.map(|column| (column.name, column.circle())) else {
            let problem = format!("{} has no field `{field}` that holds numbers", source.message);
            return Err(StoreError::Query(problem));
        };
        let range = self.bounded(group, range)?.within(MonthKey::DATED);
        let grid = Grid::new(range, count);
        let mut cells = vec![None; grid.buckets(range)];
        for (key, part) in self.parts(range)? {
            if key == MonthKey::Undated {
                continue;
            }
            goes_on()?;
            let connection = self.month(key)?;
            let table = self.table(&source.message)?;
            let mut read = || -> rusqlite::Result<()> {
                // Roll-ups and what is stale of them must be of the same moment.
                let snapshot = connection.unchecked_transaction()?;
                if let Some(question) = Question::new(connection, table, group, &[name], Order::Oldest)? {
                    let series = series(connection, group, name)?;
                    let (cells, seen) = (&mut cells, Seen::default());
                    let mut month =
                        MonthCells { connection, group, series, circle, question, grid, cells, seen };
                    month.read(part)?;
                }
                snapshot.finish()
            };
            let result = read();
            self.named(key, result)?;
        }
        Ok((grid, cells))
    }

    /// A range with both ends, at most as wide as the group's samples reach where it had none.
    fn bounded(&mut self, group: GroupKey, range: TimeRange) -> Result<TimeRange> {
        if range.from_us != i64::MIN && range.to_us != i64::MAX {
            return Ok(range);
        }
        self.recorded(group, range)
    }

    /// The part of a range in which the group has samples: from the first to the last one of all its recordings.
    pub(super) fn recorded(&mut self, group: GroupKey, range: TimeRange) -> Result<TimeRange> {
        let mut extent = Extent::NONE;
        for key in self.keys()?.into_iter().filter(|key| *key != MonthKey::Undated) {
            let read = |connection: &Connection| {
                let sql = "SELECT first_us,last_us FROM _group WHERE id=?1 AND src=?2 AND src_ent=?3";
                let mut find = connection.prepare_cached(sql)?;
                find.query_row((group.id, group.src, group.src_ent), |row| {
                    Ok(Extent { first_us: row.get(0)?, last_us: row.get(1)?, count: 1 })
                })
                .optional()
            };
            extent.merge(self.ask_month(key, read)?.unwrap_or(Extent::NONE));
        }
        if extent.count == 0 {
            return Ok(TimeRange { from_us: 0, to_us: 0 });
        }
        Ok(range.within(TimeRange { from_us: extent.first_us, to_us: extent.last_us + 1 }))
    }
}

/// Where buckets begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) origin_us: i64,
    pub(super) width_us: i64,
    /// The coarsest level that fits into a bucket.
    level: Option<usize>,
}

impl Grid {
    fn new(range: TimeRange, count: usize) -> Self {
        let count = count.clamp(1, MAX_BUCKETS) as i64;
        let span_us = range.to_us.saturating_sub(range.from_us).max(1);
        let wanted_us = span_us.div_euclid(count) + i64::from(span_us % count != 0);
        let level = LEVELS_S.iter().rposition(|level_s| level_s * 1_000_000 <= wanted_us);
        // Half as many buckets come much quicker than twice as many samples.
        let level = level.or((2 * wanted_us >= LEVELS_S[0] * 1_000_000).then_some(0));
        match level {
            None => Self { origin_us: range.from_us, width_us: wanted_us, level: None },
            Some(level) => {
                let level_us = LEVELS_S[level] * 1_000_000;
                let width_us = wanted_us.div_euclid(level_us) * level_us
                    + if wanted_us % level_us == 0 { 0 } else { level_us };
                let origin_us = range.from_us.div_euclid(width_us) * width_us;
                Self { origin_us, width_us, level: Some(level) }
            }
        }
    }

    fn buckets(&self, range: TimeRange) -> usize {
        if range.is_empty() { 0 } else { self.at(range.to_us - 1) + 1 }
    }

    fn at(&self, time_us: i64) -> usize {
        ((time_us - self.origin_us) / self.width_us) as usize
    }
}

fn series(connection: &Connection, group: GroupKey, field: &str) -> rusqlite::Result<Option<i64>> {
    connection
        .prepare_cached("SELECT series FROM _field WHERE id=?1 AND src=?2 AND src_ent=?3 AND field=?4")?
        .query_row((group.id, group.src, group.src_ent, field), |row| row.get(0))
        .optional()
}

/// Reading one month.
struct MonthCells<'m> {
    connection: &'m Connection,
    group: GroupKey,
    series: Option<i64>,
    /// Once around, of angles.
    circle: Option<f64>,
    /// For the samples themselves.
    question: Question<'m>,
    grid: Grid,
    cells: &'m mut [Option<Cell>],
    seen: Seen,
}

impl MonthCells<'_> {
    fn read(&mut self, part: TimeRange) -> rusqlite::Result<()> {
        let Some(level) = self.grid.level else { return self.samples(part.from_us, part.to_us) };
        let mut at_us = part.from_us;
        for stale in self.stale(part)? {
            let (from_us, to_us) = (stale * WINDOW_US, (stale + 1) * WINDOW_US);
            let from_us = from_us.max(at_us);
            self.cover(at_us, from_us, Some(level))?;
            at_us = to_us.min(part.to_us).max(at_us);
            self.samples(from_us, at_us)?;
        }
        self.cover(at_us, part.to_us, Some(level))
    }

    /// Windows whose roll-ups cannot be used.
    fn stale(&self, part: TimeRange) -> rusqlite::Result<Vec<i64>> {
        let mut statement = self.connection.prepare_cached(
            "SELECT window FROM _stale WHERE id=?1 AND src=?2 AND src_ent=?3 AND window BETWEEN ?4 AND ?5 \
             ORDER BY window",
        )?;
        let GroupKey { id, src, src_ent } = self.group;
        let span = (id, src, src_ent, window(part.from_us), window(part.to_us - 1));
        statement.query_map(span, |row| row.get(0))?.collect()
    }

    /// Adds what is between two times: the whole cells of a level from it, the rest from finer ones.
    fn cover(&mut self, from_us: i64, to_us: i64, level: Option<usize>) -> rusqlite::Result<()> {
        if from_us >= to_us {
            return Ok(());
        }
        let Some(level) = level else { return self.samples(from_us, to_us) };
        let level_us = LEVELS_S[level] * 1_000_000;
        let first = from_us.div_euclid(level_us) + i64::from(from_us.rem_euclid(level_us) != 0);
        let end = to_us.div_euclid(level_us);
        let finer = level.checked_sub(1);
        if first >= end {
            return self.cover(from_us, to_us, finer);
        }
        self.cover(from_us, first * level_us, finer)?;
        self.rolled(level, first, end)?;
        self.cover(end * level_us, to_us, finer)
    }

    fn rolled(&mut self, level: usize, first: i64, end: i64) -> rusqlite::Result<()> {
        let Some(series) = self.series else { return Ok(()) };
        let level_us = LEVELS_S[level] * 1_000_000;
        if self.circle.is_some() && !self.has_directions()? {
            return self.samples(first * level_us, end * level_us);
        }
        let angles = self.circle.is_some();
        let cells =
            rollup::stored(self.connection, series, LEVELS_S[level], first..end, angles, &mut self.seen)?;
        for (at, cell) in cells {
            let at_us = at * level_us;
            if self.circle.is_some() && cell.direction.is_none() {
                self.samples(at_us, at_us + level_us)?;
            } else {
                merge_into(&mut self.cells[self.grid.at(at_us)], &cell);
            }
        }
        Ok(())
    }

    /// Whether the month keeps directions: version 0.1.0 made months without.
    fn has_directions(&self) -> rusqlite::Result<bool> {
        self.connection
            .prepare_cached("SELECT 1 FROM sqlite_master WHERE type='table' AND name='_direction'")?
            .exists(())
    }

    fn samples(&mut self, from_us: i64, to_us: i64) -> rusqlite::Result<()> {
        if from_us >= to_us {
            return Ok(());
        }
        let mut rows = self.question.rows(TimeRange { from_us, to_us })?;
        while let Some(row) = rows.next()? {
            if let Some(value) = number(row.value(0)?) {
                let time_us = row.time_us()?;
                merge_into(&mut self.cells[self.grid.at(time_us)], &Cell::of(time_us, value, self.circle));
            }
        }
        Ok(())
    }
}
