//! The spool: everything that is to reach the shore, kept on disk until it has.
//!
//! Packets get their numbers here. They are appended to files of about 1 MiB and passed to the kernel before they are sent;
//! a separate thread syncs them to disk. So a killed program loses nothing that was spooled, and a computer that loses
//! power loses what was spooled since the last sync: the sync interval plus the time of the sync. Numbers that may have
//! been used then are never used again; they are declared as a gap. Packets that a killed program had not spooled yet are
//! declared too, from its last packet to the next start; one number represents them, as their count is unknown.
//!
//! Its size is limited. When full, the oldest file that is complete loses its telemetry; if none is, the oldest loses the
//! rest. Removed packets are declared as a gap, in their place. Write errors are handled likewise: packets that could not
//! be written use numbers, and the gap is written as soon as the disk works again.

mod identity;
mod read;
mod segment;
mod thin;

#[cfg(test)]
mod tests;

pub(crate) use identity::random;
pub(super) use identity::write_whole;

use crate::disk::DataLock;
use anyhow::Context as _;
use identity::{Identity, sync_folder};
use link::{Gap, GapReason, SpoolState};
use read::Place;
use segment::{HEADER_BYTES, Header, Level};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use units::UtcTime;

/// Most entries that are not synced; further ones wait.
const MOST_UNSYNCED: u64 = 100_000;
/// Numbers skipped after a power loss: more than can have been used since the last sync.
const LEFT_OUT: u64 = 2 * MOST_UNSYNCED;
/// A number with twenty digits.
const NAME_DIGITS: usize = 20;

/// Bounds of a spool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    /// Bytes of all files.
    pub(crate) bytes: u64,
    /// A file that reached so many is closed.
    pub(crate) file_bytes: u64,
}

impl Bounds {
    /// Bounds for so many bytes.
    pub(crate) fn of(bytes: u64) -> Self {
        Self { bytes, file_bytes: (bytes / 16).clamp(4 << 10, 1 << 20) }
    }
}

/// The spool.
#[derive(Debug)]
pub(crate) struct Spool {
    folder: PathBuf,
    bounds: Bounds,
    identity: Identity,
    /// By the number of their first entry.
    files: BTreeMap<u64, Info>,
    active: Active,
    /// The number of the next packet.
    next: u64,
    /// The number after the last entry passed to the kernel.
    written: u64,
    /// The number after the last entry synced to disk.
    synced: u64,
    /// Entries from `written` on.
    buffer: Vec<u8>,
    /// Numbers below `next` that could not be written and whose gap is still to be declared.
    lost: Option<Gap>,
    /// Files, and the folder, that were closed or changed since the last sync.
    closed: Vec<Arc<File>>,
    place: Option<Place>,
    /// Packets thinned out so far.
    thinned: u64,
    _lock: DataLock,
}

#[derive(Debug, Clone, Copy)]
struct Info {
    level: Level,
    bytes: u64,
}

/// The file that is appended to; it has the greatest numbers.
#[derive(Debug)]
struct Active {
    first: u64,
    file: Arc<File>,
    bytes: u64,
    /// A partial write could not be truncated: nothing may be appended.
    is_torn: bool,
}

impl Spool {
    /// Opens the spool in a folder, or makes one. Returns remarks about repairs.
    ///
    /// # Errors
    /// When another program uses it ([`InUse`](crate::disk::InUse)), or on a disk error.
    pub(crate) fn open(folder: &Path, bounds: Bounds, now: UtcTime) -> anyhow::Result<(Self, Vec<String>)> {
        Self::open_after(folder, bounds, now, &identity::boot())
    }

