//! The header of a NetCDF file of the classic format, with offsets of 32 or 64 bits (CDF-1, CDF-2).
//!
//! By the format's specification in the NetCDF user's guide, appendix B. Numbers are big-endian; names and values are
//! filled up to four bytes. No count is believed before its bytes are there.

use super::CurrentsError;

/// Most dimensions, variables and attributes in one list.
const MOST_IN_LIST: usize = 2_000;
/// The number of records of a file that was still being written.
const STREAMING: usize = 0xFFFF_FFFF;

/// The type of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Byte,
    Char,
    Short,
    Int,
    Float,
    Double,
}

impl Kind {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Byte | Self::Char => 1,
            Self::Short => 2,
            Self::Int | Self::Float => 4,
            Self::Double => 8,
        }
    }

    /// The number in so many bytes as it has.
    pub(super) fn number(self, bytes: &[u8]) -> f64 {
        let wide = bytes.iter().fold(0_u64, |wide, byte| wide << 8 | u64::from(*byte));
        match self {
            Self::Byte | Self::Char => f64::from(wide as u8 as i8),
            Self::Short => f64::from(wide as u16 as i16),
            Self::Int => f64::from(wide as u32 as i32),
            Self::Float => f64::from(f32::from_bits(wide as u32)),
            Self::Double => f64::from_bits(wide),
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Attribute {
    Text(String),
    Number(f64),
}

pub(super) type Attributes = Vec<(String, Attribute)>;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Numbers of its dimensions, the slowest first.
    pub(super) dimensions: Vec<usize>,
    pub(super) attributes: Attributes,
    pub(super) kind: Kind,
    /// Where its values begin.
    pub(super) begin: usize,
}

impl Variable {
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find_map(|(found, value)| match value {
            Attribute::Text(text) if found == name => Some(text.as_str()),
            _ => None,
        })
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.attributes.iter().find_map(|(found, value)| match value {
            Attribute::Number(number) if found == name => Some(*number),
            _ => None,
        })
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dimension {
    pub(super) name: String,
    /// Its length; of the dimension of records their number.
    pub(super) length: usize,
    pub(super) of_records: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) dimensions: Vec<Dimension>,
    pub(super) variables: Vec<Variable>,
    /// Bytes from one record to the next.
    pub(super) record_bytes: usize,
}

struct Reader<'b> {
    bytes: &'b [u8],
    at: usize,
    wide: bool,
}

pub(super) fn wrong(what: impl Into<String>) -> CurrentsError {
    CurrentsError::NetCdf(what.into())
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self, CurrentsError> {
        let wide = match bytes.get(..4) {
            Some(b"CDF\x01") => false,
            Some(b"CDF\x02") => true,
            _ => {
                return Err(wrong(
                    "this is NetCDF-4 or CDF-5; the classic format is read: convert it by `nccopy -k classic IN OUT`",
                ));
            }
        };
        let mut reader = Reader { bytes, at: 4, wide };
        let records = reader.word()?;
        let dimensions = reader.list(0x0A, |reader| {
            let (name, length) = (reader.name()?, reader.word()?);
            Ok(Dimension { name, length, of_records: length == 0 })
        })?;
        let _ = reader.attributes()?;
        let variables = reader.list(0x0B, Reader::variable)?;
        let mut header = Self { dimensions, variables, record_bytes: 0 };
        for variable in &header.variables {
            if variable.dimensions.iter().any(|number| *number >= header.dimensions.len()) {
                return Err(wrong(format!(
                    "the variable {} has a dimension that is not there",
                    variable.name
                )));
            }
        }
        let mut record_bytes = 0_usize;
        let of_records: Vec<&Variable> =
            header.variables.iter().filter(|one| header.is_of_records(one)).collect();
        for variable in &of_records {
            let bytes = header.values_at_once(variable).saturating_mul(variable.kind.bytes());
            // Of a single variable the format fills nothing up.
            let filled = if of_records.len() > 1 { bytes.saturating_add(3) & !3 } else { bytes };
            record_bytes = record_bytes.saturating_add(filled);
        }
        let first = of_records.iter().map(|variable| variable.begin).min();
        header.record_bytes = record_bytes;
        let records = match first {
            Some(first) if records == STREAMING && record_bytes > 0 => {
                bytes.len().saturating_sub(first) / record_bytes
            }
            _ => records,
        };
        for dimension in header.dimensions.iter_mut().filter(|dimension| dimension.of_records) {
            dimension.length = records;
        }
        Ok(header)
    }

    pub(super) fn is_of_records(&self, variable: &Variable) -> bool {
        variable.dimensions.first().is_some_and(|first| self.dimensions[*first].of_records)
    }

    /// How many values of a variable stand together: in each record, or all.
    pub(super) fn values_at_once(&self, variable: &Variable) -> usize {
        let lengths = variable.dimensions.iter().map(|number| &self.dimensions[*number]);
        let lengths = lengths.filter(|dimension| !dimension.of_records).map(|dimension| dimension.length);
        lengths.fold(1, usize::saturating_mul)
    }
}

