//! Restores a data folder from a backup.

use super::manifest::{Entry, Manifest, copy};
use crate::folder::RESTORING;
use anyhow::{Context as _, bail, ensure};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// Result of a restore.
#[derive(Debug)]
pub struct Restored {
    /// Files that were restored.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// When the backup was made, µs since 1970 UTC.
    pub made_us: i64,
    /// Files of the history that were damaged; the server rebuilds them from the archive.
    pub made_again: Vec<PathBuf>,
    /// Files from outside of the data folder: their original path, and where they are now.
    pub outside: Vec<(PathBuf, PathBuf)>,
}

/// Makes the data folder `data`, which must be absent or empty, of a backup. It appears whole or not at all: the restore
/// works in another folder, beside `data` if that is absent, inside it if it exists, such as a mounted disk. While the
/// working folder is inside, no program accepts `data` as a data folder ([`crate::folder::check`]), and the next restore
/// starts over. A restore locks the working folder; a second one at the same time is refused.
///
/// # Errors
/// The folder holds something, another restore is under way, the backup is not whole or is damaged, or something cannot be read or
/// written.
pub fn restore(backup: &Path, data: &Path, progress: &mut dyn FnMut(&str)) -> anyhow::Result<Restored> {
    restore_around(backup, data, progress, &mut || ())
}

/// As [`restore`]; `meanwhile` runs between the first look at the folder and its lock, for tests.
pub(super) fn restore_around(
    backup: &Path,
    data: &Path,
    progress: &mut dyn FnMut(&str),
    meanwhile: &mut dyn FnMut(),
) -> anyhow::Result<Restored> {
    let manifest = Manifest::read(backup)?;
    // Nothing is made in a folder that is not empty.
    let (is_there, _) = look(data, &manifest, false)?;
    let growing = if is_there { data.join(RESTORING) } else { beside(data) };
    meanwhile();
    let (_held, is_new) = hold(&growing, data)?;
    // Checked again under the lock: another restore may have finished meanwhile.
    let looked = look(data, &manifest, is_new).and_then(|(still_there, moved)| {
        ensure!(still_there == is_there, "{} appeared meanwhile: another restore made it", data.display());
        Ok(moved)
    });
    let moved = looked.inspect_err(|_| {
        if is_new {
            fs::remove_dir(&growing).ok();
        }
    })?;
    for path in moved.iter().map(|name| data.join(name)) {
        remove(&path)?;
    }
    for entry in fs::read_dir(&growing).with_context(|| growing.display().to_string())? {
        remove(&entry?.path())?;
    }
    let filled = fill(backup, &growing, data, manifest, progress);
    if filled.is_err() {
        fs::remove_dir_all(&growing).ok();
    }
    let restored = filled?;
    if is_there {
        move_up(&growing, data).with_context(|| {
            format!("{} is not whole, and no server starts there: restore once more", data.display())
        })?;
    } else {
        fs::rename(&growing, data)
            .inspect_err(|_| drop(fs::remove_dir_all(&growing)))
            .with_context(|| format!("cannot make {}", data.display()))?;
        if let Some(parent) = data.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            File::open(parent).and_then(|folder| folder.sync_all()).ok();
        }
    }
    Ok(restored)
}

/// Makes the working folder, or takes over that of an interrupted restore, and locks it until the file is dropped; returns
/// whether it is new.
fn hold(growing: &Path, data: &Path) -> anyhow::Result<(File, bool)> {
    let named = || format!("cannot make {}", growing.display());
    if let Some(parent) = growing.parent() {
        private_folder(parent).with_context(named)?;
    }
    let is_new = match fs::DirBuilder::new().mode(0o700).create(growing) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => false,
        made => made.map(|()| true).with_context(named)?,
    };
    let other = || {
        format!(
            "another restore into {} is under way, or has just ended: wait until it is done, then look what is there",
            data.display()
        )
    };
    let folder = File::open(growing).with_context(other)?;
    ensure!(folder.try_lock().is_ok(), other());
    // A restore that finished has renamed the folder.
    let is_same =
        fs::metadata(growing).is_ok_and(|now| folder.metadata().is_ok_and(|held| now.ino() == held.ino()));
    ensure!(is_same, other());
    Ok((folder, is_new))
}

fn remove(path: &Path) -> anyhow::Result<()> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    removed.with_context(|| format!("cannot remove {}", path.display()))
}

