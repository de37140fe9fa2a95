//! One agent for one data folder: a locked file with the owner's process.

use anyhow::Context as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;

const NAME: &str = "agent.lock";

/// The folder of data is in use by another agent.
#[derive(Debug)]
pub(crate) struct InUse(String);

impl std::fmt::Display for InUse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for InUse {}

/// The lock of a folder, held as long as this lives; the system releases it when the process ends in any way.
#[derive(Debug)]
pub(crate) struct DataLock(File);

impl DataLock {
    /// Locks a folder, making it if needed.
    pub(crate) fn take(folder: &Path) -> anyhow::Result<Self> {
        fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        let path = folder.join(NAME);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .with_context(|| format!("opening {}", path.display()))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut process = String::new();
                file.read_to_string(&mut process).ok();
                let text = format!(
                    "another lutra-agent (process {}) uses {}; end it, or give this one a folder of its own \
                     with --data",
                    process.trim(),
                    folder.display()
                );
                return Err(InUse(text).into());
            }
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| format!("locking {}", path.display()));
            }
        }
        // Only for people; the lock works without the number.
        let note = file.set_len(0).and_then(|()| file.rewind());
        note.and_then(|()| writeln!(file, "{}", std::process::id())).ok();
        Ok(Self(file))
    }
}

impl Drop for DataLock {
    fn drop(&mut self) {
        self.0.set_len(0).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_owner_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new");
        let first = DataLock::take(&path).unwrap();
        let refused = DataLock::take(&path).unwrap_err();
        assert!(refused.is::<InUse>());
        assert!(refused.to_string().contains(&std::process::id().to_string()), "{refused}");
        drop(first);
        DataLock::take(&path).unwrap();
    }
}
