//! What is written by one transaction: rows by their table, each once, and names.

use super::layout::TableId;
use super::row::{Item, Row};
use imc::names::SystemName;
use std::collections::BTreeMap;

/// The rows of a batch.
#[derive(Debug, Default)]
pub(super) struct Batch<'i> {
    /// In order of their keys; of several with one key, that which came first.
    pub(super) rows: BTreeMap<TableId, Vec<&'i Row>>,
    /// Who spoke, and the newest name that it gave itself, with when (PostgreSQL's count).
    pub(super) vessels: BTreeMap<u16, Option<(i64, &'i SystemName)>>,
}

impl<'i> Batch<'i> {
    pub(super) fn of(items: &'i [Item]) -> Self {
        let mut batch = Self::default();
        for item in items {
            for row in std::iter::once(&item.row).chain(&item.detection) {
                batch.rows.entry(row.table).or_default().push(row);
            }
            let key = item.row.key;
            let known = batch.vessels.entry(key.src).or_default();
            if let Some(name) = &item.name
                && known.is_none_or(|(time, _)| time <= key.time)
            {
                *known = Some((key.time, name));
            }
        }
        for rows in batch.rows.values_mut() {
            rows.sort_by_key(|row| (row.key, row.received_us));
            rows.dedup_by_key(|row| row.key);
        }
        batch
    }
}

/// Rows as COPY takes them.
pub(super) fn copied(rows: &[&Row]) -> Vec<u8> {
    // Its signature, no flags, no more of a header.
    const BEGIN: &[u8; 19] = b"PGCOPY\n\xff\r\n\0\0\0\0\0\0\0\0\0";
    const END: [u8; 2] = (-1_i16).to_be_bytes();
    let bytes: usize = rows.iter().map(|row| row.tuple.len()).sum();
    let mut data = Vec::with_capacity(BEGIN.len() + bytes + END.len());
    data.extend_from_slice(BEGIN);
    for row in rows {
        data.extend_from_slice(&row.tuple);
    }
    data.extend_from_slice(&END);
    data
}
