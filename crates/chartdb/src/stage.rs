//! Changing a chart set atomically: no reader ever sees half of a change.
//!
//! Charts are read into a database of their own, `chart.gpkg.part`, one transaction for each. When all are read, it
//! becomes the set where there was none; else its charts go into the set in one transaction (`merge`), so that a small
//! change of a large set writes little. A change that fails or is killed leaves the set as it was; what was read stays,
//! and the next import continues from it as long as the set is still the one that the change was meant for, and the import
//! is of all that was read: nothing goes into a set but what its operator gives at that time.

use crate::contents::Contents;
use crate::error::{ChartDbError, Named as _, Result};
use crate::index_file::{self, PartFile, index_path};
use crate::merge;
use crate::part_file::{forget, part_of};
use crate::read::{self, Chart, ChartDb};
use crate::schema;
use crate::write::{self, Entry};
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// A change of a chart set.
pub(crate) struct Stage {
    live: PathBuf,
    part: PathBuf,
    connection: Connection,
    /// Digest of the set before the change; empty if there is no set yet.
    base: String,
    /// The charts of that set by name.
    held: BTreeMap<String, Chart>,
    /// The charts that an earlier run has read.
    begun: BTreeSet<String>,
    _lock: File,
}

impl Stage {
    /// Starts anew, without what an earlier run left.
    pub(crate) fn fresh(live: &Path) -> Result<Self> {
        Self::open(live, None)
    }

    /// Continues with what an earlier run read if that was exactly these charts; otherwise starts anew.
    pub(crate) fn resumed(live: &Path, charts: &BTreeSet<String>) -> Result<Self> {
        Self::open(live, Some(charts))
    }

    fn open(live: &Path, charts: Option<&BTreeSet<String>>) -> Result<Self> {
        if let Some(folder) = live.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).named(folder)?;
        }
        let lock = lock(live)?;
        let (mut base, mut held) = (String::new(), BTreeMap::new());
        if live.exists() {
            let set = ChartDb::open(live)?;
            base = hex::encode(set.digest()?);
            held = set.charts()?.into_iter().map(|chart| (chart.name.clone(), chart)).collect();
        }
        let part = part_of(live);
        let left = charts.and_then(|charts| {
            let left = resume(&part, &base)?;
            let begun: BTreeSet<String> = left.charts().ok()?.into_iter().map(|chart| chart.name).collect();
            // Which edition was withdrawn does not show any more.
            let goes_on = begun.is_subset(charts) && taken_out(left.connection()).ok()?.is_empty();
            goes_on.then(|| (left.into_connection(), begun))
        });
        let (connection, begun) = match left {
            Some(left) => left,
            None => (create(&part, &base)?, BTreeSet::new()),
        };
        Ok(Self { live: live.to_owned(), part, connection, base, held, begun, _lock: lock })
    }

    /// The charts that an earlier run has read.
    pub(crate) fn begun(&self) -> &BTreeSet<String> {
        &self.begun
    }

    pub(crate) fn connection(&mut self) -> &mut Connection {
        &mut self.connection
    }

    pub(crate) fn part(&self) -> &Path {
        &self.part
    }

    /// The chart of a name, with the change so far.
    pub(crate) fn chart(&self, name: &str) -> Result<Option<Chart>> {
        let find = || -> rusqlite::Result<Option<Chart>> {
            if let Some(chart) = read::find_chart(&self.connection, name)? {
                return Ok(Some(chart));
            }
            let held = self.held.get(name).cloned();
            Ok(if taken_out(&self.connection)?.contains(name) { None } else { held })
        };
        find().named(&self.part)
    }

    /// Takes a chart out, with an entry in the log; does nothing if the set does not hold it.
    pub(crate) fn take_out(&mut self, time: &str, entry: &Entry<'_>) -> Result<()> {
        let held = self.held.contains_key(entry.cell);
        let take = |connection: &mut Connection| -> rusqlite::Result<()> {
            let all = connection.transaction()?;
            let read = write::remove(&all, entry.cell)?;
            if held {
                all.execute("INSERT OR IGNORE INTO taken_out VALUES (?1)", [entry.cell])?;
            }
            if read || held {
                write::log(&all, time, entry)?;
            }
            all.commit()
        };
        take(&mut self.connection).named(&self.part)
    }

    /// Brings the change into the set, with its index. Without a change, leaves the set alone.
    ///
    /// Returns the digest of the set.
    pub(crate) fn finish(self, time: &str) -> Result<[u8; 32]> {
        if self.base.is_empty() { self.become_set(time) } else { self.change_set(time) }
    }

    /// The staged charts become the set.
    fn become_set(self, time: &str) -> Result<[u8; 32]> {
        let Self { live, part, connection, _lock, .. } = self;
        let read = ChartDb::of(connection, &part)?;
        let contents = Contents::of(&read)?;
        let digest = contents.digest();
        let index = PartFile::of(&contents, None, &index_path(&live))?;
        let mut connection = read.into_connection();
        let end = connection.transaction().named(&part)?;
        schema::finish(&end, time).named(&part)?;
        end.execute("DELETE FROM chart_set WHERE key = 'base'", []).named(&part)?;
        end.execute_batch("DROP TABLE taken_out").named(&part)?;
        end.commit().named(&part)?;
        connection.close().map_err(|(_, error)| error).named(&part)?;
        File::open(&part).and_then(|file| file.sync_all()).named(&part)?;
        fs::rename(&part, &live).named(&live)?;
        let folder = live.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(folder).and_then(|folder| folder.sync_all()).named(folder)?;
        index.put_in_place()?;
        Ok(digest)
    }

    /// The staged charts go into the set. The index is written before, so that the set is locked for as short as can be,
    /// and takes its place after: a run that was cut off in between builds the index again from the set.
    fn change_set(self, time: &str) -> Result<[u8; 32]> {
        let Self { live, part, connection, base, _lock, .. } = self;
        let change = ChartDb::of(connection, &part)?;
        let gone = taken_out(change.connection()).named(&part)?;
        let set = ChartDb::open(&live)?;
        if gone.is_empty() && change.charts()?.is_empty() {
            let digest = set.digest()?;
            drop(change);
            forget(&part)?;
            return Ok(digest);
        }
        let before = index_file::open(&index_path(&live)).ok();
        let (digest, index) = {
            let contents = Contents::changed(&set, &change, &gone)?;
            (contents.digest(), PartFile::of(&contents, before.as_ref(), &index_path(&live))?)
        };
        drop((set, change));
        merge::into(&live, &part, &base, &gone, time)?;
        index.put_in_place()?;
        forget(&part)?;
        Ok(digest)
    }

    /// Gives the change up.
    pub(crate) fn abandon(self) -> Result<()> {
        drop(self.connection);
        forget(&self.part)
    }
}

