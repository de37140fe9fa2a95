//! The rows of an index as bytes: how charts, objects, lines and trees are written and read back.
//!
//! All numbers are little-endian; a list is its length (u32) and its rows, a text its length and its UTF-8. What is read
//! is whole, and not yet sound: [`is_sound`](super::sound::is_sound) says whether it leads anywhere it must not.

use super::index::Entry;
use super::object::{ChartObject, Role, Stored};
use super::piece::{Line, Piece};
use super::places::{AreaEntry, Areas, Places, Quad};
use super::ring::Ring;
use super::tree::{Node, Run, Tree};
use crate::coverage::Source;
use crate::grid::{Bounds, Vertex};
use crate::s57::{ObjectClass, ObjectId};

/// Bytes that grow row by row.
pub(super) struct Writer(pub(super) Vec<u8>);

impl Writer {
    pub(super) fn list<T>(&mut self, items: &[T], mut write: impl FnMut(&mut Self, &T)) {
        // Tables are indexed by u32.
        self.u32s(&[items.len() as u32]);
        for item in items {
            write(self, item);
        }
    }

    pub(super) fn u32s(&mut self, values: &[u32]) {
        for value in values {
            self.0.extend(value.to_le_bytes());
        }
    }

    pub(super) fn i32(&mut self, value: i32) {
        self.0.extend(value.to_le_bytes());
    }

    pub(super) fn vertex(&mut self, vertex: Vertex) {
        for value in vertex {
            self.i32(value);
        }
    }

    pub(super) fn bounds(&mut self, bounds: &Bounds) {
        self.vertex(bounds.min);
        self.vertex(bounds.max);
    }

    pub(super) fn text(&mut self, text: &str) {
        self.list(text.as_bytes(), |out, byte| out.0.push(*byte));
    }

    pub(super) fn piece(&mut self, piece: &Piece) {
        self.list(&piece.charts, |out, name| out.text(name));
        self.list(&piece.objects, Self::object);
        self.u32s(&[piece.own_objects, piece.own_vertices]);
        self.list(&piece.lines, |out, line| out.u32s(&[line.object, line.first, line.count]));
        self.list(&piece.areas.vertices, |out, vertex| out.vertex(*vertex));
        self.list(&piece.areas.rings, |out, ring| out.u32s(&[ring.first, ring.count, ring.boxes]));
        self.list(&piece.areas.boxes, Self::bounds);
        self.list(&piece.areas.list, |out, area| out.u32s(&[area.object, area.first_ring, area.rings]));
        self.vertex(piece.places.corner);
        self.0.extend(piece.places.side.to_le_bytes());
        self.list(&piece.places.nodes, |out, node| out.u32s(&[node.first, node.count]));
        self.list(&piece.places.entries, |out, entry| out.u32s(&[*entry]));
        for tree in &piece.trees {
            self.list(&tree.runs, |out, run| out.u32s(&[run.first, run.count, run.object]));
            self.list(&tree.nodes, |out, node| {
                out.bounds(&node.bounds);
                out.i32(node.least_mm);
            });
        }
    }

    pub(super) fn entry(&mut self, entry: &Entry) {
        self.0.extend(entry.mark);
        self.bounds(&entry.bounds);
        self.bounds(&entry.danger);
        self.bounds(&entry.unassessed.unwrap_or(Bounds::EMPTY));
        self.0.extend([u8::from(entry.unassessed.is_some()), entry.worst_zone.unwrap_or(0)]);
        self.u32s(&[entry.objects, entry.vertices]);
    }

    pub(super) fn source(&mut self, source: &Source) {
        for text in [&source.name, &source.edition, &source.update, &source.issue_date] {
            self.text(text);
        }
        self.u32s(&[source.scale]);
        self.0.extend([source.band, source.sounding_datum, u8::from(source.supplement)]);
    }

    pub(super) fn object(&mut self, object: &ChartObject) {
        let ObjectId { agency, number, subdivision } = object.id;
        self.u32s(&[object.record, object.source, number]);
        for value in [object.class.0, agency, subdivision] {
            self.0.extend(value.to_le_bytes());
        }
        let interest = u8::from(object.interest);
        self.0.extend([object.role as u8, interest, object.zone.unwrap_or(0)]);
        let (kind, first, second) = match object.stored {
            Stored::Land => (0, None, None),
            Stored::Obstacle => (1, None, None),
            Stored::Unknown => (2, None, None),
            Stored::NoData => (3, None, None),
            Stored::Overhead(clearance) => (4, clearance, None),
            Stored::Depth(least, greatest) => (5, Some(least), greatest),
        };
        self.0.push(kind);
        self.i32(first.unwrap_or(i32::MIN));
        self.i32(second.unwrap_or(i32::MIN));
        self.0.push(u8::from(object.name.is_some()));
        self.text(object.name.as_deref().unwrap_or_default());
    }
}

/// Bytes that are read row by row; a read that leads beyond them answers `None`.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    /// Where it stands.
    pub(super) at: usize,
}

