//! How the history follows the archive: new packets go into it at once, and missing ones are read from
//! the archive in slices, the newest day first, while packets keep coming in.
//!
//! The history is derived, so nothing that is wrong with it stops the archive. A damaged file goes aside and its
//! days are read again; a history of a later version is left alone; one that cannot be opened is tried again.

use crate::archive::{self, Archive, DayKey, DayReader, Lengths, Written, shortened};
use crate::error::{Result, StoreError};
use crate::history::{Extent, History, Progress};
use crate::layout::{free_bytes, reserved_bytes};
use crate::packet::Arrived;
use imc::PacketView;
use link::LinkSeq;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Packets of the archive that are read into the history at once when no client is waiting.
pub(crate) const REPLAY_PACKETS: usize = 20_000;
/// The same between two commits, which wait meanwhile.
const SLICE_PACKETS: usize = 8_000;
/// Bytes that are read at once at most, or one packet more.
const SLICE_BYTES: usize = 4 << 20;
/// Bytes of the archive after which the history's progress is saved. As much may have to be read again after a
/// crash.
const SAVE_AFTER_BYTES: u64 = 4 << 20;
/// The same by the shore's clock (µs).
const SAVE_AFTER_US: i64 = 30_000_000;
/// The same by commits that brought nothing.
const IDLE_COMMITS: u32 = 20;
/// A history that cannot be opened is tried again each time so many slices were asked for.
const TRY_EVERY: u32 = 10;
/// Causes that are reported; more of them are counted.
const CAUSES: usize = 4;

/// The history, or why there is not one that can be written.
#[derive(Debug)]
enum Kept {
    Open(Box<History>),
    /// This file was written by a later version.
    Newer(PathBuf),
    /// It could not be opened, or a file of it is damaged.
    Closed {
        why: String,
        distrusted: Option<PathBuf>,
    },
}

/// The history on its way behind the archive.
#[derive(Debug)]
pub(crate) struct Follower {
    folder: PathBuf,
    kept: Kept,
    /// Days of which the archive has more than the history and `unindexed`; all days while there is no history.
    behind: BTreeSet<DayKey>,
    /// Most bytes that were to be read since it was whole.
    most_behind: u64,
    /// Why it is behind, in words.
    causes: Vec<String>,
    attempts: u32,
    /// On disk, and not in the history yet.
    unindexed: Vec<Written>,
    unsaved_bytes: u64,
    /// Commits since one brought something.
    idle_commits: u32,
    saved_at: UtcTime,
}

/// The progress of reading the archive.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Chunk {
    pub(crate) packets: u64,
    pub(crate) rows: u64,
}

impl Follower {
    /// Opens the history in a folder, as far as that can be.
    pub(crate) fn open(folder: PathBuf) -> Self {
        let kept = Kept::Closed { why: String::new(), distrusted: None };
        let mut follower = Self {
            folder,
            kept,
            behind: BTreeSet::new(),
            most_behind: 0,
            causes: Vec::new(),
            attempts: 0,
            unindexed: Vec::new(),
            unsaved_bytes: 0,
            idle_commits: 0,
            saved_at: UtcTime::default(),
        };
        follower.try_open();
        follower
    }

    fn try_open(&mut self) {
        let distrusted = match &mut self.kept {
            Kept::Closed { distrusted, .. } => distrusted.take(),
            Kept::Open(_) | Kept::Newer(_) => return,
        };
        self.kept = match History::open(self.folder.clone(), distrusted.as_deref()) {
            Ok((history, notes)) => {
                self.causes.extend(notes);
                Kept::Open(Box::new(history))
            }
            Err(StoreError::Newer { path }) => Kept::Newer(path),
            Err(error) => {
                let damaged = error.damaged_database().map(Path::to_owned).or(distrusted);
                Kept::Closed { why: error.to_string(), distrusted: damaged }
            }
        };
    }

    /// The history, if it can be written.
    pub(crate) fn history(&mut self) -> Result<&mut History> {
        match &mut self.kept {
            Kept::Open(history) => Ok(history),
            Kept::Newer(path) => Err(StoreError::Newer { path: path.clone() }),
            Kept::Closed { why, .. } => {
                Err(StoreError::Behind(format!("the history cannot be opened: {why}")))
            }
        }
    }

