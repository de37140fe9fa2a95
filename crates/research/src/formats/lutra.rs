//! All that is known of a detection, in columns of our own: a row each, the oldest report first.
//!
//! A column that no message carried is an empty cell, never 0. Both messages that can carry a detection are one row.

use super::cells::Cells;
use super::columns::{LUTRA_COLUMNS, values};
use super::{Format, Rows};
use crate::study::Heard;
use tables::Dialect;

pub(super) const FORMAT: Format = Format {
    name: "lutra",
    about: "every column that Lutra knows, for programs and spreadsheets",
    // Written by `header`, as the dialect of a spreadsheet decides what stands between names.
    header: "",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: true,
};

/// Appends the names of the columns.
pub(super) fn header(out: &mut Vec<u8>, dialect: Dialect) {
    for (at, column) in LUTRA_COLUMNS.iter().enumerate() {
        if at > 0 {
            out.push(dialect.separator());
        }
        out.extend_from_slice(column.name.as_bytes());
    }
    out.push(b'\n');
}

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    values(heard, &mut |value| cells.value(value));
    true
}
