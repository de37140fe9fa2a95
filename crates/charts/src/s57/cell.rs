//! A cell: its identity and its features, read from a base and its updates.

use super::assemble::Assembler;
use super::codes::ObjectClass;
use super::error::{S57Error, S57Problem};
use super::feature::{Feature, FeatureLink};
use super::geometry::{Geometry, Path};
use super::named_bytes::NamedBytes;
use super::records::{DatasetId, DatasetParameters, DatasetStructure};
use super::store::{Notice, Store, StoredFeature};
use std::collections::BTreeSet;

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
    /// Irregularities that were read: to be shown at import.
    pub notices: Vec<Notice>,
    /// Record numbers of features without readable geometry of which a part is in no file: their extent is unknown.
    pub incomplete: BTreeSet<u32>,
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
        let mut incomplete = BTreeSet::new();
        for (record, stored) in stored {
            let geometry = assembler.geometry(&stored).map_err(fail)?;
            if matches!(geometry, Geometry::Unreadable { .. }) && !assembler.is_whole(&stored) {
                incomplete.insert(record);
            }
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
            if spans_half_the_globe(&feature.geometry) {
                return Err(fail(S57Problem::Span { class: feature.class, record }));
            }
            features.push(feature);
        }
        let Store { id, structure, parameters, .. } = store;
        Ok(Self { id, structure, parameters, features, notices, incomplete })
    }

    /// Features of a class.
    pub fn of_class(&self, class: ObjectClass) -> impl Iterator<Item = &Feature> {
        self.features.iter().filter(move |feature| feature.class == class)
    }
}

/// Whether a line leads from one position to the next over more than 180° of longitude: which way round the globe it
/// runs is ambiguous, and the wrong way turns land into water.
fn spans_half_the_globe(geometry: &Geometry) -> bool {
    let spans =
        |path: &Path| path.points.windows(2).any(|pair| (pair[1].lon_deg - pair[0].lon_deg).abs() > 180.0);
    match geometry {
        Geometry::Lines(paths) | Geometry::Unreadable { paths, .. } => paths.iter().any(spans),
        Geometry::Area(area) => area.rings().any(spans),
        Geometry::None | Geometry::Point(_) | Geometry::Soundings(_) => false,
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
