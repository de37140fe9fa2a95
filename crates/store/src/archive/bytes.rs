//! A day's file in either form, plain or compressed, read by places in the plain file.
//!
//! Where both forms lie in a folder, after a kill while a day was compressed, the plain one is in use: it is the one that
//! was written first.

use super::layout::{ARRIVALS, DATA, packed_name};
use super::packed::{Packed, PackedReader};
use crate::error::{Named as _, Result, StoreError};
use std::fs::{self, File};
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// A day's file, open at a place.
#[derive(Debug)]
pub(crate) enum DayFile {
    Plain(File),
    Packed(Box<PackedReader>),
}

impl DayFile {
    /// Opens the file that is called `name` in its plain form, at byte `at` of that form.
    pub(crate) fn open(folder: &Path, name: &str, at: u64) -> Result<Self> {
        let path = folder.join(name);
        match File::open(&path) {
            Ok(mut file) => {
                file.seek(SeekFrom::Start(at)).named(&path)?;
                Ok(Self::Plain(file))
            }
            // The compressed one has its name before the plain one loses it.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let packed = folder.join(packed_name(name));
                match Packed::read(&packed) {
                    Err(none) if none.kind() == io::ErrorKind::NotFound => Err(error).named(&path),
                    other => Ok(Self::Packed(Box::new(PackedReader::new(other.named(&packed)?, at)))),
                }
            }
            Err(error) => Err(error).named(&path),
        }
    }
}

impl Read for DayFile {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(into),
            Self::Packed(packed) => packed.read(into),
        }
    }
}

/// Bytes of the plain form of a day's file, whichever form it has; `None` when there is neither.
///
/// # Errors
/// It cannot be read, or the head or the seek table of the compressed form is damaged.
pub(crate) fn plain_bytes(folder: &Path, name: &str) -> Result<Option<u64>> {
    if let Some(bytes) = size(&folder.join(name))? {
        return Ok(Some(bytes));
    }
    let packed = folder.join(packed_name(name));
    match Packed::read(&packed) {
        Ok(file) => Ok(Some(file.plain_bytes())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => size(&folder.join(name)),
        Err(error) => Err(error).named(&packed),
    }
}

/// The same of what can be read: 0 where there is no file, or a compressed one is damaged.
///
/// # Errors
/// It cannot be looked at.
pub(crate) fn readable_bytes(folder: &Path, name: &str) -> Result<u64> {
    match plain_bytes(folder, name) {
        Err(StoreError::Io { source, .. }) if source.kind() == io::ErrorKind::InvalidData => Ok(0),
        other => Ok(other?.unwrap_or(0)),
    }
}

/// Whether a day's packets are compressed, so that nothing is added to them.
pub(crate) fn is_packed(folder: &Path) -> bool {
    !folder.join(DATA).exists() && folder.join(packed_name(DATA)).exists()
}

/// Whether there is a file, in either form.
pub(crate) fn is_there(folder: &Path, name: &str) -> bool {
    folder.join(name).exists() || folder.join(packed_name(name)).exists()
}

/// Bytes that a day's packets and records of arrival take on the disk.
pub(crate) fn disk_bytes(folder: &Path) -> u64 {
    day_files(folder).iter().map(|path| fs::metadata(path).map_or(0, |file| file.len())).sum()
}

/// The paths that a day's packets and records of arrival may have.
pub(crate) fn day_files(folder: &Path) -> [PathBuf; 4] {
    [DATA, packed_name(DATA), ARRIVALS, packed_name(ARRIVALS)].map(|name| folder.join(name))
}

fn size(path: &Path) -> Result<Option<u64>> {
    match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        other => other.named(path).map(|file| Some(file.len())),
    }
}
