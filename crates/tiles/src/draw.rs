//! Draws one tile.

use crate::clip::{Frame, simplified, simplified_ring};
use crate::layer::Layer;
use crate::mvt::{Drawn, EXTENT, LayerWriter, Value};
use crate::shape::Shape;
use crate::sheet::{About, Item, Sheet};
use crate::world::{BITS, Bounds, Point};
use charts::depth_index::{clearance_m, is_structure};
use charts::s57::{AttributeCode, value_words};
use std::collections::BTreeMap;

/// The greatest zoom for which there are tiles; maps enlarge those beyond.
pub const MOST_ZOOM: u8 = 18;
/// The zoom from which on every danger, aid and name is drawn; before, the first of each square of the tile: of
/// dangers the shallowest, unknown depths first of all.
pub const ALL_DANGERS: u8 = 11;

/// A tile is 2^12 units wide.
const TILE_BITS: u32 = 12;
/// Units around a tile that are drawn too, so that lines and symbols go on.
const BUFFER: i32 = 64;
/// How far simplified geometry may be off (units): half a pixel where a tile has 512.
const WITHIN: f64 = 4.0;
/// What is smaller is not drawn (units), but dangers are, as points.
const SMALLEST: i64 = 2;
/// Squares in which soundings and points are thinned: 2^8 units wide, 16 by 16 in a tile.
const SQUARE_BITS: u32 = 8;

/// There is no such tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoTile {
    /// The zoom is beyond [`MOST_ZOOM`].
    #[error("zoom {0} is beyond {MOST_ZOOM}, the last for which there are tiles")]
    Zoom(u8),
    /// The zoom has fewer columns or rows.
    #[error("zoom {zoom} has columns and rows from 0 to {last}")]
    Place {
        /// The zoom.
        zoom: u8,
        /// The last column and row.
        last: u32,
    },
}

impl Sheet {
    /// The vector tile of a zoom, column and row; empty where nothing is charted.
    ///
    /// # Errors
    /// When there is no such tile.
    pub fn tile(&self, zoom: u8, x: u32, y: u32) -> Result<Vec<u8>, NoTile> {
        if zoom > MOST_ZOOM {
            return Err(NoTile::Zoom(zoom));
        }
        let last = (1_u32 << zoom) - 1;
        if x > last || y > last {
            return Err(NoTile::Place { zoom, last });
        }
        let bits = BITS - u32::from(zoom);
        let view = View {
            sheet: self,
            zoom,
            origin: Point::new((x << bits) as i32, (y << bits) as i32),
            bits: bits - TILE_BITS,
        };
        let mut tile = Vec::new();
        for layer in Layer::ALL.into_iter().filter(|layer| layer.first_zoom() <= zoom) {
            view.layer(layer, &mut tile);
        }
        Ok(tile)
    }
}

/// What one tile looks at.
struct View<'a> {
    sheet: &'a Sheet,
    zoom: u8,
    origin: Point,
    /// A unit of the tile is 2^bits units of the world.
    bits: u32,
}

