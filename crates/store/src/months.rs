//! Compressing months of the history that are over.
//!
//! [`plan_months`] says which; [`PackedMonth::make`] makes a new file of one of them, beside the writer and without it, and reads it
//! back row by row; [`Store::adopt_month`] gives that the month's name. A kill at any [`MonthStep`] leaves the month as it was or
//! as it is compressed, whole; the next start removes what is half made.

use crate::error::{Named as _, Result, StoreError};
use crate::history::schema::Schema;
use crate::history::{self, MonthKey, PART, chunk, look, pack};
use crate::layout::{HISTORY, free_bytes, reserved_bytes};
use crate::opening::FileId;
use crate::reader::{self, Memory};
use crate::store::Store;
use rusqlite::{Connection, OpenFlags};
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

const DAY_US: i64 = 86_400_000_000;
/// Samples that are rolled up at once before a month is compressed.
const READY_SAMPLES: u64 = 5_000;
/// A compressed month is compressed again when one in so many of its rows came since.
const AGAIN_FROM: u64 = 32;

/// A month that can be compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PackableMonth {
    /// The month.
    pub key: MonthKey,
    /// Bytes of its file.
    pub bytes: u64,
}

/// The steps of compressing a month, for tests that end a process at one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MonthStep {
    /// The new file is being written.
    Begun,
    /// It is written, read back and synced.
    Made,
    /// Nothing else can open the month.
    Closed,
    /// The new file has the month's name.
    Named,
}

impl MonthStep {
    /// All, in their order.
    pub const ALL: [Self; 4] = [Self::Begun, Self::Made, Self::Closed, Self::Named];
}

/// The months that can be compressed, the oldest first: those that ended `after_days` days ago or before, by their own time.
///
/// # Errors
/// When the folder cannot be read.
pub fn plan_months(data: &Path, after_days: u16, now: UtcTime) -> Result<Vec<PackableMonth>> {
    let folder = data.join(HISTORY);
    let ended_before_us = now.micros().saturating_sub(i64::from(after_days) * DAY_US);
    let mut found = Vec::new();
    for key in history::months(&folder)? {
        let path = folder.join(key.file_name());
        let is_over = key.range_us().is_some_and(|(_, end_us)| end_us <= ended_before_us);
        // What cannot be read is the doctor's.
        if is_over && is_worth_it(&path).unwrap_or(false) {
            let bytes = fs::metadata(&path).named(&path)?.len();
            found.push(PackableMonth { key, bytes });
        }
    }
    Ok(found)
}

fn is_worth_it(path: &Path) -> rusqlite::Result<bool> {
    let connection = reader::open(path, Memory::EXPORT)?;
    match look::version(&connection)? {
        history::VERSION => Ok(true),
        history::PACKED_VERSION => {
            let late = late_rows(&connection)?;
            Ok(late > 0 && late >= (late + chunk::rows(&connection)?) / AGAIN_FROM)
        }
        _ => Ok(false),
    }
}

/// How many rows a compressed month has that are not compressed.
fn late_rows(connection: &Connection) -> rusqlite::Result<u64> {
    let schema = Schema::new();
    let mut statement = connection.prepare("SELECT name FROM sqlite_schema WHERE type='table'")?;
    let names = statement.query_map((), |row| row.get::<_, String>(0))?;
    let mut late = 0;
    for name in names {
        if let Some(table) = schema.named(&name?) {
            let sql = format!("SELECT count(*) FROM \"{}\"", table.desc.abbrev);
            late += connection.query_row(&sql, (), |row| row.get::<_, i64>(0))?.cast_unsigned();
        }
    }
    Ok(late)
}

/// Whether a month can be compressed now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Readiness {
    /// It can.
    Ready,
    /// More of it must be rolled up first: ask again.
    Unfinished,
    /// The history lacks something of the archive, and no month can.
    Behind,
}

