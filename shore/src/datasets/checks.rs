//! Checks whether the archive still gives the published bytes.
//!
//! A check may take minutes. It is computed once for all requesters, by a task that continues if they disconnect; a later
//! request finds its answer.

use super::Datasets;
use super::contents::{CANONICAL, Frozen};
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result};
use crate::history::History;
use crate::identity::Principal;
use api::{DatasetCheck, DatasetContent, DatasetVersion, say};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{Semaphore, watch};
use tokio_util::sync::{CancellationToken, DropGuard};

/// Answers that are kept.
const KEPT: usize = 1_000;
/// An answer is reused for this long although the archive grew (µs): a boat under way changes it every second.
const HOLDS_US: i64 = 600_000_000;
/// Checks that run or are queued.
const RUNNING: usize = 16;

/// A file that is checked: dataset, version, and the link by which it is given (0 for none).
type Checked = (i64, u32, i64);

/// The answer of a check, with the state of archive and register that it is valid for.
type Kept = ((u64, i64), DatasetCheck);

/// The result of a check; `None` while it runs.
type Coming = watch::Receiver<Option<Result<DatasetCheck>>>;

#[derive(Default)]
struct Known {
    kept: BTreeMap<Checked, Kept>,
    running: BTreeMap<Checked, Coming>,
}

/// Checks that are known, and those that run.
#[derive(Clone)]
pub(super) struct Checks {
    known: Arc<Mutex<Known>>,
    /// For users with an account one file is computed at a time for checks, so that places for exports stay free.
    turn: Arc<Semaphore>,
    /// Cancels running checks once all handles of the datasets are dropped.
    ended: CancellationToken,
    _end: Arc<DropGuard>,
}

impl Default for Checks {
    fn default() -> Self {
        let ended = CancellationToken::new();
        let end = Arc::new(ended.clone().drop_guard());
        Self { known: Arc::default(), turn: Arc::new(Semaphore::new(1)), ended, _end: end }
    }
}

fn lock(known: &Mutex<Known>) -> MutexGuard<'_, Known> {
    // Valid even after a panic: every change is one insert or remove.
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Inputs of the task of one check.
struct Task {
    of: Checked,
    frozen: Arc<Frozen>,
    said: DatasetContent,
    known: Arc<Mutex<Known>>,
    places: Arc<Semaphore>,
    history: History,
    clock: Clock,
    ended: CancellationToken,
}

impl Drop for Task {
    fn drop(&mut self) {
        lock(&self.known).running.remove(&self.of);
    }
}

impl Task {
    async fn answer(&self) -> Result<DatasetCheck> {
        let (data, asked) = (self.history.data().to_owned(), Arc::clone(&self.frozen));
        let state = crate::error::slow(move || asked.state(&data)).await??;
        if let Some((known, check)) = lock(&self.known).kept.get(&self.of)
            && *known == state
        {
            return Ok(check.clone());
        }
        let place = Arc::clone(&self.places).acquire_owned().await.map_err(|_| busy())?;
        let frozen = Arc::clone(&self.frozen);
        let now = frozen.content(&self.history, place, self.ended.clone()).await?;
        let check = compared(&self.said, now, self.clock.utc().micros());
        let mut known = lock(&self.known);
        if known.kept.len() >= KEPT {
            known.kept.clear();
        }
        known.kept.insert(self.of, (state, check.clone()));
        Ok(check)
    }
}

fn busy() -> Error {
    Error::new(ErrorKind::Busy, say("Too many files are being checked; try again in a moment."))
}

/// Compares the published content with the present one.
fn compared(said: &DatasetContent, now: DatasetContent, checked_us: i64) -> DatasetCheck {
    let is_same = now.sha256 == said.sha256;
    let (rows, rows_now) = (said.rows, now.rows);
    let is_other_format = !is_same && said.format != now.format;
    let written_by = is_other_format.then(|| {
        if said.software.is_empty() { "another version of Lutra".to_owned() } else { said.software.clone() }
    });
    let text = match (&written_by, rows == rows_now) {
        _ if is_same => "The archive still gives exactly these bytes.".to_owned(),
        (Some(by), _) => format!(
            "Written by {by}, whose canonical CSV has other bytes than that of this version of Lutra: {rows} rows then, \
             {rows_now} now. Whether the archive has changed is not known."
        ),
        (None, false) => format!("The archive has changed since: {rows} rows then, {rows_now} now."),
        (None, true) => {
            format!(
                "The archive or the register has changed since: {rows} rows then and now, but other bytes."
            )
        }
    };
    DatasetCheck { checked_us, is_same, rows, rows_now, sha256_now: now.sha256, written_by, text }
}

