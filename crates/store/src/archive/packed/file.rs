//! A compressed file, open for reading at any place.

use super::super::Disk;
use super::super::layout::PACKED_ARRIVALS;
use super::columns;
use super::table::{self, Coding, FOOTER_BYTES, Frame, HEAD_BYTES, Head, damaged};
use super::walk;
use crate::error::{Named as _, Result};
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::os::unix::fs::FileExt as _;
use std::path::Path;

/// A compressed file of the archive. As [`Read`] it gives the plain file from its start on, and fails at a damaged frame.
///
/// It holds one unpacked frame, 1 MiB at most.
pub struct Packed {
    file: File,
    head: Head,
    frames: Vec<Frame>,
    damage: Option<&'static str>,
    decoder: zstd::bulk::Decompressor<'static>,
    /// A frame as it is in the file.
    frame: Vec<u8>,
    unpacked: Vec<u8>,
    plain: Vec<u8>,
    /// The frame that `plain` is of.
    held: Option<u64>,
    /// Where reading goes on, in the plain file.
    at: u64,
}

impl fmt::Debug for Packed {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Packed")
            .field("head", &self.head)
            .field("at", &self.at)
            .finish_non_exhaustive()
    }
}

impl Packed {
    /// Opens a file, and checks its head and its seek table. Where one of them is damaged, or the end is cut off, the
    /// frames are found one after the other, which reads the whole file.
    ///
    /// # Errors
    /// It cannot be read, or nothing in it can be found.
    pub fn open(path: &Path) -> Result<Self> {
        Self::read(path).named(path)
    }

    pub(crate) fn read(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let file_bytes = file.metadata()?.len();
        if file_bytes < HEAD_BYTES as u64 + table::table_bytes(1) {
            return Err(damaged("it is cut"));
        }
        let mut head = [0; HEAD_BYTES];
        file.read_exact_at(&mut head, 0)?;
        let is_records = path.file_name().is_some_and(|name| name == PACKED_ARRIVALS);
        let (head, frames, damage) = match Head::read(&head) {
            Ok(head) => match seek_table(&file, &head, file_bytes) {
                Ok(frames) => (head, frames, None),
                Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                    (head, walk::frames(&file, &head, file_bytes)?, Some("its seek table is damaged"))
                }
                Err(error) => return Err(error),
            },
            // How many records a frame has stands in the head alone.
            Err(error) if error.kind() != io::ErrorKind::InvalidData || is_records => return Err(error),
            Err(error) => {
                let (head, frames) = walk::frames_without_head(&file, file_bytes)?.ok_or(error)?;
                (head, frames, Some("its head is damaged"))
            }
        };
        Ok(Self {
            file,
            head,
            frames,
            damage,
            decoder: zstd::bulk::Decompressor::new()?,
            frame: Vec::new(),
            unpacked: Vec::new(),
            plain: Vec::new(),
            held: None,
            at: 0,
        })
    }

    /// What is damaged in it beside frames, if so.
    pub(crate) fn damage(&self) -> Option<&'static str> {
        self.damage
    }

    /// Whether it still says what it was made of.
    pub(crate) fn has_digest(&self) -> bool {
        self.head.sha256 != walk::UNKNOWN
    }

    /// Bytes of the plain file.
    pub fn plain_bytes(&self) -> u64 {
        self.head.plain_bytes
    }

    /// SHA-256 of the plain file, as it was when this file was made; zeros if the head is damaged.
    pub fn plain_sha256(&self) -> [u8; 32] {
        self.head.sha256
    }

    /// The plain bytes of the frame in which a place lies, from there on; empty at the end.
    pub(crate) fn plain_from(&mut self, at: u64) -> io::Result<&[u8]> {
        if at >= self.head.plain_bytes {
            return Ok(&[]);
        }
        let frame_bytes = u64::from(self.head.frame_bytes);
        let frame = at / frame_bytes;
        if self.held != Some(frame) {
            self.held = None;
            self.unpack(frame)?;
            self.held = Some(frame);
        }
        Ok(&self.plain[(at % frame_bytes) as usize..])
    }

    /// Whether a place lies behind the last frame that was found.
    fn is_behind_frames(&self, at: u64) -> bool {
        at / u64::from(self.head.frame_bytes) >= self.frames.len() as u64
    }

    /// Plain bytes from a place to the end of its frame.
    fn rest_of_frame(&self, at: u64) -> u64 {
        let frame_bytes = u64::from(self.head.frame_bytes);
        self.head.plain_in(at / frame_bytes) - at % frame_bytes
    }

    fn unpack(&mut self, number: u64) -> io::Result<()> {
        let frame = *self.frames.get(number as usize).ok_or_else(|| damaged("a frame is missing"))?;
        self.frame.resize(frame.packed as usize, 0);
        self.file.read_exact_at(&mut self.frame, frame.at)?;
        let plain_bytes = self.head.plain_in(number) as usize;
        let into = match self.head.coding {
            Coding::Bytes => &mut self.plain,
            Coding::Records => &mut self.unpacked,
        };
        into.clear();
        into.reserve_exact(frame.unpacked as usize);
        let unpacked = self.decoder.decompress_to_buffer(&self.frame, into);
        if unpacked.ok() != Some(frame.unpacked as usize) {
            return Err(damaged("a frame is damaged"));
        }
        if self.head.coding == Coding::Records {
            self.plain.clear();
            columns::decode(&self.unpacked, plain_bytes, &mut self.plain)?;
        }
        Ok(())
    }
}

impl Read for Packed {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let from = self.plain_from(self.at)?;
        let count = from.len().min(into.len());
        into[..count].copy_from_slice(&from[..count]);
        self.at += count as u64;
        Ok(count)
    }
}

/// Reads a compressed file for people: a damaged frame is zeros, so that all other frames are still read, at their places.
#[derive(Debug)]
pub(crate) struct PackedReader {
    packed: Packed,
    at: u64,
}

impl PackedReader {
    pub(crate) fn new(packed: Packed, at: u64) -> Self {
        Self { packed, at }
    }
}

impl Read for PackedReader {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        // What is cut off ends there: nothing vouches for a length behind it.
        if self.packed.is_behind_frames(self.at) {
            return Ok(0);
        }
        let count = match self.packed.plain_from(self.at) {
            Ok(from) => {
                let count = from.len().min(into.len());
                into[..count].copy_from_slice(&from[..count]);
                count
            }
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                let count = self.packed.rest_of_frame(self.at).min(into.len() as u64) as usize;
                into[..count].fill(0);
                count
            }
            Err(error) => return Err(error),
        };
        self.at += count as u64;
        Ok(count)
    }
}

/// The frames as the seek table at the end of a file has them.
fn seek_table(file: &File, head: &Head, file_bytes: u64) -> io::Result<Vec<Frame>> {
    let mut footer = [0; FOOTER_BYTES];
    file.read_exact_at(&mut footer, file_bytes - FOOTER_BYTES as u64)?;
    let table_bytes = table::table_bytes(table::read_footer(&footer)?);
    if table_bytes > file_bytes - HEAD_BYTES as u64 {
        return Err(damaged("its seek table is damaged"));
    }
    let mut bytes = vec![0; table_bytes as usize];
    file.read_exact_at(&mut bytes, file_bytes - table_bytes)?;
    table::read_table(head, &bytes, file_bytes)
}

/// Puts a head to the start of a file that was written with room for it.
pub(super) fn put_head(file: &File, head: &Head, disk: &mut dyn Disk) -> io::Result<()> {
    file.write_all_at(&head.write(), 0)?;
    disk.sync(file)
}
