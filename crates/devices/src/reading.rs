//! The readings of the devices, without the bytes that carry them.

use crate::pair::Side;
use units::UtcTime;

/// A reading of a device.
#[derive(Debug, Clone, PartialEq)]
pub enum Reading {
    /// An epoch of the GNSS compass.
    Gnss(GnssReading),
    /// A motor's feedback.
    Motor(Side, MotorReading),
    /// A battery's report.
    Battery(BatteryReading),
    /// A power rail's report.
    Rail(RailReading),
    /// Whether a power channel is on.
    PowerChannel(PowerChannelReading),
    /// The receiver's pulse at a whole second.
    Pulse(PulseReading),
    /// A fault that a part reports, or its end.
    Trouble(TroubleReading),
    /// A detection of a tag by the hydrophone.
    Tag(TagReading),
    /// The hydrophone's regular report of the water.
    Water(WaterReading),
    /// How the hydrophone listens and its clock is kept.
    Receiver(ReceiverReading),
}

/// A pulse per second of the satellites' receiver, as the kernel saw it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PulseReading {
    /// The computer's clock at the pulse.
    pub utc: UtcTime,
    /// The kernel's count of pulses.
    pub sequence: u32,
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
    /// Roll, to starboard positive (rad).
    pub roll_rad: Option<f64>,
    /// Pitch, bow up positive (rad).
    pub pitch_rad: Option<f64>,
    /// Magnetic heading (rad).
    pub magnetic_heading_rad: Option<f64>,
}

/// A position as the receiver has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GnssFix {
    /// Latitude (rad).
    pub lat_rad: f64,
    /// Longitude (rad).
    pub lon_rad: f64,
    /// Height above the ellipsoid (m); not a number where it is not reported.
    pub height_m: f64,
    /// How good.
    pub quality: Quality,
    /// Horizontal dilution of precision; not a number where it is not reported.
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
    /// By the phase of the carrier, its whole cycles known: centimetres.
    RtkFixed,
    /// By the phase of the carrier, its whole cycles estimated: decimetres.
    RtkFloat,
    /// Reckoned on from earlier positions, without satellites.
    Estimated,
}

/// Movement over ground as the receiver has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundVelocity {
    /// Course over ground (rad); not a number where it [stands](Self::stands).
    pub course_rad: f64,
    /// Speed over ground (m/s).
    pub speed_mps: f64,
}

impl GroundVelocity {
    /// Slower than this a receiver may leave its course empty (m/s).
    pub const STANDING_MPS: f64 = 0.1;

    /// Whether it is the velocity of a vessel that stands still: too slow for the receiver to give a course.
    pub fn stands(&self) -> bool {
        self.course_rad.is_nan() && self.speed_mps < Self::STANDING_MPS
    }
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

/// A power rail's report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RailReading {
    /// Its number, from 0.
    pub number: u8,
    /// Voltage (V).
    pub voltage_v: f64,
    /// Current drawn from it (A); negative while current flows into it.
    pub current_a: f64,
    /// Its fuse (A).
    pub fuse_a: f64,
    /// Flags of the card, which no document explains.
    pub flags: u8,
}

/// Whether a power channel is on, as the card reports it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PowerChannelReading {
    /// Number of its rail, from 0.
    pub rail: u8,
    /// The name the vessel's configuration gives it.
    pub name: String,
    /// Whether it is on.
    pub on: bool,
}

/// A part that reports errors of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// A motor.
    Motor(Side),
    /// A battery, by its number from 0.
    Battery(u8),
}

/// A fault that a part reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TroubleReading {
    /// The part.
    pub part: Part,
    /// The fault and the remedy, in one sentence; empty when the fault is over.
    pub text: String,
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
    /// Lines that the receiver wrote since the previous one and that were lost; absent where unknown, as for the first.
    pub lines_lost: Option<u16>,
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
    /// Lines that the receiver wrote since the previous one and that were lost; absent where unknown, as for the first.
    pub lines_lost: Option<u16>,
}

/// How the hydrophone listens and its clock is kept, as its driver knows it: given before the line that it matters to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReceiverReading {
    /// Whether it listens: its port is open, it is not in command mode, and it is not silent.
    pub listening: bool,
    /// Frequency listened to (kHz), as set or as its lines say.
    pub frequency_khz: Option<u8>,
    /// Number of the set of codings that it decodes, as set (LM).
    pub protocols: Option<u8>,
    /// How good its clock is.
    pub clock: ClockState,
    /// The least of the last differences between the arrival of a line by this computer's clock and its stamp (s): how far
    /// the receiver's clock is behind, with the shortest delay of a line in it. Absent until stamps have come.
    pub clock_offset_s: Option<f64>,
    /// Why the clock was lost and the remedy, in one sentence; empty while it is not.
    pub clock_fault: String,
}

/// How good a receiver's clock is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClockState {
    /// Nothing is known of it yet.
    #[default]
    Unknown,
    /// It counts from power-up.
    Unset,
    /// It was set.
    Set,
    /// It was set, and rounded to a mark or kept by the pulse since.
    Disciplined,
    /// It was good and is not known to be any more: commands are not acknowledged, it restarted, its stamps are off, or the
    /// computer's own clock was set.
    Lost,
}
