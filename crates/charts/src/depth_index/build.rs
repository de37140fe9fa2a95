//! Makes an index of cells, soundings and land masks.

use super::index::DepthIndex;
use super::meaning::{is_of_interest, meaning};
use super::object::{ChartObject, Role, Stored, millimetres};
use super::places::{AreaEntry, Areas, Places};
use super::ring::Ring;
use super::seams;
use super::tree::Tree;
use crate::coverage::{ChartCoverage, Coverage, Source};
use crate::grid::{Vertex, vertex};
use crate::s57::{
    Area, AttributeCode, Cell, Feature, GeoPoint, Geometry, ObjectClass, ObjectId, Path, Sounding,
};

/// Why no index can be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// A position beyond the globe.
    #[error("{file}: {class} {record} has a position outside ±90° and ±180°; repair or leave out the object")]
    Position {
        /// The source.
        file: String,
        /// The object's class.
        class: ObjectClass,
        /// Its record number.
        record: u32,
    },
    /// Too much for one index.
    #[error("the charts have more than two thousand million vertices; make several chart sets")]
    TooLarge,
}

/// Where something is, in units.
#[derive(Debug, Clone)]
pub(super) enum Shape {
    Area(Vec<Vec<Vertex>>),
    Line(Vec<Vertex>),
}

#[derive(Debug, Clone)]
pub(super) struct Pending {
    pub(super) object: ChartObject,
    pub(super) shapes: Vec<Shape>,
}

#[derive(Debug, Clone)]
struct PendingSource {
    coverage: ChartCoverage,
    objects: Vec<Pending>,
}

/// Collects what an index is made of.
#[derive(Debug, Clone, Default)]
pub struct IndexBuilder {
    sources: Vec<PendingSource>,
}

impl IndexBuilder {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a cell.
    ///
    /// # Errors
    /// When a position is outside the globe.
    pub fn add_cell(&mut self, cell: &Cell) -> Result<(), BuildError> {
        let source = Source {
            name: cell.id.name.split('.').next().unwrap_or_default().to_owned(),
            edition: cell.id.edition.clone(),
            update: cell.id.update.clone(),
            issue_date: cell.id.issue_date.clone(),
            band: cell.id.band,
            scale: cell.parameters.scale,
            sounding_datum: cell.parameters.sounding_datum,
            supplement: false,
        };
        self.add_features(source, &cell.features)
    }

