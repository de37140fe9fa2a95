//! Rows that come for a packed month.

use super::read::Open;
use super::{BEFORE, Declared, HEAD, Head, Key, SENT_AT};
use crate::history::columns::columns_of;
use crate::history::group::GroupKey;
use crate::history::schema::{KEY_COLUMNS, Table};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OptionalExtension as _};

/// The place of the arrival among a chunk's columns.
const RECEIVED_AT: usize = 2;

/// Makes way for rows that come for a packed month.
#[derive(Default)]
pub(crate) struct Late {
    /// The chunk that was looked at last, with its arrivals.
    seen: Option<(GroupKey, Head, Open)>,
}

impl std::fmt::Debug for Late {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Late").finish_non_exhaustive()
    }
}

impl Late {
    /// Whether a row with this key may be new or came earlier than the history knows, so that it is to be written; then no chunk
    /// has it any more. The table is there.
    pub(crate) fn admits(
        &mut self,
        connection: &Connection,
        table: &Table,
        group: GroupKey,
        key: Key,
        received_us: i64,
    ) -> rusqlite::Result<bool> {
        let Some((head, open)) = self.covering(connection, group, key)? else { return Ok(true) };
        if arrival(open, key).is_some_and(|known_us| known_us <= received_us) {
            return Ok(false);
        }
        unpack(connection, table, group, head)?;
        self.seen = None;
        Ok(true)
    }

    /// When the row with this key first arrived (µs), if a chunk has it.
    pub(crate) fn arrival_of(
        &mut self,
        connection: &Connection,
        group: GroupKey,
        key: Key,
    ) -> rusqlite::Result<Option<i64>> {
        Ok(self.covering(connection, group, key)?.and_then(|(_, open)| arrival(open, key)))
    }

    /// The chunk within which a key lies, with its arrivals.
    fn covering(
        &mut self,
        connection: &Connection,
        group: GroupKey,
        key: Key,
    ) -> rusqlite::Result<Option<(&Head, &Open)>> {
        let is_within = |of: GroupKey, head: &Head| of == group && (head.first..=head.last).contains(&key);
        if !self.seen.as_ref().is_some_and(|(of, head, _)| is_within(*of, head)) {
            let Some(head) = covering(connection, group, key)? else { return Ok(None) };
            let open = Open::read(connection, group, &head, |_| vec![Some(RECEIVED_AT)])?;
            self.seen = Some((group, head, open));
        }
        Ok(self.seen.as_ref().map(|(_, head, open)| (head, open)))
    }

    /// Forgets what it knows of the file, which was written to or not after all.
    pub(crate) fn forget(&mut self) {
        self.seen = None;
    }
}

/// When a row of a chunk with its arrivals alone first arrived.
fn arrival(open: &Open, key: Key) -> Option<i64> {
    match open.value(open.find(key)?, 0) {
        ValueRef::Integer(known_us) => Some(known_us),
        _ => None,
    }
}

/// The head of the chunk within which a key lies.
fn covering(connection: &Connection, group: GroupKey, key: Key) -> rusqlite::Result<Option<Head>> {
    let mut find = connection.prepare_cached(&format!(
        "SELECT {HEAD} FROM _chunk WHERE id=?1 AND src=?2 AND src_ent=?3 AND (first_us,first_hash)<=(?4,?5) \
         ORDER BY first_us DESC,first_hash DESC LIMIT 1"
    ))?;
    let of = (group.id, group.src, group.src_ent, key.0, key.1);
    Ok(find.query_row(of, Head::read).optional()?.filter(|head| head.last >= key))
}

/// Makes ordinary rows of a chunk.
fn unpack(connection: &Connection, table: &Table, group: GroupKey, head: &Head) -> rusqlite::Result<()> {
    let name = table.desc.abbrev;
    let mut declared = Vec::new();
    let open = Open::read(connection, group, head, |found| {
        declared = found.to_vec();
        (0..BEFORE + found.len()).map(Some).collect()
    })?;
    let present = columns_of(connection, name)?;
    for Declared { name: column, kind } in &declared {
        // A column that this version's catalogue lacks.
        if !present.iter().any(|one| one.eq_ignore_ascii_case(column)) {
            connection.execute_batch(&format!("ALTER TABLE \"{name}\" ADD COLUMN \"{column}\" {kind}"))?;
        }
    }
    let mut sql = format!("INSERT INTO \"{name}\" ({}", KEY_COLUMNS.join(","));
    for Declared { name, .. } in &declared {
        sql.extend([",\"", name, "\""]);
    }
    let columns = KEY_COLUMNS.len() + declared.len();
    sql.extend([") VALUES (?", &",?".repeat(columns - 1), ")"]);
    let mut insert = connection.prepare_cached(&sql)?;
    let mut short = connection.prepare_cached("INSERT INTO _short VALUES (?1,?2,?3,?4,?5,?6)")?;
    for row in 0..open.rows() {
        insert.raw_bind_parameter(1, group.src)?;
        insert.raw_bind_parameter(2, group.src_ent)?;
        let places = (0..SENT_AT).chain(BEFORE..BEFORE + declared.len());
        for (at, place) in places.enumerate() {
            insert
                .raw_bind_parameter(at + 3, rusqlite::types::ToSqlOutput::Borrowed(open.value(row, place)))?;
        }
        insert.raw_execute()?;
        if let ValueRef::Integer(fields) = open.value(row, SENT_AT) {
            let (time_us, hash) = open.key(row);
            short.execute((group.id, group.src, group.src_ent, time_us, hash, fields))?;
        }
    }
    connection.prepare_cached("DELETE FROM _chunk WHERE chunk=?1")?.execute([head.chunk]).map(drop)
}