/// One changes a set at a time; the system releases the lock when the process ends, however it ends.
fn lock(live: &Path) -> Result<File> {
    let mut name = live.as_os_str().to_owned();
    name.push(".lock");
    let path = PathBuf::from(name);
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path).named(&path)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(ChartDbError::Locked(live.to_owned())),
        Err(TryLockError::Error(source)) => Err(ChartDbError::Io { path, source }),
    }
}

/// The stage of an earlier run, if it is whole and meant for this set.
fn resume(part: &Path, base: &str) -> Option<ChartDb> {
    if !part.exists() {
        return None;
    }
    let connection = Connection::open(part).ok()?;
    let sound: String = connection.query_row("PRAGMA quick_check", [], |row| row.get(0)).ok()?;
    let of: Option<String> = connection
        .query_row("SELECT value FROM chart_set WHERE key = 'base'", [], |row| row.get(0))
        .optional()
        .ok()?;
    let whole = sound == "ok" && of.as_deref() == Some(base);
    ChartDb::of(connection, part).ok().filter(|_| whole)
}

/// The charts of the set that the change takes out.
fn taken_out(connection: &Connection) -> rusqlite::Result<BTreeSet<String>> {
    connection.prepare_cached("SELECT name FROM taken_out")?.query_map([], |row| row.get(0))?.collect()
}

/// An empty database for what is read.
fn create(part: &Path, base: &str) -> Result<Connection> {
    let mut journal = part.as_os_str().to_owned();
    journal.push("-journal");
    forget(Path::new(&journal))?;
    forget(part)?;
    let mut connection = Connection::open(part).named(part)?;
    connection.pragma_update(None, "synchronous", "NORMAL").named(part)?;
    let begin = connection.transaction().named(part)?;
    schema::create(&begin).named(part)?;
    begin.execute_batch("CREATE TABLE taken_out (name TEXT NOT NULL PRIMARY KEY)").named(part)?;
    begin.execute("INSERT INTO chart_set VALUES ('base', ?1)", [base]).named(part)?;
    begin.commit().named(part)?;
    Ok(connection)
}
