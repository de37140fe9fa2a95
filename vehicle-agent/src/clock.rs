//! The computer's two clocks: one for deadlines, which only goes forth, and one for records, which may be set.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use units::{MonoTime, Now, UtcTime};

type Read<T> = Arc<dyn Fn() -> T + Send + Sync>;

/// Where time comes from: every part of the program that keeps deadlines of the vessel reads this one.
#[derive(Clone)]
pub(crate) struct Clock {
    elapsed: Read<Duration>,
    utc: Read<UtcTime>,
}

impl std::fmt::Debug for Clock {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Clock").finish_non_exhaustive()
    }
}

impl Clock {
    /// The computer's, counting from here.
    pub(crate) fn system() -> Self {
        let started = Instant::now();
        Self::of(move || started.elapsed(), system_utc)
    }

    /// Clocks of whatever kind.
    pub(crate) fn of(
        elapsed: impl Fn() -> Duration + Send + Sync + 'static,
        utc: impl Fn() -> UtcTime + Send + Sync + 'static,
    ) -> Self {
        Self { elapsed: Arc::new(elapsed), utc: Arc::new(utc) }
    }

    /// The moment, by both clocks.
    pub(crate) fn now(&self) -> Now {
        Now { mono: MonoTime::default() + self.elapsed(), utc: self.utc() }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        (self.elapsed)()
    }

    /// What the computer takes for UTC.
    pub(crate) fn utc(&self) -> UtcTime {
        (self.utc)()
    }
}

/// A clock before 1970 is one that was never set; the satellites show that it is off.
fn system_utc() -> UtcTime {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // Until the year 294 000.
    UtcTime::from_micros(since.as_micros() as i64)
}
