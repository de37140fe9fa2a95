//! Questions to the history, answered while the writer runs and without any.
//!
//! A reader is cheap to open and sees every commit that was made before it asks. Files are opened when first
//! needed and stay open; a month that was removed is gone for readers opened later.

mod buckets;
mod catalogue;
mod detections;
mod events;
mod page;
mod samples;
mod silence;
mod snapshot;
mod track;

pub use crate::history::Order;
pub use buckets::{Bucket, Buckets};
pub use catalogue::{EntityName, RecordedDay, Series, System};
pub use detections::{Acoustic, DetectionsWanted};
pub use events::LogEntry;
pub use page::{Next, Page, Paged};
pub use samples::{Cell, Row, Samples};
pub use snapshot::{Last, Snapshot};
pub use track::{Track, TrackPoint};

use crate::error::{Named as _, Result, StoreError};
use crate::gaps::{self, Gap};
use crate::history::look;
use crate::history::schema::Schema;
use crate::history::{self, CATALOGUE, GroupKey, MonthKey, Names, Table};
use crate::layout::HISTORY;
use crate::opening::{connect, has_log, keep_log};
use crate::range::TimeRange;
use imc::Address;
use rusqlite::Connection;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The samples of one message of one entity of one system.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    /// Address of the system.
    pub system: Address,
    /// Number of the entity.
    pub entity: u8,
    /// The message's name, such as `EulerAngles`.
    pub message: String,
}

/// How much memory a reader's files may use, each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory {
    cache_kib: i64,
    map_bytes: i64,
}

impl Memory {
    /// For questions: the files are mapped, so that what the system holds of them is not copied.
    pub(crate) const QUESTIONS: Self = Self { cache_kib: 8_000, map_bytes: 1 << 30 };
    /// For reading once through everything.
    pub(crate) const EXPORT: Self = Self { cache_kib: 2_000, map_bytes: 0 };

    /// Lets a connection, which only reads, use so much.
    pub(crate) fn set(self, connection: &Connection) -> rusqlite::Result<()> {
        connection.execute_batch(&format!(
            "PRAGMA cache_size = -{}; PRAGMA mmap_size = {}; PRAGMA busy_timeout = 5000; PRAGMA query_only = 1",
            self.cache_kib, self.map_bytes
        ))?;
        connection.set_prepared_statement_cache_capacity(64);
        Ok(())
    }
}

/// The history, open for reading.
#[derive(Debug)]
pub struct Reader {
    data: PathBuf,
    folder: PathBuf,
    memory: Memory,
    pub(crate) schema: Schema,
    months: BTreeMap<MonthKey, Connection>,
}

impl Reader {
    /// Opens the history of a data folder. One that holds none answers with nothing.
    ///
    /// # Errors
    /// When there is no such folder.
    pub fn open(data: &Path) -> Result<Self> {
        Self::open_with(data, Memory::QUESTIONS)
    }

    pub(crate) fn open_with(data: &Path, memory: Memory) -> Result<Self> {
        Ok(Self { memory, ..Self::open_folder(data, HISTORY)? })
    }

    /// A history that lies in another folder of the data.
    pub(crate) fn open_folder(data: &Path, folder: &str) -> Result<Self> {
        data.metadata().named(data)?;
        let memory = Memory::QUESTIONS;
        Ok(Self {
            data: data.to_owned(),
            folder: data.join(folder),
            memory,
            schema: Schema::new(),
            months: BTreeMap::new(),
        })
    }

    /// The table of a message, by its name.
    ///
    /// # Errors
    /// When the catalogue has no such message.
    pub fn table(&self, message: &str) -> Result<&Table> {
        self.schema.named(message).ok_or_else(|| StoreError::Query(format!("IMC has no message `{message}`")))
    }

