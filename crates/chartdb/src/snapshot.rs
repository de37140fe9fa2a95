//! A chart set that is read chart by chart over hours, while imports may change it.

use crate::error::{Named as _, Result};
use crate::read::{Chart, ChartDb};
use std::path::Path;

/// A set in the state that it had when it was opened; another state is noticed, and nothing of it is read.
#[derive(Debug)]
pub struct Snapshot {
    set: ChartDb,
    charts: Vec<Chart>,
    digest: [u8; 32],
    /// The mark that manual editing left in it.
    edited: String,
    /// SQLite's count of what others changed, when the digest was compared last.
    version: i64,
}

impl Snapshot {
    /// Opens a set.
    ///
    /// # Errors
    /// When the chart set does not exist or cannot be read.
    pub fn open(path: &Path) -> Result<Self> {
        let set = ChartDb::open(path)?;
        let mut new = Self { set, charts: Vec::new(), digest: [0; 32], edited: String::new(), version: 0 };
        new.within(|new| {
            new.charts = new.set.charts_in_full()?;
            new.digest = new.set.digest()?;
            new.edited = new.set.edited()?;
            new.version = new.version_now()?;
            Ok(())
        })?;
        Ok(new)
    }

    /// Digest of its contents.
    pub fn digest(&self) -> [u8; 32] {
        self.digest
    }

    /// The charts by name, each with its present box and number of features, also where the set was edited by hand.
    pub fn charts(&self) -> &[Chart] {
        &self.charts
    }

    /// Digest of the contents of each chart.
    pub fn marks(&self) -> Vec<[u8; 32]> {
        self.charts.iter().map(|chart| chart.mark(&self.edited)).collect()
    }

    /// Reads of the set; `None` where it is in another state by now.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn read<T>(&mut self, read: impl FnOnce(&ChartDb) -> Result<T>) -> Result<Option<T>> {
        self.within(|new| {
            let version = new.version_now()?;
            if version != new.version {
                if new.set.digest()? != new.digest {
                    return Ok(None);
                }
                new.version = version;
            }
            read(&new.set).map(Some)
        })
    }

    /// Reads one state of the database, even if others change it meanwhile.
    fn within<T>(&mut self, look: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let path = self.set.path().to_owned();
        self.set.connection().execute_batch("BEGIN").named(&path)?;
        let seen = look(self);
        let ended = self.set.connection().execute_batch("COMMIT").named(&path);
        seen.and_then(|seen| ended.map(|()| seen))
    }

    fn version_now(&self) -> Result<i64> {
        let connection = self.set.connection();
        // The count is that of the state that is looked at as soon as something of it was read.
        let count = "SELECT count(*) FROM chart_set";
        let read = connection.query_row(count, [], |row| row.get::<_, i64>(0));
        let version = read.and_then(|_| connection.query_row("PRAGMA data_version", [], |row| row.get(0)));
        version.named(self.set.path())
    }
}
