//! Output of a simulated receiver.

use devices::nmea::{EarthModel, Sentence};
use devices::{GnssFix, GnssReading, GroundVelocity, Quality};
use std::time::{SystemTime, UNIX_EPOCH};
use units::UtcTime;

/// Its position (rad).
pub(crate) const PLACE_RAD: (f64, f64) = (1.107, 0.18);
/// Its heading (rad).
pub(crate) const HEADING_RAD: f64 = 1.25;

/// An epoch with the present time.
pub(crate) fn epoch() -> Vec<u8> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    epoch_at(UtcTime::from_micros(since.as_micros() as i64))
}

/// An epoch at a time.
pub(crate) fn epoch_at(utc: UtcTime) -> Vec<u8> {
    let reading = GnssReading {
        utc: Some(utc),
        fix: Some(GnssFix {
            lat_rad: PLACE_RAD.0,
            lon_rad: PLACE_RAD.1,
            height_m: 40.0,
            quality: Quality::RtkFixed,
            hdop: 0.6,
        }),
        satellites: 9,
        velocity: Some(GroundVelocity { course_rad: 1.3, speed_mps: 0.5 }),
        heading_rad: Some(HEADING_RAD),
        yaw_rate_rad_s: Some(0.01),
        ..GnssReading::default()
    };
    Sentence::EPOCH.iter().flat_map(|kind| kind.encode(&reading, &EarthModel::default())).collect()
}
