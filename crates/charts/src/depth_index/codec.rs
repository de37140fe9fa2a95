//! An index as bytes: written once ashore, opened in a moment aboard.
//!
//! Layout, all little-endian: the magic `LUTRADIX`, version (u32), the pieces one after another, the directory, and at
//! the end how long the directory is (u32) and its checksum (CRC-32). Tables are their length (u32) and their rows. The
//! directory has for each chart where its piece lies and the checksum of it. Reading checks every number against the
//! table that it points into, so that damaged bytes are refused and never lead out of bounds. Pieces stand in the order
//! of where their charts lie ([`file_order`]), so that neighbours are read together.

use super::index::{DepthIndex, Directory, Entry, Pieces, tree_of_boxes};
use super::piece::Piece;
use super::piece_cache::{IndexBytes, PieceCache};
use super::rows::{Reader, Writer};
use super::sound::is_sound;
use crate::coverage::Source;
use crate::grid::Bounds;
use std::sync::Arc;

const MAGIC: &[u8; 8] = b"LUTRADIX";
/// Raised whenever the layout changes, or the rules by which an index is made of charts: one by older rules may call
/// safe what is not, so it is made again.
const VERSION: u32 = 5;
const HEAD_BYTES: usize = 12;
/// The end after the directory.
const END_BYTES: usize = 8;
/// A directory longer than this is refused: a chart takes some 200 bytes.
const MOST_DIRECTORY: usize = 64 << 20;

/// Where a piece lies, and its checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) offset: u64,
    pub(super) length: u32,
    pub(super) checksum: u32,
}

/// The order in which pieces are written, of charts with these boxes.
pub(super) fn file_order(boxes: &[Bounds]) -> Vec<usize> {
    let mut order: Vec<usize> = tree_of_boxes(boxes).runs.iter().map(|run| run.object as usize).collect();
    order.extend((0..boxes.len()).filter(|at| boxes[*at].min[0] > boxes[*at].max[0]));
    order
}

/// The magic of an index.
pub(super) fn head() -> Vec<u8> {
    [MAGIC.as_slice(), &VERSION.to_le_bytes()].concat()
}

/// A piece as bytes.
pub(super) fn piece_bytes(piece: &Piece) -> Vec<u8> {
    let mut out = Writer(Vec::with_capacity(piece.areas.vertices.len() * 16 + 4096));
    out.piece(piece);
    out.0
}

/// The trailer of an index.
pub(super) fn end(sources: &[Source], entries: &[Entry], spans: &[Span]) -> Vec<u8> {
    let mut out = Writer(Vec::new());
    let rows: Vec<_> = sources.iter().zip(entries).zip(spans).collect();
    out.list(&rows, |out, ((source, entry), span)| {
        out.source(source);
        out.entry(entry);
        out.0.extend(span.offset.to_le_bytes());
        out.u32s(&[span.length, span.checksum]);
    });
    let tail = [out.0.len() as u32, crc32fast::hash(&out.0)];
    out.u32s(&tail);
    out.0
}

/// The piece of a chart of the directory.
///
/// # Errors
/// When it is damaged.
pub(super) fn piece(bytes: &[u8], span: Span, directory: &Directory, at: usize) -> Result<Piece, IndexError> {
    let damaged = |here: usize| IndexError::Damaged(span.offset as usize + here);
    if bytes.len() != span.length as usize || crc32fast::hash(bytes) != span.checksum {
        return Err(damaged(0));
    }
    checked_piece(bytes, directory, at).ok_or(damaged(0))
}

/// A piece of bytes whose checksum is right.
fn checked_piece(bytes: &[u8], directory: &Directory, at: usize) -> Option<Piece> {
    let mut reader = Reader { bytes, at: 0 };
    let mut piece = reader.piece()?;
    piece.supplement = directory.sources[at].supplement;
    let entry = &directory.entries[at];
    let listed = piece.objects.len() == entry.objects as usize && piece.own_vertices == entry.vertices;
    let whole = reader.at == bytes.len() && listed && is_sound(&piece);
    // Questions open no piece whose box is elsewhere.
    let placed = whole
        && entry.bounds.contains(&piece.bounds())
        && Entry::of(entry.mark, entry.bounds, &piece) == *entry;
    placed.then_some(piece)
}

