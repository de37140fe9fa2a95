//! Of many detections of an animal by a vessel within an hour, the one that was heard first, with the number of all.
//!
//! Hours are those of the clock, UTC, by when the animal was heard. An hour is closed two hours after its first detection was reported,
//! or when 10,000 are open: what is reported of it later begins a row of its own, which says of how many it is the first.

use crate::study::Heard;
use std::collections::{BTreeMap, VecDeque};

const HOUR_US: i64 = 3_600_000_000;
/// How long after its first report an hour stays open.
const OPEN_US: i64 = 2 * HOUR_US;
/// Hours that are open at most.
const OPEN: usize = 10_000;

/// The name of an animal, the vessel, and the hour since 1970.
type Key = (String, u16, i64);

/// Rows that wait until their hour is over.
#[derive(Debug, Default)]
pub(super) struct Hours {
    /// The number of the row of each hour that is open.
    open: BTreeMap<Key, u64>,
    waiting: VecDeque<Hour>,
    /// The number of the first row that waits.
    first: u64,
}

#[derive(Debug)]
struct Hour {
    key: Key,
    reported_us: i64,
    row: Row,
}

/// An occurrence that waits to be written.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// Its cells before and after what is said of the hour.
    pub(super) before: Vec<u8>,
    pub(super) after: Vec<u8>,
    /// What was measured, as lines.
    pub(super) facts: Vec<u8>,
    /// Whether the length and weight of its animal are among that.
    pub(super) has_animal: bool,
    pub(super) cell_m: Option<u32>,
    /// When it was heard, µs.
    pub(super) heard_us: i64,
    /// Detections of which it is the first.
    pub(super) of: u64,
}

impl Hours {
    /// Counts a detection of an hour that is open, and gives the row that waits; `None` where none is.
    pub(super) fn count(&mut self, heard: &Heard<'_>) -> Option<&mut Row> {
        let number = self.open.get(&key(heard)?)?;
        let at = usize::try_from(number - self.first).ok()?;
        let row = &mut self.waiting.get_mut(at)?.row;
        row.of += 1;
        Some(row)
    }

    /// Opens the hour of a detection, of which `row` is written.
    pub(super) fn open(&mut self, heard: &Heard<'_>, row: Row) {
        let Some(key) = key(heard) else { return };
        self.open.insert(key.clone(), self.first + self.waiting.len() as u64);
        let reported_us = heard.detection.origin.reported.micros();
        self.waiting.push_back(Hour { key, reported_us, row });
    }

    /// The next row whose hour is over, at the time of the report of `now`; at the end, without one, any.
    pub(super) fn next(&mut self, now: Option<&Heard<'_>>) -> Option<Row> {
        let first = self.waiting.front()?;
        let over = |now: &Heard<'_>| {
            now.detection.origin.reported.micros().saturating_sub(first.reported_us) > OPEN_US
        };
        if self.waiting.len() <= OPEN && !now.is_none_or(over) {
            return None;
        }
        let Hour { key, row, .. } = self.waiting.pop_front()?;
        self.open.remove(&key);
        self.first += 1;
        Some(row)
    }
}

fn key(heard: &Heard<'_>) -> Option<Key> {
    let vessel = heard.detection.origin.system.0;
    Some((heard.animal?.name.clone(), vessel, heard.time_us.div_euclid(HOUR_US)))
}
