//! Changes that an update makes to features, nodes and edges.

use super::feature::FeatureRef;
use super::vector::{NULL, VectorRef, VectorUse};
use crate::s57::records::{Control, Edits, Instruction, Link, Pointer};
use crate::s57::{Attribute, AttributeCode, GeoPoint, LinkRole, ObjectId};

/// Deletes an attribute when it stands alone as its value (S-57 part 3, 8.4.2.2.b).
const DELETED: &str = "\u{7F}";

/// An edit of a list. Indices count from 1.
#[derive(Debug, Clone, PartialEq)]
pub enum ListEdit<T> {
    /// Puts items before an index; length + 1 appends.
    Insert {
        /// Before which item.
        index: usize,
        /// The items.
        items: Vec<T>,
    },
    /// Takes items away.
    Delete {
        /// The first of them.
        index: usize,
        /// How many.
        count: usize,
    },
    /// Replaces items.
    Replace {
        /// The first of them.
        index: usize,
        /// What replaces them.
        items: Vec<T>,
    },
    /// A list without a control field: where there was none.
    Plain(Vec<T>),
}

/// The control field of an edit and its items.
pub(super) fn control<T>(edit: ListEdit<T>) -> (Option<Control>, Vec<T>) {
    let with = |instruction, index, count, items| (Some(Control { instruction, index, count }), items);
    match edit {
        ListEdit::Insert { index, items } => with(Instruction::Insert, index, items.len(), items),
        ListEdit::Delete { index, count } => with(Instruction::Delete, index, count, Vec::new()),
        ListEdit::Replace { index, items } => with(Instruction::Modify, index, items.len(), items),
        ListEdit::Plain(items) => (None, items),
    }
}

fn mapped<T, U>(edit: ListEdit<T>, one: impl Fn(T) -> U) -> (Option<Control>, Vec<U>) {
    let (control, items) = control(edit);
    (control, items.into_iter().map(one).collect())
}

/// A change of a feature: any attributes, and at most one edit of its edges and one of its links.
#[derive(Debug, Clone)]
pub struct FeatureChange {
    pub(super) target: FeatureRef,
    pub(super) attributes: Vec<Attribute>,
    pub(super) national: Vec<Attribute>,
    pub(super) links: Edits<Link>,
    pub(super) pointers: Edits<Pointer>,
}

impl FeatureChange {
    /// No change yet but of the version.
    pub fn of(target: FeatureRef) -> Self {
        let (attributes, national, links, pointers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { target, attributes, national, links, pointers }
    }

    /// Replaces or adds an attribute.
    #[must_use]
    pub fn with(mut self, code: AttributeCode, value: impl Into<String>) -> Self {
        self.attributes.push(Attribute { code, value: value.into() });
        self
    }

    /// Replaces or adds an attribute in the national language.
    #[must_use]
    pub fn national(mut self, code: AttributeCode, value: impl Into<String>) -> Self {
        self.national.push(Attribute { code, value: value.into() });
        self
    }

    /// Takes an attribute away.
    #[must_use]
    pub fn without(self, code: AttributeCode) -> Self {
        self.with(code, DELETED)
    }

    /// Takes an attribute in the national language away.
    #[must_use]
    pub fn without_national(self, code: AttributeCode) -> Self {
        self.national(code, DELETED)
    }

    /// Edits the edges; of an area where the feature is one.
    #[must_use]
    pub fn edges(mut self, edit: ListEdit<VectorUse>) -> Self {
        let area = self.target.primitive == 3;
        self.pointers.push(mapped(edit, |edge| edge.pointer(area)));
        self
    }

    /// Edits the links.
    #[must_use]
    pub fn links(mut self, edit: ListEdit<(ObjectId, LinkRole)>) -> Self {
        self.links.push(mapped(edit, |(to, role)| Link { to, role }));
        self
    }
}

/// A change of a node or edge: at most one edit of its positions and one of its nodes.
#[derive(Debug, Clone)]
pub struct VectorChange {
    pub(super) target: VectorRef,
    pub(super) positions: Vec<ListEdit<(GeoPoint, f64)>>,
    pub(super) depths: bool,
    pub(super) pointers: Edits<Pointer>,
}

impl VectorChange {
    /// No change yet but of the version.
    pub fn of(target: VectorRef) -> Self {
        Self { target, positions: Vec::new(), depths: false, pointers: Vec::new() }
    }

    /// Edits the vertices of an edge or the position of a node.
    #[must_use]
    pub fn vertices(self, edit: ListEdit<GeoPoint>) -> Self {
        self.positions(edit, |at| (at, 0.0))
    }

    /// Edits the soundings of a node.
    #[must_use]
    pub fn soundings(self, edit: ListEdit<crate::s57::Sounding>) -> Self {
        Self { depths: true, ..self }.positions(edit, |one| (one.at, one.depth_m))
    }

    /// Edits the nodes between which an edge lies: the beginning is item 1, the end item 2.
    #[must_use]
    pub fn nodes(mut self, edit: ListEdit<EdgeEnd>) -> Self {
        self.pointers.push(mapped(edit, |EdgeEnd { node, begins }| Pointer {
            name: node.name(),
            orientation: NULL,
            usage: NULL,
            topology: if begins { 1 } else { 2 },
            mask: NULL,
        }));
        self
    }

    fn positions<T>(mut self, edit: ListEdit<T>, one: impl Fn(T) -> (GeoPoint, f64)) -> Self {
        let list = |items: Vec<T>| items.into_iter().map(&one).collect();
        self.positions.push(match edit {
            ListEdit::Insert { index, items } => ListEdit::Insert { index, items: list(items) },
            ListEdit::Delete { index, count } => ListEdit::Delete { index, count },
            ListEdit::Replace { index, items } => ListEdit::Replace { index, items: list(items) },
            ListEdit::Plain(items) => ListEdit::Plain(list(items)),
        });
        self
    }
}

/// A node at an end of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeEnd {
    /// The node.
    pub node: VectorRef,
    /// Whether the edge begins there.
    pub begins: bool,
}