/// Why bytes are not an index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum IndexError {
    /// Something else.
    #[error("these bytes are not a depth index; build one from the charts")]
    Magic,
    /// Of another version of Lutra.
    #[error("the depth index has version {0}, this program reads version {VERSION}; build it again")]
    Version(u32),
    /// Changed on the way.
    #[error("the depth index is damaged at byte {0}; copy or build it again")]
    Damaged(usize),
}

impl DepthIndex {
    /// The index as bytes: the same index gives the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let entries = &self.directory.entries;
        let boxes: Vec<Bounds> = entries.iter().map(|entry| entry.bounds).collect();
        let mut bytes = head();
        let mut spans = vec![Span { offset: 0, length: 0, checksum: 0 }; boxes.len()];
        for at in file_order(&boxes) {
            let piece = piece_bytes(&self.piece(at));
            spans[at] = Span {
                offset: bytes.len() as u64,
                length: piece.len() as u32,
                checksum: crc32fast::hash(&piece),
            };
            bytes.extend(piece);
        }
        bytes.extend(end(self.sources(), entries, &spans));
        bytes
    }

    /// The index of some bytes, all of it in memory.
    ///
    /// # Errors
    /// When they are not an index, of another version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IndexError> {
        let (directory, spans) = read_directory(&bytes, 0)?;
        let mut order: Vec<usize> = (0..spans.len()).collect();
        order.sort_by_key(|at| spans[*at].offset);
        // Nothing lies between the pieces.
        let mut next = HEAD_BYTES as u64;
        let mut pieces = vec![Arc::default(); spans.len()];
        for at in order {
            let span = spans[at];
            let damaged = IndexError::Damaged(span.offset as usize);
            let range = span.offset as usize..(span.offset + u64::from(span.length)) as usize;
            let found = bytes.get(range).filter(|_| span.offset == next).ok_or(damaged)?;
            pieces[at] = Arc::new(piece(found, span, &directory, at)?);
            next += u64::from(span.length);
        }
        if next != directory_at(&bytes, 0)?.0 {
            return Err(IndexError::Damaged(next as usize));
        }
        Ok(Self { directory: Arc::new(directory), pieces: Pieces::Held(pieces) })
    }

    /// The index that lies from an offset on, of which pieces are read when they are asked for and at most so many bytes
    /// of them kept.
    ///
    /// # Errors
    /// When there is no index, one of another version, or its directory is damaged.
    pub fn open(bytes: Arc<dyn IndexBytes>, from: u64, most_bytes: usize) -> Result<Self, IndexError> {
        let (directory, spans) = read_directory(&*bytes, from)?;
        let piece_cache = PieceCache::new(bytes, from, spans, most_bytes);
        Ok(Self { directory: Arc::new(directory), pieces: Pieces::Kept(Arc::new(piece_cache)) })
    }
}

impl IndexBytes for &[u8] {
    fn length(&self) -> u64 {
        self.len() as u64
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        let from = usize::try_from(offset).ok();
        let range = from.and_then(|from| Some(from..from.checked_add(length)?));
        let found = range.and_then(|range| self.get(range));
        found.map(<[u8]>::to_vec).ok_or_else(|| "it ends before".to_owned())
    }
}

/// Where the directory lies from the index's beginning on, and its checksum.
fn directory_at(bytes: &dyn IndexBytes, from: u64) -> Result<(u64, usize, u32), IndexError> {
    let length = bytes.length().saturating_sub(from);
    if length < (HEAD_BYTES + END_BYTES) as u64 {
        return Err(IndexError::Magic);
    }
    let get = |offset: u64, length: usize| {
        bytes.read(from + offset, length).map_err(|_| IndexError::Damaged(offset as usize))
    };
    let head = get(0, HEAD_BYTES)?;
    if !head.starts_with(MAGIC) {
        return Err(IndexError::Magic);
    }
    let number = |bytes: &[u8]| bytes.try_into().map_or(0, u32::from_le_bytes);
    let version = number(&head[MAGIC.len()..]);
    if version != VERSION {
        return Err(IndexError::Version(version));
    }
    let end = length - END_BYTES as u64;
    let tail = get(end, END_BYTES)?;
    let size = number(&tail[..4]) as usize;
    let most = (end - HEAD_BYTES as u64).min(MOST_DIRECTORY as u64);
    if size as u64 > most {
        return Err(IndexError::Damaged(end as usize));
    }
    Ok((end - size as u64, size, number(&tail[4..])))
}