    /// How far a day was read.
    pub(crate) fn progress(&self, key: DayKey) -> Progress {
        match &self.kept {
            Kept::Open(history) => history.progress(key),
            Kept::Newer(_) | Kept::Closed { .. } => Progress::default(),
        }
    }

    /// The streams' numbers as it last knew them, if it knows any.
    pub(crate) fn streams(&self) -> Result<Vec<LinkSeq>> {
        match &self.kept {
            Kept::Open(history) => history.streams(),
            Kept::Newer(_) | Kept::Closed { .. } => Ok(Vec::new()),
        }
    }

    /// Whether there is no history to write to, or it is new and holds nothing that was read.
    pub(crate) fn knows_nothing(&self) -> bool {
        match &self.kept {
            Kept::Open(history) => history.is_new(),
            Kept::Newer(_) | Kept::Closed { .. } => true,
        }
    }

    /// Holds it against the archive: which days it lacks. Whether one is shorter than it was when it was read, which
    /// is written down for good.
    pub(crate) fn compare(&mut self, archive: &Archive) -> Result<bool> {
        let root = archive.root().to_owned();
        let days = archive::days(&root)?;
        let mut shorter = false;
        if let Kept::Open(history) = &mut self.kept {
            for (key, progress) in history.all_progress() {
                let (was, is) = (progress.lengths, archive.lengths(key));
                if was.data > is.data
                    && let Err(error) = shortened::add(&root, &key.name(), was.data, is.data)
                {
                    self.causes.push(format!("archive/{}: shorter than it was; {error}", key.name()));
                }
                if was.data > is.data || was.arrivals > is.arrivals {
                    // What came on a day that is gone stays known.
                    if days.contains(&key) {
                        history.set_progress(key, Progress::default());
                    } else {
                        history.unread_gone(key);
                    }
                    shorter = true;
                }
            }
            if history.is_new() && !days.is_empty() && self.causes.is_empty() {
                let text =
                    "history/catalogue.sqlite was not there: the history is made again from the archive";
                self.causes.push(text.to_owned());
            }
        }
        // A day without bytes that can be read is one whose compressed file is damaged.
        let lacks = |key: &DayKey| {
            let lengths = archive.lengths(*key);
            lengths.data > 0 && self.progress(*key).lengths != lengths
        };
        self.behind = days.into_iter().filter(lacks).collect();
        self.most_behind = self.behind_bytes(archive);
        Ok(shorter)
    }

    /// Takes what was just written: it goes into the history next, or, of a day that the history lacks more of, is
    /// read from the archive in its turn.
    pub(crate) fn take(&mut self, written: Vec<Written>, archive: &mut Archive) {
        for one in written {
            if !matches!(self.kept, Kept::Open(_)) {
                self.behind.insert(one.key);
            }
            if self.behind.contains(&one.key) {
                archive.recycle(one.batch);
            } else {
                self.unindexed.push(one);
            }
        }
    }

    /// Whether it lacks something that must be read from the archive.
    pub(crate) fn is_behind(&self) -> bool {
        !self.behind.is_empty() || !matches!(self.kept, Kept::Open(_))
    }

    /// Why it lacks something, and how far it is: tens of percents, so that it is not another text at each look.
    pub(crate) fn why_behind(&self, archive: &Archive) -> Option<String> {
        match &self.kept {
            Kept::Newer(path) => return Some(StoreError::Newer { path: path.clone() }.to_string()),
            Kept::Closed { why, .. } => return Some(format!("the history cannot be opened: {why}")),
            Kept::Open(_) if self.behind.is_empty() => return None,
            Kept::Open(_) => {}
        }
        let (left, all) = (self.behind_bytes(archive), self.most_behind.max(1));
        let tens = 10 * (all.saturating_sub(left)) / all * 10;
        let mut text = format!("what it lacks is made again from the archive, {tens} % of {} MiB", all >> 20);
        for cause in self.causes.iter().take(CAUSES) {
            text = format!("{text}; {cause}");
        }
        if let Some(more @ 1..) = self.causes.len().checked_sub(CAUSES) {
            text = format!("{text}; and {more} more files");
        }
        Some(text)
    }

    /// The findings of opening it, in words.
    pub(crate) fn causes(&self) -> Vec<String> {
        match &self.kept {
            Kept::Newer(path) => vec![StoreError::Newer { path: path.clone() }.to_string()],
            Kept::Closed { why, .. } => vec![format!("the history cannot be opened: {why}")],
            Kept::Open(_) => self.causes.clone(),
        }
    }

