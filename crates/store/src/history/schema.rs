//! The tables of the history, made from IMC's catalogue when the program runs.
//!
//! One wide table per message, named as the message, a column per field, named as the field:
//!
//! | column | content |
//! |---|---|
//! | `src`, `src_ent` | address of the system and number of the entity that sent it |
//! | `time_us` | time by the sender's clock (µs since 1970-01-01 UTC) |
//! | `hash` | fingerprint of the payload: distinguishes messages of one microsecond |
//! | `received_us` | when it first came ashore, by the shore's clock |
//! | `dst`, `dst_ent` | destination |
//! | fields | numbers as they are (enumerations and bit fields too), text as text, raw data as a blob, nested messages and lists as JSON in the form of `imc::json` |
//! | `…_deg` | latitudes and longitudes once more in degrees |
//! | `true_lat_deg`, `true_lon_deg` | of `EstimatedState`: the reference point displaced by x, y and z |
//!
//! The first four are the key, in this order: one series lies together on disk, which makes reading it 50 to
//! 180 times faster than with the time first. Text that is not UTF-8 is kept as a blob.
//!
//! SQLite has no NaN: it is kept as NULL, as is a field that an older sender left out. Which of the two it is tells `_short`,
//! which holds how many fields a message had where it had not all; a month of an earlier version has no such table. The time
//! of a message whose stamp is no time (NaN, infinite, beyond 64 bits of microseconds) is the least integer, [`NO_TIME_US`].
//!
//! [`NO_TIME_US`]: crate::range::NO_TIME_US

use imc::catalogue::{MESSAGES, MessageDesc};
use std::cell::OnceCell;
use std::fmt::Write as _;
use tables::{Column, ColumnKind};

/// Columns before the fields.
pub(crate) const KEY_COLUMNS: [&str; 7] =
    ["src", "src_ent", "time_us", "hash", "received_us", "dst", "dst_ent"];
/// The message with columns that are computed when it is written.
pub(crate) const ESTIMATED_STATE: u16 = 350;

/// The table of one message.
#[derive(Debug)]
pub struct Table {
    /// The message.
    pub desc: &'static MessageDesc,
    /// The columns after the key: first the message's fields, then the computed ones.
    pub columns: Vec<Column>,
    pub(crate) insert: String,
    /// Positions in `columns` of the numbers.
    pub(crate) numbers: Vec<usize>,
    /// Lets a row stand for an earlier arrival than it knows.
    pub(crate) earlier: String,
}

impl Table {
    fn new(desc: &'static MessageDesc) -> Self {
        let columns = tables::columns(desc);
        let numbers: Vec<usize> = (0..columns.len()).filter(|at| columns[*at].is_number()).collect();
        let mut insert = format!("INSERT OR IGNORE INTO \"{}\" ({}", desc.abbrev, KEY_COLUMNS.join(","));
        for column in &columns {
            write!(insert, ",\"{}\"", column.name).ok();
        }
        insert.push_str(") VALUES (?1");
        for at in 2..=KEY_COLUMNS.len() + columns.len() {
            write!(insert, ",?{at}").ok();
        }
        insert.push(')');
        let earlier = format!(
            "UPDATE \"{}\" SET received_us=?5,dst=?6,dst_ent=?7 WHERE src=?1 AND src_ent=?2 AND time_us=?3 \
             AND hash=?4 AND received_us>?5 AND ?8>=0",
            desc.abbrev
        );
        Self { desc, columns, insert, numbers, earlier }
    }

    /// The column with this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The statement that makes the table.
    pub(crate) fn create(&self) -> String {
        let mut sql = format!(
            "CREATE TABLE IF NOT EXISTS \"{}\" (src INTEGER NOT NULL, src_ent INTEGER NOT NULL, \
             time_us INTEGER NOT NULL, hash INTEGER NOT NULL, received_us INTEGER, dst INTEGER, dst_ent INTEGER",
            self.desc.abbrev
        );
        for column in &self.columns {
            write!(sql, ", {}", declaration(column)).ok();
        }
        for column in &self.columns {
            if let Some(degrees) = degrees_column(column) {
                write!(sql, ", {degrees}").ok();
            }
        }
        sql.push_str(", PRIMARY KEY (src, src_ent, time_us, hash)) WITHOUT ROWID");
        sql
    }

    /// The statements that add the columns which a table of an older catalogue lacks.
    pub(crate) fn add_missing(&self, present: &[String]) -> Vec<String> {
        let lacks = |name: &str| !present.iter().any(|one| one.eq_ignore_ascii_case(name));
        let mut statements = Vec::new();
        let mut add = |declaration: &str| {
            statements.push(format!("ALTER TABLE \"{}\" ADD COLUMN {declaration}", self.desc.abbrev));
        };
        for column in &self.columns {
            if lacks(column.name) {
                add(&declaration(column));
            }
            if let Some(degrees) = degrees_column(column).filter(|_| lacks(&format!("{}_deg", column.name))) {
                add(&degrees);
            }
        }
        statements
    }
}

/// All tables, each made when first asked for.
#[derive(Debug)]
pub(crate) struct Schema {
    tables: Vec<OnceCell<Table>>,
}

