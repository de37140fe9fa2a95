//! An area of operation: a polygon on the sea.

use std::f64::consts::TAU;
use thiserror::Error;
use units::{LatLon, LocalFrame, LocalPoint};

/// Points of the border behind which ways back inside are searched for: the nearest ones.
const FEET: usize = 32;
/// From each of them the inside is searched for in so many directions.
const DIRECTIONS: u32 = 16;
/// Shares of the distance that is wanted from the border, for areas without room for all of it.
const INSETS: [f64; 3] = [1.0, 0.5, 0.2];
/// A place counts as this far inside although it is somewhat less.
const NEARLY: f64 = 0.95;
/// Points beside the nearest one of a side, so many times the distance that is wanted from the border.
const BESIDE: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];

/// Why some places are not an area.
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

    /// Its corners.
    pub fn corners(&self) -> impl Iterator<Item = LatLon> {
        self.corners.iter().map(|corner| self.frame.to_place(*corner))
    }

    /// How far a place lies outside (m); 0 inside and on the border.
    pub fn outside_m(&self, place: LatLon) -> f64 {
        let signed_m = self.depth_m(place);
        if signed_m >= 0.0 { 0.0 } else { -signed_m }
    }

    /// Distance to the border (m), positive inside, negative outside.
    pub fn depth_m(&self, place: LatLon) -> f64 {
        self.depth_at_m(self.frame.to_local(place))
    }

    fn depth_at_m(&self, point: LocalPoint) -> f64 {
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

    /// Places inside, about `inset_m` from the border where there is so much room, the nearest to `from` first.
    pub fn ways_in(&self, from: LatLon, inset_m: f64) -> Vec<LatLon> {
        let point = self.frame.to_local(from);
        let mut feet: Vec<LocalPoint> =
            self.sides().flat_map(|(side, to)| feet_of(point, side, to, inset_m)).collect();
        feet.sort_by(|a, b| a.distance_m(point).total_cmp(&b.distance_m(point)));
        feet.truncate(FEET);
        let mut found = Vec::new();
        for share in INSETS {
            let wanted_m = share * inset_m;
            found.extend(feet.iter().filter_map(|foot| self.behind(point, *foot, wanted_m)));
            if !found.is_empty() {
                break;
            }
        }
        found.sort_by(|a, b| a.distance_m(point).total_cmp(&b.distance_m(point)));
        found.dedup_by(|later, before| later.distance_m(*before) < inset_m / 2.0);
        found.into_iter().map(|place| self.frame.to_place(place)).collect()
    }

    /// The place nearest to `from` that lies so far inside behind a point of the border.
    fn behind(&self, from: LocalPoint, foot: LocalPoint, inset_m: f64) -> Option<LocalPoint> {
        // Behind a square corner the place that is far enough from both sides is farther from the corner itself.
        let ways = [inset_m, std::f64::consts::SQRT_2 * inset_m];
        let directions = (0..DIRECTIONS).map(|n| TAU * f64::from(n) / f64::from(DIRECTIONS));
        let places = directions.flat_map(|bearing_rad| ways.map(|way_m| foot.displaced(bearing_rad, way_m)));
        let inside = places.filter(|place| self.depth_at_m(*place) >= NEARLY * inset_m);
        inside.min_by(|a, b| a.distance_m(from).total_cmp(&b.distance_m(from)))
    }

    fn sides(&self) -> impl Iterator<Item = (LocalPoint, LocalPoint)> {
        let ends = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(ends.copied())
    }
}

/// Points of a side: the nearest one, some beside it, and where it begins.
fn feet_of(point: LocalPoint, from: LocalPoint, to: LocalPoint, step_m: f64) -> Vec<LocalPoint> {
    let nearest = foot(point, from, to);
    let bearing_rad = from.bearing_rad(to);
    let beside = BESIDE.iter().flat_map(|times| [times * step_m, -times * step_m]);
    let on_side = beside.map(|way_m| foot(nearest.displaced(bearing_rad, way_m), from, to));
    [nearest, from].into_iter().chain(on_side).collect()
}

/// Distance from a point to a side (m).
fn distance_m(point: LocalPoint, from: LocalPoint, to: LocalPoint) -> f64 {
    point.distance_m(foot(point, from, to))
}

/// The point of a side that is nearest to another point.
fn foot(point: LocalPoint, from: LocalPoint, to: LocalPoint) -> LocalPoint {
    let (north_m, east_m) = (to.north_m - from.north_m, to.east_m - from.east_m);
    let length2_m2 = north_m * north_m + east_m * east_m;
    let dot_m2 = (point.north_m - from.north_m) * north_m + (point.east_m - from.east_m) * east_m;
    let share = if length2_m2 > 0.0 { (dot_m2 / length2_m2).clamp(0.0, 1.0) } else { 0.0 };
    along(from, to, share)
}

/// The point of a side at this share of its length.
fn along(from: LocalPoint, to: LocalPoint, share: f64) -> LocalPoint {
    LocalPoint {
        north_m: from.north_m + share * (to.north_m - from.north_m),
        east_m: from.east_m + share * (to.east_m - from.east_m),
    }
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
    fn the_nearest_places_inside_come_first_and_keep_off_the_border() {
        let (area, frame) = square();
        for (north_m, east_m, nearest) in
            [(-300.0, 420.0, (20.0, 420.0)), (-300.0, -300.0, (20.0, 20.0)), (990.0, 500.0, (980.0, 500.0))]
        {
            let places = area.ways_in(frame.to_place(LocalPoint { north_m, east_m }), 20.0);
            let found = frame.to_local(places[0]);
            let nearest = LocalPoint { north_m: nearest.0, east_m: nearest.1 };
            assert!(found.distance_m(nearest) < 1.5, "{north_m}, {east_m}: {found:?}");
            assert!(places.iter().all(|place| area.depth_m(*place) > 18.9));
            assert!(places.len() > 8, "others to try: {}", places.len());
        }
    }

    #[test]
    fn a_narrow_area_is_come_back_to_as_far_as_it_has_room() {
        let frame = LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap());
        let corner = |north_m, east_m| frame.to_place(LocalPoint { north_m, east_m });
        let corners = [corner(0.0, 0.0), corner(500.0, 0.0), corner(500.0, 12.0), corner(0.0, 12.0)];
        let area = Area::new(&corners).unwrap();
        let places = area.ways_in(corner(250.0, 80.0), 20.0);
        assert!(area.depth_m(places[0]) > 3.5, "{}", area.depth_m(places[0]));
    }

    #[test]
    fn needs_three_corners() {
        let place = LatLon::from_deg(63.0, 10.0).unwrap();
        assert_eq!(Area::new(&[place, place]), Err(AreaError::TooFewCorners));
    }
}
