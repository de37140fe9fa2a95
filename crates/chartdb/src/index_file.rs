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

/// Writes under another name first: a file that is there is whole.
pub(crate) fn write(path: &Path, sealed: &SealedIndex) -> Result<()> {
    let part = part_of(path);
    let write = || {
        let mut file = File::create(&part)?;
        file.write_all(&sealed.to_bytes())?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    write().map_err(|source| {
        fs::remove_file(&part).ok();
        ChartDbError::Io { path: path.to_owned(), source }
    })
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
