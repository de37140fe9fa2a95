//! Zones that people draw: where ways are to stay, and where they may not lead.
//!
//! Their borders are cut out of the water like the chart's barriers, with a margin of their own; each piece that is left lies
//! inside or outside of a zone as a whole. Sides are straight in longitude and latitude, as those of the chart and of a
//! vessel's area of operation.

use crate::obstacles::LONGEST_SIDE_M;
use crate::plane::{self, Plane, Point};
use charts::depth_index::Leg;
use units::{LatLon, wrap_pi};

/// Farthest that ways can be asked to keep from borders (m).
pub const MOST_MARGIN_M: f64 = 10_000.0;

/// Longest border of a zone that people draw (km): it is cut into pieces, which all take room and time.
pub const MOST_BORDER_KM: f64 = 1_000.0;

/// Why some places are no zone.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ZoneError {
    /// A zone needs three corners.
    #[error("a zone needs at least three corners")]
    TooFewCorners,
    /// Two sides cross or touch, so that nobody can tell what is inside.
    #[error("two sides of the zone cross or touch near {lat_deg:.5}, {lon_deg:.5}: draw it without that")]
    Crosses {
        /// Where (degrees).
        lat_deg: f64,
        /// Where (degrees).
        lon_deg: f64,
    },
    /// It spans half the globe or more.
    #[error("a zone is less than 180 degrees wide")]
    TooWide,
    /// Its border is too long to be looked at.
    #[error("the border of the zone is {km:.0} km long; at most {MOST_BORDER_KM:.0} km are taken")]
    TooLong {
        /// How long it is (km).
        km: f64,
    },
    /// The margin is not a number, or out of range.
    #[error("the margin to zones is {0} m; it must be a number from 0 to {MOST_MARGIN_M:.0} m")]
    Margin(f64),
}

/// A polygon on the sea; its last corner joins the first. It holds no pole and spans less than half the globe. Where it
/// overlaps itself, the even-odd rule says what is inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    corners: Vec<LatLon>,
}

impl Zone {
    /// From its corners in either sense.
    ///
    /// # Errors
    /// With fewer than three corners.
    pub fn new(corners: Vec<LatLon>) -> Result<Self, ZoneError> {
        if corners.len() < 3 { Err(ZoneError::TooFewCorners) } else { Ok(Self { corners }) }
    }

    /// As [`Self::new`], and only if its sides neither cross nor touch: for what people draw.
    ///
    /// # Errors
    /// Which sides do.
    pub fn drawn(corners: Vec<LatLon>) -> Result<Self, ZoneError> {
        let zone = Self::new(corners)?;
        let first = zone.corners[0];
        let point =
            |place: LatLon| Point { x: wrap_pi(place.lon_rad() - first.lon_rad()), y: place.lat_rad() };
        let xs = || zone.corners.iter().map(|corner| point(*corner).x);
        if xs().fold(0.0, f64::max) - xs().fold(0.0, f64::min) >= std::f64::consts::PI {
            return Err(ZoneError::TooWide);
        }
        let km = zone.border_m() / 1e3;
        if km > MOST_BORDER_KM {
            return Err(ZoneError::TooLong { km });
        }
        let sides: Vec<[Point; 2]> = zone.sides().map(|(from, to)| [point(from), point(to)]).collect();
        for (at, one) in sides.iter().enumerate() {
            for (other_at, other) in sides.iter().enumerate().skip(at + 1) {
                let next = other_at == at + 1 || (at == 0 && other_at + 1 == sides.len());
                if let Some(meet) = if next { turning_back(*one, *other) } else { meeting(*one, *other) } {
                    let lon_deg = wrap_pi(first.lon_rad() + meet.x).to_degrees();
                    return Err(ZoneError::Crosses { lat_deg: meet.y.to_degrees(), lon_deg });
                }
            }
        }
        Ok(zone)
    }

    /// Its corners, each once.
    pub(crate) fn corners(&self) -> &[LatLon] {
        &self.corners
    }

    /// How long its border is (m); sides of many kilometres only nearly.
    pub fn border_m(&self) -> f64 {
        self.sides().map(|(from, to)| Plane::new(from).point(to).distance_m(Point::default())).sum()
    }

    /// Whether it holds a place.
    pub fn holds(&self, place: LatLon) -> bool {
        let east_rad = |place: LatLon| wrap_pi(place.lon_rad() - self.corners[0].lon_rad());
        let here_rad = east_rad(place);
        // A ray to the east crosses the border an odd number of times from inside.
        let crosses = |from: &LatLon, to: &LatLon| {
            let (from_north, to_north) = (from.lat_rad() - place.lat_rad(), to.lat_rad() - place.lat_rad());
            let (from_rad, to_rad) = (east_rad(*from), east_rad(*to));
            let at_rad = from_rad + (to_rad - from_rad) * from_north / (from_north - to_north);
            (from_north > 0.0) != (to_north > 0.0) && at_rad > here_rad
        };
        self.sides().filter(|(from, to)| crosses(from, to)).count() % 2 == 1
    }

    /// Whether a leg enters it or touches its border.
    pub(crate) fn meets(&self, leg: Leg) -> bool {
        let around = Plane::new(leg.from);
        let ends = [leg.from, leg.to].map(|place| around.point(place));
        let border = self.border(&around);
        self.holds(leg.from)
            || self.holds(leg.to)
            || plane::sides(&border).any(|side| meeting(ends, side).is_some())
    }

    fn sides(&self) -> impl Iterator<Item = (LatLon, LatLon)> {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(ends.copied())
    }

