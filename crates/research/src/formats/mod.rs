//! Detections as files that portals, R packages and people take, one format in one module.
//!
//! Most are CSV. Headers are the formats' own, byte for byte: readers know a file by them. All texts are UTF-8 without a mark, times
//! are UTC, degrees have eight decimals (1 mm). What is not known is absent in the way of the format, never 0.

mod actel;
mod cells;
mod columns;
mod darwin_core;
mod etn;
mod fathom;
mod geojson;
mod glatos;
mod kml;
mod lutra;
mod movebank;
mod otn;
mod parquet;
mod thelma;
mod vue;
mod yaps;

pub use columns::{ColumnKind, DetectionColumn, LUTRA_COLUMNS};

use crate::study::{Heard, Study};
use cells::Cells;
use std::io;
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
    /// Detections as elements of a text.
    Elements(Document),
    /// Detections as rows of a Parquet table.
    Table,
    /// Animals with their tags.
    Animals(fn(&mut Cells<'_>, &api::RegisterTag, &api::RegisterAnimal)),
}

/// All of one's own columns: for programs and spreadsheets that need no other format.
pub const LUTRA: Format = lutra::FORMAT;

/// A text of elements, which is no table.
#[derive(Debug, Clone, Copy)]
struct Document {
    /// With which the name of a file ends.
    ending: &'static str,
    media: &'static str,
    /// Appends a detection; `false`, with nothing appended, where the format cannot hold it.
    element: fn(&mut String, &Heard<'_>) -> bool,
    /// What stands between two.
    between: &'static str,
    /// What stands after the last one.
    end: &'static str,
}

/// All formats, the one of all columns first.
pub const FORMATS: [Format; 16] = [
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
    darwin_core::FORMAT,
    geojson::FORMAT,
    kml::FORMAT,
    parquet::FORMAT,
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
        !matches!(self.rows, Rows::Animals(_))
    }

    /// Whether it is a table of comma-separated values.
    pub const fn is_csv(&self) -> bool {
        matches!(self.rows, Rows::Detections(_) | Rows::Animals(_))
    }

    /// With which the name of its files ends.
    pub const fn ending(&self) -> &'static str {
        match self.rows {
            Rows::Detections(_) | Rows::Animals(_) => "csv",
            Rows::Elements(document) => document.ending,
            Rows::Table => "parquet",
        }
    }

    /// Its media type.
    pub const fn media(&self) -> &'static str {
        match self.rows {
            Rows::Detections(_) | Rows::Animals(_) => "text/csv; charset=utf-8",
            Rows::Elements(document) => document.media,
            Rows::Table => "application/vnd.apache.parquet",
        }
    }
}

/// Writes one file.
#[derive(Debug)]
pub struct Writer {
    format: Format,
    dialect: Dialect,
    /// Whether an element is there already.
    is_begun: bool,
    table: Option<parquet::Table>,
}

impl Writer {
    /// Of this format; all but [`LUTRA`] know the plain dialect only.
    pub fn new(format: Format, dialect: Dialect) -> Self {
        Self { format, dialect, is_begun: false, table: None }
    }

    /// Appends what a file begins with.
    ///
    /// # Errors
    /// The writer of the format fails.
    pub fn header(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        out.extend_from_slice(self.dialect.mark());
        if let Rows::Table = self.format.rows {
            return self.table.insert(parquet::Table::new()?).drain(out);
        }
        if self.format.name == LUTRA.name {
            lutra::header(out, self.dialect);
        } else {
            out.extend_from_slice(self.format.header.as_bytes());
        }
        Ok(())
    }

    /// Appends the row of a detection, or what is ready of the rows so far; `false` where the format has none for it.
    ///
    /// # Errors
    /// As [`Self::header()`].
    pub fn row(&mut self, out: &mut Vec<u8>, heard: &Heard<'_>) -> io::Result<bool> {
        match self.format.rows {
            Rows::Detections(write) => {
                let begun = out.len();
                let written = write(&mut Cells::new(out, self.dialect, self.format.absent), heard);
                if written {
                    out.push(b'\n');
                } else {
                    out.truncate(begun);
                }
                Ok(written)
            }
            Rows::Elements(document) => Ok(self.element(document, out, heard)),
            Rows::Table => {
                let Some(table) = &mut self.table else { return Ok(false) };
                table.row(heard)?;
                table.drain(out)?;
                Ok(true)
            }
            Rows::Animals(_) => Ok(false),
        }
    }

    fn element(&mut self, document: Document, out: &mut Vec<u8>, heard: &Heard<'_>) -> bool {
        let mut text = String::new();
        let is_there = (document.element)(&mut text, heard);
        if is_there {
            if std::mem::replace(&mut self.is_begun, true) {
                out.extend_from_slice(document.between.as_bytes());
            }
            out.extend_from_slice(text.as_bytes());
        }
        is_there
    }

    /// Appends what a file ends with: the rows of one that is of the register alone, of others their last lines. How many rows.
    ///
    /// # Errors
    /// As [`Self::header()`].
    pub fn end(&mut self, out: &mut Vec<u8>, study: &Study) -> io::Result<u64> {
        match self.format.rows {
            Rows::Animals(write) => {
                let mut rows = 0;
                for (tag, animal) in study.carried() {
                    write(&mut Cells::new(out, self.dialect, self.format.absent), tag, animal);
                    out.push(b'\n');
                    rows += 1;
                }
                return Ok(rows);
            }
            Rows::Elements(document) => out.extend_from_slice(document.end.as_bytes()),
            Rows::Table => self.table.take().map_or(Ok(()), |table| table.end(out))?,
            Rows::Detections(_) => {}
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests;
