//! The index itself: a directory of charts, and their pieces, in memory or on a [`PieceCache`].

use super::codec::{self, Span};
use super::coords::Spot;
use super::object::{ChartObject, Role, State, Stored};
use super::piece::{Kind, Piece};
use super::piece_cache::PieceCache;
use super::restricted::Restriction;
use super::tree::{Node, Run, Tree};
use crate::coverage::{ChartCoverage, Coverage, Source};
use crate::grid::{Bounds, Vertex};
use crate::s57::ObjectClass;
use std::sync::Arc;

/// An index over charts; cheap to clone.
#[derive(Debug, Clone, Default)]
pub struct DepthIndex {
    pub(super) directory: Arc<Directory>,
    pub(super) pieces: Pieces,
}

/// What is known of all charts, the best first.
#[derive(Debug, PartialEq, Default)]
pub(super) struct Directory {
    pub(super) sources: Vec<Source>,
    pub(super) entries: Vec<Entry>,
    /// Number of the first object of each chart.
    first_objects: Vec<u32>,
    /// Their boxes; the objects of its runs are numbers of charts.
    boxes: Tree,
}

/// What is known of a chart without its piece.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    /// Digest of the chart's contents, for the maker of the index.
    pub(super) mark: [u8; 32],
    /// Holds all that is its own.
    pub(super) bounds: Bounds,
    /// Its tree of dangers.
    pub(super) danger: Bounds,
    /// Its waters, if their survey quality is not stated.
    pub(super) unassessed: Option<Bounds>,
    pub(super) worst_zone: Option<u8>,
    pub(super) objects: u32,
    pub(super) vertices: u32,
}

impl Entry {
    /// Of a chart whose box is `bounds` or within it.
    pub(super) fn of(mark: [u8; 32], bounds: Bounds, piece: &Piece) -> Self {
        Self {
            mark,
            bounds,
            danger: piece.tree(Kind::Danger).bounds(),
            unassessed: piece.unassessed(),
            worst_zone: piece.worst_zone(),
            objects: piece.objects.len() as u32,
            vertices: piece.own_vertices,
        }
    }
}

#[derive(Debug, Clone)]
pub(super) enum Pieces {
    Held(Vec<Arc<Piece>>),
    Kept(Arc<PieceCache>),
}

impl Default for Pieces {
    fn default() -> Self {
        Self::Held(Vec::new())
    }
}

impl PartialEq for DepthIndex {
    /// Whether they are of the same charts with the same contents, whatever they were marked by. Reads all of it.
    fn eq(&self, other: &Self) -> bool {
        self.sources() == other.sources()
            && (0..self.sources().len()).all(|at| self.piece(at) == other.piece(at))
    }
}

impl Directory {
    pub(super) fn new(charts: Vec<(Source, Entry)>) -> Self {
        let (sources, entries): (Vec<Source>, Vec<Entry>) = charts.into_iter().unzip();
        let first_of_next = |next: &mut u32, entry: &Entry| {
            let first = *next;
            *next = first.saturating_add(entry.objects);
            Some(first)
        };
        let first_objects = entries.iter().scan(0, first_of_next).collect();
        let boxes: Vec<Bounds> = entries.iter().map(|entry| entry.bounds).collect();
        Self { sources, entries, first_objects, boxes: tree_of_boxes(&boxes) }
    }
}

/// A tree over boxes, whose runs have the numbers of the boxes as objects. Empty ones are left out.
pub(super) fn tree_of_boxes(boxes: &[Bounds]) -> Tree {
    let corners: Vec<Vertex> = boxes.iter().flat_map(|bounds| [bounds.min, bounds.max]).collect();
    let filled = boxes.iter().zip(0..).filter(|(bounds, _)| bounds.min[0] <= bounds.max[0]);
    let runs = filled.map(|(_, at)| Run { first: 2 * at, count: 2, object: at }).collect();
    Tree::build(runs, &corners, |_| 0)
}

impl DepthIndex {
    /// Of charts in memory, the best first.
    pub(super) fn held(charts: Vec<(Source, Entry, Arc<Piece>)>) -> Self {
        let mut pieces = Vec::with_capacity(charts.len());
        let mut listed = Vec::with_capacity(charts.len());
        for (source, entry, piece) in charts {
            listed.push((source, entry));
            pieces.push(piece);
        }
        Self { directory: Arc::new(Directory::new(listed)), pieces: Pieces::Held(pieces) }
    }

    /// Sources, the best first.
    pub fn sources(&self) -> &[Source] {
        &self.directory.sources
    }

    /// What it holds, in a line for people.
    pub fn edition(&self) -> String {
        match self.sources() {
            [] => "no charts".to_owned(),
            [one] => one.edition_text(),
            all => {
                let newest = all.iter().max_by_key(|source| (&source.issue_date, &source.name));
                let newest = newest.map(Source::edition_text).unwrap_or_default();
                format!("{} charts, the newest {newest}", all.len())
            }
        }
    }

    /// Which chart covers what, for callers that need regions rather than depths. Reads all charts.
    pub fn coverage(&self) -> Coverage {
        let chart = |(at, source): (usize, &Source)| {
            let piece = self.piece(at);
            let mut chart = ChartCoverage { source: source.clone(), ..Default::default() };
            for area in &piece.areas.list {
                let object = &piece.objects[area.object as usize];
                if object.role == Role::Coverage && !source.supplement {
                    let rings = piece.areas.rings_of(*area).iter();
                    chart
                        .areas
                        .push(rings.map(|ring| ring.vertices(&piece.areas.vertices).to_vec()).collect());
                    chart.by_skin = object.class != ObjectClass::M_COVR;
                }
            }
            chart
        };
        Coverage::new(self.sources().iter().enumerate().map(chart).collect())
    }

