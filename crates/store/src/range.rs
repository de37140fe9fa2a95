//! Ranges of time for queries.

use units::UtcTime;

/// The time of what has none: its sender's stamp is no number, infinite or beyond what 64 bits of microseconds hold. No stamp
/// that is a time gives it.
pub const NO_TIME_US: i64 = i64::MIN;

/// From a time on, up to another that is not part of it (µs since 1970-01-01 UTC, by the senders' clocks).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeRange {
    /// First microsecond.
    pub from_us: i64,
    /// First microsecond that is not part of it.
    pub to_us: i64,
}

impl TimeRange {
    /// All of time, with the samples that have no believable one.
    pub const ALL: Self = Self { from_us: i64::MIN, to_us: i64::MAX };

    /// Between two times; without a first or last one when they are `None`. What has no time is in none but [`Self::ALL`].
    pub fn new(from: Option<UtcTime>, to: Option<UtcTime>) -> Self {
        if from.is_none() && to.is_none() {
            return Self::ALL;
        }
        Self {
            from_us: from.map_or(NO_TIME_US + 1, UtcTime::micros),
            to_us: to.map_or(i64::MAX, UtcTime::micros),
        }
    }

    /// Whether a time is part of it.
    pub fn contains(&self, time_us: i64) -> bool {
        (self.from_us..self.to_us).contains(&time_us)
    }

    /// Whether it has no time at all.
    pub fn is_empty(&self) -> bool {
        self.from_us >= self.to_us
    }

    /// The intersection.
    #[must_use]
    pub fn within(&self, other: Self) -> Self {
        Self { from_us: self.from_us.max(other.from_us), to_us: self.to_us.min(other.to_us) }
    }
}
