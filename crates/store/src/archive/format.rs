//! The format of the archive's files: `archive/format.json`. A program that knows only an older format leaves the folder
//! alone: it would take records that it does not understand for damage and cut them off.

use crate::error::{Named as _, Result, StoreError};
use serde_json::{Value, json};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

/// The file's name.
pub(crate) const FORMAT_FILE: &str = "format.json";
/// The latest format version that this program knows. Raise it with a new transport, flag of a record or file.
///
/// - 1: days as they were written.
/// - 2: days may be compressed, and have several parts.
const FORMAT: u64 = 2;
/// The format of an archive without any of these, which programs that know only that one may go on using.
const PLAIN: u64 = 1;

/// Refuses an archive of a later format. Reads one file and writes nothing.
///
/// # Errors
/// [`StoreError::NewerArchive`], or the file cannot be read.
pub(crate) fn refuse_newer(archive: &Path) -> Result<()> {
    match known(archive)? {
        Some((found, program)) if found > FORMAT => {
            Err(StoreError::NewerArchive { path: archive.to_owned(), found, known: FORMAT, program })
        }
        _ => Ok(()),
    }
}

/// Writes down the form, where it is not, or where it says that no day is compressed and one is.
pub(crate) fn note(archive: &Path) -> Result<()> {
    let known = known(archive)?.map(|(format, _)| format);
    if known.is_some_and(|format| format >= FORMAT) {
        return Ok(());
    }
    let has_packed = super::days(archive)?
        .iter()
        .any(|key| super::bytes::has_packed(&key.folder(archive)) || key.part > 0);
    match (has_packed, known) {
        (true, _) => write(archive, FORMAT),
        (false, None) => write(archive, PLAIN),
        (false, Some(_)) => Ok(()),
    }
}

/// Writes down, before the first day is compressed, that there may be such days.
pub(crate) fn note_packed(archive: &Path) -> Result<()> {
    let is_noted = known(archive)?.is_some_and(|(format, _)| format >= FORMAT);
    if is_noted { Ok(()) } else { write(archive, FORMAT) }
}

fn write(archive: &Path, format: u64) -> Result<()> {
    let (path, new) = (archive.join(FORMAT_FILE), archive.join("format.json.new"));
    let text = json!({ "format": format, "program": env!("CARGO_PKG_VERSION") }).to_string();
    let write = || -> std::io::Result<()> {
        let mut file = File::create(&new)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&new, &path)?;
        File::open(archive)?.sync_all()
    };
    write().named(&path)
}

/// The form and the program that wrote it down; `None` where nothing, or nothing that can be read, is written down: every
/// program since writes it whole or not at all.
fn known(archive: &Path) -> Result<Option<(u64, String)>> {
    let path = archive.join(FORMAT_FILE);
    let text = match fs::read(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        text => text.named(&path)?,
    };
    let Ok(said) = serde_json::from_slice::<Value>(&text) else { return Ok(None) };
    let program = said["program"].as_str().unwrap_or("unknown").to_owned();
    Ok(said["format"].as_u64().map(|format| (format, program)))
}
