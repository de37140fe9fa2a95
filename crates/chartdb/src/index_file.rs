//! The depth index beside a chart set: `chart.gpkg` has `chart.lutra-index`.
//!
//! It holds the digest of the set that it was made of. One of another set, or a damaged one, is not used: the
//! index is rebuilt from the database, and put in its place where that can be written. Of one of another state of the
//! set, the pieces of charts that are the same are taken over.
//!
//! A small change of a large set does not copy a gigabyte: what differs lies in `chart.lutra-changes`, to be read as if
//! it stood at the end of the index. It names the index that it belongs to, and is as good as absent beside another.
//! When the changes grow, both become one again.

use crate::contents::Contents;
use crate::error::{ChartDbError, Named as _, Result};
use crate::overviews::Overviews;
use crate::part_file::{forget, part_of};
use crate::read::ChartDb;
use charts::depth_index::{IndexBytes, IndexError, SealedIndex};
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

/// Of an index, that is kept in memory at most.
const KEPT_BYTES: usize = 96 << 20;

/// Writing an index never takes this long: an older temporary file is left over.
const ABANDONED: Duration = Duration::from_hours(1);

/// An index that was loaded.
#[derive(Debug)]
pub struct LoadedIndex {
    /// The index and the digest of its charts.
    pub sealed: SealedIndex,
    /// Why it had to be rebuilt; `None` where it was there.
    pub rebuilt: Option<String>,
}

/// How often a set may change while its index is made; imports do not change it more often.
const TRIES: u32 = 5;

/// Where the index of a chart set lies.
pub fn index_path(db: &Path) -> PathBuf {
    db.with_extension("lutra-index")
}

/// All files of a chart set that may be there: the set, its index with its changes, its overviews.
pub fn files(db: &Path) -> [PathBuf; 4] {
    let index = index_path(db);
    [db.to_owned(), changes_path(&index), index, Overviews::path(db)]
}

/// Where the changes of the index of a chart set lie.
fn changes_path(index: &Path) -> PathBuf {
    index.with_extension("lutra-changes")
}

/// Loads the index of a chart set; makes it again where it does not fit. Of its pieces those are read that questions
/// need, from the file as opened, even if another takes its place.
///
/// # Errors
/// When there is no chart set, or it cannot be read.
pub fn load_index(db: &Path) -> Result<LoadedIndex> {
    while_it_stays(db, load_once)
}

/// Loads or makes again until the set did not change meanwhile: it is read chart by chart, and charts that an import has
/// just replaced would be missing.
fn while_it_stays(db: &Path, load: impl Fn(&Path) -> Result<Option<LoadedIndex>>) -> Result<LoadedIndex> {
    for _ in 0..TRIES {
        if let Some(loaded) = load(db)? {
            return Ok(loaded);
        }
    }
    Err(ChartDbError::Locked(db.to_owned()))
}

fn load_once(db: &Path) -> Result<Option<LoadedIndex>> {
    let set = ChartDb::open(db)?;
    let charts = Contents::of(&set)?;
    let path = index_path(db);
    let (why, before) = match open(&path) {
        Ok(found) if found.sealed.digest == charts.digest() => {
            return Ok(Some(LoadedIndex { sealed: found.sealed, rebuilt: None }));
        }
        Ok(found) => {
            let why = format!("{} belongs to another state of the chart set", path.display());
            (why, Some(found))
        }
        Err(why) => (format!("{}: {why}", path.display()), None),
    };
    make(&set, &charts, before.as_ref(), &path, why)
}

/// Makes the index again although there is one that fits, as when parts of it turn out to be damaged.
///
/// # Errors
/// When there is no chart set, or it cannot be read.
pub fn remake_index(db: &Path) -> Result<LoadedIndex> {
    while_it_stays(db, |db| {
        let set = ChartDb::open(db)?;
        let path = index_path(db);
        let why = format!("{} is damaged", path.display());
        make(&set, &Contents::of(&set)?, None, &path, why)
    })
}

