//! Many detections at once, for plots: read once from the history, kept small, and counted from there.
//!
//! To read a million from the history takes seconds; to count a million that are in memory takes some tens of milliseconds. So
//! months that somebody asks about are read by a thread of its own, the newest detections first, and kept as long as there is room:
//! `MOST` detections and reports of listening, 32 bytes each, 64 MB in all; the months that were asked for the longest ago make
//! room. What one question asks beyond that is left out, the oldest first, and the answer says from when on it is whole.
//!
//! A question waits for `PATIENCE`; then it is answered with what is read by then, and the answer says so. A month to which
//! something came since is read again, but not before ten times as long has gone by as that takes.

use crate::history::export;
use api::{DetectionsSummary, DetectionsSummaryQuery};
use research::{HORIZON_S, Narrowed, Question, Sightings, Study, TagNames};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};
use store::{Acoustic, Page, Reader, StoreError, TimeRange};

/// Detections and reports of listening that are kept.
const MOST: usize = 2_000_000;
/// So long a question waits for what is not read yet.
const PATIENCE: Duration = Duration::from_millis(200);
/// Detections that are read at once, and the bytes of their texts.
const PAGE: Page = Page { skip: 0, rows: 20_000, bytes: 16 << 20 };
/// A month is read again at the earliest after so many times what that takes.
const REST: u32 = 10;

/// Detections in memory; cheap to clone.
#[derive(Debug, Clone)]
pub struct Explorer {
    data: PathBuf,
    shelf: Arc<Shelf>,
}

#[derive(Debug)]
struct Shelf {
    /// How many are kept.
    most: usize,
    state: Mutex<State>,
    /// Something was read, or the reading ended.
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    names: Arc<TagNames>,
    /// By their begin (µs).
    months: BTreeMap<i64, Month>,
    /// Whether a thread reads.
    is_reading: bool,
    /// Why the last reading ended early.
    trouble: Option<String>,
    /// Counts questions.
    asked: u64,
}

/// A month, as far as it is read.
#[derive(Debug, Clone)]
struct Month {
    /// Of the history that was read.
    version: u64,
    /// The newest first.
    chunks: Vec<Arc<Sightings>>,
    reach: Reach,
    /// The last question that was about it.
    asked: u64,
    /// When it was read, and how long that took.
    read: Option<(Instant, Duration)>,
}

impl Month {
    fn len(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.len()).sum()
    }
}

/// How far a month is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// All of it.
    Whole,
    /// From this time on (µs); the thread is at it.
    From(i64),
    /// From this time on (µs), for there was no room for more.
    Cut(i64),
}

/// What was found of the months of a question.
struct Found {
    names: Arc<TagNames>,
    chunks: Vec<Arc<Sightings>>,
    read_from_us: Option<i64>,
    left_out_before_us: Option<i64>,
}

/// Months that are wanted, the newest first, with the version of the history.
type Wanted = Vec<(TimeRange, u64)>;

impl Explorer {
    pub(crate) fn new(data: &Path) -> Self {
        Self::holding(data, MOST)
    }

    fn holding(data: &Path, most: usize) -> Self {
        let shelf = Shelf { most, state: Mutex::default(), changed: Condvar::new() };
        Self { data: data.to_owned(), shelf: Arc::new(shelf) }
    }

