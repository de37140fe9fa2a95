//! Charts for small zooms, at which a tile shows hundreds of them: of each chart what is seen at a zoom, its vertices in
//! the units of that zoom's tiles. Drawn, it gives the very bytes that the chart itself would give, for it has gone
//! through the first steps of drawing already; as bytes it is kept from one start of a server to the next.
//!
//! Layout, little-endian: [`MAGIC`], then lists of objects and items, each a count (u32) and its rows. Lines are steps from
//! one vertex to the next, most of which take two bytes. Bytes that are not an overview answer `None`, and it is made again
//! of the chart.

use crate::about::About;
use crate::layer::Layer;
use crate::piece::{Item, Piece};
use crate::shape::{Polygon, Shape};
use crate::world::{BITS, Bounds, Point, SMALLEST, TILE_BITS, rounded};
use charts::s57::{Attribute, AttributeCode, ObjectClass};

/// Another one whenever the layout or the way of drawing changes.
const MAGIC: &[u8; 8] = b"LUTRAOV2";

/// The properties in tiles of these zooms.
const KEPT: [AttributeCode; 3] = [AttributeCode::DRVAL1, AttributeCode::DRVAL2, AttributeCode::VALDCO];

/// The visible part of a chart at a zoom up to [`LAST_ZOOM`](crate::world::LAST_ZOOM).
pub(crate) fn overview(chart: &Piece, zoom: u8) -> Piece {
    let bits = BITS - u32::from(zoom) - TILE_BITS;
    let seen = |item: &&Item| {
        let drawn = item.layer.is_some_and(|layer| layer.first_zoom() <= zoom);
        drawn && item.bounds.size() >> bits >= SMALLEST
    };
    let line = |line: &Vec<Point>| rounded(line, Point::new(0, 0), bits);
    let items: Vec<Item> = chart
        .items()
        .iter()
        .filter(seen)
        .map(|item| {
            let shape = match &item.shape {
                Shape::Lines(lines) => Shape::Lines(lines.iter().map(line).collect()),
                Shape::Areas(areas) => {
                    Shape::Areas(areas.iter().map(|area| area.iter().map(line).collect()).collect())
                }
                point => point.clone(),
            };
            Item { shape, ..item.clone() }
        })
        .collect();
    let mut objects: Vec<(u32, About)> = Vec::new();
    let mut numbers: Vec<u32> = items.iter().map(|item| item.object).collect();
    numbers.sort_unstable();
    numbers.dedup();
    for object in numbers {
        if let Some(about) = chart.about(object) {
            let told = about.attributes.iter().filter(|one| KEPT.contains(&one.code)).cloned();
            objects.push((object, About { attributes: told.collect(), ..about.clone() }));
        }
    }
    Piece::of(objects, items)
}

/// An overview as bytes.
pub(crate) fn to_bytes(piece: &Piece) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    let number = |out: &mut Vec<u8>, value: u32| out.extend(value.to_le_bytes());
    let point = |out: &mut Vec<u8>, at: Point| {
        out.extend(at.x.to_le_bytes());
        out.extend(at.y.to_le_bytes());
    };
    let line = |out: &mut Vec<u8>, line: &Vec<Point>| {
        number(out, line.len() as u32);
        let mut pen = Point::new(0, 0);
        for at in line {
            step(out, at.x, pen.x);
            step(out, at.y, pen.y);
            pen = *at;
        }
    };
    number(&mut out, piece.objects.len() as u32);
    for (object, about) in &piece.objects {
        number(&mut out, *object);
        number(&mut out, about.record);
        out.extend(about.class.0.to_le_bytes());
        number(&mut out, about.attributes.len() as u32);
        for one in &about.attributes {
            out.extend(one.code.0.to_le_bytes());
            number(&mut out, one.value.len() as u32);
            out.extend(one.value.as_bytes());
        }
    }
    let drawn = |item: &&Item| matches!(item.shape, Shape::Lines(_) | Shape::Areas(_));
    number(&mut out, piece.items().iter().filter(drawn).count() as u32);
    for item in piece.items().iter().filter(drawn) {
        out.push(item.layer.map_or(u8::MAX, |layer| layer as u8));
        number(&mut out, item.object);
        point(&mut out, item.bounds.min);
        point(&mut out, item.bounds.max);
        let areas: &[Polygon] = match &item.shape {
            Shape::Areas(areas) => areas,
            Shape::Lines(lines) => std::slice::from_ref(lines),
            Shape::Point(_) | Shape::Sounding(..) => &[],
        };
        out.push(u8::from(matches!(item.shape, Shape::Areas(_))));
        number(&mut out, areas.len() as u32);
        for area in areas {
            number(&mut out, area.len() as u32);
            for ring in area {
                line(&mut out, ring);
            }
        }
    }
    out
}

