//! Records of a file and the fields in them.

use super::definition::{FieldDefinition, parse_definitions};
use super::error::{Iso8211Error, Iso8211Problem};
use super::leader::{LEADER_BYTES, Leader, decimal};
use super::row::{LexicalLevel, Rows};
use super::{FIELD_TERMINATOR, UNIT_TERMINATOR};
use std::collections::BTreeMap;
use std::fmt;

/// The name of a field.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tag(pub [u8; 4]);

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{}", byte.escape_ascii()))
    }
}

impl fmt::Debug for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// One field of a record.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// Its name.
    pub tag: Tag,
    /// Its bytes, terminator included.
    pub bytes: &'a [u8],
    /// Where it starts in the file.
    pub offset: usize,
}

/// One record of a file.
#[derive(Debug, Clone)]
pub struct Record<'a> {
    /// Which one, counted from 0 (the data descriptive record).
    pub number: usize,
    /// Where it starts in the file.
    pub offset: usize,
    /// Its fields in the order of the directory.
    pub fields: Vec<Field<'a>>,
    length: usize,
    control_length: usize,
}

impl<'a> Record<'a> {
    fn parse(file: &'a [u8], offset: usize, number: usize) -> Result<Self, Iso8211Error> {
        let leader = Leader::parse(file, offset, number)?;
        let fail = |at: usize, problem| Iso8211Error { record: number, offset: at, problem };
        let directory = &file[offset + LEADER_BYTES..offset + leader.base];
        let Some((&FIELD_TERMINATOR, entries)) = directory.split_last() else {
            return Err(fail(offset + leader.base - 1, Iso8211Problem::Directory));
        };
        if entries.len() % leader.entry.bytes() != 0 {
            return Err(fail(offset + leader.base - 1, Iso8211Problem::Directory));
        }
        let limit = if leader.length == 0 { file.len() - offset } else { leader.length };
        let mut end = leader.base;
        let mut fields = Vec::with_capacity(entries.len() / leader.entry.bytes());
        for (at, entry) in entries.chunks_exact(leader.entry.bytes()).enumerate() {
            let entry_offset = offset + LEADER_BYTES + at * leader.entry.bytes();
            let (tag, rest) = entry.split_at(4);
            let tag = Tag([tag[0], tag[1], tag[2], tag[3]]);
            let (length, position) = rest.split_at(leader.entry.length);
            let length =
                decimal(length).ok_or_else(|| fail(entry_offset, Iso8211Problem::Number("field length")))?;
            let position = decimal(position)
                .ok_or_else(|| fail(entry_offset, Iso8211Problem::Number("field position")))?;
            let from = leader.base + position;
            if length == 0 || from + length > limit {
                return Err(fail(entry_offset, Iso8211Problem::FieldExtent { tag, length, position }));
            }
            end = end.max(from + length);
            let from = offset + from;
            fields.push(Field { tag, bytes: &file[from..from + length], offset: from });
        }
        // A record too long for the five digits of its leader is as long as its directory says.
        let length = if leader.length == 0 { end } else { leader.length };
        Ok(Self { number, offset, fields, length, control_length: leader.control_length })
    }

    /// The first field of that name.
    pub fn field(&self, tag: &[u8; 4]) -> Option<Field<'a>> {
        self.fields.iter().copied().find(|field| &field.tag.0 == tag)
    }

    /// A fault at this record's start.
    pub fn error(&self, problem: Iso8211Problem) -> Iso8211Error {
        Iso8211Error { record: self.number, offset: self.offset, problem }
    }
}

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
    /// When the bytes do not begin with one, or it describes a field in a way that is no format.
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

/// Splits at unit terminators; what follows the last one is the last part.
pub(super) fn units(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|byte| *byte == UNIT_TERMINATOR)
}
