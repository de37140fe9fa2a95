//! A copy of the data folder that opens as one, made while the writer runs.
//!
//! Databases are copied by SQLite's own backup, which sees one moment of each. They come before the archive, and
//! the catalogue before the months, so that the copy's history is never ahead of what it says it has read;
//! opening the copy reads the difference. Past days of the archive never change: they are linked, or copied
//! where that cannot be, and left alone when they are there already.

use crate::archive::{self, ARRIVALS, DATA, DayKey};
use crate::error::{Named as _, Result, StoreError};
use crate::history::{self, CATALOGUE};
use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OpenFlags};
use std::fs;
use std::path::Path;

/// Pages that are copied between two looks at whether to go on.
const PAGES: i32 = 1_000;

/// What a backup copied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BackedUp {
    /// Databases copied.
    pub databases: u64,
    /// Files of the archive copied.
    pub copied: u64,
    /// Files of the archive linked.
    pub linked: u64,
    /// Files of the archive that were there already.
    pub kept: u64,
}

/// Copies a data folder into another, which may hold an earlier copy. `progress` is told what is copied next and
/// may stop by returning false.
///
/// # Errors
/// When files cannot be read or written, when both are the same folder, and [`StoreError::Cancelled`].
pub fn backup(data: &Path, to: &Path, progress: &mut dyn FnMut(&str) -> bool) -> Result<BackedUp> {
    fs::create_dir_all(to.join("history")).named(to)?;
    if data.canonicalize().named(data)? == to.canonicalize().named(to)? {
        return Err(StoreError::Query("a backup must go to another folder".to_owned()));
    }
    let mut done = BackedUp::default();
    let folder = data.join("history");
    let mut databases = vec![CATALOGUE.to_owned()];
    databases.extend(history::months(&folder)?.into_iter().map(history::MonthKey::file_name));
    for name in databases {
        let path = folder.join(&name);
        if path.exists() {
            go_on(progress, &name)?;
            copy_database(&path, &to.join("history").join(&name), &name, progress)?;
            done.databases += 1;
        }
    }
    let (from, target) = (data.join("archive"), to.join("archive"));
    fs::create_dir_all(&target).named(&target)?;
    let gaps = from.join("gaps.jsonl");
    if gaps.exists() {
        fs::copy(&gaps, target.join("gaps.jsonl")).named(&gaps)?;
    }
    let shortened = from.join(archive::shortened::SHORTENED);
    if shortened.exists() {
        fs::copy(&shortened, target.join(archive::shortened::SHORTENED)).named(&shortened)?;
    }
    if archive::is_trimmed(&from) {
        archive::mark_trimmed(&target)?;
    }
    let days = archive::days(&from)?;
    let newest = days.iter().map(|key| key.day).max();
    for key in days {
        go_on(progress, &key.name())?;
        copy_day(&from, &target, key, newest == Some(key.day), &mut done)?;
    }
    Ok(done)
}

fn go_on(progress: &mut dyn FnMut(&str) -> bool, what: &str) -> Result<()> {
    if progress(what) { Ok(()) } else { Err(StoreError::Cancelled) }
}

fn copy_database(from: &Path, to: &Path, name: &str, progress: &mut dyn FnMut(&str) -> bool) -> Result<()> {
    let unfinished = to.with_extension("part");
    fs::remove_file(&unfinished).ok();
    let source = Connection::open_with_flags(from, OpenFlags::SQLITE_OPEN_READ_ONLY).named(from)?;
    // The copy is of the moment at which this begins, however much is written meanwhile.
    let snapshot = source.unchecked_transaction().named(from)?;
    {
        let mut copy = Connection::open(&unfinished).named(&unfinished)?;
        let backup = Backup::new(&source, &mut copy).named(from)?;
        loop {
            match backup.step(PAGES).named(from)? {
                StepResult::Done => break,
                _ => go_on(progress, name)?,
            }
        }
    }
    drop(snapshot);
    fs::File::open(&unfinished).and_then(|file| file.sync_all()).named(&unfinished)?;
    for end in ["-wal", "-shm"] {
        let mut beside = to.to_owned().into_os_string();
        beside.push(end);
        fs::remove_file(beside).ok();
    }
    fs::rename(&unfinished, to).named(to)
}

fn copy_day(from: &Path, to: &Path, key: DayKey, growing: bool, done: &mut BackedUp) -> Result<()> {
    let (source, target) = (key.folder(from), key.folder(to));
    fs::create_dir_all(&target).named(&target)?;
    let mut paths = Vec::new();
    for entry in fs::read_dir(&source).named(&source)? {
        paths.push(entry.named(&source)?.path());
    }
    // Packets before their records: a record without its packet is cut off when the copy is opened, while a packet
    // without its record would have lost its number.
    paths.sort_by_key(|path| path.file_name().is_none_or(|name| name != DATA));
    for path in paths {
        let Some(name) = path.file_name().filter(|_| path.is_file()) else { continue };
        let copy = target.join(name);
        let length = fs::metadata(&path).named(&path)?.len();
        if fs::metadata(&copy).is_ok_and(|there| there.len() == length) {
            done.kept += 1;
            continue;
        }
        fs::remove_file(&copy).ok();
        let grows = growing && (name == DATA || name == ARRIVALS);
        if !grows && fs::hard_link(&path, &copy).is_ok() {
            done.linked += 1;
        } else {
            fs::copy(&path, &copy).named(&path)?;
            done.copied += 1;
        }
    }
    Ok(())
}