/// Whether the folder exists, and what an interrupted restore moved there; it must hold nothing else. If the working folder
/// is new, no restore was interrupted.
fn look(data: &Path, manifest: &Manifest, is_new: bool) -> anyhow::Result<(bool, Vec<OsString>)> {
    let entries = match fs::read_dir(data) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((false, Vec::new())),
        other => other.with_context(|| data.display().to_string())?,
    };
    let (mut moved, mut is_broken_off) = (Vec::new(), false);
    for entry in entries {
        let name = entry.with_context(|| data.display().to_string())?.file_name();
        match name.to_str() {
            Some(RESTORING) => is_broken_off = !is_new,
            // Every new ext4 file system has it.
            Some("lost+found") => {}
            _ => moved.push(name),
        }
    }
    let is_ours = |name: &OsString| {
        manifest.files.iter().any(|entry| entry.path.iter().next() == Some(name.as_os_str()))
    };
    ensure!(
        moved.is_empty() || is_broken_off,
        "{} is not empty: restore into a folder that is, and move it to its place when all is well",
        data.display()
    );
    if let Some(foreign) = moved.iter().find(|name| !is_ours(name)) {
        bail!(
            "a restore into {} was broken off, and {} there is not of this backup: restore the backup of before once more, or empty \
             the folder, with {RESTORING}, if what is in it is not needed",
            data.display(),
            foreign.to_string_lossy()
        );
    }
    Ok((true, moved))
}

/// Moves everything in a folder inside `data` to `data`, and removes the folder last.
fn move_up(growing: &Path, data: &Path) -> anyhow::Result<()> {
    let moved = || -> io::Result<()> {
        for entry in fs::read_dir(growing)? {
            let entry = entry?;
            fs::rename(entry.path(), data.join(entry.file_name()))?;
        }
        File::open(data)?.sync_all()?;
        fs::remove_dir(growing)?;
        File::open(data)?.sync_all()
    };
    moved().with_context(|| format!("cannot move what is in {} to {}", growing.display(), data.display()))
}

/// The folder that becomes the data folder.
fn beside(data: &Path) -> PathBuf {
    let mut name = data.components().as_path().to_owned().into_os_string();
    name.push(RESTORING);
    PathBuf::from(name)
}

fn fill(
    backup: &Path,
    to: &Path,
    data: &Path,
    manifest: Manifest,
    progress: &mut dyn FnMut(&str),
) -> anyhow::Result<Restored> {
    private_folder(to).with_context(|| format!("cannot make {}", to.display()))?;
    let (mut bytes, mut files, mut made_again, mut damaged) = (0, 0, Vec::new(), Vec::new());
    for entry in &manifest.files {
        progress(&entry.path.display().to_string());
        match take(backup, to, entry)? {
            None => {
                bytes += entry.bytes;
                files += 1;
            }
            // Derived data: the server rebuilds it.
            Some(_) if entry.path.starts_with("history") => {
                fs::remove_file(to.join(&entry.path)).ok();
                made_again.push(entry.path.clone());
            }
            Some(why) => damaged.push(format!("{}: {why}", entry.path.display())),
        }
    }
    if !damaged.is_empty() {
        damaged.sort();
        let (count, first) = (damaged.len(), damaged.iter().take(5).cloned().collect::<Vec<_>>().join("; "));
        bail!("{count} files of the backup are not as they were copied, nothing is restored: {first}");
    }
    let outside = manifest.outside.into_iter().map(|(was, here)| (was, data.join(here))).collect();
    Ok(Restored { files, bytes, made_us: manifest.made_us, made_again, outside })
}

/// Copies one file; returns what is wrong with it, if anything.
fn take(backup: &Path, to: &Path, entry: &Entry) -> anyhow::Result<Option<String>> {
    let target = to.join(&entry.path);
    let source = match File::open(backup.join(entry.at())) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Some("is not there".to_owned())),
        other => other.with_context(|| entry.path.display().to_string())?,
    };
    let copied = || -> io::Result<(u64, String, u64)> {
        if let Some(folder) = target.parent() {
            private_folder(folder)?;
        }
        let length = source.metadata()?.len();
        let mode = entry.mode & 0o700;
        let mut file = File::options().write(true).create_new(true).mode(mode | 0o600).open(&target)?;
        let (bytes, sha256) = copy(&source, entry.bytes, &mut file)?;
        file.set_permissions(fs::Permissions::from_mode(mode | 0o400))?;
        file.sync_all()?;
        Ok((bytes, sha256, length))
    };
    let (bytes, sha256, length) = copied().with_context(|| format!("cannot write {}", target.display()))?;
    // Files of the archive may be hard links that have grown since.
    let may_be_longer = entry.path.starts_with("archive");
    Ok(if bytes < entry.bytes || length > entry.bytes && !may_be_longer {
        Some(format!("has {length} bytes instead of {}", entry.bytes))
    } else if sha256 != entry.sha256 {
        Some("holds other bytes".to_owned())
    } else {
        None
    })
}

fn private_folder(folder: &Path) -> io::Result<()> {
    fs::DirBuilder::new().recursive(true).mode(0o700).create(folder)
}
