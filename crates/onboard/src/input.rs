//! What the brain is told: sensor values, the health of its computer, packets, and the passing of time.
//!
//! Values are as the devices gave them: absent ones are `None`, and numbers may still be nonsense (NaN, out of
//! range). Refusing those is the business of [`Navigation`](crate::Navigation) and its neighbours. SI units
//! and radians.

use crate::grounding::ChartFile;
use crate::lease::Lease;
use mission::Ticket;
use std::net::SocketAddrV4;
use units::{MonoTime, UtcTime};

/// The moment at which something is handled: a steady time for deadlines and UTC for records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Now {
    /// Never goes back.
    pub mono: MonoTime,
    /// The computer's clock; it may be set while the vessel runs.
    pub utc: UtcTime,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// Nothing but time has passed.
    Timer,
    /// An epoch of the GNSS compass.
    Gnss(GnssReading),
    /// A motor's feedback.
    Motor(Side, MotorReading),
    /// A battery's report.
    Battery(BatteryReading),
    /// A detection of a tag.
    Tag(TagReading),
    /// The hydrophone's regular report.
    Water(WaterReading),
    /// The computer's own state.
    Host(HostReading),
    /// Bytes of one packet from a peer.
    Packet(Peer, Vec<u8>),
    /// Bytes of one packet from the shore, under the lease with this epoch (0 for none).
    Order(Peer, u64, Vec<u8>),
    /// The shore says who commands the vessel.
    Lease(Lease),
    /// Another sea chart came, to take the place of the one in force as soon as that is safe.
    Chart(ChartFile),
    /// A peer connected by TCP.
    Connected(Peer),
    /// A peer is gone.
    Disconnected(Peer),
    /// Addresses at which this system can be reached.
    Reachable(Reachable),
    /// A log was opened under this name, or could not be.
    LogOpened(Result<String, String>),
    /// A change of the plans is on the disk, or could not be brought there.
    Stored(Ticket, Result<(), String>),
    /// The parameters of the entity with this label are on the disk for the next start, or could not be brought
    /// there.
    ParametersKept(String, Result<(), String>),
    /// What else was to be kept on disk could not be.
    NotKept(String),
    /// The program is about to end: motors first.
    Shutdown,
}

/// One of the two motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Thruster 0.
    Port,
    /// Thruster 1.
    Starboard,
}

/// Whom a packet came from or goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Peer {
    /// A UDP socket.
    Udp(SocketAddrV4),
    /// A TCP connection, by a number the shell gave it ([`Peer::number`]).
    Tcp(u32),
}

/// Servers of streams that a system can have.
pub const SERVERS: u8 = 8;
/// The upper bits of a connection's number are its server.
const SERVER_SHIFT: u32 = 29;

impl Peer {
    /// The number of the `count`th connection to the `server`th server of the configuration, both from 0. Counts
    /// start anew after 2²⁹, servers after [`SERVERS`].
    pub fn number(server: u8, count: u32) -> u32 {
        (u32::from(server % SERVERS) << SERVER_SHIFT) | (count & ((1 << SERVER_SHIFT) - 1))
    }

    /// The server that a connection came to.
    pub fn server(self) -> Option<usize> {
        match self {
            Self::Udp(_) => None,
            Self::Tcp(number) => Some((number >> SERVER_SHIFT) as usize),
        }
    }
}

/// Where this system listens.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reachable {
    /// Sockets of UDP.
    pub udp: Vec<SocketAddrV4>,
    /// Sockets of TCP.
    pub tcp: Vec<SocketAddrV4>,
}

/// What the compass knows at one epoch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GnssReading {
    /// Time of the epoch, where the receiver has one.
    pub utc: Option<UtcTime>,
    /// Position; absent without a fix.
    pub fix: Option<GnssFix>,
    /// Satellites in use or view.
    pub satellites: u8,
    /// Course over ground (rad) and speed over ground (m/s).
    pub velocity: Option<(f64, f64)>,
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
    /// Whether corrections were used.
    pub differential: bool,
    /// Horizontal dilution of precision.
    pub hdop: f64,
}

/// A motor's feedback.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorReading {
    /// Speed of the propeller (1/min).
    pub rpm: f64,
    /// Electrical power (W).
    pub power_w: f64,
    /// Temperature (°C).
    pub temperature_c: f64,
}

/// A battery's report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BatteryReading {
    /// Its number, from 0.
    pub number: u8,
    /// Voltage (V).
    pub voltage_v: f64,
    /// Current drawn (A).
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
    /// The receiver's clock (s).
    pub clock_s: u32,
    /// Thousandths of a second of the same clock.
    pub millis: u16,
    /// Name of the coding.
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
}

/// The hydrophone's regular report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterReading {
    /// Serial number of the receiver.
    pub serial: u32,
    /// The receiver's clock (s).
    pub clock_s: u32,
    /// Temperature (°C).
    pub temperature_c: f64,
    /// Mean noise (receiver counts).
    pub noise_average: u8,
    /// Peak noise (receiver counts).
    pub noise_peak: u8,
    /// Frequency listened to (kHz).
    pub frequency_khz: u8,
    /// Running number of the line.
    pub counter: u16,
}

/// The state of the computer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HostReading {
    /// Load of the processor (%).
    pub cpu_percent: f64,
    /// Free space where logs are kept (MiB).
    pub disk_free_mib: f64,
    /// The same as share of the whole (%).
    pub disk_free_percent: f64,
    /// Memory in use by this program (MiB).
    pub memory_mib: f64,
    /// Temperature of the processor (°C), where known.
    pub temperature_c: Option<f64>,
}