impl Reader<'_> {
    pub(super) fn piece(&mut self) -> Option<Piece> {
        let charts = self.list(4, Self::text)?;
        let objects = self.list(35, Self::object)?;
        let (own_objects, own_vertices) = (self.u32()?, self.u32()?);
        let line = |reader: &mut Self| {
            Some(Line { object: reader.u32()?, first: reader.u32()?, count: reader.u32()? })
        };
        let lines = self.list(12, line)?;
        let areas = self.areas()?;
        let corner = self.vertex()?;
        let side = i64::from_le_bytes(self.array()?);
        let nodes = self.list(8, |reader| Some(Quad { first: reader.u32()?, count: reader.u32()? }))?;
        let entries = self.list(4, Self::u32)?;
        let places = Places { corner, side, nodes, entries };
        let trees = [self.tree()?, self.tree()?, self.tree()?, self.tree()?, self.tree()?];
        let supplement = false;
        Some(Piece { supplement, charts, objects, areas, lines, places, own_objects, own_vertices, trees })
    }

    pub(super) fn areas(&mut self) -> Option<Areas> {
        let vertices = self.list(8, Self::vertex)?;
        let ring = |reader: &mut Self| {
            Some(Ring { first: reader.u32()?, count: reader.u32()?, boxes: reader.u32()? })
        };
        let rings = self.list(12, ring)?;
        let boxes = self.list(16, Self::bounds)?;
        let area = |reader: &mut Self| {
            Some(AreaEntry { object: reader.u32()?, first_ring: reader.u32()?, rings: reader.u32()? })
        };
        Some(Areas { vertices, rings, boxes, list: self.list(12, area)? })
    }

    pub(super) fn entry(&mut self) -> Option<Entry> {
        let mark = self.array()?;
        let (bounds, danger, unassessed) = (self.bounds()?, self.bounds()?, self.bounds()?);
        let (bare, zone) = (self.u8()? != 0, self.u8()?);
        let (objects, vertices) = (self.u32()?, self.u32()?);
        let unassessed = bare.then_some(unassessed);
        let worst_zone = (zone > 0).then_some(zone);
        Some(Entry { mark, bounds, danger, unassessed, worst_zone, objects, vertices })
    }

    pub(super) fn tree(&mut self) -> Option<Tree> {
        let run = |reader: &mut Self| {
            Some(Run { first: reader.u32()?, count: reader.u32()?, object: reader.u32()? })
        };
        let runs = self.list(12, run)?;
        let node = |reader: &mut Self| Some(Node { bounds: reader.bounds()?, least_mm: reader.i32()? });
        Tree::from_parts(runs, self.list(20, node)?)
    }

    /// A table; its length must fit what is left, so that nothing is allocated for rows that cannot be there.
    pub(super) fn list<T>(
        &mut self,
        row_bytes: usize,
        mut read: impl FnMut(&mut Self) -> Option<T>,
    ) -> Option<Vec<T>> {
        let count = self.u32()? as usize;
        if count > (self.bytes.len() - self.at) / row_bytes {
            return None;
        }
        let mut rows = Vec::with_capacity(count);
        for _ in 0..count {
            rows.push(read(self)?);
        }
        Some(rows)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = self.bytes.get(self.at..self.at + N)?;
        self.at += N;
        bytes.try_into().ok()
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn vertex(&mut self) -> Option<Vertex> {
        Some([self.i32()?, self.i32()?])
    }

    pub(super) fn bounds(&mut self) -> Option<Bounds> {
        Some(Bounds { min: self.vertex()?, max: self.vertex()? })
    }

    pub(super) fn text(&mut self) -> Option<String> {
        String::from_utf8(self.list(1, Self::u8)?).ok()
    }

    pub(super) fn source(&mut self) -> Option<Source> {
        Some(Source {
            name: self.text()?,
            edition: self.text()?,
            update: self.text()?,
            issue_date: self.text()?,
            scale: self.u32()?,
            band: self.u8()?,
            sounding_datum: self.u8()?,
            supplement: self.u8()? != 0,
        })
    }

    pub(super) fn object(&mut self) -> Option<ChartObject> {
        let (record, source, number) = (self.u32()?, self.u32()?, self.u32()?);
        let (class, agency, subdivision) = (self.u16()?, self.u16()?, self.u16()?);
        let role = match self.u8()? {
            0 => Role::Coverage,
            1 => Role::Skin,
            2 => Role::Danger,
            3 => Role::Quality,
            4 => Role::Overhead,
            5 => Role::Interest,
            6 => Role::Prohibited,
            7 => Role::Restricted,
            _ => return None,
        };
        let (interest, zone, kind) = (self.u8()? != 0, self.u8()?, self.u8()?);
        let (first, second) = (self.i32()?, self.i32()?);
        let given = |value: i32| (value != i32::MIN).then_some(value);
        let stored = match kind {
            0 => Stored::Land,
            1 => Stored::Obstacle,
            2 => Stored::Unknown,
            3 => Stored::NoData,
            4 => Stored::Overhead(given(first)),
            // Values of the range that stands for "no depth" are refused.
            5 if first > i32::MIN + 16 => Stored::Depth(first, given(second)),
            _ => return None,
        };
        let (named, name) = (self.u8()? != 0, self.text()?);
        Some(ChartObject {
            class: ObjectClass(class),
            id: ObjectId { agency, number, subdivision },
            record,
            source,
            name: named.then_some(name),
            zone: (zone > 0).then_some(zone),
            stored,
            role,
            interest,
        })
    }
}
