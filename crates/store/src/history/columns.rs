//! The columns of a month's tables, and the one that stands for how much of a message was sent.

use rusqlite::Connection;

/// Stands among the names of columns for the number of fields that a message had: NULL for all of them. Where the month is of an
/// earlier version, which does not know, it is 0.
pub(crate) const SENT: &str = "(sent)";

/// The columns that a table has, those it computes included; none when there is no such table.
pub(crate) fn columns_of(connection: &Connection, table: &str) -> rusqlite::Result<Vec<String>> {
    let mut statement = connection.prepare_cached("SELECT name FROM pragma_table_xinfo(?1)")?;
    statement.query_map([table], |row| row.get(0))?.collect()
}