    /// Adds the features of a source, as a database gives them.
    ///
    /// # Errors
    /// When a position is outside the globe.
    pub fn add_features<'a>(
        &mut self,
        source: Source,
        features: impl IntoIterator<Item = &'a Feature>,
    ) -> Result<(), BuildError> {
        let features: Vec<&Feature> = features.into_iter().collect();
        let mut objects = Vec::new();
        for feature in &features {
            let fail = || BuildError::Position {
                file: source.name.clone(),
                class: feature.class,
                record: feature.record,
            };
            add_feature(feature, &mut objects).ok_or_else(fail)?;
        }
        if source.supplement {
            // Skin would cover what it is part of, and hide what lies there.
            let skin = objects.iter_mut().filter(|one| one.object.role == Role::Skin);
            skin.for_each(|one| one.object.role = Role::Danger);
        }
        let coverage = ChartCoverage::of(source, features);
        self.sources.push(PendingSource { coverage, objects });
        Ok(())
    }

    /// Adds single soundings. They can only show that it is shallower than a cell says; they make nothing
    /// navigable.
    ///
    /// # Errors
    /// When a position is outside the globe.
    pub fn add_soundings(&mut self, name: &str, soundings: &[Sounding]) -> Result<(), BuildError> {
        let source = Source { name: name.to_owned(), supplement: true, ..Source::default() };
        let feature = made(ObjectClass::SOUNDG, Geometry::Soundings(soundings.to_vec()));
        self.add_features(source, [&feature])
    }

    /// Adds areas of land. They are land whatever cell has data there: who gives them wants them kept clear of.
    /// Around them nothing is said.
    ///
    /// # Errors
    /// When a position is outside the globe.
    pub fn add_land(&mut self, name: &str, areas: &[Area]) -> Result<(), BuildError> {
        let source = Source { name: name.to_owned(), supplement: true, ..Source::default() };
        let features: Vec<Feature> =
            areas.iter().map(|area| made(ObjectClass::LNDARE, Geometry::Area(area.clone()))).collect();
        self.add_features(source, &features)
    }

    /// Makes the index.
    ///
    /// # Errors
    /// When there is too much.
    pub fn build(mut self) -> Result<DepthIndex, BuildError> {
        self.sources.sort_by_cached_key(|pending| pending.coverage.source.rank());
        let mut index = DepthIndex::default();
        let (mut lines, mut covered) = (Vec::new(), Vec::new());
        for (at, PendingSource { coverage, objects }) in self.sources.into_iter().enumerate() {
            index.sources.push(coverage.source.clone());
            covered.push(coverage);
            for mut pending in objects {
                pending.object.source = at as u32;
                let object = index.objects.len() as u32;
                index.objects.push(pending.object);
                for shape in pending.shapes {
                    match shape {
                        Shape::Area(rings) => push_area(&mut index.areas, object, &rings),
                        Shape::Line(line) => {
                            lines.push((object, index.areas.vertices.len() as u32, line.len() as u32));
                            index.areas.vertices.extend(line);
                        }
                    }
                }
            }
        }
        if index.areas.vertices.len() > (i32::MAX as usize) / 2 {
            return Err(BuildError::TooLarge);
        }
        let coverage = Coverage::new(covered);
        cover_by_skin(&mut index, &coverage);
        let objects = &index.objects;
        let areas = &index.areas;
        index.places = Places::build(areas, |area| {
            let object = &objects[areas.list[area as usize].object as usize];
            (object.source, object.role, object.stored.least_mm())
        });
        grow_trees(&mut index, &coverage, &lines);
        index.note_unassessed();
        Ok(index)
    }
}

fn made(class: ObjectClass, geometry: Geometry) -> Feature {
    Feature {
        record: 0,
        object: ObjectId::default(),
        class,
        group: 1,
        version: 1,
        attributes: Vec::new(),
        national: Vec::new(),
        links: Vec::new(),
        geometry,
    }
}

/// `None` where a position is outside the globe.
fn add_feature(feature: &Feature, objects: &mut Vec<Pending>) -> Option<()> {
    let Some((role, stored)) = meaning(feature) else {
        // A danger that does not decide is still of interest.
        if is_of_interest(feature.class) {
            let pending = pending(feature, Role::Interest, Stored::NoData, shapes(&feature.geometry)?);
            objects.push(pending);
        }
        return Some(());
    };
    if let Geometry::Soundings(soundings) = &feature.geometry {
        for sounding in soundings {
            let at = vertex(sounding.at.lon_deg, sounding.at.lat_deg)?;
            let stored = Stored::Depth(millimetres(sounding.depth_m), None);
            objects.push(pending(feature, Role::Danger, stored, vec![Shape::Line(vec![at])]));
        }
        return Some(());
    }
    let shapes = shapes(&feature.geometry)?;
    // What cannot be read as an area counts as a danger over all of its box, not as skin.
    let unreadable = matches!(feature.geometry, Geometry::Unreadable { .. });
    let (role, stored) = match (role, unreadable) {
        (Role::Coverage | Role::Quality | Role::Interest, true) => return Some(()),
        (Role::Skin | Role::Danger, true) => (Role::Danger, Stored::Unknown),
        (role, _) => (role, stored),
    };
    if !shapes.is_empty() {
        objects.push(pending(feature, role, stored, shapes));
    }
    Some(())
}

fn pending(feature: &Feature, role: Role, stored: Stored, shapes: Vec<Shape>) -> Pending {
    let object = ChartObject {
        class: feature.class,
        id: feature.object,
        record: feature.record,
        source: 0,
        name: feature.text(AttributeCode::OBJNAM).map(str::to_owned),
        zone: feature.code(AttributeCode::CATZOC).and_then(|code| u8::try_from(code).ok()),
        stored,
        role,
        interest: is_of_interest(feature.class),
    };
    Pending { object, shapes }
}

