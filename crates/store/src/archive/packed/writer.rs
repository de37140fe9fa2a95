//! Makes a compressed file of a plain one, some bytes at a time: written beside, synced, and read back whole against the
//! plain file. Nothing in use is touched here.

use super::super::Disk;
use super::columns;
use super::file::{Packed, put_head};
use super::table::{Coding, FRAME_BYTES, HEAD_BYTES, Head, write_table};
use crate::error::{Named as _, Result, StoreError};
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

/// The level of zstd: higher ones gain a few tenths of a percent on packets.
const LEVEL: i32 = 6;

/// Bytes that are written between two syncs, so that no sync holds up the recorder's for long.
const SYNC_BYTES: u64 = 8 << 20;

/// The work on one file.
pub(crate) struct Packer {
    plain: PathBuf,
    part: PathBuf,
    source: File,
    plain_bytes: u64,
    coding: Coding,
    frame_bytes: u32,
    stage: Stage,
    at: u64,
}

/// How far it is.
enum Stage {
    Writing(Box<Writing>),
    /// Reading back a file: this one's, or one that lies beside the plain file.
    Checking(Box<Checking>),
    Done {
        packed_bytes: u64,
    },
}

struct Writing {
    file: File,
    compressor: zstd::bulk::Compressor<'static>,
    hash: Sha256,
    frames: Vec<(u32, u32)>,
    unsynced_bytes: u64,
}

struct Checking {
    packed: Packed,
    hash: Sha256,
    /// Where the file is written anew, for one that lay beside the plain file.
    again: Option<PathBuf>,
    /// Frames of it are damaged.
    is_damaged: bool,
}

/// What a turn did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Turn {
    /// There is more to do.
    More,
    /// The new file is written and synced; it has yet to be read back.
    Written,
    /// The file is read back and is the plain one, byte for byte.
    Done,
}

impl Packer {
    /// Begins to make `part` of the first `plain_bytes` bytes of `plain`, which must be all of it.
    pub(crate) fn write(
        plain: &Path,
        part: &Path,
        coding: Coding,
        frame_bytes: u32,
        disk: &mut dyn Disk,
    ) -> Result<Self> {
        let source = File::open(plain).named(plain)?;
        let plain_bytes = source.metadata().named(plain)?.len();
        let stage = Stage::Writing(Box::new(Writing::begin(part, disk).named(part)?));
        let (plain, part) = (plain.to_owned(), part.to_owned());
        Ok(Self {
            plain,
            part,
            source,
            plain_bytes,
            coding,
            frame_bytes: frame_bytes.min(FRAME_BYTES),
            stage,
            at: 0,
        })
    }

    /// Begins to hold `packed`, which lies at `path` beside `plain`, against it. One that is damaged, or lacks packets
    /// that came later, is written anew as `part`, once the plain file is proved to begin with all that it was made of.
    ///
    /// # Errors
    /// [`StoreError::Differs`] if it holds more than the plain file.
    pub(crate) fn check(
        plain: &Path,
        path: &Path,
        packed: Packed,
        part: &Path,
        coding: Coding,
        frame_bytes: u32,
    ) -> Result<Self> {
        let source = File::open(plain).named(plain)?;
        let plain_bytes = source.metadata().named(plain)?.len();
        if packed.plain_bytes() > plain_bytes {
            return Err(differs(path, packed.plain_bytes(), plain, plain_bytes));
        }
        let stage = Stage::Checking(Box::new(Checking {
            is_damaged: packed.damage().is_some(),
            packed,
            hash: Sha256::new(),
            again: Some(part.to_owned()),
        }));
        let (plain, part) = (plain.to_owned(), path.to_owned());
        let frame_bytes = frame_bytes.min(FRAME_BYTES);
        Ok(Self { plain, part, source, plain_bytes, coding, frame_bytes, stage, at: 0 })
    }

    /// The plain file.
    pub(crate) fn plain(&self) -> &Path {
        &self.plain
    }

    /// The file that is made or checked.
    pub(crate) fn part(&self) -> &Path {
        &self.part
    }

    /// Bytes of the plain file.
    pub(crate) fn plain_bytes(&self) -> u64 {
        self.plain_bytes
    }

    /// Bytes of the compressed file, once it is done.
    pub(crate) fn packed_bytes(&self) -> Option<u64> {
        match self.stage {
            Stage::Done { packed_bytes } => Some(packed_bytes),
            Stage::Writing(_) | Stage::Checking(_) => None,
        }
    }

