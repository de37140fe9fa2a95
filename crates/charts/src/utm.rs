//! Universal Transverse Mercator coordinates on GRS 80 or WGS 84 to latitude and longitude and back.
//!
//! Krüger's series in the third flattening n to the sixth order (L. Krüger 1912; C. F. F. Karney, "Transverse
//! Mercator with an accuracy of a few nanometers", J. Geodesy 85, 2011, equations 7 to 11, 35 and 36): below
//! 5 nm within 3900 km of the central meridian, so that zone 33 serves all of Norway as Kartverket uses it.
//!
//! EUREF89 (ETRS89) moves with Europe: about 0.8 m from WGS 84 in Norway by 2025, growing 2.5 cm a year.
//! [`Datum::offset_m`] says how much to allow; nothing is shifted.

use units::{LatLon, WGS84_FLATTENING, WGS84_SEMI_MAJOR_M, wrap_pi};

/// Scale on the central meridian.
const SCALE: f64 = 0.9996;
/// Easting of the central meridian (m).
const FALSE_EASTING_M: f64 = 500_000.0;
/// Northing of the equator on the southern hemisphere (m).
const FALSE_NORTHING_SOUTH_M: f64 = 10_000_000.0;
/// Farther from the central meridian nothing sensible is written in UTM (m).
const MAX_EASTING_OFFSET_M: f64 = 3_000_000.0;

/// The frame that coordinates were surveyed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Datum {
    /// WGS 84, as GNSS gives it.
    #[default]
    Wgs84,
    /// ETRS89, as EUREF89: WGS 84 of 1989, fixed to Europe. Its ellipsoid GRS 80 differs by 0.1 mm.
    Etrs89,
}

impl Datum {
    /// How far a position of this datum may lie from the same numbers in WGS 84 (m); to be added to the
    /// position uncertainty of a question.
    pub fn offset_m(self) -> f64 {
        match self {
            Self::Wgs84 => 0.0,
            Self::Etrs89 => 1.0,
        }
    }
}

/// Why numbers are not a place in UTM.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum UtmError {
    /// No such zone.
    #[error("there is no UTM zone {0}; zones are 1 to 60, Norway's charts use 32, 33 and 35")]
    Zone(u8),
    /// No such code.
    #[error(
        "EPSG:{0} is not a UTM zone of WGS 84 or ETRS89; \
         convert the file to EPSG:25832, 25833, 25835, 326xx or 327xx"
    )]
    Epsg(u32),
    /// Out of range.
    #[error(
        "easting {easting_m} m, northing {northing_m} m is not a place of the zone; check the order x y z"
    )]
    Range {
        /// Easting (m).
        easting_m: f64,
        /// Northing (m).
        northing_m: f64,
    },
}

/// A zone of UTM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Utm {
    zone: u8,
    south: bool,
    datum: Datum,
}

/// A place in a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UtmPoint {
    /// Easting (m).
    pub easting_m: f64,
    /// Northing (m).
    pub northing_m: f64,
}

impl Utm {
    /// A zone, 1 to 60.
    ///
    /// # Errors
    /// When there is no such zone.
    pub fn new(zone: u8, south: bool, datum: Datum) -> Result<Self, UtmError> {
        if (1..=60).contains(&zone) { Ok(Self { zone, south, datum }) } else { Err(UtmError::Zone(zone)) }
    }

    /// The zone of an EPSG code: 326xx and 327xx (WGS 84), 258xx (ETRS89, zones 28 to 38).
    ///
    /// # Errors
    /// When the code is another.
    pub fn from_epsg(code: u32) -> Result<Self, UtmError> {
        let zone = (code % 100) as u8;
        match code / 100 {
            326 => Self::new(zone, false, Datum::Wgs84),
            327 => Self::new(zone, true, Datum::Wgs84),
            258 if (28..=38).contains(&zone) => Self::new(zone, false, Datum::Etrs89),
            _ => Err(UtmError::Epsg(code)),
        }
        .map_err(|_| UtmError::Epsg(code))
    }

    /// The datum.
    pub fn datum(self) -> Datum {
        self.datum
    }

    /// Longitude of the central meridian (rad).
    fn meridian_rad(self) -> f64 {
        (f64::from(self.zone) * 6.0 - 183.0).to_radians()
    }

    fn false_northing_m(self) -> f64 {
        if self.south { FALSE_NORTHING_SOUTH_M } else { 0.0 }
    }