    /// Its border in a plane, closed, long sides in pieces.
    pub(crate) fn border(&self, plane: &Plane) -> Vec<Point> {
        let mut border = Vec::with_capacity(self.corners.len() + 1);
        for (from, to) in self.sides() {
            let length_m = plane.point(from).distance_m(plane.point(to));
            let pieces = (length_m / LONGEST_SIDE_M).ceil().clamp(1.0, 10_000.0) as u32;
            let east_rad = wrap_pi(to.lon_rad() - from.lon_rad());
            border.extend((0..pieces).filter_map(|piece| {
                let share = f64::from(piece) / f64::from(pieces);
                let lat_rad = from.lat_rad() + share * (to.lat_rad() - from.lat_rad());
                let lon_rad = wrap_pi(from.lon_rad() + share * east_rad);
                LatLon::from_rad(lat_rad, lon_rad).ok().map(|place| plane.point(place))
            }));
        }
        border.extend(border.first().copied());
        border
    }
}

/// What ways keep to beside the chart; by default nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Zones {
    allowed: Option<Zone>,
    forbidden: Vec<Zone>,
    margin_m: f64,
}

impl Zones {
    /// Ways stay inside the allowed zone, if there is one, and out of all the forbidden ones, this far from their borders
    /// (m).
    ///
    /// # Errors
    /// When the margin is no number or out of range.
    pub fn new(allowed: Option<Zone>, forbidden: Vec<Zone>, margin_m: f64) -> Result<Self, ZoneError> {
        if !(0.0..=MOST_MARGIN_M).contains(&margin_m) {
            return Err(ZoneError::Margin(margin_m));
        }
        Ok(Self { allowed, forbidden, margin_m })
    }

    /// How far ways keep from borders (m).
    pub fn margin_m(&self) -> f64 {
        self.margin_m
    }

    /// Whether a place lies where ways may lead; the margin is not looked at.
    pub fn allow(&self, place: LatLon) -> bool {
        let inside = self.allowed.as_ref().is_none_or(|zone| zone.holds(place));
        inside && !self.forbidden.iter().any(|zone| zone.holds(place))
    }

    /// All borders in a plane.
    pub(crate) fn borders(&self, plane: &Plane) -> Vec<Vec<Point>> {
        self.allowed.iter().chain(&self.forbidden).map(|zone| zone.border(plane)).collect()
    }
}

/// Where two sides cross or touch.
fn meeting([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    let (of_c, of_d, of_a, of_b) = (a.cross(b, c), a.cross(b, d), c.cross(d, a), c.cross(d, b));
    if of_c * of_d < 0.0 && of_a * of_b < 0.0 {
        return Some(c.towards(d, of_c / (of_c - of_d)));
    }
    let on = |of: f64, at: Point, [from, to]: [Point; 2]| {
        let within = (from.x.min(to.x)..=from.x.max(to.x)).contains(&at.x)
            && (from.y.min(to.y)..=from.y.max(to.y)).contains(&at.y);
        (of == 0.0 && within).then_some(at)
    };
    let touching = [on(of_c, c, [a, b]), on(of_d, d, [a, b]), on(of_a, a, [c, d]), on(of_b, b, [c, d])];
    touching.into_iter().flatten().next()
}

/// The corner of two sides of which one leads back over the other.
fn turning_back([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    // The last side meets the first at its end.
    let (from, corner, to) = if b == c { (a, b, d) } else { (c, a, b) };
    let along = (corner.x - from.x) * (to.x - corner.x) + (corner.y - from.y) * (to.y - corner.y);
    (from.cross(corner, to) == 0.0 && along < 0.0).then_some(corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(lat_deg: f64, lon_deg: f64) -> LatLon {
        LatLon::from_deg(lat_deg, lon_deg).unwrap()
    }

    #[test]
    fn a_zone_across_the_date_line_holds_what_lies_in_it() {
        let corners = [(-17.0, 179.9), (-17.0, -179.9), (-17.2, -179.9), (-17.2, 179.9)];
        let zone = Zone::new(corners.map(|(lat, lon)| place(lat, lon)).to_vec()).unwrap();
        for (lat, lon, inside) in
            [(-17.1, 180.0, true), (-17.1, -179.95, true), (-17.1, 179.95, true)].into_iter().chain([
                (-17.1, 179.8, false),
                (-17.1, -179.8, false),
                (-17.1, 0.0, false),
                (-16.9, 180.0, false),
            ])
        {
            assert_eq!(zone.holds(place(lat, lon)), inside, "{lat}, {lon}");
        }
    }

    #[test]
    fn bad_zones_are_refused() {
        assert_eq!(Zone::new(vec![place(63.0, 10.0); 2]), Err(ZoneError::TooFewCorners));
        let bow = [(63.0, 10.0), (63.1, 10.2), (63.1, 10.0), (63.0, 10.2)].map(|(lat, lon)| place(lat, lon));
        let crossed = Zone::drawn(bow.to_vec()).unwrap_err();
        assert!(crossed.to_string().contains("63.05000, 10.10000"), "{crossed}");
        let band = [0.0, 100.0, -100.0].map(|lon| place(10.0 + lon / 50.0, lon));
        assert_eq!(Zone::drawn(band.to_vec()), Err(ZoneError::TooWide));
        let sea = [(50.0, 0.0), (60.0, 0.0), (60.0, 20.0), (50.0, 20.0)].map(|(lat, lon)| place(lat, lon));
        assert!(matches!(Zone::drawn(sea.to_vec()), Err(ZoneError::TooLong { km }) if km > 2_000.0));
        let square =
            [(63.0, 10.0), (63.1, 10.0), (63.1, 10.2), (63.0, 10.2)].map(|(lat, lon)| place(lat, lon));
        assert!(Zone::drawn(square.to_vec()).is_ok());
        assert!(Zones::new(None, Vec::new(), f64::NAN).is_err());
        assert!(Zones::new(None, Vec::new(), -1.0).is_err());
    }
}
