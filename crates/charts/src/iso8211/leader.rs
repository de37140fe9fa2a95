//! The 24 bytes before every record.

use super::error::{Iso8211Error, Iso8211Problem};

/// Bytes of a leader.
pub(super) const LEADER_BYTES: usize = 24;

/// A record's leader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leader {
    /// Length of the record; 0 = longer than five digits can say.
    pub(super) length: usize,
    /// `L` or `D`.
    pub(super) identifier: u8,
    /// Where the fields begin.
    pub(super) base: usize,
    /// Length of the field controls in the DDR.
    pub(super) control_length: usize,
    pub(super) entry: EntryMap,
}

/// Digits of the three parts of a directory entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryMap {
    pub(super) length: usize,
    pub(super) position: usize,
    pub(super) tag: usize,
}

impl EntryMap {
    pub(super) fn bytes(self) -> usize {
        self.length + self.position + self.tag
    }
}

impl Leader {
    /// The leader at `offset` of `file`.
    pub(super) fn parse(file: &[u8], offset: usize, record: usize) -> Result<Self, Iso8211Error> {
        let fail = |at: usize, problem| Iso8211Error { record, offset: offset + at, problem };
        let left = file.len().saturating_sub(offset);
        let bytes = file.get(offset..offset + LEADER_BYTES).ok_or_else(|| {
            fail(0, Iso8211Problem::Extent { length: LEADER_BYTES, base: LEADER_BYTES, left })
        })?;
        let number = |from: usize, to: usize, what| {
            decimal(&bytes[from..to]).ok_or_else(|| fail(from, Iso8211Problem::Number(what)))
        };
        // The identifier is checked first, so that a picture or a zip file is recognised as such.
        let identifier = bytes[6];
        if record == 0 && identifier != b'L' {
            return Err(fail(6, Iso8211Problem::NotADescription(char::from(identifier))));
        }
        if record > 0 && identifier != b'D' {
            return Err(fail(6, Iso8211Problem::NotData(char::from(identifier))));
        }
        let length = number(0, 5, "record length")?;
        let base = number(12, 17, "base address")?;
        let entry = EntryMap {
            length: number(20, 21, "entry map")?,
            position: number(21, 22, "entry map")?,
            tag: number(23, 24, "entry map")?,
        };
        if entry.length == 0 || entry.position == 0 || entry.tag != 4 {
            let EntryMap { length, position, tag } = entry;
            return Err(fail(20, Iso8211Problem::EntryMap { length, position, tag }));
        }
        let impossible =
            base <= LEADER_BYTES || base > left || (length != 0 && (length < base || length > left));
        if impossible {
            return Err(fail(0, Iso8211Problem::Extent { length, base, left }));
        }
        let control_length = if record == 0 { number(10, 12, "field control length")? } else { 0 };
        Ok(Self { length, identifier, base, control_length, entry })
    }
}

/// A decimal number of up to nine digits; blanks may stand before it.
pub(super) fn decimal(digits: &[u8]) -> Option<usize> {
    let digits = digits.trim_ascii_start();
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    digits
        .iter()
        .try_fold(0_usize, |sum, digit| digit.is_ascii_digit().then(|| sum * 10 + usize::from(digit - b'0')))
}
