//! Reads a file record by record.

use super::FIELD_TERMINATOR;
use super::definition::{FieldDefinition, parse_definitions};
use super::error::{Iso8211Error, Iso8211Problem};
use super::record::{Field, Record};
use super::row::{LexicalLevel, Rows};
use super::tag::Tag;
use std::collections::BTreeMap;

/// Reads a file record by record. After an error it gives no more.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    file: &'a [u8],
    definitions: BTreeMap<Tag, FieldDefinition>,
    next_offset: usize,
    next_number: usize,
}

impl<'a> Reader<'a> {
    /// Reads the data descriptive record.
    ///
    /// # Errors
    /// When the bytes do not begin with one, or it describes a field in a way that is not a format.
    pub fn new(file: &'a [u8]) -> Result<Self, Iso8211Error> {
        if file.is_empty() {
            return Err(Iso8211Error { record: 0, offset: 0, problem: Iso8211Problem::Empty });
        }
        let record = Record::parse(file, 0, 0)?;
        let definitions = parse_definitions(&record, record.control_length)?;
        Ok(Self { file, definitions, next_offset: record.length, next_number: 1 })
    }

    /// How a field is written, if the head of the file says so.
    pub fn definition(&self, tag: &[u8; 4]) -> Option<&FieldDefinition> {
        self.definitions.get(&Tag(*tag))
    }

    /// The next record; `None` at the end of the file.
    ///
    /// # Errors
    /// When the record is damaged; there is no way to find the one after it.
    pub fn next_record(&mut self) -> Result<Option<Record<'a>>, Iso8211Error> {
        let rest = self.file.get(self.next_offset..).unwrap_or_default();
        // Some producers fill the last block with blanks or zeros.
        if rest.iter().all(|byte| matches!(byte, b' ' | 0 | b'^')) {
            return Ok(None);
        }
        match Record::parse(self.file, self.next_offset, self.next_number) {
            Ok(record) => {
                self.next_offset += record.length;
                self.next_number += 1;
                Ok(Some(record))
            }
            Err(error) => {
                self.next_offset = self.file.len();
                Err(error)
            }
        }
    }

    /// The rows of a field by its definition.
    ///
    /// # Errors
    /// When the field is not described or does not end in a terminator.
    pub fn rows(
        &self,
        record: &Record<'a>,
        field: Field<'a>,
        level: LexicalLevel,
    ) -> Result<Rows<'a, '_>, Iso8211Error> {
        let fail = |problem| Iso8211Error { record: record.number, offset: field.offset, problem };
        let definition =
            self.definitions.get(&field.tag).ok_or_else(|| fail(Iso8211Problem::Undescribed(field.tag)))?;
        let body = match (level, field.bytes) {
            (LexicalLevel::Ucs2, [body @ .., FIELD_TERMINATOR, 0]) | (_, [body @ .., FIELD_TERMINATOR]) => {
                Some(body)
            }
            _ => None,
        };
        let body = body.ok_or_else(|| fail(Iso8211Problem::Unterminated(field.tag)))?;
        Ok(Rows::new(definition, body, level, record.number, field.offset))
    }
}
