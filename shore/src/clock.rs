//! The wall clock and how its times are written.

use std::time::{SystemTime, UNIX_EPOCH};
use units::UtcTime;

/// The time, UTC.
pub fn now() -> UtcTime {
    let us = match SystemTime::now().duration_since(UNIX_EPOCH) {
        Ok(since) => i64::try_from(since.as_micros()).unwrap_or(i64::MAX),
        Err(before) => -i64::try_from(before.duration().as_micros()).unwrap_or(i64::MAX),
    };
    UtcTime::from_micros(us)
}

/// As `2026-03-01 12:34:56Z`.
pub fn written(time: UtcTime) -> String {
    let at = time.civil();
    format!("{:04}-{:02}-{:02} {:02}:{:02}:{:02}Z", at.year, at.month, at.day, at.hour, at.minute, at.second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_in_utc() {
        assert_eq!(written(UtcTime::from_micros(1_772_368_496_000_000)), "2026-03-01 12:34:56Z");
    }
}