    /// A place in this zone's metres.
    pub fn to_utm(self, place: LatLon) -> UtmPoint {
        let (sin_lat, lon) = (place.lat_rad().sin(), wrap_pi(place.lon_rad() - self.meridian_rad()));
        let e = eccentricity();
        // Conformal latitude as its tangent (Karney 7 to 9).
        let tau = place.lat_rad().tan();
        let sigma = (e * (e * sin_lat).atanh()).sinh();
        let tau_c = tau * sigma.hypot(1.0) - sigma * tau.hypot(1.0);
        let xi = tau_c.atan2(lon.cos());
        let eta = (lon.sin() / tau_c.hypot(lon.cos())).asinh();
        let (mut north, mut east) = (xi, eta);
        for (at, alpha) in ALPHA.iter().enumerate() {
            let order = 2.0 * (at + 1) as f64;
            north += alpha * (order * xi).sin() * (order * eta).cosh();
            east += alpha * (order * xi).cos() * (order * eta).sinh();
        }
        let radius_m = SCALE * rectifying_radius_m();
        UtmPoint {
            easting_m: FALSE_EASTING_M + radius_m * east,
            northing_m: self.false_northing_m() + radius_m * north,
        }
    }

    /// The place of some metres.
    ///
    /// # Errors
    /// When they lie beyond 3000 km of the central meridian or beyond a pole.
    pub fn to_place(self, point: UtmPoint) -> Result<LatLon, UtmError> {
        let UtmPoint { easting_m, northing_m } = point;
        let range = UtmError::Range { easting_m, northing_m };
        let near = (easting_m - FALSE_EASTING_M).abs() <= MAX_EASTING_OFFSET_M && northing_m.abs() <= 2e7;
        if !near {
            return Err(range);
        }
        let radius_m = SCALE * rectifying_radius_m();
        let north = (northing_m - self.false_northing_m()) / radius_m;
        let east = (easting_m - FALSE_EASTING_M) / radius_m;
        if north.abs() > std::f64::consts::FRAC_PI_2 {
            return Err(range);
        }
        let (mut xi, mut eta) = (north, east);
        for (at, beta) in BETA.iter().enumerate() {
            let order = 2.0 * (at + 1) as f64;
            xi -= beta * (order * north).sin() * (order * east).cosh();
            eta -= beta * (order * north).cos() * (order * east).sinh();
        }
        let tau_c = xi.sin() / eta.sinh().hypot(xi.cos());
        let lon = self.meridian_rad() + eta.sinh().atan2(xi.cos());
        LatLon::from_rad(latitude_of(tau_c), wrap_pi(lon)).map_err(|_| range)
    }
}

/// Latitude by the tangent of its conformal latitude: Newton's method, Karney 19 to 21.
fn latitude_of(tau_c: f64) -> f64 {
    let e = eccentricity();
    let e2 = e * e;
    let mut tau = tau_c / (1.0 - e2);
    for _ in 0..5 {
        let sin_lat = tau / tau.hypot(1.0);
        let sigma = (e * (e * sin_lat).atanh()).sinh();
        let found = tau * sigma.hypot(1.0) - sigma * tau.hypot(1.0);
        let step = (tau_c - found) / found.hypot(1.0) * (1.0 + (1.0 - e2) * tau * tau)
            / ((1.0 - e2) * tau.hypot(1.0));
        tau += step;
        if step.abs() < 1e-15 * tau.abs().max(1.0) {
            break;
        }
    }
    tau.atan()
}

fn eccentricity() -> f64 {
    units::WGS84_ECCENTRICITY_SQUARED.sqrt()
}

/// Third flattening.
const N: f64 = WGS84_FLATTENING / (2.0 - WGS84_FLATTENING);
const N2: f64 = N * N;
const N3: f64 = N2 * N;
const N4: f64 = N2 * N2;
const N5: f64 = N4 * N;
const N6: f64 = N4 * N2;

/// Radius of the circle with the length of a meridian (Karney 14).
fn rectifying_radius_m() -> f64 {
    WGS84_SEMI_MAJOR_M / (1.0 + N) * (1.0 + N2 / 4.0 + N4 / 64.0 + N6 / 256.0)
}

/// Karney 35.
const ALPHA: [f64; 6] = [
    N / 2.0 - 2.0 / 3.0 * N2 + 5.0 / 16.0 * N3 + 41.0 / 180.0 * N4 - 127.0 / 288.0 * N5
        + 7891.0 / 37800.0 * N6,
    13.0 / 48.0 * N2 - 3.0 / 5.0 * N3 + 557.0 / 1440.0 * N4 + 281.0 / 630.0 * N5
        - 1_983_433.0 / 1_935_360.0 * N6,
    61.0 / 240.0 * N3 - 103.0 / 140.0 * N4 + 15061.0 / 26880.0 * N5 + 167_603.0 / 181_440.0 * N6,
    49561.0 / 161_280.0 * N4 - 179.0 / 168.0 * N5 + 6_601_661.0 / 7_257_600.0 * N6,
    34729.0 / 80640.0 * N5 - 3_418_889.0 / 1_995_840.0 * N6,
    212_378_941.0 / 319_334_400.0 * N6,
];

