//! The list of files in an exchange set: CATALOG.031 (S-57 part 3, 7.2; appendix B.1, 5.6.1).

use super::error::S57Error;
use super::fields::container;
use crate::iso8211::{Iso8211Problem, LexicalLevel, Reader, Value};

/// One file of an exchange set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CatalogueEntry {
    /// Path in the exchange set, with the separators of the file.
    pub file: String,
    /// Long name.
    pub long_name: String,
    /// Volume.
    pub volume: String,
    /// `ASC`, `BIN`, `TXT` ...
    pub implementation: String,
    /// South, west, north and east limits (degrees), where given.
    pub limits_deg: Option<[f64; 4]>,
    /// Checksum, where given.
    pub crc32: Option<u32>,
    /// Comment.
    pub comment: String,
}

/// A catalogue file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Catalogue {
    /// Its files in order.
    pub entries: Vec<CatalogueEntry>,
}

impl Catalogue {
    /// Reads a catalogue file.
    ///
    /// # Errors
    /// When the bytes are not an ISO 8211 file or a record is damaged.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, S57Error> {
        Self::read_container(bytes).map_err(|error| container(file, error))
    }

    fn read_container(bytes: &[u8]) -> Result<Self, crate::iso8211::Iso8211Error> {
        let mut reader = Reader::new(bytes)?;
        let mut entries = Vec::new();
        let mut row = Vec::new();
        while let Some(record) = reader.next_record()? {
            let Some(field) = record.field(b"CATD") else { continue };
            let Some(definition) = reader.definition(b"CATD") else {
                return Err(record.error(Iso8211Problem::Undescribed(field.tag)));
            };
            let mut rows = reader.rows(&record, field, LexicalLevel::Latin1)?;
            while rows.next_into(&mut row)? {
                let value = |label: &str| definition.labels().position(|one| one == label).map(|at| row[at]);
                entries.push(entry(value));
            }
        }
        Ok(Self { entries })
    }
}

fn entry<'a>(value: impl Fn(&str) -> Option<Value<'a>>) -> CatalogueEntry {
    let text = |label| {
        let bytes = value(label).map_or(&[][..], Value::bytes);
        LexicalLevel::Latin1.decode(bytes).trim().to_owned()
    };
    let degrees = |label| value(label).and_then(Value::real);
    let limits = (degrees("SLAT"), degrees("WLON"), degrees("NLAT"), degrees("ELON"));
    CatalogueEntry {
        file: text("FILE"),
        long_name: text("LFIL"),
        volume: text("VOLM"),
        implementation: text("IMPL"),
        limits_deg: if let (Some(s), Some(w), Some(n), Some(e)) = limits { Some([s, w, n, e]) } else { None },
        crc32: u32::from_str_radix(&text("CRCS"), 16).ok(),
        comment: text("COMT"),
    }
}