/// What came of giving a compressed month its name.
#[derive(Debug)]
pub enum Adopted {
    /// It has the name, and the file that had it before is still open.
    Done(CompressedMonth, Replaced),
    /// Something was written to the month meanwhile: it stays as it was, and must be compressed again.
    Changed,
    /// Something reads the month: it stays as it was, and this may be tried again.
    Busy(PackedMonth),
}

impl Adopted {
    /// The month, if it has the name.
    pub fn done(self) -> Option<CompressedMonth> {
        match self {
            Self::Done(month, _) => Some(month),
            Self::Changed | Self::Busy(_) => None,
        }
    }
}

/// The file that a month had before it was compressed. Its room is free when this is dropped, which can take a second for a large month:
/// where nothing waits for it.
#[derive(Debug)]
pub struct Replaced {
    _file: fs::File,
}

/// A month in its compressed form, which has no name yet. Dropping it leaves the month as it was.
#[derive(Debug)]
pub struct PackedMonth {
    key: MonthKey,
    path: PathBuf,
    part: PathBuf,
    source: Option<pack::Source>,
    bytes: u64,
    packed_bytes: u64,
    rows: u64,
}

/// What compressing a month did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompressedMonth {
    /// The month.
    pub key: MonthKey,
    /// Bytes of its file before.
    pub bytes: u64,
    /// Bytes of its file now.
    pub packed_bytes: u64,
    /// Messages in chunks.
    pub rows: u64,
}

impl PackedMonth {
    /// Makes it, after [`Store::ready_month`]. `goes_on` gets the messages that were written, and then compared, so far, and may stop it
    /// by returning false; it may also take its time. Only one is made at a time.
    ///
    /// # Errors
    /// The disk has no room for it beside what recording needs, the month cannot be read, the new file not be written or it is not
    /// what the month is; [`StoreError::Cancelled`]. The month stays as it was.
    pub fn make(data: &Path, month: &PackableMonth, goes_on: &mut dyn FnMut(u64) -> bool) -> Result<Self> {
        let folder = data.join(HISTORY);
        let (free, needed) = (free_bytes(&folder)?, reserved_bytes(&folder)?.saturating_add(month.bytes));
        if free < needed {
            return Err(StoreError::NoRoom {
                what: format!("{HISTORY}/{}", month.key.file_name()),
                free,
                needed,
            });
        }
        let (path, part) = (folder.join(month.key.file_name()), folder.join(PART));
        history::remove_part(&folder)?;
        let mut new = Self {
            key: month.key,
            source: Some(pack::Source::open(&path)?),
            path,
            part,
            bytes: month.bytes,
            packed_bytes: 0,
            rows: 0,
        };
        if let Some(source) = &new.source {
            new.rows = pack::make(source, &new.path, &new.part, goes_on)?;
        }
        new.packed_bytes = fs::metadata(&new.part).named(&new.part)?.len();
        Ok(new)
    }

    /// The month.
    pub fn key(&self) -> MonthKey {
        self.key
    }
}

impl Drop for PackedMonth {
    fn drop(&mut self) {
        // Unless it has the month's name by now.
        fs::remove_file(&self.part).ok();
    }
}

impl Store {
    /// Makes a month ready to be compressed; false while the history lacks something.
    ///
    /// # Errors
    /// When the history cannot be written.
    pub fn ready_month(&mut self, key: MonthKey) -> Result<bool> {
        loop {
            match self.ready_month_some(key)? {
                Readiness::Ready => return Ok(true),
                Readiness::Unfinished => {}
                Readiness::Behind => return Ok(false),
            }
        }
    }

    /// The same by one small step, beside which a server records: until some thousand samples were rolled up, or those of one window of
    /// ten minutes where it has more.
    ///
    /// # Errors
    /// As [`Self::ready_month`].
    pub fn ready_month_some(&mut self, key: MonthKey) -> Result<Readiness> {
        if self.is_behind() {
            return Ok(Readiness::Behind);
        }
        let is_ready = self.history()?.ready_month(key, READY_SAMPLES)?;
        Ok(if is_ready { Readiness::Ready } else { Readiness::Unfinished })
    }

