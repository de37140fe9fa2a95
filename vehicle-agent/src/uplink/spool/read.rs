//! Reading the spool: its state at a start, and entries by number.

use super::segment::{self, HEADER_BYTES, Header, Item, Level, MOST_ENTRY_BYTES};
use super::{Info, NAME_DIGITS, Spool, path};
use anyhow::Context as _;
use bytes::Bytes;
use link::{Entry, Gap, GapReason};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::time::UNIX_EPOCH;
use units::UtcTime;

/// Read at once at least.
const LEAST_CHUNK_BYTES: usize = 8 << 10;

/// Contents of a folder.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) files: BTreeMap<u64, Info>,
    /// The number after the last entry.
    pub(super) next: u64,
    /// When the last entry was recorded; of a file without any, when it was begun.
    pub(super) last_recorded: UtcTime,
}

impl Found {
    /// Reads a folder, truncates a torn file and removes files without entries and remainders of a thinning.
    pub(super) fn look(folder: &Path, remarks: &mut Vec<String>) -> anyhow::Result<Self> {
        let mut files = BTreeMap::new();
        let (mut covered, mut begun, mut begun_at) = (0, 0, UtcTime::default());
        for first in names(folder)? {
            let path = path(folder, first);
            let (bytes, header) = head(&path).with_context(|| format!("reading {}", path.display()))?;
            // It was merged into the previous file, which was replaced; only this removal was left.
            if first < covered {
                fs::remove_file(&path).ok();
                continue;
            }
            // It was begun when the last entry of the file before it was written, or was to be begun on a full disk: that file
            // may have gone on.
            // The first file hides nothing: what it lost is read as damage.
            if bytes <= HEADER_BYTES as u64 && !files.is_empty() {
                (begun, begun_at) = (first, changed(&path)?);
                fs::remove_file(&path)?;
                continue;
            }
            let header = header.filter(|header| header.first == first);
            covered = covered.max(header.and_then(|header| header.end).unwrap_or(0));
            // A file without a header is treated as damaged when read.
            let level = header.map_or(Level::Whole, |header| header.level);
            files.insert(first, Info { level, bytes });
        }
        let mut found = Self { files, next: covered.max(begun), last_recorded: begun_at };
        if let Some((first, _)) = found.files.last_key_value() {
            found.mend_last(folder, *first, remarks)?;
        }
        found.last_recorded = found.last_recorded.max(begun_at);
        Ok(found)
    }

    /// Finds the end of the last file. A file without entries is removed: another begins with its number.
    fn mend_last(&mut self, folder: &Path, first: u64, remarks: &mut Vec<String>) -> anyhow::Result<()> {
        let path = path(folder, first);
        let bytes = Bytes::from(fs::read(&path).with_context(|| format!("reading {}", path.display()))?);
        let mut at = if Header::from_bytes(&bytes).is_some() { HEADER_BYTES } else { bytes.len() };
        let mut next = first;
        // It was made when the last entry of the previous file was written.
        self.last_recorded = changed(&path)?;
        while let Some((item, length)) = segment::take(&bytes.slice(at..)) {
            self.last_recorded = match &item {
                Item::Record(record, _) => record.recorded,
                Item::Gap(gap) if gap.until > UtcTime::default() => gap.until,
                // The time of damaged entries is unknown.
                Item::Gap(_) => self.last_recorded,
            };
            (next, at) = (item.end(), at + length);
        }
        if at < bytes.len() {
            remarks.push(format!("{} torn bytes were cut off the end of the spool", bytes.len() - at));
            let file = OpenOptions::new().write(true).open(&path)?;
            file.set_len(at as u64)?;
        }
        self.next = self.next.max(next);
        if next == first {
            fs::remove_file(&path)?;
            self.files.remove(&first);
        } else {
            self.files.insert(first, Info { bytes: at as u64, ..self.files[&first] });
        }
        Ok(())
    }
}

/// Refuses a spool of a later version: its data would be taken for damage here, and removed. Writes nothing.
pub(super) fn refuse_newer(folder: &Path) -> anyhow::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_none_or(|end| end != "spool") {
            continue;
        }
        let mut begin = Vec::with_capacity(HEADER_BYTES);
        let file = File::open(&path).with_context(|| format!("reading {}", path.display()))?;
        file.take(HEADER_BYTES as u64).read_to_end(&mut begin)?;
        anyhow::ensure!(
            !segment::is_newer(&begin),
            "{} was written by a later lutra-agent: nothing was changed. Install that version again until the shore has all \
             of the spool, then this one",
            path.display()
        );
    }
    Ok(())
}

