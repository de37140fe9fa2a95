//! The depth index beside a chart set: `chart.gpkg` has `chart.lutra-index`.
//!
//! It holds the digest of the set that it was made of. One of another set, or a damaged one, is not used: the
//! index is made anew from the database, and put in its place where that can be written.

use crate::error::{ChartDbError, Named as _, Result};
use crate::read::ChartDb;
use charts::depth_index::SealedIndex;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Nobody writes an index for so long.
const ABANDONED: Duration = Duration::from_hours(1);

/// An index that was loaded.
#[derive(Debug)]
pub struct LoadedIndex {
    /// The index and the digest of its charts.
    pub sealed: SealedIndex,
    /// Why it had to be made anew; `None` where it was there.
    pub rebuilt: Option<String>,
}

/// Where the index of a chart set lies.
pub fn index_path(db: &Path) -> PathBuf {
    db.with_extension("lutra-index")
}

/// Loads the index of a chart set; makes it anew where it does not fit.
///
/// # Errors
/// When there is no chart set, or it cannot be read.
pub fn load_index(db: &Path) -> Result<LoadedIndex> {
    let charts = ChartDb::open(db)?;
    let digest = charts.digest()?;
    let path = index_path(db);
    let why = match fs::read(&path) {
        Err(error) => format!("{}: {error}", path.display()),
        Ok(bytes) if SealedIndex::digest_of(&bytes).is_some_and(|found| found != digest) => {
            format!("{} belongs to another state of the chart set", path.display())
        }
        Ok(bytes) => match SealedIndex::from_bytes(&bytes) {
            Ok(sealed) => return Ok(LoadedIndex { sealed, rebuilt: None }),
            Err(error) => format!("{}: {error}", path.display()),
        },
    };
    let sealed = SealedIndex { digest, index: charts.build_index()? };
    // A folder that cannot be written still gives answers.
    write(&path, &sealed).ok();
    Ok(LoadedIndex { sealed, rebuilt: Some(why) })
}

/// Writes under another name first: a file that is there is whole. The name has the number of the process, for an
/// import and a server may write at the same time.
pub(crate) fn write(path: &Path, sealed: &SealedIndex) -> Result<()> {
    let part = part_of(&numbered(path, std::process::id()));
    let write = || {
        let mut file = File::create(&part)?;
        file.write_all(&sealed.to_bytes())?;
        file.sync_all()?;
        let now = file.metadata()?.modified();
        fs::rename(&part, path)?;
        if let Ok(now) = now {
            sweep(path, now);
        }
        Ok(())
    };
    write().map_err(|source| {
        fs::remove_file(&part).ok();
        ChartDbError::Io { path: path.to_owned(), source }
    })
}

/// `chart.lutra-index.4711`.
fn numbered(path: &Path, process: u32) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{process}"));
    name.into()
}

/// Removes what processes left that were killed while they wrote. What is younger may still be written.
fn sweep(path: &Path, now: SystemTime) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Ok(entries), Some(name)) = (fs::read_dir(folder), path.file_name()) else { return };
    let name = name.to_string_lossy();
    for entry in entries.flatten() {
        let other = entry.file_name().to_string_lossy().into_owned();
        let rest = other.strip_prefix(&*name).and_then(|rest| rest.strip_suffix(".part"));
        // Without a number: of versions before.
        let number = rest.map(|rest| rest.strip_prefix('.').unwrap_or(rest));
        let ours = number.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
        let written = entry.metadata().and_then(|data| data.modified()).ok();
        let old = written.and_then(|time| now.duration_since(time).ok()).is_some_and(|age| age > ABANDONED);
        if ours && old {
            fs::remove_file(entry.path()).ok();
        }
    }
}

/// The name under which a file is written until it is whole.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// Removes a file that may not be there.
pub(crate) fn forget(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error).named(path),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::depth_index::DepthIndex;

    #[test]
    fn what_another_process_writes_is_left_alone_and_what_a_dead_one_left_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chart.lutra-index");
        let other = |name: &str, age: Duration| {
            let path = folder.path().join(name);
            let file = File::create(&path).unwrap();
            (&file).write_all(b"half").unwrap();
            file.set_modified(file.metadata().unwrap().modified().unwrap() - age).unwrap();
            path
        };
        let writing = other("chart.lutra-index.1.part", Duration::from_secs(10));
        let before = other("chart.lutra-index.part", Duration::from_secs(10));
        let dead = other("chart.lutra-index.2.part", ABANDONED * 2);
        let old = other("chart.lutra-index.part.old.part", ABANDONED * 2);
        write(&path, &SealedIndex { digest: [7; 32], index: DepthIndex::default() }).unwrap();
        assert_eq!(fs::read(&writing).unwrap(), b"half");
        assert_eq!(fs::read(&before).unwrap(), b"half");
        assert!(!dead.exists() && old.exists());
        assert!(SealedIndex::from_bytes(&fs::read(&path).unwrap()).is_ok());
        // Nothing of this process is left: the index and the three above.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
