//! One file of the history, open for writing.

use super::MonthKey;
use super::chunk::{self, Late};
use super::columns::columns_of;
use super::group::GroupKey;
use super::rollup;
use super::row::{self, RowError, Sample};
use super::schema::{MONTH, SHORT, Schema, Table};
use crate::error::{Named as _, Result, StoreError};
use imc::catalogue::MESSAGES;
use imc::json::NestedText;
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The settings of every database that is written to.
///
/// A commit need not wait for the disk: the archive is the truth, and its cursor is moved only after the log of
/// this database was synced.
pub(crate) const WRITER: &str = "
PRAGMA page_size = 8192;
PRAGMA journal_mode = WAL;
PRAGMA synchronous = NORMAL;
PRAGMA cache_size = -8000;
PRAGMA temp_store = MEMORY;
PRAGMA wal_autocheckpoint = 1000;
PRAGMA journal_size_limit = 67108864;
";
/// Prepared statements that are kept: an INSERT and a roll-up of each message a fleet sends.
const STATEMENTS: usize = 256;
/// Version of the layout of the catalogue, and of months.
pub(crate) const VERSION: i64 = 1;
/// Version of the layout of packed months, and the latest that is known: earlier programs leave a history alone that has one.
pub(crate) const PACKED_VERSION: i64 = 3;
/// Version of the layout of packed months of a trial, which is not read any more.
pub(crate) const TRIAL_VERSION: i64 = 2;
/// Commits after which a window that nothing more came to is rolled up, when a later one has begun.
const QUIET_COMMITS: u64 = 2;
/// The same when none has: the entity fell silent.
const SILENT_COMMITS: u64 = 240;

/// How much of a group there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Time of the first sample (µs since 1970-01-01 UTC).
    pub first_us: i64,
    /// Time of the last.
    pub last_us: i64,
    /// How many.
    pub count: u64,
}

impl Extent {
    pub(crate) const NONE: Self = Self { first_us: i64::MAX, last_us: i64::MIN, count: 0 };

    pub(crate) fn add(&mut self, time_us: i64) {
        self.merge(Self { first_us: time_us, last_us: time_us, count: 1 });
    }

    pub(crate) fn merge(&mut self, other: Self) {
        self.first_us = self.first_us.min(other.first_us);
        self.last_us = self.last_us.max(other.last_us);
        self.count += other.count;
    }
}

/// One sample on its way into a month.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry<'a> {
    pub(crate) month: MonthKey,
    pub(crate) group: GroupKey,
    pub(crate) sample: Sample<'a>,
}

/// Which windows are rolled up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Due {
    /// All that lack something.
    All,
    /// Those of them to which nothing came for some commits.
    Quiet {
        /// The commits so far.
        commit: u64,
    },
}

#[derive(Debug)]
struct Group {
    extent: Extent,
    changed: bool,
}

#[derive(Debug)]
pub(crate) struct Month {
    key: MonthKey,
    path: PathBuf,
    connection: Connection,
    /// Of a packed month.
    late: Option<Late>,
    tables: BTreeSet<u16>,
    groups: BTreeMap<GroupKey, Group>,
    /// Windows whose roll-ups do not hold all samples, with the commit that last added one.
    stale: BTreeMap<(GroupKey, i64), u64>,
    nested: NestedText,
}

impl Month {
    pub(crate) fn open(folder: &Path, key: MonthKey) -> Result<Self> {
        let path = folder.join(key.file_name());
        let open = || -> rusqlite::Result<_> {
            let connection = Connection::open(&path)?;
            connection.execute_batch(WRITER)?;
            connection.set_prepared_statement_cache_capacity(STATEMENTS);
            let version: i64 = connection.query_row("PRAGMA user_version", (), |row| row.get(0))?;
            if version > PACKED_VERSION {
                return Ok(None);
            }
            connection.execute_batch(MONTH)?;
            make_short(&connection)?;
            // One that has it is not written to.
            if version < VERSION {
                connection.pragma_update(None, "user_version", VERSION)?;
            }
            let late = chunk::is_packed(&connection)?.then(Late::default);
            let (groups, stale) = (load_groups(&connection)?, load_stale(&connection)?);
            Ok(Some((connection, late, groups, stale)))
        };
        let Some((connection, late, groups, stale)) = open().named(&path)? else {
            return Err(StoreError::Newer { path });
        };
        Ok(Self {
            key,
            path,
            connection,
            late,
            tables: BTreeSet::new(),
            groups,
            stale,
            nested: NestedText::default(),
        })
    }

