//! Removal of old data.

use crate::archive;
use crate::error::{Named as _, Result};
use crate::history;
use crate::store::Store;
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

const DAY_US: i64 = 86_400_000_000;

/// What may go. The archive can bring back months of the history (by `reindex`); nothing brings back the archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Retention {
    /// Months of the history that ended before this.
    pub history_before: Option<UtcTime>,
    /// Days of the archive that ended before this, by arrival.
    pub archive_before: Option<UtcTime>,
}

/// A part that is removed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Removal {
    /// A month's file or a day's folder.
    pub path: PathBuf,
    /// Bytes that it frees.
    pub bytes: u64,
}

/// The parts that a retention would remove.
///
/// # Errors
/// When folders cannot be read.
pub fn plan_retention(data: &Path, retention: &Retention) -> Result<Vec<Removal>> {
    let mut removals = Vec::new();
    let folder = data.join("history");
    for key in history::months(&folder)? {
        let ended = key.range_us().map(|(_, end_us)| end_us);
        let old =
            retention.history_before.is_some_and(|before| ended.is_some_and(|end| end <= before.micros()));
        if old {
            let path = folder.join(key.file_name());
            let bytes = fs::metadata(&path).named(&path)?.len();
            removals.push(Removal { path, bytes });
        }
    }
    let root = data.join("archive");
    for key in archive::days(&root)? {
        let ended = key.start().map(|start| start.micros() + DAY_US);
        let old =
            retention.archive_before.is_some_and(|before| ended.is_some_and(|end| end <= before.micros()));
        if old {
            let path = key.folder(&root);
            let bytes = archive::bytes::disk_bytes(&path);
            removals.push(Removal { path, bytes });
        }
    }
    Ok(removals)
}

impl Store {
    /// Removes the parts of a retention; returns them.
    ///
    /// Waiting packets are committed and saved first, so that nothing is removed that the history has not read.
    ///
    /// # Errors
    /// When something could not be written or removed.
    pub fn retain(&mut self, retention: &Retention) -> Result<Vec<Removal>> {
        self.commit()?;
        self.settle()?;
        let removals = plan_retention(self.folder(), retention)?;
        self.remove(&removals)?;
        Ok(removals)
    }

    /// Removes this, which is of its own history and archive. Everything that waits is committed and saved first.
    ///
    /// # Errors
    /// When something could not be written or removed.
    pub fn remove(&mut self, removals: &[Removal]) -> Result<()> {
        self.commit()?;
        self.settle()?;
        self.close_months()?;
        let root = self.folder().join("archive");
        let removed = |path: &Path| removals.iter().any(|removal| removal.path == path);
        let mut days = archive::days(&root)?;
        days.retain(|key| removed(&key.folder(&root)));
        let folder = self.folder().join("history");
        let mut months = history::months(&folder)?;
        months.retain(|key| removed(&folder.join(key.file_name())));
        if removals.iter().any(|removal| removal.path.is_dir()) {
            archive::mark_trimmed(&root)?;
        }
        // Data removed on purpose must not count as missing.
        self.give_up(&days, &months)?;
        for removal in removals {
            let path = &removal.path;
            if path.is_dir() {
                // The data goes first: a folder without it is not a day, so a power cut here leaves only litter.
                for file in archive::bytes::day_files(path) {
                    match fs::remove_file(&file) {
                        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                            return Err(error).named(&file);
                        }
                        _ => {}
                    }
                }
                fs::remove_dir_all(path).named(path)?;
            } else {
                fs::remove_file(path).named(path)?;
                for end in ["-wal", "-shm"] {
                    let mut beside = path.clone().into_os_string();
                    beside.push(end);
                    fs::remove_file(beside).ok();
                }
            }
        }
        self.forget_days(&days);
        Ok(())
    }
}
