//! Puts records into fields, subfield by subfield: what `fields` reads.

use super::container::FieldBytes;
use super::error::WriteError;
use crate::iso8211::{FIELD_TERMINATOR, LexicalLevel, Tag, UNIT_TERMINATOR};
use crate::s57::feature::{Attribute, LinkRole, ObjectId};
use crate::s57::records::{
    Control, DatasetId, DatasetParameters, DatasetStructure, Edits, FeatureRecord, Instruction, Link, Name,
    Pointer, VectorRecord,
};

const ASCII: LexicalLevel = LexicalLevel::Ascii;
/// RCNM of a feature record.
const FEATURE: u8 = 100;
/// Orientation, usage, topology or mask does not apply.
const NULL: u8 = 255;

/// Units of measurement as codes (S-57 part 3, 3.2): what a reader of metres and degrees must check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeasureUnits {
    /// Of depths: 1 metres.
    pub depth: u8,
    /// Of heights: 1 metres.
    pub height: u8,
    /// Of accuracies: 1 metres.
    pub accuracy: u8,
    /// Of coordinates: 1 degrees.
    pub coordinate: u8,
}

impl Default for MeasureUnits {
    fn default() -> Self {
        Self { depth: 1, height: 1, accuracy: 1, coordinate: 1 }
    }
}

/// Bytes of one field.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn u8(mut self, value: u8) -> Self {
        self.0.push(value);
        self
    }

    fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn i32(mut self, value: i32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn name(self, name: Name) -> Self {
        self.u8(name.kind).u32(name.id)
    }

    fn object(self, id: ObjectId) -> Self {
        self.u16(id.agency).u32(id.number).u16(id.subdivision)
    }

    fn text(mut self, text: &str, level: LexicalLevel) -> Result<Self, WriteError> {
        for character in text.chars() {
            self.0.extend(encode(character, level)?);
        }
        self.0.push(UNIT_TERMINATOR);
        if level == LexicalLevel::Ucs2 {
            self.0.push(0);
        }
        Ok(self)
    }

    fn fixed(mut self, text: &str, width: usize) -> Result<Self, WriteError> {
        let before = self.0.len();
        for character in text.chars() {
            self.0.extend(encode(character, ASCII)?);
        }
        // An update has no application date: it is blank.
        if text.is_empty() {
            self.0.extend(std::iter::repeat_n(b' ', width));
        }
        if self.0.len() - before == width {
            Ok(self)
        } else {
            Err(WriteError::Width { text: text.to_owned(), width })
        }
    }

    fn close(mut self, tag: [u8; 4], level: LexicalLevel) -> FieldBytes {
        self.0.push(FIELD_TERMINATOR);
        if level == LexicalLevel::Ucs2 {
            self.0.push(0);
        }
        (Tag(tag), self.0)
    }
}

/// The bytes of a character; terminators, the byte order mark and what UCS-2 lacks are refused.
fn encode(character: char, level: LexicalLevel) -> Result<impl Iterator<Item = u8>, WriteError> {
    let code = u32::from(character);
    let greatest = match level {
        LexicalLevel::Ascii => 0x7F,
        LexicalLevel::Latin1 => 0xFF,
        LexicalLevel::Ucs2 => 0xFFFF,
    };
    if code > greatest || matches!(code, 0x1E | 0x1F | 0xFEFF) {
        return Err(WriteError::Character { character, level });
    }
    let width = if level == LexicalLevel::Ucs2 { 2 } else { 1 };
    Ok(code.to_le_bytes().into_iter().take(width))
}

/// Numbers the record.
pub(super) fn record_number(number: usize) -> FieldBytes {
    // Two bytes: the number wraps after 65535 records; no reader relies on it.
    Bytes::default().u16(number as u16).close(*b"0001", ASCII)
}

pub(super) fn dataset(id: &DatasetId, structure: &DatasetStructure) -> Result<Vec<FieldBytes>, WriteError> {
    let bytes = Bytes::default()
        .u8(10)
        .u32(1)
        .u8(id.purpose)
        .u8(id.band)
        .text(&id.name, ASCII)?
        .text(&id.edition, ASCII)?
        .text(&id.update, ASCII)?
        .fixed(&id.update_date, 8)?
        .fixed(&id.issue_date, 8)?
        .fixed(&id.standard, 4)?
        .u8(id.product)
        .text("", ASCII)?
        .text("2.0", ASCII)?
        // Application profile: EN for a new cell, ER for a revision.
        .u8(if id.purpose == 2 { 2 } else { 1 })
        .u16(id.agency)
        .text(&id.comment, ASCII)?;
    let counts = [
        structure.meta_features,
        0,
        structure.geo_features,
        structure.collections,
        structure.isolated_nodes,
        structure.connected_nodes,
        structure.edges,
        0,
    ];
    let head = Bytes::default()
        .u8(structure.structure)
        .u8(structure.attribute_level as u8)
        .u8(structure.national_level as u8);
    let structure = counts.into_iter().fold(head, Bytes::u32);
    Ok(vec![bytes.close(*b"DSID", ASCII), structure.close(*b"DSSI", ASCII)])
}

