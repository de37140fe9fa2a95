//! The few calls by which the archive grows, so that tests can make each of them fail.

use std::fs::File;
use std::io::{self, Write as _};

/// Appending and syncing.
pub(crate) trait Disk: std::fmt::Debug + Send {
    /// Appends all bytes, or fails having appended some of them.
    fn append(&mut self, file: &File, bytes: &[u8]) -> io::Result<()>;
    /// Waits until what was appended is on the disk.
    fn sync(&mut self, file: &File) -> io::Result<()>;
}

/// The real one.
#[derive(Debug)]
pub(crate) struct RealDisk;

impl Disk for RealDisk {
    fn append(&mut self, mut file: &File, bytes: &[u8]) -> io::Result<()> {
        file.write_all(bytes)
    }

    fn sync(&mut self, file: &File) -> io::Result<()> {
        file.sync_data()
    }
}