    fn open_after(
        folder: &Path,
        bounds: Bounds,
        now: UtcTime,
        boot: &str,
    ) -> anyhow::Result<(Self, Vec<String>)> {
        read::refuse_newer(folder)?;
        let lock = DataLock::take(folder)?;
        let mut remarks = Vec::new();
        let found = read::Found::look(folder, &mut remarks)?;
        let mut identity = if let Some(identity) = Identity::load(folder) {
            identity
        } else {
            if !found.files.is_empty() {
                remarks.push("the spool had lost its identity: what is in it is sent again".to_owned());
            }
            Identity { boot: boot.to_owned(), ..Identity::fresh(0)? }
        };
        let gap = (!identity.clean && identity.starts > 0).then(|| {
            let is_same_boot = identity.boot == boot;
            let (numbers, reason) =
                if is_same_boot { (1, GapReason::Killed) } else { (LEFT_OUT, GapReason::PowerLost) };
            let (from, to) = (found.next, found.next + numbers);
            // If the clock was set back meanwhile, the gap has no duration.
            Gap { from, to, since: found.last_recorded.min(now), until: now, reason }
        });
        if let Some(gap) = gap {
            let what =
                if gap.reason == GapReason::Killed { "the program was killed" } else { "power was lost" };
            remarks.push(format!("{what}; packets of the last moment are missing from {} on", gap.from));
        }
        let next = gap.map_or(found.next, |gap| gap.to);
        identity.starts += 1;
        (identity.boot, identity.clean) = (boot.to_owned(), false);
        identity.save(folder)?;
        let mut files = found.files;
        let first = found.next;
        let active =
            create(folder, first).with_context(|| format!("making a file in {}", folder.display()))?;
        files.insert(first, Info { level: Level::Whole, bytes: active.bytes });
        let mut spool = Self {
            folder: folder.to_owned(),
            bounds,
            identity,
            files,
            active,
            next,
            written: first,
            synced: first,
            buffer: Vec::new(),
            lost: gap,
            closed: Vec::new(),
            place: None,
            thinned: 0,
            _lock: lock,
        };
        spool.write().with_context(|| format!("writing into {}", folder.display()))?;
        spool
            .sync_now()
            .and_then(|()| sync_folder(folder))
            .with_context(|| format!("syncing {}", folder.display()))?;
        Ok((spool, remarks))
    }

    /// State of the spool, for the link.
    pub(crate) fn state(&self) -> SpoolState {
        let first = self.files.first_key_value().map_or(self.written, |(first, _)| *first);
        SpoolState { stream: self.identity.stream, first, next: self.written }
    }

    /// Starts of the program with this spool.
    pub(crate) fn starts(&self) -> u64 {
        self.identity.starts
    }

    /// Packets thinned out since the start.
    pub(crate) fn thinned(&self) -> u64 {
        self.thinned
    }

    /// Bytes of all files.
    pub(crate) fn bytes(&self) -> u64 {
        self.files.values().map(|info| info.bytes).sum()
    }

    /// Buffers a packet; [`Spool::write`] passes it to the kernel.
    pub(crate) fn append(&mut self, recorded: UtcTime, packet: &[u8], important: bool) {
        self.put_lost();
        segment::put_record(&mut self.buffer, self.next, recorded, packet, important);
        self.next += 1;
    }

    /// Declares `count` packets that were lost before the spool.
    pub(crate) fn missed(&mut self, count: u64, since: UtcTime, until: UtcTime) {
        if count > 0 {
            let (from, reason) = (self.next, GapReason::NotRecorded);
            self.lose(Gap { from, to: from + count, since, until, reason });
            self.next += count;
        }
    }

    /// Passes the buffer to the kernel.
    ///
    /// # Errors
    /// On a disk error: the packets are lost, and declared as soon as the disk works again.
    pub(crate) fn write(&mut self) -> io::Result<()> {
        self.put_lost();
        if self.buffer.is_empty() {
            return Ok(());
        }
        let begun = if self.active.is_torn { self.roll() } else { Ok(()) };
        if let Err(error) = begun.and_then(|()| (&*self.active.file).write_all(&self.buffer)) {
            self.give_up_buffer();
            return Err(error);
        }
        self.active.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        self.written = self.next;
        self.files.insert(self.active.first, Info { level: Level::Whole, bytes: self.active.bytes });
        if self.written - self.synced > MOST_UNSYNCED {
            self.sync_now()?;
        }
        if self.active.bytes >= self.bounds.file_bytes {
            self.roll()?;
        }
        if self.bytes() > self.bounds.bytes {
            self.thin()?;
        }
        Ok(())
    }

