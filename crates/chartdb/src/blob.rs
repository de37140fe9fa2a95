//! Geometry as GeoPackage keeps it: a small head with the envelope, then well-known binary (OGC 12-128r18,
//! 2.1.3; OGC 06-103r4, 8). Own code in place of the crate `geozero` (0.14), whose reader follows collections in
//! collections as deep as a file nests them and so ends the program by a full stack; lakes come from elsewhere.
//!
//! Written is little-endian with an envelope of four numbers; read is either byte order, any envelope and any
//! number of dimensions, as lakes need. No count is trusted before its bytes are there.

use charts::s57::GeoPoint;

/// WGS 84 as longitude and latitude.
pub(crate) const SRS_WGS84: i32 = 4326;

const POINT: u32 = 1;
const LINE: u32 = 2;
const POLYGON: u32 = 3;
const MULTI_LINE: u32 = 5;
const MULTI_POLYGON: u32 = 6;
/// Added to a type for a third coordinate.
const WITH_Z: u32 = 1000;

/// Rings of one polygon, the outer one first; coordinates unchanged, x before y.
pub(crate) type Polygon = Vec<Vec<GeoPoint>>;

/// What was read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Point(GeoPoint),
    Lines(Vec<Vec<GeoPoint>>),
    Polygons(Vec<Polygon>),
}

/// West, east, south and north (degrees).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Envelope(pub(crate) [f64; 4]);

impl Envelope {
    pub(crate) fn of(points: impl IntoIterator<Item = GeoPoint>) -> Option<Self> {
        let mut all = points.into_iter();
        let first = all.next()?;
        let start = [first.lon_deg, first.lon_deg, first.lat_deg, first.lat_deg];
        let grown = all.fold(start, |[w, e, s, n], at| {
            [w.min(at.lon_deg), e.max(at.lon_deg), s.min(at.lat_deg), n.max(at.lat_deg)]
        });
        Some(Self(grown))
    }
}

fn head(envelope: Envelope) -> Vec<u8> {
    let mut out = vec![b'G', b'P', 0, 0x03];
    out.extend(SRS_WGS84.to_le_bytes());
    envelope.0.iter().for_each(|number| out.extend(number.to_le_bytes()));
    out
}

fn kind(out: &mut Vec<u8>, kind: u32) {
    out.push(1);
    out.extend(kind.to_le_bytes());
}

fn points(out: &mut Vec<u8>, points: &[GeoPoint]) {
    out.extend((points.len() as u32).to_le_bytes());
    for point in points {
        out.extend(point.lon_deg.to_le_bytes());
        out.extend(point.lat_deg.to_le_bytes());
    }
}

/// A point, with its depth as height below where given.
pub(crate) fn point(at: GeoPoint, z: Option<f64>) -> Vec<u8> {
    let mut out = head(Envelope([at.lon_deg, at.lon_deg, at.lat_deg, at.lat_deg]));
    kind(&mut out, if z.is_some() { POINT + WITH_Z } else { POINT });
    for number in [Some(at.lon_deg), Some(at.lat_deg), z].into_iter().flatten() {
        out.extend(number.to_le_bytes());
    }
    out
}

/// Several lines as one geometry.
pub(crate) fn lines(envelope: Envelope, paths: &[&[GeoPoint]]) -> Vec<u8> {
    let mut out = head(envelope);
    kind(&mut out, MULTI_LINE);
    out.extend((paths.len() as u32).to_le_bytes());
    for path in paths {
        kind(&mut out, LINE);
        points(&mut out, path);
    }
    out
}

/// Several polygons as one geometry.
pub(crate) fn polygons(envelope: Envelope, list: &[Vec<&[GeoPoint]>]) -> Vec<u8> {
    let mut out = head(envelope);
    kind(&mut out, MULTI_POLYGON);
    out.extend((list.len() as u32).to_le_bytes());
    for rings in list {
        kind(&mut out, POLYGON);
        out.extend((rings.len() as u32).to_le_bytes());
        for ring in rings {
            points(&mut out, ring);
        }
    }
    out
}

/// Reads a blob; `None` where it is not one, is damaged, or is of a kind that charts do not use.
pub(crate) fn read(blob: &[u8]) -> Option<Shape> {
    let flags = *blob.get(3)?;
    if !blob.starts_with(b"GP") {
        return None;
    }
    let numbers = match (flags >> 1) & 7 {
        0 => 0,
        1 => 4,
        2 | 3 => 6,
        4 => 8,
        _ => return None,
    };
    let mut reader = Reader { bytes: blob.get(8 + numbers * 8..)?, little: true };
    reader.shape()
}

struct Reader<'a> {
    bytes: &'a [u8],
    little: bool,
}

