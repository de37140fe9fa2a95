//! Files of NetCDF's classic format with offsets of 64 bits (CDF-2): a header, variables of a fixed size, then records one after another.
//!
//! Own code that writes records as they come, without the C library that the crate `netcdf` links. By the format's specification in the NetCDF user's guide, appendix B. All numbers are big-endian; names, texts and the values of each
//! variable in a record are filled up to four bytes.

use std::io::{self, Write};

const DIMENSIONS: u32 = 0x0A;
const VARIABLES: u32 = 0x0B;
const ATTRIBUTES: u32 = 0x0C;

/// An attribute of a variable or of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Attribute {
    Text(String),
    Double(f64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

pub(super) type Attributes = Vec<(&'static str, Attribute)>;

/// Of what type values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Text of so many bytes, filled up with zeros; the dimension of its letters is the variable's own.
    Text(u32),
    Double,
    Int,
}

impl Kind {
    fn code(self) -> u32 {
        match self {
            Self::Text(_) => 2,
            Self::Int => 4,
            Self::Double => 6,
        }
    }

    /// Bytes of one value.
    pub(super) fn bytes(self) -> u32 {
        match self {
            Self::Text(bytes) => bytes,
            Self::Int => 4,
            Self::Double => 8,
        }
    }
}

/// Over what a variable reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Over {
    /// One value.
    Nothing,
    /// A value in each record.
    Records,
}

#[derive(Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) over: Over,
    pub(super) attributes: Attributes,
    /// The values of one that is not of records.
    pub(super) values: Vec<u8>,
}

/// What a file is, before its records.
#[derive(Debug)]
pub(super) struct Classic {
    /// The dimension of records, and how many there are.
    pub(super) records: (&'static str, u32),
    pub(super) attributes: Attributes,
    /// At least two of records: of a single one the format fills nothing up.
    pub(super) variables: Vec<Variable>,
}

impl Classic {
    /// Writes all that stands before the records.
    ///
    /// # Errors
    /// `out` cannot be written.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        // Offsets have one length, so that the header has it too, whatever they are.
        let begins = u64::from(length(&self.header(0)));
        out.write_all(&self.header(begins))?;
        for variable in self.variables.iter().filter(|one| one.over != Over::Records) {
            let mut values = variable.values.clone();
            fill(&mut values);
            out.write_all(&values)?;
        }
        Ok(())
    }

    fn header(&self, begins: u64) -> Vec<u8> {
        let mut out = b"CDF\x02".to_vec();
        word(&mut out, self.records.1);
        let texts = self.variables.iter().filter_map(|one| match one.kind {
            Kind::Text(bytes) => Some((format!("{}_strlen", one.name), bytes)),
            _ => None,
        });
        let dimensions: Vec<(String, u32)> =
            std::iter::once((self.records.0.to_owned(), 0)).chain(texts).collect();
        list(&mut out, DIMENSIONS, dimensions.len());
        for (dimension, length) in &dimensions {
            name(&mut out, dimension);
            word(&mut out, *length);
        }
        attributes(&mut out, &self.attributes);
        self.variables(&mut out, begins);
        out
    }

    fn variables(&self, out: &mut Vec<u8>, begins: u64) {
        list(out, VARIABLES, self.variables.len());
        let of_fixed: u64 = self.variables.iter().filter(|one| one.over != Over::Records).map(size).sum();
        let (mut fixed, mut records) = (begins, begins + of_fixed);
        let mut letters = 1;
        for variable in &self.variables {
            name(out, &variable.name);
            let mut over: Vec<usize> = match variable.over {
                Over::Nothing => Vec::new(),
                Over::Records => vec![0],
            };
            if let Kind::Text(_) = variable.kind {
                over.push(letters);
                letters += 1;
            }
            word(out, over.len() as u32);
            for dimension in over {
                word(out, dimension as u32);
            }
            attributes(out, &variable.attributes);
            word(out, variable.kind.code());
            let size = size(variable);
            word(out, size as u32);
            let at = if variable.over == Over::Records { &mut records } else { &mut fixed };
            out.extend_from_slice(&at.to_be_bytes());
            *at += size;
        }
    }
}

/// Bytes of a variable, of one of records in each, filled up.
fn size(variable: &Variable) -> u64 {
    u64::from(variable.kind.bytes()).next_multiple_of(4)
}

fn length(bytes: &[u8]) -> u32 {
    u32::try_from(bytes.len()).unwrap_or(u32::MAX)
}

fn word(out: &mut Vec<u8>, value: u32) {
    out.extend_from_slice(&value.to_be_bytes());
}

/// The begin of a list; one without an element has two zeros instead.
fn list(out: &mut Vec<u8>, tag: u32, elements: usize) {
    word(out, if elements == 0 { 0 } else { tag });
    word(out, elements as u32);
}

fn name(out: &mut Vec<u8>, text: &str) {
    word(out, length(text.as_bytes()));
    out.extend_from_slice(text.as_bytes());
    fill(out);
}

fn attributes(out: &mut Vec<u8>, all: &[(&str, Attribute)]) {
    list(out, ATTRIBUTES, all.len());
    for (called, value) in all {
        name(out, called);
        match value {
            Attribute::Text(text) => {
                word(out, Kind::Text(0).code());
                name(out, text);
            }
            Attribute::Double(value) => {
                word(out, Kind::Double.code());
                word(out, 1);
                out.extend_from_slice(&value.to_be_bytes());
            }
        }
    }
}

/// Fills up to four bytes. What is filled begins at a multiple of four, as all before it is filled too.
pub(super) fn fill(out: &mut Vec<u8>) {
    out.resize(out.len().next_multiple_of(4), 0);
}
