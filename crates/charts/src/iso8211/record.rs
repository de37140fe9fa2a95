//! A record and the fields in it.

use super::FIELD_TERMINATOR;
use super::error::{Iso8211Error, Iso8211Problem};
use super::leader::{LEADER_BYTES, Leader, decimal};
use super::tag::Tag;

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
    pub(super) length: usize,
    pub(super) control_length: usize,
}

impl<'a> Record<'a> {
    pub(super) fn parse(file: &'a [u8], offset: usize, number: usize) -> Result<Self, Iso8211Error> {
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
