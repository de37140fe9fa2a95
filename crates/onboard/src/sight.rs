//! Whether the position is known, for the controllers that steer by it: lost at once, regained after a while.

use crate::navigation::Estimate;
use std::time::Duration;
use units::MonoTime;

/// Whether the position is known.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sight {
    lost: bool,
    good_since: Option<MonoTime>,
}

impl Sight {
    /// Takes the latest estimate, if there is one. Returns whether the position is known; after a loss it
    /// counts as known again when positions have been measured for `recovery`.
    pub(crate) fn see(&mut self, now: MonoTime, estimate: Option<&Estimate>, recovery: Duration) -> bool {
        let is_good = estimate.is_some_and(|estimate| !estimate.is_reckoned() && !estimate.is_heading_old());
        if estimate.is_none() {
            self.lost = true;
        }
        self.good_since = if is_good { self.good_since.or(Some(now)) } else { None };
        if self.good_since.is_some_and(|since| now.since(since) >= recovery) {
            self.lost = false;
        }
        !self.lost
    }
}
