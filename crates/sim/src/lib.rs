//! A simulated Otter: the boat's dynamics in current, wind and waves, its motors and battery, its GNSS
//! compass, the interface card on its CAN bus and its hydrophone among tagged fish.
//!
//! Begin at [`Vessel`]: configure it, give it commands, step it, poll what its sensors send, as the bytes of
//! the real devices or as values. [`Otter`] is the bare model for open-loop checks; [`Fish`] is a tagged fish
//! that several vessels can hear. What sensors send are the [`devices`]' readings and bytes.
//!
//! The crate has no clock, no threads and no input or output. Time is the sum of the steps; chance comes from
//! seeds. Two runs with the same settings, seeds and commands give the same bytes. Units are SI and radians
//! but where a name says otherwise; headings and courses turn clockwise from north.
//!
//! It knows `devices` and `units`: no IMC, no brain, no chart.

mod battery;
mod card;
mod compass_settings;
mod current;
mod environment;
mod faults;
mod fish;
mod gnss;
mod hydrophone;
mod motor;
mod otter;
mod process;
mod range;
mod rng;
mod tbr_clock;
mod vessel;
mod waves;
mod wind;

pub use battery::{BatteryBank, BatteryConfig};
pub use card::CardConfig;
pub use compass_settings::AtFirst;
pub use current::CurrentConfig;
pub use environment::{Environment, EnvironmentConfig};
pub use faults::Faults;
pub use fish::{Fish, FishConfig, Ping};
pub use gnss::GnssConfig;
pub use hydrophone::HydrophoneConfig;
pub use motor::{Drive, Motor, ThrottleMap, radps, rpm};
pub use otter::{
    BodyForce, Load, MAX_PAYLOAD_KG, Otter, OtterState, STEP_S, shaft_max_radps, shaft_min_radps, thrust_n,
};
pub use range::OutOfRange;
pub use tbr_clock::{ClockConfig, ReceiverClock};
pub use vessel::{Output, OutputForm, Port, Timed, Truth, Vessel, VesselConfig};
pub use waves::WaveConfig;
pub use wind::WindConfig;
