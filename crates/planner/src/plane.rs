//! A plane to search ways in.
//!
//! The oblique stereographic projection of the ellipsoid by way of the conformal sphere (EPSG Guidance Note 7-2, method
//! 9809). It is conformal, so that a circle of clearance stays a circle, and its scale is 1 + (r / 2R)² at a distance
//! r from the middle: 0.006 % at 100 km, 0.04 % at 250 km. The shortest way in the plane is the shortest on the sea to
//! that share.

use units::{LatLon, WGS84_ECCENTRICITY_SQUARED as E2, WGS84_SEMI_MAJOR_M, wrap_pi};

/// No plane has its middle nearer to a pole (rad).
const NEARLY_A_POLE_RAD: f64 = 1.57;

/// A point of the plane: metres to the east and to the north of its middle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Metres to the east.
    pub x: f64,
    /// Metres to the north.
    pub y: f64,
}

impl Point {
    pub(crate) fn distance_m(self, other: Self) -> f64 {
        self.square_m2(other).sqrt()
    }

    /// The square of the distance (m²): points of a plane are some thousand kilometres apart at most, so that none is too large.
    pub(crate) fn square_m2(self, other: Self) -> f64 {
        let (dx, dy) = (other.x - self.x, other.y - self.y);
        dx * dx + dy * dy
    }

    /// The point at a share of the way to another.
    pub(crate) fn towards(self, other: Self, share: f64) -> Self {
        Self { x: self.x + (other.x - self.x) * share, y: self.y + (other.y - self.y) * share }
    }

    /// Twice the area of the triangle of three points: positive where `b` lies to the left of the way from here to `a`.
    pub(crate) fn cross(self, a: Self, b: Self) -> f64 {
        (a.x - self.x) * (b.y - self.y) - (a.y - self.y) * (b.x - self.x)
    }

    /// The point of a segment that is nearest to this one.
    pub(crate) fn nearest_on(self, a: Self, b: Self) -> Self {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let square = dx * dx + dy * dy;
        let share = if square > 0.0 { ((self.x - a.x) * dx + (self.y - a.y) * dy) / square } else { 0.0 };
        a.towards(b, share.clamp(0.0, 1.0))
    }
}

/// The sides of a line; a point is a side without length.
pub(crate) fn sides(line: &[Point]) -> impl Iterator<Item = [Point; 2]> {
    let single = (line.len() == 1).then(|| [line[0], line[0]]);
    line.windows(2).map(|pair| [pair[0], pair[1]]).chain(single)
}

/// The projection around a middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    middle: LatLon,
    /// Diameter of the conformal sphere (m).
    diameter_m: f64,
    /// Exponent and constant of the sphere.
    n: f64,
    c: f64,
    sin_chi0: f64,
    cos_chi0: f64,
}

impl Plane {
    pub(crate) fn middle(&self) -> LatLon {
        self.middle
    }

    /// A plane around a place.
    pub fn new(middle: LatLon) -> Self {
        // At a pole itself the sphere's constants have no value.
        let lat_rad = middle.lat_rad().clamp(-NEARLY_A_POLE_RAD, NEARLY_A_POLE_RAD);
        let (sin, cos) = lat_rad.sin_cos();
        let w2 = 1.0 - E2 * sin * sin;
        let prime_vertical_m = WGS84_SEMI_MAJOR_M / w2.sqrt();
        let meridian_m = prime_vertical_m * (1.0 - E2) / w2;
        let n = (1.0 + E2 * cos.powi(4) / (1.0 - E2)).sqrt();
        let w1 = conformal_w(sin, n, 1.0);
        let sin_chi00 = (w1 - 1.0) / (w1 + 1.0);
        let c = (n + sin) * (1.0 - sin_chi00) / ((n - sin) * (1.0 + sin_chi00));
        let w = c * w1;
        let sin_chi0 = (w - 1.0) / (w + 1.0);
        Self {
            middle,
            diameter_m: 2.0 * (prime_vertical_m * meridian_m).sqrt(),
            n,
            c,
            sin_chi0,
            cos_chi0: (1.0 - sin_chi0 * sin_chi0).sqrt(),
        }
    }

    /// Where a place lies in the plane.
    pub fn point(&self, place: LatLon) -> Point {
        let w = conformal_w(place.lat_rad().sin(), self.n, self.c);
        let sin_chi = (w - 1.0) / (w + 1.0);
        let cos_chi = 2.0 * w.sqrt() / (w + 1.0);
        let (sin_l, cos_l) = (self.n * wrap_pi(place.lon_rad() - self.middle.lon_rad())).sin_cos();
        // The antipode lies nowhere; keep it finite.
        let b = (1.0 + sin_chi * self.sin_chi0 + cos_chi * self.cos_chi0 * cos_l).max(1e-9);
        let north = sin_chi * self.cos_chi0 - cos_chi * self.sin_chi0 * cos_l;
        Point { x: self.diameter_m * cos_chi * sin_l / b, y: self.diameter_m * north / b }
    }

    /// How much longer what lies at a point is in the plane than on the sea.
    pub(crate) fn scale(&self, at: Point) -> f64 {
        1.0 + (at.x * at.x + at.y * at.y) / (self.diameter_m * self.diameter_m)
    }

    /// The direction of true north at a point, of length 1.
    pub(crate) fn north(&self, at: Point) -> Point {
        let place = self.place(at);
        // Some metres to the north, or near the pole to the south.
        let sense = if place.lat_rad() < 1.57 { 1.0 } else { -1.0 };
        let beside = LatLon::from_rad(place.lat_rad() + sense * 1e-6, place.lon_rad()).unwrap_or(place);
        let beside = self.point(beside);
        let off_m = sense * at.distance_m(beside).max(1e-9);
        Point { x: (beside.x - at.x) / off_m, y: (beside.y - at.y) / off_m }
    }

