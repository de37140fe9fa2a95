//! A quadtree that finds the areas that hold a point.
//!
//! A leaf lists the areas that hold all of it, and those whose border runs through it, which are asked one by
//! one. Leaves are split until few border segments are left.

use super::coords::Spot;
use super::ring::Ring;
use crate::grid::{Bounds, Vertex};

/// A leaf with so few areas is not split, however long their borders: each is asked in logarithmic time.
const FEW_AREAS: usize = 5;
/// Segments at which a leaf is split.
const SPLIT_AT: usize = 32;
/// Segments that are moved together near the root.
const TOGETHER: u32 = 16;
/// Sides below this are not split (units; 3 m).
const SMALLEST: i64 = 256;
/// Marks an entry whose area holds the whole leaf.
pub(super) const WHOLE: u32 = 1 << 31;
/// Marks an inner node.
const INNER: u32 = u32::MAX;

/// An area: its rings and the object it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct AreaEntry {
    pub(super) object: u32,
    pub(super) first_ring: u32,
    pub(super) rings: u32,
}

/// When an area holds a point. For an area whose rings cross neither themselves nor each other both rules agree; where
/// a damaged one lies is unknown, and each rule errs on the side of danger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hold {
    /// Where it lies round the point once, as an exterior does: for water that is deep.
    Plainly,
    /// Where it lies round the point in any way: for all else.
    AtAll,
}

/// The geometry that areas share.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Areas {
    pub(super) vertices: Vec<Vertex>,
    pub(super) rings: Vec<Ring>,
    pub(super) boxes: Vec<Bounds>,
    pub(super) list: Vec<AreaEntry>,
}

impl Areas {
    pub(super) fn rings_of(&self, area: AreaEntry) -> &[Ring] {
        &self.rings[area.first_ring as usize..(area.first_ring + area.rings) as usize]
    }

    fn border(&self, area: u32, vertex: u32, count: u32) -> Border {
        let bounds = Bounds::of(&self.vertices[vertex as usize..=(vertex + count) as usize]);
        Border { area, vertex, count, bounds }
    }

    /// Whether an area holds a point. Exteriors run clockwise and holes anticlockwise ([`Hold`]).
    pub(super) fn contains(&self, area: u32, hold: Hold, at: Spot) -> bool {
        let rings = self.rings_of(self.list[area as usize]);
        let turns: i32 = rings.iter().map(|ring| ring.turns(&self.vertices, &self.boxes, at)).sum();
        match hold {
            Hold::Plainly => turns < 0 && turns & 1 == 1,
            Hold::AtAll => turns != 0,
        }
    }
}

/// A node: inner with its first of four children, or a leaf with its entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quad {
    /// First child, or first entry.
    pub(super) first: u32,
    /// [`INNER`], or the number of entries.
    pub(super) count: u32,
}

impl Quad {
    pub(super) fn is_inner(self) -> bool {
        self.count == INNER
    }
}

/// The quadtree.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Places {
    pub(super) corner: Vertex,
    /// A power of two.
    pub(super) side: i64,
    pub(super) nodes: Vec<Quad>,
    pub(super) entries: Vec<u32>,
}

/// Consecutive segments of an area's border. Near the root they are moved by the dozen, near the leaves singly.
#[derive(Clone, Copy)]
struct Border {
    area: u32,
    /// Its first vertex.
    vertex: u32,
    /// Segments.
    count: u32,
    bounds: Bounds,
}

struct Build<'a, K, H> {
    areas: &'a Areas,
    /// When an area holds a point.
    hold: H,
    /// The order of entries within a leaf.
    key: K,
    places: Places,
    /// Nodes that may still be made: parallel borders closer than a leaf would split for ever.
    budget: usize,
}

impl Places {
    /// Builds the tree; `key` gives the order in which areas of a leaf are looked at, `hold` when an area holds a point.
    pub(super) fn build<O: Ord>(areas: &Areas, key: impl Fn(u32) -> O, hold: impl Fn(u32) -> Hold) -> Self {
        let mut borders = Vec::with_capacity(areas.vertices.len() / TOGETHER as usize + areas.rings.len());
        let mut whole = Bounds::EMPTY;
        for (area, entry) in areas.list.iter().enumerate() {
            for ring in areas.rings_of(*entry) {
                whole.add(Bounds::of(ring.vertices(&areas.vertices)));
                let (first, end) = (ring.first, ring.first + ring.segments() as u32);
                borders.extend((first..end).step_by(TOGETHER as usize).map(|vertex| {
                    let count = TOGETHER.min(end - vertex);
                    areas.border(area as u32, vertex, count)
                }));
            }
        }
        if borders.is_empty() {
            return Self::default();
        }
        let span = |axis: usize| i64::from(whole.max[axis]) - i64::from(whole.min[axis]) + 1;
        let side = (span(0).max(span(1)) as u64).next_power_of_two() as i64;
        let places =
            Self { corner: whole.min, side, nodes: vec![Quad { first: 0, count: 0 }], entries: Vec::new() };
        let budget = areas.vertices.len() * 2 + 1000;
        let mut build = Build { areas, hold, key, places, budget };
        let corner = [i64::from(whole.min[0]), i64::from(whole.min[1])];
        build.fill(0, corner, side, &borders, Vec::new());
        build.places
    }