    fn behind_bytes(&self, archive: &Archive) -> u64 {
        let lacks =
            |key: &DayKey| archive.lengths(*key).data.saturating_sub(self.progress(*key).lengths.data);
        self.behind.iter().map(lacks).sum()
    }

    /// Puts what was just written into the history and, where it lacks something, a slice of that; how many rows it
    /// gained.
    pub(crate) fn index(&mut self, archive: &mut Archive, now: UtcTime) -> Result<u64> {
        let outcome = self.index_some(archive, now);
        match outcome {
            Err(error) if self.mend(&error, archive)? => Ok(0),
            other => other,
        }
    }

    fn index_some(&mut self, archive: &mut Archive, now: UtcTime) -> Result<u64> {
        let batches = std::mem::take(&mut self.unindexed);
        if matches!(self.kept, Kept::Closed { .. }) {
            self.attempts = self.attempts.wrapping_add(1);
            if self.attempts % TRY_EVERY == 1 {
                self.open_again(archive)?;
            }
        }
        let (mut done, mut failed) = (Chunk::default(), None);
        let is_idle = batches.is_empty();
        for batch in batches {
            // One that fails leaves its day and all later ones to be read from the archive.
            if failed.is_none() && !self.behind.contains(&batch.key) {
                match self.index_batch(&batch) {
                    Ok(rows) => done.rows += rows,
                    Err(error) => failed = Some(error),
                }
            }
            if failed.is_some() {
                self.behind.insert(batch.key);
            }
            archive.recycle(batch.batch);
        }
        if let Some(error) = failed {
            return Err(error);
        }
        if self.is_behind() {
            done.rows += self.catch_up(archive, SLICE_PACKETS)?.rows;
        } else if is_idle {
            self.history()?.tick()?;
            self.idle_commits = self.idle_commits.saturating_add(1);
            if self.idle_commits == IDLE_COMMITS && self.unsaved_bytes > 0 {
                self.save(archive, now)?;
            }
            return Ok(0);
        }
        self.idle_commits = 0;
        self.history()?.tend(done.rows)?;
        self.save_if_due(archive, now)?;
        Ok(done.rows)
    }

    /// Opens a history that was closed, and finds what it lacks.
    fn open_again(&mut self, archive: &Archive) -> Result<()> {
        self.try_open();
        if matches!(self.kept, Kept::Open(_)) {
            self.compare(archive)?;
        }
        Ok(())
    }

    /// Mends a history of which an error says that a file is damaged, and finds what it lacks; false for other errors.
    pub(crate) fn mend(&mut self, error: &StoreError, archive: &Archive) -> Result<bool> {
        let is_damage = self.distrust(error);
        if is_damage {
            self.open_again(archive)?;
        }
        Ok(is_damage)
    }

    /// Closes a history of which an error says that a file is damaged. Where that is one chunk of a compressed month, it is moved out of
    /// the way; otherwise the file goes aside when the history is opened again.
    fn distrust(&mut self, error: &StoreError) -> bool {
        let Some(path) = error.damaged_database().filter(|path| path.starts_with(&self.folder)) else {
            return false;
        };
        let is_mended = error.damaged_chunk().is_some_and(|place| {
            self.history().and_then(|history| history.set_chunk_aside(path, place)).unwrap_or(false)
        });
        if is_mended {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            self.causes.push(format!("history/{name}: {error}; it is set aside"));
        }
        let distrusted = (!is_mended).then(|| path.to_owned());
        self.kept = Kept::Closed { why: error.to_string(), distrusted };
        true
    }

    /// Reads so many missing packets, the newest day first: people look at that one.
    pub(crate) fn catch_up(&mut self, archive: &Archive, packets: usize) -> Result<Chunk> {
        self.history()?;
        let mut done = Chunk::default();
        while done.packets < packets as u64
            && let Some(key) = self.behind.iter().max_by_key(|key| (key.day, key.part, key.src)).copied()
        {
            Self::leave_room(archive)?;
            match self.read(archive, key, packets - done.packets as usize)? {
                Some(chunk) => {
                    done = Chunk { packets: done.packets + chunk.packets, rows: done.rows + chunk.rows };
                }
                None => {
                    self.behind.remove(&key);
                }
            }
        }
        if self.behind.is_empty() {
            self.causes.clear();
            self.most_behind = 0;
        }
        self.most_behind = self.most_behind.max(self.behind_bytes(archive));
        Ok(done)
    }

