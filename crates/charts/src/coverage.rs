//! Which chart is in force where.
//!
//! Where charts overlap, the best one counts: the finest band, then the largest scale, then the newest issue
//! ([`Coverage::charts`] has them in that order), exactly up to the border of what it covers. A chart covers what its
//! M_COVR areas with CATCOV 1 say (S-57 appendix B.1, 3.4); one without any, such as depths of lakes, what its skin of
//! the Earth covers. Soundings and land masks from elsewhere cover nothing: they are used beside the charts.
//!
//! The depth index cuts coarser charts off by this, tiles are drawn by it, and a planner gets by it the regions of one
//! chart each: [`Coverage::in_force`].

use crate::grid::{Bounds, PER_DEGREE, vertex};
use crate::s57::{Area, AttributeCode, Feature, GeoPoint, Geometry, ObjectClass, SKIN_CLASSES};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;
use std::cmp::Reverse;
use units::LatLon;

pub use crate::grid::Vertex;

/// An area as its rings, outer and inner alike: a point lies inside where an odd number of them holds it. The last
/// vertex of a ring is its first one again.
pub type Polygon = Vec<Vec<Vertex>>;

/// Where chart objects come from: a cell, or a file of soundings, land or lakes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Source {
    /// Name of the cell or file.
    pub name: String,
    /// Edition.
    pub edition: String,
    /// Number of the last update.
    pub update: String,
    /// Date of issue (YYYYMMDD).
    pub issue_date: String,
    /// Usage band, 1 overview to 6 berthing; 0 for what is not a cell.
    pub band: u8,
    /// Compilation scale, 1 : this; 0 if unknown.
    pub scale: u32,
    /// Datum of depths (S-57 code VERDAT); 0 if unknown.
    pub sounding_datum: u8,
    /// Whether it only adds to cells (soundings, land masks): no cell hides it, and it makes nothing navigable.
    pub supplement: bool,
}

impl Source {
    /// Name, edition, update and date of issue, as far as there are such.
    pub(crate) fn edition_text(&self) -> String {
        let mut words = vec![self.name.clone()];
        if !self.edition.is_empty() {
            words.push(format!("edition {}", self.edition));
        }
        if !self.update.is_empty() && self.update != "0" {
            words.push(format!("update {}", self.update));
        }
        if let (Some(year), Some(month), Some(day)) =
            (self.issue_date.get(..4), self.issue_date.get(4..6), self.issue_date.get(6..8))
        {
            words.push(format!("of {year}-{month}-{day}"));
        }
        words.join(" ")
    }

    /// Less answers before more: supplements, which answer beside the others, finer band, larger scale, newer issue,
    /// then the name so that the order is the same in every run.
    pub fn rank(&self) -> impl Ord + use<> {
        let scale = if self.scale == 0 { u32::MAX } else { self.scale };
        let newer = Reverse(self.issue_date.clone());
        (!self.supplement, Reverse(self.band), scale, newer, self.name.clone())
    }
}

/// Whether a feature says that its chart has data in its area.
pub fn is_coverage(feature: &Feature) -> bool {
    feature.class == ObjectClass::M_COVR && feature.code(AttributeCode::CATCOV) == Some(1)
}

/// Whether a feature is part of the skin of the Earth: depth areas and land, which lie beside each other.
pub(crate) fn is_skin(feature: &Feature) -> bool {
    matches!(feature.geometry, Geometry::Area(_)) && SKIN_CLASSES.contains(&feature.class)
}

/// The coverage of one chart, without regard to others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartCoverage {
    /// The chart.
    pub source: Source,
    /// What it covers; none of a supplement.
    pub areas: Vec<Polygon>,
    /// Whether these are areas of its skin, because it does not say itself where it has data.
    pub by_skin: bool,
}

impl ChartCoverage {
    /// By the features of a chart.
    pub fn of<'a>(source: Source, features: impl IntoIterator<Item = &'a Feature>) -> Self {
        if source.supplement {
            return Self { source, ..Self::default() };
        }
        let (mut told, mut skin) = (Vec::new(), Vec::new());
        for feature in features {
            let Geometry::Area(area) = &feature.geometry else { continue };
            if is_coverage(feature) {
                told.push(area);
            } else if is_skin(feature) {
                skin.push(area);
            }
        }
        let by_skin = told.is_empty();
        let areas = if by_skin { skin } else { told };
        Self { source, areas: areas.into_iter().map(polygon).collect(), by_skin }
    }
}