pub(super) fn parameters(
    parameters: &DatasetParameters,
    units: MeasureUnits,
) -> Result<FieldBytes, WriteError> {
    let bytes = Bytes::default()
        .u8(20)
        .u32(1)
        .u8(parameters.horizontal_datum)
        .u8(parameters.vertical_datum)
        .u8(parameters.sounding_datum)
        .u32(parameters.scale)
        .u8(units.depth)
        .u8(units.height)
        .u8(units.accuracy)
        .u8(units.coordinate)
        .u32(parameters.coordinate_factor)
        .u32(parameters.sounding_factor)
        .text(&parameters.comment, ASCII)?;
    Ok(bytes.close(*b"DSPM", ASCII))
}

pub(super) fn feature(
    record: &FeatureRecord,
    level: LexicalLevel,
    national: LexicalLevel,
) -> Result<Vec<FieldBytes>, WriteError> {
    let head = Bytes::default()
        .u8(FEATURE)
        .u32(record.id)
        .u8(record.primitive)
        .u8(record.group)
        .u16(record.class)
        .u16(record.version)
        .u8(code(record.instruction));
    let mut fields = vec![head.close(*b"FRID", ASCII)];
    fields.extend(record.object.map(|id| Bytes::default().object(id).close(*b"FOID", ASCII)));
    fields.extend(attributes(*b"ATTF", &record.attributes, level)?);
    fields.extend(attributes(*b"NATF", &record.national, national)?);
    let link = |bytes: Bytes, link: &Link| bytes.object(link.to).u8(role(link.role)).text("", ASCII);
    list(&mut fields, [*b"FFPC", *b"FFPT"], &record.links, link)?;
    let pointer =
        |bytes: Bytes, to: &Pointer| Ok(bytes.name(to.name).u8(to.orientation).u8(to.usage).u8(to.mask));
    list(&mut fields, [*b"FSPC", *b"FSPT"], &record.pointers, pointer)?;
    Ok(fields)
}

pub(super) fn vector(record: &VectorRecord, level: LexicalLevel) -> Result<Vec<FieldBytes>, WriteError> {
    let head = Bytes::default().name(record.name).u16(record.version).u8(code(record.instruction));
    let mut fields = vec![head.close(*b"VRID", ASCII)];
    fields.extend(attributes(*b"ATTV", &record.attributes, level)?);
    let pointer = |bytes: Bytes, to: &Pointer| {
        Ok(bytes.name(to.name).u8(to.orientation).u8(to.usage).u8(to.topology).u8(to.mask))
    };
    list(&mut fields, [*b"VRPC", *b"VRPT"], &record.pointers, pointer)?;
    if record.has_depths {
        list(&mut fields, [*b"SGCC", *b"SG3D"], &record.coordinates, |bytes, at| {
            Ok(bytes.i32(at.y).i32(at.x).i32(at.z))
        })?;
    } else {
        list(&mut fields, [*b"SGCC", *b"SG2D"], &record.coordinates, |bytes, at| {
            Ok(bytes.i32(at.y).i32(at.x))
        })?;
    }
    Ok(fields)
}

fn attributes(
    tag: [u8; 4],
    list: &[Attribute],
    level: LexicalLevel,
) -> Result<Option<FieldBytes>, WriteError> {
    if list.is_empty() {
        return Ok(None);
    }
    let mut bytes = Bytes::default();
    for one in list {
        bytes = bytes.u16(one.code.0).text(&one.value, level)?;
    }
    Ok(Some(bytes.close(tag, level)))
}

/// A list, each part under its control where it has one.
fn list<T>(
    fields: &mut Vec<FieldBytes>,
    [control_tag, tag]: [[u8; 4]; 2],
    edits: &Edits<T>,
    one: impl Fn(Bytes, &T) -> Result<Bytes, WriteError>,
) -> Result<(), WriteError> {
    // Control fields do not repeat (S-57 part 3, 7.6 and 7.7).
    if edits.len() > 1 {
        return Err(WriteError::Edits(Tag(control_tag)));
    }
    for (control, items) in edits {
        if let Some(Control { instruction, index, count }) = *control {
            let narrow = |number| u16::try_from(number).map_err(|_| WriteError::Control(number));
            let bytes = Bytes::default().u8(code(instruction)).u16(narrow(index)?).u16(narrow(count)?);
            fields.push(bytes.close(control_tag, ASCII));
        }
        if !items.is_empty() {
            let bytes = items.iter().try_fold(Bytes::default(), &one)?;
            fields.push(bytes.close(tag, ASCII));
        }
    }
    Ok(())
}

fn code(instruction: Instruction) -> u8 {
    match instruction {
        Instruction::Insert => 1,
        Instruction::Delete => 2,
        Instruction::Modify => 3,
    }
}

fn role(role: LinkRole) -> u8 {
    match role {
        LinkRole::Master => 1,
        LinkRole::Slave => 2,
        LinkRole::Peer => 3,
        LinkRole::Other => NULL,
    }
}
