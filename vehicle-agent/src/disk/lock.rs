//! One agent for one data folder: a locked file with the owner's process.

use anyhow::{Context as _, ensure};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;

const NAME: &str = "agent.lock";
/// What stands in a folder of an agent, also before its first run: `provision` brings the chart.
const OWN: [&str; 5] = [NAME, "chart", "logs", "plans", "spool"];

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
    /// Locks a folder, making it if needed. One that holds other things and nothing of an agent's is left as it is.
    pub(crate) fn take(folder: &Path) -> anyhow::Result<Self> {
        refuse_foreign(folder)?;
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

/// A mistyped folder must not fill with plans and logs: one of the system's that holds others and nothing of an agent's.
fn refuse_foreign(folder: &Path) -> anyhow::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    if !is_systems(&folder.canonicalize()?) {
        return Ok(());
    }
    let names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let is_own = names.iter().any(|name| OWN.contains(&name.as_str()));
    ensure!(
        is_own || names.is_empty(),
        "{} is a folder of the system, and nothing in it is an agent's. Nothing was changed; name a folder of the agent's own \
         with --data, like /var/lib/lutra-agent",
        folder.display()
    );
    Ok(())
}

/// Whether a folder is one that the system made for itself or for others to make theirs in (Filesystem Hierarchy Standard).
fn is_systems(folder: &Path) -> bool {
    const WITHIN: [&str; 8] = ["/bin", "/boot", "/etc", "/lib", "/proc", "/sbin", "/sys", "/usr"];
    const ITSELF: [&str; 8] = ["/", "/home", "/media", "/mnt", "/root", "/var", "/var/lib", "/var/log"];
    WITHIN.iter().any(|one| folder.starts_with(one)) || ITSELF.iter().any(|one| folder == Path::new(one))
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

    #[test]
    fn a_folder_of_the_system_is_left_as_it_is() {
        let refused = refuse_foreign(Path::new("/etc")).unwrap_err().to_string();
        assert!(
            refused.contains("/etc is a folder of the system") && refused.contains("--data"),
            "{refused}"
        );
        for own in ["/var/lib/lutra-agent", "/home/otter", "/data", "/tmp/x/dev"] {
            assert!(!is_systems(Path::new(own)), "{own}");
        }
        // A folder outside the system's may hold other things.
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("dev")).unwrap();
        DataLock::take(folder.path()).unwrap();
    }
}