/// `None` where the set is another by the time the index is made.
fn make(
    set: &ChartDb,
    charts: &Contents<'_>,
    before: Option<&OpenIndex>,
    path: &Path,
    why: String,
) -> Result<Option<LoadedIndex>> {
    let has_stayed = || -> Result<bool> { Ok(set.digest()? == charts.digest()) };
    let written = PartFile::of(charts, before, path).and_then(|part| {
        let stayed = has_stayed()?;
        if stayed { part.put_in_place().map(|()| true) } else { Ok(false) }
    });
    let sealed = match written {
        Ok(false) => return Ok(None),
        Ok(true) => open(path).map_err(|why| ChartDbError::file(path.display().to_string(), why))?.sealed,
        // A folder that cannot be written still gives answers.
        Err(ChartDbError::Io { .. }) => {
            let mut bytes = SealedIndex::head(charts.digest());
            charts.make_index(before.map(|before| &before.sealed.index), |part| {
                bytes.extend_from_slice(part);
                Ok(())
            })?;
            if !has_stayed()? {
                return Ok(None);
            }
            let sealed = SealedIndex::from_bytes(&bytes);
            sealed.map_err(|error| ChartDbError::file(path.display().to_string(), error.to_string()))?
        }
        Err(error) => return Err(error),
    };
    Ok(Some(LoadedIndex { sealed, rebuilt: Some(why) }))
}

/// An index with its changes, as it lies on the disk.
pub(crate) struct OpenIndex {
    pub(crate) sealed: SealedIndex,
    base: Base,
}

/// Identifies a file of an index: the digest of the set that it was made of, its length, and its last bytes, among them
/// the checksum of a directory that has the checksums of all pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Base {
    digest: [u8; 32],
    length: u64,
    end: [u8; 8],
}

const CHANGES_MAGIC: &[u8; 8] = b"LUTRACHD";
/// Magic, digest of the set, and what names the index.
const CHANGES_HEAD_BYTES: usize = 8 + 32 + 48;

impl Base {
    fn of(file: &FileBytes) -> Option<Self> {
        let head = SealedIndex::head([0; 32]).len();
        let digest = SealedIndex::digest_of(&file.read(0, head).ok()?)?;
        let end = file.read(file.length.checked_sub(8)?, 8).ok()?.try_into().ok()?;
        Some(Self { digest, length: file.length, end })
    }

    /// The head of its changes, for a set of this digest.
    fn changes_head(&self, digest: [u8; 32]) -> Vec<u8> {
        [CHANGES_MAGIC.as_slice(), &digest, &self.digest, &self.length.to_le_bytes(), &self.end].concat()
    }
}

/// The index in a file, of any set, with its changes.
pub(crate) fn open(path: &Path) -> Result<OpenIndex, String> {
    let file = Arc::new(FileBytes::open(path)?);
    let base = Base::of(&file).ok_or_else(|| IndexError::Magic.to_string())?;
    let sealed = match changed(&file, &base, &changes_path(path)) {
        Some(sealed) => sealed,
        None => SealedIndex::open(file, KEPT_BYTES).map_err(|error| error.to_string())?,
    };
    Ok(OpenIndex { sealed, base })
}

/// The index with its changes, if there are such.
fn changed(file: &Arc<FileBytes>, base: &Base, changes: &Path) -> Option<SealedIndex> {
    let changes = FileBytes::open(changes).ok()?;
    let head = changes.read(0, CHANGES_HEAD_BYTES).ok()?;
    let digest = head.get(CHANGES_MAGIC.len()..)?.first_chunk().copied()?;
    if base.changes_head(digest) != head {
        return None;
    }
    // Cut off behind its head it would hold nothing, and the old directory would be taken for that of this set.
    let body = changes.length - CHANGES_HEAD_BYTES as u64;
    let end = changes.read(changes.length - body.min(8), body.min(8) as usize).ok()?;
    let directory_bytes = u32::from_le_bytes(*end.first_chunk()?);
    if u64::from(directory_bytes) + 8 > body {
        return None;
    }
    let joined = JoinedBytes { first: Arc::clone(file), changes };
    SealedIndex::open_changed(Arc::new(joined), digest, KEPT_BYTES).ok()
}

/// A file, held open.
#[derive(Debug)]
struct FileBytes {
    file: File,
    length: u64,
}

