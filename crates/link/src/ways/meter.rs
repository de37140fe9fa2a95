//! The byte budget of a day, and what is left out as it is used up.
//!
//! A day is one of UTC where the clock is right, and never longer than 24 h by the clock that does not step: a clock that
//! jumped, or never was set, does not spend a budget for good.

use std::time::Duration;
use units::{MonoTime, Now};

/// The approximate overhead of TCP, IP, TLS and WebSocket for each message.
const MESSAGE_COST_BYTES: u64 = 60;
const DAY_US: i64 = 86_400_000_000;
const DAY: Duration = Duration::from_hours(24);
/// A clock that shows an earlier day than the counted one for so long is trusted. A Raspberry Pi starts in the
/// past, and has the time by then where it has a network.
const BELIEVED_AFTER: Duration = Duration::from_mins(10);

/// Bytes of a day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Used {
    /// Days since 1970, UTC.
    pub day: i64,
    /// Bytes, both directions.
    pub bytes: u64,
}

/// The messages that a metered way leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Thinning {
    /// Nothing.
    #[default]
    Nothing,
    /// Records and charts; live values come once a second.
    Records,
    /// All but position, alarms, states and answers, every 5 s.
    Most,
    /// The same once a minute.
    AllButLast,
}

impl Thinning {
    pub(crate) fn from_code(code: u8) -> Self {
        match code {
            0 => Self::Nothing,
            1 => Self::Records,
            2 => Self::Most,
            _ => Self::AllButLast,
        }
    }

    /// A stable word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Records => "records",
            Self::Most => "most",
            Self::AllButLast => "all_but_last",
        }
    }

    /// Live values no more often than this; `None` for no limit.
    pub(crate) fn live_every(self) -> Option<Duration> {
        match self {
            Self::Nothing => None,
            Self::Records => Some(Duration::from_secs(1)),
            Self::Most => Some(Duration::from_secs(5)),
            Self::AllButLast => Some(Duration::from_mins(1)),
        }
    }
}

/// Counts a way's bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Meter {
    used: Used,
    daily_bytes: Option<u64>,
    /// Since when the bytes count, as far as this start of the program knows.
    begun: MonoTime,
    /// Since when the clock says, without a break, that it is an earlier day.
    earlier_since: Option<MonoTime>,
    /// The later day that an earlier one took the place of: its budget is spent already when the clock comes to it again.
    left: Option<i64>,
}

impl Meter {
    pub(crate) fn new(now: MonoTime, used: Used, daily_bytes: Option<u64>) -> Self {
        Self { used, daily_bytes, begun: now, earlier_since: None, left: None }
    }

    /// Begins the day that has come, or another after 24 h whatever the clock says. A clock that stands in the past begins
    /// none; after a while its day takes the place of the later one, with the bytes of that.
    pub(crate) fn turn(&mut self, now: Now) {
        let day = now.utc.micros().div_euclid(DAY_US);
        let is_spent = self.left.is_some_and(|left| day <= left);
        if now.mono.since(self.begun) >= DAY || (day > self.used.day && !is_spent) {
            self.used = Used { day: day.max(self.used.day), bytes: 0 };
            (self.begun, self.left) = (now.mono, None);
        } else if day > self.used.day {
            self.used.day = day;
        }
        if day >= self.used.day {
            self.earlier_since = None;
        } else if now.mono.since(*self.earlier_since.get_or_insert(now.mono)) >= BELIEVED_AFTER {
            self.left = self.left.max(Some(self.used.day));
            self.used.day = day;
            self.earlier_since = None;
        }
    }

    /// A message of so many bytes went or came.
    pub(crate) fn count(&mut self, now: Now, message_bytes: usize) {
        self.turn(now);
        self.used.bytes = self.used.bytes.saturating_add(message_bytes as u64 + MESSAGE_COST_BYTES);
    }

    pub(crate) fn used(&self) -> Used {
        self.used
    }

    pub(crate) fn daily_bytes(&self) -> Option<u64> {
        self.daily_bytes
    }

