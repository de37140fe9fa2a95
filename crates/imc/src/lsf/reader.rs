//! Reading a log as a stream, compressed or not, whole or cut.

use super::gunzip::{self, Gunzip, Unpacked};
use crate::deframe::{Damage, Deframer, Frame};
use crate::header::PacketView;
use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// Bytes that are read or unpacked at once.
const CHUNK_BYTES: usize = 1 << 18;

/// One finding in a log.
#[derive(Debug, PartialEq)]
pub enum LogItem<'a> {
    /// A whole packet with a right checksum.
    Packet {
        /// Its first byte in the unpacked log.
        offset: u64,
        /// The packet.
        view: PacketView<'a>,
    },
    /// Bytes that are not a packet, such as the cut last packet of a vehicle that lost its power.
    Damage(Damage),
    /// The compressed log is cut or damaged here and some of it is missing. Every byte that could be unpacked
    /// was; if another member of the file follows, the log continues with it.
    Cut {
        /// Bytes unpacked before.
        offset: u64,
        /// What is wrong.
        problem: &'static str,
    },
}

/// Packets and damage of a log, in constant memory.
#[derive(Debug)]
pub struct LogReader<R> {
    source: Source<R>,
    deframer: Deframer,
    chunk: Vec<u8>,
    unpacked: u64,
    ended: bool,
    problem: Option<&'static str>,
    /// The file, when the reader opened it itself: its errors name it.
    path: Option<PathBuf>,
}

/// The same error with the file in front of it.
fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[derive(Debug)]
enum Source<R> {
    Plain(R),
    Gzip(Box<Gunzip<R>>),
}

impl LogReader<io::Chain<io::Cursor<Vec<u8>>, File>> {
    /// A log file, unpacked on the way when its first bytes say that it is gzip.
    ///
    /// # Errors
    /// When the file cannot be opened or read. This error and those of reading on name the file.
    pub fn open(path: &Path) -> io::Result<Self> {
        let reader = File::open(path).and_then(Self::detect).map_err(|error| named(path, &error))?;
        Ok(Self { path: Some(path.to_owned()), ..reader })
    }
}

impl LogReader<File> {
    /// A log file from byte `offset` on, as [`super::Index::bytes_between`] gives it. Offsets of what is found
    /// continue to count from the start of the file.
    ///
    /// # Errors
    /// When the file cannot be opened or read, or is compressed: there is no way into the middle of that. This
    /// error and those of reading on name the file.
    pub fn open_at(path: &Path, offset: u64) -> io::Result<Self> {
        let reader = Self::seek(path, offset).map_err(|error| named(path, &error))?;
        Ok(Self { path: Some(path.to_owned()), ..reader })
    }

    fn seek(path: &Path, offset: u64) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let mut start = Vec::new();
        file.by_ref().take(gunzip::MAGIC.len() as u64).read_to_end(&mut start)?;
        if start == gunzip::MAGIC {
            let problem = "a compressed log can only be read from its start; unpack it first";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        file.seek(SeekFrom::Start(offset))?;
        Ok(Self { deframer: Deframer::at(offset), ..Self::new(file) })
    }
}

impl<R: Read> LogReader<io::Chain<io::Cursor<Vec<u8>>, R>> {
    /// As [`LogReader::open`], from any source of bytes.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn detect(mut source: R) -> io::Result<Self> {
        // A pipe may give its first bytes one by one.
        let mut start = Vec::new();
        source.by_ref().take(gunzip::MAGIC.len() as u64).read_to_end(&mut start)?;
        let compressed = start == gunzip::MAGIC;
        let source = io::Cursor::new(start).chain(source);
        let source =
            if compressed { Source::Gzip(Box::new(Gunzip::new(source))) } else { Source::Plain(source) };
        Ok(Self::from_source(source))
    }
}

impl<R: Read> LogReader<R> {
    /// A log that is not compressed.
    pub fn new(source: R) -> Self {
        Self::from_source(Source::Plain(source))
    }

    fn from_source(source: Source<R>) -> Self {
        Self {
            source,
            deframer: Deframer::new(),
            chunk: vec![0; CHUNK_BYTES],
            unpacked: 0,
            ended: false,
            problem: None,
            path: None,
        }
    }

    /// Bytes of the unpacked log read so far.
    pub fn unpacked_bytes(&self) -> u64 {
        self.unpacked
    }

    /// The next packet or damage; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read. Damage in the log is not an error.
    pub fn next_item(&mut self) -> io::Result<Option<LogItem<'_>>> {
        loop {
            if let Some(found) = self.deframer.find() {
                return Ok(Some(match self.deframer.frame(found) {
                    Frame::Packet { offset, view } => LogItem::Packet { offset, view },
                    Frame::Damage(damage) => LogItem::Damage(damage),
                }));
            }
            if let Some(problem) = self.problem.take() {
                return Ok(Some(LogItem::Cut { offset: self.unpacked, problem }));
            }
            if self.ended {
                return Ok(None);
            }
            self.fill().map_err(|error| match &self.path {
                Some(path) => named(path, &error),
                None => error,
            })?;
        }
    }

    fn fill(&mut self) -> io::Result<()> {
        let count = match &mut self.source {
            Source::Plain(source) => match source.read(&mut self.chunk) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => return Ok(()),
                other => other?,
            },
            Source::Gzip(source) => match source.read(&mut self.chunk)? {
                Unpacked::Bytes(count) => count,
                Unpacked::Damage(problem) => {
                    self.problem = Some(problem);
                    return Ok(());
                }
                Unpacked::End => 0,
            },
        };
        if count == 0 {
            self.ended = true;
            self.deframer.finish();
        } else {
            self.unpacked += count as u64;
            self.deframer.push(&self.chunk[..count]);
        }
        Ok(())
    }
}
