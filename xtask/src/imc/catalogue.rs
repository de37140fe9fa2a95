//! The catalogue in the form of `messages.json`.

use anyhow::ensure;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Catalogue {
    #[serde(rename = "protocol")]
    _protocol: String,
    pub(super) version: String,
    #[serde(rename = "sync")]
    _sync: u16,
    pub(super) units: Vec<(String, String)>,
    pub(super) enumerations: Vec<Shared>,
    pub(super) bitfields: Vec<Shared>,
    pub(super) groups: BTreeMap<String, Vec<String>>,
    pub(super) categories: Vec<String>,
    pub(super) messages: Vec<Message>,
}

/// An enumeration or bit field that several messages use.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Shared {
    pub(super) abbrev: String,
    pub(super) name: String,
    pub(super) prefix: String,
    pub(super) values: Vec<Label>,
}

/// Number, abbreviation and name of one value.
#[derive(Deserialize)]
pub(super) struct Label(pub(super) i64, pub(super) String, pub(super) String);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Message {
    pub(super) id: u16,
    pub(super) abbrev: String,
    pub(super) name: String,
    pub(super) category: String,
    #[serde(default)]
    pub(super) source: Vec<String>,
    #[serde(default)]
    pub(super) flags: Vec<String>,
    pub(super) summary: Option<String>,
    pub(super) fields: Vec<Field>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Field {
    pub(super) abbrev: String,
    pub(super) name: String,
    #[serde(rename = "type")]
    pub(super) kind: Kind,
    pub(super) unit: Option<String>,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    pub(super) default: Option<f64>,
    pub(super) prefix: Option<String>,
    pub(super) enum_def: Option<String>,
    pub(super) bitfield_def: Option<String>,
    pub(super) message_type: Option<String>,
    pub(super) values: Option<Vec<Label>>,
    pub(super) bits: Option<Vec<Label>>,
    /// Added to the message after its first release: older senders leave it out.
    #[serde(default)]
    pub(super) appended: bool,
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    #[serde(rename = "int8_t")]
    I8,
    #[serde(rename = "uint8_t")]
    U8,
    #[serde(rename = "int16_t")]
    I16,
    #[serde(rename = "uint16_t")]
    U16,
    #[serde(rename = "int32_t")]
    I32,
    #[serde(rename = "uint32_t")]
    U32,
    #[serde(rename = "int64_t")]
    I64,
    #[serde(rename = "fp32_t")]
    F32,
    #[serde(rename = "fp64_t")]
    F64,
    #[serde(rename = "rawdata")]
    Raw,
    #[serde(rename = "plaintext")]
    Text,
    #[serde(rename = "message")]
    Message,
    #[serde(rename = "message-list")]
    List,
}

impl Kind {
    /// Bytes on the wire, for the kinds where the value does not matter.
    pub(super) fn width(self) -> Option<usize> {
        match self {
            Self::I8 | Self::U8 => Some(1),
            Self::I16 | Self::U16 => Some(2),
            Self::I32 | Self::U32 | Self::F32 => Some(4),
            Self::I64 | Self::F64 => Some(8),
            Self::Raw | Self::Text | Self::Message | Self::List => None,
        }
    }

    /// The Rust type of a number of this kind.
    pub(super) fn number(self) -> &'static str {
        match self {
            Self::I8 => "i8",
            Self::U8 => "u8",
            Self::I16 => "i16",
            Self::U16 => "u16",
            Self::I32 => "i32",
            Self::U32 => "u32",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::Raw | Self::Text | Self::Message | Self::List => "",
        }
    }

    /// The variant of `catalogue::FieldKind`.
    pub(super) fn variant(self) -> &'static str {
        match self {
            Self::I8 => "I8",
            Self::U8 => "U8",
            Self::I16 => "I16",
            Self::U16 => "U16",
            Self::I32 => "I32",
            Self::U32 => "U32",
            Self::I64 => "I64",
            Self::F32 => "F32",
            Self::F64 => "F64",
            Self::Raw => "Raw",
            Self::Text => "Text",
            Self::Message => "Message",
            Self::List => "List",
        }
    }
}

impl Field {
    pub(super) fn is_enumerated(&self) -> bool {
        self.unit.as_deref() == Some("Enumerated")
    }

    pub(super) fn is_bitfield(&self) -> bool {
        self.unit.as_deref() == Some("Bitfield")
    }
}

impl Catalogue {
    /// Checks the generator's assumptions.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let ids: BTreeSet<u16> = self.messages.iter().map(|m| m.id).collect();
        let abbrevs: BTreeSet<&str> = self.messages.iter().map(|m| m.abbrev.as_str()).collect();
        ensure!(ids.len() == self.messages.len(), "two messages have the same id");
        ensure!(abbrevs.len() == self.messages.len(), "two messages have the same abbreviation");
        for message in &self.messages {
            let at = |field: &Field| format!("{}.{}", message.abbrev, field.abbrev);
            ensure!(self.categories.contains(&message.category), "{}: unknown category", message.abbrev);
            let mut appended = false;
            for field in &message.fields {
                ensure!(field.appended || !appended, "{}: only last fields can be appended", at(field));
                appended |= field.appended;
                ensure!(
                    !field.appended || field.kind == Kind::F64,
                    "{}: appended fields are fp64_t",
                    at(field)
                );
                let has_values = field.values.is_some() || field.enum_def.is_some();
                ensure!(!field.is_enumerated() || has_values, "{}: no values", at(field));
                let has_bits = field.bits.is_some() || field.bitfield_def.is_some();
                ensure!(field.is_bitfield() == has_bits, "{}: bits and unit disagree", at(field));
                if let Some(wanted) = &field.message_type {
                    let known = abbrevs.contains(wanted.as_str()) || self.groups.contains_key(wanted);
                    ensure!(known, "{}: unknown message type {wanted}", at(field));
                }
                if let Some(name) = &field.enum_def {
                    ensure!(self.enumerations.iter().any(|e| e.abbrev == *name), "{}: no {name}", at(field));
                }
                if let Some(name) = &field.bitfield_def {
                    ensure!(self.bitfields.iter().any(|e| e.abbrev == *name), "{}: no {name}", at(field));
                }
            }
        }
        Ok(())
    }
}
