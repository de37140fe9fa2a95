//! Draws one tile.

use crate::about::About;
use crate::clip::{Frame, simplified, simplified_ring};
use crate::layer::Layer;
use crate::mvt::{Drawn, EXTENT, LayerWriter, Value};
use crate::shape::Shape;
use crate::sheet::{Changed, Placed, Scene, Sheet};
use crate::world::{BITS, Bounds, LAST_ZOOM, Point, SMALLEST, TILE_BITS, local, rounded};
use charts::depth_index::{clearance_m, is_structure};
use charts::s57::{AttributeCode, value_words};
use std::collections::BTreeMap;

/// The greatest zoom for which there are tiles; maps enlarge those beyond.
pub const MOST_ZOOM: u8 = 18;
/// The zoom from which on every danger, aid and name is drawn; before, the first of each square of the tile: of
/// dangers the shallowest, unknown depths first of all.
pub const ALL_DANGERS: u8 = 11;

/// Units around a tile that are drawn too, so that lines and symbols continue across its edge.
const BUFFER: i32 = 64;
/// How far simplified geometry may be off (units): half a pixel where a tile has 512.
const WITHIN: f64 = 4.0;
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
    /// The charts are others by now.
    #[error(transparent)]
    Changed(#[from] Changed),
}

impl Sheet {
    /// The vector tile of a zoom, column and row; empty where nothing is charted.
    ///
    /// # Errors
    /// When there is no such tile, or the charts are others by now.
    pub fn tile(&self, zoom: u8, x: u32, y: u32) -> Result<Vec<u8>, NoTile> {
        if zoom > MOST_ZOOM {
            return Err(NoTile::Zoom(zoom));
        }
        let last = (1_u32 << zoom) - 1;
        if x > last || y > last {
            return Err(NoTile::Place { zoom, last });
        }
        let bits = BITS - u32::from(zoom);
        let place = Place {
            zoom,
            origin: Point::new((x << bits) as i32, (y << bits) as i32),
            bits: bits - TILE_BITS,
        };
        // Points are thinned by squares that reach beyond the buffer.
        let view = View { scene: self.scene(place.bounds(place.bits + SQUARE_BITS), zoom)?, place };
        let mut tile = Vec::new();
        for layer in Layer::ALL.into_iter().filter(|layer| layer.first_zoom() <= zoom) {
            view.layer(layer, &mut tile)?;
        }
        Ok(tile)
    }
}

/// Where a tile lies.
#[derive(Debug, Clone, Copy)]
struct Place {
    zoom: u8,
    origin: Point,
    /// A unit of the tile is 2^bits units of the world.
    bits: u32,
}

impl Place {
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

    /// A point in the tile's units, to the nearest.
    fn local(&self, at: Point) -> Point {
        local(at, self.origin, self.bits)
    }

    /// A line in the tile's units without repeated points.
    fn locals(&self, line: &[Point]) -> Vec<Point> {
        if self.zoom <= LAST_ZOOM {
            // An overview is rounded already, from the corner of the world on.
            let (x, y) = (self.origin.x >> self.bits, self.origin.y >> self.bits);
            return line.iter().map(|at| Point::new(at.x - x, at.y - y)).collect();
        }
        rounded(line, self.origin, self.bits)
    }
}

/// The input of one tile.
struct View<'a> {
    scene: Scene<'a>,
    place: Place,
}

