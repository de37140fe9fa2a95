//! Bytes that a file needs only at its end, and that wait in a place of the caller's until then.
//!
//! A core opens no files: whoever writes a file that needs one hands in a [`Spool`], which may be a file without a name, and says by its
//! errors when that is full.

use std::fmt::Debug;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};

/// A place for bytes, empty at first; read from its beginning once all are there.
pub trait Spool: Read + Write + Seek + Send + Debug {}

impl<T: Read + Write + Seek + Send + Debug> Spool for T {}

/// Bytes of a chunk.
const CHUNK: usize = 64 * 1024;

/// Bytes on their way into a spool.
#[derive(Debug)]
pub(super) struct Waiting {
    spool: BufWriter<Box<dyn Spool>>,
}

impl Waiting {
    /// # Errors
    /// Whoever calls gave no spool.
    pub(super) fn new(spool: Option<Box<dyn Spool>>) -> io::Result<Self> {
        let none = || io::Error::other("this format needs a place for bytes that wait, and it was not given");
        Ok(Self { spool: BufWriter::with_capacity(CHUNK, spool.ok_or_else(none)?) })
    }

    /// # Errors
    /// The place is full, or fails.
    pub(super) fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.spool.write_all(bytes)
    }

    /// All that waits, from its beginning.
    ///
    /// # Errors
    /// As [`Self::push()`].
    pub(super) fn read(self) -> io::Result<impl BufRead> {
        let mut spool = self.spool.into_inner().map_err(io::IntoInnerError::into_error)?;
        spool.seek(SeekFrom::Start(0))?;
        Ok(BufReader::with_capacity(CHUNK, spool))
    }
}
