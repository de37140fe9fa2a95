//! Mapbox vector tiles, version 2.1, as bytes. Own code in place of the crate `geozero` (0.14), whose writer neither
//! turns rings as the format asks nor leaves out those without area, and would bring a library of protocol buffers for
//! seven kinds of field.

use crate::shape::edges;
use crate::world::Point;
use std::collections::BTreeMap;

/// Units of a tile's side.
pub(crate) const EXTENT: i32 = 4096;

/// The properties of a feature.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Value<'a> {
    Text(&'a str),
    Number(f64),
}

/// A geometry in tile units.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Drawn {
    Point(Point),
    Lines(Vec<Vec<Point>>),
    /// Outer rings, each followed by its holes.
    Areas(Vec<Vec<Vec<Point>>>),
}

/// A layer that is being written.
#[derive(Debug)]
pub(crate) struct LayerWriter {
    name: &'static str,
    keys: Vec<&'static str>,
    values: BTreeMap<Vec<u8>, u32>,
    written: Vec<Vec<u8>>,
    features: Vec<u8>,
}

impl LayerWriter {
    pub(crate) fn new(name: &'static str) -> Self {
        Self { name, keys: Vec::new(), values: BTreeMap::new(), written: Vec::new(), features: Vec::new() }
    }

    /// Adds a feature; one without any geometry is left out.
    pub(crate) fn add(&mut self, id: u32, drawn: &Drawn, says: &[(&'static str, Value<'_>)]) {
        let (kind, geometry) = commands(drawn);
        if geometry.is_empty() {
            return;
        }
        let tags: Vec<u32> =
            says.iter().flat_map(|(key, value)| [self.key(key), self.value(*value)]).collect();
        let mut feature = Vec::new();
        number(&mut feature, 1, u64::from(id));
        packed(&mut feature, 2, &tags);
        number(&mut feature, 3, kind);
        packed(&mut feature, 4, &geometry);
        bytes(&mut self.features, 2, &feature);
    }

    fn key(&mut self, key: &'static str) -> u32 {
        let at = self.keys.iter().position(|one| *one == key).unwrap_or_else(|| {
            self.keys.push(key);
            self.keys.len() - 1
        });
        at as u32
    }

    fn value(&mut self, value: Value<'_>) -> u32 {
        let mut out = Vec::new();
        match value {
            Value::Text(text) => bytes(&mut out, 1, text.as_bytes()),
            Value::Number(value) if (0.0..1e9).contains(&value) && value.fract() == 0.0 => {
                number(&mut out, 5, value as u64);
            }
            Value::Number(value) => {
                varint(&mut out, 3 << 3 | 1);
                out.extend(value.to_le_bytes());
            }
        }
        let next = self.written.len() as u32;
        *self.values.entry(out).or_insert_with_key(|out| {
            self.written.push(out.clone());
            next
        })
    }

    /// Puts the layer into a tile, unless it is empty.
    pub(crate) fn finish(self, tile: &mut Vec<u8>) {
        if self.features.is_empty() {
            return;
        }
        let mut layer = Vec::with_capacity(self.features.len() + 256);
        number(&mut layer, 15, 2);
        bytes(&mut layer, 1, self.name.as_bytes());
        layer.extend(&self.features);
        for key in &self.keys {
            bytes(&mut layer, 3, key.as_bytes());
        }
        for value in &self.written {
            bytes(&mut layer, 4, value);
        }
        number(&mut layer, 5, EXTENT as u64);
        bytes(tile, 3, &layer);
    }
}

/// Type and commands of a geometry; none where nothing is left of it.
fn commands(drawn: &Drawn) -> (u64, Vec<u32>) {
    let mut out = Vec::new();
    let mut pen = Point::new(0, 0);
    let kind = match drawn {
        Drawn::Point(at) => {
            out.push(1 << 3 | 1);
            step(&mut out, &mut pen, *at);
            1
        }
        Drawn::Lines(lines) => {
            for line in lines.iter().filter(|line| line.len() >= 2) {
                stroke(&mut out, &mut pen, line.iter().copied());
            }
            2
        }
        Drawn::Areas(areas) => {
            for area in areas {
                for (number, ring) in area.iter().enumerate() {
                    let twice = twice_area(ring);
                    if ring.len() < 3 || twice == 0 {
                        // Without its outer ring nothing is left of an area.
                        if number == 0 {
                            break;
                        }
                        continue;
                    }
                    // Outer rings have a positive area with y down, holes a negative one.
                    if (twice > 0) == (number == 0) {
                        stroke(&mut out, &mut pen, ring.iter().copied());
                    } else {
                        stroke(&mut out, &mut pen, ring.iter().rev().copied());
                    }
                    out.push(1 << 3 | 7);
                }
            }
            3
        }
    };
    (kind, out)
}

fn stroke(out: &mut Vec<u32>, pen: &mut Point, points: impl ExactSizeIterator<Item = Point>) {
    let count = points.len() as u32;
    for (number, at) in points.enumerate() {
        match number {
            0 => out.push(1 << 3 | 1),
            1 => out.push((count - 1) << 3 | 2),
            _ => {}
        }
        step(out, pen, at);
    }
}

fn step(out: &mut Vec<u32>, pen: &mut Point, to: Point) {
    let zigzag = |value: i32| (value << 1 ^ value >> 31) as u32;
    out.extend([zigzag(to.x - pen.x), zigzag(to.y - pen.y)]);
    *pen = to;
}

/// Twice the signed area of a ring.
fn twice_area(ring: &[Point]) -> i64 {
    edges(ring).map(|(a, b)| i64::from(a.x) * i64::from(b.y) - i64::from(b.x) * i64::from(a.y)).sum()
}

fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn number(out: &mut Vec<u8>, field: u64, value: u64) {
    varint(out, field << 3);
    varint(out, value);
}

fn bytes(out: &mut Vec<u8>, field: u64, value: &[u8]) {
    varint(out, field << 3 | 2);
    varint(out, value.len() as u64);
    out.extend(value);
}

fn packed(out: &mut Vec<u8>, field: u64, values: &[u32]) {
    let mut inner = Vec::with_capacity(values.len() * 2);
    for value in values {
        varint(&mut inner, u64::from(*value));
    }
    bytes(out, field, &inner);
}
