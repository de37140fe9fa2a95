//! A small chart that a test damages, and the check whether any query calls it safe.

use charts::depth_index::{Demand, DepthIndex, IndexBuilder, Leg, unsafe_to_use};
use charts::s57::write::{CellDraft, FeatureDraft, FeatureRef, UpdateDraft, VectorRef, VectorUse};
use charts::s57::{AttributeCode as Attr, Cell, GeoPoint, NamedBytes, ObjectClass as Class};
use units::LatLon;

pub(crate) type At = (f64, f64);

const NAME: &str = "NO5X0058.000";
/// The corners of the chart, clockwise from the south-west.
pub(crate) const CORNERS: [At; 4] = [(63.0, 10.0), (63.02, 10.0), (63.02, 10.04), (63.0, 10.04)];
/// The middle of the chart.
pub(crate) const MIDDLE: At = (63.01, 10.02);

/// A draft of a cell, its updates, and bytes of the finished cell that are changed by hand.
pub(crate) struct Chart {
    pub(crate) cell: CellDraft,
    pub(crate) updates: Vec<UpdateDraft>,
    pub(crate) corners: [VectorRef; 4],
    pub(crate) sides: [VectorRef; 4],
    /// Bytes in the finished base cell, and their replacement: of the same length, and there once.
    pub(crate) patches: Vec<(Vec<u8>, Vec<u8>)>,
    /// Records that are in the base cell twice: bytes that mark one of them.
    pub(crate) repeated: Option<&'static str>,
}

pub(crate) fn at((lat_deg, lon_deg): At) -> GeoPoint {
    GeoPoint { lon_deg, lat_deg }
}

/// The same ring from `from` to `to`, as corners of a square in the order of [`CORNERS`].
pub(crate) fn square((south, west): At, (north, east): At) -> [At; 4] {
    [(south, west), (north, west), (north, east), (south, east)]
}

impl Chart {
    /// Four corners and four sides, and no object yet.
    pub(crate) fn bare() -> Self {
        let mut cell = CellDraft::new(NAME, 5, 10_000);
        let corners = CORNERS.map(|corner| cell.records.connected_node(at(corner)));
        let sides = [0, 1, 2, 3].map(|one| cell.records.edge(corners[one], corners[(one + 1) % 4], &[]));
        Self { cell, updates: Vec::new(), corners, sides, patches: Vec::new(), repeated: None }
    }

    /// All of it is covered, and 20 m deep.
    pub(crate) fn deep() -> Self {
        let mut chart = Self::bare();
        chart.cover();
        chart.water("20");
        chart
    }

    pub(crate) fn outline(&self) -> Vec<VectorUse> {
        self.sides.iter().map(|side| side.forward()).collect()
    }

    /// Says that the cell has data all over.
    pub(crate) fn cover(&mut self) -> FeatureRef {
        let cover = FeatureDraft::area(Class::M_COVR, &self.outline()).with(Attr::CATCOV, "1");
        self.add(cover)
    }

    /// Water of so many metres all over.
    pub(crate) fn water(&mut self, least_m: &str) -> FeatureRef {
        let water = FeatureDraft::area(Class::DEPARE, &self.outline()).with(Attr::DRVAL1, least_m);
        self.add(water)
    }

    pub(crate) fn add(&mut self, feature: FeatureDraft) -> FeatureRef {
        self.cell.records.feature(feature)
    }

    /// A rock in the middle, with attributes.
    pub(crate) fn rock(&mut self, attributes: &[(Attr, &str)]) -> FeatureRef {
        let node = self.cell.records.isolated_node(at(MIDDLE));
        let rock = FeatureDraft::point(Class::UWTROC, node);
        self.add(attributes.iter().fold(rock, |rock, (code, value)| rock.with(*code, *value)))
    }

    /// Edges from corner to corner and back to the first.
    pub(crate) fn ring(&mut self, corners: &[At]) -> Vec<VectorRef> {
        let nodes: Vec<_> =
            corners.iter().map(|corner| self.cell.records.connected_node(at(*corner))).collect();
        let next = nodes.iter().cycle().skip(1);
        nodes.iter().zip(next).map(|(from, to)| self.cell.records.edge(*from, *to, &[])).collect()
    }

    /// An area over a ring of its own, with attributes.
    pub(crate) fn area(&mut self, class: Class, corners: &[At], attributes: &[(Attr, &str)]) -> FeatureRef {
        let ring: Vec<_> = self.ring(corners).into_iter().map(VectorRef::forward).collect();
        let area = FeatureDraft::area(class, &ring);
        self.add(attributes.iter().fold(area, |area, (code, value)| area.with(*code, *value)))
    }

    /// A node that no file has.
    pub(crate) fn ghost_node(&self) -> VectorRef {
        let mut elsewhere = self.cell.records.clone();
        (0..1000).map(|_| elsewhere.isolated_node(at(MIDDLE))).last().unwrap()
    }

