//! Making a backup.

use super::manifest::{Entry, MANIFEST, Manifest, copy};
use crate::{clock, folder, identity};
use anyhow::{Context as _, ensure};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use store::BackedUp;

/// What of a data folder is not copied as files: what the store and app.db copy themselves, what is of a moment only,
/// and what could not be used.
const LEFT_OUT: [&str; 8] =
    ["archive", "history", "history.new", "history.old", "history.aside", "uploads", "lock", "backup.json"];
/// Ends of names of what is under way, or rebuilt by itself.
const UNDER_WAY: [&str; 7] = [".part", ".new", ".tmp", ".lock", "-wal", "-shm", "-journal"];
/// Where files that lie outside of the data folder come to.
const OUTSIDE: &str = "outside";

/// Copies everything into a folder, which may hold an earlier backup: archive, history, people, charts, certificates,
/// and those of the files that the configuration names which lie beyond the data folder. `progress` is told what comes next.
///
/// # Errors
/// Something cannot be read or written. What was there of an earlier backup may then be partly replaced.
pub fn make(
    data: &Path,
    named: &[PathBuf],
    to: &Path,
    progress: &mut dyn FnMut(&str),
) -> anyhow::Result<BackedUp> {
    folder::check(to)?;
    refuse_below(to, data)?;
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    // A way with `..` in it may lead elsewhere than it seemed to while it was not there.
    refuse_below(to, data)?;
    let earlier = Manifest::read(to).unwrap_or_default();
    let done = store::backup(data, to, &mut |what| {
        progress(what);
        true
    })?;
    identity::wait(identity::backup(data, to))?;
    let mut manifest = Manifest::new(clock::now().micros());
    for path in files(data, Path::new(""))? {
        progress(&path.display().to_string());
        copy_file(&data.join(&path), &to.join(&path))?;
    }
    for path in beyond(data, named) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let here = Path::new(OUTSIDE).join(format!("{}-{name}", manifest.outside.len() + 1));
        copy_file(path, &to.join(&here))?;
        manifest.outside.push((path.to_owned(), here));
    }
    let known: BTreeMap<&Path, &Entry> =
        earlier.files.iter().map(|entry| (entry.path.as_path(), entry)).collect();
    let mut held = Vec::new();
    held_by(to, Path::new(""), &mut held)?;
    // What an earlier backup took from elsewhere and this one did not.
    held.retain(|path| !path.starts_with(OUTSIDE) || manifest.outside.iter().any(|(_, here)| here == path));
    for path in held {
        progress(&path.display().to_string());
        manifest.files.push(entry(to, &path, known.get(path.as_path()).copied())?);
    }
    manifest.write(to)?;
    Ok(done)
}

/// Refuses a folder, which need not be there yet, that is the data folder or lies in it.
fn refuse_below(path: &Path, data: &Path) -> anyhow::Result<()> {
    let full = std::path::absolute(path).with_context(|| path.display().to_string())?;
    let data = data.canonicalize().with_context(|| data.display().to_string())?;
    let there = full.ancestors().find_map(|parent| parent.canonicalize().ok());
    let is_below = there.is_some_and(|there| there.starts_with(data));
    ensure!(!is_below, "a backup must go to another folder, on another disk where that can be");
    Ok(())
}

/// The files of a data folder that are copied as they are, below it.
fn files(data: &Path, below: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let folder = data.join(below);
    for item in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let item = item?;
        let (name, kind) = (item.file_name().to_string_lossy().into_owned(), item.file_type()?);
        let path = below.join(item.file_name());
        let is_left_out =
            below.as_os_str().is_empty() && (LEFT_OUT.contains(&name.as_str()) || name.starts_with("app.db"));
        if is_left_out || UNDER_WAY.iter().any(|end| name.ends_with(end)) {
            continue;
        }
        if kind.is_dir() {
            found.extend(files(data, &path)?);
        } else if kind.is_file() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Files beyond the data folder without which the server is another one.
fn beyond<'p>(data: &Path, named: &'p [PathBuf]) -> Vec<&'p Path> {
    let data = data.canonicalize().unwrap_or_else(|_| data.to_owned());
    let is_beyond =
        |path: &&Path| path.is_file() && path.canonicalize().is_ok_and(|path| !path.starts_with(&data));
    named.iter().map(PathBuf::as_path).filter(is_beyond).collect()
}

/// Copies a file: under another name until it is whole.
fn copy_file(from: &Path, to: &Path) -> anyhow::Result<()> {
    let part = PathBuf::from(format!("{}.part", to.display()));
    let copied = || -> io::Result<()> {
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder)?;
        }
        copy_state(from, &part)?;
        File::open(&part)?.sync_all()?;
        fs::rename(&part, to)
    };
    copied().with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))
}

/// Copies a file; of a chart set, which an import may be changing in place, one state of it.
fn copy_state(from: &Path, to: &Path) -> io::Result<()> {
    if from.extension().is_some_and(|end| end == "gpkg") {
        if to.exists() {
            fs::remove_file(to)?;
        }
        match chartdb::copy(from, to) {
            Err(chartdb::ChartDbError::Foreign(_)) => {}
            copied => return copied.map_err(io::Error::other),
        }
    }
    fs::copy(from, to).map(drop)
}

/// All files of a backup, below it.
fn held_by(backup: &Path, below: &Path, found: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    let folder = backup.join(below);
    let mut names = Vec::new();
    for item in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let item = item?;
        names.push((item.file_name(), item.file_type()?.is_dir()));
    }
    names.sort();
    for (name, is_folder) in names {
        let path = below.join(&name);
        let text = name.to_string_lossy().into_owned();
        if is_folder {
            held_by(backup, &path, found)?;
        } else if text != MANIFEST && !UNDER_WAY.iter().any(|end| text.ends_with(end)) {
            found.push(path);
        }
    }
    Ok(())
}

/// What the manifest says of a file. A file of the archive that is as long as it was is what it was: they only grow.
fn entry(backup: &Path, path: &Path, earlier: Option<&Entry>) -> anyhow::Result<Entry> {
    let full = backup.join(path);
    let read = || -> io::Result<Entry> {
        let about = fs::metadata(&full)?;
        let mode = about.permissions().mode() & 0o7777;
        if let Some(same) = earlier.filter(|one| path.starts_with("archive") && one.bytes == about.len()) {
            return Ok(Entry { mode, ..same.clone() });
        }
        let (bytes, sha256) = copy(File::open(&full)?, about.len(), &mut io::sink())?;
        Ok(Entry { path: path.to_owned(), bytes, sha256, mode })
    };
    read().with_context(|| format!("cannot read {}", full.display()))
}