impl Datasets {
    /// Whether the archive still gives the bytes of a published version.
    ///
    /// # Errors
    /// There is no such version, or not for this person; too much else is computed; or the archive cannot be read.
    pub async fn check(&self, who: &Principal, id: i64, number: u32) -> Result<DatasetCheck> {
        let frozen = self.file(who, id, number, None).await?;
        let version = self.version(who, id, number).await?;
        self.checked((id, number, 0), frozen, &version.content).await
    }

    /// The same, computed now, to be stored.
    pub(super) async fn check_now(&self, id: i64, version: &DatasetVersion) -> Result<DatasetCheck> {
        let frozen = self.frozen(version, None, Some(CANONICAL)).await?;
        self.begun((id, version.number, 0), frozen, &version.content).await
    }

    /// Compares a file with its published content; it is computed where no answer is stored.
    pub(super) async fn checked(
        &self,
        of: Checked,
        frozen: Frozen,
        said: &DatasetContent,
    ) -> Result<DatasetCheck> {
        let now_us = self.clock.utc().micros();
        let known = lock(&self.checks.known).kept.get(&of).map(|(_, check)| check.clone());
        match known.filter(|check| now_us.saturating_sub(check.checked_us) < HOLDS_US) {
            Some(check) => Ok(check),
            None => self.begun(of, frozen, said).await,
        }
    }

    /// The answer of the check that runs, or of a new one.
    async fn begun(&self, of: Checked, frozen: Frozen, said: &DatasetContent) -> Result<DatasetCheck> {
        let mut coming = self.begin(of, frozen, said)?;
        let done = coming.wait_for(Option::is_some).await;
        done.map_or_else(|_| Err(busy()), |done| done.clone().unwrap_or_else(|| Err(busy())))
    }

    fn begin(&self, of: Checked, frozen: Frozen, said: &DatasetContent) -> Result<Coming> {
        let mut known = lock(&self.checks.known);
        if let Some(coming) = known.running.get(&of) {
            return Ok(coming.clone());
        }
        if known.running.len() >= RUNNING {
            return Err(busy());
        }
        let (tell, coming) = watch::channel(None);
        known.running.insert(of, coming.clone());
        drop(known);
        let places = if of.2 == 0 { &self.checks.turn } else { self.places.all() };
        let task = Task {
            of,
            frozen: Arc::new(frozen),
            said: said.clone(),
            known: Arc::clone(&self.checks.known),
            places: Arc::clone(places),
            history: self.history.clone(),
            clock: self.clock.clone(),
            ended: self.checks.ended.clone(),
        };
        tokio::spawn(async move {
            let answer = tokio::select! {
                answer = task.answer() => answer,
                () = task.ended.cancelled() => Err(busy()),
            };
            drop(task);
            tell.send_replace(Some(answer));
        });
        Ok(coming)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn content(sha256: &str, format: u32) -> DatasetContent {
        DatasetContent {
            rows: 3,
            sha256: sha256.to_owned(),
            format,
            software: "Lutra 0.0.1".to_owned(),
            ..DatasetContent::default()
        }
    }

    #[test]
    fn other_bytes_of_another_format_do_not_blame_the_archive() {
        let check = compared(&content("a", 1), content("b", 2), 7);
        assert!(!check.is_same && check.written_by.as_deref() == Some("Lutra 0.0.1"), "{check:?}");
        assert!(
            check.text.starts_with("Written by Lutra 0.0.1") && !check.text.contains("has changed since")
        );
        let check = compared(&content("a", 1), content("a", 2), 7);
        assert!(check.is_same && check.written_by.is_none(), "the same bytes are the same");
        let check = compared(&content("a", 2), content("b", 2), 7);
        assert!(check.written_by.is_none() && check.text.contains("has changed since"));
    }
}