    /// What vessels declared missing in a range, of one system or of all.
    ///
    /// # Errors
    /// When the declarations cannot be read.
    pub fn gaps(&self, system: Option<Address>, range: TimeRange) -> Result<Vec<Gap>> {
        let mut gaps = gaps::all(&self.data.join("archive"))?;
        gaps.retain(|gap| {
            system.is_none_or(|system| system == gap.system)
                && gap.from.micros() < range.to_us
                && gap.to.micros() >= range.from_us
        });
        gaps.sort_by_key(|gap| (gap.from, gap.to, gap.system));
        Ok(gaps)
    }

    pub(crate) fn group(&self, source: &Source) -> Result<GroupKey> {
        let id = self.table(&source.message)?.desc.id;
        Ok(GroupKey { id, src: source.system.0, src_ent: source.entity })
    }

    /// The months that there are.
    pub(crate) fn keys(&self) -> Result<Vec<MonthKey>> {
        history::months(&self.folder)
    }

    /// Asks one month. Where it is not open yet it is closed again: what asks all months must not keep them from being replaced.
    pub(crate) fn ask_month<T>(
        &self,
        key: MonthKey,
        ask: impl FnOnce(&Connection) -> rusqlite::Result<T>,
    ) -> Result<T> {
        if let Some(open) = self.months.get(&key) {
            return self.named(key, ask(open));
        }
        let opened = open_known(&self.folder.join(key.file_name()), Memory::EXPORT)?;
        self.named(key, ask(&opened))
    }

    /// The files that hold a range, open, with the part that each holds.
    pub(crate) fn parts(&mut self, range: TimeRange) -> Result<Vec<(MonthKey, TimeRange)>> {
        let parts = MonthKey::parts(range, &history::months(&self.folder)?);
        for (key, _) in &parts {
            if !self.months.contains_key(key) {
                let path = self.folder.join(key.file_name());
                self.months.insert(*key, open_known(&path, self.memory)?);
            }
        }
        Ok(parts)
    }

    /// The file of a part.
    pub(crate) fn month(&self, key: MonthKey) -> Result<&Connection> {
        self.months.get(&key).ok_or_else(|| StoreError::Query(format!("{} is not open", key.file_name())))
    }

    /// Puts the name of a month's file to an error.
    pub(crate) fn named<T>(&self, key: MonthKey, result: rusqlite::Result<T>) -> Result<T> {
        result.named(&self.folder.join(key.file_name()))
    }

    /// The names of everything, as of now.
    pub(crate) fn names(&self) -> Result<Names> {
        Ok(self.ask_catalogue(history::load_names)?.unwrap_or_default())
    }

    /// Asks the catalogue, when there is one.
    pub(crate) fn ask_catalogue<T>(
        &self,
        ask: impl FnOnce(&Connection) -> rusqlite::Result<T>,
    ) -> Result<Option<T>> {
        let path = self.folder.join(CATALOGUE);
        if !path.exists() {
            return Ok(None);
        }
        let connection = open_known(&path, Memory::EXPORT)?;
        ask(&connection).named(&path).map(Some)
    }
}

/// As [`open`], but refuses what a later version wrote: what its tables mean is not known.
fn open_known(path: &Path, memory: Memory) -> Result<Connection> {
    let mut connection = open(path, memory).named(path)?;
    // Its compression was broken off at its end. A reader of a file without a log holds no lock, and it could be replaced below it.
    if !has_log(&connection).named(path)? && keep_log(path).is_ok() {
        connection = open(path, memory).named(path)?;
    }
    match look::version(&connection).named(path)? {
        version if version > history::latest_version(path) => {
            Err(StoreError::Newer { path: path.to_owned() })
        }
        history::TRIAL_VERSION => Err(StoreError::Trial { path: path.to_owned() }),
        _ => Ok(connection),
    }
}

/// Opens a database for reading, beside its writer or where nobody may write.
pub(crate) fn open(path: &Path, memory: Memory) -> rusqlite::Result<Connection> {
    let (connection, _) = connect(path)?;
    memory.set(&connection)?;
    Ok(connection)
}
