//! Making a backup.

use super::keeping::{self, BackedUp, Keeping};
use super::manifest::{ALTERNATE, ASIDE, MANIFEST, Manifest};
use crate::{clock, folder, identity};
use anyhow::{Context as _, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use store::{BackupFile, Changes};

/// Entries of a data folder that are not copied as files: those that the store and app.db copy themselves, temporary ones,
/// and those that a restore could not use.
const LEFT_OUT: [&str; 11] = [
    "archive",
    "history",
    "history.new",
    "history.old",
    "history.aside",
    "uploads",
    "lock",
    "backup.json",
    ALTERNATE,
    ASIDE,
    OUTSIDE,
];
/// Suffixes of files that are being written or are rebuilt automatically.
const UNDER_WAY: [&str; 7] = [".part", ".new", ".tmp", ".lock", "-wal", "-shm", "-journal"];
/// Folder for files from outside of the data folder.
const OUTSIDE: &str = "outside";

/// Copies everything into a folder, which may hold an earlier backup: archive, history, people, charts, certificates,
/// and those of the files that the configuration names which lie beyond the data folder. Only what the earlier backup lacks
/// is copied; what is kept is read and compared, unless `verifies` is false. `progress` is called with the next step.
///
/// # Errors
/// Something cannot be read or written. An earlier backup is then intact.
pub fn make(
    data: &Path,
    named: &[PathBuf],
    to: &Path,
    verifies: bool,
    progress: &mut dyn FnMut(&str),
) -> anyhow::Result<BackedUp> {
    folder::check(to)?;
    refuse_below(to, data)?;
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    // A path with `..` may lead elsewhere once its folders exist.
    refuse_below(to, data)?;
    let _lock = keeping::lock(to)?;
    let earlier = if to.join(MANIFEST).exists() { Manifest::read(to)? } else { Manifest::default() };
    let aside = free_name(to, &clock::written(clock::now()).replace([' ', ':'], "-"));
    let mut keeping = Keeping::new(data, to, &earlier, verifies, aside);
    keeping.sweep_parts();
    for BackupFile { path, changes } in store::backup_files(data)? {
        let name = path.display().to_string();
        progress(&name);
        let from = data.join(&path);
        match changes {
            Changes::Grows { now } => grow(&mut keeping, data, &path, now)?,
            Changes::Whole => keeping.take(&path, &from, |to| copy_state(&from, to))?,
            Changes::Database => keeping.take(&path, &from, |to| {
                Ok(store::copy_database(&from, to, &mut || {
                    progress(&name);
                    true
                })?)
            })?,
        }
    }
    let people = data.join("app.db");
    if people.exists() {
        progress("app.db");
        let copy = |to: &Path| Ok(identity::wait(identity::backup(data, to))?);
        keeping.take(Path::new("app.db"), &people, copy)?;
    }
    for path in files(data, Path::new(""))? {
        progress(&path.display().to_string());
        let from = data.join(&path);
        keeping.take(&path, &from, |to| copy_state(&from, to))?;
    }
    let mut manifest = Manifest::new(clock::now().micros());
    for from in beyond(data, named) {
        progress(&from.display().to_string());
        let name = from.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let here = Path::new(OUTSIDE).join(format!("{}-{name}", manifest.outside.len() + 1));
        keeping.take(&here, from, |to| copy_state(from, to))?;
        manifest.outside.push((from.to_owned(), here));
    }
    progress("what the earlier backup has");
    keeping.carry_over(OUTSIDE)?;
    manifest.files = keeping.files();
    manifest.write(to)?;
    progress("what is not named any more");
    keeping.sweep()?;
    Ok(keeping.done)
}

/// Backs up a file of the archive. The server may compress it meanwhile: then the compressed one is taken.
fn grow(keeping: &mut Keeping<'_>, data: &Path, path: &Path, now: bool) -> anyhow::Result<()> {
    let grown = keeping.grow(path, now);
    if grown.is_err()
        && !data.join(path).exists()
        && let Some(other) = store::other_form(path).filter(|other| data.join(other).exists())
    {
        return keeping.grow(&other, false);
    }
    grown
}

/// An unused name below the backup for what is set aside at this time.
fn free_name(to: &Path, time: &str) -> PathBuf {
    let (mut path, mut number) = (Path::new(ASIDE).join(time), 1);
    while to.join(&path).exists() {
        number += 1;
        path = Path::new(ASIDE).join(format!("{time}-{number}"));
    }
    path
}

/// Refuses a path, which need not exist, that is the data folder or is inside it.
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

/// Files outside of the data folder that the server's identity depends on.
fn beyond<'p>(data: &Path, named: &'p [PathBuf]) -> Vec<&'p Path> {
    let data = data.canonicalize().unwrap_or_else(|_| data.to_owned());
    let is_beyond =
        |path: &&Path| path.is_file() && path.canonicalize().is_ok_and(|path| !path.starts_with(&data));
    named.iter().map(PathBuf::as_path).filter(is_beyond).collect()
}

/// Copies a file; of a chart set, which an import may be changing in place, one state of it.
fn copy_state(from: &Path, to: &Path) -> anyhow::Result<()> {
    let named = || format!("cannot copy {} to {}", from.display(), to.display());
    if from.extension().is_some_and(|end| end == "gpkg") {
        match chartdb::copy(from, to) {
            Err(chartdb::ChartDbError::Foreign(_)) => {}
            copied => return copied.with_context(named),
        }
    }
    fs::copy(from, to).map(drop).with_context(named)
}
