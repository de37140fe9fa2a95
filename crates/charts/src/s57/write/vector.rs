//! Nodes and edges of a draft, and how features use them.

use crate::s57::records::{Name, Pointer};

/// Does not apply.
pub(super) const NULL: u8 = 255;

/// A node or edge of a draft, in the version in which it was written last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VectorRef {
    pub(super) kind: u8,
    /// Record number.
    pub id: u32,
    /// Version of the record.
    pub version: u16,
}

impl VectorRef {
    /// The edge from its beginning to its end, as part of a line or of an exterior boundary.
    pub fn forward(self) -> VectorUse {
        VectorUse { vector: self, reversed: false, usage: 1, masked: false }
    }

    /// The edge from its end to its beginning.
    pub fn reverse(self) -> VectorUse {
        VectorUse { reversed: true, ..self.forward() }
    }

    pub(super) fn name(self) -> Name {
        Name { kind: self.kind, id: self.id }
    }
}

/// How a feature uses an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VectorUse {
    pub(super) vector: VectorRef,
    pub(super) reversed: bool,
    pub(super) usage: u8,
    pub(super) masked: bool,
}

impl VectorUse {
    /// As part of a hole.
    #[must_use]
    pub fn interior(self) -> Self {
        Self { usage: 2, ..self }
    }

    /// As an exterior boundary where the data end, not the object.
    #[must_use]
    pub fn data_limit(self) -> Self {
        Self { usage: 3, ..self }
    }

    /// Not to be drawn.
    #[must_use]
    pub fn masked(self) -> Self {
        Self { masked: true, ..self }
    }

    /// The other way round.
    #[must_use]
    pub fn turned(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    pub(super) fn pointer(self, area: bool) -> Pointer {
        Pointer {
            name: self.vector.name(),
            orientation: if self.reversed { 2 } else { 1 },
            usage: if area { self.usage } else { NULL },
            topology: 0,
            mask: if self.masked { 1 } else { 2 },
        }
    }
}
