//! Electronic navigational charts in S-57 edition 3.1: a base cell with its updates becomes features with
//! geometry.
//!
//! [`Cell::read`] reads one cell; [`ExchangeSet::read`] a whole ENC_ROOT tree. Both are pure functions over
//! bytes with names. Records are kept apart from geometry until all updates are applied, because an update may
//! touch any list of any record; then [`Geometry`] is assembled by node identity.
//!
//! Sources: IHO S-57 edition 3.1, part 3 (structure, 7; updating, 8); appendix B.1 (ENC product
//! specification).

mod assemble;
mod catalogue;
mod cell;
mod codes;
mod error;
mod exchange;
mod feature;
mod fields;
mod geometry;
mod named_bytes;
mod records;
mod skin;
mod store;
mod update;
mod words;
pub mod write;

pub use catalogue::{Catalogue, CatalogueEntry};
pub use cell::Cell;
pub use codes::{AttributeCode, ObjectClass, SKIN_CLASSES};
pub use error::{Place, S57Error, S57Problem};
pub use exchange::{CellFailure, ExchangeSet};
pub use feature::{Attribute, Feature, FeatureLink, LinkRole, ObjectId};
pub use geometry::{Area, EdgeUse, GeoPoint, Geometry, Path, Sounding};
pub use named_bytes::NamedBytes;
pub use records::{DatasetId, DatasetParameters, DatasetStructure};
pub use skin::SkinCheck;
pub use store::Notice;
pub use words::{attribute_words, class_words, value_words};
