//! The store, open for writing: what is accepted, when it is safe, and how the history follows.

use crate::archive::{self, Archive, DayKey, DayReader, Disk, Lengths, RealDisk, Recovered, Written};
use crate::archive::{ARRIVALS, DATA};
use crate::error::{Named as _, Result, StoreError};
use crate::fingerprint::RepeatWindow;
use crate::gaps::{self, Gap};
use crate::history::{Arrived, Extent, History, Progress};
use crate::lock::FolderLock;
use crate::packet::{Accepted, Committed, Door, LinkSeq, Outcome, Repairs};
use crate::reindex::{self, GROWING, HISTORY};
use crate::tail::Marks;
use imc::PacketView;
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Packets of the archive that are read into the history in one transaction.
const REPLAY_PACKETS: usize = 20_000;
/// Bytes of the archive after which the history's progress is saved. As much may have to be read again after a
/// crash.
const SAVE_AFTER_BYTES: u64 = 4 << 20;
/// The same by the shore's clock (µs).
const SAVE_AFTER_US: i64 = 30_000_000;
/// The same by commits that brought nothing.
const IDLE_COMMITS: u32 = 20;

/// The store of one data folder.
///
/// There is one writer for each folder; readers of the history ([`crate::Reader`]) need no writer and do not
/// disturb it. Nothing is on disk before a commit says so. At most 64 MiB wait for a commit: then
/// [`Store::accept`] refuses, and whoever brings packets must hold them back.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    archive: Archive,
    history: History,
    repeats: RepeatWindow,
    /// On disk, and not in the history yet.
    unindexed: Vec<Written>,
    /// What became durable and was not told yet.
    untold: Vec<LinkSeq>,
    /// Whether the archive holds packets that are neither in the history nor in `unindexed`.
    behind: bool,
    unsaved_bytes: u64,
    /// Commits since one brought something.
    idle_commits: u32,
    saved_at: UtcTime,
    now: UtcTime,
    repairs: Repairs,
    lock: FolderLock,
}

impl Store {
    /// Opens the store in a folder, making it if need be, mends what a crash left and reads into the history
    /// what is not there yet.
    ///
    /// # Errors
    /// When another process has it open, or files cannot be read or written.
    pub fn open(folder: &Path) -> Result<Self> {
        Self::open_with(folder, &mut |_| true)
    }

    /// As [`Self::open`]; `progress` is told how many packets were read into the history and may stop that by
    /// returning false.
    ///
    /// # Errors
    /// As [`Self::open`], and [`StoreError::Cancelled`].
    pub fn open_with(folder: &Path, progress: &mut dyn FnMut(u64) -> bool) -> Result<Self> {
        Self::open_on(folder, Box::new(RealDisk), progress)
    }

    /// Opens the archive with a history that grows beside the one that is asked.
    pub(crate) fn open_growing(folder: &Path, progress: &mut dyn FnMut(u64) -> bool) -> Result<Self> {
        Self::open_in(folder, GROWING, Box::new(RealDisk), progress)
    }