impl Schema {
    pub(crate) fn new() -> Self {
        Self { tables: MESSAGES.iter().map(|_| OnceCell::new()).collect() }
    }

    /// The table of a message of the catalogue.
    pub(crate) fn table(&self, id: u16) -> Option<&Table> {
        let at = MESSAGES.binary_search_by_key(&id, |message| message.id).ok()?;
        Some(self.tables[at].get_or_init(|| Table::new(MESSAGES[at])))
    }

    /// The table of a message by its name.
    pub(crate) fn named(&self, abbrev: &str) -> Option<&Table> {
        self.table(imc::catalogue::by_abbrev(abbrev)?.id)
    }
}

fn declaration(column: &Column) -> String {
    let kind = match column.kind {
        ColumnKind::Integer => "INTEGER",
        ColumnKind::Single | ColumnKind::Double => "REAL",
        ColumnKind::Text | ColumnKind::Nested => "TEXT",
        ColumnKind::Raw => "BLOB",
    };
    format!("\"{}\" {kind}", column.name)
}

/// A latitude or longitude once more in degrees; computed when read, it takes no room.
fn degrees_column(column: &Column) -> Option<String> {
    let name = column.name;
    (column.is_place() && column.unit == Some("rad"))
        .then(|| format!("\"{name}_deg\" REAL GENERATED ALWAYS AS (\"{name}\" * 57.29577951308232) VIRTUAL"))
}

/// The tables that every month has beside the messages' tables.
pub(crate) const MONTH: &str = "
CREATE TABLE IF NOT EXISTS _group (
  id INTEGER NOT NULL, src INTEGER NOT NULL, src_ent INTEGER NOT NULL,
  first_us INTEGER NOT NULL, last_us INTEGER NOT NULL, count INTEGER NOT NULL,
  PRIMARY KEY (id, src, src_ent)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS _field (
  series INTEGER PRIMARY KEY, id INTEGER NOT NULL, src INTEGER NOT NULL, src_ent INTEGER NOT NULL,
  field TEXT NOT NULL, UNIQUE (id, src, src_ent, field));
CREATE TABLE IF NOT EXISTS _rollup (
  series INTEGER NOT NULL, level_s INTEGER NOT NULL, cell INTEGER NOT NULL,
  first_us INTEGER NOT NULL, count INTEGER NOT NULL, min REAL NOT NULL, max REAL NOT NULL, sum REAL NOT NULL,
  first REAL NOT NULL, last REAL NOT NULL,
  PRIMARY KEY (series, level_s, cell)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS _direction (
  series INTEGER NOT NULL, level_s INTEGER NOT NULL, cell INTEGER NOT NULL,
  count INTEGER NOT NULL, cos REAL NOT NULL, sin REAL NOT NULL,
  PRIMARY KEY (series, level_s, cell)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS _stale (
  id INTEGER NOT NULL, src INTEGER NOT NULL, src_ent INTEGER NOT NULL, window INTEGER NOT NULL,
  PRIMARY KEY (id, src, src_ent, window)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS _raw (
  src INTEGER NOT NULL, src_ent INTEGER NOT NULL, id INTEGER NOT NULL, time_us INTEGER NOT NULL,
  hash INTEGER NOT NULL, received_us INTEGER, dst INTEGER, dst_ent INTEGER, payload BLOB, problem TEXT,
  PRIMARY KEY (src, src_ent, id, time_us, hash)) WITHOUT ROWID;
";

/// Distinguishes a NaN from a field that an older sender left out.
pub(crate) const SHORT: &str = "
CREATE TABLE _short (
  id INTEGER NOT NULL, src INTEGER NOT NULL, src_ent INTEGER NOT NULL, time_us INTEGER NOT NULL,
  hash INTEGER NOT NULL, fields INTEGER NOT NULL,
  PRIMARY KEY (id, src, src_ent, time_us, hash)) WITHOUT ROWID;
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_of_the_catalogue_gets_a_table() {
        let connection = rusqlite::Connection::open_in_memory().unwrap();
        connection.execute_batch(MONTH).unwrap();
        let schema = Schema::new();
        for message in MESSAGES {
            let table = schema.table(message.id).unwrap();
            connection.execute_batch(&table.create()).unwrap();
            connection.prepare(&table.insert).unwrap();
        }
    }

    #[test]
    fn a_table_of_an_older_catalogue_gains_the_columns_it_lacks() {
        let connection = rusqlite::Connection::open_in_memory().unwrap();
        let schema = Schema::new();
        let table = schema.named("TBRFishTag").unwrap();
        connection
            .execute_batch(
                "CREATE TABLE TBRFishTag (src INTEGER NOT NULL, src_ent INTEGER NOT NULL, time_us INTEGER NOT NULL, \
                 hash INTEGER NOT NULL, received_us INTEGER, dst INTEGER, dst_ent INTEGER, serial_no INTEGER, \
                 PRIMARY KEY (src, src_ent, time_us, hash)) WITHOUT ROWID",
            )
            .unwrap();
        for statement in table.add_missing(&["serial_no".to_owned()]) {
            connection.execute_batch(&statement).unwrap();
        }
        connection.prepare(&table.insert).unwrap();
        connection.prepare("SELECT lat_deg, lon_deg FROM TBRFishTag").unwrap();
    }
}
