//! When nothing was heard of a system: what the shore can tell by itself of vessels that declare nothing.
//!
//! A silence is a stretch of the system's own time between two samples without any sample of any of its series. It
//! is found when it is asked for and written nowhere, so what comes late or is imported closes it. Samples of one
//! series after the other split what is left of the range, the densest first; where the range is long, roll-ups
//! tell where to look.

use super::{Reader, Source};
use crate::error::Result;
use crate::history::Order;
use crate::history::rows::Question;
use crate::history::{Extent, GroupKey, MonthKey};
use crate::range::TimeRange;
use imc::Address;
use rusqlite::Connection;
use std::cmp::Reverse;

const SECOND_US: i64 = 1_000_000;
const HOUR_US: i64 = 3_600 * SECOND_US;
const SHORT_US: i64 = 6 * HOUR_US;
const MIDDLE_US: i64 = 8 * 24 * HOUR_US;
/// Most silences of an answer; the longest are kept.
const MOST: usize = 1_000;
/// Cells of roll-ups from which on they are looked at before the samples.
const WORTH_CELLS: i64 = 200;
/// Cells that are looked at together.
const CELLS_AT_ONCE: i64 = 50_000;

/// How closely a range is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Grain {
    /// Shorter silences do not count.
    least_us: i64,
    /// Width of the roll-ups' cells: every silence has one that is empty.
    cell_us: Option<i64>,
}

impl Grain {
    fn of(span_us: i64) -> Self {
        if span_us <= SHORT_US {
            Self { least_us: 10 * SECOND_US, cell_us: None }
        } else if span_us <= MIDDLE_US {
            Self { least_us: 20 * SECOND_US, cell_us: Some(10 * SECOND_US) }
        } else {
            Self { least_us: 1_200 * SECOND_US, cell_us: Some(600 * SECOND_US) }
        }
    }
}

impl Reader {
    /// When nothing was heard of a system in a range, in order of time: the stretches between two samples that are
    /// longer than 10 s, in ranges beyond 6 hours 20 s and beyond 8 days 20 minutes. At most 1,000, the longest.
    /// Before its first sample and after its last a system is not silent; samples without a believable time do not
    /// count.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn silences(&mut self, system: Address, range: TimeRange) -> Result<Vec<TimeRange>> {
        let mut groups: Vec<(GroupKey, Extent)> = Vec::new();
        for series in self.series(Some(system))? {
            if series.dated.count > 0 {
                groups.push((series.group, series.dated));
            }
        }
        groups.sort_by_key(|(group, extent)| (Reverse(extent.count), *group));
        let mut heard = Extent::NONE;
        for (_, extent) in &groups {
            heard.merge(*extent);
        }
        let whole = range.within(TimeRange { from_us: heard.first_us, to_us: heard.last_us });
        if heard.count == 0 || whole.is_empty() {
            return Ok(Vec::new());
        }
        let grain = Grain::of(whole.to_us - whole.from_us);
        let months = self.parts(MonthKey::DATED)?;
        let mut quiet = vec![whole];
        quiet.retain(|one| one.to_us - one.from_us > grain.least_us);
        for (group, _) in groups {
            if quiet.is_empty() {
                break;
            }
            let mut left = Vec::new();
            for stretch in quiet {
                for hole in self.holes(group, stretch, grain)? {
                    self.split(group, hole, (&months, grain.least_us), &mut left)?;
                }
            }
            if left.len() > MOST {
                left.sort_by_key(|one| Reverse(one.to_us - one.from_us));
                left.truncate(MOST);
                left.sort_by_key(|one| one.from_us);
            }
            quiet = left;
        }
        Ok(quiet)
    }

    /// The parts of a stretch that the samples must be asked about: by the roll-ups, the rest is not silent.
    fn holes(&mut self, group: GroupKey, stretch: TimeRange, grain: Grain) -> Result<Vec<TimeRange>> {
        let all = vec![stretch];
        let Some(cell_us) = grain.cell_us else { return Ok(all) };
        if (stretch.to_us - stretch.from_us) / cell_us < WORTH_CELLS {
            return Ok(all);
        }
        let Some(table) = self.schema.table(group.id) else { return Ok(all) };
        let Some(name) = table.numbers.first().map(|at| table.columns[*at].name) else { return Ok(all) };
        let message = table.desc.abbrev.to_owned();
        let source = Source { system: Address(group.src), entity: group.src_ent, message };
        let mut holes: Vec<TimeRange> = Vec::new();
        let first = stretch.from_us.div_euclid(cell_us);
        let end = stretch.to_us.div_euclid(cell_us) + 1;
        for from in (first..end).step_by(CELLS_AT_ONCE as usize) {
            let to = end.min(from + CELLS_AT_ONCE);
            let part = TimeRange { from_us: from * cell_us, to_us: to * cell_us };
            let (_, cells) = self.cells(&source, name, part, (to - from) as usize)?;
            for cell in (from..to).filter(|cell| !matches!(cells.get((cell - from) as usize), Some(Some(_))))
            {
                // With the cells beside it, in which its ends lie.
                let hole = TimeRange { from_us: (cell - 1) * cell_us, to_us: (cell + 2) * cell_us };
                match holes.last_mut() {
                    // The next of the same run of empty cells.
                    Some(last) if last.to_us == hole.to_us - cell_us => last.to_us = hole.to_us,
                    _ => holes.push(hole),
                }
            }
        }
        Ok(holes.into_iter().map(|hole| hole.within(stretch)).filter(|hole| !hole.is_empty()).collect())
    }

    /// Adds what the samples of a group leave of a hole.
    fn split(
        &self,
        group: GroupKey,
        hole: TimeRange,
        (months, least_us): (&[(MonthKey, TimeRange)], i64),
        left: &mut Vec<TimeRange>,
    ) -> Result<()> {
        let mut last_us = hole.from_us;
        let mut hear = |time_us: i64| {
            if time_us - last_us > least_us {
                left.push(TimeRange { from_us: last_us, to_us: time_us });
            }
            last_us = time_us;
        };
        for (key, part) in months {
            let part = part.within(hole);
            if part.is_empty() {
                continue;
            }
            let connection = self.month(*key)?;
            let mut read = || -> rusqlite::Result<()> {
                let _moment = self.moment(*key)?;
                // What could not be read as its message lies raw: little, and between the others.
                let mut raw = raw_times(connection, group, part)?.into_iter().peekable();
                let question = match self.schema.table(group.id) {
                    Some(table) => Question::new(connection, table, group, &[], Order::Oldest)?,
                    None => None,
                };
                if let Some(mut question) = question {
                    let mut rows = question.rows(part)?;
                    while let Some(row) = rows.next()? {
                        let time_us = row.time_us()?;
                        while let Some(before_us) = raw.next_if(|raw_us| *raw_us <= time_us) {
                            hear(before_us);
                        }
                        hear(time_us);
                    }
                }
                raw.for_each(&mut hear);
                Ok(())
            };
            self.named(*key, read())?;
        }
        hear(hole.to_us);
        Ok(())
    }
}

/// The times of a group's messages that could not be read, in their order.
fn raw_times(connection: &Connection, group: GroupKey, part: TimeRange) -> rusqlite::Result<Vec<i64>> {
    let mut statement = connection.prepare_cached(
        "SELECT time_us FROM _raw WHERE src=?1 AND src_ent=?2 AND id=?3 AND time_us>=?4 AND time_us<?5 ORDER BY time_us",
    )?;
    let span = (group.src, group.src_ent, group.id, part.from_us, part.to_us);
    statement.query_map(span, |row| row.get(0))?.collect()
}
