//! Photos of notes, one file each in the data folder.
//!
//! They are not in app.db, which has a single writing thread and is copied whole by each backup.

use crate::error::{Error, ErrorKind, Result};
use api::{Wording, say};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Bytes of one photo.
pub const PHOTO_BYTES: usize = 4 << 20;
/// Bytes of all photos together.
pub(super) const ALL_BYTES: u64 = 2 << 30;

/// A photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Photo {
    /// Its media type.
    pub media: String,
    /// The file.
    pub bytes: Vec<u8>,
}

/// A photo's media type by its first bytes, whatever its name says.
pub(super) fn media(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1A, b'\n', ..] => Some("image/png"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

/// The media type of a photo, if it can be kept.
///
/// # Errors
/// It is too large, or not a photo.
pub(super) fn check(bytes: &[u8]) -> Result<&'static str> {
    let wrong = |text: Wording| Error::new(ErrorKind::Malformed, text);
    if bytes.len() > PHOTO_BYTES {
        return Err(wrong(
            say("photo: it has more than {most} MiB. Make it smaller and send it again.")
                .with("most", PHOTO_BYTES >> 20),
        ));
    }
    let none = say("photo: not a JPEG, PNG or WebP file; choose one of these kinds.");
    media(bytes).ok_or_else(|| wrong(none))
}

/// The files.
#[derive(Debug, Clone)]
pub(super) struct Photos(PathBuf);

impl Photos {
    pub(super) fn new(data: &Path) -> Self {
        Self(data.join("logbook"))
    }

    fn path(&self, note: i64) -> PathBuf {
        self.0.join(note.to_string())
    }

    /// Keeps the photo of a note: whole, and on the disk when it returns.
    pub(super) fn keep(&self, note: i64, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.0)?;
        let part = self.0.join(format!("{note}.part"));
        let mut file = File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, self.path(note))?;
        File::open(&self.0)?.sync_all()
    }

    /// Removes the file of a photo whose note was not changed.
    pub(super) fn forget(&self, note: i64) {
        fs::remove_file(self.path(note)).ok();
    }

    pub(super) fn read(&self, note: i64) -> io::Result<Vec<u8>> {
        fs::read(self.path(note))
    }
}