    /// The source of an object.
    pub fn source(&self, object: &ChartObject) -> &Source {
        &self.sources()[object.source as usize]
    }

    /// An object of an answer.
    pub fn object(&self, object: u32) -> Option<ChartObject> {
        let at = self.directory.first_objects.partition_point(|first| *first <= object).checked_sub(1)?;
        let piece = self.piece(at);
        let found = piece.object(object - self.directory.first_objects[at])?;
        let chart = &piece.charts[found.source as usize];
        let named = || self.sources().iter().position(|source| source.name == *chart);
        let source = if found.source == 0 { at } else { named().unwrap_or(at) };
        Some(ChartObject { source: source as u32, ..found.clone() })
    }

    /// Number of vertices, for telling how large a chart set is.
    pub fn vertex_count(&self) -> usize {
        self.directory.entries.iter().map(|entry| entry.vertices as usize).sum()
    }

    /// Charts that could not be read when they were needed, and why. Their boxes count as danger of unknown depth.
    pub fn unreadable(&self) -> Vec<String> {
        match &self.pieces {
            Pieces::Held(_) => Vec::new(),
            Pieces::Kept(piece_cache) => piece_cache.unreadable(),
        }
    }

    pub(super) fn piece(&self, at: usize) -> Arc<Piece> {
        match &self.pieces {
            Pieces::Held(pieces) => Arc::clone(&pieces[at]),
            Pieces::Kept(piece_cache) => piece_cache.piece(&self.directory, at),
        }
    }

    /// A piece, but none where it cannot be read.
    pub(super) fn sound_piece(&self, at: usize) -> Option<Arc<Piece>> {
        match &self.pieces {
            Pieces::Held(pieces) => Some(Arc::clone(&pieces[at])),
            Pieces::Kept(piece_cache) => piece_cache.read(&self.directory, at).ok().map(Arc::new),
        }
    }

    /// Where a piece lies from the index's beginning on; `None` where it lies in no file.
    pub(super) fn span(&self, at: usize) -> Option<Span> {
        match &self.pieces {
            Pieces::Held(_) => None,
            Pieces::Kept(piece_cache) => Some(piece_cache.span(at)),
        }
    }

    /// A piece as bytes with their checksum, but none where it cannot be read.
    pub(super) fn piece_bytes(&self, at: usize) -> Option<(Vec<u8>, u32)> {
        match &self.pieces {
            Pieces::Held(pieces) => {
                let bytes = codec::piece_bytes(&pieces[at]);
                let checksum = crc32fast::hash(&bytes);
                Some((bytes, checksum))
            }
            Pieces::Kept(piece_cache) => piece_cache.bytes(at),
        }
    }

    /// The number that an object of a piece has in answers.
    pub(super) fn number(&self, at: usize, object: u32) -> u32 {
        self.directory.first_objects[at].saturating_add(object)
    }

    /// The charts whose boxes are accepted, the best first.
    pub(super) fn charts_in(&self, accept: impl Fn(&Node) -> bool) -> Vec<usize> {
        let mut found = Vec::new();
        self.directory.boxes.search(accept, |run| found.push(run.object as usize));
        found.sort_unstable();
        found
    }

    /// Visits the objects of supplements and of the best source whose areas hold a point, with their numbers.
    fn visit_at(&self, at: Spot, mut visit: impl FnMut(u32, &ChartObject)) {
        // ±180° is one meridian; areas are asked on the side on which they are written.
        let at = at.wrapped();
        for chart in self.charts_in(|node| node.bounds.holds(at)) {
            let piece = self.piece(chart);
            if piece.visit_at(at, |object, one| visit(self.number(chart, object), one)) {
                return;
            }
        }
    }

    /// The deciding state at a point and, where a border may run through it, just beside it.
    ///
    /// Vertices are whole units, so only places with a whole number of units can lie on a border other than by chance of
    /// the last bit; half a unit (6 mm) to each side is on both sides of any border through them.
    pub(super) fn worst_at(&self, at: Spot) -> State {
        let beside =
            |value: f64| if (value - value.round()).abs() < 1e-3 { &[-0.5, 0.5][..] } else { &[0.0][..] };
        let (xs, ys) = (beside(at.x), beside(at.y));
        let mut state = self.state_at(at);
        if xs.len() * ys.len() == 1 {
            return state;
        }
        for (dx, dy) in xs.iter().flat_map(|dx| ys.iter().map(move |dy| (dx, dy))) {
            state.meet(&self.state_at(Spot { x: at.x + dx, y: at.y + dy }));
        }
        state
    }

    /// The deciding state at a point, with its object, and the worst zone of confidence there.
    pub(super) fn state_at(&self, at: Spot) -> State {
        let mut state =
            State { stored: Stored::NoData, object: None, zone: None, overhead: None, areas: [None; 2] };
        let mut skin = false;
        let mut worst = i32::MAX;
        self.visit_at(at, |id, object| match object.role {
            Role::Skin | Role::Danger => {
                skin |= object.role == Role::Skin;
                let least = object.stored.least_mm();
                if least < worst {
                    worst = least;
                    (state.stored, state.object) = (object.stored, Some(id));
                }
            }
            Role::Quality => state.zone = state.zone.max(object.zone),
            Role::Overhead => state.pass_under(object.stored, id),
            Role::Coverage | Role::Interest => {}
            Role::Prohibited => state.enter(Restriction::EntryProhibited, id),
            Role::Restricted => state.enter(Restriction::EntryRestricted, id),
        });
        // A place that is covered, but by no depth area, is not charted, unless something worse is there.
        if !skin && worst > Stored::NoData.least_mm() {
            (state.stored, state.object) = (Stored::NoData, None);
        }
        state
    }
}
