//! How long receivers listened, by the vessels' reports.

use super::sighting::{Listened, Pieces};
use std::collections::BTreeMap;

/// A report of listening holds this long without another (µs): vessels send one every 30 s, and two may be lost.
const HOLDS_US: i64 = 90_000_000;

/// Gives each stretch in which a receiver listened and its vessel: from, to (µs). A vessel with any report is given at
/// least once, with an empty stretch where it did not listen.
pub(super) fn each_listened(
    pieces: &Pieces<'_>,
    counts: impl Fn(&Listened) -> bool,
    mut give: impl FnMut(u16, i64, i64),
) {
    // The newest come first: of each receiver the one after.
    let mut after: BTreeMap<(u16, u8), i64> = BTreeMap::new();
    for told in pieces.listened().filter(|told| counts(told)) {
        let from_us = told.reported_us;
        let next_us = after.insert((told.vessel, told.entity), from_us).unwrap_or(i64::MAX);
        let to_us = if told.on { next_us.min(from_us.saturating_add(HOLDS_US)) } else { from_us };
        give(told.vessel, from_us, to_us.max(from_us));
    }
}