fn read_directory(bytes: &dyn IndexBytes, from: u64) -> Result<(Directory, Vec<Span>), IndexError> {
    let (offset, size, checksum) = directory_at(bytes, from)?;
    let damaged = IndexError::Damaged(offset as usize);
    let rows = bytes.read(from + offset, size).map_err(|_| damaged)?;
    if crc32fast::hash(&rows) != checksum {
        return Err(damaged);
    }
    let mut reader = Reader { bytes: &rows, at: 0 };
    let row = |reader: &mut Reader<'_>| {
        let (source, entry) = (reader.source()?, reader.entry()?);
        let place = u64::from_le_bytes(reader.array()?);
        let span = Span { offset: place, length: reader.u32()?, checksum: reader.u32()? };
        let within = place.checked_add(u64::from(span.length)).is_some_and(|end| end <= offset);
        within.then_some(((source, entry), span))
    };
    let rows = reader.list(100, row).filter(|_| reader.at == size).ok_or(damaged)?;
    let (charts, spans) = rows.into_iter().unzip();
    Ok((Directory::new(charts), spans))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth_index::{Demand, IndexBuilder, Leg};
    use crate::s57::{Area, GeoPoint, Path, Sounding};
    use proptest::prelude::*;
    use units::LatLon;

    fn small() -> DepthIndex {
        let mut builder = IndexBuilder::new();
        let points = [(10.0, 63.0), (10.0, 63.1), (10.2, 63.1), (10.2, 63.0), (10.0, 63.0)];
        let points = points.map(|(lon_deg, lat_deg)| GeoPoint { lon_deg, lat_deg }).to_vec();
        let path = Path { points, edges: Vec::new() };
        builder.add_land("land", &[Area { exteriors: vec![path], holes: Vec::new() }]).unwrap();
        let at = GeoPoint { lon_deg: 9.9, lat_deg: 63.0 };
        builder.add_soundings("survey", &[Sounding { at, depth_m: 2.3 }]).unwrap();
        builder.build().unwrap()
    }

    #[test]
    fn bytes_lead_back_to_the_same_index() {
        let index = small();
        let bytes = index.to_bytes();
        let back = DepthIndex::from_bytes(&bytes).unwrap();
        assert_eq!(back, index);
        assert_eq!(back.to_bytes(), bytes);
    }

    #[test]
    fn every_changed_byte_is_noticed() {
        let bytes = small().to_bytes();
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            assert!(DepthIndex::from_bytes(&changed).is_err(), "byte {at}");
            assert!(DepthIndex::from_bytes(&bytes[..at]).is_err(), "cut at {at}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn damage_with_a_right_checksum_never_leads_out_of_bounds(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        ) {
            let whole = small();
            let mut pieces: Vec<Vec<u8>> = (0..2).map(|at| piece_bytes(&whole.piece(at))).collect();
            for (at, value) in changes {
                let bytes = &mut pieces[at.index(2)];
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let read = |at: usize| {
                let piece = Arc::new(checked_piece(&pieces[at], &whole.directory, at)?);
                let (source, entry) = (&whole.directory.sources[at], &whole.directory.entries[at]);
                Some((source.clone(), entry.clone(), piece))
            };
            if let Some(charts) = (0..2).map(read).collect() {
                let index = DepthIndex::held(charts);
                let from = LatLon::from_deg(63.05, 10.1).unwrap();
                let leg = Leg { from, to: LatLon::from_deg(63.05, 9.9).unwrap() };
                index.shallowest_along(leg, 20.0, &Demand::default());
                index.distance_to_shallower(from, 3.0, 1000.0);
            }
        }
    }
}