/// Vertices off the globe are left out; the builder of a depth index from the same features refuses them.
fn polygon(area: &Area) -> Polygon {
    let at = |point: &GeoPoint| vertex(point.lon_deg, point.lat_deg);
    area.rings().map(|ring| ring.points.iter().filter_map(at).collect()).collect()
}

/// The coverage of all charts of a set, the best chart first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coverage {
    charts: Vec<ChartCoverage>,
    /// Boxes of all areas with the number of their chart.
    boxes: Vec<(usize, Bounds)>,
}

/// Where one chart is in force.
#[derive(Debug, Clone, PartialEq)]
pub struct InForce<'a> {
    /// The chart, with its scale.
    pub source: &'a Source,
    /// The areas that no better chart covers: outer ring first, holes after it, not closed by a repeated vertex. Of all
    /// charts together they overlap nowhere.
    pub areas: Vec<Polygon>,
}

impl Coverage {
    /// Puts charts in order.
    pub fn new(mut charts: Vec<ChartCoverage>) -> Self {
        charts.sort_by_cached_key(|chart| chart.source.rank());
        let of_chart = |(number, chart): (usize, &ChartCoverage)| {
            let bounds = chart.areas.iter().map(move |area| (number, Bounds::of(area.iter().flatten())));
            bounds.collect::<Vec<_>>()
        };
        let boxes = charts.iter().enumerate().flat_map(of_chart).collect();
        Self { charts, boxes }
    }

    /// Each chart's own coverage, the best one first; supplements before all.
    pub fn charts(&self) -> &[ChartCoverage] {
        &self.charts
    }

    /// The chart in force at a place; `None` where none covers it.
    pub fn at(&self, place: LatLon) -> Option<&Source> {
        let at = vertex(place.lon_deg(), place.lat_deg())?;
        let here = Bounds { min: at, max: at };
        let mut areas = self.boxes.iter().zip(self.areas());
        let found = areas.find(|((_, bounds), area)| bounds.overlaps(&here) && holds(area, at));
        found.map(|((number, _), _)| &self.charts[*number].source)
    }

    /// Where each chart is in force, the best one first. Borders that cut each other are rounded to the grid there.
    pub fn in_force(&self) -> Vec<InForce<'_>> {
        let areas: Vec<&Polygon> = self.areas().collect();
        let mut all: Vec<InForce<'_>> =
            self.charts.iter().map(|chart| InForce { source: &chart.source, areas: Vec::new() }).collect();
        for (at, (number, bounds)) in self.boxes.iter().enumerate() {
            let mut left =
                Overlay::from_subj(&shape(areas[at])).overlay(OverlayRule::Subject, FillRule::EvenOdd);
            // Of one chart, too, an area counts once.
            let better = self.boxes[..at].iter().zip(&areas).filter(|((_, one), _)| one.overlaps(bounds));
            for (_, area) in better {
                left = Overlay::from_subj_and_clip(&left, &shape(area))
                    .overlay(OverlayRule::Difference, FillRule::EvenOdd);
            }
            let areas = left.iter().map(|area| area.iter().map(|ring| ring_of(ring)).collect());
            all[*number].areas.extend(areas);
        }
        all.retain(|chart| !chart.areas.is_empty());
        all
    }

    fn areas(&self) -> impl Iterator<Item = &Polygon> {
        self.charts.iter().flat_map(|chart| &chart.areas)
    }
}

/// In 64 bits: a chart may span the globe, and products of its extents must fit.
fn shape(area: &Polygon) -> Vec<Vec<IntPoint<i64>>> {
    let point = |at: &Vertex| IntPoint::new(i64::from(at[0]), i64::from(at[1]));
    area.iter().map(|ring| ring.iter().map(point).collect()).collect()
}

fn ring_of(ring: &[IntPoint<i64>]) -> Vec<Vertex> {
    // Cutting makes no vertex outside the areas, whose vertices are i32.
    ring.iter().map(|at| [at.x as i32, at.y as i32]).collect()
}