impl View<'_> {
    const FRAME: Frame = Frame { min: -BUFFER, max: EXTENT + BUFFER };

    fn layer(&self, layer: Layer, tile: &mut Vec<u8>) -> Result<(), Changed> {
        let mut writer = LayerWriter::new(layer.name());
        let thinned = match layer {
            Layer::Sounding => true,
            Layer::Danger | Layer::Aid | Layer::Name => self.place.zoom < ALL_DANGERS,
            _ => false,
        };
        if thinned {
            for placed in self.firsts(layer) {
                self.item(layer, placed, &mut writer)?;
            }
        }
        for placed in self.scene.within(Some(layer), self.place.bounds(0)) {
            let point = matches!(placed.item.shape, Shape::Point(_) | Shape::Sounding(..));
            if !(thinned && point) {
                self.item(layer, placed, &mut writer)?;
            }
        }
        writer.finish(tile);
        Ok(())
    }

    /// Of the points of each square the first by rank. Squares are the same for all tiles of a zoom.
    fn firsts(&self, layer: Layer) -> impl Iterator<Item = Placed<'_>> {
        let bits = self.place.bits + SQUARE_BITS;
        let mut squares: BTreeMap<(i32, i32), (f64, Placed<'_>)> = BTreeMap::new();
        for placed in self.scene.within(Some(layer), self.place.bounds(bits)) {
            let (Shape::Point(at) | Shape::Sounding(at, _)) = placed.item.shape else { continue };
            let rank = rank(layer, &placed);
            let square = squares.entry((at.x >> bits, at.y >> bits)).or_insert((rank, placed));
            let first = (square.0, square.1.object, square.1.item.bounds.min);
            if (rank, placed.object, at) < first {
                *square = (rank, placed);
            }
        }
        squares.into_values().map(|(_, placed)| placed)
    }

    fn item(&self, layer: Layer, placed: Placed<'_>, writer: &mut LayerWriter) -> Result<(), Changed> {
        let Placed { item, about: Some(about), .. } = placed else { return Ok(()) };
        let small = item.bounds.size() >> self.place.bits < SMALLEST;
        let drawn = match &item.shape {
            Shape::Point(at) | Shape::Sounding(at, _) => Drawn::Point(self.place.local(*at)),
            Shape::Lines(_) | Shape::Areas(_) if small => {
                if layer != Layer::Danger {
                    return Ok(());
                }
                let middle = |min: i32, max: i32| min + (max - min) / 2;
                let Bounds { min, max } = item.bounds;
                Drawn::Point(self.place.local(Point::new(middle(min.x, max.x), middle(min.y, max.y))))
            }
            Shape::Lines(lines) => {
                let clipped = lines.iter().flat_map(|line| Self::FRAME.line(&self.place.locals(line)));
                Drawn::Lines(clipped.map(|line| simplified(&line, WITHIN)).collect())
            }
            Shape::Areas(areas) => {
                let ring = |ring: &Vec<Point>| {
                    let clipped = Self::FRAME.ring(self.place.locals(ring));
                    simplified_ring(&clipped, WITHIN)
                };
                Drawn::Areas(areas.iter().map(|area| area.iter().map(ring).collect()).collect())
            }
        };
        if let Drawn::Point(at) = drawn
            && !Self::FRAME.holds(at)
        {
            return Ok(());
        }
        self.write(layer, placed, about, &drawn, writer)
    }

    fn write(
        &self,
        layer: Layer,
        placed: Placed<'_>,
        about: &About,
        drawn: &Drawn,
        writer: &mut LayerWriter,
    ) -> Result<(), Changed> {
        let class = about.class.to_string();
        let scale = f64::from(self.scene.sheet.source(about).scale);
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
                if let Shape::Sounding(_, depth_m) = placed.item.shape {
                    says.push(("depth_m", Value::Number(depth_m)));
                }
            }
            Layer::Danger => {
                says.extend(number(AttributeCode::VALSOU).map(|value| ("depth_m", value)));
                says.extend(number(AttributeCode::WATLEV).map(|value| ("watlev", value)));
                let around = self.scene.around_m(placed.item)?.map(Value::Number);
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
        writer.add(placed.object, drawn, &says);
        Ok(())
    }
}

fn rank(layer: Layer, placed: &Placed<'_>) -> f64 {
    match placed.item.shape {
        Shape::Sounding(_, depth_m) => depth_m,
        _ if layer == Layer::Danger => {
            // Buildings have no depth either, and must not take the place of a rock.
            let last = placed.about.is_some_and(|about| is_structure(about.class));
            let unknown = if last { f64::INFINITY } else { f64::NEG_INFINITY };
            placed.about.and_then(|about| about.number(AttributeCode::VALSOU)).unwrap_or(unknown)
        }
        _ => 0.0,
    }
}
