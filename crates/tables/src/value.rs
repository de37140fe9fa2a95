//! Values as their column writes them.

use crate::cell;
use crate::column::{ColumnKind, Field};
use crate::dialect::Format;
use crate::number;

impl Field {
    /// Appends an integer as this column has it: by its name, turned into another unit, or as it is.
    pub fn write_integer(&self, out: &mut Vec<u8>, value: i64, format: Format) {
        match (self.names.and_then(|names| names.label(value)), self.factor) {
            (Some(label), _) => cell::text(out, label.as_bytes(), format),
            (None, Some(factor)) => number::double(out, value as f64 * factor, format.dialect),
            (None, None) => number::integer(out, value),
        }
    }

    /// Appends a real likewise. A single is as short as it is, unless it is turned into another unit.
    pub fn write_real(&self, out: &mut Vec<u8>, value: f64, format: Format) {
        match (self.factor, self.kind) {
            (Some(factor), _) => number::double(out, value * factor, format.dialect),
            (None, ColumnKind::Single) => number::single(out, value as f32, format.dialect),
            (None, _) => number::double(out, value, format.dialect),
        }
    }
}
