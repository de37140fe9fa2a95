//! IMC's definition of every message and field: names, types, units, values, ranges.
//!
//! The tables are generated from `catalogue/messages.json`, which holds LSTS IMC 5.4.31 and the Otters' two
//! additions TBRFishTag (2007) and TBRSensor (2008). Code that meets messages it was not written for
//! (storage, exports, the dashboard) works from these.

#[rustfmt::skip]
#[expect(
    clippy::approx_constant,
    clippy::too_many_lines,
    clippy::unreadable_literal,
    reason = "generated, with numbers as the catalogue has them"
)]
pub(crate) mod tables;

pub use tables::{ADDRESSES, BITFIELDS, ENUMERATIONS, GROUPS, MESSAGES, UNITS, VERSION};

/// One message of the catalogue.
#[derive(Debug, PartialEq)]
pub struct MessageDesc {
    /// Id on the wire.
    pub id: u16,
    /// Short name, such as `EstimatedState`.
    pub abbrev: &'static str,
    /// Long name.
    pub name: &'static str,
    /// The part of the catalogue it belongs to.
    pub category: &'static str,
    /// What it is for, where Lutra handles it.
    pub summary: Option<&'static str>,
    /// Kinds of system that send it.
    pub sources: &'static [&'static str],
    /// `periodic` or `deprecated`.
    pub flags: &'static [&'static str],
    /// Payload bytes, when no value changes them.
    pub fixed_bytes: Option<usize>,
    /// Its fields, as far as they can be passed over at once.
    pub(crate) runs: &'static [Run],
    /// Fields in wire order.
    pub fields: &'static [FieldDesc],
}

/// Neighbouring fields of a message whose bytes can be passed over at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Run {
    /// Numbers, of so many bytes together.
    Fixed(usize),
    /// Bytes or text after their number.
    Counted,
    /// One message or none.
    Message,
    /// Any number of messages.
    List,
}

/// One field of a message.
#[derive(Debug, PartialEq)]
pub struct FieldDesc {
    /// Short name, such as `lat`.
    pub abbrev: &'static str,
    /// Long name.
    pub name: &'static str,
    /// Type on the wire.
    pub kind: FieldKind,
    /// Unit, such as `m/s`; `Enumerated`, `Bitfield` and `TupleList` are the catalogue's own.
    pub unit: Option<&'static str>,
    /// Least advised value.
    pub min: Option<f64>,
    /// Greatest advised value.
    pub max: Option<f64>,
    /// Value of a message made without saying otherwise, where it is not 0.
    pub default: Option<f64>,
    /// Names of its numbers, if any.
    pub meaning: Meaning,
    /// The message or group that a nested message should be of.
    pub message_type: Option<&'static str>,
    /// Added after the message's first release: older senders leave it out.
    pub appended: bool,
}

/// Type of a field on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FieldKind {
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 16-bit integer.
    I16,
    /// Unsigned 16-bit integer.
    U16,
    /// Signed 32-bit integer.
    I32,
    /// Unsigned 32-bit integer.
    U32,
    /// Signed 64-bit integer.
    I64,
    /// IEEE 754 single.
    F32,
    /// IEEE 754 double.
    F64,
    /// Bytes.
    Raw,
    /// Text.
    Text,
    /// One message or none.
    Message,
    /// Any number of messages.
    List,
}

