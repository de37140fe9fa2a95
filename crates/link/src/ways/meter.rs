//! Bytes of a day, and what is left out as they go.

use std::time::Duration;
use units::UtcTime;

/// What TCP, IP, TLS and WebSocket add to a message, about.
const MESSAGE_COST_BYTES: u64 = 60;
const DAY_US: i64 = 86_400_000_000;

/// Bytes of a day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Used {
    /// Days since 1970, UTC.
    pub day: i64,
    /// Bytes, both directions.
    pub bytes: u64,
}

/// What a metered way leaves out.
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

    /// Live values no more often than this; `None` for as often as ever.
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
}

impl Meter {
    pub(crate) fn new(used: Used, daily_bytes: Option<u64>) -> Self {
        Self { used, daily_bytes }
    }

    /// Begins the day that has come. A clock that stands in the past, as a Raspberry Pi's does at its start, begins none.
    pub(crate) fn turn(&mut self, now: UtcTime) {
        let day = now.micros().div_euclid(DAY_US);
        if day > self.used.day {
            self.used = Used { day, bytes: 0 };
        }
    }

    pub(crate) fn count(&mut self, now: UtcTime, message_bytes: usize) {
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

    #[test]
    fn thinning_grows_with_what_the_day_has_used_and_ends_with_it() {
        let at = |day: i64| UtcTime::from_micros(day * DAY_US + 5);
        let mut meter = Meter::new(Used { day: 20_000, bytes: 60_000 }, Some(100_000));
        assert_eq!(meter.thinning(), Thinning::Nothing);
        let mut seen = Vec::new();
        for _ in 0..50 {
            meter.count(at(20_000), 940);
            seen.push(meter.thinning());
        }
        assert_eq!((seen[8], seen[9]), (Thinning::Nothing, Thinning::Records));
        assert_eq!((seen[28], seen[29]), (Thinning::Records, Thinning::Most));
        assert_eq!(
            (seen[38], seen[39], seen[49]),
            (Thinning::Most, Thinning::AllButLast, Thinning::AllButLast)
        );
        meter.count(at(0), 0);
        assert_eq!(meter.used(), Used { day: 20_000, bytes: 110_060 }, "a clock in the past begins no day");
        meter.turn(at(20_001));
        assert_eq!((meter.thinning(), meter.used().bytes), (Thinning::Nothing, 0));
    }

    #[test]
    fn without_a_budget_nothing_is_left_out() {
        let meter = Meter::new(Used { day: 1, bytes: u64::MAX }, None);
        assert_eq!(meter.thinning(), Thinning::Nothing);
    }
}