impl FileBytes {
    fn open(path: &Path) -> Result<Self, String> {
        let file = File::open(path).map_err(|error| error.to_string())?;
        let about = file.metadata().map_err(|error| error.to_string())?;
        // A pipe would wait for ever.
        if !about.is_file() {
            return Err("this is not a file".to_owned());
        }
        Ok(Self { file, length: about.len() })
    }
}

/// An index, and its changes without their head.
#[derive(Debug)]
struct JoinedBytes {
    first: Arc<FileBytes>,
    changes: FileBytes,
}

impl IndexBytes for JoinedBytes {
    fn length(&self) -> u64 {
        self.first.length + self.changes.length - CHANGES_HEAD_BYTES as u64
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        match offset.checked_sub(self.first.length) {
            // No piece and no directory lies across.
            None => self.first.read(offset, length),
            Some(beyond) => self.changes.read(beyond + CHANGES_HEAD_BYTES as u64, length),
        }
    }
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
    /// Whether these are only the changes of the index that is there.
    changes: bool,
}

/// An index that is smaller is written as a whole: that takes no time, and leaves one file.
const LEAST_BASE_BYTES: u64 = 32 << 20;

impl PartFile {
    /// The index of these charts, to lie at `path`.
    pub(crate) fn of(charts: &Contents<'_>, before: Option<&OpenIndex>, path: &Path) -> Result<Self> {
        Self::sized(charts, before, path, LEAST_BASE_BYTES)
    }

    fn sized(charts: &Contents<'_>, before: Option<&OpenIndex>, path: &Path, least: u64) -> Result<Self> {
        let head = SealedIndex::head(charts.digest());
        let Some(before) = before.filter(|before| before.base.length >= least) else {
            return Self::write(path, false, &head, |put| {
                charts.make_index(before.map(|before| &before.sealed.index), put)
            });
        };
        let (changes, slight) = Self::changes(charts, before, path)?;
        if slight {
            return Ok(changes);
        }
        // Both become one; what was made for the changes is not made again.
        let file = FileBytes::open(path).ok().map(Arc::new);
        let joined = file.and_then(|file| changed(&file, &before.base, &changes.part));
        let made = joined.as_ref().map_or(&before.sealed.index, |joined| &joined.index);
        Self::write(path, false, &head, |put| charts.make_index(Some(made), put))
    }

    /// The changes that bring the index up to date, and whether they are a small part of the whole.
    fn changes(charts: &Contents<'_>, before: &OpenIndex, path: &Path) -> Result<(Self, bool)> {
        let base = &before.base;
        let base_bytes = base.length - SealedIndex::head_bytes();
        let mut in_use_bytes = 0;
        let new = Self::write(&changes_path(path), true, &base.changes_head(charts.digest()), |put| {
            in_use_bytes = charts.change_index(&before.sealed.index, base_bytes, put)?;
            Ok(())
        })?;
        let changed_bytes = fs::metadata(&new.part).named(&new.part)?.len();
        let slight = changed_bytes <= base.length / 4 && in_use_bytes >= base.length / 2;
        Ok((new, slight))
    }

