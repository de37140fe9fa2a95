//! The drawn part of one chart, in the world's square: its objects where no better chart hides them.

use crate::about::About;
use crate::cut::Cover;
use crate::layer::Layer;
use crate::shape::{Shape, shapes};
use crate::world::Bounds;
use charts::coverage::is_coverage;
use charts::s57::{AttributeCode, Feature, ObjectClass};

/// An object that is drawn, or only listed where it has no layer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Item {
    pub(crate) layer: Option<Layer>,
    /// Number in its chart.
    pub(crate) object: u32,
    pub(crate) bounds: Bounds,
    pub(crate) shape: Shape,
}

impl Item {
    /// The sort key of items of a layer: near places get near numbers.
    pub(crate) fn place(&self) -> u64 {
        let middle = |min: i32, max: i32| (i64::from(min) + i64::from(max)) as u64 / 2;
        let Bounds { min, max } = self.bounds;
        interleaved(middle(min.x, max.x), middle(min.y, max.y))
    }
}

/// Neighbouring items, in one box.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    bounds: Bounds,
    first: usize,
    end: usize,
}

/// Items of a block.
const BLOCK: usize = 32;

/// One chart as drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Piece {
    /// By their number in the chart.
    pub(crate) objects: Vec<(u32, About)>,
    /// By layer, those without one last; within a layer by where they are.
    items: Vec<Item>,
    /// By layer, [`Layer::ALL`] and those without one last.
    blocks: Vec<Vec<Block>>,
}

impl Piece {
    /// Of a chart of this number, where these better charts do not cover it.
    pub(crate) fn new(source: u32, features: Vec<Feature>, better: Option<&Cover>) -> Self {
        let (mut objects, mut items) = (Vec::with_capacity(features.len()), Vec::new());
        for (object, feature) in (0..).zip(features) {
            for shape in shapes(&feature) {
                let layer = layer(&feature, &shape);
                let left = better.map_or(Some(shape.clone()), |better| better.cut(shape));
                let Some(shape) = left else { continue };
                if Layer::names(feature.class) && has_name(&feature) {
                    let shape = Shape::Point(shape.inner());
                    let layer = Some(Layer::Name);
                    items.push(Item { layer, object, bounds: shape.bounds(), shape });
                }
                items.push(Item { layer, object, bounds: shape.bounds(), shape });
            }
            let attributes = feature.attributes.into_iter().chain(feature.national).collect();
            let (class, record) = (feature.class, feature.record);
            objects.push((object, About { class, record, source, attributes }));
        }
        Self::of(objects, items)
    }

    /// Sorts the items into blocks.
    pub(crate) fn of(objects: Vec<(u32, About)>, mut items: Vec<Item>) -> Self {
        items.sort_by_cached_key(|item| (index(item.layer), item.place()));
        let mut blocks = vec![Vec::new(); Layer::ALL.len() + 1];
        let mut first = 0;
        for group in items.chunk_by(|a, b| a.layer == b.layer) {
            let blocks = &mut blocks[index(group[0].layer)];
            for chunk in group.chunks(BLOCK) {
                let bounds = chunk.iter().fold(Bounds::EMPTY, |all, item| all.with(item.bounds));
                blocks.push(Block { bounds, first, end: first + chunk.len() });
                first += chunk.len();
            }
        }
        Self { objects, items, blocks }
    }

    pub(crate) fn items(&self) -> &[Item] {
        &self.items
    }

    /// The items of a layer that meet a box.
    pub(crate) fn within(&self, layer: Option<Layer>, bounds: Bounds) -> impl Iterator<Item = &Item> {
        let blocks = self.blocks.get(index(layer)).map(Vec::as_slice).unwrap_or_default();
        let met = blocks.iter().filter(move |block| block.bounds.meets(&bounds));
        met.flat_map(|block| &self.items[block.first..block.end])
            .filter(move |item| item.bounds.meets(&bounds))
    }

    /// The data of an object.
    pub(crate) fn about(&self, object: u32) -> Option<&About> {
        let at = self.objects.binary_search_by_key(&object, |(number, _)| *number).ok()?;
        Some(&self.objects[at].1)
    }

    /// The last object of a record, which is the only one in a sound chart.
    pub(crate) fn of_record(&self, record: u32) -> Option<u32> {
        self.objects.iter().rev().find(|(_, about)| about.record == record).map(|(object, _)| *object)
    }

    /// About how much memory it takes.
    pub(crate) fn bytes(&self) -> usize {
        let text = |about: &About| about.attributes.iter().map(|one| 56 + one.value.len()).sum::<usize>();
        let objects: usize = self.objects.iter().map(|(_, about)| 48 + text(about)).sum();
        let items: usize = self.items.iter().map(|item| 72 + item.shape.bytes()).sum();
        objects + items + 1_000
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