    /// As [`Self::index`] of what it lacks alone, in large pieces; what was read.
    pub(crate) fn replay_some(&mut self, archive: &Archive, now: UtcTime) -> Result<Chunk> {
        let outcome = self.catch_up(archive, REPLAY_PACKETS).and_then(|chunk| {
            self.history()?.tend(chunk.packets)?;
            self.save_if_due(archive, now)?;
            Ok(chunk)
        });
        match outcome {
            Err(error) if self.mend(&error, archive)? => Ok(Chunk::default()),
            other => other,
        }
    }

    /// Refuses to fill a disk that the archive needs.
    fn leave_room(archive: &Archive) -> Result<()> {
        let (reserved, free) = (reserved_bytes(archive.root())?, free_bytes(archive.root())?);
        if free < reserved {
            return Err(StoreError::Behind(format!(
                "the history is made again from the archive once there is room: {} MiB of the disk are free, and {} \
                 are left to recording; make room",
                free >> 20,
                reserved >> 20
            )));
        }
        Ok(())
    }

    fn read(&mut self, archive: &Archive, key: DayKey, most: usize) -> Result<Option<Chunk>> {
        let mut progress = self.progress(key);
        if progress.lengths == archive.lengths(key) {
            return Ok(None);
        }
        if progress.lengths == Lengths::default() {
            // From its beginning: what was known of it is counted again.
            progress.extent = Extent::NONE;
        }
        let Lengths { data, arrivals } = progress.lengths;
        let mut reader = DayReader::open(archive.root(), key, data, arrivals)?;
        let mut bytes = Vec::new();
        let mut packets = Vec::new();
        while packets.len() < most && bytes.len() < SLICE_BYTES {
            let Some(archived) = reader.next_packet()? else {
                progress.lengths = archive.lengths(key);
                break;
            };
            packets.push((bytes.len(), archived.arrival.received.micros()));
            bytes.extend_from_slice(archived.view.bytes());
            progress.lengths = archived.end;
        }
        let arrived = packets.iter().filter_map(|(at, received_us)| {
            let view = PacketView::unchecked(&bytes[*at..]).ok()?;
            Some(Arrived { view, received_us: *received_us })
        });
        let (rows, extent) = self.history()?.write(arrived)?;
        self.advance(key, progress, extent, bytes.len())?;
        Ok(Some(Chunk { packets: packets.len() as u64, rows }))
    }

    fn index_batch(&mut self, written: &Written) -> Result<u64> {
        let (rows, extent) = self.history()?.write(archive::packets_of(written))?;
        let mut progress = self.progress(written.key);
        progress.lengths = written.lengths;
        self.advance(written.key, progress, extent, written.batch.data.len())?;
        Ok(rows)
    }

    fn advance(&mut self, key: DayKey, mut progress: Progress, extent: Extent, bytes: usize) -> Result<()> {
        progress.extent.merge(extent);
        self.history()?.set_progress(key, progress);
        self.unsaved_bytes += bytes as u64;
        Ok(())
    }

    fn save_if_due(&mut self, archive: &Archive, now: UtcTime) -> Result<()> {
        let due = self.unsaved_bytes >= SAVE_AFTER_BYTES || now - self.saved_at >= SAVE_AFTER_US;
        if due { self.save(archive, now) } else { Ok(()) }
    }

    /// Makes what was read safe; nothing where there is no history.
    pub(crate) fn save(&mut self, archive: &Archive, now: UtcTime) -> Result<()> {
        if let Kept::Open(history) = &mut self.kept {
            let streams: Vec<LinkSeq> = archive.streams.all_durable().collect();
            history.save_progress(&streams)?;
            self.unsaved_bytes = 0;
            self.saved_at = now;
        }
        Ok(())
    }

    /// Counts days as not read, before they are removed from the archive. What came on them stays known while a month may have it.
    pub(crate) fn unread(&mut self, days: &[DayKey]) -> Result<()> {
        let history = self.history()?;
        for key in days {
            history.unread_gone(*key);
        }
        Ok(())
    }
}
