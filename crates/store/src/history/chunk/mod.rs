//! Packed months: the rows of messages' tables as compressed chunks.
//!
//! A packed month has the tables of every month, except those of messages: their rows are in `_chunk`, some of one group each, in
//! the order of the key, and its roll-ups are in `_rolled`. What still comes for it goes into ordinary tables. Chunks do not overlap, and no ordinary row lies
//! within one: a row that comes for the time of a chunk makes ordinary rows of all of it ([`late`]). The next packing makes
//! chunks again. The columns of many chunks are listed once, in `_layout`, and once more in `_layout_copy`: whichever a chunk's sum
//! confirms counts, so that no single fault there makes all of a message unreadable.

pub(super) mod codec;
mod late;
mod read;
pub(super) mod rolled;

pub(crate) use late::Late;
pub(super) use read::{Chunks, Open};
pub(crate) use rolled::Seen;
pub(super) use rolled::add as add_rolled;

use super::group::GroupKey;
use codec::Damaged;
use rusqlite::{Connection, OptionalExtension as _, Row};
use units::UtcTime;

/// The tables that a packed month has beside those of all months.
pub(super) const TABLES: &str = "
CREATE TABLE IF NOT EXISTS _layout (
  layout INTEGER PRIMARY KEY, id INTEGER NOT NULL, columns TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS _layout_copy (layout INTEGER PRIMARY KEY, columns TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS _chunk (
  chunk INTEGER PRIMARY KEY, id INTEGER NOT NULL, src INTEGER NOT NULL, src_ent INTEGER NOT NULL,
  first_us INTEGER NOT NULL, first_hash INTEGER NOT NULL, last_us INTEGER NOT NULL, last_hash INTEGER NOT NULL,
  count INTEGER NOT NULL, layout INTEGER NOT NULL, body BLOB NOT NULL);
CREATE UNIQUE INDEX IF NOT EXISTS _chunk_key ON _chunk (
  id, src, src_ent, first_us, first_hash, last_us, last_hash, count, layout);
";
/// Chunks that could not be read, as they were; made with the first one.
const DAMAGED: &str = "CREATE TABLE IF NOT EXISTS _damaged AS SELECT *,'' AS columns FROM _chunk WHERE 0";
/// Columns of a chunk before those of the message: time, fingerprint, arrival, receiver, and how many fields were sent.
pub(super) const BEFORE: usize = 6;
/// The place of the last of them.
const SENT_AT: usize = BEFORE - 1;
/// What [`Head::read`] reads.
pub(super) const HEAD: &str = "chunk,first_us,first_hash,last_us,last_hash,count,layout";

/// Whether a month has chunks, or had some.
pub(crate) fn is_packed(connection: &Connection) -> rusqlite::Result<bool> {
    Ok(!super::columns::columns_of(connection, "_chunk")?.is_empty())
}

/// How many rows are in the chunks of a packed month.
pub(crate) fn rows(connection: &Connection) -> rusqlite::Result<u64> {
    connection
        .query_row("SELECT coalesce(sum(count),0) FROM _chunk", (), |row| row.get::<_, i64>(0))
        .map(i64::cast_unsigned)
}

/// Reads all of a month's chunks; the first that is damaged, if any is.
pub(crate) fn check(connection: &Connection) -> rusqlite::Result<()> {
    if !is_packed(connection)? {
        return Ok(());
    }
    let mut statement = connection.prepare(&format!("SELECT {HEAD},id,src,src_ent FROM _chunk"))?;
    let mut rows = statement.query(())?;
    while let Some(row) = rows.next()? {
        let group = GroupKey { id: row.get(7)?, src: row.get(8)?, src_ent: row.get(9)? };
        let head = Head::read(row)?;
        Open::read(connection, group, &head, |declared| (0..BEFORE + declared.len()).map(Some).collect())?;
    }
    rolled::check(connection)
}

/// A time, and the fingerprint that tells messages of one microsecond apart.
pub(super) type Key = (i64, i64);

/// What is known of a chunk before it is unpacked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Head {
    chunk: i64,
    pub(super) first: Key,
    pub(super) last: Key,
    pub(super) count: usize,
    layout: i64,
}

impl Head {
    pub(super) fn read(row: &Row<'_>) -> rusqlite::Result<Self> {
        Ok(Self {
            chunk: row.get(0)?,
            first: (row.get(1)?, row.get(2)?),
            last: (row.get(3)?, row.get(4)?),
            count: row.get::<_, u32>(5)? as usize,
            layout: row.get(6)?,
        })
    }

    /// Which samples it holds, for people.
    pub(super) fn told(&self, group: GroupKey) -> String {
        let message = imc::catalogue::by_id(group.id);
        let message = message.map_or_else(|| format!("message {}", group.id), |desc| desc.abbrev.to_owned());
        let [from, to] = [self.first.0, self.last.0].map(UtcTime::from_micros);
        let GroupKey { src, src_ent, .. } = group;
        format!("{message} of {src:#06x}, entity {src_ent}, from {from} to {to}")
    }

    fn damaged(&self, group: GroupKey, why: Damaged) -> rusqlite::Error {
        let text = format!("{}: {why}", self.told(group));
        DamagedChunk { place: Place::Rows(self.chunk), text }.into()
    }
}

/// Where a chunk lies in its month.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// In `_chunk`.
    Rows(i64),
    /// In `_rolled`.
    Rolled(i64),
}

