//! The store, open for writing: it accepts packets, commits them, and updates the history.

use crate::archive::{self, ARRIVALS, DATA, bytes, shortened};
use crate::archive::{Archive, DayKey, Disk, Lengths, RealDisk, Recovered};
use crate::error::{Named as _, Result, StoreError};
use crate::fingerprint::RepeatWindow;
use crate::follow::Follower;
use crate::gaps::{Gap, Gaps};
use crate::history::{History, MonthKey};
use crate::layout::{GROWING, HISTORY, finish_swap};
use crate::lock::FolderLock;
use crate::packet::{Accepted, Committed, Outcome, Repairs};
use crate::tail::Marks;
use imc::PacketView;
use link::{LinkSeq, Transport};
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Packets of the archive that are read into the history before a server starts up: what a crash leaves unread.
const AT_ONCE_PACKETS: u64 = 20_000;

/// The store of one data folder.
///
/// There is one writer for each folder; readers of the history ([`crate::Reader`]) need no writer and do not
/// disturb it. Nothing is on disk before a commit says so. At most 64 MiB wait for a commit: then
/// [`Store::accept`] refuses, and the caller must hold packets back.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    archive: Archive,
    follower: Follower,
    gaps: Gaps,
    repeats: RepeatWindow,
    /// Durable records that were not reported yet.
    untold: Vec<LinkSeq>,
    now: UtcTime,
    repairs: Repairs,
    lock: FolderLock,
}

impl Store {
    /// Opens the store in a folder, making it if need be, repairs the effects of a crash and reads into the history
    /// what is not there yet. A history that cannot be written is not an error: it is [behind](Self::behind).
    ///
    /// # Errors
    /// When another process has it open, or files of the archive cannot be read or written.
    pub fn open(folder: &Path) -> Result<Self> {
        Self::open_with(folder, &mut |_| true)
    }

    /// As [`Self::open`], but reads into the history only what a crash leaves unread. What it lacks beyond that,
    /// such as a month that was damaged, is read with each [`Self::index`].
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_at_once(folder: &Path) -> Result<Self> {
        let mut enough = |packets| packets < AT_ONCE_PACKETS;
        let mut store = Self::open_archive(folder, HISTORY, Box::new(RealDisk))?;
        match store.replay(&mut enough) {
            Err(StoreError::Cancelled) => {}
            other => other?,
        }
        store.save().ok();
        Ok(store)
    }

    /// As [`Self::open`]; `progress` gets the number of packets read into the history and may stop that by
    /// returning false.
    ///
    /// # Errors
    /// As [`Self::open`], and [`StoreError::Cancelled`].
    pub fn open_with(folder: &Path, progress: &mut dyn FnMut(u64) -> bool) -> Result<Self> {
        Self::open_on(folder, Box::new(RealDisk), progress)
    }

    /// Opens the archive with a history that is built, whole, beside the one in use.
    pub(crate) fn open_growing(folder: &Path, progress: &mut dyn FnMut(u64) -> bool) -> Result<Self> {
        let mut store = Self::open_in(folder, GROWING, Box::new(RealDisk), progress)?;
        while store.is_behind() {
            store.index()?;
        }
        Ok(store)
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
        let mut store = Self::open_archive(folder, history, disk)?;
        store.replay(progress)?;
        // Progress that cannot be saved is read again next time.
        store.save().ok();
        Ok(store)
    }

    fn open_archive(folder: &Path, history: &str, disk: Box<dyn Disk>) -> Result<Self> {
        let root = folder.join("archive");
        archive::format::refuse_newer(&root)?;
        fs::create_dir_all(&root).named(&root)?;
        let lock = FolderLock::take(folder)?;
        archive::format::note(&root)?;
        finish_swap(folder)?;
        archive::sweep_packing(&root)?;
        let mut store = Self {
            folder: folder.to_owned(),
            gaps: Gaps::open(&root)?,
            archive: Archive::new(root, disk),
            follower: Follower::open(folder.join(history)),
            repeats: RepeatWindow::new(),
            untold: Vec::new(),
            now: UtcTime::default(),
            repairs: Repairs::default(),
            lock,
        };
        store.mend_archive()?;
        let shorter = store.follower.compare(&store.archive)?;
        store.recover_streams(shorter)?;
        store.repairs.notes.extend(store.follower.causes());
        store.repairs.notes.extend(shortened::told(shortened::written(store.archive.root())?));
        Ok(store)
    }

