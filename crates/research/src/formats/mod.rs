//! Detections as files that portals, R packages and people take, one format in one module.
//!
//! Headers are the formats' own, byte for byte: readers know a file by them. All files are UTF-8 without a mark, times are UTC,
//! degrees have eight decimals (1 mm). What is not known is absent in the way of the format, never 0.

mod actel;
mod cells;
mod etn;
mod fathom;
mod glatos;
mod lutra;
mod movebank;
mod otn;
mod thelma;
mod vue;
mod yaps;

pub use lutra::LUTRA_COLUMNS;

use crate::study::{Heard, Study};
use cells::Cells;
use tables::Dialect;

/// A file format.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// By which it is asked for.
    pub name: &'static str,
    /// For whom it is.
    pub about: &'static str,
    /// What stands before the first row, with its ends of lines; of [`LUTRA`] the names of columns alone.
    pub header: &'static str,
    /// What stands where nothing is known.
    absent: &'static str,
    /// What comes of a detection or of the register.
    rows: Rows,
    /// Whether rows tell the nearest other detection of the tag.
    pub has_lag: bool,
}

/// What the rows of a file are.
#[derive(Debug, Clone, Copy)]
enum Rows {
    /// Detections; `false` leaves one out that the format cannot hold.
    Detections(fn(&mut Cells<'_>, &Heard<'_>) -> bool),
    /// Animals with their tags.
    Animals(fn(&mut Cells<'_>, &api::RegisterTag, &api::RegisterAnimal)),
}

/// All of one's own columns: for programs and spreadsheets that need no other format.
pub const LUTRA: Format = lutra::FORMAT;

/// All formats, the one of all columns first.
pub const FORMATS: [Format; 12] = [
    LUTRA,
    vue::FORMAT,
    fathom::FORMAT,
    thelma::NEW,
    thelma::OLD,
    otn::FORMAT,
    etn::FORMAT,
    glatos::FORMAT,
    actel::DETECTIONS,
    actel::BIOMETRICS,
    yaps::FORMAT,
    movebank::FORMAT,
];

/// The format of this name.
///
/// # Errors
/// No format has this name; the text lists those that there are.
pub fn format(name: &str) -> Result<Format, String> {
    let name = name.trim();
    FORMATS.into_iter().find(|format| format.name == name).ok_or_else(|| {
        let shown: String = name.chars().take(40).collect();
        let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
        format!("`{shown}` is no format; there are {}", names.join(", "))
    })
}

impl Format {
    /// Whether its rows are detections; else they are of the register alone.
    pub const fn is_of_detections(&self) -> bool {
        matches!(self.rows, Rows::Detections(_))
    }
}

/// Writes one file.
#[derive(Debug)]
pub struct Writer {
    format: Format,
    dialect: Dialect,
}

impl Writer {
    /// Of this format; all but [`LUTRA`] know the plain dialect only.
    pub fn new(format: Format, dialect: Dialect) -> Self {
        Self { format, dialect }
    }

    /// Appends what a file begins with.
    pub fn header(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self.dialect.mark());
        if self.format.name == LUTRA.name {
            lutra::header(out, self.dialect);
        } else {
            out.extend_from_slice(self.format.header.as_bytes());
        }
    }

    /// Appends the row of a detection; `false` where the format has none for it.
    pub fn row(&self, out: &mut Vec<u8>, heard: &Heard<'_>) -> bool {
        let Rows::Detections(write) = self.format.rows else { return false };
        let begun = out.len();
        let written = write(&mut Cells::new(out, self.dialect, self.format.absent), heard);
        if written {
            out.push(b'\n');
        } else {
            out.truncate(begun);
        }
        written
    }

    /// Appends the rows of a file that is of the register alone; how many.
    pub fn rows_of(&self, out: &mut Vec<u8>, study: &Study) -> u64 {
        let Rows::Animals(write) = self.format.rows else { return 0 };
        let mut rows = 0;
        for (tag, animal) in study.carried() {
            write(&mut Cells::new(out, self.dialect, self.format.absent), tag, animal);
            out.push(b'\n');
            rows += 1;
        }
        rows
    }
}

#[cfg(test)]
mod tests;
