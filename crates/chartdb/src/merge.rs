//! Brings the charts of an import into a set in one SQLite transaction: until it is done, readers see the set as it was. If the
//! program is killed, the next one that opens the set rolls the transaction back.

use crate::error::{ChartDbError, Named as _, Result};
use crate::read::{ChartDb, PATIENCE};
use crate::schema::{self, FEATURE_TABLES};
use crate::write;
use rusqlite::{Connection, OptionalExtension as _};
use std::collections::BTreeSet;
use std::path::Path;

/// Brings the charts of `part` into the set whose digest is `base`, and takes others out.
///
/// # Errors
/// When the set is another by now, another program uses it for too long, or a disk does not do it.
pub(crate) fn into(live: &Path, part: &Path, base: &str, gone: &BTreeSet<String>, time: &str) -> Result<()> {
    let busy = |error: rusqlite::Error| match error.sqlite_error_code() {
        Some(rusqlite::ErrorCode::DatabaseBusy | rusqlite::ErrorCode::DatabaseLocked) => {
            ChartDbError::Busy(live.to_owned())
        }
        _ => ChartDbError::Sqlite { path: live.to_owned(), source: error },
    };
    let connection = Connection::open(live).named(live)?;
    connection.busy_timeout(PATIENCE).named(live)?;
    let has_log = has_log(&connection).map_err(busy)?;
    connection.pragma_update(None, "synchronous", "FULL").named(live)?;
    // KiB: what does not fit is written before its time, and locks readers out.
    connection.pragma_update(None, "cache_size", -65_536).named(live)?;
    connection.execute("ATTACH ?1 AS change", [part.to_string_lossy()]).named(part)?;
    connection.execute_batch("BEGIN IMMEDIATE").map_err(busy)?;
    // Dropped before its end, the transaction is undone.
    let set = ChartDb::of(connection, live)?;
    if hex::encode(set.digest()?) != base {
        return Err(ChartDbError::Locked(live.to_owned()));
    }
    bring(set.connection(), gone, time).map_err(busy)?;
    set.connection().execute_batch("COMMIT").map_err(busy)?;
    if has_log {
        // Readers see the log at once. A server notices the change by the file's time, so the log goes into the file.
        set.connection().execute_batch("PRAGMA wal_checkpoint(TRUNCATE)").map_err(busy)?;
    }
    Ok(())
}

/// Whether the set has a write-ahead log, as QGIS leaves it: removed unless another process has the set open.
fn has_log(connection: &Connection) -> rusqlite::Result<bool> {
    let mode = |sql: &str| connection.query_row(sql, [], |row| row.get::<_, String>(0));
    let mode = match mode("PRAGMA journal_mode = DELETE") {
        Err(error) if error.sqlite_error_code() == Some(rusqlite::ErrorCode::DatabaseBusy) => {
            mode("PRAGMA journal_mode")?
        }
        other => other?,
    };
    Ok(mode == "wal")
}

fn bring(connection: &Connection, gone: &BTreeSet<String>, time: &str) -> rusqlite::Result<()> {
    schema::drop_triggers(connection)?;
    for name in gone {
        write::remove(connection, name)?;
    }
    let mut select = connection.prepare("SELECT id, name FROM change.cells ORDER BY id")?;
    let charts = select.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let mut numbers: Vec<(i64, i64)> = Vec::new();
    for chart in charts {
        let (there, name): (i64, String) = chart?;
        write::remove(connection, &name)?;
        let columns = columns(connection, "cells", &["id"])?;
        let copy =
            format!("INSERT INTO main.cells ({columns}) SELECT {columns} FROM change.cells WHERE id = ?1");
        connection.prepare_cached(&copy)?.execute([there])?;
        numbers.push((there, connection.last_insert_rowid()));
    }
    for (table, ..) in FEATURE_TABLES {
        features(connection, table, &numbers)?;
    }
    for (table, number) in [("objects", "fid"), ("coverage", "id"), ("import_log", "id")] {
        let columns = columns(connection, table, &[number, "source"])?;
        let copy = format!(
            "INSERT INTO main.{table} (source, {columns}) SELECT ?2, {columns} FROM change.{table} \
             WHERE source = ?1 ORDER BY {number}"
        );
        let mut copy = connection.prepare(&copy)?;
        for (there, here) in &numbers {
            copy.execute([there, here])?;
        }
    }
    let columns = columns(connection, "import_log", &["id"])?;
    connection.execute(
        &format!(
            "INSERT INTO main.import_log ({columns}) SELECT {columns} FROM change.import_log \
             WHERE source IS NULL ORDER BY id"
        ),
        [],
    )?;
    schema::finish(connection, time)
}

/// The rows of a table with geometry, numbered on from those that there are, with their boxes.
fn features(connection: &Connection, table: &str, numbers: &[(i64, i64)]) -> rusqlite::Result<()> {
    let last = "SELECT seq FROM main.sqlite_sequence WHERE name = ?1";
    let last: i64 = connection.query_row(last, [table], |row| row.get(0)).optional()?.unwrap_or(0);
    let columns = columns(connection, table, &["fid", "source"])?;
    let rows = format!(
        "INSERT INTO main.{table} (fid, source, {columns}) SELECT fid + ?3, ?2, {columns} FROM change.{table} \
         WHERE source = ?1 ORDER BY fid"
    );
    let boxes = format!(
        "INSERT INTO main.rtree_{table}_geom SELECT r.id + ?2, r.minx, r.maxx, r.miny, r.maxy \
         FROM change.{table} t JOIN change.rtree_{table}_geom r ON r.id = t.fid WHERE t.source = ?1 ORDER BY t.fid"
    );
    let (mut rows, mut boxes) = (connection.prepare(&rows)?, connection.prepare(&boxes)?);
    for (there, here) in numbers {
        rows.execute([*there, *here, last])?;
        boxes.execute([*there, last])?;
    }
    Ok(())
}

/// The columns of a table but some: those of the change, for a user may have added others to the set.
fn columns(connection: &Connection, table: &str, without: &[&str]) -> rusqlite::Result<String> {
    let mut select = connection.prepare_cached("SELECT name FROM pragma_table_info(?1, 'change')")?;
    let names: Vec<String> = select.query_map([table], |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    let wanted = names.into_iter().filter(|name| !without.contains(&name.as_str()));
    Ok(wanted.collect::<Vec<_>>().join(", "))
}
