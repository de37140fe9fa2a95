//! Writes the container: leaders, directories and fields (ISO/IEC 8211:1994, 5.2, 5.3 and 6.2).

use super::error::WriteError;
use crate::iso8211::{FIELD_TERMINATOR, Tag};
use std::fmt::Write as _;

/// Digits of a directory entry's length and position; tags have four letters always.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EntryMap {
    /// As few digits as each record needs: records of one file differ, as real ones do.
    #[default]
    Shortest,
    /// The same digits in all records.
    Fixed {
        /// Digits of a field's length, 1 to 9.
        length: u8,
        /// Digits of a field's position, 1 to 9.
        position: u8,
    },
}

/// One field with its terminator.
pub(super) type FieldBytes = (Tag, Vec<u8>);

/// The first nine bytes after the record length, and the field controls' length.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Description,
    Data,
}

/// Longer records say 0 and are as long as their directory.
const LONGEST_SAID: usize = 99_999;

/// Appends a record.
pub(super) fn push_record(
    file: &mut Vec<u8>,
    kind: Kind,
    map: EntryMap,
    fields: &[FieldBytes],
) -> Result<(), WriteError> {
    let body: usize = fields.iter().map(|(_, bytes)| bytes.len()).sum();
    let longest = fields.iter().map(|(_, bytes)| bytes.len()).max().unwrap_or(0);
    let (length_digits, position_digits) = match map {
        EntryMap::Shortest => (digits(longest), digits(body)),
        EntryMap::Fixed { length, position } => (usize::from(length), usize::from(position)),
    };
    let mut directory = String::new();
    let mut position = 0;
    for (tag, bytes) in fields {
        let needed = [(digits(bytes.len()), length_digits), (digits(position), position_digits)];
        if let Some((digits, _)) = needed.into_iter().find(|(needed, given)| needed > given || *given > 9) {
            return Err(WriteError::EntryMap { tag: *tag, digits });
        }
        // Writing to a text cannot fail.
        let _ = write!(directory, "{tag}{:0length_digits$}{position:0position_digits$}", bytes.len());
        position += bytes.len();
    }
    let base = 24 + directory.len() + 1;
    let length = Some(base + body).filter(|length| *length <= LONGEST_SAID).unwrap_or(0);
    let (identity, controls, sets) = match kind {
        Kind::Description => ("3LE1 ", "09", " ! "),
        Kind::Data => (" D   ", "  ", "   "),
    };
    let leader = format!("{length:05}{identity}{controls}{base:05}{sets}{length_digits}{position_digits}04");
    file.extend(leader.bytes());
    file.extend(directory.bytes());
    file.push(FIELD_TERMINATOR);
    for (_, bytes) in fields {
        file.extend(bytes);
    }
    Ok(())
}

fn digits(number: usize) -> usize {
    number.checked_ilog10().map_or(1, |log| log as usize + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iso8211::Reader;

    fn file(map: EntryMap, body: usize) -> Result<Vec<u8>, WriteError> {
        let mut file = Vec::new();
        let described = b"1600;&   Text\x1fTEXT\x1f(A)\x1e".to_vec();
        push_record(&mut file, Kind::Description, map, &[(Tag(*b"TEXT"), described)])?;
        for _ in 0..2 {
            let mut bytes = vec![b'x'; body];
            bytes.push(FIELD_TERMINATOR);
            push_record(&mut file, Kind::Data, map, &[(Tag(*b"TEXT"), bytes)])?;
        }
        Ok(file)
    }

    #[test]
    fn records_of_every_length_follow_one_another() {
        for body in [0, 9, 98, 99_939, 99_999, 250_000] {
            for map in [EntryMap::Shortest, EntryMap::Fixed { length: 7, position: 3 }] {
                let file = file(map, body).unwrap();
                let mut reader = Reader::new(&file).unwrap();
                for _ in 0..2 {
                    let record = reader.next_record().unwrap().unwrap();
                    assert_eq!(record.field(b"TEXT").unwrap().bytes.len(), body + 1);
                }
                assert!(reader.next_record().unwrap().is_none());
            }
        }
    }

    #[test]
    fn refuses_what_the_entry_map_has_no_digits_for() {
        let error = file(EntryMap::Fixed { length: 2, position: 1 }, 99).unwrap_err();
        assert_eq!(error.to_string(), "field TEXT needs 3 digits in the directory; give the entry map more");
    }
}
