//! A part of the sea that somebody drew.

use std::fmt;
use std::str::FromStr;
use units::LatLon;

/// Corners that an area may have.
const CORNERS: std::ops::RangeInclusive<usize> = 3..=100;

/// A polygon. Its sides are straight on a chart that draws latitude and longitude at right angles, which at the reach of a
/// hydrophone no one tells from geodesics. It does not cross the 180th meridian.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Latitude and longitude of each corner (deg, north and east positive), in order; the last joins the first.
    corners: Vec<(f64, f64)>,
}

/// Why a text is no area.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoArea {
    /// It has too few corners, or too many.
    Corners(usize),
    /// A corner is no place.
    Corner(usize),
}

impl fmt::Display for NoArea {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least, most) = (CORNERS.start(), CORNERS.end());
        match self {
            Self::Corners(count) => write!(
                out,
                "it has {count} corners; give {least} to {most}, each as latitude,longitude in degrees, with `;` between corners"
            ),
            Self::Corner(at) => {
                write!(
                    out,
                    "corner {at} is no place; write it as latitude,longitude in degrees, like 63.44,10.35"
                )
            }
        }
    }
}

impl std::error::Error for NoArea {}

impl FromStr for Area {
    type Err = NoArea;

    /// From corners as `63.44,10.35;63.45,10.35;63.45,10.40`.
    fn from_str(text: &str) -> Result<Self, NoArea> {
        let texts: Vec<&str> = text.split(';').map(str::trim).filter(|text| !text.is_empty()).collect();
        if !CORNERS.contains(&texts.len()) {
            return Err(NoArea::Corners(texts.len()));
        }
        let corner = |(at, text): (usize, &&str)| {
            let degrees = |text: &str| text.trim().parse::<f64>().ok();
            let place = text.split_once(',').and_then(|(lat, lon)| Some((degrees(lat)?, degrees(lon)?)));
            place.filter(|(lat, lon)| LatLon::from_deg(*lat, *lon).is_ok()).ok_or(NoArea::Corner(at + 1))
        };
        Ok(Self { corners: texts.iter().enumerate().map(corner).collect::<Result<_, _>>()? })
    }
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
}
