//! How far the nearest other detection of each is: the same as [`crate::Lags`] gives, for all at once.

use super::sighting::{Pieces, Sighting};
use crate::lag::{HORIZON_S, Lag};

/// µs to the nearest other detection of the tag by the same receiver, for each row in order; `i64::MAX` where none is.
pub(super) struct AllLags(Vec<i64>);

/// A row of a tag by a receiver: its number among all rows, and its times (µs).
#[derive(Clone, Copy)]
struct Row {
    at: usize,
    time_us: i64,
    reported_us: i64,
}

impl AllLags {
    /// Of the rows for which `counts` is true; the others are not neighbours. The rows of a vessel come newest report
    /// first; a receiver that was on several vessels comes in several such runs.
    pub(super) fn new(pieces: &Pieces<'_>, counts: impl Fn(&Sighting) -> bool) -> Self {
        let mut lags = Self(Vec::new());
        // Of each tag by each receiver the row before, and whether rows came out of order.
        let mut last: Vec<Option<Row>> = vec![None; pieces.names.len()];
        let mut is_mixed = vec![false; pieces.names.len()];
        for (at, (series, row)) in pieces.rows().enumerate() {
            lags.0.push(i64::MAX);
            if !counts(row) {
                continue;
            }
            let row = Row { at, time_us: row.time_us, reported_us: row.reported_us };
            if let Some(before) = last[series].replace(row) {
                lags.are_neighbours(before, row);
                is_mixed[series] |= row.reported_us > before.reported_us;
            }
        }
        if is_mixed.contains(&true) {
            lags.sort(pieces, &is_mixed, counts);
        }
        lags
    }

    /// Again, for tags by receivers whose rows came out of order.
    fn sort(&mut self, pieces: &Pieces<'_>, is_mixed: &[bool], counts: impl Fn(&Sighting) -> bool) {
        let mut mixed: Vec<Vec<Row>> = vec![Vec::new(); pieces.names.len()];
        for (at, (series, row)) in pieces.rows().enumerate() {
            if is_mixed[series] && counts(row) {
                self.0[at] = i64::MAX;
                mixed[series].push(Row { at, time_us: row.time_us, reported_us: row.reported_us });
            }
        }
        for mut rows in mixed {
            rows.sort_by_key(|row| row.reported_us);
            for pair in rows.windows(2) {
                self.are_neighbours(pair[0], pair[1]);
            }
        }
    }

    fn are_neighbours(&mut self, one: Row, other: Row) {
        let lag_us = one.time_us.saturating_sub(other.time_us).saturating_abs();
        for at in [one.at, other.at] {
            self.0[at] = self.0[at].min(lag_us);
        }
    }

    /// Of the row of this number.
    pub(super) fn lag(&self, at: usize) -> Lag {
        match self.0[at] {
            us if us <= HORIZON_S * 1_000_000 => Lag::Seconds(us as f64 / 1e6),
            _ => Lag::Nothing,
        }
    }
}
