//! Notifications of a program to the service manager (systemd, by the protocol of `sd_notify(3)`): that it is ready, alive,
//! ending. Without a service manager nothing is sent.
//!
//! [`ready`] and [`ending`] are sent once; a [`Lifeline`] reports that the program is alive for as long as its owner calls
//! [`Lifeline::beat`]. [`journal`] writes the log into the system's journal, with fields. [`report`] is what its doctor reports to monitoring.

pub mod journal;
pub mod lines;
pub mod report;

use sd_notify::NotifyState;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

/// The service is up: what waits for it may begin, and `systemctl start` returns.
pub fn ready() {
    tell(NotifyState::Ready);
}

/// The service ends, on its own or by request.
pub fn ending() {
    tell(NotifyState::Stopping);
}

fn tell(state: NotifyState<'_>) {
    if let Err(error) = sd_notify::notify(&[state]) {
        tracing::warn!(%error, "the service manager (systemd) cannot be told how the program is");
    }
}

/// How often [`Lifeline::beat`] must be called at least; `None` without a watchdog (`WatchdogSec` of the unit).
pub fn watched_every() -> Option<Duration> {
    // Half of what is allowed, as sd_watchdog_enabled(3) advises.
    sd_notify::watchdog_enabled().map(|limit| limit / 2)
}

/// Says that the program lives while its owner beats. An owner that hangs beats no more, and the service manager starts the
/// program again, although this thread runs on.
#[derive(Debug, Clone, Default)]
pub struct Lifeline(Arc<AtomicU64>);

impl Lifeline {
    /// Begins; a beat costs nothing and never waits for the service manager.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn start() -> std::io::Result<Self> {
        let lifeline = Self::default();
        if let Some(every) = watched_every() {
            lifeline.clone().watch(every, || tell(NotifyState::Watchdog))?;
        }
        Ok(lifeline)
    }

    /// The owner has done a round of its work.
    pub fn beat(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// Reports in a thread of its own, each `every`, if the owner has called [`Lifeline::beat`] since.
    fn watch(self, every: Duration, lives: impl Fn() + Send + 'static) -> std::io::Result<()> {
        let look = move || {
            let mut known = 0;
            loop {
                known = self.look(known, &lives);
                thread::sleep(every);
            }
        };
        thread::Builder::new().name("service".to_owned()).spawn(look)?;
        Ok(())
    }

    /// Looks once; gives how many beats are known now.
    fn look(&self, known: u64, lives: &impl Fn()) -> u64 {
        let beats = self.0.load(Ordering::Relaxed);
        if beats != known {
            lives();
        }
        beats
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn an_owner_that_hangs_is_not_said_to_live() {
        let (told, lifeline) = (Cell::new(0), Lifeline::default());
        let lives = || told.set(told.get() + 1);
        let mut known = lifeline.look(0, &lives);
        assert_eq!(told.get(), 0, "it has not begun");
        for round in 1..4 {
            lifeline.beat();
            known = lifeline.look(known, &lives);
            assert_eq!(told.get(), round);
        }
        for _ in 0..5 {
            known = lifeline.look(known, &lives);
        }
        assert_eq!(told.get(), 3, "it hangs");
        lifeline.beat();
        lifeline.look(known, &lives);
        assert_eq!(told.get(), 4, "it goes on");
    }
}
