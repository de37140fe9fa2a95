//! The subfields of a field, row by row.

use super::UNIT_TERMINATOR;
use super::definition::{FieldDefinition, Format};
use super::error::{Iso8211Error, Iso8211Problem};

/// In which characters a text field is written (S-57 part 3, 2.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum LexicalLevel {
    /// Level 0: ASCII.
    #[default]
    Ascii,
    /// Level 1: ISO 8859-1.
    Latin1,
    /// Level 2: UCS-2, least significant byte first; terminators are two bytes.
    Ucs2,
}

impl LexicalLevel {
    /// The text of some bytes. Level 0 is read as level 1, of which it is a part; a half surrogate becomes �.
    pub fn decode(self, bytes: &[u8]) -> String {
        match self {
            Self::Ascii | Self::Latin1 => bytes.iter().map(|byte| char::from(*byte)).collect(),
            Self::Ucs2 => {
                let units = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
                let units = units.skip_while(|unit| *unit == 0xFEFF);
                char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
            }
        }
    }
}

/// One subfield's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Text, in the field's lexical level.
    Text(&'a [u8]),
    /// An integer; `None` where digits should stand and blanks do.
    Integer(Option<i64>),
    /// A real number; `None` where digits should stand and blanks do.
    Real(Option<f64>),
    /// Bytes as they are.
    Bits(&'a [u8]),
}

impl<'a> Value<'a> {
    /// The integer, if it is one.
    pub fn integer(self) -> Option<i64> {
        if let Self::Integer(value) = self { value } else { None }
    }

    /// The number, if it is one.
    pub fn real(self) -> Option<f64> {
        match self {
            Self::Real(value) => value,
            Self::Integer(value) => value.map(|value| value as f64),
            Self::Text(_) | Self::Bits(_) => None,
        }
    }

    /// The bytes of a text or bit string.
    pub fn bytes(self) -> &'a [u8] {
        match self {
            Self::Text(bytes) | Self::Bits(bytes) => bytes,
            Self::Integer(_) | Self::Real(_) => &[],
        }
    }
}

/// Walks the rows of one field. A field that does not repeat has one.
#[derive(Debug, Clone)]
pub struct Rows<'a, 'd> {
    definition: &'d FieldDefinition,
    body: &'a [u8],
    at: usize,
    level: LexicalLevel,
    record: usize,
    offset: usize,
    done: bool,
}

impl<'a, 'd> Rows<'a, 'd> {
    pub(super) fn new(
        definition: &'d FieldDefinition,
        body: &'a [u8],
        level: LexicalLevel,
        record: usize,
        offset: usize,
    ) -> Self {
        // A repeating group may repeat no times; a field of single values has them even if all are empty.
        let done = definition.repeats && body.is_empty();
        Self { definition, body, at: 0, level, record, offset, done }
    }

    /// Fills `row` with the next row's values; false after the last row.
    ///
    /// # Errors
    /// When the field ends inside the row or a number is not one.
    pub fn next_into(&mut self, row: &mut Vec<Value<'a>>) -> Result<bool, Iso8211Error> {
        row.clear();
        if self.done {
            return Ok(false);
        }
        let definition = self.definition;
        for subfield in &definition.subfields {
            let value = self.value(subfield.format).map_err(|number| {
                let (tag, label) = (definition.tag, subfield.label.clone());
                let problem = if number {
                    Iso8211Problem::Subfield { tag, label }
                } else {
                    Iso8211Problem::Short { tag, label }
                };
                Iso8211Error { record: self.record, offset: self.offset + self.at, problem }
            })?;
            row.push(value);
        }
        self.done = !definition.repeats || self.at >= self.body.len();
        Ok(true)
    }

    /// The error says whether it is about a number (true) or about the end of the field.
    fn value(&mut self, format: Format) -> Result<Value<'a>, bool> {
        match format {
            Format::Unsigned(width) => {
                let bytes = self.take(width)?;
                let value = bytes.iter().rev().fold(0_i64, |sum, byte| (sum << 8) | i64::from(*byte));
                Ok(Value::Integer(Some(value)))
            }
            Format::Signed(width) => {
                let bytes = self.take(width)?;
                let value = bytes.iter().rev().fold(0_i64, |sum, byte| (sum << 8) | i64::from(*byte));
                let unused = 64 - 8 * width as u32;
                Ok(Value::Integer(Some((value << unused) >> unused)))
            }
            Format::Bits(width) => Ok(Value::Bits(self.take(width)?)),
            Format::Text(width) => Ok(Value::Text(self.text(width)?)),
            Format::Integer(width) => number(self.text(width)?).map(Value::Integer),
            Format::Real(width) => number(self.text(width)?).map(Value::Real),
        }
    }

    fn take(&mut self, width: usize) -> Result<&'a [u8], bool> {
        let bytes = self.body.get(self.at..self.at + width).ok_or(false)?;
        self.at += width;
        Ok(bytes)
    }

    fn text(&mut self, width: Option<usize>) -> Result<&'a [u8], bool> {
        if let Some(width) = width {
            return self.take(width);
        }
        let rest = self.body.get(self.at..).ok_or(false)?;
        let (end, terminator) = match self.level {
            LexicalLevel::Ascii | LexicalLevel::Latin1 => {
                (rest.iter().position(|byte| *byte == UNIT_TERMINATOR), 1)
            }
            LexicalLevel::Ucs2 => {
                let pairs = rest.chunks_exact(2);
                let end = pairs.into_iter().position(|pair| pair == [UNIT_TERMINATOR, 0]);
                (end.map(|pairs| pairs * 2), 2)
            }
        };
        // The last text of a field may end with the field.
        let end = end.unwrap_or(rest.len());
        self.at += (end + terminator).min(rest.len());
        Ok(&rest[..end])
    }
}

fn number<T: std::str::FromStr>(text: &[u8]) -> Result<Option<T>, bool> {
    let text = std::str::from_utf8(text).map_err(|_| true)?.trim();
    if text.is_empty() { Ok(None) } else { text.parse().map(Some).map_err(|_| true) }
}
