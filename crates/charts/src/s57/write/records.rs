//! What is in a draft, in the order of the file.

use super::change::{FeatureChange, VectorChange, control};
use super::error::WriteError;
use super::feature::{FeatureDraft, FeatureRef};
use super::vector::{NULL, VectorRef};
use crate::s57::records::{
    CONNECTED_NODE, Coordinate, DataRecord, EDGE, FeatureRecord, ISOLATED_NODE, Instruction, Pointer,
    VectorRecord,
};
use crate::s57::{GeoPoint, ObjectId, Sounding};

/// Nodes, edges, features and changes in the order in which they are written.
///
/// Positions are rounded to the file's factors. A position that does not fit is an error when the file is made.
#[derive(Debug, Clone)]
pub struct Records {
    agency: u16,
    coordinate_factor: u32,
    sounding_factor: u32,
    /// Last record number used of isolated nodes, connected nodes, edges and features.
    last: [u32; 4],
    list: Vec<DataRecord>,
    fault: Option<WriteError>,
}

impl Records {
    pub(super) fn new(agency: u16, coordinate_factor: u32, sounding_factor: u32) -> Self {
        Self { agency, coordinate_factor, sounding_factor, last: [0; 4], list: Vec::new(), fault: None }
    }

    /// Records of another file as they are.
    #[cfg(test)]
    pub(super) fn of(list: Vec<DataRecord>) -> Self {
        Self { list, ..Self::new(0, 1, 1) }
    }

    /// Nothing, with numbers beyond those used here.
    pub(super) fn continued(&self) -> Self {
        Self { last: self.last, ..Self::new(self.agency, self.coordinate_factor, self.sounding_factor) }
    }

    pub(super) fn factors(&self) -> (u32, u32) {
        (self.coordinate_factor, self.sounding_factor)
    }

    pub(super) fn list(&self) -> Result<&[DataRecord], WriteError> {
        self.fault.clone().map_or(Ok(&self.list), Err)
    }

    /// A node at which edges meet, or which a point feature on a line shares with it.
    pub fn connected_node(&mut self, at: GeoPoint) -> VectorRef {
        let coordinates = vec![self.coordinate(at, 0.0)];
        self.vector(CONNECTED_NODE, Vec::new(), coordinates, false)
    }

    /// The node of a point feature on its own.
    pub fn isolated_node(&mut self, at: GeoPoint) -> VectorRef {
        let coordinates = vec![self.coordinate(at, 0.0)];
        self.vector(ISOLATED_NODE, Vec::new(), coordinates, false)
    }

    /// One node with many soundings.
    pub fn soundings(&mut self, soundings: &[Sounding]) -> VectorRef {
        let coordinates = soundings.iter().map(|one| self.coordinate(one.at, one.depth_m)).collect();
        self.vector(ISOLATED_NODE, Vec::new(), coordinates, true)
    }

    /// An edge from node to node; without vertices between them it is a straight line.
    pub fn edge(&mut self, from: VectorRef, to: VectorRef, between: &[GeoPoint]) -> VectorRef {
        let pointers = [(from, 1), (to, 2)].map(|(node, topology)| Pointer {
            name: node.name(),
            orientation: NULL,
            usage: NULL,
            topology,
            mask: NULL,
        });
        let coordinates = between.iter().map(|at| self.coordinate(*at, 0.0)).collect();
        self.vector(EDGE, pointers.into(), coordinates, false)
    }

    /// Inserts a feature.
    pub fn feature(&mut self, draft: FeatureDraft) -> FeatureRef {
        let id = self.next(3);
        let object = draft.object.unwrap_or(ObjectId { agency: self.agency, number: id, subdivision: 1 });
        let record = FeatureRecord {
            id,
            primitive: draft.primitive,
            group: draft.group,
            class: draft.class.0,
            version: 1,
            instruction: Instruction::Insert,
            object: Some(object),
            attributes: draft.attributes,
            national: draft.national,
            links: plain(draft.links),
            pointers: plain(draft.pointers),
        };
        let (primitive, group, class) = (draft.primitive, draft.group, draft.class);
        self.list.push(DataRecord::Feature(record));
        FeatureRef { record: id, primitive, group, class, object, version: 1 }
    }