    pub(crate) fn open_on(
        folder: &Path,
        disk: Box<dyn Disk>,
        progress: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self> {
        Self::open_in(folder, HISTORY, disk, progress)
    }

    fn open_in(
        folder: &Path,
        history: &str,
        disk: Box<dyn Disk>,
        progress: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self> {
        let root = folder.join("archive");
        fs::create_dir_all(&root).named(&root)?;
        let lock = FolderLock::take(folder)?;
        reindex::finish_swap(folder)?;
        let mut store = Self {
            folder: folder.to_owned(),
            archive: Archive::new(root, disk),
            history: History::open(folder.join(history))?,
            repeats: RepeatWindow::new(),
            unindexed: Vec::new(),
            untold: Vec::new(),
            behind: false,
            unsaved_bytes: 0,
            idle_commits: 0,
            saved_at: UtcTime::default(),
            now: UtcTime::default(),
            repairs: Repairs::default(),
            lock,
        };
        let shorter = store.mend_archive()?;
        store.recover_streams(shorter)?;
        store.replay(progress)?;
        store.save()?;
        Ok(store)
    }

    /// What opening it found and mended.
    pub fn repairs(&self) -> &Repairs {
        &self.repairs
    }

    /// The data folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Takes a packet, to be on disk after the next commit.
    ///
    /// # Errors
    /// When the bytes are not just one packet, or too much waits already ([`StoreError::Full`]): commit, and
    /// give it again.
    pub fn accept(&mut self, accepted: &Accepted<'_>) -> Result<Outcome> {
        let view = PacketView::new(accepted.packet)?;
        let extra = accepted.packet.len() - view.bytes().len();
        if extra > 0 {
            return Err(StoreError::Trailing { extra });
        }
        self.now = self.now.max(accepted.received);
        if accepted.door.brings_copies() {
            if self.archive.is_full_for(&view) {
                return Err(StoreError::Full { waiting: self.archive.waiting_bytes() });
            }
            if self.repeats.repeats(&view) {
                return Ok(Outcome::Duplicate);
            }
        }
        let appended = self.archive.append(&view, accepted.received, accepted.door, accepted.link)?;
        if appended && !accepted.door.brings_copies() && accepted.door != Door::Import {
            // What comes directly may come once more through a relay.
            self.repeats.repeats(&view);
        }
        Ok(if appended { Outcome::Recorded } else { Outcome::Duplicate })
    }

    /// Takes a packet of a log, unless the history knows that it came before `received`, which is the time at
    /// which the import began. Copies within one log are kept, as the log has them.
    pub(crate) fn accept_from_log(&mut self, view: &PacketView<'_>, received: UtcTime) -> Result<Outcome> {
        self.now = self.now.max(received);
        if self.history.arrival_of(view)?.is_some_and(|first_us| first_us != received.micros()) {
            return Ok(Outcome::Duplicate);
        }
        let appended = self.archive.append(view, received, Door::Import, None)?;
        Ok(if appended { Outcome::Recorded } else { Outcome::Duplicate })
    }

    /// The first of `count` times of arrival, from `now_us` on, that no import had before.
    pub(crate) fn reserve_arrivals(&mut self, now_us: i64, count: usize) -> Result<i64> {
        self.history.reserve_arrivals(now_us, count)
    }

    /// Puts everything accepted on disk and into the history.
    ///
    /// The archive comes first. When it cannot be written nothing of what waits is on disk, nothing is lost
    /// and a later commit can succeed. When the history cannot be written, that is told in
    /// [`Committed::history_behind`]: the packets are safe, and later commits bring the history up to date.
    ///
    /// # Errors
    /// When the archive cannot be written.
    pub fn commit(&mut self) -> Result<Committed> {
        let mut committed = self.sync()?;
        match self.index() {
            Ok(rows) => {
                committed.rows = rows;
                let rest = || "it reads what it missed from the archive".to_owned();
                committed.history_behind = self.behind.then(rest);
            }
            Err(error) => committed.history_behind = Some(error.to_string()),
        }
        Ok(committed)
    }

    /// The first half of a commit: everything accepted is on disk, and its numbers may be acknowledged.
    ///
    /// # Errors
    /// When the archive cannot be written; everything still waits.
    pub fn sync(&mut self) -> Result<Committed> {
        let (written, durable) = self.archive.sync()?;
        let mut told = std::mem::take(&mut self.untold);
        told.extend(durable);
        let mut committed = Committed { durable: told, ..Committed::default() };
        for one in &written {
            committed.packets += one.batch.packets;
            committed.bytes += one.batch.data.len() as u64;
        }
        if self.behind {
            // It is read from the archive in its turn.
            for one in written {
                self.archive.recycle(one.batch);
            }
        } else {
            self.unindexed.extend(written);
        }
        Ok(committed)
    }

    /// As [`Self::sync`], for work in between: what becomes durable by it is told by the next one.
    pub(crate) fn sync_quietly(&mut self) -> Result<()> {
        self.untold = self.sync()?.durable;
        Ok(())
    }

    /// The second half: the history follows; how many rows it gained.
    ///
    /// # Errors
    /// When the history cannot be written. The next call reads from the archive what is missing.
    pub fn index(&mut self) -> Result<u64> {
        if self.behind {
            let rows = self.catch_up()?;
            self.save_if_due()?;
            return Ok(rows);
        }
        let batches = std::mem::take(&mut self.unindexed);
        if batches.is_empty() {
            self.history.tick()?;
            self.idle_commits = self.idle_commits.saturating_add(1);
            if self.idle_commits == IDLE_COMMITS && self.unsaved_bytes > 0 {
                self.save()?;
            }
            return Ok(0);
        }
        self.idle_commits = 0;
        let mut rows = 0;
        for batch in batches {
            // One that fails leaves all later ones to be read from the archive.
            if !self.behind {
                match self.index_batch(&batch) {
                    Ok(added) => rows += added,
                    Err(error) => {
                        self.behind = true;
                        self.unindexed.clear();
                        return Err(error);
                    }
                }
            }
            self.archive.recycle(batch.batch);
        }
        self.history.tend(rows)?;
        self.save_if_due()?;
        Ok(rows)
    }

    /// Up to where the archive is durable, for those who [follow](crate::Tail) it.
    pub fn marks(&self) -> Marks {
        Marks(self.archive.marks().collect())
    }

    /// The highest number of a stream up to which nothing is missing on disk.
    pub fn durable(&self, stream: u64) -> Option<u64> {
        self.archive.streams.durable(stream)
    }

    /// Bytes of packets that wait for a commit.
    pub fn waiting_bytes(&self) -> usize {
        self.archive.waiting_bytes()
    }

    /// Whether the history lacks packets of the archive that a later [`Self::index`] has to read from there.
    pub fn is_behind(&self) -> bool {
        self.behind
    }

    /// Records, durably, that something is missing.
    ///
    /// # Errors
    /// When it cannot be written, or ends before it begins.
    pub fn declare_gap(&mut self, gap: &Gap) -> Result<()> {
        gaps::declare(self.archive.root(), gap)
    }

    /// Brings all roll-ups up to date and saves the progress, so that opening has nothing to read again.
    ///
    /// # Errors
    /// When the history cannot be written.
    pub fn settle(&mut self) -> Result<()> {
        self.history.roll_up_all()?;
        self.save()?;
        // What an import filled the caches with is not needed any more.
        self.history.close_months();
        Ok(())
    }

    /// Commits, saves the progress and closes. Dropping a store without is safe: opening it again then reads
    /// what came last from the archive once more.
    ///
    /// # Errors
    /// When something could not be written; what was committed before is safe.
    pub fn close(mut self) -> Result<()> {
        self.sync()?;
        self.index()?;
        if self.behind {
            return Ok(());
        }
        self.save()
    }

    /// Saves the progress and closes all files, but goes on keeping other writers away.
    pub(crate) fn close_keeping_lock(mut self) -> Result<FolderLock> {
        self.save()?;
        Ok(self.lock)
    }

    /// Forgets the days that are no longer there.
    pub(crate) fn forget_days(&mut self, before: &[DayKey]) -> Result<()> {
        let left = archive::days(self.archive.root())?;
        for key in before.iter().filter(|key| !left.contains(key)) {
            self.archive.forget(*key);
            self.history.set_progress(*key, Progress::default());
        }
        self.save()
    }

    /// Closes the history's months; they are opened again when needed.
    pub(crate) fn close_months(&mut self) {
        self.history.close_months();
    }

    /// Mends the days whose files are not as the history last saw them, and learns all their lengths. Whether
    /// one is shorter than the history knew it.
    fn mend_archive(&mut self) -> Result<bool> {
        let mut shorter = false;
        for key in archive::days(self.archive.root())? {
            let mut progress = self.history.progress(key);
            let folder = key.folder(self.archive.root());
            let length = |name: &str| fs::metadata(folder.join(name)).map_or(0, |file| file.len());
            let mut lengths = Lengths { data: length(DATA), arrivals: length(ARRIVALS) };
            if lengths != progress.lengths {
                let mended = archive::mend(self.archive.root(), key)?;
                lengths = mended.lengths;
                let name = key.name();
                let mut note = |count: u64, what: &str| {
                    if count > 0 {
                        self.repairs.notes.push(format!("archive/{name}: {count} {what}"));
                    }
                };
                note(mended.cut_bytes, "bytes of an unfinished packet cut off");
                note(mended.cut_records, "bytes of arrivals without packets cut off");
                note(mended.recovered, "packets without a record of arrival kept");
            }
            if progress.lengths.data > lengths.data || progress.lengths.arrivals > lengths.arrivals {
                let name = key.name();
                self.repairs.notes.push(format!("archive/{name}: shorter than when it was last read"));
                progress = Progress::default();
                self.history.set_progress(key, progress);
                shorter = true;
            }
            self.archive.know(key, lengths);
        }
        Ok(shorter)
    }

    /// Learns which numbers are surely on disk: from what was known when the progress was saved, and the records
    /// of arrival since; or, `from_scratch`, from all records. It comes before the replay, which saves what it
    /// has done as it goes on.
    fn recover_streams(&mut self, from_scratch: bool) -> Result<()> {
        if !from_scratch {
            self.archive.streams.start_from(self.history.streams()?);
        }
        let mut recovered = Recovered::default();
        for key in archive::days(self.archive.root())? {
            let read = if from_scratch { Lengths::default() } else { self.history.progress(key).lengths };
            if read != self.archive.lengths(key) {
                recovered.read(&key.folder(self.archive.root()), read.arrivals)?;
            }
        }
        let trimmed = archive::is_trimmed(self.archive.root());
        self.archive.streams.recover(&recovered, trimmed);
        Ok(())
    }

    /// Reads into the history all of the archive that is not there yet.
    fn replay(&mut self, progress: &mut dyn FnMut(u64) -> bool) -> Result<()> {
        for key in archive::days(self.archive.root())? {
            while let Some(chunk) = self.replay_chunk(key)? {
                self.repairs.replayed += chunk.packets;
                self.history.tend(chunk.packets)?;
                self.save_if_due()?;
                if !progress(self.repairs.replayed) {
                    return Err(StoreError::Cancelled);
                }
            }
        }
        Ok(())
    }

    /// Some more of what the history lacks, at most about one transaction; it is up to date when nothing is left.
    fn catch_up(&mut self) -> Result<u64> {
        let mut done = Chunk { packets: 0, rows: 0 };
        for key in archive::days(self.archive.root())? {
            if let Some(chunk) = self.replay_chunk(key)? {
                done = Chunk { packets: done.packets + chunk.packets, rows: done.rows + chunk.rows };
            }
            if done.packets >= REPLAY_PACKETS as u64 {
                self.history.tend(done.rows)?;
                return Ok(done.rows);
            }
        }
        self.behind = false;
        self.history.tend(done.rows)?;
        Ok(done.rows)
    }

    fn replay_chunk(&mut self, key: DayKey) -> Result<Option<Chunk>> {
        let mut progress = self.history.progress(key);
        if progress.lengths == self.archive.lengths(key) {
            return Ok(None);
        }
        let Lengths { data, arrivals } = progress.lengths;
        let mut reader = DayReader::open(self.archive.root(), key, data, arrivals)?;
        let mut bytes = Vec::new();
        let mut packets = Vec::new();
        while packets.len() < REPLAY_PACKETS {
            let Some(archived) = reader.next_packet()? else { break };
            packets.push((bytes.len(), archived.arrival.received.micros()));
            bytes.extend_from_slice(archived.view.bytes());
            progress.lengths = archived.end;
        }
        if packets.len() < REPLAY_PACKETS {
            progress.lengths = self.archive.lengths(key);
        }
        let arrived = packets.iter().filter_map(|(at, received_us)| {
            let view = PacketView::unchecked(&bytes[*at..]).ok()?;
            Some(Arrived { view, received_us: *received_us })
        });
        let (rows, extent) = self.history.write(arrived)?;
        self.advance(key, progress, extent, bytes.len());
        Ok(Some(Chunk { packets: packets.len() as u64, rows }))
    }

    fn index_batch(&mut self, written: &Written) -> Result<u64> {
        let (rows, extent) = self.history.write(archive::packets_of(written))?;
        let mut progress = self.history.progress(written.key);
        progress.lengths = written.lengths;
        self.advance(written.key, progress, extent, written.batch.data.len());
        Ok(rows)
    }

    fn advance(&mut self, key: DayKey, mut progress: Progress, extent: Extent, bytes: usize) {
        progress.extent.merge(extent);
        self.history.set_progress(key, progress);
        self.unsaved_bytes += bytes as u64;
    }

    fn save_if_due(&mut self) -> Result<()> {
        let due = self.unsaved_bytes >= SAVE_AFTER_BYTES || self.now - self.saved_at >= SAVE_AFTER_US;
        if due { self.save() } else { Ok(()) }
    }

    fn save(&mut self) -> Result<()> {
        let streams: Vec<LinkSeq> = self.archive.streams.all_durable().collect();
        self.history.save_progress(&streams)?;
        self.unsaved_bytes = 0;
        self.saved_at = self.now;
        Ok(())
    }
}

struct Chunk {
    packets: u64,
    rows: u64,
}

#[cfg(test)]
mod tests {
    #[test]
    fn writers_and_readers_can_be_handed_to_threads() {
        fn sent<T: Send + 'static>() {}
        sent::<super::Store>();
        sent::<crate::Reader>();
    }
}
