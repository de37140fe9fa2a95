//! An area of the sea that a user drew.

use std::str::FromStr;
use units::LatLon;

/// Corners that an area may have.
pub const AREA_CORNERS: std::ops::RangeInclusive<usize> = 3..=100;

/// A polygon. Its sides are straight on a chart that draws latitude and longitude at right angles; at the range of a
/// hydrophone they do not differ noticeably from geodesics. No side crosses another, and none the 180th meridian.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Latitude and longitude of each corner (deg, north and east positive), in order; the last joins the first.
    corners: Vec<(f64, f64)>,
}

/// Why a text is not an area; its words are made above, where the catalogue of words has them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoArea {
    /// It has too few corners, or too many.
    Corners(usize),
    /// A corner is not a place.
    Corner(usize),
    /// The side from this corner to the next one spans more than 180 degrees of longitude.
    Side(usize),
    /// The sides from these two corners to the next ones cross or touch.
    Crossing(usize, usize),
}

impl FromStr for Area {
    type Err = NoArea;

    /// From corners as `63.44,10.35;63.45,10.35;63.45,10.40`.
    fn from_str(text: &str) -> Result<Self, NoArea> {
        let texts: Vec<&str> = text.split(';').map(str::trim).filter(|text| !text.is_empty()).collect();
        if !AREA_CORNERS.contains(&texts.len()) {
            return Err(NoArea::Corners(texts.len()));
        }
        let corner = |(at, text): (usize, &&str)| {
            let degrees = |text: &str| text.trim().parse::<f64>().ok();
            let place = text.split_once(',').and_then(|(lat, lon)| Some((degrees(lat)?, degrees(lon)?)));
            place.filter(|(lat, lon)| LatLon::from_deg(*lat, *lon).is_ok()).ok_or(NoArea::Corner(at + 1))
        };
        let corners: Vec<(f64, f64)> = texts.iter().enumerate().map(corner).collect::<Result<_, _>>()?;
        // A double click, or the first corner repeated to close the ring, is one corner.
        let is_new = |at: &usize| corners[*at] != corners[(at + corners.len() - 1) % corners.len()];
        let ring: Vec<usize> = (0..corners.len()).filter(is_new).collect();
        if !AREA_CORNERS.contains(&ring.len()) {
            return Err(NoArea::Corners(ring.len()));
        }
        let side = |at: usize| (corners[ring[at]], corners[ring[(at + 1) % ring.len()]]);
        let is_long = |at: &usize| {
            let ((_, west), (_, east)) = side(*at);
            (east - west).abs() > 180.0
        };
        if let Some(at) = (0..ring.len()).find(is_long) {
            return Err(NoArea::Side(ring[at] + 1));
        }
        // The neighbours of a side share a corner with it.
        let others = |at: usize| (at + 2..ring.len()).map(move |other| (at, other));
        let is_beside = |(at, other): &(usize, usize)| (other + 1) % ring.len() == *at;
        let mut pairs = (0..ring.len()).flat_map(others).filter(|pair| !is_beside(pair));
        match pairs.find(|(one, other)| do_meet(side(*one), side(*other))) {
            Some((one, other)) => Err(NoArea::Crossing(ring[one] + 1, ring[other] + 1)),
            None => Ok(Self { corners }),
        }
    }
}

type Corner = (f64, f64);

/// Whether two straight lines have a point in common.
fn do_meet((a, b): (Corner, Corner), (c, d): (Corner, Corner)) -> bool {
    let (abc, abd) = (turn(a, b, c), turn(a, b, d));
    let (cda, cdb) = (turn(c, d, a), turn(c, d, b));
    if abc != abd && cda != cdb {
        return true;
    }
    let on = |turn: i8, (from, to): (Corner, Corner), point: Corner| {
        turn == 0 && is_between(from.0, to.0, point.0) && is_between(from.1, to.1, point.1)
    };
    on(abc, (a, b), c) || on(abd, (a, b), d) || on(cda, (c, d), a) || on(cdb, (c, d), b)
}

fn is_between(one: f64, other: f64, value: f64) -> bool {
    (one.min(other)..=one.max(other)).contains(&value)
}

/// To which side one turns at `b` on the way from `a` to `c`: 1, -1, or 0 where it goes straight.
fn turn(a: Corner, b: Corner, c: Corner) -> i8 {
    let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    i8::from(area > 0.0) - i8::from(area < 0.0)
}

impl Area {
    /// Whether a place lies in it (degrees, north and east positive): by the even-odd rule.
    pub fn contains_deg(&self, lat_deg: f64, lon_deg: f64) -> bool {
        let Some(mut before) = self.corners.last() else { return false };
        let mut is_in = false;
        for corner in &self.corners {
            let ((lat_a, lon_a), (lat_b, lon_b)) = (*before, *corner);
            if (lat_a > lat_deg) != (lat_b > lat_deg) {
                let crossing_deg = lon_a + (lat_deg - lat_a) / (lat_b - lat_a) * (lon_b - lon_a);
                is_in ^= lon_deg < crossing_deg;
            }
            before = corner;
        }
        is_in
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_has_what_lies_between_its_corners() {
        // A triangle with a notch: even-odd, whichever way round.
        for text in ["63,10;64,10;64,11;63.5,10.5;63,11", " 63,11 ; 63.5,10.5;64,11;64,10;63,10;"] {
            let area: Area = text.parse().unwrap();
            for (lat, lon, is_in) in
                [(63.5, 10.2, true), (63.5, 10.8, false), (63.9, 10.8, true), (62.9, 10.2, false)]
            {
                assert_eq!(area.contains_deg(lat, lon), is_in, "{lat} {lon} in {text}");
            }
        }
    }

    #[test]
    fn what_is_no_area_is_told_with_its_corner() {
        assert_eq!("63,10;64,10".parse::<Area>(), Err(NoArea::Corners(2)));
        assert_eq!("63,10;64,10;91,10".parse::<Area>(), Err(NoArea::Corner(3)));
        assert_eq!("63,10;64 10;63,11".parse::<Area>(), Err(NoArea::Corner(2)));
        assert_eq!("63,10;64,NaN;63,11".parse::<Area>(), Err(NoArea::Corner(2)));
        assert!("63,10;".repeat(101).parse::<Area>().is_err());
    }

    #[test]
    fn an_area_across_the_date_line_or_itself_is_refused_with_the_remedy() {
        let no = |text: &str| text.parse::<Area>().unwrap_err();
        assert_eq!(no("-17,179;-17,-179;-18,-179;-18,179"), NoArea::Side(1));
        assert!(matches!(no("-17,179;-17,-179;-18,-179"), NoArea::Side(_)));
        // A bow tie, a corner on a side, and the same corner twice.
        assert_eq!(no("63,10;64,11;64,10;63,11"), NoArea::Crossing(1, 3));
        assert_eq!(no("63,10;63,12;64,11;63,11"), NoArea::Crossing(1, 3));
        assert!(matches!(no("63,10;64,10;63,11;64,10;63,9"), NoArea::Crossing(..)));
        assert!("63,10;64,10;64,11;63,11".parse::<Area>().is_ok());
        assert!("63,10;63,10;64,10;64,11;63,11;63,10".parse::<Area>().is_ok(), "twice is once");
        assert_eq!(no("63,10;63,10;64,10;63,10"), NoArea::Corners(2));
        assert!("-60,-170;-60,5;60,5;60,-170".parse::<Area>().is_ok(), "175 degrees wide");
    }
}
