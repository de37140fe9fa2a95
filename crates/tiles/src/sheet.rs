//! All that is drawn, in the world's square.

use crate::cut::Cover;
use crate::layer::Layer;
use crate::shape::{Shape, contains, shapes};
use crate::world::Bounds;
use charts::coverage::{ChartCoverage, Coverage, Source, is_coverage};
use charts::s57::{Attribute, AttributeCode, Feature, ObjectClass};
use std::collections::BTreeMap;

/// A chart and its features.
#[derive(Debug, Clone, PartialEq)]
pub struct SheetSource {
    /// What it is.
    pub source: Source,
    /// What it holds.
    pub features: Vec<Feature>,
}

/// What is known of an object; its number in the sheet is its `id` in tiles.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// Class.
    pub class: ObjectClass,
    /// Record number in its chart.
    pub record: u32,
    /// Number of its chart: [`Sheet::source`].
    pub source: u32,
    /// Attributes in the order of the file, then the national ones.
    pub attributes: Vec<Attribute>,
}

impl About {
    /// The value of an attribute; `None` where it is absent or empty.
    pub fn text(&self, code: AttributeCode) -> Option<&str> {
        let mut values = self.attributes.iter().filter(|one| one.code == code).map(|one| one.value.trim());
        values.find(|value| !value.is_empty())
    }

    /// Its value as a finite number.
    pub fn number(&self, code: AttributeCode) -> Option<f64> {
        self.text(code)?.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// Its name, the international one first.
    pub fn name(&self) -> Option<&str> {
        self.text(AttributeCode::OBJNAM).or_else(|| self.text(AttributeCode::NOBJNM))
    }
}

/// Something that is drawn, or only told of where it has no layer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Item {
    pub(crate) layer: Option<Layer>,
    pub(crate) object: u32,
    pub(crate) bounds: Bounds,
    pub(crate) shape: Shape,
}

/// Items that stand together, in one box.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    bounds: Bounds,
    first: usize,
    end: usize,
}

/// Items of a block.
const BLOCK: usize = 32;

/// A chart set as it is drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sheet {
    sources: Vec<Source>,
    objects: Vec<About>,
    by_record: BTreeMap<(u32, u32), u32>,
    /// Least depth of the charted area in which a danger lies (m), by object.
    around_m: BTreeMap<u32, f64>,
    /// By layer, those without one last; within a layer by where they are.
    items: Vec<Item>,
    /// By layer, [`Layer::ALL`] and those without one last.
    blocks: Vec<Vec<Block>>,
}

impl Sheet {
    /// Makes the sheet of these charts.
    pub fn new(mut charts: Vec<SheetSource>) -> Self {
        charts.sort_by_key(|chart| chart.source.rank());
        let covered = charts.iter().map(|chart| ChartCoverage::of(chart.source.clone(), &chart.features));
        let coverage = Coverage::new(covered.collect());
        let mut sheet = Self::default();
        let mut items = Vec::new();
        let mut better = Cover::default();
        for (chart, covered) in charts.into_iter().zip(coverage.charts()) {
            let source = sheet.sources.len() as u32;
            let supplement = chart.source.supplement;
            sheet.sources.push(chart.source);
            for feature in chart.features {
                let object = sheet.objects.len() as u32;
                let shapes = shapes(&feature);
                sheet.by_record.insert((source, feature.record), object);
                for shape in shapes {
                    let layer = layer(&feature, &shape);
                    let left = if supplement { Some(shape) } else { better.cut(shape) };
                    let Some(shape) = left else { continue };
                    if Layer::names(feature.class) && has_name(&feature) {
                        let shape = Shape::Point(shape.inner());
                        let layer = Some(Layer::Name);
                        items.push(Item { layer, object, bounds: shape.bounds(), shape });
                    }
                    items.push(Item { layer, object, bounds: shape.bounds(), shape });
                }
                sheet.objects.push(About {
                    class: feature.class,
                    record: feature.record,
                    source,
                    attributes: feature.attributes.into_iter().chain(feature.national).collect(),
                });
            }
            better.add(&covered.areas);
        }
        sheet.lay(items);
        sheet.around_m = sheet.surroundings();
        sheet
    }

