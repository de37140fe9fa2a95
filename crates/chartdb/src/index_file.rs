//! The depth index beside a chart set: `chart.gpkg` has `chart.lutra-index`.
//!
//! It holds the digest of the set that it was made of. One of another set, or a damaged one, is not used: the
//! index is made anew from the database, and put in its place where that can be written. Of one of another state of the
//! set, the pieces of charts that are the same are taken over.

use crate::error::{ChartDbError, Named as _, Result};
use crate::read::ChartDb;
use charts::depth_index::{DepthIndex, IndexBytes, SealedIndex};
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

/// Of an index, that is kept in memory at most.
const KEPT_BYTES: usize = 96 << 20;

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

/// Loads the index of a chart set; makes it anew where it does not fit. Of its pieces those are read that questions
/// need, from the file that it is now, whatever takes its place.
///
/// # Errors
/// When there is no chart set, or it cannot be read.
pub fn load_index(db: &Path) -> Result<LoadedIndex> {
    let charts = ChartDb::open(db)?;
    let digest = charts.digest()?;
    let path = index_path(db);
    let (why, before) = match open(&path) {
        Ok(sealed) if sealed.digest == digest => return Ok(LoadedIndex { sealed, rebuilt: None }),
        Ok(sealed) => {
            let why = format!("{} belongs to another state of the chart set", path.display());
            (why, Some(sealed.index))
        }
        Err(why) => (format!("{}: {why}", path.display()), None),
    };
    make(&charts, digest, before.as_ref(), &path, why)
}

/// Makes the index anew although there is one that fits, as when parts of it turn out to be damaged.
///
/// # Errors
/// When there is no chart set, or it cannot be read.
pub fn remake_index(db: &Path) -> Result<LoadedIndex> {
    let charts = ChartDb::open(db)?;
    let path = index_path(db);
    let why = format!("{} is damaged", path.display());
    make(&charts, charts.digest()?, None, &path, why)
}

fn make(
    charts: &ChartDb,
    digest: [u8; 32],
    before: Option<&DepthIndex>,
    path: &Path,
    why: String,
) -> Result<LoadedIndex> {
    let written = PartFile::of(charts, digest, before, path).and_then(PartFile::put_in_place);
    let sealed = match written {
        Ok(()) => open(path).map_err(|why| ChartDbError::file(path.display().to_string(), why))?,
        // A folder that cannot be written still gives answers.
        Err(ChartDbError::Io { .. }) => {
            let mut bytes = SealedIndex::head(digest);
            charts.make_index(before, |part| {
                bytes.extend_from_slice(part);
                Ok(())
            })?;
            let sealed = SealedIndex::from_bytes(&bytes);
            sealed.map_err(|error| ChartDbError::file(path.display().to_string(), error.to_string()))?
        }
        Err(error) => return Err(error),
    };
    Ok(LoadedIndex { sealed, rebuilt: Some(why) })
}

/// The index in a file, whatever it is of.
pub(crate) fn open(path: &Path) -> Result<SealedIndex, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let about = file.metadata().map_err(|error| error.to_string())?;
    // A pipe would wait for ever.
    if !about.is_file() {
        return Err("this is no file".to_owned());
    }
    let bytes = Arc::new(FileBytes { file, length: about.len() });
    SealedIndex::open(bytes, KEPT_BYTES).map_err(|error| error.to_string())
}

/// A file, held open.
#[derive(Debug)]
struct FileBytes {
    file: File,
    length: u64,
}

impl IndexBytes for FileBytes {
    fn length(&self) -> u64 {
        self.length
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        // No more is made room for than there is.
        if offset.checked_add(length as u64).is_none_or(|end| end > self.length) {
            return Err("it ends before".to_owned());
        }
        let mut bytes = vec![0; length];
        self.file.read_exact_at(&mut bytes, offset).map_err(|error| error.to_string())?;
        Ok(bytes)
    }
}

/// An index under another name until it is whole. The name has the number of the process, for an import and a server
/// may write at the same time.
pub(crate) struct PartFile {
    part: PathBuf,
    path: PathBuf,
}

impl PartFile {
    /// The index of these charts, to lie at `path`.
    pub(crate) fn of(
        charts: &ChartDb,
        digest: [u8; 32],
        before: Option<&DepthIndex>,
        path: &Path,
    ) -> Result<Self> {
        let part = part_of(&numbered(path, std::process::id()));
        // From here on what was written goes away unless it gets its place.
        let new = Self { part, path: path.to_owned() };
        let mut file = BufWriter::new(File::create(&new.part).named(path)?);
        file.write_all(&SealedIndex::head(digest)).named(path)?;
        charts.make_index(before, |part| file.write_all(part).named(path))?;
        let file = file.into_inner().map_err(std::io::IntoInnerError::into_error).named(path)?;
        file.sync_all().named(path)?;
        Ok(new)
    }

    /// Gives it its name.
    pub(crate) fn put_in_place(self) -> Result<()> {
        let now = fs::metadata(&self.part).and_then(|data| data.modified());
        fs::rename(&self.part, &self.path).named(&self.path)?;
        if let Ok(now) = now {
            sweep(&self.path, now);
        }
        Ok(())
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        fs::remove_file(&self.part).ok();
    }
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
        let sealed = SealedIndex { digest: [7; 32], index: DepthIndex::default() };
        let part = part_of(&numbered(&path, std::process::id()));
        fs::write(&part, sealed.to_bytes()).unwrap();
        PartFile { part, path: path.clone() }.put_in_place().unwrap();
        assert_eq!(fs::read(&writing).unwrap(), b"half");
        assert_eq!(fs::read(&before).unwrap(), b"half");
        assert!(!dead.exists() && old.exists());
        assert!(SealedIndex::from_bytes(&fs::read(&path).unwrap()).is_ok());
        // Nothing of this process is left: the index and the three above.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
