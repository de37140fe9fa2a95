//! The computer's two clocks: a monotonic one for deadlines, and UTC for records, which may be set.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use units::{MonoTime, Now, UtcTime};

type Read<T> = Arc<dyn Fn() -> T + Send + Sync>;

/// The source of time: every part of the program with deadlines of the vessel uses this clock.
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

    /// Clocks of any kind.
    pub(crate) fn of(
        elapsed: impl Fn() -> Duration + Send + Sync + 'static,
        utc: impl Fn() -> UtcTime + Send + Sync + 'static,
    ) -> Self {
        Self { elapsed: Arc::new(elapsed), utc: Arc::new(utc) }
    }

    /// The current time of both clocks.
    pub(crate) fn now(&self) -> Now {
        Now { mono: MonoTime::default() + self.elapsed(), utc: self.utc() }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        (self.elapsed)()
    }

    /// The computer's UTC.
    pub(crate) fn utc(&self) -> UtcTime {
        (self.utc)()
    }
}

/// A clock before 1970 was never set; GNSS time shows that it is wrong.
fn system_utc() -> UtcTime {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // Until the year 294 000.
    UtcTime::from_micros(since.as_micros() as i64)
}
