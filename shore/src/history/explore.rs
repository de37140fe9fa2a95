//! Many detections at once, for plots: read once from the history, kept in a compact form, and counted there.
//!
//! Reading a million from the history takes seconds; counting a million in memory takes some tens of milliseconds. So the
//! detections of a query are read by a separate thread, in stretches of some days, the newest first, and kept while there
//! is room (`shelf`). What one query needs beyond that is left out, the oldest first, and the answer says from when on it
//! is complete.
//!
//! A query waits for `PATIENCE`; then it is answered with what has been read, and the answer says so. A month that got new
//! data is read again, but not before ten times the reading time has passed.
//!
//! Counting takes some 70 bytes for each detection: so a query is [`Explorer::prepare`]d, and counted in its turn.

use super::export;
use super::shelf::{Found, Kept, Shelf, Unread, Wanted};
use crate::error::asked_wrong;
use api::{DetectionsSummary, DetectionsSummaryQuery, say};
use imc::Address;
use research::{HORIZON_S, Narrowed, Question, Ranks, Sightings, SightingsBuilder, Study};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};
use store::{Acoustic, Page, Reader, StoreError, TimeRange};

/// Detections and reports of listening that are kept.
const MOST: usize = 2_000_000;
/// How long a plot's query waits for detections that are not read yet.
pub const PATIENCE: Duration = Duration::from_millis(200);
/// Detections that are read at once, and the bytes of their texts.
const PAGE: Page = Page { skip: 0, rows: 20_000, bytes: 16 << 20 };
/// A month is read again at the earliest after its reading time multiplied by this.
const REST: u32 = 10;

/// Detections in memory; cheap to clone.
#[derive(Debug, Clone)]
pub struct Explorer {
    data: PathBuf,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    page: Page,
    state: Mutex<State>,
    /// Notified when data were read, or the reading ended.
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    shelf: Shelf,
    /// Whether a thread reads.
    is_reading: bool,
    /// Why the last reading ended early.
    trouble: Option<String>,
}

/// A query whose detections are read, as far as there is room.
#[derive(Debug)]
pub struct Prepared {
    /// The query.
    pub question: Question,
    wanted: Wanted,
}

/// Where the detections of a query are.
#[derive(Debug)]
pub enum FoundRanks {
    /// All of them are counted.
    Whole(Ranks),
    /// They are still being read.
    Reading,
    /// There is no room for all of them.
    TooMany,
}

impl Explorer {
    pub(crate) fn new(data: &Path) -> Self {
        Self::holding(data, MOST, REST)
    }

    /// Keeps at most `most` detections, and reads a month again after `rest` times its reading time.
    fn holding(data: &Path, most: usize, rest: u32) -> Self {
        let page = Page { rows: PAGE.rows.min(most / 100).max(1), ..PAGE };
        let state = State { shelf: Shelf::new(most, rest), is_reading: false, trouble: None };
        let shared = Shared { page, state: Mutex::new(state), changed: Condvar::new() };
        Self { data: data.to_owned(), shared: Arc::new(shared) }
    }

