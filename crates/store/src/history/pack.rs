//! Making a packed month of a month: a new file beside it, read back row by row.

use super::chunk::codec::{self, Column, FULL_BYTES, ROWS};
use super::chunk::{BEFORE, Declared, Seen, TABLES, columns_in_use, declared, is_packed, owner, rolled};
use super::columns::{SENT, columns_of};
use super::group::GroupKey;
use super::look;
use super::month::{PACKED_VERSION, VERSION};
use super::order::Order;
use super::rollup;
use super::rows::{Question, Row};
use super::schema::{KEY_COLUMNS, MONTH, SHORT, Schema};
use crate::error::{Named as _, Result, StoreError};
use crate::opening::{FileId, connect, keep_log};
use crate::range::TimeRange;
use crate::reader::{self, Memory};
use rusqlite::types::{ToSqlOutput, ValueRef};
use rusqlite::{Connection, params_from_iter};
use std::fs::File;
use std::path::Path;

/// The settings of a file that is written once, synced, and then given its name. Small pages: a chunk fills its last one by half.
const NEW: &str = "PRAGMA page_size = 1024; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; \
                   PRAGMA locking_mode = EXCLUSIVE; PRAGMA cache_size = -8000; PRAGMA temp_store = MEMORY";
/// Tables that are not copied: what they hold is in chunks, or belongs to those.
const OWN: [&str; 7] = ["_short", "_rollup", "_direction", "_chunk", "_layout", "_layout_copy", "_rolled"];
/// The columns that every question asks for first, as a chunk has them after the time.
const FIRST: [&str; BEFORE - 1] = ["hash", "received_us", "dst", "dst_ent", SENT];

/// A month that is being packed, as it was at one moment.
#[derive(Debug)]
pub(crate) struct Source {
    connection: Connection,
    /// Which file it was.
    file: FileId,
    /// SQLite's count of what others changed.
    version: i64,
}

impl Source {
    /// Opens a month. Nothing that is written to it from here on is packed.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let source = Self::watch(path)?;
        source.connection.execute_batch("BEGIN").named(path)?;
        Ok(Self { version: data_version(&source.connection).named(path)?, ..source })
    }

    /// Opens a month only to know whether something is written to it from here on.
    pub(crate) fn watch(path: &Path) -> Result<Self> {
        let (connection, file) = connect(path).named(path)?;
        Memory::EXPORT.set(&connection).named(path)?;
        let version = data_version(&connection).named(path)?;
        Ok(Self { connection, file, version })
    }

    /// Whether nothing was written since, and the file has still its name.
    pub(crate) fn is_unchanged(&self, path: &Path) -> rusqlite::Result<bool> {
        Ok(data_version(&self.connection)? == self.version && FileId::of(path) == Some(self.file))
    }

    /// Which file it is.
    pub(crate) fn file(&self) -> FileId {
        self.file
    }

    /// Ends the moment.
    fn end(&self) -> rusqlite::Result<()> {
        self.connection.execute_batch("COMMIT")
    }
}

fn data_version(connection: &Connection) -> rusqlite::Result<i64> {
    connection.query_row("PRAGMA data_version", (), |row| row.get(0))
}

/// The work that goes on in it, with its caller's say whether it goes on.
struct Work<'w> {
    schema: Schema,
    source: &'w Connection,
    target: &'w Connection,
    goes_on: &'w mut dyn FnMut(u64) -> bool,
    /// Messages that were written or compared.
    rows: u64,
    /// Rows of other tables and roll-ups.
    steps: u64,
    is_stopped: bool,
}

/// Bytes of a new file after which they are put on the disk.
const SYNC_BYTES: u64 = 8 << 20;

/// Puts a new file on the disk while it grows: one long sync at its end would hold up those of the recorder.
struct Syncing {
    file: File,
    synced: u64,
}

impl Syncing {
    /// Syncs when enough was written. What fails here fails again at the end, and is an error there.
    fn keep_up(&mut self) {
        let bytes = self.file.metadata().map_or(0, |file| file.len());
        if bytes >= self.synced + SYNC_BYTES && self.file.sync_data().is_ok() {
            self.synced = bytes;
        }
    }
}

/// Steps between two looks whether it goes on.
const STEPS: u64 = 4_096;