    /// Where dangers lie, in the water of the chart that is drawn there.
    fn surroundings(&self) -> BTreeMap<u32, f64> {
        let dangers = self.items.iter().filter(|item| item.layer == Some(Layer::Danger));
        let around = |item: &Item| {
            let at = item.shape.inner();
            let holds = |water: &&Item| {
                let Shape::Areas(areas) = &water.shape else { return false };
                areas.iter().any(|area| contains(area, at))
            };
            let here = self.within(Some(Layer::Water), Bounds { min: at, max: at }).filter(holds);
            let depth = |water: &Item| self.about(water.object)?.number(AttributeCode::DRVAL1);
            let least_m = here.map(|water| depth(water).unwrap_or(f64::NEG_INFINITY)).reduce(f64::min);
            Some((item.object, least_m.filter(|least_m| least_m.is_finite())?))
        };
        dangers.filter_map(around).collect()
    }

    /// Least depth of the charted area in which a danger lies (m); `None` on land, in waters of unknown depth and
    /// for what is no danger.
    pub(crate) fn around_m(&self, danger: u32) -> Option<f64> {
        self.around_m.get(&danger).copied()
    }

    /// Sorts the items into blocks.
    fn lay(&mut self, mut items: Vec<Item>) {
        items.sort_by_cached_key(|item| {
            let middle = |min: i32, max: i32| (i64::from(min) + i64::from(max)) as u64 / 2;
            let (x, y) =
                (middle(item.bounds.min.x, item.bounds.max.x), middle(item.bounds.min.y, item.bounds.max.y));
            (index(item.layer), interleaved(x, y))
        });
        self.blocks = vec![Vec::new(); Layer::ALL.len() + 1];
        let mut first = 0;
        for group in items.chunk_by(|a, b| a.layer == b.layer) {
            let blocks = &mut self.blocks[index(group[0].layer)];
            for chunk in group.chunks(BLOCK) {
                let bounds = chunk.iter().fold(Bounds::EMPTY, |all, item| all.with(item.bounds));
                blocks.push(Block { bounds, first, end: first + chunk.len() });
                first += chunk.len();
            }
        }
        self.items = items;
    }

    /// The items of a layer that meet a box.
    pub(crate) fn within(&self, layer: Option<Layer>, bounds: Bounds) -> impl Iterator<Item = &Item> {
        let blocks = self.blocks.get(index(layer)).map(Vec::as_slice).unwrap_or_default();
        let met = blocks.iter().filter(move |block| block.bounds.meets(&bounds));
        met.flat_map(|block| &self.items[block.first..block.end])
            .filter(move |item| item.bounds.meets(&bounds))
    }

    /// What is known of an object.
    pub fn about(&self, object: u32) -> Option<&About> {
        self.objects.get(object as usize)
    }

    /// The chart of an object.
    pub fn source(&self, about: &About) -> &Source {
        &self.sources[about.source as usize]
    }

    /// The number of a chart's record.
    pub fn object_of(&self, chart: &str, record: u32) -> Option<u32> {
        let source = self.sources.iter().position(|source| source.name == chart)?;
        self.by_record.get(&(source as u32, record)).copied()
    }
}

fn index(layer: Option<Layer>) -> usize {
    layer.map_or(Layer::ALL.len(), |layer| layer as usize)
}

/// The bits of both, alternating: near places get near numbers (G. M. Morton, 1966).
fn interleaved(x: u64, y: u64) -> u64 {
    let spread = |value: u64| (0..32).fold(0, |out, bit| out | (value >> bit & 1) << (2 * bit));
    spread(x) | spread(y) << 1
}

fn has_name(feature: &Feature) -> bool {
    [AttributeCode::OBJNAM, AttributeCode::NOBJNM].into_iter().any(|code| feature.text(code).is_some())
}

fn layer(feature: &Feature, shape: &Shape) -> Option<Layer> {
    match shape {
        Shape::Sounding(..) => Some(Layer::Sounding),
        _ if feature.class == ObjectClass::M_COVR && !is_coverage(feature) => None,
        _ => Layer::of(feature.class, shape.kind()),
    }
}
