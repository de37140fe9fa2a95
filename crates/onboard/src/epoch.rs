//! An epoch of the compass as IMC's messages.

use devices::{GnssReading, Quality};
use imc::messages::{EulerAngles, GpsFix, GpsFixType, GpsFixValidity};

const MICROS_OF_DAY: i64 = 86_400_000_000;

/// The attitude, where there is a heading; roll and pitch that the compass does not give are taken as level.
pub(crate) fn euler_angles(time: f64, reading: &GnssReading) -> Option<EulerAngles> {
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    Some(EulerAngles {
        time,
        phi: finite(reading.roll_rad).unwrap_or_default(),
        theta: finite(reading.pitch_rad).unwrap_or_default(),
        psi: finite(reading.heading_rad)?,
        psi_magnetic: finite(reading.magnetic_heading_rad).unwrap_or_default(),
    })
}

/// Position, movement and time.
pub(crate) fn gps_fix(reading: &GnssReading) -> GpsFix {
    let mut fix = GpsFix { satellites: reading.satellites, ..GpsFix::default() };
    let mut validity = GpsFixValidity::empty();
    if let Some(utc) = reading.utc {
        let civil = utc.civil();
        validity |= GpsFixValidity::VALID_DATE | GpsFixValidity::VALID_TIME;
        // Years of four digits; the receiver has no others.
        fix.utc_year = civil.year.clamp(0, 9999) as u16;
        fix.utc_month = civil.month;
        fix.utc_day = civil.day;
        fix.utc_time = (utc.micros().rem_euclid(MICROS_OF_DAY) as f64 / 1e6) as f32;
    }
    if let Some(position) = reading.fix.filter(|fix| fix.lat_rad.is_finite() && fix.lon_rad.is_finite()) {
        validity |= GpsFixValidity::VALID_POS;
        fix.r#type = match position.quality {
            Quality::Autonomous => GpsFixType::Standalone,
            // IMC has no number for the carrier's phase.
            Quality::Differential | Quality::RtkFixed | Quality::RtkFloat => GpsFixType::Differential,
            Quality::Estimated => GpsFixType::DeadReckoning,
        };
        fix.lat = position.lat_rad;
        fix.lon = position.lon_rad;
        // Not a number where the receiver does not report it.
        if position.height_m.is_finite() {
            fix.height = position.height_m as f32;
        }
        if position.hdop.is_finite() {
            validity |= GpsFixValidity::VALID_HDOP;
            fix.hdop = position.hdop as f32;
        }
    }
    if let Some(velocity) = reading.velocity.filter(|v| v.speed_mps.is_finite()) {
        validity |= GpsFixValidity::VALID_SOG;
        fix.sog = velocity.speed_mps as f32;
        // A vessel at rest has no course.
        if velocity.course_rad.is_finite() {
            validity |= GpsFixValidity::VALID_COG;
            fix.cog = velocity.course_rad as f32;
        }
    }
    fix.validity = validity;
    fix
}
