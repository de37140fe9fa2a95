//! Places of plans as received, before they are checked.

use units::{LatLon, LocalPoint};

/// Latitude and longitude as received, in radians; perhaps not a valid place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawPlace {
    /// Latitude (rad).
    pub lat_rad: f64,
    /// Longitude (rad).
    pub lon_rad: f64,
}

impl From<LatLon> for RawPlace {
    fn from(place: LatLon) -> Self {
        Self { lat_rad: place.lat_rad(), lon_rad: place.lon_rad() }
    }
}

/// Metres north and east of a place.
pub type Offset = LocalPoint;
