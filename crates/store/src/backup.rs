//! The files of a data folder that a backup holds, how each of them changes, and the time that it covers.
//!
//! The files come in the order in which a backup must copy them while the writer runs. Databases come before the archive,
//! and the catalogue before the months, so that the copy's history is never ahead of what it says it has read; opening
//! the copy reads the difference. Of a day packets come before their records: a record without its packet is cut off when
//! the copy is opened, while a packet without its record would have lost its number.

use crate::archive::{self, ARRIVAL_BYTES, ARRIVALS, DATA, DayKey, Record, Records, bytes, packed_name};
use crate::error::{Named as _, Result, StoreError};
use crate::history::{self, CATALOGUE};
use imc::Address;
use rusqlite::Connection;
use rusqlite::backup::{Backup, StepResult};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Pages that are copied between two checks for cancellation.
const PAGES: i32 = 1_000;
/// Files of the archive beside its days.
const BESIDE_DAYS: [&str; 3] = ["gaps.jsonl", archive::shortened::SHORTENED, archive::TRIMMED];

/// How a file changes while a server runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changes {
    /// A database, to be copied by [`copy_database`].
    Database,
    /// It only ever grows; `now` as long as its day is the newest.
    Grows {
        /// Whether more may come at any moment.
        now: bool,
    },
    /// It is written whole.
    Whole,
}

/// A file for a backup.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BackupFile {
    /// Below the data folder.
    pub path: PathBuf,
    /// How it changes.
    pub changes: Changes,
}

/// The files of archive and history that a backup holds, in the order in which they are to be copied.
///
/// # Errors
/// When the folder cannot be read.
pub fn backup_files(data: &Path) -> Result<Vec<BackupFile>> {
    let mut found = Vec::new();
    let mut add = |path: PathBuf, changes| {
        if data.join(&path).is_file() {
            found.push(BackupFile { path, changes });
        }
    };
    let folder = Path::new(crate::layout::HISTORY);
    add(folder.join(CATALOGUE), Changes::Database);
    for month in history::months(&data.join(folder))? {
        add(folder.join(month.file_name()), Changes::Database);
    }
    let archive = Path::new(crate::layout::ARCHIVE);
    for name in BESIDE_DAYS {
        add(archive.join(name), Changes::Whole);
    }
    let days = archive::days(&data.join(archive))?;
    let newest = days.iter().map(|key| key.day).max();
    for key in days {
        let now = newest == Some(key.day);
        let folder = archive.join(key.name());
        for name in [DATA, ARRIVALS] {
            // The one in use, asked once: the compressed one has its name before the plain one loses it.
            if bytes::is_plain_in_use(&data.join(&folder), name) {
                found.push(BackupFile { path: folder.join(name), changes: Changes::Grows { now } });
            } else if data.join(&folder).join(packed_name(name)).is_file() {
                let path = folder.join(packed_name(name));
                found.push(BackupFile { path, changes: Changes::Grows { now: false } });
            }
        }
        let mut add = |path: PathBuf, changes| {
            if data.join(&path).is_file() {
                found.push(BackupFile { path, changes });
            }
        };
        add(folder.join(archive::DEFINITIONS), Changes::Grows { now: false });
    }
    // After the days: it is raised before the first of them is compressed.
    let format = archive.join(archive::format::FORMAT_FILE);
    if data.join(&format).is_file() {
        found.push(BackupFile { path: format, changes: Changes::Whole });
    }
    Ok(found)
}

/// The other form of a day's file, plain or compressed, by its path; `None` for all other files.
pub fn other_form(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let other = [DATA, ARRIVALS].into_iter().find_map(|plain| match name {
        name if name == plain => Some(packed_name(plain)),
        name if name == packed_name(plain) => Some(plain),
        _ => None,
    })?;
    Some(path.with_file_name(other))
}

/// Whether a day's file is compressed, by its path.
pub fn is_packed(path: &Path) -> bool {
    [DATA, ARRIVALS].iter().any(|plain| path.file_name().is_some_and(|name| name == packed_name(plain)))
}

/// Copies one consistent state of a database, however much is written meanwhile. `progress` may stop it by returning false.
///
/// # Errors
/// When it cannot be read or the copy not be written, and [`StoreError::Cancelled`].
pub fn copy_database(from: &Path, to: &Path, progress: &mut dyn FnMut() -> bool) -> Result<()> {
    let (source, _) = crate::opening::connect(from).named(from)?;
    let snapshot = source.unchecked_transaction().named(from)?;
    {
        let mut copy = Connection::open(to).named(to)?;
        let backup = Backup::new(&source, &mut copy).named(from)?;
        loop {
            match backup.step(PAGES).named(from)? {
                StepResult::Done => break,
                _ if progress() => {}
                _ => return Err(StoreError::Cancelled),
            }
        }
    }
    drop(snapshot);
    Ok(())
}

/// From when to when something of a system was recorded, by the times at which it came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Covered {
    /// The system.
    pub system: Address,
    /// When the first came.
    pub from: UtcTime,
    /// When the last came.
    pub to: UtcTime,
    /// Days on which something came.
    pub days: u32,
}

/// The time that the archive of a data folder covers, by system.
///
/// # Errors
/// When it cannot be read.
pub fn covered(data: &Path) -> Result<Vec<Covered>> {
    let root = data.join(crate::layout::ARCHIVE);
    let mut all: BTreeMap<Address, Covered> = BTreeMap::new();
    for key in archive::days(&root)? {
        // A day whose records cannot be read counts as one whose records were lost.
        let Some((from, to)) = arrivals(&key.folder(&root)).ok().flatten().or_else(|| whole_day(key)) else {
            continue;
        };
        let one = all.entry(key.src).or_insert(Covered { system: key.src, from, to, days: 0 });
        (one.from, one.to, one.days) =
            (one.from.min(from), one.to.max(to), one.days + u32::from(key.part == 0));
    }
    Ok(all.into_values().collect())
}

/// A day whose records were lost covers what it may cover.
fn whole_day(key: DayKey) -> Option<(UtcTime, UtcTime)> {
    key.start().map(|start| (start, start))
}

/// Records at the start and the end of a day among which its first and its last packet are looked for: jumps have no time.
const LOOKED_AT: u64 = 1_000;

/// When the first and the last packet of a day came: records are in the order in which packets came.
fn arrivals(folder: &Path) -> Result<Option<(UtcTime, UtcTime)>> {
    let records = bytes::readable_bytes(folder, ARRIVALS) / ARRIVAL_BYTES as u64;
    let among = |from: u64, last: bool| -> Result<Option<UtcTime>> {
        let mut records = Records::open(folder, from * ARRIVAL_BYTES as u64)?;
        let mut found = None;
        for _ in 0..LOOKED_AT {
            match records.next()? {
                Some(Record::Packet(arrival)) => found = Some(arrival.received),
                Some(Record::Jump { .. }) => {}
                None => break,
            }
            if found.is_some() && !last {
                break;
            }
        }
        Ok(found)
    };
    let (first, last) = (among(0, false)?, among(records.saturating_sub(LOOKED_AT), true)?);
    Ok(first.zip(last).map(|(first, last)| (first.min(last), last.max(first))))
}