    /// Findings and repairs of opening it.
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
        self.take(&PacketView::new(accepted.packet)?, accepted)
    }

    /// As [`Store::accept`], for bytes whose checksum the caller has found to be right.
    ///
    /// # Errors
    /// As those of [`Store::accept`], but for the checksum.
    pub fn accept_checked(&mut self, accepted: &Accepted<'_>) -> Result<Outcome> {
        self.take(&PacketView::unchecked(accepted.packet)?, accepted)
    }

    fn take(&mut self, view: &PacketView<'_>, accepted: &Accepted<'_>) -> Result<Outcome> {
        let extra = accepted.packet.len() - view.bytes().len();
        if extra > 0 {
            return Err(StoreError::Trailing { extra });
        }
        self.now = self.now.max(accepted.received);
        if accepted.transport.brings_copies() {
            if self.archive.is_full_for(view) {
                return Err(StoreError::Full { waiting: self.archive.waiting_bytes() });
            }
            if self.repeats.repeats(view) {
                return Ok(Outcome::Duplicate);
            }
        }
        let appended = self.archive.append(view, accepted.received, accepted.transport, accepted.link)?;
        if appended && !accepted.transport.brings_copies() && accepted.transport != Transport::Import {
            // A direct packet may come once more through a relay.
            self.repeats.repeats(view);
        }
        if let Some(link) = accepted.link.filter(|_| appended) {
            self.gaps.revoke(link, view.header().time());
        }
        Ok(if appended { Outcome::Recorded } else { Outcome::Duplicate })
    }

    /// Takes a packet of a log, unless the history knows that it came before `received`, which is the time at
    /// which the import began. Copies within one log are kept, as the log has them.
    ///
    /// # Errors
    /// When the history cannot be read, or the archive takes no more; [`StoreError::Behind`] when the history was found damaged, and
    /// must be made whole before the same packet is given again.
    pub(crate) fn accept_from_log(&mut self, view: &PacketView<'_>, received: UtcTime) -> Result<Outcome> {
        self.now = self.now.max(received);
        let first_us = loop {
            match self.follower.history()?.arrival_of(view) {
                // What was damaged must be known again, or its packets would be taken twice.
                Err(error) if self.mend(&error)? => {
                    if let Some(why) = self.behind() {
                        return Err(StoreError::Behind(why));
                    }
                }
                other => break other?,
            }
        };
        if first_us.is_some_and(|first_us| first_us != received.micros()) {
            return Ok(Outcome::Duplicate);
        }
        let appended = self.archive.append(view, received, Transport::Import, None)?;
        Ok(if appended { Outcome::Recorded } else { Outcome::Duplicate })
    }

    /// Mends the history where an error says that it is damaged; false for other errors. What is damaged is moved out of the way, a
    /// chunk of a compressed month alone, and what the archive has of it is read again.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn mend(&mut self, error: &StoreError) -> Result<bool> {
        self.follower.mend(error, &self.archive)
    }

    /// The first of `count` times of arrival, from `now_us` on, that no import had before.
    pub(crate) fn reserve_arrivals(&mut self, now_us: i64, count: usize) -> Result<i64> {
        self.follower.history()?.reserve_arrivals(now_us, count)
    }

    /// Puts everything accepted on disk and into the history.
    ///
    /// The archive comes first. When it cannot be written nothing of what waits is on disk, nothing is lost
    /// and a later commit can succeed. When the history cannot be written, that is reported in
    /// [`Committed::history_behind`]: the packets are safe, and later commits bring the history up to date.
    ///
    /// # Errors
    /// When the archive cannot be written.
    pub fn commit(&mut self) -> Result<Committed> {
        let mut committed = self.sync()?;
        match self.index() {
            Ok(rows) => {
                committed.rows = rows;
                committed.history_behind = self.behind();
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
        self.follower.take(written, &mut self.archive);
        self.gaps.save();
        Ok(committed)
    }

    /// As [`Self::sync`], for work in between: what becomes durable by it is reported by the next one.
    pub(crate) fn sync_quietly(&mut self) -> Result<()> {
        self.untold = self.sync()?.durable;
        Ok(())
    }

    /// The second half: updates the history; returns the rows it gained. Of what it [lacks](Self::behind) it reads a
    /// slice, so that the recording of packets in between is not delayed.
    ///
    /// # Errors
    /// When the history cannot be written. Later calls read from the archive what is missing.
    pub fn index(&mut self) -> Result<u64> {
        self.follower.index(&mut self.archive, self.now)
    }

    /// Why the history lacks packets of the archive, and how far it is with them; `None` while it lacks nothing.
    pub fn behind(&self) -> Option<String> {
        self.follower.why_behind(&self.archive)
    }

    /// Whether the history lacks packets of the archive that a later [`Self::index`] has to read from there.
    pub fn is_behind(&self) -> bool {
        self.follower.is_behind()
    }

    /// Up to where the archive is durable, for [followers](crate::Tail).
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

    /// Records, durably, that something is missing. Adjacent gaps are merged; for a system and a day so many are kept
    /// apart, and more are merged into the nearest. Records that come for its numbers revoke it.
    ///
    /// # Errors
    /// When it cannot be written, or ends before it begins.
    pub fn declare_gap(&mut self, gap: &Gap) -> Result<()> {
        self.gaps.declare(gap.clone())
    }

    /// Brings the history up to date with all roll-ups and saves the progress, so that opening has nothing to read
    /// again.
    ///
    /// # Errors
    /// When the history cannot be written.
    pub fn settle(&mut self) -> Result<()> {
        loop {
            while self.is_behind() {
                self.index()?;
            }
            match self.follower.history()?.roll_up_all() {
                Err(error) if self.mend(&error)? => {}
                other => break other?,
            }
        }
        self.save()?;
        // The caches as filled by an import are not needed any more.
        self.close_months()
    }

    /// Commits, saves the progress and closes. Dropping a store without is safe: opening it again then reads
    /// what came last from the archive once more.
    ///
    /// # Errors
    /// When something could not be written; what was committed before is safe.
    pub fn close(mut self) -> Result<()> {
        self.sync()?;
        if self.is_behind() {
            // The next start reads on from here.
            self.index().ok();
            return self.save();
        }
        self.index()?;
        self.save()
    }

    /// Saves the progress and closes all files, but keeps the writer's lock.
    pub(crate) fn close_keeping_lock(mut self) -> Result<FolderLock> {
        self.save()?;
        Ok(self.lock)
    }

    /// Drops days and months, before their files are removed.
    pub(crate) fn give_up(&mut self, days: &[DayKey], months: &[MonthKey]) -> Result<()> {
        self.follower.unread(days)?;
        self.save()?;
        months.iter().try_for_each(|key| self.follower.history()?.forget_month(*key))?;
        self.follower.history()?.forget_gone();
        self.save()
    }

    /// Forgets days that are no longer there.
    pub(crate) fn forget_days(&mut self, days: &[DayKey]) {
        for key in days {
            self.archive.forget(*key);
        }
    }

    /// The history, if it can be written.
    pub(crate) fn history(&mut self) -> Result<&mut History> {
        self.follower.history()
    }

    /// The archive.
    pub(crate) fn archive_mut(&mut self) -> &mut Archive {
        &mut self.archive
    }

    /// Closes the history's months; they are opened again when needed.
    pub(crate) fn close_months(&mut self) -> Result<()> {
        self.follower.history()?.close_months();
        Ok(())
    }

    /// Repairs the days whose files differ from what the history last saw, and reads all their lengths.
    fn mend_archive(&mut self) -> Result<()> {
        for key in archive::days(self.archive.root())? {
            let folder = key.folder(self.archive.root());
            if bytes::is_packed(&folder) {
                self.know_packed(key, &folder);
                continue;
            }
            let length = |name: &str| fs::metadata(folder.join(name)).map_or(0, |file| file.len());
            let mut lengths = Lengths { data: length(DATA), arrivals: length(ARRIVALS) };
            if lengths != self.follower.progress(key).lengths {
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
            self.archive.know(key, lengths);
        }
        Ok(())
    }

    /// A compressed day, which no crash shortens: neither form of it is mended, and nothing is added. Of a file that cannot be
    /// read now the length counts that the history last saw: one bad sector must neither stop the server nor make it forget
    /// what it has.
    fn know_packed(&mut self, key: DayKey, folder: &Path) {
        let seen = self.follower.progress(key).lengths;
        let length = |name: &str, seen: u64| match bytes::plain_bytes(folder, name) {
            Ok(bytes) => bytes.unwrap_or(0),
            Err(_) => seen,
        };
        let lengths = Lengths { data: length(DATA, seen.data), arrivals: length(ARRIVALS, seen.arrivals) };
        for found in bytes::findings(folder) {
            self.repairs.notes.push(format!("archive/{}/{found}", key.name()));
        }
        self.archive.know(key, lengths);
        self.archive.close(key, lengths);
    }

    /// Finds which numbers are durable: from what was known when the progress was saved, and the records
    /// of arrival since; or, `from_scratch`, from all records. It comes before the replay, which saves what it
    /// has done as it goes on.
    fn recover_streams(&mut self, from_scratch: bool) -> Result<()> {
        let from_scratch = from_scratch || self.follower.knows_nothing();
        if !from_scratch {
            self.archive.streams.start_from(self.follower.streams()?);
        }
        let mut recovered = Recovered::default();
        for key in archive::days(self.archive.root())? {
            let read = if from_scratch { Lengths::default() } else { self.follower.progress(key).lengths };
            if read != self.archive.lengths(key) {
                let folder = key.folder(self.archive.root());
                match recovered.read(&folder, read.arrivals) {
                    // A start does not fail for it; what follows on such a stream is sent again.
                    Err(error) if bytes::is_packed(&folder) => self.repairs.notes.push(error.to_string()),
                    other => other?,
                }
            }
        }
        let trimmed = archive::is_trimmed(self.archive.root());
        self.archive.streams.recover(&recovered, trimmed);
        Ok(())
    }

    /// Reads into the history the part of the archive that it lacks. One that cannot be written stays behind.
    fn replay(&mut self, progress: &mut dyn FnMut(u64) -> bool) -> Result<()> {
        while self.is_behind() {
            match self.follower.replay_some(&self.archive, self.now) {
                Ok(chunk) => self.repairs.replayed += chunk.packets,
                Err(error) => {
                    self.repairs.notes.push(format!("the history is behind the archive: {error}"));
                    return Ok(());
                }
            }
            if !progress(self.repairs.replayed) {
                return Err(StoreError::Cancelled);
            }
        }
        Ok(())
    }

    fn save(&mut self) -> Result<()> {
        self.follower.save(&self.archive, self.now)
    }
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