impl FieldKind {
    /// The catalogue's name of the type, such as `fp32_t`.
    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "int8_t",
            Self::U8 => "uint8_t",
            Self::I16 => "int16_t",
            Self::U16 => "uint16_t",
            Self::I32 => "int32_t",
            Self::U32 => "uint32_t",
            Self::I64 => "int64_t",
            Self::F32 => "fp32_t",
            Self::F64 => "fp64_t",
            Self::Raw => "rawdata",
            Self::Text => "plaintext",
            Self::Message => "message",
            Self::List => "message-list",
        }
    }

    /// Bytes on the wire; `None` when they depend on the value.
    pub fn width(self) -> Option<usize> {
        match self {
            Self::I8 | Self::U8 => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 | Self::F32 => Some(4),
            Self::I64 | Self::F64 => Some(8),
            Self::Raw | Self::Text | Self::Message | Self::List => None,
        }
    }

    /// Least and greatest value of an integer type.
    pub fn integer_range(self) -> Option<(i64, i64)> {
        match self {
            Self::I8 => Some((i8::MIN.into(), i8::MAX.into())),
            Self::U8 => Some((0, u8::MAX.into())),
            Self::I16 => Some((i16::MIN.into(), i16::MAX.into())),
            Self::U16 => Some((0, u16::MAX.into())),
            Self::I32 => Some((i32::MIN.into(), i32::MAX.into())),
            Self::U32 => Some((0, u32::MAX.into())),
            Self::I64 => Some((i64::MIN, i64::MAX)),
            Self::F32 | Self::F64 | Self::Raw | Self::Text | Self::Message | Self::List => None,
        }
    }
}

/// Whether a field's numbers have names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// They have none.
    Plain,
    /// Each listed number has one.
    Enumeration(&'static EnumDesc),
    /// Each listed bit has one.
    Bitfield(&'static EnumDesc),
}

/// An enumeration or bit field.
#[derive(Debug, PartialEq)]
pub struct EnumDesc {
    /// Name by which several fields share it; `None` when it is one field's own.
    pub abbrev: Option<&'static str>,
    /// Long name.
    pub name: &'static str,
    /// Prefix of its values in other implementations.
    pub prefix: &'static str,
    /// Its values.
    pub values: &'static [Label],
}

/// One named number.
#[derive(Debug, PartialEq)]
pub struct Label {
    /// The number.
    pub value: i64,
    /// Short name, such as `NORMAL`.
    pub abbrev: &'static str,
    /// Long name.
    pub name: &'static str,
}

/// The message with this id.
pub fn by_id(id: u16) -> Option<&'static MessageDesc> {
    tables::by_id(id)
}

/// The message with this id, if a payload of so many bytes may be one.
///
/// LSTS' definitions leave the ids of TBRFishTag (2007) and TBRSensor (2008) free, and newer DUNE says ValidatePlan by 2007.
/// The header does not say which is meant, but the Otters' messages have fixed sizes: another size is another message,
/// and reading it by these fields would turn a plan into a fish detection.
#[inline]
pub fn by_id_and_size(id: u16, payload_bytes: usize) -> Option<&'static MessageDesc> {
    let desc = by_id(id)?;
    let fits = match id {
        FISH_TAG => payload_bytes == FISH_TAG_BYTES || payload_bytes == FISH_TAG_BYTES_OF_2019,
        SENSOR => payload_bytes == SENSOR_BYTES,
        _ => true,
    };
    fits.then_some(desc)
}

/// TBRFishTag.
const FISH_TAG: u16 = 2007;
const FISH_TAG_BYTES: usize = 37;
/// Without a position.
const FISH_TAG_BYTES_OF_2019: usize = 21;
/// TBRSensor.
const SENSOR: u16 = 2008;
const SENSOR_BYTES: usize = 17;

/// The message with this abbreviation, spelt exactly.
pub fn by_abbrev(abbrev: &str) -> Option<&'static MessageDesc> {
    let at = tables::BY_ABBREV.binary_search_by_key(&abbrev, |message| message.abbrev).ok()?;
    Some(tables::BY_ABBREV[at])
}

/// The name of a unit, such as `Meter per second` for `m/s`.
pub fn unit_name(abbrev: &str) -> Option<&'static str> {
    UNITS.iter().find(|(unit, _)| *unit == abbrev).map(|(_, name)| *name)
}

impl MessageDesc {
    /// The field with this abbreviation.
    pub fn field(&self, abbrev: &str) -> Option<&'static FieldDesc> {
        self.fields.iter().find(|field| field.abbrev == abbrev)
    }

    /// Least number of payload bytes of a sender that knows all fields.
    pub fn min_bytes(&self) -> usize {
        // Text and raw data need their length, a list its count and a message its id: two bytes each.
        self.fields.iter().map(|field| field.kind.width().unwrap_or(2)).sum()
    }
}

