//! A cell: its identity and its features.

use super::assemble::Assembler;
use super::codes::{AttributeCode, ObjectClass};
use super::error::{S57Error, S57Problem};
use super::exchange::NamedBytes;
use super::geometry::Geometry;
use super::records::{DatasetId, DatasetParameters, DatasetStructure};
use super::store::{Notice, Store, StoredFeature};

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
    /// Which.
    pub code: AttributeCode,
    /// Its value.
    pub value: String,
}

/// What a linked feature is to the one that links to it.
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
    /// What it is to this one.
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
    /// The value of an attribute; `None` where it is absent or empty.
    pub fn text(&self, code: AttributeCode) -> Option<&str> {
        let all = self.attributes.iter().chain(&self.national);
        all.filter(|one| one.code == code).map(|one| one.value.trim()).find(|value| !value.is_empty())
    }

    /// The value of an attribute as a number; `None` where it is absent, empty or no finite number.
    pub fn number(&self, code: AttributeCode) -> Option<f64> {
        self.text(code)?.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The value of an attribute as a code of an enumeration.
    pub fn code(&self, code: AttributeCode) -> Option<u32> {
        self.text(code)?.parse().ok()
    }

    /// The values of a list attribute.
    pub fn list(&self, code: AttributeCode) -> impl Iterator<Item = u32> + '_ {
        self.text(code).unwrap_or_default().split(',').filter_map(|value| value.trim().parse().ok())
    }
}

/// A cell with all given updates applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Identity, edition and dates; update number and date of issue are those of the last update.
    pub id: DatasetId,
    /// Lexical levels and record counts as the base announces them.
    pub structure: DatasetStructure,
    /// Datums, scale and factors.
    pub parameters: DatasetParameters,
    /// Features by record number.
    pub features: Vec<Feature>,
    /// What was read but is not as it should be: to be shown at import.
    pub notices: Vec<Notice>,
}

impl Cell {
    /// Reads a base cell and applies updates in the order given.
    ///
    /// Updates that a re-issued base contains already are passed over.
    ///
    /// # Errors
    /// When a file is damaged or not what it should be, or an update is missing, out of order or does not fit.
    /// An error of any update is the error of the whole: a chart with half its updates is not shown as newer
    /// than it is.
    pub fn read(base: NamedBytes<'_>, updates: &[NamedBytes<'_>]) -> Result<Self, S57Error> {
        let mut store = Store::read_base(base.name, base.bytes)?;
        for update in updates {
            if !store.apply(update.name, update.bytes)? {
                let text = format!("passed over: the base is re-issued with update {}", store.reissue);
                store.notices.push(Notice { file: update.name.to_owned(), feature: None, text });
            }
        }
        Self::assemble(base.name, store)
    }

    fn assemble(file: &str, mut store: Store) -> Result<Self, S57Error> {
        let mut notices = std::mem::take(&mut store.notices);
        let mut features = Vec::with_capacity(store.features.len());
        let stored = std::mem::take(&mut store.features);
        let fail = |problem| S57Error { file: file.to_owned(), place: None, problem };
        let mut assembler = Assembler::new(&store);
        for (record, stored) in stored {
            let geometry = assembler.geometry(&stored).map_err(fail)?;
            let feature = stored.into_feature(record, geometry);
            if let Geometry::Unreadable { reason, .. } = &feature.geometry {
                let text = format!("{} {record} has no readable geometry: {reason}", feature.class);
                notices.push(Notice { file: file.to_owned(), feature: Some(record), text });
            }
            if feature.geometry == Geometry::None && !feature.class.is_collection() {
                let text = format!(
                    "{} {record} has no position: it is in the cell, but nowhere on the chart",
                    feature.class
                );
                notices.push(Notice { file: file.to_owned(), feature: Some(record), text });
            }
            let outside = |point: super::GeoPoint| point.place().is_none();
            if feature.geometry.points().any(outside) {
                return Err(fail(S57Problem::Range { what: "a position" }));
            }
            features.push(feature);
        }
        let Store { id, structure, parameters, .. } = store;
        Ok(Self { id, structure, parameters, features, notices })
    }

    /// Features of a class.
    pub fn of_class(&self, class: ObjectClass) -> impl Iterator<Item = &Feature> {
        self.features.iter().filter(move |feature| feature.class == class)
    }
}

impl StoredFeature {
    fn into_feature(self, record: u32, geometry: Geometry) -> Feature {
        let link = |link: super::records::Link| FeatureLink { to: link.to, role: link.role };
        Feature {
            record,
            object: self.object,
            class: ObjectClass(self.class),
            group: self.group,
            version: self.version,
            attributes: self.attributes,
            national: self.national,
            links: self.links.into_iter().map(link).collect(),
            geometry,
        }
    }
}
