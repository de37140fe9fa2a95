//! The folder of all data of a demo. While the demo runs it holds a lock on a file in it, so that the next one can remove the folder
//! of one that was killed.

use crate::cli::say::{complain, say};
use anyhow::{Context as _, bail};
use std::fmt;
use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};

/// Most names that are tried.
const NAMES: u32 = 1000;

/// How the names of folders begin; then come the number of the process, and one that makes them different.
const PREFIX: &str = "lutra-demo-";
/// The file in a folder that the demo has locked while it runs.
const LOCK: &str = "lock";

/// A folder that only its owner may read, removed with all in it when dropped unless it is to be kept.
#[derive(Debug)]
pub(super) struct Scratch {
    path: PathBuf,
    /// The lock; `None` for a folder that is kept.
    lock: Option<File>,
}

impl Scratch {
    /// A new one among the temporary files.
    ///
    /// # Errors
    /// It cannot be made.
    pub(super) fn temporary() -> anyhow::Result<Self> {
        let parent = std::env::temp_dir();
        for number in 0..NAMES {
            let path = parent.join(format!("{PREFIX}{}-{number}", std::process::id()));
            // Only a new one: another user's folder is never taken for ours.
            match DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => {
                    let lock = File::create(path.join(LOCK)).and_then(|file| file.lock().map(|()| file));
                    let lock = lock.with_context(|| format!("cannot lock {}", path.display()))?;
                    return Ok(Self { path, lock: Some(lock) });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => {
                    return Err(error).with_context(|| {
                        format!(
                            "cannot make {}: set TMPDIR to a folder that takes it, or give --keep DIR",
                            path.display()
                        )
                    });
                }
            }
        }
        bail!("{} is full of folders lutra-demo-*: remove them", parent.display())
    }

    /// This one, which must be new or empty.
    ///
    /// # Errors
    /// It is not empty, or cannot be made.
    pub(super) fn kept(path: &Path) -> anyhow::Result<Self> {
        let about = || format!("cannot make {}", path.display());
        DirBuilder::new().mode(0o700).recursive(true).create(path).with_context(about)?;
        let path = path.canonicalize().with_context(about)?;
        if fs::read_dir(&path).with_context(about)?.next().is_some() {
            bail!("--keep {}: the folder is not empty; choose a new one", path.display());
        }
        Ok(Self { path, lock: None })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

/// Removes the folders of demos that were killed, and says so: nobody else would.
pub(super) fn remove_left(parent: &Path) {
    for folder in left(parent) {
        match fs::remove_dir_all(&folder) {
            Ok(()) => say!("removed   {}, which a demo left that was killed", folder.display()),
            Err(error) => {
                complain!("{}, which a demo left that was killed, is not removed: {error}", folder.display());
            }
        }
    }
}

/// The folders of demos whose process is gone. One that has no lock yet may be of a demo that begins just now.
fn left(parent: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(parent) else { return Vec::new() };
    let is_left = |folder: &PathBuf| {
        let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let process = name.strip_prefix(PREFIX).and_then(|rest| rest.split('-').next()).unwrap_or_default();
        let is_gone =
            process.parse::<u32>().is_ok_and(|id| !Path::new("/proc").join(id.to_string()).exists());
        // A process of another container has no number here.
        is_gone && File::open(folder.join(LOCK)).is_ok_and(|file| file.try_lock().is_ok())
    };
    // Links are passed over: what they point to is no demo's.
    let folders = entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    folders.map(|entry| entry.path()).filter(is_left).collect()
}

impl fmt::Display for Scratch {
    /// Its path, and whether it is kept.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fate = if self.lock.is_none() { "which stays" } else { "which is removed at the end" };
        write!(f, "{}, {fate}", self.path.display())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if self.lock.is_some()
            && let Err(error) = fs::remove_dir_all(&self.path)
        {
            tracing::warn!(%error, folder = %self.path.display(), "the scratch folder is not removed");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_kept_is_gone() {
        let scratch = Scratch::temporary().unwrap();
        let path = scratch.path().to_owned();
        fs::write(path.join("file"), "x").unwrap();
        assert_ne!(Scratch::temporary().unwrap().path(), path);
        drop(scratch);
        assert!(!path.exists());
    }

    /// Numbers of processes end at 4,194,304 on Linux.
    const NO_PROCESS: u32 = 4_200_000;

    #[test]
    fn the_folder_of_a_demo_that_was_killed_is_found_and_no_other() {
        let parent = tempfile::tempdir().unwrap();
        let folder = |name: &str, lock: bool| {
            let path = parent.path().join(name);
            fs::create_dir(&path).unwrap();
            let file = lock.then(|| File::create(path.join(LOCK)).unwrap());
            (path, file)
        };
        let (killed, _) = folder(&format!("{PREFIX}{NO_PROCESS}-0"), true);
        let (_, elsewhere) = folder(&format!("{PREFIX}{NO_PROCESS}-1"), true);
        elsewhere.as_ref().unwrap().lock().unwrap();
        folder(&format!("{PREFIX}{NO_PROCESS}-2"), false);
        folder(&format!("{PREFIX}{}-0", std::process::id()), true);
        folder("lutra-demo-notes", true);
        std::os::unix::fs::symlink(&killed, parent.path().join(format!("{PREFIX}{NO_PROCESS}-3"))).unwrap();
        assert_eq!(left(parent.path()), std::slice::from_ref(&killed));
        remove_left(parent.path());
        assert!(!killed.exists());
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 5);
    }

    #[test]
    fn a_folder_to_keep_is_new_and_stays() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("a/demo");
        fs::write(Scratch::kept(&path).unwrap().path().join("file"), "x").unwrap();
        assert!(path.join("file").exists());
        assert!(Scratch::kept(&path).unwrap_err().to_string().contains("not empty"));
    }
}
