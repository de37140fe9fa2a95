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
}

struct Checking {
    packed: Packed,
    hash: Sha256,
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
        let mut begin = || -> io::Result<Writing> {
            let file = File::create(part)?;
            disk.append(&file, &[0; HEAD_BYTES])?;
            let mut compressor = zstd::bulk::Compressor::new(LEVEL)?;
            compressor.include_checksum(true)?;
            Ok(Writing { file, compressor, hash: Sha256::new(), frames: Vec::new() })
        };
        let stage = Stage::Writing(Box::new(begin().named(part)?));
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

    /// Begins to hold `packed`, which an earlier run left beside `plain`, against it.
    pub(crate) fn check(plain: &Path, packed: &Path, coding: Coding) -> Result<Self> {
        let source = File::open(plain).named(plain)?;
        let plain_bytes = source.metadata().named(plain)?.len();
        let (plain, part) = (plain.to_owned(), packed.to_owned());
        let stage = Stage::Checking(Box::new(Checking { packed: Packed::open(&part)?, hash: Sha256::new() }));
        Ok(Self { plain, part, source, plain_bytes, coding, frame_bytes: FRAME_BYTES, stage, at: 0 })
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
        while self.at < self.plain_bytes && self.at < enough {
            let count = (self.plain_bytes - self.at).min(self.frame_bytes.into()) as usize;
            let stretch = &mut stretch[..count];
            self.source.read_exact_at(stretch, self.at).named(&self.plain)?;
            match &mut self.stage {
                Stage::Writing(writing) => writing.frame(stretch, self.coding, disk).named(&self.part)?,
                Stage::Checking(checking) => checking.frame(stretch, self.at, &self.part, &self.plain)?,
                Stage::Done { .. } => {}
            }
            self.at += count as u64;
        }
        if self.at < self.plain_bytes {
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
                let packed = Packed::open(&self.part)?;
                self.stage = Stage::Checking(Box::new(Checking { packed, hash: Sha256::new() }));
                self.at = 0;
                Ok(Turn::Written)
            }
            Stage::Checking(checking) => {
                let sha256: [u8; 32] = checking.hash.clone().finalize().into();
                let same = checking.packed.plain_bytes() == self.plain_bytes
                    && checking.packed.plain_sha256() == sha256;
                let end = self.source.metadata().named(&self.plain)?.len();
                if !same || end != self.plain_bytes {
                    return Err(differs(&self.part, &self.plain));
                }
                let packed_bytes = fs::metadata(&self.part).named(&self.part)?.len();
                self.stage = Stage::Done { packed_bytes };
                Ok(Turn::Done)
            }
            Stage::Done { .. } => Ok(Turn::Done),
        }
    }
}

impl Writing {
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
        self.frames.push((packed.len() as u32, unpacked.len() as u32));
        Ok(())
    }
}

impl Checking {
    fn frame(&mut self, plain: &[u8], at: u64, part: &Path, of: &Path) -> Result<()> {
        let mut done = 0;
        while done < plain.len() {
            let from = self.packed.plain_from(at + done as u64).named(part)?;
            let count = from.len().min(plain.len() - done);
            if count == 0 || from[..count] != plain[done..done + count] {
                return Err(differs(part, of));
            }
            self.hash.update(&from[..count]);
            done += count;
        }
        Ok(())
    }
}

fn differs(packed: &Path, plain: &Path) -> StoreError {
    StoreError::Differs { packed: packed.to_owned(), plain: plain.to_owned() }
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