/// When a file was last written to.
fn changed(path: &Path) -> io::Result<UtcTime> {
    let since = fs::metadata(path)?.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok(UtcTime::from_micros(since.as_micros() as i64))
}

fn names(folder: &Path) -> io::Result<Vec<u64>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let Some(name) = name.to_str() else { continue };
        if let Some(digits) = name.strip_suffix(".spool").filter(|digits| digits.len() == NAME_DIGITS) {
            names.extend(digits.parse::<u64>());
        } else if Path::new(name).extension().is_some_and(|extension| extension == "tmp") {
            fs::remove_file(folder.join(name))?;
        }
    }
    names.sort_unstable();
    Ok(names)
}

fn head(path: &Path) -> io::Result<(u64, Option<Header>)> {
    let mut file = File::open(path)?;
    let mut bytes = Vec::with_capacity(HEADER_BYTES);
    file.by_ref().take(HEADER_BYTES as u64).read_to_end(&mut bytes)?;
    Ok((file.metadata()?.len(), Header::from_bytes(&bytes)))
}

/// Where the last reading ended, so that the next continues there.
#[derive(Debug)]
pub(super) struct Place {
    first: u64,
    file: File,
    seq: u64,
    offset: u64,
}

impl Spool {
    /// The entries from this number on, from one file and about `most_bytes` long. Empty if there are none, or the disk
    /// cannot be read now.
    pub(crate) fn read(&mut self, from: u64, most_bytes: usize) -> Vec<Entry> {
        if from >= self.written {
            return Vec::new();
        }
        let Some(first) = self.files.range(..=from).next_back().map(|(first, _)| *first) else {
            let to = self.state().first;
            let time = UtcTime::default();
            let reason = GapReason::AcknowledgedBefore;
            return vec![Entry::Gap(Gap { from, to, since: time, until: time, reason })];
        };
        let end = self.files.range(from + 1..).next().map_or(self.written, |(next, _)| *next);
        match self.read_file(first, from, most_bytes) {
            Ok(entries) if !entries.is_empty() => entries,
            Err(error) if error.kind() != io::ErrorKind::NotFound => Vec::new(),
            Ok(_) | Err(_) => {
                self.place = None;
                let time = UtcTime::default();
                let reason = GapReason::Damaged;
                vec![Entry::Gap(Gap { from, to: end, since: time, until: time, reason })]
            }
        }
    }

    /// The whole entries of a file that end after `from`, up to damage or its end.
    fn read_file(&mut self, first: u64, from: u64, most_bytes: usize) -> io::Result<Vec<Entry>> {
        let mut place = match self.place.take() {
            Some(place) if place.first == first && place.seq == from => place,
            _ => {
                let (seq, offset) = (first, HEADER_BYTES as u64);
                Place { first, file: File::open(path(&self.folder, first))?, seq, offset }
            }
        };
        let mut entries = Vec::new();
        let mut taken = 0;
        let mut chunk = most_bytes.max(LEAST_CHUNK_BYTES) as u64;
        loop {
            place.file.seek(SeekFrom::Start(place.offset))?;
            let mut bytes = Vec::new();
            place.file.by_ref().take(chunk).read_to_end(&mut bytes)?;
            let is_all = (bytes.len() as u64) < chunk;
            let bytes = Bytes::from(bytes);
            let mut at = 0;
            while let Some((item, length)) = segment::take(&bytes.slice(at..)) {
                at += length;
                place.seq = item.end();
                if place.seq > from {
                    taken += length;
                    entries.push(match item {
                        Item::Record(record, _) => Entry::Record(record),
                        Item::Gap(gap) => Entry::Gap(gap),
                    });
                    if taken >= most_bytes {
                        break;
                    }
                }
            }
            place.offset += at as u64;
            if !entries.is_empty() || (at == 0 && (is_all || chunk > MOST_ENTRY_BYTES as u64)) {
                break;
            }
            if at == 0 {
                // An entry larger than the chunk, or damage; the largest entry fits the next.
                chunk = MOST_ENTRY_BYTES as u64 + 1;
            }
        }
        self.place = Some(place);
        Ok(entries)
    }
}