    /// The place of a point.
    pub fn place(&self, point: Point) -> LatLon {
        let (x, y) = (point.x / self.diameter_m, point.y / self.diameter_m);
        // Plain stereographic on the sphere: tan(c/2) = radius / diameter.
        let square = x * x + y * y;
        let (sin_c_by_r, cos_c) = (2.0 / (1.0 + square), (1.0 - square) / (1.0 + square));
        let sin_chi = (cos_c * self.sin_chi0 + y * sin_c_by_r * self.cos_chi0).clamp(-1.0, 1.0);
        let l_rad = (x * sin_c_by_r).atan2(self.cos_chi0 * cos_c - y * self.sin_chi0 * sin_c_by_r);
        let lat_rad =
            latitude_rad(((1.0 + sin_chi) / (self.c * (1.0 - sin_chi).max(1e-15))).ln() / (2.0 * self.n));
        let lon_rad = wrap_pi(self.middle.lon_rad() + l_rad / self.n);
        // Only NaN is refused.
        LatLon::from_rad(lat_rad, lon_rad).unwrap_or(self.middle)
    }
}

fn conformal_w(sin_lat: f64, n: f64, c: f64) -> f64 {
    let e = E2.sqrt();
    let sin_lat = sin_lat.clamp(-1.0 + 1e-15, 1.0 - 1e-15);
    let s1 = (1.0 + sin_lat) / (1.0 - sin_lat);
    let s2 = (1.0 - e * sin_lat) / (1.0 + e * sin_lat);
    c * (s1 * s2.powf(e)).powf(n)
}

/// Latitude of an isometric latitude; it converges by e² a step.
fn latitude_rad(isometric: f64) -> f64 {
    let e = E2.sqrt();
    let mut sin = isometric.tanh();
    for _ in 0..8 {
        sin = (isometric + e * (e * sin).atanh()).tanh();
    }
    sin.asin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geographiclib_rs::{Geodesic, InverseGeodesic};
    use proptest::prelude::*;

    #[test]
    fn distances_from_the_middle_agree_with_the_geodesic() {
        let middle = LatLon::from_deg(63.44, 10.35).unwrap();
        let plane = Plane::new(middle);
        for (lat, lon) in [(63.45, 10.35), (63.44, 10.55), (63.9, 9.0), (62.8, 11.9)] {
            let point = plane.point(LatLon::from_deg(lat, lon).unwrap());
            let geodesic_m: f64 = Geodesic::wgs84().inverse(63.44, 10.35, lat, lon);
            let plane_m = point.distance_m(Point::default());
            let scale = 1.0 + (geodesic_m / (2.0 * 6.38e6)).powi(2) / 3.0;
            assert!((plane_m / geodesic_m - scale).abs() < 2e-6, "{plane_m} {geodesic_m}");
        }
    }

    #[test]
    fn lengths_far_from_the_middle_are_told_by_the_scale() {
        let plane = Plane::new(LatLon::from_deg(63.44, 10.35).unwrap());
        for (lat, lon) in [(63.44, 10.36), (66.0, 10.35), (68.5, 14.0), (60.0, 2.0)] {
            let [one, other] = [lat, lat + 0.01].map(|lat| plane.point(LatLon::from_deg(lat, lon).unwrap()));
            let geodesic_m: f64 = Geodesic::wgs84().inverse(lat, lon, lat + 0.01, lon);
            let scale = one.distance_m(other) / geodesic_m;
            assert!(
                (plane.scale(one.towards(other, 0.5)) / scale - 1.0).abs() < 2e-5,
                "{scale} at {lat}, {lon}"
            );
        }
    }

    proptest! {
        #[test]
        fn places_come_back(lat in -85.0..85.0f64, lon in -180.0..180.0f64, north in -3.0..3.0f64, east in -4.0..4.0f64) {
            let plane = Plane::new(LatLon::from_deg(lat, lon).unwrap());
            let place = LatLon::from_deg(lat + north, wrap_pi((lon + east).to_radians()).to_degrees()).unwrap();
            let back = plane.place(plane.point(place));
            prop_assert!((back.lat_rad() - place.lat_rad()).abs() < 1e-12);
            prop_assert!(wrap_pi(back.lon_rad() - place.lon_rad()).abs() < 1e-11);
        }

        #[test]
        fn angles_are_kept(lat in -80.0..80.0f64, north in -1.0..1.0f64, east in -1.0..1.0f64) {
            let plane = Plane::new(LatLon::from_deg(lat, 10.0).unwrap());
            let at = |dn: f64, de: f64| plane.point(LatLon::from_deg(lat + north + dn, 10.0 + east + de).unwrap());
            let frame = units::LocalFrame::new(LatLon::from_deg(lat + north, 10.0 + east).unwrap());
            let step = |dn: f64, de: f64| {
                let local = frame.to_local(LatLon::from_deg(lat + north + dn, 10.0 + east + de).unwrap());
                local.north_m.hypot(local.east_m)
            };
            let scale_n = at(0.0, 0.0).distance_m(at(1e-4, 0.0)) / step(1e-4, 0.0);
            let scale_e = at(0.0, 0.0).distance_m(at(0.0, 1e-4)) / step(0.0, 1e-4);
            prop_assert!((scale_n / scale_e - 1.0).abs() < 1e-4, "{scale_n} {scale_e}");
        }
    }
}