    /// An edge that no file has.
    pub(crate) fn ghost_edge(&self) -> VectorRef {
        let mut elsewhere = self.cell.records.clone();
        (0..1000).map(|_| elsewhere.edge(self.corners[0], self.corners[1], &[])).last().unwrap()
    }

    /// The next update.
    pub(crate) fn update(&mut self, change: impl FnOnce(&mut UpdateDraft)) {
        let mut update =
            self.updates.last().map_or_else(|| UpdateDraft::new(&self.cell, 1), UpdateDraft::next);
        change(&mut update);
        self.updates.push(update);
    }

    /// Changes the geometric primitive of a feature by hand.
    pub(crate) fn as_primitive(&mut self, feature: FeatureRef, primitive: u8) {
        let head = |primitive| {
            let mut bytes = vec![100];
            bytes.extend(feature.record.to_le_bytes());
            bytes.extend([primitive, feature.group]);
            bytes.extend(feature.class.0.to_le_bytes());
            bytes
        };
        self.patches.push((head(feature.primitive), head(primitive)));
    }

    fn base(&self) -> Vec<u8> {
        let mut bytes = self.cell.to_bytes().unwrap();
        for (old, new) in &self.patches {
            let all: Vec<_> =
                (0..bytes.len() - old.len()).filter(|at| bytes[*at..].starts_with(old)).collect();
            assert!(all.len() == 1 && old.len() == new.len(), "{old:?} is there {} times", all.len());
            bytes[all[0]..all[0] + new.len()].copy_from_slice(new);
        }
        if let Some(tag) = self.repeated {
            let again = record_with(&bytes, tag);
            bytes.extend(again);
        }
        bytes
    }

    /// Imports the cell: the refusal in words, or the chart.
    pub(crate) fn read(&self) -> Result<Cell, String> {
        let base = self.base();
        let stem = NAME.trim_end_matches("000");
        let files = self
            .updates
            .iter()
            .zip(1..)
            .map(|(update, number)| (format!("{stem}{number:03}"), update.to_bytes().unwrap()));
        let files: Vec<_> = files.collect();
        let updates: Vec<_> = files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
        let cell =
            Cell::read(NamedBytes { name: NAME, bytes: &base }, &updates).map_err(|why| why.to_string())?;
        let problem = unsafe_to_use(&cell, &cell.skin_check());
        problem.map_or(Ok(cell), |problem| Err(format!("{NAME}: {problem}")))
    }
}

/// The record of a file that has a field, without the description that names all fields.
fn record_with(bytes: &[u8], tag: &str) -> Vec<u8> {
    let mut rest = bytes;
    let mut found = Vec::new();
    while !rest.is_empty() {
        let length: usize = std::str::from_utf8(&rest[..5]).unwrap().parse().unwrap();
        let (record, after) = rest.split_at(length);
        let base: usize = std::str::from_utf8(&record[12..17]).unwrap().parse().unwrap();
        let directory = &record[24..base];
        if directory.windows(tag.len()).any(|word| word == tag.as_bytes()) {
            found = record.to_vec();
        }
        rest = after;
    }
    found
}

/// An index of the chart alone, and one in which a coarse chart of deep water lies below it: what the damaged chart
/// does not cover any more, the coarse one calls deep.
pub(crate) fn indices(cell: &Cell) -> [(&'static str, DepthIndex); 2] {
    let coarse = {
        let mut cell = CellDraft::new("NO2X0001.000", 2, 700_000);
        let nodes = square((62.9, 9.8), (63.1, 10.3)).map(|corner| cell.records.connected_node(at(corner)));
        let sides =
            [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]).forward());
        cell.records.feature(FeatureDraft::area(Class::M_COVR, &sides).with(Attr::CATCOV, "1"));
        cell.records.feature(FeatureDraft::area(Class::DEPARE, &sides).with(Attr::DRVAL1, "50"));
        let bytes = cell.to_bytes().unwrap();
        Cell::read(NamedBytes { name: "NO2X0001.000", bytes: &bytes }, &[]).unwrap()
    };
    let index = |cells: &[&Cell]| {
        let mut builder = IndexBuilder::new();
        for cell in cells {
            builder.add_cell(cell).unwrap();
        }
        builder.build().unwrap()
    };
    [("alone", index(&[cell])), ("over a coarse chart", index(&[cell, &coarse]))]
}

/// Whether a vessel that needs 5 m of water and 3 m above it may be at a place, or pass it on a way of 500 m from any of
/// four sides, or of 4 m.
pub(crate) fn is_safe_past(index: &DepthIndex, (lat, lon): At) -> bool {
    let demand = Demand { air_draught_m: Some(3.0), ..Demand::least_depth(5.0) };
    let place = |lat, lon| LatLon::from_deg(lat, lon).unwrap();
    [(0.0, 0.005), (0.002, 0.0), (0.0, 0.000_04), (0.0, 0.0)].into_iter().any(|(north, east)| {
        let leg = Leg { from: place(lat - north, lon - east), to: place(lat + north, lon + east) };
        index.shallowest_along(leg, 1.0, &demand).navigable
            || index.first_danger_along(leg, 1.0, &demand).is_none()
    })
}
