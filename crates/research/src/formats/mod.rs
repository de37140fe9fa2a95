//! Detections as files that portals, R packages and people take, one format in one module.
//!
//! Most are CSV. Headers are the formats' own, byte for byte: readers know a file by them. All texts are UTF-8 without a mark, times
//! are UTC, degrees have eight decimals (1 mm). What is not known is absent in the way of the format, never 0.

mod about;
mod actel;
mod cells;
mod columns;
mod darwin_core;
mod etn;
mod fathom;
mod geojson;
mod geopackage;
mod glatos;
mod kml;
mod lutra;
mod movebank;
mod netcdf;
mod otn;
mod parquet;
mod thelma;
mod vue;
mod waiting;
mod yaps;
mod zip;

pub use about::About;
pub use columns::{ColumnKind, DetectionColumn, LUTRA_COLUMNS, Value, values};
pub use netcdf::{TrackOf, write_track};
pub use waiting::Spool;

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
    /// Detections as a Darwin Core archive.
    Archive(darwin_core::Keep),
    /// Detections as points of NetCDF.
    Points,
    /// Detections in a database, which this crate does not write.
    Database,
    /// Animals with their tags.
    Animals(WriteAnimal),
}

/// Writes the row of an animal and its tag.
type WriteAnimal = fn(&mut Cells<'_>, &api::RegisterTag, &api::RegisterAnimal);

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
pub const FORMATS: [Format; 20] = [
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
    darwin_core::HOURLY,
    darwin_core::EVERY,
    geojson::FORMAT,
    kml::FORMAT,
    geopackage::FORMAT,
    parquet::FORMAT,
    netcdf::FORMAT,
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
        format!("`{shown}` is not a format; there are {}", names.join(", "))
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
            Rows::Archive(_) => "zip",
            Rows::Points => "nc",
            Rows::Database => "gpkg",
        }
    }

    /// Its media type.
    pub const fn media(&self) -> &'static str {
        match self.rows {
            Rows::Detections(_) | Rows::Animals(_) => "text/csv; charset=utf-8",
            Rows::Elements(document) => document.media,
            Rows::Table => parquetfile::MEDIA,
            Rows::Archive(_) => "application/zip",
            Rows::Points => "application/x-netcdf",
            Rows::Database => "application/geopackage+sqlite3",
        }
    }

    /// Whether its writer needs a [`Spool`].
    pub const fn needs_spool(&self) -> bool {
        matches!(self.rows, Rows::Archive(_) | Rows::Points)
    }

    /// Whether it is a database, GeoPackage, which a [`Writer`] does not write: who has files writes it by [`values`].
    pub const fn is_database(&self) -> bool {
        matches!(self.rows, Rows::Database)
    }
}

/// Writes one file.
#[derive(Debug)]
pub struct Writer {
    format: Format,
    dialect: Dialect,
    /// Whether an element is there already.
    is_begun: bool,
    /// Where bytes wait, until the header takes it.
    spool: Option<Box<dyn Spool>>,
    made: Made,
}

/// What is on its way into a file that is more than one row after another.
#[derive(Debug)]
enum Made {
    Nothing,
    Table(Box<parquet::Table>),
    Archive(Box<darwin_core::Archive>),
    Points(Box<netcdf::Points>),
}

impl Writer {
    /// Of this format; all but [`LUTRA`] know the plain dialect only.
    pub fn new(format: Format, dialect: Dialect) -> Self {
        Self { format, dialect, is_begun: false, spool: None, made: Made::Nothing }
    }

    /// With a place for what waits, for a format that [`Format::needs_spool`].
    #[must_use]
    pub fn with_spool(self, spool: Box<dyn Spool>) -> Self {
        Self { spool: Some(spool), ..self }
    }

    /// Appends what a file begins with.
    ///
    /// # Errors
    /// The writer of the format fails, or it needs a spool and has none, or the format is a database.
    pub fn header(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        out.extend_from_slice(self.dialect.mark());
        match self.format.rows {
            Rows::Table => {
                let mut table = Box::new(parquet::Table::new()?);
                table.drain(out)?;
                self.made = Made::Table(table);
            }
            Rows::Archive(keep) => {
                let archive = darwin_core::Archive::new(keep, self.spool.take(), out)?;
                self.made = Made::Archive(Box::new(archive));
            }
            Rows::Points => self.made = Made::Points(Box::new(netcdf::Points::new(self.spool.take())?)),
            Rows::Database => {
                return Err(io::Error::other("a database is not written one row after another"));
            }
            _ if self.format.name == LUTRA.name => lutra::header(out, self.dialect),
            _ => out.extend_from_slice(self.format.header.as_bytes()),
        }
        Ok(())
    }

    /// Appends the row of a detection, or what is ready of the rows so far; `false` where the format has none for it, or not one more.
    ///
    /// # Errors
    /// As [`Self::header()`], or where bytes wait is full.
    pub fn row(&mut self, out: &mut Vec<u8>, heard: &Heard<'_>) -> io::Result<bool> {
        match &mut self.made {
            Made::Table(table) => {
                table.row(heard)?;
                table.drain(out)?;
                return Ok(true);
            }
            Made::Archive(archive) => return archive.row(out, heard),
            Made::Points(points) => return points.row(heard),
            Made::Nothing => {}
        }
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
            _ => Ok(false),
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

    /// Writes what a file ends with: the rows of one that is of the register alone, of others their last lines, or all that waited. How
    /// many rows of the register. What the file says of itself is of `about`.
    ///
    /// # Errors
    /// As [`Self::row()`], or `out` cannot be written.
    pub fn end(&mut self, out: &mut dyn io::Write, study: &Study, about: &About) -> io::Result<u64> {
        match std::mem::replace(&mut self.made, Made::Nothing) {
            Made::Table(table) => table.end(out)?,
            Made::Archive(archive) => archive.end(out, about)?,
            Made::Points(points) => points.end(out, about)?,
            Made::Nothing => {}
        }
        match self.format.rows {
            Rows::Animals(write) => self.animals(write, out, study),
            Rows::Elements(document) => out.write_all(document.end.as_bytes()).map(|()| 0),
            _ => Ok(0),
        }
    }

    fn animals(&self, write: WriteAnimal, out: &mut dyn io::Write, study: &Study) -> io::Result<u64> {
        let mut rows = 0;
        for (tag, animal) in study.carried() {
            let mut row = Vec::new();
            write(&mut Cells::new(&mut row, self.dialect, self.format.absent), tag, animal);
            row.push(b'\n');
            out.write_all(&row)?;
            rows += 1;
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) use zip::tests::unzipped;