fn shapes(geometry: &Geometry) -> Option<Vec<Shape>> {
    let line = |path: &Path| -> Option<Vec<Vertex>> {
        path.points.iter().map(|point| vertex(point.lon_deg, point.lat_deg)).collect()
    };
    let single = |point: &GeoPoint| vertex(point.lon_deg, point.lat_deg).map(|at| vec![at]);
    Some(match geometry {
        Geometry::None => Vec::new(),
        Geometry::Point(point) => vec![Shape::Line(single(point)?)],
        Geometry::Soundings(soundings) => {
            let at = soundings.iter().map(|one| single(&one.at).map(Shape::Line));
            at.collect::<Option<Vec<_>>>()?
        }
        Geometry::Lines(paths) => {
            paths.iter().map(|path| line(path).map(Shape::Line)).collect::<Option<Vec<_>>>()?
        }
        Geometry::Area(area) => {
            let rings = area.rings().map(line).collect::<Option<Vec<Vec<Vertex>>>>()?;
            vec![Shape::Area(rings)]
        }
        Geometry::Unreadable { paths, .. } => {
            let vertices = paths.iter().map(line).collect::<Option<Vec<Vec<Vertex>>>>()?.concat();
            if vertices.is_empty() {
                return Some(Vec::new());
            }
            let bounds = crate::grid::Bounds::of(&vertices);
            let ([x0, y0], [x1, y1]) = (bounds.min, bounds.max);
            vec![Shape::Area(vec![vec![[x0, y0], [x0, y1], [x1, y1], [x1, y0], [x0, y0]]])]
        }
    })
}

fn push_area(areas: &mut Areas, object: u32, rings: &[Vec<Vertex>]) {
    let first_ring = areas.rings.len() as u32;
    for ring in rings.iter().filter(|ring| ring.len() >= 2) {
        let first = areas.vertices.len() as u32;
        let boxes = areas.boxes.len() as u32;
        areas.vertices.extend_from_slice(ring);
        if ring.first() != ring.last() {
            areas.vertices.push(ring[0]);
        }
        let count = areas.vertices.len() as u32 - first;
        Ring::push_boxes(&areas.vertices[first as usize..], &mut areas.boxes);
        areas.rings.push(Ring { first, count, boxes });
    }
    let rings = areas.rings.len() as u32 - first_ring;
    areas.list.push(AreaEntry { object, first_ring, rings });
}

/// A source that does not say where it has data has them where its skin is.
fn cover_by_skin(index: &mut DepthIndex, coverage: &Coverage) {
    for at in 0..index.areas.list.len() {
        let area = index.areas.list[at];
        let object = &index.objects[area.object as usize];
        if object.role != Role::Skin || !coverage.charts()[object.source as usize].by_skin {
            continue;
        }
        let coverage = ChartObject { role: Role::Coverage, stored: Stored::NoData, ..object.clone() };
        let object = index.objects.len() as u32;
        index.objects.push(coverage);
        index.areas.list.push(AreaEntry { object, ..area });
    }
}

fn grow_trees(index: &mut DepthIndex, coverage: &Coverage, lines: &[(u32, u32, u32)]) {
    let mut runs = seams::Runs::default();
    for area in &index.areas.list {
        for ring in index.areas.rings_of(*area) {
            runs.add(&index.objects[area.object as usize], area.object, ring.first, ring.count);
        }
    }
    for (object, first, count) in lines {
        runs.add(&index.objects[*object as usize], *object, *first, *count);
    }
    let seams::Runs { danger, quality, overhead, interest } = runs;
    let [mut danger, mut quality, overhead] =
        [danger, quality, overhead].map(|runs| seams::best_scale_only(index, coverage, runs));
    danger.extend(seams::borders(index));
    quality.extend(seams::unassessed(index));
    let vertices = &index.areas.vertices;
    let objects = &index.objects;
    let least =
        |object: u32| objects.get(object as usize).map_or(Stored::NoData, |one| one.stored).least_mm();
    let danger = Tree::build(danger, vertices, least);
    let [quality, overhead, interest] =
        [quality, overhead, interest].map(|runs| Tree::build(runs, vertices, least));
    (index.danger, index.quality, index.overhead, index.interest) = (danger, quality, overhead, interest);
}
