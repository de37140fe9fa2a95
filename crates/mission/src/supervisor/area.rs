//! An area of operation: a polygon on the sea.

use thiserror::Error;
use units::{LatLon, LocalFrame, LocalPoint};

/// Why some places are no area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum AreaError {
    /// An area needs three corners.
    #[error("an area needs at least three corners")]
    TooFewCorners,
}

/// A polygon; its last corner joins the first. Small enough for a flat frame (some tens of kilometres).
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    frame: LocalFrame,
    corners: Vec<LocalPoint>,
}

impl Area {
    /// From its corners in either sense.
    ///
    /// # Errors
    /// With fewer than three corners.
    pub fn new(corners: &[LatLon]) -> Result<Self, AreaError> {
        let [first, _, _, ..] = corners else {
            return Err(AreaError::TooFewCorners);
        };
        let frame = LocalFrame::new(*first);
        Ok(Self { frame, corners: corners.iter().map(|corner| frame.to_local(*corner)).collect() })
    }

    /// How far a place lies outside (m); 0 inside and on the border.
    pub fn outside_m(&self, place: LatLon) -> f64 {
        let signed_m = self.depth_m(place);
        if signed_m >= 0.0 { 0.0 } else { -signed_m }
    }

    /// Distance to the border (m), positive inside, negative outside.
    pub fn depth_m(&self, place: LatLon) -> f64 {
        let point = self.frame.to_local(place);
        let mut inside = false;
        let mut border_m = f64::INFINITY;
        for (from, to) in self.sides() {
            border_m = border_m.min(distance_m(point, from, to));
            // Even-odd rule: a ray to the east crosses the border an odd number of times from inside.
            if (from.north_m > point.north_m) != (to.north_m > point.north_m) {
                let share = (point.north_m - from.north_m) / (to.north_m - from.north_m);
                inside ^= point.east_m < from.east_m + share * (to.east_m - from.east_m);
            }
        }
        if inside { border_m } else { -border_m }
    }

    fn sides(&self) -> impl Iterator<Item = (LocalPoint, LocalPoint)> {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(ends.copied())
    }
}

/// Distance from a point to a side (m).
fn distance_m(point: LocalPoint, from: LocalPoint, to: LocalPoint) -> f64 {
    let (north_m, east_m) = (to.north_m - from.north_m, to.east_m - from.east_m);
    let length2_m2 = north_m * north_m + east_m * east_m;
    let dot_m2 = (point.north_m - from.north_m) * north_m + (point.east_m - from.east_m) * east_m;
    let share = if length2_m2 > 0.0 { (dot_m2 / length2_m2).clamp(0.0, 1.0) } else { 0.0 };
    let foot = LocalPoint { north_m: from.north_m + share * north_m, east_m: from.east_m + share * east_m };
    point.distance_m(foot)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> (Area, LocalFrame) {
        let frame = LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap());
        let corner = |north_m, east_m| frame.to_place(LocalPoint { north_m, east_m });
        let corners = [corner(0.0, 0.0), corner(1000.0, 0.0), corner(1000.0, 1000.0), corner(0.0, 1000.0)];
        (Area::new(&corners).unwrap(), frame)
    }

    #[test]
    fn tells_how_far_a_place_is_from_the_border() {
        let (area, frame) = square();
        let cases = [
            (500.0, 500.0, 500.0),
            (500.0, 990.0, 10.0),
            (500.0, 1050.0, -50.0),
            (-30.0, -40.0, -50.0),
            (1300.0, 1400.0, -500.0),
        ];
        for (north_m, east_m, depth_m) in cases {
            let place = frame.to_place(LocalPoint { north_m, east_m });
            assert!((area.depth_m(place) - depth_m).abs() < 0.01, "{north_m}, {east_m}");
            assert!((area.outside_m(place) - (-depth_m).max(0.0)).abs() < 0.01);
        }
    }

    #[test]
    fn needs_three_corners() {
        let place = LatLon::from_deg(63.0, 10.0).unwrap();
        assert_eq!(Area::new(&[place, place]), Err(AreaError::TooFewCorners));
    }
}
