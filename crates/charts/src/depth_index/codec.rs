//! An index as bytes: written once ashore, loaded in a moment aboard.
//!
//! Layout, all little-endian: the magic `LUTRADIX`, version (u32), checksum of what follows (u32, CRC-32),
//! then each table as its length (u32) and its rows. Reading checks every index against the table that it
//! points into, so that damaged bytes are refused and never lead out of bounds.

use super::index::DepthIndex;
use super::object::{ChartObject, Role, Stored};
use super::places::{AreaEntry, Places, Quad, WHOLE};
use super::ring::Ring;
use super::tree::{NO_DATA, Node, Run, Tree};
use crate::coverage::Source;
use crate::crc32::crc32;
use crate::grid::{Bounds, Vertex};
use crate::s57::{ObjectClass, ObjectId};

const MAGIC: &[u8; 8] = b"LUTRADIX";
/// Raised whenever the layout changes, or the rules by which an index is made of charts: one by older rules may call
/// safe what is not, so it is made again.
const VERSION: u32 = 2;
const HEAD_BYTES: usize = 16;

/// Why bytes are no index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum IndexError {
    /// Something else.
    #[error("these bytes are no depth index; build one from the charts")]
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
        let mut out = Writer(Vec::with_capacity(self.areas.vertices.len() * 16 + 4096));
        out.list(&self.sources, Writer::source);
        out.list(&self.objects, Writer::object);
        out.list(&self.areas.vertices, |out, vertex| out.vertex(*vertex));
        out.list(&self.areas.rings, |out, ring| out.u32s(&[ring.first, ring.count, ring.boxes]));
        out.list(&self.areas.boxes, Writer::bounds);
        out.list(&self.areas.list, |out, area| out.u32s(&[area.object, area.first_ring, area.rings]));
        out.vertex(self.places.corner);
        out.0.extend(self.places.side.to_le_bytes());
        out.list(&self.places.nodes, |out, node| out.u32s(&[node.first, node.count]));
        out.list(&self.places.entries, |out, entry| out.u32s(&[*entry]));
        for tree in [&self.danger, &self.quality, &self.overhead, &self.interest] {
            out.list(&tree.runs, |out, run| out.u32s(&[run.first, run.count, run.object]));
            out.list(&tree.nodes, |out, node| {
                out.bounds(&node.bounds);
                out.i32(node.least_mm);
            });
        }
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(crc32(&out.0).to_le_bytes());
        bytes.extend(out.0);
        bytes
    }

    /// The index of some bytes.
    ///
    /// # Errors
    /// When they are no index, of another version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IndexError> {
        if bytes.get(..8) != Some(MAGIC.as_slice()) || bytes.len() < HEAD_BYTES {
            return Err(IndexError::Magic);
        }
        let mut head = Reader { bytes, at: 8 };
        let damaged = |at| IndexError::Damaged(at);
        let version = head.u32().ok_or(damaged(8))?;
        if version != VERSION {
            return Err(IndexError::Version(version));
        }
        if head.u32() != Some(crc32(&bytes[HEAD_BYTES..])) {
            return Err(damaged(12));
        }
        Self::from_body(&bytes[HEAD_BYTES..])
    }

    /// The index of what follows the head, without comparing its checksum: for tests of the checks below it.
    pub(super) fn from_body(body: &[u8]) -> Result<Self, IndexError> {
        let mut reader = Reader { bytes: body, at: 0 };
        let index = reader.index().filter(|_| reader.at == body.len());
        let mut index = index.ok_or(IndexError::Damaged(HEAD_BYTES + reader.at))?;
        if !index.is_sound() {
            return Err(IndexError::Damaged(HEAD_BYTES));
        }
        index.note_unassessed();
        Ok(index)
    }

    /// Whether everything that points points into its table.
    fn is_sound(&self) -> bool {
        let within = |first: u32, count: u32, length: usize| {
            first.checked_add(count).is_some_and(|end| end as usize <= length)
        };
        let areas = &self.areas;
        let vertices = areas.vertices.len();
        let rings_sound = areas.rings.iter().all(|ring| {
            let boxes = Ring::box_count(ring.segments()) as u32;
            ring.count >= 2
                && within(ring.first, ring.count, vertices)
                && within(ring.boxes, boxes, areas.boxes.len())
        });
        let areas_sound = areas.list.iter().all(|area| {
            within(area.first_ring, area.rings, areas.rings.len())
                && (area.object as usize) < self.objects.len()
        });
        let trees_sound = [&self.danger, &self.quality, &self.overhead, &self.interest].iter().all(|tree| {
            tree.runs.iter().all(|run| {
                let known = (run.object as usize) < self.objects.len();
                run.count >= 1 && within(run.first, run.count, vertices) && (known || run.object == NO_DATA)
            })
        });
        // Only the trees of dangers and of quality may hold the border of what is charted or assessed.
        let named = [&self.overhead, &self.interest]
            .iter()
            .all(|tree| tree.runs.iter().all(|run| run.object != NO_DATA));
        let sourced = self.objects.iter().all(|object| (object.source as usize) < self.sources.len());
        rings_sound && areas_sound && trees_sound && named && sourced && self.places_sound()
    }

    fn places_sound(&self) -> bool {
        let Places { side, nodes, entries, .. } = &self.places;
        if nodes.is_empty() {
            return entries.is_empty();
        }
        let sided = *side > 0 && *side <= 1 << 33 && (*side as u64).is_power_of_two();
        // Children come after their parents, so that no walk goes in circles.
        let noded = nodes.iter().enumerate().all(|(at, node)| {
            if node.is_inner() {
                node.first as usize > at && (node.first as usize).saturating_add(4) <= nodes.len()
            } else {
                (node.first as usize).saturating_add(node.count as usize) <= entries.len()
            }
        });
        sided && noded && entries.iter().all(|entry| ((entry & !WHOLE) as usize) < self.areas.list.len())
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn list<T>(&mut self, items: &[T], mut write: impl FnMut(&mut Self, &T)) {
        // Tables are indexed by u32.
        self.u32s(&[items.len() as u32]);
        for item in items {
            write(self, item);
        }
    }

    fn u32s(&mut self, values: &[u32]) {
        for value in values {
            self.0.extend(value.to_le_bytes());
        }
    }

    fn i32(&mut self, value: i32) {
        self.0.extend(value.to_le_bytes());
    }

    fn vertex(&mut self, vertex: Vertex) {
        for value in vertex {
            self.i32(value);
        }
    }

    fn bounds(&mut self, bounds: &Bounds) {
        self.vertex(bounds.min);
        self.vertex(bounds.max);
    }

    fn text(&mut self, text: &str) {
        self.list(text.as_bytes(), |out, byte| out.0.push(*byte));
    }

    fn source(&mut self, source: &Source) {
        for text in [&source.name, &source.edition, &source.update, &source.issue_date] {
            self.text(text);
        }
        self.u32s(&[source.scale]);
        self.0.extend([source.band, source.sounding_datum, u8::from(source.supplement)]);
    }

    fn object(&mut self, object: &ChartObject) {
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

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn index(&mut self) -> Option<DepthIndex> {
        let mut index = DepthIndex { sources: self.list(19, Self::source)?, ..DepthIndex::default() };
        index.objects = self.list(35, Self::object)?;
        index.areas.vertices = self.list(8, Self::vertex)?;
        let ring = |reader: &mut Self| {
            Some(Ring { first: reader.u32()?, count: reader.u32()?, boxes: reader.u32()? })
        };
        index.areas.rings = self.list(12, ring)?;
        index.areas.boxes = self.list(16, Self::bounds)?;
        let area = |reader: &mut Self| {
            Some(AreaEntry { object: reader.u32()?, first_ring: reader.u32()?, rings: reader.u32()? })
        };
        index.areas.list = self.list(12, area)?;
        index.places.corner = self.vertex()?;
        index.places.side = i64::from_le_bytes(self.array()?);
        index.places.nodes =
            self.list(8, |reader| Some(Quad { first: reader.u32()?, count: reader.u32()? }))?;
        index.places.entries = self.list(4, Self::u32)?;
        index.danger = self.tree()?;
        index.quality = self.tree()?;
        index.overhead = self.tree()?;
        index.interest = self.tree()?;
        Some(index)
    }

    fn tree(&mut self) -> Option<Tree> {
        let run = |reader: &mut Self| {
            Some(Run { first: reader.u32()?, count: reader.u32()?, object: reader.u32()? })
        };
        let runs = self.list(12, run)?;
        let node = |reader: &mut Self| Some(Node { bounds: reader.bounds()?, least_mm: reader.i32()? });
        Tree::from_parts(runs, self.list(20, node)?)
    }

    /// A table; its length must fit what is left, so that nothing is allocated for rows that cannot be there.
    fn list<T>(&mut self, row_bytes: usize, mut read: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
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

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = self.bytes.get(self.at..self.at + N)?;
        self.at += N;
        bytes.try_into().ok()
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_le_bytes)
    }

    fn vertex(&mut self) -> Option<Vertex> {
        Some([self.i32()?, self.i32()?])
    }

    fn bounds(&mut self) -> Option<Bounds> {
        Some(Bounds { min: self.vertex()?, max: self.vertex()? })
    }

    fn text(&mut self) -> Option<String> {
        String::from_utf8(self.list(1, Self::u8)?).ok()
    }

    fn source(&mut self) -> Option<Source> {
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

    fn object(&mut self) -> Option<ChartObject> {
        let (record, source, number) = (self.u32()?, self.u32()?, self.u32()?);
        let (class, agency, subdivision) = (self.u16()?, self.u16()?, self.u16()?);
        let role = match self.u8()? {
            0 => Role::Coverage,
            1 => Role::Skin,
            2 => Role::Danger,
            3 => Role::Quality,
            4 => Role::Overhead,
            5 => Role::Interest,
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
            // A depth that could pass for no depth is none.
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
            let mut body = small().to_bytes().split_off(HEAD_BYTES);
            for (at, value) in changes {
                let at = at.index(body.len());
                body[at] = value;
            }
            if let Ok(index) = DepthIndex::from_body(&body) {
                let from = LatLon::from_deg(63.05, 10.1).unwrap();
                let leg = Leg { from, to: LatLon::from_deg(63.05, 9.9).unwrap() };
                index.shallowest_along(leg, 20.0, &Demand::default());
                index.distance_to_shallower(from, 3.0, 1000.0);
            }
        }
    }
}