    /// Puts a compressed month in the place of the month.
    ///
    /// # Errors
    /// When files cannot be opened or renamed.
    pub fn adopt_month(&mut self, packed: PackedMonth) -> Result<Adopted> {
        self.adopt_month_watched(packed, &mut |_| ())
    }

    /// As [`Self::adopt_month`]; `steps` is called after each step, for tests.
    ///
    /// # Errors
    /// As [`Self::adopt_month`].
    pub fn adopt_month_watched(
        &mut self,
        mut packed: PackedMonth,
        steps: &mut dyn FnMut(MonthStep),
    ) -> Result<Adopted> {
        let PackedMonth { key, bytes, packed_bytes, rows, .. } = packed;
        self.history()?.close_month(key);
        let Some(source) = packed.source.take() else { return Ok(Adopted::Changed) };
        if !source.is_unchanged(&packed.path).named(&packed.path)? {
            return Ok(Adopted::Changed);
        }
        let file = source.file();
        drop(source);
        let closed = close_for_all(&packed.path).named(&packed.path)?;
        let Some(closed) = closed else {
            // Only this store writes to it, and does nothing else meanwhile.
            packed.source = Some(pack::Source::watch(&packed.path)?);
            return Ok(Adopted::Busy(packed));
        };
        if FileId::of(&packed.path) != Some(file) {
            return Ok(Adopted::Changed);
        }
        // SQLite leaves the memory of the log there when the last to close it could only read; nothing uses it now.
        fs::remove_file(beside(&packed.path, "-shm")).ok();
        // Under the lock: closing a file ends all locks of this process on it.
        let replaced = Replaced { _file: fs::File::open(&packed.path).named(&packed.path)? };
        steps(MonthStep::Closed);
        if let Err(error) = fs::rename(&packed.part, &packed.path) {
            closed.execute_batch("PRAGMA journal_mode = WAL").ok();
            return Err(error).named(&packed.part);
        }
        steps(MonthStep::Named);
        drop(closed);
        let folder = self.folder().join(HISTORY);
        fs::File::open(&folder).and_then(|file| file.sync_all()).named(&folder)?;
        Ok(Adopted::Done(CompressedMonth { key, bytes, packed_bytes, rows }, replaced))
    }
}

/// Opens a month so that nothing else can, with nothing beside its file; `None` when something else has it open.
///
/// SQLite finds the log beside a database by its name. So the old file must not be one with a log when the new one takes its name, and
/// must not be open: a reader of it would read the log of the other. All months have logs, and a reader of such a file holds a
/// lock until it closes it. The form is changed under a lock that is held until the name is another's; who waits for that meanwhile
/// looks again what has the name (`opening::connect`). The change is of two bytes, which need no journal.
fn close_for_all(path: &Path) -> rusqlite::Result<Option<Connection>> {
    // A name that has no file gets none.
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    connection.busy_timeout(std::time::Duration::ZERO)?;
    connection.execute_batch("PRAGMA locking_mode = EXCLUSIVE")?;
    let form: rusqlite::Result<String> =
        connection.query_row("PRAGMA journal_mode = MEMORY", (), |row| row.get(0));
    match form {
        Ok(form) if form == "memory" => {}
        Ok(_) => return Ok(None),
        Err(error) if is_busy(&error) => return Ok(None),
        Err(error) => return Err(error),
    }
    // Also where it had that form before.
    match connection.execute_batch("BEGIN EXCLUSIVE; COMMIT") {
        Ok(()) => Ok(Some(connection)),
        Err(error) if is_busy(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

fn beside(path: &Path, end: &str) -> PathBuf {
    let mut name = path.to_owned().into_os_string();
    name.push(end);
    PathBuf::from(name)
}

fn is_busy(error: &rusqlite::Error) -> bool {
    use rusqlite::ErrorCode::{DatabaseBusy, DatabaseLocked};
    matches!(error.sqlite_error_code(), Some(DatabaseBusy | DatabaseLocked))
}
