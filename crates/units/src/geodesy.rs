//! The WGS-84 ellipsoid: between geodetic and Earth-centred coordinates.

/// Semi-major axis of WGS-84 (m). NIMA TR8350.2, table 3.1.
pub const WGS84_SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening of WGS-84. NIMA TR8350.2, table 3.1.
pub const WGS84_FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared of WGS-84, f(2 - f).
pub const WGS84_ECCENTRICITY_SQUARED: f64 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);

/// A point by geodetic latitude and longitude (rad) and height above the ellipsoid (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodetic {
    /// Latitude, north positive (rad).
    pub lat_rad: f64,
    /// Longitude, east positive (rad).
    pub lon_rad: f64,
    /// Height above the ellipsoid (m).
    pub height_m: f64,
}

/// A point in the Earth-centred, Earth-fixed frame (m): x to 0°N 0°E, y to 0°N 90°E, z to the north pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ecef {
    /// Towards 0°N 0°E (m).
    pub x_m: f64,
    /// Towards 0°N 90°E (m).
    pub y_m: f64,
    /// Towards the north pole (m).
    pub z_m: f64,
}

impl Geodetic {
    /// The same point, Earth-centred.
    pub fn to_ecef(self) -> Ecef {
        let (sin_lat, cos_lat) = self.lat_rad.sin_cos();
        let (sin_lon, cos_lon) = self.lon_rad.sin_cos();
        let normal_m = WGS84_SEMI_MAJOR_M / (1.0 - WGS84_ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
        let ring_m = (normal_m + self.height_m) * cos_lat;
        Ecef {
            x_m: ring_m * cos_lon,
            y_m: ring_m * sin_lon,
            z_m: (normal_m * (1.0 - WGS84_ECCENTRICITY_SQUARED) + self.height_m) * sin_lat,
        }
    }
}

impl Ecef {
    /// The same point by latitude, longitude and height.
    ///
    /// Bowring's latitude (B. R. Bowring, "Transformation from spatial to geographical coordinates", Survey
    /// Review 23, 1976), refined once: below a nanometre for heights within 10 km of the ellipsoid.
    pub fn to_geodetic(self) -> Geodetic {
        let e2 = WGS84_ECCENTRICITY_SQUARED;
        let semi_minor_m = WGS84_SEMI_MAJOR_M * (1.0 - WGS84_FLATTENING);
        let second_e2 = e2 / (1.0 - e2);
        let ring_m = self.x_m.hypot(self.y_m);
        let mut reduced = (self.z_m * WGS84_SEMI_MAJOR_M).atan2(ring_m * semi_minor_m);
        let mut lat_rad = 0.0;
        for _ in 0..2 {
            let (sin_r, cos_r) = reduced.sin_cos();
            lat_rad = (self.z_m + second_e2 * semi_minor_m * sin_r.powi(3))
                .atan2(ring_m - e2 * WGS84_SEMI_MAJOR_M * cos_r.powi(3));
            reduced = ((1.0 - WGS84_FLATTENING) * lat_rad.sin()).atan2(lat_rad.cos());
        }
        let (sin_lat, cos_lat) = lat_rad.sin_cos();
        // Height along the normal; this form has no singularity at the poles.
        let height_m = ring_m * cos_lat + self.z_m * sin_lat
            - WGS84_SEMI_MAJOR_M * (1.0 - e2 * sin_lat * sin_lat).sqrt();
        Geodetic { lat_rad, lon_rad: self.y_m.atan2(self.x_m), height_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equator_and_pole_stand_on_the_axes() {
        let equator = Geodetic { lat_rad: 0.0, lon_rad: 0.0, height_m: 0.0 }.to_ecef();
        assert!((equator.x_m - WGS84_SEMI_MAJOR_M).abs() < 1e-9);
        let pole = Geodetic { lat_rad: std::f64::consts::FRAC_PI_2, lon_rad: 0.0, height_m: 0.0 }.to_ecef();
        // Semi-minor axis of WGS-84: 6 356 752.3142 m (NIMA TR8350.2, table 3.3).
        assert!((pole.z_m - 6_356_752.314_2).abs() < 1e-4);
    }

    #[test]
    fn there_and_back_is_the_same_point() {
        for lat_deg in [-89.999_f64, -63.4, -1e-7, 0.0, 12.5, 63.440_6, 89.999] {
            for lon_deg in [-179.9_f64, -10.0, 0.0, 10.353_5, 179.9] {
                for height_m in [-50.0, 0.0, 43.25, 9_000.0] {
                    let point =
                        Geodetic { lat_rad: lat_deg.to_radians(), lon_rad: lon_deg.to_radians(), height_m };
                    let back = point.to_ecef().to_geodetic();
                    assert!((back.lat_rad - point.lat_rad).abs() < 1e-15 * 4.0, "{point:?} {back:?}");
                    assert!((back.lon_rad - point.lon_rad).abs() < 1e-15);
                    assert!((back.height_m - point.height_m).abs() < 1e-8, "{point:?} {back:?}");
                }
            }
        }
    }
}
