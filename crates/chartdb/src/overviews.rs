//! Results from charts that a server keeps between starts, so that it need not compute them again: bytes by a key and a
//! zoom, in a SQLite database beside the set. It may be deleted at any time.

use crate::error::{Named as _, Result};
use crate::read::PATIENCE;
use rusqlite::{Connection, OptionalExtension as _, params};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Another one whenever the tables change.
const VERSION: i64 = 1;

/// Bytes by key and zoom.
#[derive(Debug)]
pub struct Overviews {
    connection: Connection,
    path: PathBuf,
}

impl Overviews {
    /// Those of a chart set: `chart.gpkg` has `chart.lutra-overviews`.
    pub fn path(db: &Path) -> PathBuf {
        db.with_extension("lutra-overviews")
    }

    /// Opens the overviews of a chart set; a missing or damaged file is made new.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn open(db: &Path) -> Result<Self> {
        let path = Self::path(db);
        let opened = Self::opened(&path);
        if opened.as_ref().is_err_and(|error| !error.is_busy()) && path.is_file() {
            crate::part_file::forget(&path)?;
            return Self::opened(&path);
        }
        opened
    }

    fn opened(path: &Path) -> Result<Self> {
        let open = || -> rusqlite::Result<Connection> {
            let connection = Connection::open(path)?;
            connection.busy_timeout(PATIENCE)?;
            // Data lost in a power cut is made again.
            connection.pragma_update(None, "synchronous", "OFF")?;
            let version: i64 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
            if version != VERSION {
                connection.execute_batch(
                    "BEGIN IMMEDIATE; DROP TABLE IF EXISTS overviews; CREATE TABLE overviews \
                     (key BLOB NOT NULL, zoom INTEGER NOT NULL, checksum INTEGER NOT NULL, bytes BLOB NOT NULL, \
                     PRIMARY KEY (key, zoom)) WITHOUT ROWID; COMMIT",
                )?;
                connection.pragma_update(None, "user_version", VERSION)?;
            }
            Ok(connection)
        };
        Ok(Self { connection: open().named(path)?, path: path.to_owned() })
    }

    /// The stored bytes; `None` also where they are damaged.
    pub fn get(&self, key: &[u8; 32], zoom: u8) -> Option<Vec<u8>> {
        let get = || -> rusqlite::Result<Option<(u32, Vec<u8>)>> {
            let select = "SELECT checksum, bytes FROM overviews WHERE key = ?1 AND zoom = ?2";
            let mut select = self.connection.prepare_cached(select)?;
            select.query_row(params![key, zoom], |row| Ok((row.get(0)?, row.get(1)?))).optional()
        };
        let (checksum, bytes) = get().ok()??;
        (crc32fast::hash(&bytes) == checksum).then_some(bytes)
    }

    /// Keeps bytes for zoom 0 and those that follow.
    ///
    /// # Errors
    /// When the disk does not take them.
    pub fn put(&mut self, key: &[u8; 32], zooms: &[Vec<u8>]) -> Result<()> {
        let mut put = || -> rusqlite::Result<()> {
            let all = self.connection.transaction()?;
            for (zoom, bytes) in (0_u8..).zip(zooms) {
                all.prepare_cached("INSERT OR REPLACE INTO overviews VALUES (?1, ?2, ?3, ?4)")?
                    .execute(params![key, zoom, crc32fast::hash(bytes), bytes])?;
            }
            all.commit()
        };
        put().named(&self.path)
    }

    /// Forgets what has none of these keys.
    ///
    /// # Errors
    /// When the disk does not do it.
    pub fn retain(&mut self, keys: &BTreeSet<[u8; 32]>) -> Result<()> {
        let mut retain = || -> rusqlite::Result<()> {
            let all = self.connection.transaction()?;
            let held: Vec<[u8; 32]> = all
                .prepare("SELECT DISTINCT key FROM overviews")?
                .query_map([], |row| row.get(0))?
                .collect::<rusqlite::Result<_>>()?;
            for key in held.iter().filter(|key| !keys.contains(*key)) {
                all.execute("DELETE FROM overviews WHERE key = ?1", [key])?;
            }
            all.commit()
        };
        retain().named(&self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_there_at_the_next_start_and_damage_is_as_good_as_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let db = folder.path().join("chart.gpkg");
        let zooms = [vec![1, 2, 3], Vec::new(), vec![7; 5_000]];
        Overviews::open(&db).unwrap().put(&[7; 32], &zooms).unwrap();
        let mut kept = Overviews::open(&db).unwrap();
        let got = (0..4).map(|zoom| kept.get(&[7; 32], zoom)).collect::<Vec<_>>();
        assert_eq!(got, [Some(vec![1, 2, 3]), Some(Vec::new()), Some(vec![7; 5_000]), None]);
        assert_eq!(kept.get(&[8; 32], 0), None);
        kept.put(&[8; 32], &zooms).unwrap();
        kept.retain(&BTreeSet::from([[8; 32]])).unwrap();
        assert_eq!((kept.get(&[7; 32], 0), kept.get(&[8; 32], 0)), (None, Some(vec![1, 2, 3])));
        drop(kept);

        let path = Overviews::path(&db);
        let mut bytes = std::fs::read(&path).unwrap();
        let at = bytes.windows(100).position(|window| window == [7; 100]).unwrap();
        bytes[at] = 6;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(Overviews::open(&db).unwrap().get(&[8; 32], 2), None);
        // A file that is not a database is made again.
        std::fs::write(&path, [7; 10_000]).unwrap();
        assert_eq!(Overviews::open(&db).unwrap().get(&[8; 32], 0), None);
    }
}