/// A chunk that cannot be read. The others can.
#[derive(Debug, thiserror::Error)]
#[error(
    "a chunk is damaged, {text}. All other times can be read; stop the server and run `lutra-server reindex`, which makes the \
     history again from the archive"
)]
struct DamagedChunk {
    place: Place,
    text: String,
}

impl From<DamagedChunk> for rusqlite::Error {
    fn from(damaged: DamagedChunk) -> Self {
        Self::ToSqlConversionFailure(Box::new(damaged))
    }
}

/// The chunk that is damaged, if an error says so.
pub(crate) fn damaged(error: &rusqlite::Error) -> Option<Place> {
    match error {
        rusqlite::Error::ToSqlConversionFailure(source) => {
            source.downcast_ref().map(|damaged: &DamagedChunk| damaged.place)
        }
        _ => None,
    }
}

/// Moves a damaged chunk out of the way, in one transaction: its samples do not count any more, and its bytes stay in `_damaged`.
/// Roll-ups are made again. Nothing happens where it is gone.
pub(crate) fn set_aside(connection: &mut Connection, place: Place) -> rusqlite::Result<()> {
    let transaction = connection.transaction()?;
    match place {
        Place::Rows(chunk) => {
            transaction.execute_batch(DAMAGED)?;
            let which = lost_with(&transaction, chunk)?;
            transaction.execute_batch(&format!(
                "INSERT INTO _damaged SELECT *,(SELECT columns FROM _layout WHERE _layout.layout=_chunk.layout) \
                 FROM _chunk WHERE {which};
                 UPDATE _group SET count=max(0,_group.count-gone.count) FROM \
                 (SELECT id,src,src_ent,sum(count) AS count FROM _chunk WHERE {which} GROUP BY 1,2,3) AS gone \
                 WHERE _group.id=gone.id AND _group.src=gone.src AND _group.src_ent=gone.src_ent;
                 DELETE FROM _chunk WHERE {which}"
            ))?;
        }
        Place::Rolled(rolled) => rolled::remove(&transaction, rolled)?,
    }
    transaction.commit()
}

/// Which chunks are lost with one that is damaged, as a condition: that alone, or all that have its columns where their list is gone.
fn lost_with(connection: &Connection, chunk: i64) -> rusqlite::Result<String> {
    let mut find = connection.prepare("SELECT layout FROM _chunk WHERE chunk=?1")?;
    let layout: Option<i64> = find.query_row([chunk], |row| row.get(0)).optional()?;
    Ok(match layout {
        Some(layout) if layouts(connection, layout)?.is_empty() => format!("layout={layout}"),
        _ => format!("chunk={chunk}"),
    })
}

/// A column of a message's table, and its type in SQL.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Declared {
    pub(super) name: String,
    pub(super) kind: String,
}

/// The columns of a layout as they stand in the month, which are those of a chunk after the first [`BEFORE`]; `None` when they do not
/// stand there.
fn layout(connection: &Connection, layout: i64) -> rusqlite::Result<Option<String>> {
    let mut find = connection.prepare_cached("SELECT columns FROM _layout WHERE layout=?1")?;
    find.query_row([layout], |row| row.get(0)).optional()
}

/// Their copy.
fn layout_copy(connection: &Connection, layout: i64) -> rusqlite::Result<Option<String>> {
    if super::columns::columns_of(connection, "_layout_copy")?.is_empty() {
        return Ok(None);
    }
    let mut find = connection.prepare_cached("SELECT columns FROM _layout_copy WHERE layout=?1")?;
    find.query_row([layout], |row| row.get(0)).optional()
}

/// Both, as far as they are there.
fn layouts(connection: &Connection, number: i64) -> rusqlite::Result<Vec<String>> {
    let both = [layout(connection, number)?, layout_copy(connection, number)?];
    Ok(both.into_iter().flatten().collect())
}

/// The messages that chunks are of, and their columns by the first chunk of each layout.
pub(super) fn columns_in_use(connection: &Connection) -> rusqlite::Result<Vec<(u16, Vec<Declared>)>> {
    let mut statement = connection.prepare(
        "SELECT layout,id,src,src_ent,body FROM _chunk WHERE chunk IN (SELECT min(chunk) FROM _chunk GROUP BY layout) ORDER BY layout",
    )?;
    let mut rows = statement.query(())?;
    let mut found = Vec::new();
    while let Some(row) = rows.next()? {
        let group = GroupKey { id: row.get(1)?, src: row.get(2)?, src_ent: row.get(3)? };
        let texts = layouts(connection, row.get(0)?)?;
        let body = row.get_ref(4)?.as_blob()?;
        let is_its = |text: &&String| codec::Body::open(body, &owner(group, text)).is_ok();
        if let Some(text) = texts.iter().find(is_its).or(texts.first()) {
            found.push((group.id, declared_in(text)));
        }
    }
    Ok(found)
}

/// The columns of a layout's text.
pub(super) fn declared_in(text: &str) -> Vec<Declared> {
    text.lines().map(declared).collect()
}

/// What a chunk's sum covers beside its bytes.
pub(super) fn owner(group: GroupKey, layout: &str) -> String {
    let GroupKey { id, src, src_ent } = group;
    format!("{id} {src} {src_ent}\n{layout}")
}

pub(super) fn declared(line: &str) -> Declared {
    let (name, kind) = line.split_once(' ').unwrap_or((line, ""));
    Declared { name: name.to_owned(), kind: kind.to_owned() }
}
