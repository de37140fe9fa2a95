//! What chunks that were set aside held, and how much of that the history lacks: the rest was read again from the archive.

use super::chunk::{HEAD, Head};
use super::columns::columns_of;
use super::group::GroupKey;
use super::order::Order;
use super::rows::Question;
use super::schema::Schema;
use crate::range::TimeRange;
use rusqlite::Connection;

/// What was in chunks that were set aside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Aside {
    /// Samples that the history has not again by now.
    pub(crate) missing: u64,
    /// Which they are, for people.
    pub(crate) what: String,
}

/// The chunks of a month that were set aside.
pub(crate) fn aside(connection: &Connection, schema: &Schema) -> rusqlite::Result<Vec<Aside>> {
    if columns_of(connection, "_damaged")?.is_empty() {
        return Ok(Vec::new());
    }
    let mut statement =
        connection.prepare(&format!("SELECT {HEAD},id,src,src_ent FROM _damaged ORDER BY chunk"))?;
    let mut rows = statement.query(())?;
    let mut found = Vec::new();
    while let Some(row) = rows.next()? {
        let group = GroupKey { id: row.get(7)?, src: row.get(8)?, src_ent: row.get(9)? };
        let head = Head::read(row)?;
        let part = TimeRange { from_us: head.first.0, to_us: head.last.0.saturating_add(1) };
        let there = match schema.table(group.id) {
            Some(table) => Question::new(connection, table, group, &[], Order::Oldest)?
                .map_or(Ok(0), |mut question| question.count(part))?,
            None => 0,
        };
        found.push(Aside { missing: (head.count as u64).saturating_sub(there), what: head.told(group) });
    }
    Ok(found)
}