    /// Drops a buffer that could not be written; a partial write is truncated.
    fn give_up_buffer(&mut self) {
        let bytes = std::mem::take(&mut self.buffer).into();
        let (mut since, mut until) = (None, None);
        let mut rest: bytes::Bytes = bytes;
        while let Some((item, length)) = segment::take(&rest) {
            rest = rest.slice(length..);
            let (from, to) = match item {
                segment::Item::Record(record, _) => (record.recorded, record.recorded),
                segment::Item::Gap(gap) => (gap.since, gap.until),
            };
            since = Some(since.map_or(from, |time: UtcTime| time.min(from)));
            until = Some(until.map_or(to, |time: UtcTime| time.max(to)));
        }
        let (since, until) = (since.unwrap_or_default(), until.unwrap_or_default());
        self.active.is_torn = self.active.file.set_len(self.active.bytes).is_err();
        let (from, to, reason) = (self.written, self.next, GapReason::NotRecorded);
        self.lost = Some(Gap { from, to, since, until, reason });
    }

    /// Extends the lost range; it follows earlier losses or the buffer.
    fn lose(&mut self, gap: Gap) {
        match &mut self.lost {
            Some(lost) if lost.to == gap.from && lost.reason == gap.reason => {
                (lost.to, lost.until) = (gap.to, gap.until);
            }
            _ => {
                self.put_lost();
                self.lost = Some(gap);
            }
        }
    }

    fn put_lost(&mut self) {
        if let Some(gap) = self.lost.take() {
            segment::put_gap(&mut self.buffer, &gap);
        }
    }

    /// Closes the active file and begins another.
    fn roll(&mut self) -> io::Result<()> {
        let active = create(&self.folder, self.written)?;
        self.files.insert(active.first, Info { level: Level::Whole, bytes: active.bytes });
        let before = std::mem::replace(&mut self.active, active);
        self.closed.push(before.file);
        // The new file's name must be synced too.
        self.closed.push(Arc::new(File::open(&self.folder)?));
        Ok(())
    }

    /// Files that are not synced, and the number up to which everything is on disk once they are.
    pub(crate) fn unsynced(&mut self) -> Option<(Vec<Arc<File>>, u64)> {
        self.is_unsynced().then(|| {
            let mut files = std::mem::take(&mut self.closed);
            files.push(Arc::clone(&self.active.file));
            (files, self.written)
        })
    }

    /// Whether anything is not synced.
    pub(crate) fn is_unsynced(&self) -> bool {
        self.synced < self.written
    }

    /// Notes that everything below this number is on disk.
    pub(crate) fn synced(&mut self, next: u64) {
        self.synced = self.synced.max(next);
    }

    fn sync_now(&mut self) -> io::Result<()> {
        if let Some((files, next)) = self.unsynced() {
            files.iter().try_for_each(|file| file.sync_data())?;
            self.synced(next);
        }
        Ok(())
    }

    /// Notes that everything below this number is ashore: files without other entries are removed.
    pub(crate) fn acknowledged(&mut self, next: u64) {
        while let Some((first, end)) = self.oldest() {
            if end > next {
                return;
            }
            fs::remove_file(path(&self.folder, first)).ok();
            self.files.remove(&first);
        }
    }

    /// The oldest file but the active one, and the number after it.
    fn oldest(&self) -> Option<(u64, u64)> {
        let mut firsts = self.files.keys();
        Some((*firsts.next()?, *firsts.next()?))
    }

    /// Begins a new stream: the shore has numbers of this one that the disk has lost.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn renumber(&mut self) -> anyhow::Result<()> {
        self.identity.stream = random()?;
        self.identity.save(&self.folder)
    }

    /// Syncs everything to disk at the end of the program.
    ///
    /// # Errors
    /// On a disk error.
    pub(crate) fn close(mut self) -> anyhow::Result<()> {
        self.write()?;
        self.sync_now()?;
        self.identity.clean = true;
        self.identity.save(&self.folder)
    }
}

/// Makes a file; one of the same name has no entries and is started over.
fn create(folder: &Path, first: u64) -> io::Result<Active> {
    let path = path(folder, first);
    let mut file = OpenOptions::new().create(true).append(true).open(&path)?;
    let header = Header { level: Level::Whole, first, end: None }.to_bytes();
    // A full disk may take the name alone: the file before it is written on then.
    file.set_len(0).and_then(|()| file.write_all(&header)).inspect_err(|_| {
        fs::remove_file(&path).ok();
    })?;
    Ok(Active { first, file: Arc::new(file), bytes: HEADER_BYTES as u64, is_torn: false })
}

fn path(folder: &Path, first: u64) -> PathBuf {
    folder.join(format!("{first:0NAME_DIGITS$}.spool"))
}
