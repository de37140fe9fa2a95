//! The options of a table: its shape, units, names and dialect.

use std::num::NonZeroI64;
use tables::{Dialect, Format, Style};

/// How a table is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shape {
    /// A row for each message and a column for each field.
    #[default]
    Wide,
    /// A row for each value, with the names of message and field and the unit.
    Long,
}

/// In which unit angles are written. The history keeps radians.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Angles {
    /// As IMC has them.
    #[default]
    Radians,
    /// `rad` becomes `deg` and `rad/s` becomes `deg/s`.
    Degrees,
}

/// How values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a choice of its own")]
pub struct CsvOptions {
    /// How the table is laid out.
    pub shape: Shape,
    /// In which unit angles are written.
    pub angles: Angles,
    /// Whether a wide table's header gives units, as in `psi [rad]`; else they are in [`describe_csv`](crate::describe_csv) only.
    pub units: bool,
    /// Whether numbers that have names are written as those: `R64K` for 4. Numbers without a name stay.
    pub labels: bool,
    /// Whether text that a spreadsheet would take for a formula gets an apostrophe before it. To get the text
    /// back, take one apostrophe from text that begins with one.
    pub guard: bool,
    /// Whether each row also gives the time at which its message first came ashore.
    pub received: bool,
    /// For which readers cells and numbers are written.
    pub dialect: Dialect,
    /// Of each series the first row in each span of this length (µs), counted from 1970; `None` for every row.
    pub every_us: Option<NonZeroI64>,
}

impl Default for CsvOptions {
    fn default() -> Self {
        Self {
            shape: Shape::Wide,
            angles: Angles::Radians,
            units: true,
            labels: false,
            guard: true,
            received: false,
            dialect: Dialect::Plain,
            every_us: None,
        }
    }
}

impl CsvOptions {
    /// How cells are written.
    pub(crate) fn format(&self) -> Format {
        Format { dialect: self.dialect, guard: self.guard }
    }

    pub(super) fn style(&self) -> Style {
        Style { degrees: self.angles == Angles::Degrees, labels: self.labels }
    }
}