/// Karney 36.
const BETA: [f64; 6] = [
    N / 2.0 - 2.0 / 3.0 * N2 + 37.0 / 96.0 * N3 - N4 / 360.0 - 81.0 / 512.0 * N5 + 96199.0 / 604_800.0 * N6,
    N2 / 48.0 + N3 / 15.0 - 437.0 / 1440.0 * N4 + 46.0 / 105.0 * N5 - 1_118_711.0 / 3_870_720.0 * N6,
    17.0 / 480.0 * N3 - 37.0 / 840.0 * N4 - 209.0 / 4480.0 * N5 + 5569.0 / 90720.0 * N6,
    4397.0 / 161_280.0 * N4 - 11.0 / 504.0 * N5 - 830_251.0 / 7_257_600.0 * N6,
    4583.0 / 161_280.0 * N5 - 108_847.0 / 3_991_680.0 * N6,
    20_648_693.0 / 638_668_800.0 * N6,
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Longitude, latitude, easting and northing by PROJ (to 0.1 mm).
    const BY_PROJ: [(u32, f64, f64, f64, f64); 6] = [
        (25832, 10.3834, 63.4517, 568_983.823_4, 7_036_662.962_7),
        (25833, 10.3834, 63.4517, 269_927.552_7, 7_044_215.895_0),
        (25832, 9.2, 64.0, 509_782.421_6, 7_097_029.508_1),
        (25833, 9.2, 64.0, 216_608.081_8, 7_109_921.517_8),
        (25832, 8.0, 63.0, 449_348.956_0, 6_985_983.066_2),
        (25833, 8.0, 63.0, 145_951.716_7, 7_004_893.476_7),
    ];

    #[test]
    fn agrees_with_published_values_to_a_fifth_of_a_millimetre() {
        for (epsg, lon_deg, lat_deg, easting_m, northing_m) in BY_PROJ {
            // GRS 80, which these codes mean, is 0.1 mm shorter to the pole than WGS 84.
            let utm = Utm::from_epsg(epsg).unwrap();
            let point = utm.to_utm(LatLon::from_deg(lat_deg, lon_deg).unwrap());
            assert!((point.easting_m - easting_m).abs() < 2e-4, "{epsg} {point:?}");
            assert!((point.northing_m - northing_m).abs() < 2e-4, "{epsg} {point:?}");
            let place = utm.to_place(UtmPoint { easting_m, northing_m }).unwrap();
            // 0.2 mm is 2e-9 degrees of latitude and 4e-9 of longitude here.
            assert!((place.lat_deg() - lat_deg).abs() < 2e-9 && (place.lon_deg() - lon_deg).abs() < 4e-9);
        }
    }

    #[test]
    fn codes_that_are_no_utm_zone_are_refused_by_name() {
        for code in [4326, 3857, 25800, 25861, 32600, 32661, 0] {
            assert_eq!(Utm::from_epsg(code), Err(UtmError::Epsg(code)));
        }
        assert!(Utm::from_epsg(32733).is_ok());
        let utm = Utm::from_epsg(25833).unwrap();
        assert!(utm.to_place(UtmPoint { easting_m: 7e6, northing_m: 2e5 }).is_err());
        assert!(utm.to_place(UtmPoint { easting_m: f64::NAN, northing_m: 0.0 }).is_err());
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same_place(lat_deg in -84.0..84.0_f64, off_deg in -20.0..20.0_f64, zone in 1_u8..=60) {
            let utm = Utm::new(zone, lat_deg < 0.0, Datum::Wgs84).unwrap();
            let lon_rad = wrap_pi((f64::from(zone) * 6.0 - 183.0 + off_deg).to_radians());
            let place = LatLon::from_rad(lat_deg.to_radians(), lon_rad).unwrap();
            let back = utm.to_place(utm.to_utm(place)).unwrap();
            // 1e-12 rad is 6 µm on the ground.
            prop_assert!((back.lat_rad() - place.lat_rad()).abs() < 1e-12);
            prop_assert!(wrap_pi(back.lon_rad() - place.lon_rad()).abs() < 1e-11);
        }
    }
}
