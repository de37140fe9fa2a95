//! Changing a chart set so that nobody ever sees half of it.
//!
//! Changes go into a copy, `chart.gpkg.part`, one transaction for each chart, and the copy takes the place of
//! the set when all is done. A change that fails or is killed leaves the set as it was; the copy stays, and the
//! next import goes on from it as long as the set is still the one that it was copied from, and the import is of
//! all that was changed in the copy: nothing goes into a set but what its operator gives at that time.

use crate::error::{ChartDbError, Named as _, Result};
use crate::index_file::{self, PartFile, forget, index_path, part_of};
use crate::read::{Chart, ChartDb};
use crate::schema;
use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long to wait for other programs that write.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pages of a copy between two looks at the source.
const COPY_PAGES: i32 = 4096;

/// A copy of a chart set that is being changed.
pub(crate) struct Stage {
    live: PathBuf,
    part: PathBuf,
    connection: Connection,
    /// Digest of the set that the copy was made of; empty where there was none.
    base: String,
    /// The charts that an earlier run has brought into the copy.
    begun: BTreeSet<String>,
    _lock: File,
}

impl Stage {
    /// Makes the copy anew, whatever an earlier run left.
    pub(crate) fn fresh(live: &Path) -> Result<Self> {
        Self::open(live, None)
    }

    /// Goes on with the copy that is there if these charts are all that is changed in it; else makes it anew.
    pub(crate) fn resumed(live: &Path, charts: &BTreeSet<String>) -> Result<Self> {
        Self::open(live, Some(charts))
    }

    fn open(live: &Path, charts: Option<&BTreeSet<String>>) -> Result<Self> {
        if let Some(folder) = live.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).named(folder)?;
        }
        let lock = lock(live)?;
        let (mut base, mut held) = (String::new(), Vec::new());
        if live.exists() {
            let set = ChartDb::open(live)?;
            (base, held) = (hex::encode(set.digest()?), set.charts()?);
        }
        let part = part_of(live);
        let left = charts.and_then(|charts| {
            let copy = resume(&part, &base)?;
            let begun = begun(&held, &copy.charts().ok()?).filter(|begun| begun.is_subset(charts))?;
            Some((copy.into_connection(), begun))
        });
        let (connection, begun) = match left {
            Some(left) => left,
            None => (copy(live, &part, &base)?, BTreeSet::new()),
        };
        Ok(Self { live: live.to_owned(), part, connection, base, begun, _lock: lock })
    }

    /// The charts that an earlier run has brought into the copy.
    pub(crate) fn begun(&self) -> &BTreeSet<String> {
        &self.begun
    }

    pub(crate) fn connection(&mut self) -> &mut Connection {
        &mut self.connection
    }

    pub(crate) fn part(&self) -> &Path {
        &self.part
    }

    /// Puts the copy in the place of the set, with its index. Without a change, leaves the set alone.
    ///
    /// Returns the digest of the set.
    pub(crate) fn finish(self, time: &str) -> Result<[u8; 32]> {
        let Self { live, part, connection, base, begun: _, _lock } = self;
        let copy = ChartDb::of(connection, &part)?;
        let digest = copy.digest()?;
        if hex::encode(digest) == base {
            drop(copy);
            forget(&part)?;
            return Ok(digest);
        }
        let before = index_file::open(&index_path(&live)).ok().map(|sealed| sealed.index);
        let index = PartFile::of(&copy, digest, before.as_ref(), &index_path(&live))?;
        let mut connection = copy.into_connection();
        let end = connection.transaction().named(&part)?;
        schema::finish(&end, time).named(&part)?;
        end.execute("DELETE FROM chart_set WHERE key = 'base'", []).named(&part)?;
        end.commit().named(&part)?;
        connection.close().map_err(|(_, error)| error).named(&part)?;
        File::open(&part).and_then(|file| file.sync_all()).named(&part)?;
        replace(&live, &part, &base)?;
        index.put_in_place()?;
        Ok(digest)
    }

    /// Gives the copy up.
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

/// The copy that an earlier run left, if it is whole and of this set.
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

/// What a copy has beyond its set. `None` where it lacks a chart: which edition was withdrawn does not show any more.
fn begun(held: &[Chart], copied: &[Chart]) -> Option<BTreeSet<String>> {
    let names: BTreeSet<&String> = copied.iter().map(|chart| &chart.name).collect();
    let there = |chart: &Chart| names.contains(&chart.name);
    let new = copied.iter().filter(|chart| !held.contains(chart)).map(|chart| chart.name.clone());
    held.iter().all(there).then(|| new.collect())
}

fn copy(live: &Path, part: &Path, base: &str) -> Result<Connection> {
    let mut journal = part.as_os_str().to_owned();
    journal.push("-journal");
    forget(Path::new(&journal))?;
    forget(part)?;
    let mut connection = Connection::open(part).named(part)?;
    connection.pragma_update(None, "synchronous", "NORMAL").named(part)?;
    if live.exists() {
        let from = ChartDb::open(live)?;
        let backup = Backup::new(from.connection(), &mut connection).named(part)?;
        loop {
            match backup.step(COPY_PAGES).named(part)? {
                StepResult::Done => break,
                StepResult::More => {}
                // SQLite has waited already.
                _ => return Err(ChartDbError::Busy(live.to_owned())),
            }
        }
    }
    let begin = connection.transaction().named(part)?;
    if base.is_empty() {
        schema::create(&begin).named(part)?;
    }
    schema::drop_triggers(&begin).named(part)?;
    begin.execute("INSERT OR REPLACE INTO chart_set VALUES ('base', ?1)", [base]).named(part)?;
    begin.commit().named(part)?;
    Ok(connection)
}

/// Renames the copy to the set while no other program writes the set. A write-ahead log that QGIS left would be
/// taken for that of the new file, so SQLite must have put it away first.
fn replace(live: &Path, part: &Path, base: &str) -> Result<()> {
    let mut held = None;
    if live.exists() {
        let busy = |error: rusqlite::Error| match error.sqlite_error_code() {
            Some(rusqlite::ErrorCode::DatabaseBusy | rusqlite::ErrorCode::DatabaseLocked) => {
                ChartDbError::Busy(live.to_owned())
            }
            _ => ChartDbError::Sqlite { path: live.to_owned(), source: error },
        };
        let connection = Connection::open(live).named(live)?;
        connection.busy_timeout(PATIENCE).named(live)?;
        let mode = |row: &rusqlite::Row<'_>| row.get::<_, String>(0);
        let mode = connection.query_row("PRAGMA journal_mode = DELETE", [], mode).map_err(busy)?;
        if mode != "delete" {
            return Err(ChartDbError::Busy(live.to_owned()));
        }
        connection.execute_batch("BEGIN EXCLUSIVE").map_err(busy)?;
        let charts = ChartDb::of(connection, live)?;
        if hex::encode(charts.digest()?) != base {
            return Err(ChartDbError::Locked(live.to_owned()));
        }
        held = Some(charts);
    }
    fs::rename(part, live).named(live)?;
    drop(held);
    let folder = live.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder).and_then(|folder| folder.sync_all()).named(folder)
}