    /// Works on about so many bytes of the plain file; a frame at least.
    ///
    /// # Errors
    /// A file cannot be read or written, or what was written does not read back as the plain file.
    pub(crate) fn work(&mut self, bytes: u64, disk: &mut dyn Disk) -> Result<Turn> {
        let enough = self.at.saturating_add(bytes.max(1));
        let mut stretch = vec![0; self.frame_bytes as usize];
        let end = match &self.stage {
            Stage::Checking(checking) => self.plain_bytes.min(checking.packed.plain_bytes()),
            Stage::Writing(_) | Stage::Done { .. } => self.plain_bytes,
        };
        while self.at < end && self.at < enough {
            let count = (end - self.at).min(self.frame_bytes.into()) as usize;
            let stretch = &mut stretch[..count];
            self.source.read_exact_at(stretch, self.at).named(&self.plain)?;
            match &mut self.stage {
                Stage::Writing(writing) => writing.frame(stretch, self.coding, disk).named(&self.part)?,
                Stage::Checking(checking) => {
                    if !checking.frame(stretch, self.at).named(&self.part)? {
                        return Err(self.not_the_same());
                    }
                }
                Stage::Done { .. } => {}
            }
            self.at += count as u64;
        }
        if self.at < end {
            return Ok(Turn::More);
        }
        match &mut self.stage {
            Stage::Writing(writing) => {
                let head = Head {
                    coding: self.coding,
                    frame_bytes: self.frame_bytes,
                    plain_bytes: self.plain_bytes,
                    sha256: writing.hash.clone().finalize().into(),
                };
                disk.append(&writing.file, &write_table(&writing.frames)).named(&self.part)?;
                put_head(&writing.file, &head, disk).named(&self.part)?;
                // What is read back comes from the disk, as far as the system lets it.
                rustix::fs::fadvise(&writing.file, 0, None, rustix::fs::Advice::DontNeed).ok();
                let packed = Packed::open(&self.part)?;
                self.stage = Stage::Checking(Box::new(Checking {
                    is_damaged: packed.damage().is_some(),
                    packed,
                    hash: Sha256::new(),
                    again: None,
                }));
                self.at = 0;
                Ok(Turn::Written)
            }
            Stage::Checking(checking) => {
                let sha256: [u8; 32] = checking.hash.clone().finalize().into();
                let is_begin = checking.packed.plain_sha256() == sha256;
                let is_whole = !checking.is_damaged && checking.packed.plain_bytes() == self.plain_bytes;
                let end = self.source.metadata().named(&self.plain)?.len();
                if !is_begin || end != self.plain_bytes || !is_whole && checking.again.is_none() {
                    return Err(self.not_the_same());
                }
                if let Some(part) = checking.again.take().filter(|_| !is_whole) {
                    self.stage = Stage::Writing(Box::new(Writing::begin(&part, disk).named(&part)?));
                    (self.part, self.at) = (part, 0);
                    return Ok(Turn::More);
                }
                let packed_bytes = fs::metadata(&self.part).named(&self.part)?.len();
                self.stage = Stage::Done { packed_bytes };
                Ok(Turn::Done)
            }
            Stage::Done { .. } => Ok(Turn::Done),
        }
    }
}

impl Packer {
    /// The error for a compressed file that does not hold what the plain one holds.
    fn not_the_same(&self) -> StoreError {
        match &self.stage {
            Stage::Checking(checking) if checking.again.is_some() => {
                differs(&self.part, checking.packed.plain_bytes(), &self.plain, self.plain_bytes)
            }
            _ => StoreError::Io {
                path: self.part.clone(),
                source: io::Error::other(format!(
                    "does not read back as {}, which stays as it is; check the disk",
                    self.plain.display()
                )),
            },
        }
    }
}

impl Writing {
    fn begin(part: &Path, disk: &mut dyn Disk) -> io::Result<Self> {
        let file = File::create(part)?;
        disk.append(&file, &[0; HEAD_BYTES])?;
        let mut compressor = zstd::bulk::Compressor::new(LEVEL)?;
        compressor.include_checksum(true)?;
        Ok(Self { file, compressor, hash: Sha256::new(), frames: Vec::new(), unsynced_bytes: 0 })
    }

    fn frame(&mut self, plain: &[u8], coding: Coding, disk: &mut dyn Disk) -> io::Result<()> {
        self.hash.update(plain);
        let columns;
        let unpacked = match coding {
            Coding::Bytes => plain,
            Coding::Records => {
                columns = columns::encode(plain);
                &columns
            }
        };
        let packed = self.compressor.compress(unpacked)?;
        disk.append(&self.file, &packed)?;
        self.unsynced_bytes += packed.len() as u64;
        if self.unsynced_bytes >= SYNC_BYTES {
            disk.sync(&self.file)?;
            self.unsynced_bytes = 0;
        }
        self.frames.push((packed.len() as u32, unpacked.len() as u32));
        Ok(())
    }
}

impl Checking {
    /// Compares a stretch of the plain file; false if it differs. A damaged frame of a file that can be written anew is
    /// only noted: the digest over the plain bytes decides.
    fn frame(&mut self, plain: &[u8], at: u64) -> io::Result<bool> {
        self.hash.update(plain);
        let mut done = 0;
        while done < plain.len() {
            let from = match self.packed.plain_from(at + done as u64) {
                Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                    self.is_damaged = true;
                    return Ok(self.again.is_some());
                }
                other => other?,
            };
            let count = from.len().min(plain.len() - done);
            if count == 0 || from[..count] != plain[done..done + count] {
                return Ok(false);
            }
            done += count;
        }
        Ok(true)
    }
}

fn differs(packed: &Path, packed_bytes: u64, plain: &Path, plain_bytes: u64) -> StoreError {
    StoreError::Differs { packed: packed.to_owned(), packed_bytes, plain: plain.to_owned(), plain_bytes }
}

impl std::fmt::Debug for Packer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Packer")
            .field("plain", &self.plain)
            .field("at", &self.at)
            .finish_non_exhaustive()
    }
}
