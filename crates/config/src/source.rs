//! Where the bytes of configuration files come from: a disk, or a table in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// The largest single file that is read, in bytes.
pub const MAX_FILE_BYTES: usize = 1 << 20;

/// Gives the bytes of files by path.
pub trait FileSource {
    /// The whole file.
    ///
    /// # Errors
    /// What the file system says, or [`io::ErrorKind::FileTooLarge`] beyond [`MAX_FILE_BYTES`].
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl FileSource for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(path)?.take(MAX_FILE_BYTES as u64 + 1).read_to_end(&mut bytes)?;
        bounded(bytes)
    }
}

/// Files held in memory, for tests and for text received from elsewhere.
#[derive(Clone, Debug, Default)]
pub struct InMemory {
    files: BTreeMap<PathBuf, Vec<u8>>,
}

impl InMemory {
    /// No files.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same table with one more file.
    #[must_use]
    pub fn with(mut self, path: impl Into<PathBuf>, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.insert(path.into(), bytes.into());
        self
    }
}

impl FileSource for InMemory {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let bytes = self.files.get(path).ok_or(io::ErrorKind::NotFound)?;
        bounded(bytes.clone())
    }
}

fn bounded(bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    if bytes.len() > MAX_FILE_BYTES { Err(io::ErrorKind::FileTooLarge.into()) } else { Ok(bytes) }
}

/// `path` without `.` and with `folder/..` taken out, so that one file has one name.
///
/// This is done on the text alone: a symbolic link to a folder is not followed first.
pub(crate) fn normalised(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(clean.components().next_back(), Some(Component::Normal(_))) => {
                clean.pop();
            }
            Component::Prefix(_) | Component::RootDir | Component::ParentDir | Component::Normal(_) => {
                clean.push(part);
            }
        }
    }
    clean
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_has_one_name() {
        for (given, clean) in
            [("a/../b.ini", "b.ini"), ("./a/./b", "a/b"), ("../x/../y", "../y"), ("/a/b/../../c", "/c")]
        {
            assert_eq!(normalised(Path::new(given)), Path::new(clean), "{given}");
        }
    }

    #[test]
    fn refuses_a_file_beyond_the_limit() {
        let files = InMemory::new().with("big", vec![b'#'; MAX_FILE_BYTES + 1]);
        assert_eq!(files.read(Path::new("big")).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(files.read(Path::new("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
