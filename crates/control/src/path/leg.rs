//! A straight leg between two places, exact beyond the flat frame.
//!
//! The leg is the intersection of the ellipsoid with the plane through both ends and the vertical between
//! them. Distances along and across are projections in Earth-centred coordinates, so nothing depends on how
//! far the leg runs from an origin: against the geodesic the error is centimetres at 25 km (chord shorter
//! than arc by L³/24R² = 1.6 cm). The bearing of the track is taken at the vessel's place, so that it follows
//! the convergence of the meridians (0.4° over a 25 km leg to the east at 63°N).

use units::{Ecef, Geodetic, LatLon, LocalFrame, LocalPoint};

/// Shorter legs have no direction of their own (m).
const SHORTEST_M: f64 = 0.1;

type Vector = [f64; 3];

/// A leg from start to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    start: LatLon,
    end: LatLon,
    origin: Vector,
    along: Vector,
    starboard: Vector,
    length_m: f64,
}

/// Where a place lies relative to a leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPosition {
    /// Distance from the start along the leg (m).
    pub along_m: f64,
    /// Distance across, positive to starboard of the track (m).
    pub cross_m: f64,
    /// Direction of the track at the place (rad).
    pub bearing_rad: f64,
}

impl Leg {
    /// The leg from `start` to `end`; when these are closer than 0.1 m it points to `fallback_bearing_rad`.
    pub fn new(start: LatLon, end: LatLon, fallback_bearing_rad: f64) -> Self {
        let origin = position(start);
        let chord = subtract(position(end), origin);
        let length_m = norm(chord);
        let (north, east) = north_east(start);
        let (sin, cos) = fallback_bearing_rad.sin_cos();
        let fallback = add(scale(north, cos), scale(east, sin));
        let along = if length_m < SHORTEST_M { fallback } else { scale(chord, 1.0 / length_m) };
        let starboard = unit(cross(along, add(up(start), up(end))), east);
        Self { start, end, origin, along, starboard, length_m }
    }

    /// Where the leg begins.
    pub fn start(&self) -> LatLon {
        self.start
    }

    /// Where the leg ends.
    pub fn end(&self) -> LatLon {
        self.end
    }

    /// Distance from start to end (m).
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Direction of the leg at its start (rad).
    pub fn bearing_rad(&self) -> f64 {
        bearing(self.start, self.along)
    }

    /// Where `place` lies relative to the leg.
    pub fn locate(&self, place: LatLon) -> TrackPosition {
        let offset = subtract(position(place), self.origin);
        TrackPosition {
            along_m: dot(offset, self.along),
            cross_m: dot(offset, self.starboard),
            bearing_rad: bearing(place, self.along),
        }
    }
}

/// Distance (m) and direction (rad, at `from`) to another place; direction 0 to the same place. The distance
/// is that of the chord: 1.6 cm short of the arc at 25 km.
pub fn range_and_bearing(from: LatLon, to: LatLon) -> (f64, f64) {
    let offset = subtract(position(to), position(from));
    let range_m = norm(offset);
    (range_m, if range_m > 0.0 { bearing(from, offset) } else { 0.0 })
}

/// The place `distance_m` (up to some kilometres) from `place` towards `bearing_rad`.
pub(crate) fn displaced(place: LatLon, bearing_rad: f64, distance_m: f64) -> LatLon {
    LocalFrame::new(place).to_place(LocalPoint::default().displaced(bearing_rad, distance_m))
}

fn position(place: LatLon) -> Vector {
    let Ecef { x_m, y_m, z_m } =
        Geodetic { lat_rad: place.lat_rad(), lon_rad: place.lon_rad(), height_m: 0.0 }.to_ecef();
    [x_m, y_m, z_m]
}

/// The vertical at a place.
fn up(place: LatLon) -> Vector {
    let (sin_lat, cos_lat) = place.lat_rad().sin_cos();
    let (sin_lon, cos_lon) = place.lon_rad().sin_cos();
    [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat]
}

/// The directions north and east at a place.
fn north_east(place: LatLon) -> (Vector, Vector) {
    let (sin_lat, cos_lat) = place.lat_rad().sin_cos();
    let (sin_lon, cos_lon) = place.lon_rad().sin_cos();
    ([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], [-sin_lon, cos_lon, 0.0])
}

fn bearing(place: LatLon, direction: Vector) -> f64 {
    let (north, east) = north_east(place);
    units::wrap_pi(dot(direction, east).atan2(dot(direction, north)))
}

fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + b[i])
}

