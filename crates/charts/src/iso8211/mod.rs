//! The container of S-57: ISO/IEC 8211 records, fields and subfields, read in place.
//!
//! A file is records back to back. The first, the data descriptive record (DDR), says which fields exist and
//! how their subfields are written; all others are data records. Leader and directory numbers are ASCII.
//! Nothing is copied: a [`Record`] borrows the file, and memory beyond the file itself is one directory.
//!
//! Sources: ISO/IEC 8211:1994 (leader 5.2, directory 5.3, field controls 6.2); IHO S-57 edition 3.1, part 3,
//! annex A. Both the entry map and the base address differ between records of one file, so each record's own
//! are used. Field positions are taken from the directory, never from the order of its entries.

mod definition;
mod error;
mod leader;
mod reader;
mod record;
mod row;
mod tag;

pub use definition::{FieldDefinition, Format, Subfield};
pub use error::{Iso8211Error, Iso8211Problem};
pub use reader::Reader;
pub use record::{Field, Record};
pub use row::{LexicalLevel, Rows, Value};
pub use tag::Tag;

/// Ends every field.
pub const FIELD_TERMINATOR: u8 = 0x1E;
/// Ends a subfield of variable length.
pub const UNIT_TERMINATOR: u8 = 0x1F;