    /// Counts what a question asks for.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn summary(
        &self,
        reader: &mut Reader,
        question: &Question,
        study: &Study,
    ) -> store::Result<DetectionsSummary> {
        self.summary_within(reader, question, study, PATIENCE)
    }

    /// The same, with more patience or less.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn summary_within(
        &self,
        reader: &mut Reader,
        question: &Question,
        study: &Study,
        patience: Duration,
    ) -> store::Result<DetectionsSummary> {
        // What confirms the first and last detections lies beside them.
        let beside_us = HORIZON_S * 1_000_000;
        let range = TimeRange {
            from_us: question.from_us.saturating_sub(beside_us),
            to_us: question.to_us.saturating_add(beside_us),
        };
        let mut wanted = Wanted::new();
        for month in store::months(reader)?.into_iter().rev() {
            if !month.within(range).is_empty() {
                wanted.push((month, store::acoustic_version(reader, month)?));
            }
        }
        let found = self.find(&wanted, patience)?;
        let chunks: Vec<&Sightings> = found.chunks.iter().map(Arc::as_ref).collect();
        let mut summary = research::summary(&found.names, &chunks, study, question);
        summary.read_from_us = found.read_from_us;
        summary.left_out_before_us =
            found.left_out_before_us.filter(|before_us| *before_us > question.from_us);
        Ok(summary)
    }

    /// What is read of the months, after at most so long.
    fn find(&self, wanted: &Wanted, patience: Duration) -> store::Result<Found> {
        let until = Instant::now() + patience;
        let mut state = self.shelf.lock();
        state.asked += 1;
        let asked = state.asked;
        for (month, _) in wanted {
            if let Some(month) = state.months.get_mut(&month.from_us) {
                month.asked = asked;
            }
        }
        state.trouble = None;
        loop {
            let unread = state.unread(wanted, Instant::now());
            if let Some(trouble) = state.trouble.take() {
                return Err(StoreError::Query(format!("detections cannot be read: {trouble}")));
            }
            let now = Instant::now();
            if unread.is_empty() || now >= until {
                return Ok(state.found(wanted));
            }
            if !state.is_reading {
                // Without a thread the next question tries again.
                self.read(unread, asked)?;
                state.is_reading = true;
            }
            (state, _) =
                self.shelf.changed.wait_timeout(state, until - now).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Reads months, in a thread that ends with the explorer.
    fn read(&self, wanted: Wanted, asked: u64) -> store::Result<()> {
        let (data, shelf) = (self.data.clone(), Arc::downgrade(&self.shelf));
        let work = move || {
            let _ends = Ends(Weak::clone(&shelf));
            let read = read_all(&data, &shelf, &wanted, asked);
            if let (Err(error), Some(shelf)) = (read, shelf.upgrade()) {
                shelf.lock().trouble = Some(error.to_string());
            }
        };
        let started = std::thread::Builder::new().name("explorer".into()).spawn(work);
        started.map(drop).map_err(|source| StoreError::Io { path: "a thread".into(), source })
    }
}

/// Says that the reading ended, however it did.
struct Ends(Weak<Shelf>);

impl Drop for Ends {
    fn drop(&mut self) {
        if let Some(shelf) = self.0.upgrade() {
            shelf.lock().is_reading = false;
            shelf.changed.notify_all();
        }
    }
}

impl Shelf {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Each change leaves it whole.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Those of the months that are to be read.
    fn unread(&self, wanted: &Wanted, now: Instant) -> Wanted {
        let has_others =
            self.months.keys().any(|from_us| !wanted.iter().any(|(month, _)| month.from_us == *from_us));
        let mut unread = Wanted::new();
        for (month, version) in wanted {
            let is_read = self.months.get(&month.from_us).is_some_and(|known| {
                let is_rested =
                    known.read.is_none_or(|(at, took)| now.saturating_duration_since(at) >= took * REST);
                match known.reach {
                    Reach::From(_) => false,
                    Reach::Cut(_) => !has_others && (known.version == *version || !is_rested),
                    Reach::Whole => known.version == *version || !is_rested,
                }
            });
            if !is_read {
                unread.push((*month, *version));
            } else if self.is_cut(month) {
                break;
            }
        }
        unread
    }

    fn is_cut(&self, month: &TimeRange) -> bool {
        self.months.get(&month.from_us).is_some_and(|known| matches!(known.reach, Reach::Cut(_)))
    }

    fn found(&self, wanted: &Wanted) -> Found {
        let mut found = Found {
            names: Arc::clone(&self.names),
            chunks: Vec::new(),
            read_from_us: None,
            left_out_before_us: None,
        };
        for (month, _) in wanted {
            let known = self.months.get(&month.from_us);
            found.chunks.extend(known.into_iter().flat_map(|known| known.chunks.iter().cloned()));
            match known.map_or(Reach::From(month.to_us), |known| known.reach) {
                Reach::Whole => {}
                Reach::From(from_us) => {
                    found.read_from_us = Some(from_us);
                    break;
                }
                Reach::Cut(from_us) => {
                    found.left_out_before_us = Some(from_us);
                    break;
                }
            }
        }
        found
    }

    fn len(&self) -> usize {
        self.months.values().map(Month::len).sum()
    }

    /// Whether there is room for so many more of a month that is read. What was read of it before stays until it is read again, where
    /// there is room for both.
    fn has_room_beside(&mut self, fresh: &Month, month: TimeRange, count: usize, most: usize) -> bool {
        if !self.is_whole(month) {
            return self.has_room(count, most, fresh.asked);
        }
        let staged = fresh.len() + count;
        if self.has_room(staged, most, fresh.asked) {
            return true;
        }
        self.months.remove(&month.from_us);
        self.has_room(staged, most, fresh.asked)
    }

    fn is_whole(&self, month: TimeRange) -> bool {
        self.months.get(&month.from_us).is_some_and(|known| known.reach == Reach::Whole)
    }

    /// Keeps what was read of a month, in place of what was read of it before where that is no more.
    fn keep(&mut self, month: TimeRange, fresh: &mut Month, begun: Instant) {
        let is_done = !matches!(fresh.reach, Reach::From(_));
        if is_done {
            fresh.read = Some((Instant::now(), begun.elapsed()));
        }
        if is_done || !self.is_whole(month) {
            let asked = self.months.get(&month.from_us).map_or(fresh.asked, |known| known.asked);
            self.months.insert(month.from_us, Month { asked, ..fresh.clone() });
        }
    }

    /// Makes room for so many, by months that this question is not about; whether there is room then.
    fn has_room(&mut self, count: usize, most: usize, asked: u64) -> bool {
        while self.len() + count > most {
            let others = self.months.iter().filter(|(_, month)| month.asked < asked);
            let Some(from_us) = others.min_by_key(|(_, month)| month.asked).map(|(from_us, _)| *from_us)
            else {
                return false;
            };
            self.months.remove(&from_us);
        }
        true
    }
}

fn read_all(data: &Path, shelf: &Weak<Shelf>, wanted: &Wanted, asked: u64) -> store::Result<()> {
    let mut reader = Reader::open(data)?;
    for (month, version) in wanted {
        if !read_month(&mut reader, shelf, *month, *version, asked)? {
            break;
        }
    }
    Ok(())
}

/// Reads a month; whether there is room for more.
fn read_month(
    reader: &mut Reader,
    shelf: &Weak<Shelf>,
    month: TimeRange,
    version: u64,
    asked: u64,
) -> store::Result<bool> {
    let begun = Instant::now();
    let (mut rest, mut page) = (month, PAGE);
    let mut fresh = Month { version, chunks: Vec::new(), reach: Reach::From(month.to_us), asked, read: None };
    loop {
        let found = reader.acoustics(rest, page)?;
        let Some(shelf) = shelf.upgrade() else { return Err(StoreError::Cancelled) };
        let mut state = shelf.lock();
        let chunk = chunk(Arc::make_mut(&mut state.names), found.items);
        let has_room = state.has_room_beside(&fresh, month, chunk.len(), shelf.most);
        fresh.reach = match (has_room, fresh.reach, found.next) {
            (true, _, None) | (false, Reach::Whole, _) => Reach::Whole,
            (true, _, Some(next)) => Reach::From(next.time_us),
            (false, Reach::From(from_us) | Reach::Cut(from_us), _) => Reach::Cut(from_us),
        };
        if has_room {
            fresh.chunks.push(Arc::new(chunk));
        }
        state.keep(month, &mut fresh, begun);
        drop(state);
        shelf.changed.notify_all();
        let (true, Some(next)) = (has_room, found.next) else { return Ok(has_room) };
        (rest.to_us, page.skip) = (next.time_us.saturating_add(1), next.skip);
    }
}

/// Detections kept small. What has no room for its name is not there.
fn chunk(names: &mut TagNames, items: Vec<Acoustic>) -> Sightings {
    let mut chunk = Sightings::default();
    for one in items {
        match one {
            Acoustic::Heard(one) => drop(chunk.push(names, &one)),
            Acoustic::Listening(origin, told) => chunk.listen(origin, told),
        }
    }
    chunk
}

/// A question from its text.
///
/// # Errors
/// What is wrong with which parameter.
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
        narrowed: narrowed(query.project.as_deref(), query.area.as_deref(), study)?,
    })
}

/// What is wanted of projects and places.
///
/// # Errors
/// There is no such project, or the area is none.
pub fn narrowed(projects: Option<&str>, area: Option<&str>, study: &Study) -> store::Result<Narrowed> {
    Narrowed::new(projects, area, study).map_err(StoreError::Query)
}

#[cfg(test)]
#[path = "explore_tests.rs"]
mod tests;