impl View<'_> {
    const FRAME: Frame = Frame { min: -BUFFER, max: EXTENT + BUFFER };

    fn layer(&self, layer: Layer, tile: &mut Vec<u8>) {
        let mut writer = LayerWriter::new(layer.name());
        let thinned = match layer {
            Layer::Sounding => true,
            Layer::Danger | Layer::Aid | Layer::Name => self.zoom < ALL_DANGERS,
            _ => false,
        };
        if thinned {
            for item in self.firsts(layer) {
                self.item(layer, item, &mut writer);
            }
        }
        for item in self.sheet.within(Some(layer), self.bounds(0)) {
            let point = matches!(item.shape, Shape::Point(_) | Shape::Sounding(..));
            if !(thinned && point) {
                self.item(layer, item, &mut writer);
            }
        }
        writer.finish(tile);
    }

    /// The tile with its buffer, to whole multiples of 2^bits of the world's units.
    fn bounds(&self, bits: u32) -> Bounds {
        let low = |value: i32| (value - (BUFFER << self.bits)) >> bits << bits;
        let high = |value: i32| {
            let end = i64::from(value) + (i64::from(EXTENT + BUFFER) << self.bits);
            (((end >> bits) + 1) << bits).min(i64::from(i32::MAX)) as i32
        };
        Bounds {
            min: Point::new(low(self.origin.x), low(self.origin.y)),
            max: Point::new(high(self.origin.x), high(self.origin.y)),
        }
    }

    /// Of the points of each square the first by rank. Squares are the same for all tiles of a zoom.
    fn firsts(&self, layer: Layer) -> impl Iterator<Item = &Item> {
        let bits = self.bits + SQUARE_BITS;
        let mut squares: BTreeMap<(i32, i32), (f64, &Item)> = BTreeMap::new();
        for item in self.sheet.within(Some(layer), self.bounds(bits)) {
            let (Shape::Point(at) | Shape::Sounding(at, _)) = item.shape else { continue };
            let rank = self.rank(layer, item);
            let square = squares.entry((at.x >> bits, at.y >> bits)).or_insert((rank, item));
            if (rank, item.object, at) < (square.0, square.1.object, square.1.bounds.min) {
                *square = (rank, item);
            }
        }
        squares.into_values().map(|(_, item)| item)
    }

    fn rank(&self, layer: Layer, item: &Item) -> f64 {
        match item.shape {
            Shape::Sounding(_, depth_m) => depth_m,
            _ if layer == Layer::Danger => {
                let about = self.sheet.about(item.object);
                // Buildings have no depth either, and must not take the place of a rock.
                let last = about.is_some_and(|about| is_structure(about.class));
                let unknown = if last { f64::INFINITY } else { f64::NEG_INFINITY };
                about.and_then(|about| about.number(AttributeCode::VALSOU)).unwrap_or(unknown)
            }
            _ => 0.0,
        }
    }

    fn item(&self, layer: Layer, item: &Item, writer: &mut LayerWriter) {
        let Some(about) = self.sheet.about(item.object) else { return };
        let small = item.bounds.size() >> self.bits < SMALLEST;
        let drawn = match &item.shape {
            Shape::Point(at) | Shape::Sounding(at, _) => Drawn::Point(self.local(*at)),
            Shape::Lines(_) | Shape::Areas(_) if small => {
                if layer != Layer::Danger {
                    return;
                }
                let middle = |min: i32, max: i32| min + (max - min) / 2;
                let Bounds { min, max } = item.bounds;
                Drawn::Point(self.local(Point::new(middle(min.x, max.x), middle(min.y, max.y))))
            }
            Shape::Lines(lines) => {
                let clipped = lines.iter().flat_map(|line| Self::FRAME.line(&self.locals(line)));
                Drawn::Lines(clipped.map(|line| simplified(&line, WITHIN)).collect())
            }
            Shape::Areas(areas) => {
                let ring = |ring: &Vec<Point>| {
                    let clipped = Self::FRAME.ring(self.locals(ring));
                    simplified_ring(&clipped, WITHIN)
                };
                Drawn::Areas(areas.iter().map(|area| area.iter().map(ring).collect()).collect())
            }
        };
        if let Drawn::Point(at) = drawn
            && !Self::FRAME.holds(at)
        {
            return;
        }
        self.write(layer, item, about, &drawn, writer);
    }

    fn write(&self, layer: Layer, item: &Item, about: &About, drawn: &Drawn, writer: &mut LayerWriter) {
        let class = about.class.to_string();
        let scale = f64::from(self.sheet.source(about).scale);
        let mut says = vec![("scale", Value::Number(scale)), ("cls", Value::Text(&class))];
        let number = |code| about.number(code).map(Value::Number);
        let words = |code: Option<AttributeCode>| {
            let code = code?;
            Some(value_words(code, about.text(code)?).replace(", ", ","))
        };
        let (colour, shape);
        match layer {
            Layer::Water => {
                says.extend(number(AttributeCode::DRVAL1).map(|value| ("drval1", value)));
                says.extend(number(AttributeCode::DRVAL2).map(|value| ("drval2", value)));
            }
            Layer::Contour => says.extend(number(AttributeCode::VALDCO).map(|value| ("valdco", value))),
            Layer::Sounding => {
                if let Shape::Sounding(_, depth_m) = item.shape {
                    says.push(("depth_m", Value::Number(depth_m)));
                }
            }
            Layer::Danger => {
                says.extend(number(AttributeCode::VALSOU).map(|value| ("depth_m", value)));
                says.extend(number(AttributeCode::WATLEV).map(|value| ("watlev", value)));
                let around = self.sheet.around_m(item.object).map(Value::Number);
                says.extend(around.map(|value| ("around_m", value)));
            }
            Layer::Overhead => {
                let clearance_m = clearance_m(|code| about.number(code));
                says.extend(clearance_m.map(|value| ("clearance_m", Value::Number(value))));
            }
            Layer::Aid => {
                colour = words(AttributeCode::from_acronym("COLOUR"));
                shape = words(AttributeCode::from_acronym("BOYSHP"))
                    .or_else(|| words(AttributeCode::from_acronym("BCNSHP")));
                says.extend(colour.as_deref().map(|value| ("colour", Value::Text(value))));
                says.extend(shape.as_deref().map(|value| ("shape", Value::Text(value))));
                says.extend(about.name().map(|value| ("name", Value::Text(value))));
            }
            Layer::Name => says.extend(about.name().map(|value| ("text", Value::Text(value)))),
            Layer::Area | Layer::Cover | Layer::Land | Layer::Coast => {}
        }
        writer.add(item.object, drawn, &says);
    }

    /// A point in the tile's units, to the nearest.
    fn local(&self, at: Point) -> Point {
        let half = (1 << self.bits) >> 1;
        Point::new((at.x - self.origin.x + half) >> self.bits, (at.y - self.origin.y + half) >> self.bits)
    }

    /// A line in the tile's units without repeated points.
    fn locals(&self, line: &[Point]) -> Vec<Point> {
        let mut out: Vec<Point> = Vec::with_capacity(line.len().min(1024));
        for at in line {
            let local = self.local(*at);
            if out.last() != Some(&local) {
                out.push(local);
            }
        }
        out
    }
}
