//! The folder of all data of a demo.

use anyhow::{Context as _, bail};
use std::fmt;
use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::{Path, PathBuf};

/// Most names that are tried.
const NAMES: u32 = 1000;

/// A folder that only its owner may read, removed with all in it when dropped unless it is to be kept.
#[derive(Debug)]
pub(super) struct Scratch {
    path: PathBuf,
    kept: bool,
}

impl Scratch {
    /// A new one among the temporary files.
    ///
    /// # Errors
    /// It cannot be made.
    pub(super) fn temporary() -> anyhow::Result<Self> {
        let parent = std::env::temp_dir();
        for number in 0..NAMES {
            let path = parent.join(format!("lutra-demo-{}-{number}", std::process::id()));
            // Only a new one: another user's folder is never taken for ours.
            match DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => return Ok(Self { path, kept: false }),
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
        Ok(Self { path, kept: true })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl fmt::Display for Scratch {
    /// Its path, and whether it is kept.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fate = if self.kept { "which stays" } else { "which is removed at the end" };
        write!(f, "{}, {fate}", self.path.display())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if !self.kept
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

    #[test]
    fn a_folder_to_keep_is_new_and_stays() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("a/demo");
        fs::write(Scratch::kept(&path).unwrap().path().join("file"), "x").unwrap();
        assert!(path.join("file").exists());
        assert!(Scratch::kept(&path).unwrap_err().to_string().contains("not empty"));
    }
}
