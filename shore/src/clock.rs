//! The program's clock, and the format of its times.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::watch;
use units::{MonoTime, Now, UtcTime};

/// The clock of a running server: a monotonic clock for deadlines, and UTC for records. Cheap to clone.
///
/// Everything that depends on time (leases, alarms, sessions, the progress of an order) uses it. Timeouts of sockets and
/// disks use the computer's own clock: tests cannot speed up a disk.
#[derive(Debug, Clone)]
pub struct Clock {
    begun: Instant,
    /// Offset by which a test moved it ahead of the computer's clock.
    ahead: Option<watch::Receiver<Duration>>,
}

/// Moves a [`Clock`] ahead, in a test that starts the server in its own process; cheap to clone.
#[derive(Debug, Clone)]
pub struct ClockHand(watch::Sender<Duration>);

impl Clock {
    /// The computer's clock.
    pub fn real() -> Self {
        Self { begun: Instant::now(), ahead: None }
    }

    /// The computer's clock, with a hand to move it ahead.
    pub fn with_hand() -> (Self, ClockHand) {
        let (hand, ahead) = watch::channel(Duration::ZERO);
        (Self { begun: Instant::now(), ahead: Some(ahead) }, ClockHand(hand))
    }

    /// The current time of both clocks.
    pub fn now(&self) -> Now {
        Now { mono: self.mono(), utc: self.utc() }
    }

    /// The current monotonic time.
    pub fn mono(&self) -> MonoTime {
        MonoTime::from_micros((self.begun.elapsed() + self.ahead()).as_micros() as u64)
    }

    /// The current UTC.
    pub fn utc(&self) -> UtcTime {
        UtcTime::from_micros(now().micros() + self.ahead().as_micros() as i64)
    }

    /// Waits until `due`.
    pub async fn sleep_until(&self, due: MonoTime) {
        let mut ahead = self.ahead.clone();
        loop {
            let rest = due.since(self.mono());
            if rest.is_zero() {
                return;
            }
            let moved = async {
                // A clock without a hand, or whose hand is gone, is not moved any more.
                let Some(ahead) = &mut ahead else { return std::future::pending().await };
                if ahead.changed().await.is_err() {
                    std::future::pending::<()>().await;
                }
            };
            tokio::select! {
                () = tokio::time::sleep(rest) => {}
                () = moved => {}
            }
        }
    }

    fn ahead(&self) -> Duration {
        self.ahead.as_ref().map_or(Duration::ZERO, |ahead| *ahead.borrow())
    }
}

impl ClockHand {
    /// Moves the clock ahead at once.
    pub fn advance(&self, by: Duration) {
        self.0.send_modify(|ahead| *ahead += by);
    }
}

/// The computer's UTC, for short-lived commands. A running server uses its [`Clock`].
pub fn now() -> UtcTime {
    let us = match SystemTime::now().duration_since(UNIX_EPOCH) {
        Ok(since) => i64::try_from(since.as_micros()).unwrap_or(i64::MAX),
        Err(before) => -i64::try_from(before.duration().as_micros()).unwrap_or(i64::MAX),
    };
    UtcTime::from_micros(us)
}

/// An earlier time is certainly wrong: 2024-01-01.
pub const EARLIEST: UtcTime = UtcTime::from_micros(1_704_067_200_000_000);

/// Refuses a time that is certainly wrong, as on a computer without a battery-backed clock before it has synchronised.
///
/// # Errors
/// The time is wrong; the error says what to do.
pub fn check(now: UtcTime) -> Result<(), String> {
    if now >= EARLIEST {
        return Ok(());
    }
    let now = written(now);
    Err(format!(
        "this computer's clock says {now}, which cannot be: set it, or let chrony or systemd-timesyncd do so"
    ))
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

    #[test]
    fn a_clock_that_cannot_be_right_is_told_with_what_to_do() {
        check(EARLIEST).unwrap();
        let told = check(UtcTime::from_micros(EARLIEST.micros() - 1)).unwrap_err();
        assert!(told.contains("2023-12-31 23:59:59Z") && told.contains("chrony"), "{told}");
    }

    #[tokio::test]
    async fn a_clock_is_moved_for_all_who_have_it_and_wakes_who_waits() {
        let (clock, hand) = Clock::with_hand();
        let (other, hour) = (clock.clone(), Duration::from_hours(1));
        let (before, due) = (clock.now(), clock.mono() + hour);
        let waits = tokio::spawn(async move { other.sleep_until(due).await });
        hand.advance(hour);
        tokio::time::timeout(Duration::from_secs(20), waits).await.unwrap().unwrap();
        let after = clock.now();
        assert!(after.mono.since(before.mono) >= hour && after.utc - before.utc >= 3_600_000_000);
        assert!(Clock::real().utc() - after.utc < -3_500_000_000, "another clock goes on as it did");
    }
}
