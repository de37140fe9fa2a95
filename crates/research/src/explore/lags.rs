//! How far the nearest other detection of each is: the same as [`crate::Lags`] tells, of all at once.

use super::sighting::{Sighting, Sightings};
use crate::lag::{HORIZON_S, Lag};

/// µs to the nearest other detection of the tag by the receiver, of each row in order; `i64::MAX` where there is none.
pub(super) struct AllLags(Vec<i64>);

impl AllLags {
    /// Of the rows that `counts` says yes to; the others are nobody's neighbours.
    pub(super) fn new(chunks: &[&Sightings], series: usize, counts: impl Fn(&Sighting) -> bool) -> Self {
        let rows = chunks.iter().map(|chunk| chunk.rows.len()).sum();
        let mut lags = vec![i64::MAX; rows];
        // Of each tag by each receiver the row before and its time.
        let mut last: Vec<Option<(usize, i64)>> = vec![None; series];
        for (at, row) in chunks.iter().flat_map(|chunk| &chunk.rows).enumerate() {
            if !counts(row) {
                continue;
            }
            let Some(before) = last.get_mut(row.series as usize) else { continue };
            if let Some((other, time_us)) = *before {
                let lag_us = row.time_us.saturating_sub(time_us).saturating_abs();
                lags[at] = lag_us;
                lags[other] = lags[other].min(lag_us);
            }
            *before = Some((at, row.time_us));
        }
        Self(lags)
    }

    /// Of the row at this place.
    pub(super) fn lag(&self, at: usize) -> Lag {
        match self.0[at] {
            us if us <= HORIZON_S * 1_000_000 => Lag::Seconds(us as f64 / 1e6),
            _ => Lag::Nothing,
        }
    }
}
