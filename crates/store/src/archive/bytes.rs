//! A day's file in either form, plain or compressed, read by places in the plain file.
//!
//! Both forms can lie in a folder: after a kill while a day was compressed, or when somebody unpacked a day there. A
//! compressed file gets its name only after it was compared whole with the plain one. So it is in use unless it cannot be
//! opened or the plain file is longer, and nothing is added to a day that has one.

use super::layout::{ARRIVALS, DATA, PACKED_DATA, packed_name};
use super::packed::{Packed, PackedReader};
use crate::error::{Named as _, Result};
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
                let bytes = file.metadata().named(&path)?.len();
                if let Some(packed) = packed_beside(folder, name, bytes) {
                    return Ok(Self::Packed(Box::new(PackedReader::new(packed, at))));
                }
                file.seek(SeekFrom::Start(at)).named(&path)?;
                Ok(Self::Plain(file))
            }
            // The compressed one has its name before the plain one loses it.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let packed = folder.join(packed_name(name));
                match Packed::read(&packed) {
                    Err(missing) if missing.kind() == io::ErrorKind::NotFound => Err(error).named(&path),
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
/// It cannot be read, or the compressed form is so damaged that its length is not known.
pub(crate) fn plain_bytes(folder: &Path, name: &str) -> Result<Option<u64>> {
    if let Some(bytes) = size(&folder.join(name))? {
        return Ok(Some(packed_beside(folder, name, bytes).map_or(bytes, |packed| packed.plain_bytes())));
    }
    let packed = folder.join(packed_name(name));
    match Packed::read(&packed) {
        Ok(file) => Ok(Some(file.plain_bytes())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => size(&folder.join(name)),
        Err(error) => Err(error).named(&packed),
    }
}

/// The same of what can be read: 0 where there is no file, or it cannot be read.
pub(crate) fn readable_bytes(folder: &Path, name: &str) -> u64 {
    plain_bytes(folder, name).ok().flatten().unwrap_or(0)
}

/// Whether a day's packets are compressed, so that nothing is added to them. A plain file may still lie beside.
pub(crate) fn is_packed(folder: &Path) -> bool {
    folder.join(PACKED_DATA).exists()
}

/// Whether a day has a compressed file.
pub(crate) fn has_packed(folder: &Path) -> bool {
    [DATA, ARRIVALS].iter().any(|name| folder.join(packed_name(name)).exists())
}

/// Whether the plain form of a day's file is the one in use, or there is only that one.
pub(crate) fn is_plain_in_use(folder: &Path, name: &str) -> bool {
    matches!(size(&folder.join(name)), Ok(Some(bytes)) if packed_beside(folder, name, bytes).is_none())
}

/// The compressed file beside a plain one of so many bytes, if it is the one in use.
fn packed_beside(folder: &Path, name: &str, plain_bytes: u64) -> Option<Packed> {
    // Of a day whose packets are plain, records are added to the plain file.
    if !is_packed(folder) {
        return None;
    }
    Packed::read(&folder.join(packed_name(name))).ok().filter(|packed| packed.plain_bytes() >= plain_bytes)
}

/// What an operator should know of a day's compressed files: damage, and plain files beside them that hold less.
pub(crate) fn findings(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for name in [DATA, ARRIVALS] {
        let packed_name = packed_name(name);
        let path = folder.join(packed_name);
        match Packed::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => found.push(format!("{packed_name} {error}")),
            Ok(packed) => {
                if let Some(damage) = packed.damage() {
                    found.push(format!(
                        "{packed_name}: {damage}; what is whole of it is still read. Copy the file from a backup"
                    ));
                }
                let plain = size(&folder.join(name)).ok().flatten();
                if let Some(bytes) = plain.filter(|bytes| is_packed(folder) && *bytes < packed.plain_bytes())
                {
                    found.push(format!(
                        "{name} has {bytes} bytes and lies beside {packed_name}, which holds {} and is in use. Move \
                         {name} to another folder",
                        packed.plain_bytes()
                    ));
                }
            }
        }
    }
    found
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