impl Reader<'_> {
    fn shape(&mut self) -> Option<Shape> {
        let (kind, size) = self.kind()?;
        Some(match kind {
            POINT => Shape::Point(self.point(size)?),
            LINE => Shape::Lines(vec![self.points(size)?]),
            POLYGON => Shape::Polygons(vec![self.polygon(size)?]),
            MULTI_LINE => {
                let part = |reader: &mut Self| {
                    let (kind, size) = reader.kind()?;
                    if kind == LINE { reader.points(size) } else { None }
                };
                Shape::Lines(self.list(9, part)?)
            }
            MULTI_POLYGON => {
                let part = |reader: &mut Self| {
                    let (kind, size) = reader.kind()?;
                    if kind == POLYGON { reader.polygon(size) } else { None }
                };
                Shape::Polygons(self.list(9, part)?)
            }
            _ => return None,
        })
    }

    /// The kind and how many numbers a position has.
    fn kind(&mut self) -> Option<(u32, usize)> {
        self.little = self.take::<1>()?[0] == 1;
        let code = self.u32()?;
        let more = match code / 1000 {
            0 => 0,
            1 | 2 => 1,
            3 => 2,
            _ => return None,
        };
        Some((code % 1000, 2 + more))
    }

    fn polygon(&mut self, size: usize) -> Option<Polygon> {
        self.list(4, |reader| reader.points(size))
    }

    fn points(&mut self, size: usize) -> Option<Vec<GeoPoint>> {
        let count = self.u32()? as usize;
        let (head, rest) = self.bytes.split_at_checked(count.checked_mul(size * 8)?)?;
        self.bytes = rest;
        let number =
            |bytes: [u8; 8]| if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) };
        let mut points = Vec::with_capacity(count);
        for position in head.chunks_exact(size * 8) {
            let (lon, rest) = position.split_first_chunk()?;
            points.push(GeoPoint { lon_deg: number(*lon), lat_deg: number(*rest.first_chunk()?) });
        }
        Some(points)
    }

    fn point(&mut self, size: usize) -> Option<GeoPoint> {
        let point = GeoPoint { lon_deg: self.f64()?, lat_deg: self.f64()? };
        for _ in 2..size {
            self.f64()?;
        }
        Some(point)
    }

    fn list<T>(&mut self, least: usize, mut read: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()? as usize;
        if count > self.bytes.len() / least {
            return None;
        }
        (0..count).map(|_| read(self)).collect()
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.bytes.split_first_chunk::<N>()?;
        self.bytes = rest;
        Some(*head)
    }

    fn u32(&mut self) -> Option<u32> {
        let bytes = self.take()?;
        Some(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn f64(&mut self) -> Option<f64> {
        let bytes = self.take()?;
        Some(if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: GeoPoint = GeoPoint { lon_deg: 10.0, lat_deg: 63.0 };
    const B: GeoPoint = GeoPoint { lon_deg: 10.5, lat_deg: 63.2 };
    const C: GeoPoint = GeoPoint { lon_deg: 10.4, lat_deg: 62.9 };

    #[test]
    fn a_point_stands_as_the_standard_says() {
        let blob = point(A, Some(2.5));
        assert_eq!(&blob[..8], [b'G', b'P', 0, 3, 0xE6, 0x10, 0, 0]);
        assert_eq!(&blob[8..16], 10.0_f64.to_le_bytes());
        assert_eq!(&blob[40..45], [1, 0xE9, 3, 0, 0], "PointZ is 1001");
        assert_eq!(&blob[61..], 2.5_f64.to_le_bytes());
        assert_eq!(read(&blob), Some(Shape::Point(A)));
    }

    #[test]
    fn shapes_come_back_and_cut_ones_do_not() {
        let envelope = Envelope::of([A, B, C]).unwrap();
        assert_eq!(envelope, Envelope([10.0, 10.5, 62.9, 63.2]));
        let ring = [A, B, C, A];
        for (blob, shape) in [
            (lines(envelope, &[&ring, &[A, B]]), Shape::Lines(vec![ring.to_vec(), vec![A, B]])),
            (polygons(envelope, &[vec![&ring, &ring]]), Shape::Polygons(vec![vec![ring.to_vec(); 2]])),
        ] {
            assert_eq!(read(&blob), Some(shape));
            for at in 0..blob.len() {
                assert_eq!(read(&blob[..at]), None, "cut at {at}");
            }
        }
    }

    #[test]
    fn a_count_beyond_the_bytes_is_not_believed() {
        let mut blob = lines(Envelope([0.0; 4]), &[&[A, B]]);
        blob[45..49].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read(&blob), None);
    }
}
