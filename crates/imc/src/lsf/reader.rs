//! Reading a log as a stream, compressed or not, whole or cut.

use crate::deframe::{Damage, Deframer, Frame};
use crate::header::PacketView;
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Bytes that are read at once.
const CHUNK_BYTES: usize = 1 << 18;
/// The first two bytes of a gzip member (RFC 1952, 2.3.1).
const GZIP_MAGIC: [u8; 2] = [0x1F, 0x8B];

/// One thing found in a log.
#[derive(Debug, PartialEq)]
pub enum LogItem<'a> {
    /// A whole packet with a right checksum.
    Packet {
        /// Its first byte in the unpacked log.
        offset: u64,
        /// The packet.
        view: PacketView<'a>,
    },
    /// Bytes that are no packet, such as the cut last packet of a vehicle that lost its power.
    Damage(Damage),
    /// The compressed log ends here, before its own end: it was cut or is damaged. Everything before was
    /// read. Comes at most once and last.
    Cut {
        /// Bytes that could be unpacked.
        offset: u64,
        /// What the decompressor says.
        problem: String,
    },
}

/// Packets and damage of a log, in constant memory.
#[derive(Debug)]
pub struct LogReader<R> {
    source: R,
    compressed: bool,
    deframer: Deframer,
    chunk: Vec<u8>,
    unpacked: u64,
    ended: bool,
    problem: Option<String>,
}

impl LogReader<Box<dyn Read>> {
    /// A log file, unpacked on the way when its first bytes say that it is gzip.
    ///
    /// # Errors
    /// When the file cannot be opened or read.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::detect(File::open(path)?)
    }

    /// As [`Self::open`], from any source of bytes.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn detect(mut source: impl Read + 'static) -> io::Result<Self> {
        // A pipe may give its first bytes one by one.
        let mut start = Vec::new();
        source.by_ref().take(GZIP_MAGIC.len() as u64).read_to_end(&mut start)?;
        let compressed = start == GZIP_MAGIC;
        let source = io::Cursor::new(start).chain(source);
        let source: Box<dyn Read> = if compressed {
            Box::new(MultiGzDecoder::new(BufReader::with_capacity(CHUNK_BYTES, source)))
        } else {
            Box::new(source)
        };
        Ok(LogReader { compressed, ..LogReader::new(source) })
    }
}

impl<R: Read> LogReader<R> {
    /// A log that is not compressed.
    pub fn new(source: R) -> Self {
        Self {
            source,
            compressed: false,
            deframer: Deframer::new(),
            chunk: vec![0; CHUNK_BYTES],
            unpacked: 0,
            ended: false,
            problem: None,
        }
    }

    /// Bytes of the unpacked log read so far.
    pub fn unpacked_bytes(&self) -> u64 {
        self.unpacked
    }

    /// The next packet or damage; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read. Damage in the log is no error.
    pub fn next_item(&mut self) -> io::Result<Option<LogItem<'_>>> {
        loop {
            if let Some(found) = self.deframer.find() {
                return Ok(Some(match self.deframer.frame(found) {
                    Frame::Packet { offset, view } => LogItem::Packet { offset, view },
                    Frame::Damage(damage) => LogItem::Damage(damage),
                }));
            }
            if self.ended {
                let offset = self.unpacked;
                return Ok(self.problem.take().map(|problem| LogItem::Cut { offset, problem }));
            }
            self.fill()?;
        }
    }

    fn fill(&mut self) -> io::Result<()> {
        match self.source.read(&mut self.chunk) {
            Ok(0) => self.end(),
            Ok(count) => {
                self.unpacked += count as u64;
                self.deframer.push(&self.chunk[..count]).map_err(io::Error::other)?;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if self.compressed && is_damage(&error) => {
                self.problem = Some(error.to_string());
                self.end();
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn end(&mut self) {
        self.ended = true;
        self.deframer.finish();
    }
}

/// Whether the decompressor complains of its input rather than the source of failing.
fn is_damage(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    matches!(error.kind(), InvalidData | InvalidInput | UnexpectedEof)
}
