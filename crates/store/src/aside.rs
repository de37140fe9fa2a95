//! Files of the history that cannot be used: moved to `history.aside`, never removed.

use crate::error::{Named as _, Result, StoreError};
use std::fs;
use std::path::{Path, PathBuf};

/// The folder in the data.
pub(crate) const ASIDE: &str = "history.aside";
/// Most files that lie there: a disk that damages one after the other must not be filled by that too.
const MOST: usize = 32;

/// The files that lie aside, by name.
pub(crate) fn all(data: &Path) -> Result<Vec<PathBuf>> {
    let folder = data.join(ASIDE);
    let entries = match fs::read_dir(&folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.named(&folder)?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.named(&folder)?.path();
        if path.extension().is_none_or(|end| end != "sqlite-wal" && end != "sqlite-shm") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Moves a database there, with SQLite's files beside it; returns its new path. It must not be open.
///
/// # Errors
/// It cannot be moved, or the folder holds as many as allowed.
pub(crate) fn put(data: &Path, file: &Path) -> Result<PathBuf> {
    let folder = data.join(ASIDE);
    if all(data)?.len() >= MOST {
        return Err(StoreError::Query(format!(
            "{} is damaged, and {MOST} such files lie in {} already: look after the disk, and remove what is not \
             needed any more",
            file.display(),
            folder.display()
        )));
    }
    fs::create_dir_all(&folder).named(&folder)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let to = (0..=MOST)
        .map(|number| match number {
            0 => folder.join(format!("{name}.sqlite")),
            _ => folder.join(format!("{name}.{number}.sqlite")),
        })
        .find(|path| !path.exists())
        .ok_or_else(|| StoreError::Query(format!("there is no free name for {name} in {ASIDE}")))?;
    // Its log goes first: a log on its own does no harm, while a database without its log would lack what that holds.
    for end in ["-wal", "-shm", ""] {
        let (from, to) = (beside(file, end), beside(&to, end));
        match fs::rename(&from, &to) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            other => other.named(&from)?,
        }
    }
    Ok(to)
}

fn beside(file: &Path, end: &str) -> PathBuf {
    let mut name = file.to_owned().into_os_string();
    name.push(end);
    PathBuf::from(name)
}
