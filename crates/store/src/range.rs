//! Stretches of time that are asked for.

use units::UtcTime;

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

    /// Between two times; without a first or last one when they are `None`.
    pub fn new(from: Option<UtcTime>, to: Option<UtcTime>) -> Self {
        Self { from_us: from.map_or(i64::MIN, UtcTime::micros), to_us: to.map_or(i64::MAX, UtcTime::micros) }
    }

    /// Whether a time is part of it.
    pub fn contains(&self, time_us: i64) -> bool {
        (self.from_us..self.to_us).contains(&time_us)
    }

    /// Whether it has no time at all.
    pub fn is_empty(&self) -> bool {
        self.from_us >= self.to_us
    }

    /// What both have in common.
    #[must_use]
    pub fn within(&self, other: Self) -> Self {
        Self { from_us: self.from_us.max(other.from_us), to_us: self.to_us.min(other.to_us) }
    }
}
