//! A feature: an object of the chart with its attributes and where it is.

use super::codes::{AttributeCode, ObjectClass};
use super::geometry::Geometry;

/// The worldwide identity of an object (LNAM), stable over editions. The same in two cells is one object
/// that the cells' border cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ObjectId {
    /// Producing agency.
    pub agency: u16,
    /// Number.
    pub number: u32,
    /// Subdivision.
    pub subdivision: u16,
}

/// One attribute and its value as text, whatever its type. An empty value is "known to be unknown".
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attribute {
    /// The attribute.
    pub code: AttributeCode,
    /// Its value.
    pub value: String,
}

/// The relation of a linked feature to the one that links to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkRole {
    /// It is the master, such as the buoy of a light.
    Master,
    /// It is the slave, such as the light of a buoy.
    Slave,
    /// They are peers.
    Peer,
    /// Something else.
    Other,
}

impl LinkRole {
    pub(super) fn from_code(code: i64) -> Self {
        match code {
            1 => Self::Master,
            2 => Self::Slave,
            3 => Self::Peer,
            _ => Self::Other,
        }
    }
}

/// A link from one feature to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeatureLink {
    /// The other.
    pub to: ObjectId,
    /// Its relation to this one.
    pub role: LinkRole,
}

/// One feature.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// Record number in its cell.
    pub record: u32,
    /// Identity.
    pub object: ObjectId,
    /// Class.
    pub class: ObjectClass,
    /// Group: 1 for the skin of the Earth, 2 for all others.
    pub group: u8,
    /// Version of the record.
    pub version: u16,
    /// Attributes in the order of the file.
    pub attributes: Vec<Attribute>,
    /// Attributes in the national language.
    pub national: Vec<Attribute>,
    /// Links to other features.
    pub links: Vec<FeatureLink>,
    /// Where it is.
    pub geometry: Geometry,
}

impl Feature {
    /// All values of an attribute, empty ones too. A sound cell has at most one.
    pub fn texts(&self, code: AttributeCode) -> impl Iterator<Item = &str> + '_ {
        let all = self.attributes.iter().chain(&self.national);
        all.filter(move |one| one.code == code).map(|one| one.value.trim())
    }

    /// The value of an attribute; `None` where it is absent or empty.
    pub fn text(&self, code: AttributeCode) -> Option<&str> {
        self.texts(code).find(|value| !value.is_empty())
    }

    /// The value of an attribute as a number; `None` where it is absent, empty or no finite number.
    pub fn number(&self, code: AttributeCode) -> Option<f64> {
        self.text(code)?.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The value of an attribute as a code of an enumeration.
    pub fn code(&self, code: AttributeCode) -> Option<u32> {
        self.text(code)?.parse().ok()
    }

    /// The values of a list attribute; of all its lists, should there be several.
    pub fn list(&self, code: AttributeCode) -> impl Iterator<Item = u32> + '_ {
        self.texts(code).flat_map(|list| list.split(',')).filter_map(|value| value.trim().parse().ok())
    }
}