impl FieldDesc {
    /// The name of a number: one label of an enumeration, or the set bits of a bit field joined by `|`.
    ///
    /// Bits without a name are given as one hexadecimal number; an unlisted number of an enumeration has no
    /// name.
    pub fn label(&self, value: i64) -> Option<String> {
        match self.meaning {
            Meaning::Plain => None,
            Meaning::Enumeration(desc) => {
                desc.values.iter().find(|label| label.value == value).map(|label| label.abbrev.to_owned())
            }
            Meaning::Bitfield(desc) => Some(bit_labels(desc, value)),
        }
    }

    /// The number that a label, or for a bit field labels joined by `|`, stands for.
    pub fn value_of_label(&self, text: &str) -> Option<i64> {
        let find = |desc: &EnumDesc, name: &str| {
            desc.values.iter().find(|label| label.abbrev.eq_ignore_ascii_case(name)).map(|label| label.value)
        };
        match self.meaning {
            Meaning::Plain => None,
            Meaning::Enumeration(desc) => find(desc, text.trim()),
            Meaning::Bitfield(desc) => {
                let number = |name: &str| i64::from_str_radix(name.strip_prefix("0x")?, 16).ok();
                text.split('|')
                    .map(str::trim)
                    .try_fold(0, |bits, name| Some(bits | find(desc, name).or_else(|| number(name))?))
            }
        }
    }
}

fn bit_labels(desc: &EnumDesc, value: i64) -> String {
    if let Some(exact) = desc.values.iter().find(|label| label.value == value) {
        return exact.abbrev.to_owned();
    }
    let mut names = Vec::new();
    let mut rest = value;
    for label in desc.values {
        if label.value.count_ones() == 1 && rest & label.value != 0 {
            names.push(label.abbrev.to_owned());
            rest &= !label.value;
        }
    }
    if rest != 0 {
        names.push(format!("{rest:#x}"));
    }
    names.join("|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_messages_by_id_and_name() {
        assert_eq!(MESSAGES.len(), 351);
        for message in MESSAGES {
            assert_eq!(by_id(message.id), Some(message));
            assert_eq!(by_abbrev(message.abbrev), Some(message));
        }
        assert_eq!(by_id(3999), None);
        assert_eq!(by_abbrev("estimatedstate"), None);
    }

    #[test]
    fn names_numbers_and_bits() {
        let state = by_abbrev("VehicleState").unwrap();
        let mode = state.field("op_mode").unwrap();
        assert_eq!(mode.label(3).as_deref(), Some("MANEUVER"));
        assert_eq!(mode.label(77), None);
        let loops = state.field("control_loops").unwrap();
        assert_eq!(loops.label(201).as_deref(), Some("PATH|DEPTH|YAW|SPEED"));
        assert_eq!(loops.label(0).as_deref(), Some("NONE"));
        assert_eq!(loops.label(0x10_0001).as_deref(), Some("PATH|0x100000"));
        assert_eq!(loops.value_of_label("path | SPEED"), Some(129));
        assert_eq!(loops.value_of_label("PATH|0x100000"), Some(0x10_0001));
        assert_eq!(loops.value_of_label("PATH|WINGS"), None);
    }

    #[test]
    fn fish_tags_have_two_sizes() {
        let tag = by_id(2007).unwrap();
        assert_eq!(tag.fixed_bytes, Some(37));
        let appended: usize =
            tag.fields.iter().filter(|field| field.appended).filter_map(|field| field.kind.width()).sum();
        assert_eq!(appended, 16);
        let read = |bytes| by_id_and_size(2007, bytes).map(|desc| desc.abbrev);
        for bytes in 0..100 {
            let is = [21, 37].contains(&bytes).then_some("TBRFishTag");
            assert_eq!(read(bytes), is, "{bytes} bytes");
            assert_eq!(by_id_and_size(2008, bytes).is_some(), bytes == 17, "{bytes} bytes");
        }
        assert_eq!(by_id(2007).unwrap().min_bytes(), FISH_TAG_BYTES);
        assert_eq!(by_id(2008).unwrap().min_bytes(), SENSOR_BYTES);
        assert_eq!(by_id_and_size(350, 3).unwrap().abbrev, "EstimatedState", "it may be cut");
    }
}
