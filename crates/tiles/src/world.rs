//! Web Mercator in whole numbers: the world is a square of 2^30 units, x east and y south, 3.7 cm at the equator.

use charts::s57::GeoPoint;
use i_overlay::i_float::int::point::IntPoint;
use std::f64::consts::PI;

/// A place in the world's square.
pub(crate) type Point = IntPoint<i32>;

/// The last zoom that is drawn of overviews.
pub(crate) const LAST_ZOOM: u8 = 8;
/// A tile is 2^12 units wide.
pub(crate) const TILE_BITS: u32 = 12;
/// Smaller areas are not drawn (units), but dangers are, as points.
pub(crate) const SMALLEST: i64 = 2;
/// The world is so many bits wide.
pub(crate) const BITS: u32 = 30;
const SIZE: f64 = (1_u32 << BITS) as f64;
/// Length of the equator (m): WGS-84's semi-major axis.
const EQUATOR_M: f64 = 2.0 * PI * 6_378_137.0;

/// The point of a place; beyond 85° the last there is.
pub(crate) fn point(place: GeoPoint) -> Point {
    let x = (place.lon_deg + 180.0) / 360.0;
    let y = (1.0 - place.lat_deg.to_radians().tan().asinh() / PI) / 2.0;
    let whole = |share: f64| (share * SIZE).round().clamp(0.0, SIZE - 1.0) as i32;
    Point::new(whole(x), whole(y))
}

/// Metres per unit at a latitude, on the sphere that the projection takes the Earth for: within 0.4 %.
pub(crate) fn metres_per_unit(lat_deg: f64) -> f64 {
    EQUATOR_M / SIZE * lat_deg.to_radians().cos()
}

/// A point in units of 2^bits from an origin on, to the nearest.
pub(crate) fn local(at: Point, origin: Point, bits: u32) -> Point {
    let half = (1 << bits) >> 1;
    Point::new((at.x - origin.x + half) >> bits, (at.y - origin.y + half) >> bits)
}

/// A line in units of 2^bits from an origin on, without repeated points.
pub(crate) fn rounded(line: &[Point], origin: Point, bits: u32) -> Vec<Point> {
    let mut out: Vec<Point> = Vec::with_capacity(line.len().min(1024));
    for at in line {
        let local = local(*at, origin, bits);
        if out.last() != Some(&local) {
            out.push(local);
        }
    }
    out
}

/// A box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub(crate) min: Point,
    pub(crate) max: Point,
}

impl Bounds {
    /// Holds nothing.
    pub(crate) const EMPTY: Self =
        Self { min: Point { x: i32::MAX, y: i32::MAX }, max: Point { x: i32::MIN, y: i32::MIN } };

    /// The box of points.
    pub(crate) fn of<'a>(points: impl IntoIterator<Item = &'a Point>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.with(Self { min: *point, max: *point }))
    }

    /// The box of both.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            min: Point::new(self.min.x.min(other.min.x), self.min.y.min(other.min.y)),
            max: Point::new(self.max.x.max(other.max.x), self.max.y.max(other.max.y)),
        }
    }

    /// Whether both share a point.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
    }

    /// The longer side.
    pub(crate) fn size(&self) -> i64 {
        let side = |min: i32, max: i32| i64::from(max) - i64::from(min);
        side(self.min.x, self.max.x).max(side(self.min.y, self.max.y))
    }
}