/// By the even-odd rule; a point on a border belongs to one of both sides.
fn holds(area: &Polygon, at: Vertex) -> bool {
    let crosses = |pair: &[Vertex]| {
        let (low, high) = if pair[0][1] <= pair[1][1] { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        let wide = |a: Vertex, b: Vertex, axis: usize| i128::from(a[axis]) - i128::from(b[axis]);
        let turn = wide(high, low, 0) * wide(at, low, 1) - wide(high, low, 1) * wide(at, low, 0);
        (low[1] > at[1]) != (high[1] > at[1]) && turn > 0
    };
    area.iter().flat_map(|ring| ring.windows(2)).filter(|pair| crosses(pair)).count() % 2 == 1
}

/// The place of a vertex, in degrees.
pub fn degrees(at: Vertex) -> GeoPoint {
    GeoPoint { lon_deg: f64::from(at[0]) / PER_DEGREE, lat_deg: f64::from(at[1]) / PER_DEGREE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::depth_index::IndexBuilder;
    use crate::s57::{Cell, NamedBytes};
    use testkit::Numbers;

    fn demo_cells() -> Vec<Cell> {
        let read =
            |file: &demo::DemoFile| Cell::read(NamedBytes { name: file.name, bytes: &file.bytes }, &[]);
        demo::archipelago().unwrap().iter().map(|file| read(file).unwrap()).collect()
    }

    fn shared_cells() -> Option<Vec<Cell>> {
        let names = ["GB4X0000.000", "GB5X01NE.000", "GB5X01NW.000", "GB5X01SE.000", "GB5X02SE.000"];
        let read = |name: &&str| {
            let bytes = std::fs::read(testkit::shared(&format!("data/charts/{name}"))?).unwrap();
            Some(Cell::read(NamedBytes { name, bytes: &bytes }, &[]).unwrap())
        };
        names.iter().map(read).collect()
    }

    /// At places all over the charts: one region at most holds each, and it is that of the chart in force; the index
    /// gives the same coverage back.
    fn agrees(cells: &[Cell]) {
        let mut builder = IndexBuilder::new();
        for cell in cells {
            builder.add_cell(cell).unwrap();
        }
        let index = builder.build().unwrap();
        let sources = index.sources().iter().map(|source| {
            let cell = cells.iter().find(|cell| cell.id.name.starts_with(&source.name)).unwrap();
            ChartCoverage::of(source.clone(), &cell.features)
        });
        let coverage = Coverage::new(sources.collect());
        assert_eq!(index.coverage(), coverage);
        let mut all = Bounds::EMPTY;
        coverage.boxes.iter().for_each(|(_, bounds)| all.add(*bounds));
        let regions = coverage.in_force();
        let mut numbers = Numbers(11);
        let mut in_force = vec![0; regions.len()];
        for _ in 0..20_000 {
            let at = [0, 1].map(|axis| {
                let (min, max) = (f64::from(all.min[axis]), f64::from(all.max[axis]));
                numbers.within(min, max).round() as i32
            });
            let place = degrees(at).place().unwrap();
            let within = |area: &&Polygon| {
                let closed =
                    area.iter().map(|ring| ring.iter().chain(ring.first()).copied().collect()).collect();
                holds(&closed, at)
            };
            let holding: Vec<usize> = (0..regions.len())
                .filter(|one| regions[*one].areas.iter().any(|area| within(&area)))
                .collect();
            let names: Vec<&str> = holding.iter().map(|one| regions[*one].source.name.as_str()).collect();
            let expected: Vec<&str> = coverage.at(place).iter().map(|source| source.name.as_str()).collect();
            assert_eq!(names, expected, "{at:?}");
            for one in holding {
                in_force[one] += 1;
            }
        }
        assert!(in_force.len() > 1 && in_force.iter().all(|count| *count > 10), "{in_force:?}");
    }

    #[test]
    fn regions_lie_side_by_side_on_the_demonstration_chart() {
        agrees(&demo_cells());
    }

    #[test]
    fn regions_lie_side_by_side_on_real_charts() {
        if let Some(cells) = shared_cells() {
            agrees(&cells);
        }
    }

    #[test]
    fn a_chart_without_coverage_covers_its_skin_and_a_supplement_nothing() {
        let cells = demo_cells();
        let silent: Vec<&Feature> =
            cells[0].features.iter().filter(|feature| !is_coverage(feature)).collect();
        let chart = ChartCoverage::of(Source::default(), silent.clone());
        assert!(chart.by_skin && chart.areas.len() > 10);
        let supplement = Source { supplement: true, ..Source::default() };
        assert!(ChartCoverage::of(supplement, silent).areas.is_empty());
    }
}