    /// The entries of the leaf that holds a point, whose longitude is within ±180°.
    pub(super) fn leaf(&self, at: Spot) -> &[u32] {
        if self.nodes.is_empty() {
            return &[];
        }
        let (dx, dy) =
            ((at.x - f64::from(self.corner[0])).floor(), (at.y - f64::from(self.corner[1])).floor());
        let side = self.side as f64;
        if !(dx >= 0.0 && dy >= 0.0 && dx < side && dy < side) {
            return &[];
        }
        // Within 0 and the side, which is at most 2^32.
        let (dx, dy) = (dx as u64, dy as u64);
        let mut node = self.nodes[0];
        let mut bit = self.side as u64 >> 1;
        while node.is_inner() {
            let child = u32::from(dx & bit != 0) + 2 * u32::from(dy & bit != 0);
            node = self.nodes[(node.first + child) as usize];
            bit >>= 1;
        }
        &self.entries[node.first as usize..(node.first + node.count) as usize]
    }
}

impl<O: Ord, K: Fn(u32) -> O, H: Fn(u32) -> Hold> Build<'_, K, H> {
    fn fill(&mut self, node: usize, corner: [i64; 2], side: i64, borders: &[Border], whole: Vec<u32>) {
        let few = borders.len() <= SPLIT_AT;
        let present = areas_of(borders);
        if present.len() <= FEW_AREAS {
            self.leaf(node, borders, whole);
            return;
        }
        if few && borders.iter().any(|border| border.count > 1) {
            let single = |border: &Border| {
                let Border { area, vertex, count, .. } = *border;
                (vertex..vertex + count).map(move |vertex| (area, vertex))
            };
            let singles =
                borders.iter().flat_map(single).map(|(area, vertex)| self.areas.border(area, vertex, 1));
            let singles: Vec<Border> = singles.filter(|border| self.crosses(border, corner, side)).collect();
            let whole = self.settle(&present, &singles, corner, side, whole);
            self.fill(node, corner, side, &singles, whole);
            return;
        }
        if few || side <= SMALLEST || self.budget < 4 {
            self.leaf(node, borders, whole);
            return;
        }
        self.budget -= 4;
        let first = self.places.nodes.len();
        self.places.nodes[node] = Quad { first: first as u32, count: INNER };
        self.places.nodes.extend([Quad { first: 0, count: 0 }; 4]);
        let half = side / 2;
        for child in 0..4 {
            let low = [corner[0] + (child & 1) * half, corner[1] + (child >> 1) * half];
            let inside: Vec<Border> =
                borders.iter().filter(|border| self.crosses(border, low, half)).copied().collect();
            let whole = self.settle(&present, &inside, low, half, whole.clone());
            self.fill(first + child as usize, low, half, &inside, whole);
        }
    }

    /// Adds to `whole` the areas whose border was present before and is not among `borders`, and that hold the
    /// square.
    fn settle(
        &self,
        present: &[u32],
        borders: &[Border],
        low: [i64; 2],
        side: i64,
        mut whole: Vec<u32>,
    ) -> Vec<u32> {
        let here = areas_of(borders);
        // Off the grid of vertices; no border that is gone crosses the square, so any point of it will do.
        let middle = Spot { x: (low[0] + side / 2) as f64 + 0.5, y: (low[1] + side / 2) as f64 + 0.5 };
        let gone = present.iter().copied().filter(|area| here.binary_search(area).is_err());
        whole.extend(gone.filter(|area| self.areas.contains(*area, (self.hold)(*area), middle)));
        whole
    }

    fn leaf(&mut self, node: usize, borders: &[Border], whole: Vec<u32>) {
        let mut areas = areas_of(borders);
        areas.extend(whole.into_iter().map(|area| area | WHOLE));
        areas.sort_by_key(|entry| ((self.key)(entry & !WHOLE), *entry));
        let first = self.places.entries.len() as u32;
        self.places.nodes[node] = Quad { first, count: areas.len() as u32 };
        self.places.entries.extend(areas);
    }

    /// Whether a segment may run through a square; it may err towards yes, never towards no.
    fn crosses(&self, border: &Border, low: [i64; 2], side: i64) -> bool {
        let Bounds { min, max } = border.bounds;
        let apart =
            (0..2).any(|axis| i64::from(min[axis]) > low[axis] + side || i64::from(max[axis]) < low[axis]);
        if apart || border.count > 1 {
            return !apart;
        }
        let vertex = border.vertex as usize;
        let (a, b) = (self.areas.vertices[vertex], self.areas.vertices[vertex + 1]);
        // Separated by the segment's line: the middle lies farther from it than the square reaches. 4096 covers
        // the rounding of products up to 2^64.
        let (dx, dy) = (f64::from(b[0]) - f64::from(a[0]), f64::from(b[1]) - f64::from(a[1]));
        let half = side as f64 / 2.0;
        let (cx, cy) = (low[0] as f64 + half - f64::from(a[0]), low[1] as f64 + half - f64::from(a[1]));
        (dx * cy - dy * cx).abs() <= half * (dx.abs() + dy.abs()) + 4096.0
    }
}

/// The areas that borders belong to, each once, in order.
fn areas_of(borders: &[Border]) -> Vec<u32> {
    let mut areas: Vec<u32> = borders.iter().map(|border| border.area).collect();
    areas.dedup();
    areas.sort_unstable();
    areas.dedup();
    areas
}
