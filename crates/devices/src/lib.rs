//! The devices aboard an Otter: what they read, and the bytes that carry it.
//!
//! The simulator writes these bytes, drivers of real devices read them, and both mean the same [`Reading`]s,
//! the input of the brain (`onboard`). A new device is a module of its own here, named after its protocol: its
//! reading type if no other device gives the same, its codec, and tests against recorded bytes. Opening the port
//! and timing stay in the program that uses it.
//!
//! Main types: [`Reading`] and its variants ([`GnssReading`], [`MotorReading`], [`BatteryReading`],
//! [`RailReading`], [`PowerChannelReading`], [`TagReading`], [`WaterReading`], [`ReceiverReading`]); [`Side`] and [`Pair`] for
//! what exists to port and to starboard. The codecs are [`nmea`] (GNSS compass), [`torqeedo`] (motors, batteries and power rails on the CAN bus),
//! [`tbr`] (hydrophone), [`tbr_clock`] (the commands that set the hydrophone's clock), [`vr2c`] (Innovasea's receivers) and
//! [`pattern`] (receivers whose lines a pattern declares); those of text use [`lines`]. CAN frames ([`can`]) come
//! through [`slcan`] adapters and [`candump`] logs too, and [`tq_bus`] is the motors' own line at the bench.
//!
//! The crate knows `units` and nothing else of Lutra: no IMC, no simulator, no clock, no input or output. SI units
//! and radians unless a name says otherwise; headings and courses turn clockwise from north. Readings are as
//! the devices gave them: what a device does not know is `None`, and numbers may still be invalid (NaN, out of
//! range); the user of a reading checks them.

pub mod can;
pub mod candump;
pub mod framer;
pub mod line_splitter;
pub mod lines;
pub mod nmea;
mod pair;
pub mod pattern;
mod reading;
pub mod slcan;
pub mod tbr;
pub mod tbr_clock;
pub mod torqeedo;
pub mod tq_bus;
pub mod vr2c;

pub use pair::{Pair, Side};
pub use reading::{
    BatteryReading, ClockState, GnssFix, GnssReading, GroundVelocity, MotorReading, Part,
    PowerChannelReading, PulseReading, Quality, RailReading, Reading, ReceiverReading, TagReading,
    TroubleReading, WaterReading,
};
