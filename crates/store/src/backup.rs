//! The files of a data folder that a backup holds, how each of them changes, and the time that it covers.
//!
//! The files come in the order in which a backup must copy them while the writer runs. Databases come before the archive,
//! and the catalogue before the months, so that the copy's history is never ahead of what it says it has read; opening
//! the copy reads the difference. Of a day packets come before their records: a record without its packet is cut off when
//! the copy is opened, while a packet without its record would have lost its number.

use crate::archive::{self, ARRIVAL_BYTES, ARRIVALS, DATA, DayKey, Record};
use crate::error::{Named as _, Result, StoreError};
use crate::history::{self, CATALOGUE};
use imc::Address;
use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OpenFlags};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Pages that are copied between two checks for cancellation.
const PAGES: i32 = 1_000;
/// Files of the archive beside its days.
const BESIDE_DAYS: [&str; 4] =
    ["gaps.jsonl", archive::shortened::SHORTENED, archive::format::FORMAT_FILE, archive::TRIMMED];

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
        add(folder.join(DATA), Changes::Grows { now });
        add(folder.join(ARRIVALS), Changes::Grows { now });
        add(folder.join(archive::DEFINITIONS), Changes::Grows { now: false });
    }
    Ok(found)
}

/// Copies one consistent state of a database, however much is written meanwhile. `progress` may stop it by returning false.
///
/// # Errors
/// When it cannot be read or the copy not be written, and [`StoreError::Cancelled`].
pub fn copy_database(from: &Path, to: &Path, progress: &mut dyn FnMut() -> bool) -> Result<()> {
    let source = Connection::open_with_flags(from, OpenFlags::SQLITE_OPEN_READ_ONLY).named(from)?;
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
        let Some((from, to)) = arrivals(&key.folder(&root).join(ARRIVALS))?.or_else(|| whole_day(key)) else {
            continue;
        };
        let one = all.entry(key.src).or_insert(Covered { system: key.src, from, to, days: 0 });
        (one.from, one.to, one.days) = (one.from.min(from), one.to.max(to), one.days + 1);
    }
    Ok(all.into_values().collect())
}

/// A day whose records were lost covers what it may cover.
fn whole_day(key: DayKey) -> Option<(UtcTime, UtcTime)> {
    key.start().map(|start| (start, start))
}

/// When the first and the last packet of a day came: records are in the order in which packets came.
fn arrivals(path: &Path) -> Result<Option<(UtcTime, UtcTime)>> {
    let Ok(mut file) = File::open(path) else { return Ok(None) };
    let records = file.metadata().named(path)?.len() / ARRIVAL_BYTES as u64;
    let mut at = |number: u64| -> Result<Option<UtcTime>> {
        let mut bytes = [0; ARRIVAL_BYTES];
        file.seek(SeekFrom::Start(number * ARRIVAL_BYTES as u64)).named(path)?;
        file.read_exact(&mut bytes).named(path)?;
        Ok(match Record::read(&bytes) {
            Some(Record::Packet(arrival)) => Some(arrival.received),
            Some(Record::Jump { .. }) | None => None,
        })
    };
    // Jumps have no time; a packet follows each.
    let (mut first, mut last) = (None, None);
    for number in 0..records.min(1_000) {
        first = at(number)?;
        if first.is_some() {
            break;
        }
    }
    for number in (records.saturating_sub(1_000)..records).rev() {
        last = at(number)?;
        if last.is_some() {
            break;
        }
    }
    Ok(first.zip(last).map(|(first, last)| (first.min(last), last.max(first))))
}
