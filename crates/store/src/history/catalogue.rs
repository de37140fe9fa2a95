//! `catalogue.sqlite`: systems and entities, the meaning of the messages' fields, and how far the archive was read.

use super::MonthKey;
use super::month::{Extent, VERSION as LAYOUT, WRITER};
use crate::archive::{DayKey, Lengths};
use crate::error::{Named as _, Result};
use imc::catalogue::{MESSAGES, Meaning, VERSION};
use imc::names::{Names, SystemName};
use imc::{Address, Run};
use link::LinkSeq;
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub(crate) const FILE: &str = "catalogue.sqlite";

const TABLES: &str = "
CREATE TABLE IF NOT EXISTS meta (name TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS system (
  address INTEGER NOT NULL, from_us INTEGER NOT NULL, last_us INTEGER NOT NULL, name TEXT NOT NULL,
  kind INTEGER NOT NULL, PRIMARY KEY (address, from_us)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS entity (
  address INTEGER NOT NULL, entity INTEGER NOT NULL, from_us INTEGER NOT NULL, last_us INTEGER NOT NULL,
  label TEXT NOT NULL, PRIMARY KEY (address, entity, from_us)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS archived (
  address INTEGER NOT NULL, day INTEGER NOT NULL, data_bytes INTEGER NOT NULL, arrival_bytes INTEGER NOT NULL,
  packets INTEGER NOT NULL, first_us INTEGER NOT NULL, last_us INTEGER NOT NULL,
  PRIMARY KEY (address, day)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS month (name TEXT PRIMARY KEY) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS stream (stream INTEGER PRIMARY KEY, seq INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS message (
  id INTEGER PRIMARY KEY, abbrev TEXT NOT NULL, name TEXT NOT NULL, summary TEXT);
CREATE TABLE IF NOT EXISTS field (
  id INTEGER NOT NULL, at INTEGER NOT NULL, abbrev TEXT NOT NULL, name TEXT NOT NULL, type TEXT NOT NULL,
  unit TEXT, PRIMARY KEY (id, at)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS label (
  id INTEGER NOT NULL, field TEXT NOT NULL, value INTEGER NOT NULL, bit INTEGER NOT NULL,
  abbrev TEXT NOT NULL, name TEXT NOT NULL, PRIMARY KEY (id, field, value, abbrev)) WITHOUT ROWID;
";

/// How far a day of the archive was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Nothing for a day that the archive has no more, or that is to be read again.
    pub(crate) lengths: Lengths,
    /// Packets so far, and the times that they state.
    pub(crate) extent: Extent,
}

impl Default for Progress {
    fn default() -> Self {
        Self { lengths: Lengths::default(), extent: Extent::NONE }
    }
}

/// The catalogue, open for writing.
#[derive(Debug)]
pub(crate) struct Catalogue {
    connection: Connection,
    path: PathBuf,
    names: Names,
    /// The names that are not in the file, or not with their last time.
    changed_systems: BTreeSet<u16>,
    changed_entities: BTreeSet<(u16, u8)>,
    progress: BTreeMap<DayKey, Progress>,
    changed_progress: BTreeSet<DayKey>,
    /// The months' files that must be there.
    months: BTreeSet<MonthKey>,
    new_months: BTreeSet<MonthKey>,
}

impl Catalogue {
    pub(crate) fn open(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        let open = || -> rusqlite::Result<_> {
            let mut connection = Connection::open(&path)?;
            connection.execute_batch(WRITER)?;
            // Its few rows say what was surely done; they are waited for.
            connection.execute_batch("PRAGMA synchronous = FULL")?;
            connection.execute_batch(TABLES)?;
            describe(&mut connection)?;
            connection.pragma_update(None, "user_version", LAYOUT)?;
            let (names, progress) = (load_names(&connection)?, load_progress(&connection)?);
            let months = load_months(&connection)?;
            Ok((connection, names, progress, months))
        };
        let (connection, names, progress, months) = open().named(&path)?;
        Ok(Self {
            connection,
            path,
            names,
            changed_systems: BTreeSet::new(),
            changed_entities: BTreeSet::new(),
            progress,
            changed_progress: BTreeSet::new(),
            months,
            new_months: BTreeSet::new(),
        })
    }

    /// Whether a month's file was there when the progress was last saved, or was made since.
    pub(crate) fn has_month(&self, key: MonthKey) -> bool {
        self.months.contains(&key)
    }

    /// The months' files that must be there.
    pub(crate) fn months(&self) -> Vec<MonthKey> {
        self.months.iter().copied().collect()
    }

    /// A month's file is there; it is remembered with the next save of the progress.
    pub(crate) fn add_month(&mut self, key: MonthKey) {
        if self.months.insert(key) {
            self.new_months.insert(key);
        }
    }

    /// A month's file is removed: it need not be there any more.
    pub(crate) fn forget_month(&mut self, key: MonthKey) -> Result<()> {
        self.months.remove(&key);
        self.new_months.remove(&key);
        let sql = "DELETE FROM month WHERE name=?1";
        self.connection.execute(sql, [key.file_name()]).map(drop).named(&self.path)
    }

    /// The days of which some may be in a month's file.
    pub(crate) fn days_of(&self, key: MonthKey) -> Vec<(DayKey, Progress)> {
        let may_hold = |(_, progress): &(&DayKey, &Progress)| key.may_hold(progress.extent);
        self.progress.iter().filter(may_hold).map(|(day, progress)| (*day, *progress)).collect()
    }

    /// A month's file is lost: these days are read again. Days that the archive lacks (`gone`) stay in the list of recorded days.
    /// This is on the disk before it returns.
    pub(crate) fn unread_month(&mut self, key: MonthKey, days: &[DayKey], gone: &[DayKey]) -> Result<()> {
        let unread = || -> rusqlite::Result<()> {
            let transaction = self.connection.unchecked_transaction()?;
            for day in days {
                transaction
                    .execute("DELETE FROM archived WHERE address=?1 AND day=?2", (day.src.0, day.number()))?;
            }
            for day in gone {
                transaction.execute(
                    "UPDATE archived SET data_bytes=0,arrival_bytes=0 WHERE address=?1 AND day=?2",
                    (day.src.0, day.number()),
                )?;
            }
            transaction.execute("DELETE FROM month WHERE name=?1", [key.file_name()])?;
            transaction.commit()
        };
        unread().named(&self.path)?;
        for day in days {
            self.progress.remove(day);
            self.changed_progress.remove(day);
        }
        for day in gone {
            self.unread_gone(*day);
        }
        self.months.remove(&key);
        self.new_months.remove(&key);
        Ok(())
    }

    /// A day is gone from the archive: nothing of it counts as read, and it stays in the list of recorded days.
    pub(crate) fn unread_gone(&mut self, key: DayKey) {
        let extent = self.progress(key).extent;
        self.set_progress(key, Progress { lengths: Lengths::default(), extent });
    }

    /// Forgets what came on days of which nothing is left, neither in the archive nor in a month.
    pub(crate) fn forget_gone(&mut self) {
        let is_left = |progress: &Progress| {
            progress.lengths != Lengths::default()
                || self.months.iter().any(|key| key.may_hold(progress.extent))
        };
        let gone: Vec<DayKey> =
            self.progress.iter().filter(|(_, progress)| !is_left(progress)).map(|(day, _)| *day).collect();
        for day in gone {
            self.set_progress(day, Progress::default());
        }
    }

    pub(crate) fn progress(&self, key: DayKey) -> Progress {
        self.progress.get(&key).copied().unwrap_or_default()
    }

    /// Every day of which something was read, and how far.
    pub(crate) fn all_progress(&self) -> Vec<(DayKey, Progress)> {
        self.progress.iter().map(|(key, progress)| (*key, *progress)).collect()
    }

    pub(crate) fn set_progress(&mut self, key: DayKey, progress: Progress) {
        self.progress.insert(key, progress);
        self.changed_progress.insert(key);
    }

    /// The streams' numbers as of the last saved progress.
    pub(crate) fn streams(&self) -> Result<Vec<LinkSeq>> {
        let read = || -> rusqlite::Result<Vec<LinkSeq>> {
            let mut statement = self.connection.prepare("SELECT stream,seq FROM stream")?;
            let rows = statement.query_map((), |row| {
                let (stream, seq): (i64, i64) = (row.get(0)?, row.get(1)?);
                Ok(LinkSeq { stream: stream.cast_unsigned(), seq: seq.cast_unsigned() })
            })?;
            rows.collect()
        };
        read().named(&self.path)
    }

    /// The first of `count` times of arrival, from `now_us` on, that no import had before.
    pub(crate) fn reserve_arrivals(&mut self, now_us: i64, count: usize) -> Result<i64> {
        let reserve = || -> rusqlite::Result<i64> {
            let last: Option<String> = self
                .connection
                .query_row("SELECT value FROM meta WHERE name='last_import_us'", (), |row| row.get(0))
                .optional()?;
            let last_us = last.and_then(|text| text.parse::<i64>().ok());
            let start_us = last_us.map_or(now_us, |last_us| now_us.max(last_us + 1));
            let end = (start_us + count as i64).to_string();
            self.connection.execute("INSERT OR REPLACE INTO meta VALUES ('last_import_us',?1)", [end])?;
            Ok(start_us)
        };
        reserve().named(&self.path)
    }

    /// Hears a system's name; whether it is a new one.
    pub(crate) fn hear_system(&mut self, address: Address, time_us: i64, name: &SystemName) -> bool {
        self.changed_systems.insert(address.0);
        self.names.systems.entry(address.0).or_default().hear(time_us, name)
    }

    /// Hears an entity's label; whether it is a new one.
    pub(crate) fn hear_entity(&mut self, address: Address, entity: u8, time_us: i64, label: &str) -> bool {
        let key = (address.0, entity);
        self.changed_entities.insert(key);
        self.names.entities.entry(key).or_default().hear(time_us, &label.to_owned())
    }

    /// Writes what names are not in the file yet, and with `streams` also how far the archive was read.
    pub(crate) fn save(&mut self, streams: Option<&[LinkSeq]>) -> Result<()> {
        let saved = self.save_all(streams);
        if saved.is_err() && !self.connection.is_autocommit() {
            self.connection.execute_batch("ROLLBACK").ok();
        }
        saved.named(&self.path)?;
        self.changed_systems.clear();
        self.changed_entities.clear();
        if streams.is_some() {
            self.changed_progress.clear();
            self.new_months.clear();
        }
        Ok(())
    }

    fn save_all(&self, streams: Option<&[LinkSeq]>) -> rusqlite::Result<()> {
        let connection = &self.connection;
        connection.execute_batch("BEGIN IMMEDIATE")?;
        for address in &self.changed_systems {
            connection.execute("DELETE FROM system WHERE address=?1", [address])?;
            let mut add = connection.prepare_cached("INSERT INTO system VALUES (?1,?2,?3,?4,?5)")?;
            for (from_us, run) in self.names.systems.get(address).into_iter().flat_map(|runs| &runs.runs) {
                add.execute((address, from_us, run.last_us, &run.name.name, run.name.kind))?;
            }
        }
        for (address, entity) in &self.changed_entities {
            connection.execute("DELETE FROM entity WHERE address=?1 AND entity=?2", (address, entity))?;
            let mut add = connection.prepare_cached("INSERT INTO entity VALUES (?1,?2,?3,?4,?5)")?;
            let runs = self.names.entities.get(&(*address, *entity));
            for (from_us, run) in runs.into_iter().flat_map(|runs| &runs.runs) {
                add.execute((address, entity, from_us, run.last_us, &run.name))?;
            }
        }
        if let Some(streams) = streams {
            let mut add =
                connection.prepare_cached("INSERT OR REPLACE INTO archived VALUES (?1,?2,?3,?4,?5,?6,?7)")?;
            for key in &self.changed_progress {
                let Progress { lengths, extent } = self.progress(*key);
                add.execute((
                    key.src.0,
                    key.number(),
                    lengths.data as i64,
                    lengths.arrivals as i64,
                    extent.count as i64,
                    extent.first_us,
                    extent.last_us,
                ))?;
            }
            let mut add = connection.prepare_cached("INSERT OR IGNORE INTO month VALUES (?1)")?;
            for key in &self.new_months {
                add.execute([key.file_name()])?;
            }
            let mut add = connection.prepare_cached("INSERT OR REPLACE INTO stream VALUES (?1,?2)")?;
            for LinkSeq { stream, seq } in streams {
                add.execute((stream.cast_signed(), seq.cast_signed()))?;
            }
        }
        connection.execute_batch("COMMIT")
    }
}

/// Writes what IMC's catalogue says, for people and programs that read the tables by SQL.
fn describe(connection: &mut Connection) -> rusqlite::Result<()> {
    let version = format!("{VERSION} {}", env!("CARGO_PKG_VERSION"));
    let present: Option<String> = connection
        .query_row("SELECT value FROM meta WHERE name='catalogue'", (), |row| row.get(0))
        .optional()?;
    if present.as_ref() == Some(&version) {
        return Ok(());
    }
    let transaction = connection.transaction()?;
    transaction.execute_batch("DELETE FROM message; DELETE FROM field; DELETE FROM label")?;
    {
        let mut message = transaction.prepare("INSERT INTO message VALUES (?1,?2,?3,?4)")?;
        let mut field = transaction.prepare("INSERT INTO field VALUES (?1,?2,?3,?4,?5,?6)")?;
        let mut label = transaction.prepare("INSERT OR IGNORE INTO label VALUES (?1,?2,?3,?4,?5,?6)")?;
        for desc in MESSAGES {
            message.execute((desc.id, desc.abbrev, desc.name, desc.summary))?;
            for (at, one) in desc.fields.iter().enumerate() {
                field.execute((desc.id, at as i64, one.abbrev, one.name, one.kind.name(), one.unit))?;
                let (values, bit) = match one.meaning {
                    Meaning::Plain => continue,
                    Meaning::Enumeration(values) => (values, false),
                    Meaning::Bitfield(values) => (values, true),
                };
                for value in values.values {
                    label.execute((desc.id, one.abbrev, value.value, bit, value.abbrev, value.name))?;
                }
            }
        }
    }
    transaction.execute("INSERT OR REPLACE INTO meta VALUES ('catalogue',?1)", [version])?;
    transaction.commit()
}

/// The names in a catalogue's file.
pub(crate) fn load_names(connection: &Connection) -> rusqlite::Result<Names> {
    let mut names = Names::default();
    let mut statement = connection.prepare("SELECT address,from_us,last_us,name,kind FROM system")?;
    let mut rows = statement.query(())?;
    while let Some(row) = rows.next()? {
        let name = SystemName { name: row.get(3)?, kind: row.get(4)? };
        let runs = names.systems.entry(row.get(0)?).or_default();
        runs.runs.insert(row.get(1)?, Run { name, last_us: row.get(2)? });
    }
    let mut statement = connection.prepare("SELECT address,entity,from_us,last_us,label FROM entity")?;
    let mut rows = statement.query(())?;
    while let Some(row) = rows.next()? {
        let runs = names.entities.entry((row.get(0)?, row.get(1)?)).or_default();
        runs.runs.insert(row.get(2)?, Run { name: row.get(4)?, last_us: row.get(3)? });
    }
    Ok(names)
}

/// The months' files that must be there. A catalogue of an earlier version does not say.
pub(crate) fn load_months(connection: &Connection) -> rusqlite::Result<BTreeSet<MonthKey>> {
    let there = "SELECT EXISTS (SELECT 1 FROM sqlite_schema WHERE type='table' AND name='month')";
    if !connection.query_row(there, (), |row| row.get::<_, bool>(0))? {
        return Ok(BTreeSet::new());
    }
    let mut statement = connection.prepare("SELECT name FROM month")?;
    let names: Vec<String> = statement.query_map((), |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    Ok(names.iter().filter_map(|name| MonthKey::from_file_name(name)).collect())
}

/// How far each day of the archive was read.
pub(crate) fn load_progress(connection: &Connection) -> rusqlite::Result<BTreeMap<DayKey, Progress>> {
    let mut statement = connection
        .prepare("SELECT address,day,data_bytes,arrival_bytes,packets,first_us,last_us FROM archived")?;
    let rows = statement.query_map((), |row| {
        let key = DayKey::of_number(Address(row.get(0)?), row.get(1)?);
        let number = |at: usize| row.get::<_, i64>(at).map(i64::cast_unsigned);
        let lengths = Lengths { data: number(2)?, arrivals: number(3)? };
        let extent = Extent { first_us: row.get(5)?, last_us: row.get(6)?, count: number(4)? };
        Ok((key, Progress { lengths, extent }))
    })?;
    rows.collect()
}