    /// Changes a feature, which gets the next version.
    pub fn change_feature(&mut self, change: FeatureChange) -> FeatureRef {
        let target = FeatureRef { version: change.target.version.wrapping_add(1), ..change.target };
        self.list.push(DataRecord::Feature(FeatureRecord {
            attributes: change.attributes,
            national: change.national,
            links: change.links,
            pointers: change.pointers,
            ..head(target, Instruction::Modify)
        }));
        target
    }

    /// Deletes a feature.
    pub fn delete_feature(&mut self, target: FeatureRef) {
        let target = FeatureRef { version: target.version.wrapping_add(1), ..target };
        self.list.push(DataRecord::Feature(head(target, Instruction::Delete)));
    }

    /// Changes a node or edge, which gets the next version.
    pub fn change_vector(&mut self, change: VectorChange) -> VectorRef {
        let target = VectorRef { version: change.target.version.wrapping_add(1), ..change.target };
        let mut record = vector_head(target, Instruction::Modify);
        for edit in change.positions {
            let (control, positions) = control(edit);
            let coordinates = positions.into_iter().map(|(at, depth_m)| self.coordinate(at, depth_m));
            record.coordinates.push((control, coordinates.collect()));
        }
        record.has_depths = change.depths;
        record.pointers = change.pointers;
        self.list.push(DataRecord::Vector(record));
        target
    }

    /// Deletes a node or edge.
    pub fn delete_vector(&mut self, target: VectorRef) {
        let target = VectorRef { version: target.version.wrapping_add(1), ..target };
        self.list.push(DataRecord::Vector(vector_head(target, Instruction::Delete)));
    }

    fn vector(
        &mut self,
        kind: u8,
        pointers: Vec<Pointer>,
        coordinates: Vec<Coordinate>,
        has_depths: bool,
    ) -> VectorRef {
        let id = self.next(match kind {
            ISOLATED_NODE => 0,
            CONNECTED_NODE => 1,
            _ => 2,
        });
        let new = VectorRef { kind, id, version: 1 };
        let (pointers, coordinates) = (plain(pointers), plain(coordinates));
        let record =
            VectorRecord { pointers, coordinates, has_depths, ..vector_head(new, Instruction::Insert) };
        self.list.push(DataRecord::Vector(record));
        new
    }

    fn next(&mut self, counter: usize) -> u32 {
        self.last[counter] += 1;
        self.last[counter]
    }

    fn coordinate(&mut self, at: GeoPoint, depth_m: f64) -> Coordinate {
        let mut number = |value: f64, factor: u32| {
            let scaled = (value * f64::from(factor)).round();
            if (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&scaled) {
                return scaled as i32;
            }
            self.fault.get_or_insert(WriteError::Coordinate { value, factor });
            0
        };
        Coordinate {
            y: number(at.lat_deg, self.coordinate_factor),
            x: number(at.lon_deg, self.coordinate_factor),
            z: number(depth_m, self.sounding_factor),
        }
    }
}

/// A list without control; none where it is empty.
fn plain<T>(list: Vec<T>) -> Vec<(Option<crate::s57::records::Control>, Vec<T>)> {
    if list.is_empty() { Vec::new() } else { vec![(None, list)] }
}

fn head(target: FeatureRef, instruction: Instruction) -> FeatureRecord {
    FeatureRecord {
        id: target.record,
        primitive: target.primitive,
        group: target.group,
        class: target.class.0,
        version: target.version,
        instruction,
        object: Some(target.object),
        ..FeatureRecord::default()
    }
}

fn vector_head(target: VectorRef, instruction: Instruction) -> VectorRecord {
    VectorRecord { name: target.name(), version: target.version, instruction, ..VectorRecord::default() }
}
