//! Checks the files of a history before anything is written to them.

use super::{CATALOGUE, MonthKey, TRIAL_VERSION, latest_version, months};
use crate::error::{Named as _, Result, StoreError, is_damage};
use crate::opening::connect;
use rusqlite::Connection;
use std::path::Path;

/// The state of a file of the history.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sound {
    /// As far as was looked, a database as it must be.
    Yes,
    /// It has no tables: it was made and not written to, or what it held is gone.
    Empty,
    /// It is damaged, and how.
    No(String),
    /// A later version of this program wrote it.
    Newer,
}

/// Every file of a history with what it is. Nothing is written, and what cannot be read now (rights, a disk that
/// fails) counts as sound: that is not a reason to replace it.
pub(crate) fn look(folder: &Path) -> Result<Vec<(String, Sound)>> {
    let mut found = Vec::new();
    let names = months(folder)?.into_iter().map(MonthKey::file_name);
    for name in [CATALOGUE.to_owned()].into_iter().chain(names) {
        let path = folder.join(&name);
        if path.try_exists().named(&path)? {
            found.push((name, one(&path)));
        }
    }
    Ok(found)
}

/// Refuses a history of which a later version wrote some file.
pub(crate) fn refuse_newer(folder: &Path, found: &[(String, Sound)]) -> Result<()> {
    match found.iter().find(|(_, sound)| *sound == Sound::Newer) {
        Some((name, _)) => Err(StoreError::Newer { path: folder.join(name) }),
        None => Ok(()),
    }
}

fn one(path: &Path) -> Sound {
    let read = || -> rusqlite::Result<Sound> {
        let (connection, _) = connect(path)?;
        match version(&connection)? {
            version if version > latest_version(path) => return Ok(Sound::Newer),
            TRIAL_VERSION => return Ok(Sound::No("an earlier trial version compressed it".to_owned())),
            _ => {}
        }
        let tables: u32 = connection.query_row("SELECT count(*) FROM sqlite_schema", (), |row| row.get(0))?;
        if tables == 0 {
            return Ok(Sound::Empty);
        }
        for table in ["_group", "_stale", "archived", "stream"] {
            let there: bool = connection.query_row(
                "SELECT EXISTS (SELECT 1 FROM sqlite_schema WHERE type='table' AND name=?1)",
                [table],
                |row| row.get(0),
            )?;
            if there {
                // Every page of it.
                let sql = format!("SELECT count(*) FROM (SELECT * FROM {table} ORDER BY 1 DESC)");
                connection.query_row(&sql, (), |_| Ok(()))?;
            }
        }
        Ok(Sound::Yes)
    };
    match read() {
        Ok(sound) => sound,
        Err(error) if is_damage(&error) => Sound::No(error.to_string()),
        Err(_) => Sound::Yes,
    }
}

/// The version of the layout that a file has.
pub(crate) fn version(connection: &Connection) -> rusqlite::Result<i64> {
    connection.query_row("PRAGMA user_version", (), |row| row.get(0))
}