/// Makes a packed month of `source` in the file `part`, and reads it back. `goes_on` gets the rows that were written or compared so
/// far, and may stop it by returning false. The file is synced; how many rows are in chunks.
pub(crate) fn make(
    source: &Source,
    path: &Path,
    part: &Path,
    goes_on: &mut dyn FnMut(u64) -> bool,
) -> Result<u64> {
    let target = Connection::open(part).named(part)?;
    target.execute_batch(NEW).named(part)?;
    let mut syncing = Syncing { file: File::open(part).named(part)?, synced: 0 };
    let mut goes_on_synced = |rows| {
        syncing.keep_up();
        goes_on(rows)
    };
    let mut work = Work::new(&source.connection, &target, &mut goes_on_synced, 0);
    target.execute_batch("BEGIN").named(part)?;
    let tables = work.copy(path, part)?;
    target.execute_batch("COMMIT").named(part)?;
    let rows = work.rows;
    drop(work);
    drop(target);
    let target = reader::open(part, Memory::EXPORT).named(part)?;
    let mut work = Work::new(&source.connection, &target, goes_on, rows);
    work.compare(&tables, path, part)?;
    source.end().named(path)?;
    drop(target);
    // Who reads a file with a log holds a lock until it is closed; without one a file could be replaced below its readers.
    keep_log(part).named(part)?;
    File::open(part).and_then(|file| file.sync_all()).named(part)?;
    Ok(rows)
}

/// The tables of a month.
struct Tables {
    /// Those that stay as they are, by name.
    plain: Vec<String>,
    /// Messages, with all columns that their rows have, in tables or in chunks.
    messages: Vec<(u16, Vec<Declared>)>,
}

impl<'w> Work<'w> {
    fn new(
        source: &'w Connection,
        target: &'w Connection,
        goes_on: &'w mut dyn FnMut(u64) -> bool,
        rows: u64,
    ) -> Self {
        Self { schema: Schema::new(), source, target, goes_on, rows, steps: 0, is_stopped: false }
    }

    fn copy(&mut self, path: &Path, part: &Path) -> Result<Tables> {
        let known = look::version(self.source).named(path)?;
        if known > PACKED_VERSION {
            return Err(StoreError::Newer { path: path.to_owned() });
        }
        if known < VERSION || columns_of(self.source, "_short").named(path)?.is_empty() {
            let name = path.display();
            return Err(StoreError::Query(format!("{name} was not made ready: open the store, and it is")));
        }
        let tables = self.tables().named(path)?;
        for name in &tables.plain {
            self.copy_table(name).named(part)?;
            self.look()?;
        }
        self.target.execute_batch(MONTH).named(part)?;
        self.target.execute_batch(SHORT).named(part)?;
        self.target.execute_batch(TABLES).named(part)?;
        self.target.execute_batch(rolled::TABLE).named(part)?;
        self.pack_rolled().named(path)?;
        self.look()?;
        self.copy_short().named(part)?;
        for (id, columns) in &tables.messages {
            let mut all = 0;
            for group in self.groups(*id).named(path)? {
                all += self.pack(group, columns, path, part)?;
            }
            let there = self.count(*id).named(path)?;
            if all != there {
                return Err(differs(
                    path,
                    &format!("{there} rows of message {id}, and {all} of known series"),
                ));
            }
        }
        self.target.pragma_update(None, "user_version", PACKED_VERSION).named(part)?;
        Ok(tables)
    }

