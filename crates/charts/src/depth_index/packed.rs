//! The bytes that an index has when it is built from its charts, whatever lies between its pieces in the file it is read from.
//! The same charts give the same bytes, and so the same checksum.

use super::codec::{self, Span};
use super::index::{DepthIndex, Pieces};
use super::piece_cache::IndexBytes;
use crate::grid::Bounds;
use std::sync::Arc;

/// An index to be sent or copied.
#[derive(Debug, Clone)]
pub struct PackedIndex {
    /// With where each begins, in order.
    stretches: Vec<(u64, Stretch)>,
    length: u64,
}

#[derive(Debug, Clone)]
enum Stretch {
    Made(Vec<u8>),
    Lies { bytes: Arc<dyn IndexBytes>, offset: u64, length: u32 },
}

impl Stretch {
    fn length(&self) -> u64 {
        match self {
            Self::Made(bytes) => bytes.len() as u64,
            Self::Lies { length, .. } => u64::from(*length),
        }
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        match self {
            Self::Made(bytes) => bytes.as_slice().read(offset, length),
            Self::Lies { bytes, offset: from, .. } => bytes.read(from + offset, length),
        }
    }
}

impl PackedIndex {
    /// An index behind what comes before it.
    pub(super) fn of(before: Vec<u8>, index: &DepthIndex) -> Self {
        let mut packed = Self { stretches: Vec::new(), length: 0 };
        packed.add(Stretch::Made(before));
        let Pieces::Kept(piece_cache) = &index.pieces else {
            packed.add(Stretch::Made(index.to_bytes()));
            return packed;
        };
        let entries = &index.directory.entries;
        let boxes: Vec<Bounds> = entries.iter().map(|entry| entry.bounds).collect();
        let head = codec::head();
        let mut next = head.len() as u64;
        packed.add(Stretch::Made(head));
        let mut spans = vec![Span { offset: 0, length: 0, checksum: 0 }; boxes.len()];
        for at in codec::file_order(&boxes) {
            let lies = piece_cache.span(at);
            spans[at] = Span { offset: next, ..lies };
            next += u64::from(lies.length);
            let (bytes, offset) = (Arc::clone(&piece_cache.bytes), piece_cache.from + lies.offset);
            packed.add(Stretch::Lies { bytes, offset, length: lies.length });
        }
        packed.add(Stretch::Made(codec::end(index.sources(), entries, &spans)));
        packed
    }

    fn add(&mut self, stretch: Stretch) {
        let begins = self.length;
        self.length += stretch.length();
        self.stretches.push((begins, stretch));
    }
}

impl IndexBytes for PackedIndex {
    fn length(&self) -> u64 {
        self.length
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        let end = offset.checked_add(length as u64).filter(|end| *end <= self.length);
        let end = end.ok_or("it ends before")?;
        let mut read = Vec::with_capacity(length);
        let first = self.stretches.partition_point(|(begins, stretch)| begins + stretch.length() <= offset);
        for (begins, stretch) in &self.stretches[first..] {
            let (from, to) = (offset.max(*begins), end.min(begins + stretch.length()));
            if from >= to {
                break;
            }
            read.extend(stretch.read(from - begins, (to - from) as usize)?);
        }
        Ok(read)
    }
}