impl Reader<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], CurrentsError> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| wrong("the file ends within its header; fetch it again"))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn word(&mut self) -> Result<usize, CurrentsError> {
        let word = self.take(4)?;
        Ok(word.iter().fold(0, |word, byte| word << 8 | usize::from(*byte)))
    }

    fn filled(&mut self, count: usize) -> Result<&[u8], CurrentsError> {
        let whole = count.checked_add(3).ok_or_else(|| wrong("a length is out of range"))? & !3;
        Ok(&self.take(whole)?[..count])
    }

    fn name(&mut self) -> Result<String, CurrentsError> {
        let length = self.word()?;
        Ok(String::from_utf8_lossy(self.filled(length)?).into_owned())
    }

    fn list<T>(
        &mut self,
        tag: usize,
        mut one: impl FnMut(&mut Self) -> Result<T, CurrentsError>,
    ) -> Result<Vec<T>, CurrentsError> {
        let (found, count) = (self.word()?, self.word()?);
        if found != tag && (found, count) != (0, 0) {
            return Err(wrong("its header is damaged; fetch it again"));
        }
        if count > MOST_IN_LIST {
            return Err(wrong(format!("its header has a list of {count}; {MOST_IN_LIST} at most are read")));
        }
        (0..count).map(|_| one(self)).collect()
    }

    fn kind(&mut self) -> Result<Kind, CurrentsError> {
        Ok(match self.word()? {
            1 => Kind::Byte,
            2 => Kind::Char,
            3 => Kind::Short,
            4 => Kind::Int,
            5 => Kind::Float,
            6 => Kind::Double,
            other => return Err(wrong(format!("its header has the unknown type {other}"))),
        })
    }

    /// Of numbers the first is kept.
    fn attributes(&mut self) -> Result<Attributes, CurrentsError> {
        self.list(0x0C, |reader| {
            let (name, kind, count) = (reader.name()?, reader.kind()?, reader.word()?);
            let size = count.checked_mul(kind.bytes()).ok_or_else(|| wrong("a length is out of range"))?;
            let bytes = reader.filled(size)?;
            let value = if kind == Kind::Char {
                Attribute::Text(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned())
            } else {
                Attribute::Number(bytes.get(..kind.bytes()).map_or(f64::NAN, |bytes| kind.number(bytes)))
            };
            Ok((name, value))
        })
    }

    fn variable(&mut self) -> Result<Variable, CurrentsError> {
        let (name, count) = (self.name()?, self.word()?);
        if count > MOST_IN_LIST {
            return Err(wrong(format!("the variable {name} has {count} dimensions")));
        }
        let dimensions = (0..count).map(|_| self.word()).collect::<Result<_, _>>()?;
        let (attributes, kind) = (self.attributes()?, self.kind()?);
        // The size that follows is too small a number for large variables: dimensions say it.
        let _ = self.word()?;
        let begin = if self.wide { self.word()? << 32 | self.word()? } else { self.word()? };
        Ok(Variable { name, dimensions, attributes, kind, begin })
    }
}
