//! Writes cells and updates of S-57 edition 3.1: the reader's mirror.
//!
//! A [`CellDraft`] or [`UpdateDraft`] has a head and [`Records`]: nodes, edges shared by neighbours, features,
//! and changes of them. [`CellDraft::to_bytes`] gives the file. What the file cannot hold is an error; whether
//! it makes sense (a boundary that closes, a version that follows) is not checked, so that tests can write
//! what a reader must refuse.
//!
//! Sources: IHO S-57 edition 3.1, part 3; appendix B.1 (ENC product specification) for the order of records.

mod change;
mod container;
mod encode;
mod error;
mod feature;
mod records;
mod schema;
#[cfg(test)]
mod tests;
mod vector;

pub use change::{EdgeEnd, FeatureChange, ListEdit, VectorChange};
pub use container::EntryMap;
pub use encode::MeasureUnits;
pub use error::WriteError;
pub use feature::{FeatureDraft, FeatureRef};
pub use records::Records;
pub use vector::{VectorRef, VectorUse};

use super::records::{
    CONNECTED_NODE, DataRecord, DatasetId, DatasetParameters, DatasetStructure, EDGE, ISOLATED_NODE,
};
use crate::iso8211::LexicalLevel;
use container::{Kind, push_record};

/// Coordinates of a new draft are degrees times this: a centimetre.
const COORDINATE_FACTOR: u32 = 10_000_000;
/// Depths of a new draft are metres times this.
const SOUNDING_FACTOR: u32 = 10;

/// How text and directories are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Characters of attributes.
    pub attributes: LexicalLevel,
    /// Characters of national attributes.
    pub national: LexicalLevel,
    /// Digits of the directories.
    pub entries: EntryMap,
}

impl Default for Style {
    /// As Norwegian cells: Latin 1, national names in UCS-2.
    fn default() -> Self {
        Self { attributes: LexicalLevel::Latin1, national: LexicalLevel::Ucs2, entries: EntryMap::Shortest }
    }
}

/// A base cell to be written.
#[derive(Debug, Clone)]
pub struct CellDraft {
    /// What the cell says of itself.
    pub id: DatasetId,
    /// Datums and scale. The factors are those of the records.
    pub parameters: DatasetParameters,
    /// Units; anything but metres and degrees is what readers must refuse.
    pub units: MeasureUnits,
    /// Text and directories.
    pub style: Style,
    /// What is in it.
    pub records: Records,
}

impl CellDraft {
    /// An empty cell of edition 1 on WGS 84, depths in tenths of a metre from the lowest astronomical tide.
    /// `name` ends in `.000`; `scale` is 1 : this.
    pub fn new(name: &str, band: u8, scale: u32) -> Self {
        Self::with_factors(name, band, scale, COORDINATE_FACTOR, SOUNDING_FACTOR)
    }

    /// The same with factors of one's own: coordinates are degrees times the first, depths metres times the
    /// second.
    pub fn with_factors(name: &str, band: u8, scale: u32, coordinate: u32, sounding: u32) -> Self {
        let id = DatasetId {
            purpose: 1,
            band,
            name: name.to_owned(),
            edition: "1".to_owned(),
            update: "0".to_owned(),
            update_date: "20260101".to_owned(),
            issue_date: "20260101".to_owned(),
            standard: "03.1".to_owned(),
            product: 1,
            agency: 540,
            comment: String::new(),
        };
        let parameters = DatasetParameters {
            horizontal_datum: 2,
            vertical_datum: 3,
            sounding_datum: 23,
            scale,
            coordinate_factor: coordinate,
            sounding_factor: sounding,
            comment: String::new(),
        };
        let records = Records::new(id.agency, coordinate, sounding);
        Self { id, parameters, units: MeasureUnits::default(), style: Style::default(), records }
    }

    /// The file.
    ///
    /// # Errors
    /// When text, numbers or fields do not fit the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, WriteError> {
        let (coordinate_factor, sounding_factor) = self.records.factors();
        let parameters = DatasetParameters { coordinate_factor, sounding_factor, ..self.parameters.clone() };
        let head = vec![encode::parameters(&parameters, self.units)?];
        file(&self.id, self.style, Some(head), &self.records)
    }
}

/// An update to be written.
#[derive(Debug, Clone)]
pub struct UpdateDraft {
    /// What the update says of itself.
    pub id: DatasetId,
    /// Text and directories.
    pub style: Style,
    /// What it inserts, changes and deletes.
    pub records: Records,
}

impl UpdateDraft {
    /// Update `number` of a cell. What it inserts gets numbers beyond those of the cell.
    pub fn new(cell: &CellDraft, number: u32) -> Self {
        let id = DatasetId {
            purpose: 2,
            update: number.to_string(),
            update_date: String::new(),
            ..cell.id.clone()
        };
        Self { id, style: cell.style, records: cell.records.continued() }
    }

    /// The update after this one: the next number, and record numbers beyond those that this one uses.
    #[must_use]
    pub fn next(&self) -> Self {
        let number = self.id.update.parse::<u32>().unwrap_or(0).saturating_add(1);
        let id = DatasetId { update: number.to_string(), ..self.id.clone() };
        Self { id, style: self.style, records: self.records.continued() }
    }

    /// The file.
    ///
    /// # Errors
    /// When text, numbers or fields do not fit the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, WriteError> {
        file(&self.id, self.style, None, &self.records)
    }
}

fn file(
    id: &DatasetId,
    style: Style,
    parameters: Option<Vec<container::FieldBytes>>,
    records: &Records,
) -> Result<Vec<u8>, WriteError> {
    let list = records.list()?;
    let description = schema::description(style.attributes, style.national);
    let mut bytes = Vec::new();
    push_record(&mut bytes, Kind::Description, style.entries, &description)?;
    let mut number = 0;
    let mut push = |fields: Vec<container::FieldBytes>| {
        number += 1;
        let mut all = vec![encode::record_number(number)];
        all.extend(fields);
        push_record(&mut bytes, Kind::Data, style.entries, &all)
    };
    push(encode::dataset(id, &structure(style, list))?)?;
    parameters.into_iter().try_for_each(&mut push)?;
    for record in list {
        match record {
            DataRecord::Feature(feature) => {
                push(encode::feature(feature, style.attributes, style.national)?)?;
            }
            DataRecord::Vector(vector) => push(encode::vector(vector, style.attributes)?)?,
            // Drafts have none of these: the head is written from its own fields.
            DataRecord::Id(..) | DataRecord::Parameters(_) | DataRecord::Other => {}
        }
    }
    Ok(bytes)
}

/// Counts what the head announces.
fn structure(style: Style, list: &[DataRecord]) -> DatasetStructure {
    let mut structure = DatasetStructure {
        structure: 2,
        attribute_level: style.attributes,
        national_level: style.national,
        ..DatasetStructure::default()
    };
    for record in list {
        let count = match record {
            DataRecord::Feature(feature) => match feature.class {
                300..=399 => &mut structure.meta_features,
                400..=499 => &mut structure.collections,
                _ => &mut structure.geo_features,
            },
            DataRecord::Vector(vector) => match vector.name.kind {
                ISOLATED_NODE => &mut structure.isolated_nodes,
                CONNECTED_NODE => &mut structure.connected_nodes,
                EDGE => &mut structure.edges,
                _ => continue,
            },
            DataRecord::Id(..) | DataRecord::Parameters(_) | DataRecord::Other => continue,
        };
        *count += 1;
    }
    structure
}
