//! A file on its way: one row after another by `research`, or a database.

use super::spool::Bounded;
use super::{GeoPackage, HeardFile};
use research::{About, Heard, Study, Writer};
use std::io::{self, Write};
use std::path::Path;
use store::{DetectionsWanted, TimeRange};

pub(super) enum Making {
    Rows(Box<Writer>),
    Database(Box<GeoPackage>),
}

impl Making {
    /// # Errors
    /// The format needs a place in the data folder, and there is none.
    pub(super) fn new(data: &Path, file: &HeardFile) -> io::Result<Self> {
        if file.format.is_database() {
            return Ok(Self::Database(Box::new(GeoPackage::new(data, file)?)));
        }
        let writer = Writer::new(file.format, file.dialect);
        let writer = if file.format.needs_spool() {
            writer.with_spool(Box::new(Bounded::new(data, file.most_waiting_bytes)?))
        } else {
            writer
        };
        Ok(Self::Rows(Box::new(writer)))
    }

    /// Appends what the file begins with, as far as that can be written yet.
    pub(super) fn header(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        match self {
            Self::Rows(writer) => writer.header(out),
            Self::Database(_) => Ok(()),
        }
    }

    /// Takes a detection; `false` where the format has no row for it.
    pub(super) fn row(&mut self, out: &mut Vec<u8>, heard: &Heard<'_>) -> io::Result<bool> {
        match self {
            Self::Rows(writer) => writer.row(out, heard),
            Self::Database(database) => database.row(heard).map(|()| true),
        }
    }

    /// Takes the tracks of vessels; the error of `goes_on` ends it.
    pub(super) fn tracks(
        &mut self,
        data: &Path,
        wanted: &DetectionsWanted,
        range: TimeRange,
        called: &dyn Fn(u16) -> Option<String>,
        goes_on: &mut dyn FnMut() -> store::Result<()>,
    ) -> store::Result<()> {
        match self {
            Self::Rows(_) => Ok(()),
            Self::Database(database) => database.tracks(data, wanted, range, called, goes_on),
        }
    }

    /// Writes what is left; how many rows of the register that is.
    pub(super) fn end(self, out: &mut dyn Write, study: &Study, about: &About) -> io::Result<u64> {
        match self {
            Self::Rows(mut writer) => writer.end(out, study, about),
            Self::Database(database) => database.end(out, about).map(|()| 0),
        }
    }
}
