//! Which file a sample belongs to.

use super::month::Extent;
use crate::range::TimeRange;
use units::{Civil, UtcTime};

/// Times from here on belong to a month: 2000-01-01.
const FIRST_US: i64 = 946_684_800_000_000;
/// Times from here on do not: 2100-01-01.
const END_US: i64 = 4_102_444_800_000_000;

/// A file of the history.
///
/// Samples without a believable time (before 2000, from 2100 on, or none at all) are in `undated.sqlite`
/// under the time that the sender stated, so that a packet always belongs to the same file whenever it comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MonthKey {
    /// Samples without a believable time.
    Undated,
    /// A calendar month in UTC.
    Month {
        /// The year.
        year: u16,
        /// 1 to 12.
        month: u8,
    },
}

impl MonthKey {
    /// All months.
    pub(crate) const DATED: TimeRange = TimeRange { from_us: FIRST_US, to_us: END_US };

    /// The file of a sample.
    pub fn of(time_us: i64) -> Self {
        if !(FIRST_US..END_US).contains(&time_us) {
            return Self::Undated;
        }
        let Civil { year, month, .. } = UtcTime::from_micros(time_us).civil();
        Self::Month { year: year as u16, month }
    }

    /// The file's name.
    pub fn file_name(self) -> String {
        match self {
            Self::Undated => "undated.sqlite".to_owned(),
            Self::Month { year, month } => format!("{year:04}-{month:02}.sqlite"),
        }
    }

    /// The file with this name.
    pub fn from_file_name(name: &str) -> Option<Self> {
        if name == "undated.sqlite" {
            return Some(Self::Undated);
        }
        let (year, month) = name.strip_suffix(".sqlite")?.split_once('-')?;
        let key = Self::Month { year: year.parse().ok()?, month: month.parse().ok()? };
        (key.file_name() == name && key.range_us().is_some()).then_some(key)
    }

    /// Whether samples of these times may lie in this file.
    pub(crate) fn may_hold(self, extent: Extent) -> bool {
        extent.count > 0
            && match self.range_us() {
                Some((from_us, to_us)) => extent.first_us < to_us && extent.last_us >= from_us,
                None => extent.first_us < FIRST_US || extent.last_us >= END_US,
            }
    }

    /// The files that hold a range, with the part that each holds, in order of time. What is undated lies
    /// before and after all months.
    pub(crate) fn parts(range: TimeRange, present: &[Self]) -> Vec<(Self, TimeRange)> {
        let mut parts = Vec::new();
        let mut add = |key: Self, from_us: i64, to_us: i64| {
            let part = range.within(TimeRange { from_us, to_us });
            if !part.is_empty() {
                parts.push((key, part));
            }
        };
        let undated = present.contains(&Self::Undated);
        if undated {
            add(Self::Undated, i64::MIN, FIRST_US);
        }
        for key in present {
            if let Some((from_us, to_us)) = key.range_us() {
                add(*key, from_us, to_us);
            }
        }
        if undated {
            add(Self::Undated, END_US, i64::MAX);
        }
        parts
    }

    /// First microsecond of the month and of the next; `None` for what is undated.
    pub fn range_us(self) -> Option<(i64, i64)> {
        let Self::Month { year, month } = self else { return None };
        let start = |year: i64, month: u8| {
            let midnight = Civil { year, month, day: 1, hour: 0, minute: 0, second: 0, microsecond: 0 };
            UtcTime::from_civil(midnight).map(UtcTime::micros)
        };
        let year = i64::from(year);
        let next = if month == 12 { start(year + 1, 1) } else { start(year, month + 1) };
        Some((start(year, month)?, next?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn months_have_names_and_ranges() {
        let key = MonthKey::of(1_795_246_989_820_647);
        assert_eq!(key.file_name(), "2026-11.sqlite");
        assert_eq!(MonthKey::from_file_name("2026-11.sqlite"), Some(key));
        let (start, end) = key.range_us().unwrap();
        assert_eq!(UtcTime::from_micros(start).to_string(), "2026-11-01T00:00:00.000000Z");
        assert_eq!(UtcTime::from_micros(end).to_string(), "2026-12-01T00:00:00.000000Z");
        assert_eq!((MonthKey::of(start), MonthKey::of(end - 1)), (key, key));
        assert_ne!(MonthKey::of(end), key);
    }

    #[test]
    fn unbelievable_times_are_undated() {
        for time_us in [i64::MIN, 0, FIRST_US - 1, END_US, i64::MAX] {
            assert_eq!(MonthKey::of(time_us), MonthKey::Undated);
        }
        for name in
            ["catalogue.sqlite", "2026-13.sqlite", "2026-1.sqlite", "x-01.sqlite", "2026-11.sqlite-wal"]
        {
            assert_eq!(MonthKey::from_file_name(name), None, "{name}");
        }
    }
}
