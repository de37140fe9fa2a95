//! Where bytes of an export wait that its format needs only at the end: a file without a name in the data folder, which is gone with the
//! export, and with the program.
//!
//! Each export has at most 1 GiB there, and none goes on where the disk has less left than recording needs. What is full is an error that
//! says what to do; the export then ends.

use crate::history::imports::RESERVED_BYTES;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes that may wait where nothing else is said: some two million detections of NetCDF.
pub(super) const MOST: u64 = 1 << 30;
/// How often the disk is looked at, bytes.
const LOOK_EVERY: u64 = 64 << 20;

/// A bounded file without a name.
#[derive(Debug)]
pub(super) struct Bounded {
    file: File,
    data: PathBuf,
    most: u64,
    written: u64,
    /// So much is written before the disk is looked at again.
    look_at: u64,
}

impl Bounded {
    /// # Errors
    /// The data folder takes no file, or its disk is full.
    pub(super) fn new(data: &Path, most: u64) -> io::Result<Self> {
        room(data)?;
        let file = tempfile::tempfile_in(data).map_err(|error| named(data, &error))?;
        Ok(Self { file, data: data.to_owned(), most, written: 0, look_at: LOOK_EVERY })
    }
}

/// Whether the disk has more left than recording needs.
///
/// # Errors
/// It has not, or does not say.
pub(super) fn room(data: &Path) -> io::Result<()> {
    let free = store::free_bytes(data).map_err(io::Error::other)?;
    if free >= RESERVED_BYTES {
        return Ok(());
    }
    // It is shown to people with a link too: no folder is named.
    let text = format!(
        "the server's disk is full up to the {} MiB that are kept for recording; make room there, or choose a format that needs none, such as \
         lutra",
        RESERVED_BYTES >> 20
    );
    Err(io::Error::new(io::ErrorKind::StorageFull, text))
}

/// Why the data folder takes no file.
pub(super) fn named(data: &Path, error: &io::Error) -> io::Error {
    let text = format!(
        "{}: a file of this format waits here until it is whole, and none can be written to the folder: {error}",
        data.display()
    );
    io::Error::other(text)
}

/// More than may wait.
pub(super) fn full(most: u64) -> io::Error {
    let text = format!(
        "a file of this format is made of at most {} MiB; ask for a shorter time or fewer vessels, or for a format that needs no place, such as \
         lutra or parquet",
        most >> 20
    );
    io::Error::new(io::ErrorKind::FileTooLarge, text)
}

impl Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.written + bytes.len() as u64 > self.most {
            return Err(full(self.most));
        }
        if self.written >= self.look_at {
            room(&self.data)?;
            self.look_at = self.written + LOOK_EVERY;
        }
        let written = self.file.write(bytes)?;
        self.written += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Read for Bounded {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.read(bytes)
    }
}

impl Seek for Bounded {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_full_says_so_and_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut spool = Bounded::new(folder.path(), 10).unwrap();
        spool.write_all(b"12345678").unwrap();
        let told = spool.write_all(b"9ab").unwrap_err();
        assert!(told.to_string().contains("ask for a shorter time"), "{told}");
        spool.seek(SeekFrom::Start(0)).unwrap();
        let mut read = String::new();
        spool.read_to_string(&mut read).unwrap();
        assert_eq!(read, "12345678");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it has no name");
        let gone = folder.path().join("gone");
        let told = Bounded::new(&gone, 10).unwrap_err();
        assert!(told.to_string().contains("gone"), "{told}");
    }
}
