//! Makes an index of cells, soundings and land masks.

use super::index::{DepthIndex, Entry};
use super::meaning::{is_of_interest, meaning};
use super::object::{ChartObject, Role, Stored, millimetres};
use super::piece::{Line, Piece};
use super::places::{AreaEntry, Areas, Places};
use super::ring::Ring;
use super::seams::{Around, twice_area};
use crate::coverage::{ChartCoverage, Source};
use crate::grid::{Bounds, Vertex, vertex};
use crate::s57::{
    Area, AttributeCode, Cell, Feature, GeoPoint, Geometry, ObjectClass, ObjectId, Path, SKIN_CLASSES,
    Sounding,
};
use std::sync::Arc;

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
    #[error("{0} has more than a thousand million vertices; divide it")]
    TooLarge(
        /// The source.
        String,
    ),
    /// A chart reaches beyond its declared coverage.
    #[error("{0} has positions outside the box that the chart set notes for it; import it again")]
    Bounds(
        /// The source.
        String,
    ),
}

/// Vertices of a piece and of what its seams add are numbered by i32.
const MOST_VERTICES: usize = (i32::MAX as usize) / 2;

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

    /// Adds areas of land. They are land whatever cell has data there: their provider wants them kept clear of.
    /// They say nothing of the water around them.
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
    pub fn build(self) -> Result<DepthIndex, BuildError> {
        let mut sources: Vec<(Source, Arc<Piece>)> = Vec::new();
        for pending in self.sources {
            let source = pending.coverage.source.clone();
            sources.push((source, Arc::new(pending.own_part()?)));
        }
        sources.sort_by_cached_key(|(source, _)| source.rank());
        let boxes: Vec<Bounds> = sources.iter().map(|(_, piece)| piece.bounds()).collect();
        let load = |at: usize| Ok::<_, BuildError>(Arc::clone(&sources[at].1));
        let around = Around::new(boxes.clone(), usize::MAX, load);
        let joined = |at: usize| {
            let piece = around.joined(at)?;
            Ok((sources[at].0.clone(), Entry::of([0; 32], boxes[at], &piece), Arc::new(piece)))
        };
        let charts: Result<Vec<_>, BuildError> = (0..sources.len()).map(joined).collect();
        Ok(DepthIndex::held(charts?))
    }

    /// The one chart that was added, alone.
    pub(super) fn own_part(mut self) -> Result<Piece, BuildError> {
        self.sources.pop().map_or_else(|| Ok(Piece::default()), PendingSource::own_part)
    }
}

impl PendingSource {
    /// The chart alone, without the seams to others.
    fn own_part(self) -> Result<Piece, BuildError> {
        let source = &self.coverage.source;
        let mut piece =
            Piece { supplement: source.supplement, charts: vec![source.name.clone()], ..Piece::default() };
        for Pending { object: chart_object, shapes } in self.objects {
            let object = piece.objects.len() as u32;
            piece.objects.push(chart_object);
            for shape in shapes {
                match shape {
                    Shape::Area(rings) => push_area(&mut piece.areas, object, &rings),
                    Shape::Line(line) => {
                        let first = piece.areas.vertices.len() as u32;
                        piece.lines.push(Line { object, first, count: line.len() as u32 });
                        piece.areas.vertices.extend(line);
                    }
                }
            }
        }
        if piece.areas.vertices.len() > MOST_VERTICES {
            return Err(BuildError::TooLarge(source.name.clone()));
        }
        if self.coverage.by_skin && !source.supplement {
            cover_by_skin(&mut piece);
        }
        piece.own_objects = piece.objects.len() as u32;
        piece.own_vertices = piece.areas.vertices.len() as u32;
        let (objects, areas) = (&piece.objects, &piece.areas);
        let object = |area: u32| &objects[areas.list[area as usize].object as usize];
        let key = |area| (object(area).role, object(area).stored.least_mm());
        piece.places = Places::build(areas, key, |area| object(area).hold());
        Ok(piece)
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
            let turned = |paths: &[Path], onward: bool| -> Option<Vec<Vec<Vertex>>> {
                let mut rings = paths.iter().map(line).collect::<Option<Vec<_>>>()?;
                let wrong = |ring: &&mut Vec<Vertex>| (twice_area(ring) > 0) == onward;
                rings.iter_mut().filter(wrong).for_each(|ring| ring.reverse());
                Some(rings)
            };
            let (exteriors, holes) = (turned(&area.exteriors, true)?, turned(&area.holes, false)?);
            vec![Shape::Area([exteriors, holes].concat())]
        }
        Geometry::Unreadable { paths, .. } => {
            let vertices = paths.iter().map(line).collect::<Option<Vec<Vec<Vertex>>>>()?.concat();
            if vertices.is_empty() {
                return Some(Vec::new());
            }
            let Bounds { min: [x0, y0], max: [x1, y1] } = Bounds::of(&vertices);
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
fn cover_by_skin(piece: &mut Piece) {
    for at in 0..piece.areas.list.len() {
        let area = piece.areas.list[at];
        let object = &piece.objects[area.object as usize];
        // A depth area that cannot be read is a danger, but of the skin all the same.
        if !SKIN_CLASSES.contains(&object.class) {
            continue;
        }
        let coverage = ChartObject { role: Role::Coverage, stored: Stored::NoData, ..object.clone() };
        let object = piece.objects.len() as u32;
        piece.objects.push(coverage);
        piece.areas.list.push(AreaEntry { object, ..area });
    }
}
