//! Alarms in app.db: the active ones, so that acknowledgements survive a restart, and the log of changes.

use super::notes::WriteNotes;
use super::{EVERY, WRITE_PATIENCE};
use crate::identity::{Fault, People, Request};
use api::AlarmNote;
use operations::alarms::NOTES_KEPT;
use sqlx::SqliteConnection;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

/// Active alarms, and their revision.
#[derive(Debug, Clone, Default)]
pub(super) struct Standing {
    pub(super) revision: u64,
    pub(super) alarms: Vec<api::Alarm>,
}

/// Reads the alarms that were active when the server ended.
#[derive(Debug)]
pub(super) struct ReadStanding;

impl Request for ReadStanding {
    type Answer = Vec<api::Alarm>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<api::Alarm>, Fault> {
        let sql = "SELECT body FROM alarm ORDER BY id";
        let bodies: Vec<String> = sqlx::query_scalar(sql).fetch_all(db).await?;
        let read = |body: &String| {
            serde_json::from_str(body)
                .inspect_err(
                    |error| tracing::warn!(%error, "an alarm that another version kept is not understood"),
                )
                .ok()
        };
        Ok(bodies.iter().filter_map(read).collect())
    }
}

/// Replaces the stored active alarms.
#[derive(Debug)]
pub(super) struct WriteStanding(pub(super) Vec<api::Alarm>);

impl Request for WriteStanding {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        sqlx::query("DELETE FROM alarm").execute(&mut *db).await?;
        for alarm in &self.0 {
            let body = serde_json::to_string(alarm).unwrap_or_default();
            let insert = sqlx::query("INSERT INTO alarm (id, body) VALUES (?1, ?2)");
            let insert = insert.bind(i64::try_from(alarm.id).unwrap_or(i64::MAX)).bind(body);
            insert.execute(&mut *db).await?;
        }
        Ok(())
    }
}

/// Changes of alarms that are not in app.db yet.
#[derive(Debug, Clone, Default)]
pub(super) struct PendingNotes(Arc<Mutex<VecDeque<AlarmNote>>>);

impl PendingNotes {
    fn waiting(&self) -> MutexGuard<'_, VecDeque<AlarmNote>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// If a disk hangs for long, the oldest changes are dropped.
    pub(super) fn add(&self, notes: Vec<AlarmNote>) {
        let mut waiting = self.waiting();
        waiting.extend(notes);
        let over = waiting.len().saturating_sub(NOTES_KEPT);
        waiting.drain(..over);
    }

    fn all(&self) -> Vec<AlarmNote> {
        self.waiting().iter().cloned().collect()
    }

    /// Removes the oldest, which are written.
    fn written(&self, notes: &[AlarmNote]) {
        let mut waiting = self.waiting();
        for note in notes {
            if waiting.front() == Some(note) {
                waiting.pop_front();
            }
        }
    }
}

/// Writes active alarms and changes to app.db until the server ends, and publishes in `kept` the revision that is written.
/// While a disk hangs, only the latest set of active alarms waits.
pub(super) async fn keep(
    people: People,
    mut standing: watch::Receiver<Standing>,
    happened: PendingNotes,
    kept: watch::Sender<Option<u64>>,
    stop: CancellationToken,
) {
    let mut told = false;
    kept.send_replace(Some(0));
    while let Some(Ok(())) = stop.run_until_cancelled(standing.changed()).await {
        loop {
            let now = standing.borrow_and_update().clone();
            let revision = now.revision;
            match write(&people, &happened, now).await {
                Ok(()) => {
                    kept.send_replace(Some(revision));
                    break told = false;
                }
                Err(Fault::Stopped) => return,
                Err(error) => {
                    if !std::mem::replace(&mut told, true) {
                        tracing::error!(%error, "alarms are not kept over a restart");
                    }
                    if stop.run_until_cancelled(tokio::time::sleep(EVERY)).await.is_none() {
                        return;
                    }
                }
            }
        }
    }
    // What a user changed during the shutdown.
    if standing.has_changed().unwrap_or(true) {
        let last = standing.borrow_and_update().clone();
        if let Ok(Err(error)) = tokio::time::timeout(WRITE_PATIENCE, write(&people, &happened, last)).await {
            tracing::error!(%error, "the last change of an alarm is not kept over the restart");
        }
    }
}

/// Writes the changes, then the active alarms.
async fn write(people: &People, happened: &PendingNotes, now: Standing) -> Result<(), Fault> {
    let notes = happened.all();
    people.change(WriteNotes(notes.clone())).await?;
    happened.written(&notes);
    people.change(WriteStanding(now.alarms)).await
}