/// The overview of bytes, of a chart of this number.
pub(crate) fn from_bytes(source: u32, bytes: &[u8]) -> Option<Piece> {
    let mut reader = Reader(bytes.strip_prefix(MAGIC)?);
    let objects = reader.list(|reader| {
        let (object, record, class) = (reader.u32()?, reader.u32()?, ObjectClass(reader.u16()?));
        let attributes = reader.list(|reader| {
            let code = AttributeCode(reader.u16()?);
            let length = reader.u32()? as usize;
            let value = std::str::from_utf8(reader.take(length)?).ok()?.to_owned();
            Some(Attribute { code, value })
        })?;
        Some((object, About { class, record, source, attributes }))
    })?;
    let items = reader.list(|reader| {
        let layer = Some(*Layer::ALL.get(usize::from(reader.u8()?))?);
        let object = reader.u32()?;
        let bounds = Bounds { min: reader.point()?, max: reader.point()? };
        let filled = reader.u8()? != 0;
        let mut areas = reader.list(|reader| reader.list(Reader::line))?;
        let shape = if filled { Shape::Areas(areas) } else { Shape::Lines(areas.pop()?) };
        Some(Item { layer, object, bounds, shape })
    })?;
    let sorted = objects.is_sorted_by(|a, b| a.0 < b.0);
    (reader.0.is_empty() && sorted).then(|| Piece::of(objects, items))
}

/// The step to a coordinate: the sign in the lowest bit, seven bits a byte, the lowest first.
fn step(out: &mut Vec<u8>, to: i32, from: i32) {
    let step = i64::from(to) - i64::from(from);
    let mut left = (step << 1 ^ step >> 63) as u64;
    while left >= 0x80 {
        out.push(left as u8 | 0x80);
        left >>= 7;
    }
    out.push(left as u8);
}

/// Bytes that are read from the front.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn u8(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn point(&mut self) -> Option<Point> {
        // Written as i32.
        Some(Point::new(self.u32()? as i32, self.u32()? as i32))
    }

    /// The coordinate that a step leads to; `None` beyond those there are.
    fn step(&mut self, from: i32) -> Option<i32> {
        let mut value = 0_u64;
        for shift in (0..35).step_by(7) {
            let byte = self.u8()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                // At most 35 bits.
                let step = (value >> 1) as i64 ^ -((value & 1) as i64);
                return i32::try_from(i64::from(from) + step).ok();
            }
        }
        None
    }

    fn line(&mut self) -> Option<Vec<Point>> {
        let mut pen = Point::new(0, 0);
        self.list(|reader| {
            pen = Point::new(reader.step(pen.x)?, reader.step(pen.y)?);
            Some(pen)
        })
    }

    /// A list; it grows as its rows are there, whatever its count says.
    fn list<T>(&mut self, mut row: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()?;
        let mut rows = Vec::new();
        for _ in 0..count {
            rows.push(row(self)?);
        }
        Some(rows)
    }
}