    pub(crate) fn thinning(&self) -> Thinning {
        let Some(budget) = self.daily_bytes else { return Thinning::Nothing };
        let (used, budget) = (u128::from(self.used.bytes) * 100, u128::from(budget));
        if used < budget * 70 {
            Thinning::Nothing
        } else if used < budget * 90 {
            Thinning::Records
        } else if used < budget * 100 {
            Thinning::Most
        } else {
            Thinning::AllButLast
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use units::UtcTime;

    /// So many hours into this test, while the clock says that it is this day.
    fn at(hours: u64, day: i64) -> Now {
        let mono = MonoTime::default() + Duration::from_hours(hours);
        Now { mono, utc: UtcTime::from_micros(day * DAY_US + 5) }
    }

    #[test]
    fn thinning_grows_with_what_the_day_has_used_and_ends_with_it() {
        let used = Used { day: 20_000, bytes: 60_000 };
        let mut meter = Meter::new(MonoTime::default(), used, Some(100_000));
        assert_eq!(meter.thinning(), Thinning::Nothing);
        let mut seen = Vec::new();
        for _ in 0..50 {
            meter.count(at(0, 20_000), 940);
            seen.push(meter.thinning());
        }
        assert_eq!((seen[8], seen[9]), (Thinning::Nothing, Thinning::Records));
        assert_eq!((seen[28], seen[29]), (Thinning::Records, Thinning::Most));
        assert_eq!(
            (seen[38], seen[39], seen[49]),
            (Thinning::Most, Thinning::AllButLast, Thinning::AllButLast)
        );
        meter.count(at(0, 0), 0);
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 110_060 }, "a clock in the past begins no day");
        meter.turn(at(0, 20_001));
        assert_eq!((meter.thinning(), meter.used().bytes), (Thinning::Nothing, 0));
    }

    #[test]
    fn a_clock_that_jumped_ahead_spends_no_budget_for_good() {
        let mut meter = Meter::new(MonoTime::default(), Used { day: 20_000, bytes: 7 }, Some(100_000));
        meter.count(at(0, 30_000), 99_940);
        assert_eq!(meter.thinning(), Thinning::AllButLast);
        meter.turn(at(1, 20_000));
        assert_eq!(meter.used().day, 30_000, "it may be the clock's present that is wrong");
        meter.turn(at(2, 20_000));
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 100_000 }, "what was used stays used");
        meter.turn(at(23, 20_001));
        assert_eq!(meter.used(), Used { day: 20_001, bytes: 100_000 }, "no day after one that was spent");
        meter.turn(at(24, 20_001));
        assert_eq!(meter.used(), Used { day: 20_001, bytes: 0 }, "but 24 h are one");
        meter.turn(at(30, 20_002));
        assert_eq!(meter.used().day, 20_002);
    }

    #[test]
    fn a_clock_that_starts_in_the_past_does_not_give_the_budget_twice() {
        let mut meter = Meter::new(MonoTime::default(), Used { day: 20_000, bytes: 90_000 }, Some(100_000));
        meter.turn(at(0, 19_000));
        meter.turn(at(1, 19_000));
        assert_eq!(meter.used(), Used { day: 19_000, bytes: 90_000 });
        // By now the vessel knows the time.
        meter.turn(at(2, 20_000));
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 90_000 });
        meter.turn(at(5, 20_001));
        assert_eq!(meter.used(), Used { day: 20_001, bytes: 0 });
    }

    #[test]
    fn a_clock_that_goes_there_and_back_is_not_believed_and_24_hours_are_a_day() {
        let mut meter = Meter::new(MonoTime::default(), Used { day: 20_000, bytes: 9 }, Some(100_000));
        for hours in 1..24 {
            meter.turn(at(hours, 20_000 - (hours as i64) % 2));
        }
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 9 });
        meter.turn(at(24, 20_000));
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 0 });
        meter.count(at(25, 20_000), 40);
        meter.turn(at(47, 20_000));
        assert_eq!(meter.used().bytes, 100, "counted anew from then on");
    }

    #[test]
    fn without_a_budget_nothing_is_left_out() {
        let meter = Meter::new(MonoTime::default(), Used { day: 1, bytes: u64::MAX }, None);
        assert_eq!(meter.thinning(), Thinning::Nothing);
    }
}
