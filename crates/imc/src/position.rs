//! Where a vehicle is, as `EstimatedState` says it: a reference point and an offset from it.

use crate::messages::EstimatedState;
use units::{Ecef, Geodetic, LatLon, PlaceError};

/// The vehicle's actual position: the reference point displaced by x, y and z metres north, east and down.
///
/// As DUNE's `WGS84::displace` has it, so that all programs put a vehicle at the same place: the offset is
/// turned into the Earth-centred frame at the *geocentric* latitude of the reference, atan2(Z, √(X²+Y²)).
/// The difference to the geodetic one is at most 0.19°, or 3 mm for each metre of offset.
pub fn displaced(state: &EstimatedState) -> Geodetic {
    let reference =
        Geodetic { lat_rad: state.lat, lon_rad: state.lon, height_m: f64::from(state.height) }.to_ecef();
    let (north_m, east_m, down_m) = (f64::from(state.x), f64::from(state.y), f64::from(state.z));
    let geocentric_rad = reference.z_m.atan2(reference.x_m.hypot(reference.y_m));
    let (sin_lat, cos_lat) = geocentric_rad.sin_cos();
    let (sin_lon, cos_lon) = state.lon.sin_cos();
    Ecef {
        x_m: reference.x_m - sin_lon * east_m - cos_lon * sin_lat * north_m - cos_lon * cos_lat * down_m,
        y_m: reference.y_m + cos_lon * east_m - sin_lon * sin_lat * north_m - sin_lon * cos_lat * down_m,
        z_m: reference.z_m + cos_lat * north_m - sin_lat * down_m,
    }
    .to_geodetic()
}

/// The same as a checked place.
///
/// # Errors
/// When the message holds numbers that are not a position, such as NaN.
pub fn place(state: &EstimatedState) -> Result<LatLon, PlaceError> {
    // Sine and cosine would wrap a latitude beyond a pole into another place.
    LatLon::from_rad(state.lat, state.lon)?;
    let at = displaced(state);
    LatLon::from_rad(at.lat_rad, at.lon_rad)
}

/// Speed over ground (m/s).
pub fn ground_speed_mps(state: &EstimatedState) -> f64 {
    f64::from(state.vx).hypot(f64::from(state.vy))
}

/// Course over ground, clockwise from north in (-π, π] (rad); meaningless at rest.
pub fn course_rad(state: &EstimatedState) -> f64 {
    f64::from(state.vy).atan2(f64::from(state.vx))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(lat_deg: f64, x: f32, y: f32) -> EstimatedState {
        EstimatedState {
            lat: lat_deg.to_radians(),
            lon: 10.353_5_f64.to_radians(),
            x,
            y,
            ..EstimatedState::default()
        }
    }

    #[test]
    fn no_offset_is_the_reference_itself() {
        let place = place(&at(63.440_6, 0.0, 0.0)).unwrap();
        assert!((place.lat_deg() - 63.440_6).abs() < 1e-12);
        assert!((place.lon_deg() - 10.353_5).abs() < 1e-12);
    }

    #[test]
    fn a_metre_is_a_metre_north_and_east() {
        // Radii of curvature of WGS-84 at 63.4406°: meridian 6 386 605 m, prime vertical 6 395 266 m.
        let place = place(&at(63.440_6, 100.0, 200.0)).unwrap();
        let north_m = (place.lat_rad() - 63.440_6_f64.to_radians()) * 6_386_605.0;
        let east_m =
            (place.lon_rad() - 10.353_5_f64.to_radians()) * 6_395_266.0 * 63.440_6_f64.to_radians().cos();
        // Up to 3 mm per metre by the geocentric angle (only as height) and the curvature of 200 m.
        assert!((north_m - 100.0).abs() < 0.01, "{north_m}");
        assert!((east_m - 200.0).abs() < 0.02, "{east_m}");
    }

    #[test]
    fn is_displaced_at_the_geocentric_latitude() {
        // Computed apart from this code by the formulas above. At the geodetic latitude the height would be
        // 79.945 m.
        let state = EstimatedState {
            lat: 63.4_f64.to_radians(),
            lon: 10.4_f64.to_radians(),
            height: 50.0,
            x: 100.0,
            y: 200.0,
            z: -30.0,
            ..EstimatedState::default()
        };
        let at = displaced(&state);
        assert!((at.lat_rad.to_degrees() - 63.400_896_322_786).abs() < 1e-10, "{at:?}");
        assert!((at.lon_rad.to_degrees() - 10.404_001_816_119).abs() < 1e-10, "{at:?}");
        assert!((at.height_m - 80.273_259).abs() < 1e-5, "{at:?}");
    }

    #[test]
    fn course_turns_clockwise_from_north() {
        let east = EstimatedState { vx: 0.0, vy: 2.0, psi: 0.3, ..EstimatedState::default() };
        assert!((course_rad(&east) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let north_west = EstimatedState { vx: 3.0, vy: -4.0, ..EstimatedState::default() };
        assert!((ground_speed_mps(&north_west) - 5.0).abs() < 1e-12);
        assert!((course_rad(&north_west) + 0.927_295_218).abs() < 1e-9);
    }

    #[test]
    fn nonsense_is_no_place() {
        assert!(place(&at(f64::NAN, 0.0, 0.0)).is_err());
        assert!(place(&at(120.0, 0.0, 0.0)).is_err());
        assert!(place(&at(63.0, f32::NAN, 0.0)).is_err());
    }
}
