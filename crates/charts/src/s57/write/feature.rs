//! Features of a draft.

use super::vector::{NULL, VectorRef, VectorUse};
use crate::s57::records::{Link, Pointer};
use crate::s57::{Attribute, AttributeCode, LinkRole, ObjectClass, ObjectId, SKIN_CLASSES};

/// A feature of a draft, in the version in which it was written last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeatureRef {
    /// Record number.
    pub record: u32,
    /// 1 point, 2 line, 3 area, 255 none.
    pub primitive: u8,
    /// 1 for the skin of the Earth, 2 for others.
    pub group: u8,
    /// Class.
    pub class: ObjectClass,
    /// Identity over editions.
    pub object: ObjectId,
    /// Version of the record.
    pub version: u16,
}

/// A feature to be inserted.
#[derive(Debug, Clone)]
pub struct FeatureDraft {
    pub(super) primitive: u8,
    pub(super) group: u8,
    pub(super) class: ObjectClass,
    pub(super) object: Option<ObjectId>,
    pub(super) attributes: Vec<Attribute>,
    pub(super) national: Vec<Attribute>,
    pub(super) links: Vec<Link>,
    pub(super) pointers: Vec<Pointer>,
}

impl FeatureDraft {
    /// A point, or many soundings, at a node.
    pub fn point(class: ObjectClass, node: VectorRef) -> Self {
        let name = node.name();
        let pointer = Pointer { name, orientation: NULL, usage: NULL, topology: 0, mask: NULL };
        Self::new(class, 1, vec![pointer])
    }

    /// A line of edges.
    pub fn line(class: ObjectClass, edges: &[VectorUse]) -> Self {
        Self::new(class, 2, edges.iter().map(|edge| edge.pointer(false)).collect())
    }

    /// An area bounded by edges: the exterior first, then the holes ([`VectorUse::interior`]).
    pub fn area(class: ObjectClass, edges: &[VectorUse]) -> Self {
        Self::new(class, 3, edges.iter().map(|edge| edge.pointer(true)).collect())
    }

    /// A collection: it has links and no place.
    pub fn collection(class: ObjectClass) -> Self {
        Self::new(class, NULL, Vec::new())
    }

    fn new(class: ObjectClass, primitive: u8, pointers: Vec<Pointer>) -> Self {
        let group = if primitive == 3 && SKIN_CLASSES.contains(&class) { 1 } else { 2 };
        let (object, attributes, national, links) = (None, Vec::new(), Vec::new(), Vec::new());
        Self { primitive, group, class, object, attributes, national, links, pointers }
    }

    /// With an attribute.
    #[must_use]
    pub fn with(mut self, code: AttributeCode, value: impl Into<String>) -> Self {
        self.attributes.push(Attribute { code, value: value.into() });
        self
    }

    /// With an attribute in the national language.
    #[must_use]
    pub fn national(mut self, code: AttributeCode, value: impl Into<String>) -> Self {
        self.national.push(Attribute { code, value: value.into() });
        self
    }

    /// With a link to another feature, which is `role` to this one.
    #[must_use]
    pub fn linked(mut self, to: ObjectId, role: LinkRole) -> Self {
        self.links.push(Link { to, role });
        self
    }

    /// With an identity of its own, as an object that two cells share has. Otherwise it is the cell's agency
    /// and the record number.
    #[must_use]
    pub fn identity(mut self, object: ObjectId) -> Self {
        self.object = Some(object);
        self
    }
}