    /// Adds the samples that are not there yet, in one transaction; how many those were.
    pub(crate) fn write(&mut self, schema: &Schema, entries: &[Entry<'_>], commit: u64) -> Result<u64> {
        let path = self.path.clone();
        self.connection.execute_batch("BEGIN IMMEDIATE").named(&path)?;
        let written = self.write_all(schema, entries, commit);
        self.end(written).named(&path)
    }

    /// Brings roll-ups up to date, in one transaction, until about `budget` samples were read. Returns how many were read.
    pub(crate) fn roll_up(&mut self, schema: &Schema, due: Due, budget: u64) -> Result<u64> {
        let due = self.due(due);
        if due.is_empty() {
            return Ok(0);
        }
        let path = self.path.clone();
        self.connection.execute_batch("BEGIN IMMEDIATE").named(&path)?;
        let rolled = self.roll_up_some(schema, &due, budget);
        self.end(rolled).named(&path)
    }

    /// When the very message first arrived (µs), if it is there.
    pub(crate) fn arrival_of(&mut self, schema: &Schema, entry: &Entry<'_>) -> Result<Option<i64>> {
        let time_us = entry.sample.time_us;
        let known = schema.table(entry.group.id);
        // Most imports bring what is all before or after what is there.
        let possible = self
            .groups
            .get(&entry.group)
            .is_some_and(|group| (group.extent.first_us..=group.extent.last_us).contains(&time_us));
        let path = self.path.clone();
        let sample = &entry.sample;
        let (src, src_ent) = (entry.group.src, entry.group.src_ent);
        if let Some(table) = known.filter(|_| possible) {
            let found = arrival_of_known(&self.connection, table, entry, self.late.as_mut()).named(&path)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        // Messages that do not fit their id are in `_raw`.
        let sql =
            "SELECT received_us FROM _raw WHERE src=?1 AND src_ent=?2 AND id=?3 AND time_us=?4 AND hash=?5";
        let find = |mut find: rusqlite::CachedStatement<'_>| {
            find.query_row((src, src_ent, entry.group.id, time_us, sample.hash), |row| row.get(0)).optional()
        };
        self.connection.prepare_cached(sql).and_then(find).named(&path)
    }

    /// Windows that wait for their roll-ups.
    pub(crate) fn stale(&self) -> usize {
        self.stale.len()
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn end<T>(&mut self, result: rusqlite::Result<T>) -> rusqlite::Result<T> {
        let result = result.and_then(|value| self.connection.execute_batch("COMMIT").map(|()| value));
        if result.is_err() {
            if !self.connection.is_autocommit() {
                self.connection.execute_batch("ROLLBACK").ok();
            }
            // The memory must match the file.
            self.late.iter_mut().for_each(Late::forget);
            self.tables.clear();
            self.groups = load_groups(&self.connection).unwrap_or_default();
            self.stale = load_stale(&self.connection).unwrap_or_default();
        }
        result
    }

    fn write_all(&mut self, schema: &Schema, entries: &[Entry<'_>], commit: u64) -> rusqlite::Result<u64> {
        let mut rows = 0;
        for run in entries.chunk_by(|a, b| a.group.id == b.group.id) {
            rows += match schema.table(run[0].group.id) {
                Some(table) => self.write_known(table, run, commit)?,
                None => self.write_unknown(run)?,
            };
        }
        self.save_groups()?;
        Ok(rows)
    }

    fn write_known(&mut self, table: &Table, run: &[Entry<'_>], commit: u64) -> rusqlite::Result<u64> {
        self.make_table(table)?;
        let mut insert = self.connection.prepare_cached(&table.insert)?;
        let mut rows = 0;
        for same in run.chunk_by(|a, b| a.group == b.group) {
            let mut added = Extent::NONE;
            let mut window = None;
            for entry in same {
                if let Some(late) = &mut self.late {
                    let Sample { time_us, hash, received_us, .. } = entry.sample;
                    if !late.admits(&self.connection, table, entry.group, (time_us, hash), received_us)? {
                        continue;
                    }
                }
                let fields = match row::bind(&mut insert, table, &entry.sample, &mut self.nested) {
                    Ok(fields) => fields,
                    Err(RowError::Payload(problem)) => {
                        insert.clear_bindings();
                        rows += write_raw(&self.connection, entry, &problem.to_string())?;
                        continue;
                    }
                    Err(RowError::OtherMessage) => {
                        rows += write_raw(&self.connection, entry, &other_message(table, entry))?;
                        continue;
                    }
                    Err(RowError::Sqlite(error)) => return Err(error),
                };
                if insert.raw_execute()? == 0 {
                    keep_first(&self.connection, &table.earlier, entry)?;
                    continue;
                }
                if fields < table.desc.fields.len() {
                    mark_short(&self.connection, entry, fields)?;
                }
                let time_us = entry.sample.time_us;
                added.add(time_us);
                let its_window = rollup::window(time_us);
                if window != Some(its_window) && self.key != MonthKey::Undated {
                    window = Some(its_window);
                    if self.stale.insert((entry.group, its_window), commit).is_none() {
                        mark_stale(&self.connection, entry.group, its_window)?;
                    }
                }
            }
            rows += added.count;
            add_to_group(&mut self.groups, same[0].group, added);
        }
        Ok(rows)
    }

    fn write_unknown(&mut self, run: &[Entry<'_>]) -> rusqlite::Result<u64> {
        let mut rows = 0;
        for entry in run {
            if write_raw(&self.connection, entry, "the catalogue has no message with this id")? > 0 {
                rows += 1;
                let mut added = Extent::NONE;
                added.add(entry.sample.time_us);
                add_to_group(&mut self.groups, entry.group, added);
            }
        }
        Ok(rows)
    }

    fn make_table(&mut self, table: &Table) -> rusqlite::Result<()> {
        if !self.tables.insert(table.desc.id) {
            return Ok(());
        }
        let present = columns_of(&self.connection, table.desc.abbrev)?;
        if present.is_empty() {
            return self.connection.execute_batch(&table.create());
        }
        table.add_missing(&present).iter().try_for_each(|statement| self.connection.execute_batch(statement))
    }

    fn save_groups(&mut self) -> rusqlite::Result<()> {
        let mut save =
            self.connection.prepare_cached("INSERT OR REPLACE INTO _group VALUES (?1,?2,?3,?4,?5,?6)")?;
        for (key, group) in &mut self.groups {
            if group.changed {
                let Extent { first_us, last_us, count } = group.extent;
                save.execute((key.id, key.src, key.src_ent, first_us, last_us, count as i64))?;
                group.changed = false;
            }
        }
        Ok(())
    }

    /// Windows whose turn it is.
    fn due(&self, due: Due) -> Vec<(GroupKey, i64)> {
        let ready = |(group, window): &(GroupKey, i64), touched: u64| {
            let later_began =
                self.groups.get(group).is_some_and(|group| rollup::window(group.extent.last_us) > *window);
            let Due::Quiet { commit } = due else { return true };
            let quiet = commit.saturating_sub(touched);
            quiet >= SILENT_COMMITS || later_began && quiet >= QUIET_COMMITS
        };
        self.stale.iter().filter(|(key, touched)| ready(key, **touched)).map(|(key, _)| *key).collect()
    }

    fn roll_up_some(
        &mut self,
        schema: &Schema,
        due: &[(GroupKey, i64)],
        budget: u64,
    ) -> rusqlite::Result<u64> {
        let mut read = 0;
        for (group, window) in due {
            if read >= budget {
                break;
            }
            if let Some(table) = schema.table(group.id) {
                read += rollup::roll_up(&self.connection, table, *group, *window)?;
            }
            self.connection
                .prepare_cached("DELETE FROM _stale WHERE id=?1 AND src=?2 AND src_ent=?3 AND window=?4")?
                .execute((group.id, group.src, group.src_ent, window))?;
            self.stale.remove(&(*group, *window));
        }
        Ok(read)
    }
}

fn add_to_group(groups: &mut BTreeMap<GroupKey, Group>, key: GroupKey, added: Extent) {
    if added.count > 0 {
        let group = groups.entry(key).or_insert(Group { extent: Extent::NONE, changed: true });
        group.extent.merge(added);
        group.changed = true;
    }
}

/// When the message of a table first arrived, if it is there. A packed month, with `late`, may have no such table.
fn arrival_of_known(
    connection: &Connection,
    table: &Table,
    entry: &Entry<'_>,
    late: Option<&mut Late>,
) -> rusqlite::Result<Option<i64>> {
    let Sample { time_us, hash, .. } = entry.sample;
    if let Some(late) = late {
        let found = late.arrival_of(connection, entry.group, (time_us, hash))?;
        if found.is_some() || columns_of(connection, table.desc.abbrev)?.is_empty() {
            return Ok(found);
        }
    }
    // By its whole key: many messages have one time where a sender has no clock.
    let sql = format!(
        "SELECT received_us FROM \"{}\" WHERE src=?1 AND src_ent=?2 AND time_us=?3 AND hash=?4",
        table.desc.abbrev
    );
    let key = (entry.group.src, entry.group.src_ent, time_us, hash);
    connection.prepare_cached(&sql)?.query_row(key, |row| row.get(0)).optional()
}

fn other_message(table: &Table, entry: &Entry<'_>) -> String {
    let bytes = entry.sample.view.payload().len();
    format!(
        "its payload of {bytes} bytes is not that of {}: another message has this id in the sender's IMC",
        table.desc.abbrev
    )
}

fn write_raw(connection: &Connection, entry: &Entry<'_>, problem: &str) -> rusqlite::Result<u64> {
    let sample = &entry.sample;
    let view = &sample.view;
    let rows = connection
        .prepare_cached("INSERT OR IGNORE INTO _raw VALUES (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)")?
        .execute((
            view.src().0,
            view.src_ent(),
            view.id(),
            sample.time_us,
            sample.hash,
            sample.received_us,
            view.dst().0,
            view.dst_ent(),
            view.payload(),
            problem,
        ))?;
    if rows == 0 {
        keep_first(connection, EARLIER_RAW, entry)?;
    }
    Ok(rows as u64)
}

/// Messages of `_raw` with an earlier arrival than is known.
const EARLIER_RAW: &str = "UPDATE _raw SET received_us=?5,dst=?6,dst_ent=?7 \
     WHERE src=?1 AND src_ent=?2 AND time_us=?3 AND hash=?4 AND id=?8 AND received_us>?5";

/// A row that is there stands for the first arrival of its message, in whatever order the archive is read.
fn keep_first(connection: &Connection, earlier: &str, entry: &Entry<'_>) -> rusqlite::Result<()> {
    let Sample { view, received_us, time_us, hash } = &entry.sample;
    let mut update = connection.prepare_cached(earlier)?;
    update
        .execute((
            view.src().0,
            view.src_ent(),
            time_us,
            hash,
            received_us,
            view.dst().0,
            view.dst_ent(),
            view.id(),
        ))
        .map(drop)
}

/// Makes the table of what was not whole. Rows of an earlier version do not say; of theirs those fields count as left out that
/// came with a later release of the message, and other NULLs as NaN.
fn make_short(connection: &Connection) -> rusqlite::Result<()> {
    if !columns_of(connection, "_short")?.is_empty() {
        return Ok(());
    }
    connection.execute_batch("BEGIN IMMEDIATE")?;
    let made = || -> rusqlite::Result<()> {
        connection.execute_batch(SHORT)?;
        for desc in MESSAGES {
            let present = columns_of(connection, desc.abbrev)?;
            let first = desc.fields.iter().position(|field| field.appended);
            let Some(first) = first.filter(|_| !present.is_empty()) else { continue };
            let absent = desc.fields[first..].iter().map(|field| {
                let there = present.iter().any(|name| name.eq_ignore_ascii_case(field.abbrev));
                if there { format!(" AND \"{}\" IS NULL", field.abbrev) } else { String::new() }
            });
            let absent: String = absent.collect();
            connection.execute_batch(&format!(
                "INSERT INTO _short SELECT {},src,src_ent,time_us,hash,{first} FROM \"{}\" WHERE 1{absent}",
                desc.id, desc.abbrev
            ))?;
        }
        connection.execute_batch("COMMIT")
    };
    made().inspect_err(|_| drop(connection.execute_batch("ROLLBACK")))
}

/// Remembers that a message had so many fields only.
fn mark_short(connection: &Connection, entry: &Entry<'_>, fields: usize) -> rusqlite::Result<()> {
    let GroupKey { id, src, src_ent } = entry.group;
    let Sample { time_us, hash, .. } = entry.sample;
    connection
        .prepare_cached("INSERT OR IGNORE INTO _short VALUES (?1,?2,?3,?4,?5,?6)")?
        .execute((id, src, src_ent, time_us, hash, fields as i64))
        .map(drop)
}

fn mark_stale(connection: &Connection, group: GroupKey, window: i64) -> rusqlite::Result<()> {
    connection
        .prepare_cached("INSERT OR IGNORE INTO _stale VALUES (?1,?2,?3,?4)")?
        .execute((group.id, group.src, group.src_ent, window))
        .map(drop)
}

fn load_groups(connection: &Connection) -> rusqlite::Result<BTreeMap<GroupKey, Group>> {
    let mut statement = connection.prepare("SELECT id,src,src_ent,first_us,last_us,count FROM _group")?;
    let rows = statement.query_map((), |row| {
        let key = GroupKey { id: row.get(0)?, src: row.get(1)?, src_ent: row.get(2)? };
        let extent = Extent {
            first_us: row.get(3)?,
            last_us: row.get(4)?,
            count: row.get::<_, i64>(5)?.cast_unsigned(),
        };
        Ok((key, Group { extent, changed: false }))
    })?;
    rows.collect()
}

fn load_stale(connection: &Connection) -> rusqlite::Result<BTreeMap<(GroupKey, i64), u64>> {
    let mut statement = connection.prepare("SELECT id,src,src_ent,window FROM _stale")?;
    let rows = statement.query_map((), |row| {
        let key = GroupKey { id: row.get(0)?, src: row.get(1)?, src_ent: row.get(2)? };
        Ok(((key, row.get(3)?), 0))
    })?;
    rows.collect()
}