    /// The tables that the month has.
    fn tables(&self) -> rusqlite::Result<Tables> {
        let mut found = Tables { plain: Vec::new(), messages: Vec::new() };
        let mut statement = self.source.prepare(
            "SELECT name FROM sqlite_schema WHERE type='table' AND name NOT LIKE 'sqlite\\_%' ESCAPE '\\'",
        )?;
        let names: Vec<String> =
            statement.query_map((), |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
        for name in names {
            match self.schema.named(&name) {
                Some(table) => found.messages.push((table.desc.id, columns_declared(self.source, &name)?)),
                None if OWN.contains(&name.as_str()) => {}
                None => found.plain.push(name),
            }
        }
        if is_packed(self.source)? {
            for (id, columns) in columns_in_use(self.source)? {
                match found.messages.iter_mut().find(|(of, _)| *of == id) {
                    None => found.messages.push((id, columns)),
                    Some((_, all)) => {
                        let lacks =
                            |one: &Declared| !all.iter().any(|own| own.name.eq_ignore_ascii_case(&one.name));
                        let more: Vec<Declared> = columns.into_iter().filter(lacks).collect();
                        all.extend(more);
                    }
                }
            }
        }
        found.messages.sort_by_key(|(id, _)| *id);
        Ok(found)
    }

    fn groups(&self, id: u16) -> rusqlite::Result<Vec<GroupKey>> {
        let mut statement =
            self.source.prepare_cached("SELECT src,src_ent FROM _group WHERE id=?1 ORDER BY 1,2")?;
        statement
            .query_map([id], |row| Ok(GroupKey { id, src: row.get(0)?, src_ent: row.get(1)? }))?
            .collect()
    }

    /// All rows of a message, whatever group they are of.
    fn count(&self, id: u16) -> rusqlite::Result<u64> {
        let mut count: i64 = 0;
        let name = self.schema.table(id).map_or("", |table| table.desc.abbrev);
        if !columns_of(self.source, name)?.is_empty() {
            count += self
                .source
                .query_row(&format!("SELECT count(*) FROM \"{name}\""), (), |row| row.get::<_, i64>(0))?;
        }
        if is_packed(self.source)? {
            let sql = "SELECT coalesce(sum(count),0) FROM _chunk WHERE id=?1";
            count += self.source.query_row(sql, [id], |row| row.get::<_, i64>(0))?;
        }
        Ok(count.cast_unsigned())
    }

    /// Copies a table as it is, by its own definition.
    fn copy_table(&mut self, name: &str) -> rusqlite::Result<()> {
        let sql = "SELECT sql FROM sqlite_schema WHERE type='table' AND name=?1";
        let create: String = self.source.query_row(sql, [name], |row| row.get(0))?;
        self.target.execute_batch(&create)?;
        let (select, columns) = select(self.source, name)?;
        let insert = format!(
            "INSERT INTO \"{name}\" ({}) VALUES (?{})",
            quoted(&columns),
            ",?".repeat(columns.len() - 1)
        );
        let mut insert = self.target.prepare(&insert)?;
        let mut statement = self.source.prepare(&select)?;
        let mut rows = statement.query(())?;
        while let Some(row) = rows.next()? {
            let values: Vec<ToSqlOutput<'_>> = (0..columns.len())
                .map(|at| row.get_ref(at).map(ToSqlOutput::Borrowed))
                .collect::<rusqlite::Result<_>>()?;
            insert.execute(params_from_iter(values))?;
            if !self.step() {
                break;
            }
        }
        Ok(())
    }

    fn pack_rolled(&mut self) -> rusqlite::Result<()> {
        let mut chunk = rolled::Growing::new();
        let (source, target) = (self.source, self.target);
        rolled::each(source, &mut |series, level_s, cells| {
            for (at, cell) in &cells {
                chunk.add(target, (series, level_s, *at), cell)?;
                if !self.step() {
                    return Ok(false);
                }
            }
            Ok(true)
        })?;
        chunk.write(target)
    }

    /// Holds the roll-ups of the new file against those of the month.
    fn has_same_rolled(&mut self) -> rusqlite::Result<bool> {
        let (mut own, mut new) = (0, 0);
        let (mut same, mut seen) = (true, Seen::default());
        let (source, target) = (self.source, self.target);
        rolled::each(source, &mut |series, level_s, cells| {
            own += cells.len();
            if let Some((first, last)) = cells.keys().next().zip(cells.keys().next_back()) {
                let there = rollup::stored(target, series, level_s, *first..last + 1, true, &mut seen)?;
                same &= there == cells;
            }
            Ok(cells.iter().all(|_| self.step()))
        })?;
        rolled::each(target, &mut |_, _, cells| {
            new += cells.len();
            Ok(cells.iter().all(|_| self.step()))
        })?;
        let all: i64 = source.query_row("SELECT count(*) FROM _rollup", (), |row| row.get(0))?;
        Ok(same && own == new && own as i64 >= all)
    }

    /// Copies how many fields messages had that the catalogue lacks; all others have that in their chunks.
    fn copy_short(&mut self) -> rusqlite::Result<()> {
        let mut insert = self.target.prepare("INSERT INTO _short VALUES (?1,?2,?3,?4,?5,?6)")?;
        let mut statement = self.source.prepare("SELECT id,src,src_ent,time_us,hash,fields FROM _short")?;
        let mut rows = statement.query(())?;
        while let Some(row) = rows.next()? {
            let id: u16 = row.get(0)?;
            if self.schema.table(id).is_none() {
                let of: (u16, u8, i64) = (row.get(1)?, row.get(2)?, row.get(3)?);
                let (hash, fields): (i64, i64) = (row.get(4)?, row.get(5)?);
                insert.execute((id, of.0, of.1, of.2, hash, fields))?;
            }
            if !self.step() {
                break;
            }
        }
        Ok(())
    }

    /// Packs the rows of a group; how many.
    fn pack(&mut self, group: GroupKey, columns: &[Declared], path: &Path, part: &Path) -> Result<u64> {
        let Some(table) = self.schema.table(group.id) else { return Ok(0) };
        let names = names(columns);
        let question = Question::new(self.source, table, group, &names, Order::Oldest).named(path)?;
        let Some(mut question) = question else { return Ok(0) };
        let text = layout_text(columns);
        let layout = layout_of(self.target, group.id, &text).named(part)?;
        let owner = owner(group, &text);
        let mut chunk = Growing::new(names.len() + 1);
        let mut rows = question.rows(TimeRange::ALL).named(path)?;
        let mut count = 0;
        while let Some(row) = rows.next().named(path)? {
            chunk.push(row).named(path)?;
            count += 1;
            if chunk.is_full() {
                self.rows += chunk.rows as u64;
                chunk.write(self.target, group, layout, &owner).named(part)?;
                if !(self.goes_on)(self.rows) {
                    return Err(StoreError::Cancelled);
                }
            }
        }
        self.rows += chunk.rows as u64;
        chunk.write(self.target, group, layout, &owner).named(part)?;
        Ok(count)
    }

    /// Holds the new file against the month.
    fn compare(&mut self, tables: &Tables, path: &Path, part: &Path) -> Result<()> {
        for name in &tables.plain {
            if !self.is_same_table(name).named(part)? {
                return Err(differs(path, &format!("other rows of {name}")));
            }
            self.look()?;
        }
        let has_same_rolled = self.has_same_rolled().named(part)?;
        self.look()?;
        if !has_same_rolled {
            return Err(differs(path, "other roll-ups"));
        }
        for (id, columns) in &tables.messages {
            let names = names(columns);
            for group in self.groups(*id).named(path)? {
                let Some(table) = self.schema.table(group.id) else { continue };
                let ask = |connection| Question::new(connection, table, group, &names, Order::Oldest);
                let same = match (ask(self.source).named(path)?, ask(self.target).named(part)?) {
                    (None, None) => true,
                    (Some(mut own), Some(mut new)) => {
                        same_rows(&mut own, &mut new, names.len(), &mut self.rows, self.goes_on)
                            .named(part)?
                    }
                    // A group whose messages all lie in `_raw` has a table where another vessel's have one.
                    (Some(mut one), None) | (None, Some(mut one)) => one
                        .rows(TimeRange::ALL)
                        .and_then(|mut rows| rows.next().map(|row| row.is_none()))
                        .named(part)?,
                };
                if !same {
                    return Err(differs(path, &format!("other rows of {}", table.desc.abbrev)));
                }
            }
        }
        self.look()
    }

    /// Counts a row, and looks now and then whether it goes on: false where it does not, and then [`Self::look`] says so too.
    fn step(&mut self) -> bool {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS) {
            self.is_stopped |= !(self.goes_on)(self.rows);
        }
        !self.is_stopped
    }