fn subtract(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|component| component * factor)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// `a` at length 1; `fallback` where it has none (only between antipodes).
fn unit(a: Vector, fallback: Vector) -> Vector {
    let length = norm(a);
    if length > 1e-9 { scale(a, 1.0 / length) } else { fallback }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn place(lat_deg: f64, lon_deg: f64) -> LatLon {
        LatLon::from_deg(lat_deg, lon_deg).unwrap()
    }

    #[test]
    fn starboard_of_a_northbound_track_is_east() {
        let leg = Leg::new(place(63.33, 10.08), place(63.34, 10.08), 0.0);
        let got = leg.locate(displaced(displaced(place(63.33, 10.08), 0.0, 200.0), FRAC_PI_2, 5.0));
        assert!((got.along_m - 200.0).abs() < 0.01, "{got:?}");
        assert!((got.cross_m - 5.0).abs() < 0.001, "{got:?}");
        assert!(got.bearing_rad.abs() < 1e-5);
    }

    #[test]
    fn agrees_with_the_geodesic_over_25_km_to_the_east() {
        // The arc of the great normal section over 0.5 degrees of longitude at 63°N: by the Gauss mid-latitude
        // formula the distance is N cos(lat) dlon up to terms of dlon³, here 25 km; its middle lies north of the
        // parallel by (L²/8R) tan(lat).
        let (from, to) = (place(63.0, 10.0), place(63.0, 10.5));
        let leg = Leg::new(from, to, 0.0);
        let along_parallel_m = LocalFrame::new(from).to_local(to).east_m;
        assert!((leg.length_m() - along_parallel_m).abs() < 0.1, "{} {along_parallel_m}", leg.length_m());
        let middle = leg.locate(place(63.0, 10.25));
        let bulge_m = leg.length_m().powi(2) / (8.0 * 6_395_000.0) * 63_f64.to_radians().tan();
        assert!((middle.cross_m - bulge_m).abs() < 0.1, "{middle:?} {bulge_m}");
        assert!((middle.along_m - leg.length_m() / 2.0).abs() < 0.01);
        // The bearing turns by dlon·sin(lat) from end to end.
        let turned = leg.locate(to).bearing_rad - leg.locate(from).bearing_rad;
        assert!((turned - 0.5_f64.to_radians() * 63_f64.to_radians().sin()).abs() < 1e-5);
        let end = leg.locate(to);
        assert!((end.along_m - leg.length_m()).abs() < 1e-6 && end.cross_m.abs() < 1e-6);
    }

    #[test]
    fn a_leg_of_no_length_points_where_told() {
        let leg = Leg::new(place(63.0, 10.0), place(63.0, 10.0), 0.7);
        assert!((leg.bearing_rad() - 0.7).abs() < 1e-9);
        let ahead = leg.locate(displaced(place(63.0, 10.0), 0.7, 3.0));
        assert!((ahead.along_m - 3.0).abs() < 1e-3 && ahead.cross_m.abs() < 1e-3);
    }

    #[test]
    fn crosses_the_date_line() {
        let leg = Leg::new(place(10.0, 179.99), place(10.0, -179.99), 0.0);
        assert!((leg.length_m() - 2192.9).abs() < 2.0, "{}", leg.length_m());
        assert!((leg.bearing_rad() - FRAC_PI_2).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn agrees_with_the_flat_frame_nearby(
            lat_deg in -75.0..75.0_f64, bearing_rad in -3.1..3.1_f64, length_m in 5.0..500.0_f64,
            along_m in -50.0..500.0_f64, cross_m in -100.0..100.0_f64,
        ) {
            let start = place(lat_deg, 10.0);
            let leg = Leg::new(start, displaced(start, bearing_rad, length_m), 0.0);
            let frame = LocalFrame::new(start);
            let point = LocalPoint::default()
                .displaced(bearing_rad, along_m)
                .displaced(bearing_rad + FRAC_PI_2, cross_m);
            let got = leg.locate(frame.to_place(point));
            // The flat frame's own error: the meridians converge by x·y·tan(lat)/R, here up to 0.25 m.
            prop_assert!((got.along_m - along_m).abs() < 0.3, "{:?}", got);
            prop_assert!((got.cross_m - cross_m).abs() < 0.3, "{:?}", got);
            prop_assert!(units::wrap_pi(got.bearing_rad - bearing_rad).abs() < 1e-3);
        }

        #[test]
        fn any_two_places_give_numbers(
            a in (-90.0..90.0_f64, -180.0..180.0_f64), b in (-90.0..90.0_f64, -180.0..180.0_f64),
            c in (-90.0..90.0_f64, -180.0..180.0_f64),
        ) {
            let leg = Leg::new(place(a.0, a.1), place(b.0, b.1), 0.0);
            let got = leg.locate(place(c.0, c.1));
            prop_assert!(got.along_m.is_finite() && got.cross_m.is_finite() && got.bearing_rad.is_finite());
        }
    }
}
