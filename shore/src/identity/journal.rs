//! Lines of the audit log that wait for the disk, so that what they tell of need not wait.
//!
//! A stop, control that somebody takes or gives back, and what became of a command happen first and are written down as
//! soon as app.db takes it, in order, with the time at which they happened. [`WAITING`] lines may wait; one more goes to
//! the program's log alone, as an error with everything that it says, and is counted.

use super::audit::{self, Line};
use super::fault::Fault;
use super::writer::Db;
use crate::clock::Clock;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// Lines that may wait.
const WAITING: usize = 10_000;
/// Lines written at once.
const AT_ONCE: usize = 200;
/// How long to wait after a failure.
const RETRY_AFTER: Duration = Duration::from_secs(1);
/// A line that waited longer is told by [`Journal::trouble`].
const LATE_US: i64 = 10_000_000;
/// What waits may take so long when the program ends.
const GOOD_BYE: Duration = Duration::from_secs(2);

/// The way to the audit log that waits for nothing; cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct Journal(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    clock: Clock,
    waiting: Mutex<VecDeque<(UtcTime, Line)>>,
    ready: Notify,
}

impl Journal {
    /// Empty, with the clock by which it is written.
    pub(super) fn new(clock: Clock) -> Self {
        Self(Arc::new(Shared { clock, waiting: Mutex::default(), ready: Notify::default() }))
    }

    fn waiting(&self) -> MutexGuard<'_, VecDeque<(UtcTime, Line)>> {
        self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has a line written; never waits.
    pub(super) fn note(&self, line: Line) {
        let mut waiting = self.waiting();
        if waiting.len() < WAITING {
            waiting.push_back((self.0.clock.utc(), line));
            drop(waiting);
            self.0.ready.notify_one();
            return;
        }
        drop(waiting);
        metrics::counter!("lutra_audit_lost_total").increment(1);
        let Line { actor, address, action, subject, outcome } = line;
        tracing::error!(
            actor,
            address,
            action,
            subject,
            outcome,
            "not in the audit log: too much waits for app.db"
        );
    }

    /// What is wrong, if anything: for anyone.
    pub(super) fn trouble(&self) -> Option<&'static str> {
        let oldest = self.waiting().front().map(|(at, _)| *at)?;
        (self.0.clock.utc() - oldest > LATE_US).then_some("the audit log cannot be written")
    }

    /// Writes what is noted until `stop`; [`Journal::finish`] writes what still waits then.
    pub(super) async fn keep(self, db: Db, stop: CancellationToken) {
        while stop.run_until_cancelled(self.0.ready.notified()).await.is_some() {
            let mut told = false;
            while let Some(Err(fault)) = stop.run_until_cancelled(self.write(&db)).await {
                if !std::mem::replace(&mut told, true) {
                    tracing::error!(%fault, "the audit log cannot be written; its lines wait in memory");
                }
                if stop.run_until_cancelled(tokio::time::sleep(RETRY_AFTER)).await.is_none() {
                    break;
                }
            }
        }
    }

    /// Writes what still waits, once nobody notes anything any more. What app.db does not take in time goes to the program's
    /// log.
    pub(super) async fn finish(&self, db: &Db) {
        if !matches!(tokio::time::timeout(GOOD_BYE, self.write(db)).await, Ok(Ok(()))) {
            for (_, line) in self.waiting().drain(..) {
                tracing::error!(
                    ?line,
                    "perhaps not in the audit log: the server ends and app.db does not answer"
                );
            }
        }
    }

    /// Writes all that waits.
    pub(super) async fn write(&self, db: &Db) -> Result<(), Fault> {
        loop {
            let lines: Vec<(UtcTime, Line)> = self.waiting().iter().take(AT_ONCE).cloned().collect();
            let count = lines.len();
            if count == 0 {
                return Ok(());
            }
            db.change(audit::Record(lines)).await?;
            // Whoever notes appends, and nobody else takes away.
            self.waiting().drain(..count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::writer::tests::started;
    use super::*;
    use crate::owners::Owners;

    fn line(subject: &str) -> Line {
        let (actor, address, outcome) = ("anna".to_owned(), "::1".to_owned(), "sent".to_owned());
        Line { actor, address, action: "stop", subject: subject.to_owned(), outcome }
    }

    #[tokio::test]
    async fn lines_are_written_in_order_at_the_latest_when_the_server_ends() {
        let owners = Owners::new(Clock::real());
        let (db, _folder) = started(&owners).await;
        let (journal, stop) = (Journal::new(Clock::real()), CancellationToken::new());
        for number in 0..500 {
            journal.note(line(&number.to_string()));
        }
        stop.cancel();
        journal.clone().keep(db.clone(), stop).await;
        journal.finish(&db).await;
        let written = db.ask(audit::Entries { count: 1_000, ..Default::default() }).await.unwrap();
        let subjects: Vec<String> = written.into_iter().rev().map(|entry| entry.subject).collect();
        assert_eq!(subjects, (0..500).map(|number| number.to_string()).collect::<Vec<_>>());
        assert!(journal.trouble().is_none() && owners.are_there());
    }

    #[test]
    fn what_waits_is_bounded() {
        let journal = Journal::new(Clock::real());
        for number in 0..WAITING + 10 {
            journal.note(line(&number.to_string()));
        }
        assert_eq!(journal.waiting().len(), WAITING);
    }
}
