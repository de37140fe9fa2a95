//! Queue of audit log lines that wait for the disk, so that the logged actions need not wait.
//!
//! A stop, a change of control and the progress of a command happen first and are written as soon as app.db is free, in
//! order, with the time at which they happened. At most [`WAITING`] lines are queued; a further one goes only to the
//! program's log, as an error with its full text, and is counted.

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
/// A line that has waited longer is reported by [`Journal::trouble`].
const LATE_US: i64 = 10_000_000;
/// Time limit for writing the queue when the program ends.
const GOOD_BYE: Duration = Duration::from_secs(2);

/// Non-blocking handle of the audit log; cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct Journal(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    clock: Clock,
    waiting: Mutex<VecDeque<(UtcTime, Line)>>,
    ready: Notify,
}

impl Journal {
    /// Empty, with its clock.
    pub(super) fn new(clock: Clock) -> Self {
        Self(Arc::new(Shared { clock, waiting: Mutex::default(), ready: Notify::default() }))
    }

    fn waiting(&self) -> MutexGuard<'_, VecDeque<(UtcTime, Line)>> {
        self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a line; never waits.
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

    /// What is wrong, if anything; safe to show to anyone.
    pub(super) fn trouble(&self) -> Option<&'static str> {
        let oldest = self.waiting().front().map(|(at, _)| *at)?;
        (self.0.clock.utc() - oldest > LATE_US).then_some("the audit log cannot be written")
    }

    /// Writes queued lines until `stop`; [`Journal::finish`] writes the rest.
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

    /// Writes the rest of the queue, once no more lines are added. Lines that app.db does not take in time go to the
    /// program's log.
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

    /// Writes the whole queue.
    pub(super) async fn write(&self, db: &Db) -> Result<(), Fault> {
        loop {
            let lines: Vec<(UtcTime, Line)> = self.waiting().iter().take(AT_ONCE).cloned().collect();
            let count = lines.len();
            if count == 0 {
                return Ok(());
            }
            db.change(audit::Record(lines)).await?;
            // Others only append, and only this task removes.
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
