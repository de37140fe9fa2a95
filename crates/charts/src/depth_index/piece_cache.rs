//! Pieces that lie in a file and are read when they are asked for; the last ones used are kept in memory, so many
//! bytes of them.
//!
//! A piece that cannot be read must not count as water: it is replaced by one that makes all of its box a danger of
//! unknown depth.

use super::codec::{self, IndexError, Span};
use super::index::Directory;
use super::object::{ChartObject, Role, Stored};
use super::piece::{Kind, Piece};
use super::places::{AreaEntry, Hold, Places};
use super::ring::Ring;
use super::tree::{Tree, cut};
use crate::grid::Bounds;
use crate::s57::{ObjectClass, ObjectId};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes that an index is read from, such as a file.
pub trait IndexBytes: fmt::Debug + Send + Sync {
    /// How many there are.
    fn length(&self) -> u64;

    /// So many from an offset on.
    ///
    /// # Errors
    /// Why they cannot be read.
    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String>;
}

/// Pieces in a file.
pub(super) struct PieceCache {
    pub(super) bytes: Arc<dyn IndexBytes>,
    /// Where the index begins in the bytes.
    pub(super) from: u64,
    /// From there on.
    spans: Vec<Span>,
    most_bytes: usize,
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    /// With when it was used last.
    pieces: BTreeMap<usize, (Arc<Piece>, u64)>,
    bytes: usize,
    uses: u64,
    /// By chart.
    unreadable: BTreeMap<usize, String>,
}

impl fmt::Debug for PieceCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PieceCache({:?}, {} pieces)", self.bytes, self.spans.len())
    }
}

impl PieceCache {
    pub(super) fn new(bytes: Arc<dyn IndexBytes>, from: u64, spans: Vec<Span>, most_bytes: usize) -> Self {
        Self { bytes, from, spans, most_bytes, kept: Mutex::default() }
    }

    /// Where a piece lies from the index's beginning on.
    pub(super) fn span(&self, at: usize) -> Span {
        self.spans[at]
    }

    /// A piece of the directory that the piece_cache belongs to.
    pub(super) fn piece(&self, directory: &Directory, at: usize) -> Arc<Piece> {
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = lock();
            kept.uses += 1;
            let now = kept.uses;
            if let Some((piece, used)) = kept.pieces.get_mut(&at) {
                *used = now;
                return Arc::clone(piece);
            }
        }
        // Two that need the same piece at once may both read it.
        let read = self.read(directory, at);
        let mut kept = lock();
        let piece = Arc::new(read.unwrap_or_else(|why| {
            let name = &directory.sources[at].name;
            kept.unreadable.insert(at, format!("{name}: {why}"));
            closed(name, directory.entries[at].bounds)
        }));
        kept.keep(at, &piece, &self.spans, self.most_bytes);
        piece
    }

    pub(super) fn unreadable(&self) -> Vec<String> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).unreadable.values().cloned().collect()
    }

    /// The bytes of a piece and their checksum, if they are whole.
    pub(super) fn bytes(&self, at: usize) -> Option<(Vec<u8>, u32)> {
        let span = self.spans[at];
        let bytes = self.bytes.read(self.from + span.offset, span.length as usize).ok()?;
        let whole = bytes.len() == span.length as usize && crc32fast::hash(&bytes) == span.checksum;
        whole.then_some((bytes, span.checksum))
    }

    /// A piece, read again.
    pub(super) fn read(&self, directory: &Directory, at: usize) -> Result<Piece, String> {
        let span = self.spans[at];
        let bytes = self.bytes.read(self.from + span.offset, span.length as usize)?;
        codec::piece(&bytes, span, directory, at).map_err(|error: IndexError| error.to_string())
    }
}

impl Kept {
    fn keep(&mut self, at: usize, piece: &Arc<Piece>, spans: &[Span], most_bytes: usize) {
        // In memory a piece is about as large as in the file.
        let size = |at: usize| spans[at].length as usize;
        if self.pieces.insert(at, (Arc::clone(piece), self.uses)).is_none() {
            self.bytes += size(at);
        }
        while self.bytes > most_bytes && self.pieces.len() > 1 {
            let others = self.pieces.iter().filter(|(other, _)| **other != at);
            let Some(oldest) = others.min_by_key(|(_, (_, used))| *used).map(|(other, _)| *other) else {
                return;
            };
            self.pieces.remove(&oldest);
            self.bytes -= size(oldest);
        }
    }
}

/// The substitute for a chart that cannot be read.
fn closed(name: &str, bounds: Bounds) -> Piece {
    let object = ChartObject {
        class: ObjectClass::OBSTRN,
        id: ObjectId::default(),
        record: 0,
        source: 0,
        name: Some(format!("the chart {name} cannot be read")),
        zone: None,
        stored: Stored::Unknown,
        role: Role::Danger,
        interest: false,
    };
    let mut piece =
        Piece { supplement: true, charts: vec![name.to_owned()], objects: vec![object], ..Piece::default() };
    let ([x0, y0], [x1, y1]) = (bounds.min, bounds.max);
    piece.areas.vertices = vec![[x0, y0], [x0, y1], [x1, y1], [x1, y0], [x0, y0]];
    Ring::push_boxes(&piece.areas.vertices, &mut piece.areas.boxes);
    piece.areas.rings = vec![Ring { first: 0, count: 5, boxes: 0 }];
    piece.areas.list = vec![AreaEntry { object: 0, first_ring: 0, rings: 1 }];
    piece.places = Places::build(&piece.areas, |_| 0, |_| Hold::AtAll);
    (piece.own_objects, piece.own_vertices) = (1, 5);
    piece.trees[Kind::Danger as usize] =
        Tree::build(cut(0, 0, 5).collect(), &piece.areas.vertices, |_| Stored::Unknown.least_mm());
    piece
}