    fn write(
        path: &Path,
        changes: bool,
        head: &[u8],
        make: impl FnOnce(&mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()>,
    ) -> Result<Self> {
        let part = part_of(&numbered(path, std::process::id()));
        // From here on what was written goes away unless it gets its place.
        let new = Self { part, path: path.to_owned(), changes };
        let mut file = BufWriter::new(File::create(&new.part).named(path)?);
        file.write_all(head).named(path)?;
        make(&mut |part| file.write_all(part).named(path))?;
        let file = file.into_inner().map_err(std::io::IntoInnerError::into_error).named(path)?;
        file.sync_all().named(path)?;
        Ok(new)
    }

    /// Gives it its name.
    pub(crate) fn put_in_place(self) -> Result<()> {
        let now = fs::metadata(&self.part).and_then(|data| data.modified());
        fs::rename(&self.part, &self.path).named(&self.path)?;
        if !self.changes {
            // They belong to the previous index, and are not used any more.
            forget(&changes_path(&self.path))?;
        }
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
        let index = charts::depth_index::DepthIndex::default();
        let sealed = SealedIndex { digest: [7; 32], index };
        let part = part_of(&numbered(&path, std::process::id()));
        fs::write(&part, sealed.to_bytes()).unwrap();
        PartFile { part, path: path.clone(), changes: false }.put_in_place().unwrap();
        assert_eq!(fs::read(&writing).unwrap(), b"half");
        assert_eq!(fs::read(&before).unwrap(), b"half");
        assert!(!dead.exists() && old.exists());
        assert!(SealedIndex::from_bytes(&fs::read(&path).unwrap()).is_ok());
        // Nothing of this process is left: the index and the three above.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    /// A large cell and a small one far from it; `None` without the shared cells.
    fn two_cells(folder: &Path) -> Option<(PathBuf, PathBuf)> {
        let cells = folder.join("cells");
        fs::create_dir(&cells).unwrap();
        for name in ["US4MD81M.000", "GB5X02SE.000"] {
            fs::copy(testkit::shared(&format!("data/charts/{name}"))?, cells.join(name)).unwrap();
        }
        Some((cells.join("US4MD81M.000"), cells.join("GB5X02SE.000")))
    }

    fn import(db: &Path, cell: &Path) {
        let options = crate::ImportOptions::new(units::UtcTime::from_micros(0));
        assert!(crate::import(db, &[cell.to_owned()], &options, &mut |_| true).unwrap().applied);
    }

    fn packed(sealed: &SealedIndex) -> Vec<u8> {
        let packed = sealed.packed();
        packed.read(0, packed.length() as usize).unwrap()
    }

    #[test]
    fn a_small_change_is_written_as_what_differs_and_reads_as_an_index_made_anew() {
        let folder = tempfile::tempdir().unwrap();
        let Some((large, small)) = two_cells(folder.path()) else { return };
        let (db, path) = (folder.path().join("chart.gpkg"), folder.path().join("chart.lutra-index"));
        import(&db, &large);
        let first = fs::read(&path).unwrap();
        import(&db, &small);
        let rebuilt = fs::read(&path).unwrap();
        fs::write(&path, &first).unwrap();

        let set = ChartDb::open(&db).unwrap();
        let charts = Contents::of(&set).unwrap();
        let written = PartFile::sized(&charts, Some(&open(&path).unwrap()), &path, 0).unwrap();
        assert!(written.changes);
        written.put_in_place().unwrap();
        let changes = fs::read(changes_path(&path)).unwrap();
        assert!(changes.len() < rebuilt.len() / 4 && fs::read(&path).unwrap() == first);
        let found = open(&path).unwrap().sealed;
        assert!(found.digest == charts.digest() && packed(&found) == rebuilt);
        assert_eq!(load_index(&db).unwrap().rebuilt, None);

        // Damaged or of another index they are as good as absent, and the index is made of the charts.
        for length in [50, CHANGES_HEAD_BYTES, changes.len() - 1] {
            fs::write(&path, &first).unwrap();
            fs::write(changes_path(&path), &changes[..length]).unwrap();
            let loaded = load_index(&db).unwrap();
            assert!(loaded.rebuilt.is_some() && packed(&loaded.sealed) == rebuilt, "cut at {length}");
            assert!(!changes_path(&path).exists());
        }
        fs::write(changes_path(&path), &changes).unwrap();
        assert_eq!(load_index(&db).unwrap().rebuilt, None);

        // Where little would stay in use all is written again.
        let now = units::UtcTime::from_micros(0);
        crate::remove(&db, &["US4MD81M".to_owned()], now).unwrap();
        let set = ChartDb::open(&db).unwrap();
        fs::write(&path, &rebuilt).unwrap();
        let before = open(&path).unwrap();
        let whole = PartFile::sized(&Contents::of(&set).unwrap(), Some(&before), &path, 0).unwrap();
        assert!(!whole.changes);
        whole.put_in_place().unwrap();
        assert!(fs::read(&path).unwrap().len() < changes.len() * 2 && !changes_path(&path).exists());
        assert_eq!(load_index(&db).unwrap().rebuilt, None);
    }
}