    /// Has the detections of a query read, and waits for them no longer than `patience`: [`PATIENCE`] for plots.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn prepare(
        &self,
        reader: &mut Reader,
        question: Question,
        patience: Duration,
    ) -> store::Result<Prepared> {
        // Detections just outside of the range may confirm its first and last.
        let beside_us = HORIZON_S * 1_000_000;
        let range = TimeRange {
            from_us: question.from_us.saturating_sub(beside_us),
            to_us: question.to_us.saturating_add(beside_us),
        };
        let mut months = Vec::new();
        for month in store::months(reader)? {
            if month.within(range).is_empty() {
                continue;
            }
            // Days without data of these vessels are not read.
            if let Some(heard) = reader.acoustic_extent(&question.vessels, month)? {
                months.push((month, heard, store::acoustic_version(reader, month)?));
            }
        }
        let wanted = Wanted::new(months.into_iter(), range, question.vessels.clone());
        self.wait(&wanted, patience)?;
        Ok(Prepared { question, wanted })
    }

    /// Counts the detections of a query that are read.
    pub fn summary(&self, prepared: &Prepared, study: &Study) -> DetectionsSummary {
        let Prepared { question, wanted } = prepared;
        let found = self.shared.lock().shelf.found(wanted);
        let pieces: Vec<&Sightings> = found.pieces.iter().map(Arc::as_ref).collect();
        let whole_from_us = found.read_from_us.max(found.left_out_before_us);
        let summary = research::summary(&pieces, study, question, whole_from_us);
        DetectionsSummary {
            read_from_us: found.read_from_us,
            left_out_before_us: left_out(&found, question),
            // A cut before the start of the range leaves out what may confirm its first day.
            confirmed_from_us: whole_from_us
                .map(|whole_us| whole_us.saturating_add(HORIZON_S * 1_000_000))
                .filter(|confirmed_us| *confirmed_us > question.from_us),
            ..summary
        }
    }

    /// The begins of at most `parts` equal parts of a query's detections.
    pub fn ranks(&self, prepared: &Prepared, study: &Study, parts: usize) -> FoundRanks {
        let Prepared { question, wanted } = prepared;
        let found = self.shared.lock().shelf.found(wanted);
        if found.read_from_us.is_some() {
            return FoundRanks::Reading;
        }
        if left_out(&found, question).is_some() {
            return FoundRanks::TooMany;
        }
        let pieces: Vec<&Sightings> = found.pieces.iter().map(Arc::as_ref).collect();
        FoundRanks::Whole(research::ranks(&pieces, study, question, parts))
    }

    /// Waits until all is read, at most for `patience`.
    fn wait(&self, wanted: &Wanted, patience: Duration) -> store::Result<()> {
        let until = Instant::now() + patience;
        let mut state = self.shared.lock();
        let asked = state.shelf.ask(wanted);
        state.trouble = None;
        loop {
            let now = Instant::now();
            let unread = state.shelf.unread(wanted, asked, now);
            if let Some(trouble) = state.trouble.take() {
                return Err(asked_wrong(
                    say("detections cannot be read: {trouble}").with("trouble", trouble),
                ));
            }
            if unread.is_empty() || now >= until {
                return Ok(());
            }
            if !state.is_reading {
                // Without a thread the next question tries again.
                self.read(unread, asked)?;
                state.is_reading = true;
            }
            (state, _) =
                self.shared.changed.wait_timeout(state, until - now).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Reads stretches, in a thread that ends with the explorer.
    fn read(&self, unread: Vec<Unread>, asked: u64) -> store::Result<()> {
        let (data, shared) = (self.data.clone(), Arc::downgrade(&self.shared));
        let work = move || {
            let _ends = Ends(Weak::clone(&shared));
            let read = read_all(&data, &shared, unread, asked);
            if let (Err(error), Some(shared)) = (read, shared.upgrade()) {
                shared.lock().trouble = Some(error.to_string());
            }
        };
        let started = std::thread::Builder::new().name("explorer".into()).spawn(work);
        started.map(drop).map_err(|source| StoreError::Io { path: "a thread".into(), source })
    }
}

/// From when on the answer is complete, if there is no room for earlier detections; `None` if only those outside of the
/// range are left out.
fn left_out(found: &Found, question: &Question) -> Option<i64> {
    found.left_out_before_us.filter(|before_us| *before_us > question.from_us)
}

/// Reports the end of a reading, also after a panic.
struct Ends(Weak<Shared>);

impl Drop for Ends {
    fn drop(&mut self) {
        if let Some(shared) = self.0.upgrade() {
            shared.lock().is_reading = false;
            shared.changed.notify_all();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Each change leaves it consistent.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read_all(data: &Path, shared: &Weak<Shared>, unread: Vec<Unread>, asked: u64) -> store::Result<()> {
    let mut reader = Reader::open(data)?;
    for unread in unread {
        if !read_stretch(&mut reader, shared, unread, asked)? {
            break;
        }
    }
    Ok(())
}

/// Reads vessels of a stretch; returns whether there is room for more.
fn read_stretch(
    reader: &mut Reader,
    shared: &Weak<Shared>,
    unread: Unread,
    asked: u64,
) -> store::Result<bool> {
    let Some(first) = shared.upgrade() else { return Err(StoreError::Cancelled) };
    let (mut rest, mut page) = (unread.stretch, first.page);
    let mut reading = first.lock().shelf.begin(unread, asked, Instant::now());
    drop(first);
    loop {
        let systems: Vec<Address> = reading.vessels().map(Address).collect();
        let found = reader.acoustics(&systems, rest, page)?;
        let Some(shared) = shared.upgrade() else { return Err(StoreError::Cancelled) };
        let next = found.next.map(|next| (next.time_us.saturating_add(1), next.skip));
        let pieces = pieces(found.items);
        let kept = shared.lock().shelf.take(
            &mut reading,
            pieces,
            next.map(|(whole_us, _)| whole_us),
            Instant::now(),
        );
        shared.changed.notify_all();
        match (kept, next) {
            (Kept::Again, _) => (rest, page.skip) = (reading.stretch(), 0),
            (Kept::All, Some((to_us, skip))) => (rest.to_us, page.skip) = (to_us, skip),
            (Kept::All, None) => return Ok(true),
            (Kept::NoRoom, _) => return Ok(false),
        }
    }
}

/// Detections in the compact form, by vessel.
fn pieces(items: Vec<Acoustic>) -> BTreeMap<u16, Arc<Sightings>> {
    let mut pieces = BTreeMap::<u16, SightingsBuilder>::new();
    for one in items {
        match one {
            Acoustic::Heard(one) => pieces.entry(one.origin.system.0).or_default().push(&one),
            Acoustic::Listening(origin, told) => {
                pieces.entry(origin.system.0).or_default().listen(origin, told);
            }
        }
    }
    pieces.into_iter().map(|(vessel, piece)| (vessel, Arc::new(piece.finish()))).collect()
}

/// Parses a query.
///
/// # Errors
/// The error names the parameter.
pub fn question(
    query: &DetectionsSummaryQuery,
    systems: &[imc::Address],
    study: &Study,
) -> store::Result<Question> {
    Ok(Question {
        vessels: systems.iter().map(|system| system.0).collect::<BTreeSet<u16>>(),
        from_us: query.from_us.unwrap_or(0).max(0),
        to_us: query.to_us.unwrap_or(i64::MAX),
        tags: export::tags(query.tag.as_deref())?,
        whole_axis: query.whole_axis.unwrap_or(false),
        narrowed: narrowed(&query.project, query.area.as_deref(), study)?,
    })
}

/// Parses the filters by project and area.
///
/// # Errors
/// There is no such project, or the area is not valid.
pub fn narrowed(projects: &[String], area: Option<&str>, study: &Study) -> store::Result<Narrowed> {
    Narrowed::new(projects, area, study).map_err(asked_wrong)
}

#[cfg(test)]
#[path = "explore_tests.rs"]
mod tests;
