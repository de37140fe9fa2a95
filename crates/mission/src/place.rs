//! Places of plans as somebody sent them, before they are checked.

use units::{LatLon, LocalPoint};

/// Latitude and longitude as somebody sent them, in radians; perhaps no place at all.
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
