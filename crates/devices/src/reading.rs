//! What the devices read, without the bytes that carry it.

use crate::pair::Side;
use units::UtcTime;

/// Something a device has read.
#[derive(Debug, Clone, PartialEq)]
pub enum Reading {
    /// An epoch of the GNSS compass.
    Gnss(GnssReading),
    /// A motor's feedback.
    Motor(Side, MotorReading),
    /// A battery's report.
    Battery(BatteryReading),
    /// A detection of a tag by the hydrophone.
    Tag(TagReading),
    /// The hydrophone's regular report of the water.
    Water(WaterReading),
}

/// All that the compass knows at one epoch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GnssReading {
    /// Time of the epoch, where the receiver has one.
    pub utc: Option<UtcTime>,
    /// Position; absent without a fix.
    pub fix: Option<GnssFix>,
    /// Satellites in use, or in view without a fix.
    pub satellites: u8,
    /// Movement over ground.
    pub velocity: Option<GroundVelocity>,
    /// True heading (rad).
    pub heading_rad: Option<f64>,
    /// Rate of turn, to starboard positive (rad/s).
    pub yaw_rate_rad_s: Option<f64>,
}

/// A position as the receiver has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GnssFix {
    /// Latitude (rad).
    pub lat_rad: f64,
    /// Longitude (rad).
    pub lon_rad: f64,
    /// Height above the ellipsoid (m).
    pub height_m: f64,
    /// How good.
    pub quality: Quality,
    /// Horizontal dilution of precision.
    pub hdop: f64,
}

/// How good a position is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// Satellites alone.
    #[default]
    Autonomous,
    /// With corrections.
    Differential,
}

/// Movement over ground as the receiver has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundVelocity {
    /// Course over ground (rad).
    pub course_rad: f64,
    /// Speed over ground (m/s).
    pub speed_mps: f64,
}

/// A motor's feedback.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorReading {
    /// Speed of the propeller (rpm), positive ahead.
    pub propeller_rpm: f64,
    /// Electrical power drawn (W).
    pub power_w: f64,
    /// Temperature of the motor's electronics (°C).
    pub temperature_c: f64,
}

/// A battery's report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BatteryReading {
    /// Its number, from 0.
    pub number: u8,
    /// Voltage under load (V).
    pub voltage_v: f64,
    /// Current drawn from it (A).
    pub current_a: f64,
    /// Charge (%).
    pub charge_percent: f64,
    /// Temperature (°C).
    pub temperature_c: f64,
}

/// A detection of a tag by the hydrophone.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TagReading {
    /// Serial number of the receiver.
    pub serial: u32,
    /// The receiver's clock: Unix time once it is set, else seconds since power-up (s).
    pub clock_s: u32,
    /// Thousandths of a second of the same clock.
    pub millis: u16,
    /// Name of the coding as the receiver writes it, which may be none of [`TagProtocol`](crate::tbr::TagProtocol).
    pub protocol: String,
    /// Number of the tag.
    pub tag_id: u32,
    /// The value sent, where the coding has one.
    pub data: Option<u16>,
    /// Signal to noise (dB).
    pub snr_db: u8,
    /// Carrier (kHz).
    pub frequency_khz: u8,
    /// Running number of the line.
    pub counter: u16,
    /// The line as it came, without its end, where there was one.
    pub raw: Option<String>,
}

/// The hydrophone's regular report of the water.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterReading {
    /// Serial number of the receiver.
    pub serial: u32,
    /// The receiver's clock (s).
    pub clock_s: u32,
    /// Temperature (°C).
    pub temperature_c: f64,
    /// Mean noise (receiver counts, dB-like).
    pub noise_average: u8,
    /// Peak noise (receiver counts, dB-like).
    pub noise_peak: u8,
    /// Frequency listened to (kHz).
    pub frequency_khz: u8,
    /// Running number of the line.
    pub counter: u16,
}