    /// Looks whether it goes on.
    fn look(&mut self) -> Result<()> {
        self.is_stopped |= !(self.goes_on)(self.rows);
        if self.is_stopped { Err(StoreError::Cancelled) } else { Ok(()) }
    }

    fn is_same_table(&mut self, name: &str) -> rusqlite::Result<bool> {
        let (select, columns) = select(self.source, name)?;
        let (mut own, mut new) = (self.source.prepare(&select)?, self.target.prepare(&select)?);
        let (mut own, mut new) = (own.query(())?, new.query(())?);
        loop {
            match (own.next()?, new.next()?) {
                (None, None) => return Ok(true),
                (Some(own), Some(new)) => {
                    for at in 0..columns.len() {
                        if !is_same(own.get_ref(at)?, new.get_ref(at)?) {
                            return Ok(false);
                        }
                    }
                }
                _ => return Ok(false),
            }
            // Its caller looks, and ends the work.
            if !self.step() {
                return Ok(true);
            }
        }
    }
}

/// Whether two questions have the same rows.
fn same_rows(
    own: &mut Question<'_>,
    new: &mut Question<'_>,
    columns: usize,
    compared: &mut u64,
    goes_on: &mut dyn FnMut(u64) -> bool,
) -> rusqlite::Result<bool> {
    let (mut own, mut new) = (own.rows(TimeRange::ALL)?, new.rows(TimeRange::ALL)?);
    loop {
        match (own.next()?, new.next()?) {
            (None, None) => return Ok(true),
            (Some(own), Some(new)) => {
                if own.time_us()? != new.time_us()? {
                    return Ok(false);
                }
                for at in 0..columns {
                    if !is_same(own.value(at)?, new.value(at)?) {
                        return Ok(false);
                    }
                }
            }
            _ => return Ok(false),
        }
        *compared += 1;
        // Its caller asks again, and ends the work.
        if compared.is_multiple_of(STEPS) && !goes_on(*compared) {
            return Ok(true);
        }
    }
}

