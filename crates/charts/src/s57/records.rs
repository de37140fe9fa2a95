//! The contents of a file's records, base cell or update, field by field.

use super::feature::{Attribute, LinkRole, ObjectId};
use crate::iso8211::LexicalLevel;

/// What a file says of itself (field DSID).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DatasetId {
    /// Exchange purpose: 1 a new data set, 2 an update.
    pub purpose: u8,
    /// Usage band, 1 overview to 6 berthing.
    pub band: u8,
    /// File name, such as `US5WA22M.000`.
    pub name: String,
    /// Edition.
    pub edition: String,
    /// Number of the last update applied.
    pub update: String,
    /// Updates up to this date (YYYYMMDD) are in the base.
    pub update_date: String,
    /// Date of issue (YYYYMMDD).
    pub issue_date: String,
    /// Edition of S-57, such as `03.1`.
    pub standard: String,
    /// Product specification: 1 ENC.
    pub product: u8,
    /// Agency that produced it.
    pub agency: u16,
    /// Comment.
    pub comment: String,
}

/// What a file says of its contents (field DSSI).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DatasetStructure {
    /// Data structure: 2 chain-node.
    pub structure: u8,
    /// Characters of the attributes.
    pub attribute_level: LexicalLevel,
    /// Characters of the national attributes.
    pub national_level: LexicalLevel,
    /// Number of meta features.
    pub meta_features: u32,
    /// Number of geo features.
    pub geo_features: u32,
    /// Number of collections.
    pub collections: u32,
    /// Number of isolated nodes.
    pub isolated_nodes: u32,
    /// Number of connected nodes.
    pub connected_nodes: u32,
    /// Number of edges.
    pub edges: u32,
}

/// By what the numbers of a cell are measured (field DSPM).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DatasetParameters {
    /// Horizontal datum: 2 WGS 84.
    pub horizontal_datum: u8,
    /// Datum of heights.
    pub vertical_datum: u8,
    /// Datum of depths.
    pub sounding_datum: u8,
    /// Compilation scale, 1 : this.
    pub scale: u32,
    /// Coordinates are degrees times this.
    pub coordinate_factor: u32,
    /// Depths are metres times this.
    pub sounding_factor: u32,
    /// Comment.
    pub comment: String,
}

/// What an update does with a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Instruction {
    #[default]
    Insert,
    Delete,
    Modify,
}

impl Instruction {
    pub(super) fn from_code(code: i64) -> Option<Self> {
        match code {
            1 => Some(Self::Insert),
            2 => Some(Self::Delete),
            3 => Some(Self::Modify),
            _ => None,
        }
    }
}

/// The name of a vector record: kind and number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Name {
    pub(super) kind: u8,
    pub(super) id: u32,
}

/// Kinds of vector records (RCNM).
pub(super) const ISOLATED_NODE: u8 = 110;
pub(super) const CONNECTED_NODE: u8 = 120;
pub(super) const EDGE: u8 = 130;

/// A pointer from a feature to a vector record, or from an edge to a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pointer {
    pub(super) name: Name,
    /// 1 forward, 2 reverse.
    pub(super) orientation: u8,
    /// 1 exterior, 2 interior, 3 exterior at the data limit.
    pub(super) usage: u8,
    /// 1 begin node, 2 end node.
    pub(super) topology: u8,
    /// 1 masked.
    pub(super) mask: u8,
}

/// A pointer from a feature to another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Link {
    pub(super) to: ObjectId,
    pub(super) role: LinkRole,
}

/// A position as written, with a depth where the field has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Coordinate {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) z: i32,
}

/// Where in a list an update inserts, deletes or replaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Control {
    pub(super) instruction: Instruction,
    /// Counted from 1.
    pub(super) index: usize,
    pub(super) count: usize,
}

/// A list of a record: plain in a base cell, under controls in an update.
pub(super) type Edits<T> = Vec<(Option<Control>, Vec<T>)>;

#[derive(Debug, Clone, Default)]
pub(super) struct FeatureRecord {
    pub(super) id: u32,
    pub(super) primitive: u8,
    pub(super) group: u8,
    pub(super) class: u16,
    pub(super) version: u16,
    pub(super) instruction: Instruction,
    pub(super) object: Option<ObjectId>,
    pub(super) attributes: Vec<Attribute>,
    pub(super) national: Vec<Attribute>,
    pub(super) links: Edits<Link>,
    pub(super) pointers: Edits<Pointer>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct VectorRecord {
    pub(super) name: Name,
    pub(super) version: u16,
    pub(super) instruction: Instruction,
    pub(super) attributes: Vec<Attribute>,
    pub(super) pointers: Edits<Pointer>,
    pub(super) coordinates: Edits<Coordinate>,
    pub(super) has_depths: bool,
}

#[derive(Debug, Clone)]
pub(super) enum DataRecord {
    Id(DatasetId, Option<DatasetStructure>),
    Parameters(DatasetParameters),
    Feature(FeatureRecord),
    Vector(VectorRecord),
    /// History, accuracy, data dictionary and the like: nothing of the chart's picture.
    Other,
}
