//! IMC messages as tables of CSV: which columns a message has and how its values are written.
//!
//! One dialect for all that writes tables: exports of the store, `imc lsf csv`, the log book. [`Field`] is a column,
//! [`Format`] how cells are written, [`PacketRow`] a packet as a line; [`message`] finds a message by what people type.
//!
//! - A real has as many digits as distinguish it from all others and always a decimal point (`8.0`), so that readers that
//!   guess types take a column of whole numbers for reals. `NaN`, `inf` and `-inf` are written so; an empty cell is an
//!   absent value. Python (pandas, polars), R and DuckDB read all of these as numbers.
//! - Text that is not UTF-8 is escaped by [`imc::text::escape`], quoted by RFC 4180 and harmless in spreadsheets.
//! - A time is ISO 8601 in UTC and beside it seconds since 1970; a stamp that is not a time gives two empty cells.
//!
//! It is pure: values in, bytes out. It knows IMC and what a detection is, and nothing of files or databases.

mod cell;
mod column;
mod dialect;
mod known;
mod number;
mod packet;
mod value;

pub use cell::{hex, quoted, text};
pub use column::{
    Column, ColumnKind, Computed, FIXED, Field, Style, TRUE_POSITION, column_name, columns, computed_place,
    fields, heading,
};
pub use dialect::{Dialect, Format};
pub use known::{NoMessage, message};
pub use number::{IsoTime, double, epoch, integer, real, single, stamp};
pub use packet::PacketRow;