/// To the bit.
fn is_same(own: ValueRef<'_>, new: ValueRef<'_>) -> bool {
    match (own, new) {
        (ValueRef::Real(own), ValueRef::Real(new)) => own.to_bits() == new.to_bits(),
        (own, new) => own == new,
    }
}

fn differs(path: &Path, what: &str) -> StoreError {
    StoreError::Query(format!(
        "{} is not compressed, for the compressed file had {what}: the month stays as it is. Check the memory and the disk",
        path.display()
    ))
}

/// A chunk that fills.
struct Growing {
    columns: Vec<Column>,
    rows: usize,
}

impl Growing {
    fn new(columns: usize) -> Self {
        Self { columns: vec![Column::default(); columns], rows: 0 }
    }

    fn push(&mut self, row: Row<'_>) -> rusqlite::Result<()> {
        let (time, others) = self.columns.split_at_mut(1);
        time[0].push(ValueRef::Integer(row.time_us()?));
        for (at, column) in others.iter_mut().enumerate() {
            column.push(row.value(at)?);
        }
        self.rows += 1;
        Ok(())
    }

    fn is_full(&self) -> bool {
        self.rows == ROWS || self.columns.iter().map(Column::long_bytes).sum::<usize>() >= FULL_BYTES
    }

    /// Writes it, if it has rows, and begins the next one.
    fn write(
        &mut self,
        target: &Connection,
        group: GroupKey,
        layout: i64,
        owner: &str,
    ) -> rusqlite::Result<()> {
        let key = |row: usize, at: usize| self.columns[at].integers().map(|values| values[row]);
        let Some(last) = self.rows.checked_sub(1) else { return Ok(()) };
        let body = codec::encode(&self.columns, owner)
            .map_err(|error| rusqlite::Error::ToSqlConversionFailure(Box::new(error)))?;
        target.prepare_cached("INSERT INTO _chunk VALUES (NULL,?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)")?.execute(
            (
                group.id,
                group.src,
                group.src_ent,
                key(0, 0),
                key(0, 1),
                key(last, 0),
                key(last, 1),
                self.rows as i64,
                layout,
                body,
            ),
        )?;
        *self = Self::new(self.columns.len());
        Ok(())
    }
}

/// The names of a chunk's columns after the time.
fn names(columns: &[Declared]) -> Vec<&str> {
    FIRST.into_iter().chain(columns.iter().map(|column| column.name.as_str())).collect()
}

/// The columns of a message's table after those that every one has, without those that it computes.
fn columns_declared(connection: &Connection, table: &str) -> rusqlite::Result<Vec<Declared>> {
    let mut statement =
        connection.prepare("SELECT name || ' ' || type FROM pragma_table_info(?1) ORDER BY cid")?;
    let lines: Vec<String> =
        statement.query_map([table], |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    let is_own = |column: &Declared| !KEY_COLUMNS.iter().any(|key| key.eq_ignore_ascii_case(&column.name));
    Ok(lines.iter().map(|line| declared(line)).filter(is_own).collect())
}

fn layout_text(columns: &[Declared]) -> String {
    let lines: Vec<String> = columns.iter().map(|one| format!("{} {}", one.name, one.kind)).collect();
    lines.join("\n")
}

/// The number of a layout, which is made when it is first needed.
fn layout_of(target: &Connection, id: u16, text: &str) -> rusqlite::Result<i64> {
    let mut find = target.prepare_cached("SELECT layout FROM _layout WHERE id=?1 AND columns=?2")?;
    match find.query_row((id, text), |row| row.get(0)) {
        Err(rusqlite::Error::QueryReturnedNoRows) => {
            let layout = target
                .prepare_cached("INSERT INTO _layout (id,columns) VALUES (?1,?2)")?
                .insert((id, text))?;
            target.prepare_cached("INSERT INTO _layout_copy VALUES (?1,?2)")?.execute((layout, text))?;
            Ok(layout)
        }
        other => other,
    }
}

/// The question for all of a table that is copied, and its columns.
fn select(connection: &Connection, name: &str) -> rusqlite::Result<(String, Vec<String>)> {
    let mut statement = connection.prepare("SELECT name FROM pragma_table_info(?1) ORDER BY cid")?;
    let columns: Vec<String> =
        statement.query_map([name], |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    Ok((format!("SELECT {} FROM \"{name}\"", quoted(&columns)), columns))
}

fn quoted(columns: &[String]) -> String {
    columns.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(",")
}
