//! Frames of the interface card between the boat's CAN bus and its Torqeedo motors and batteries.
//!
//! Layout: from the DUNE task `Actuators.Torqeedo`. Identifiers have 29 bits: message 28..20, zero 19..16, source 15..8,
//! destination 7..0; numbers are little endian. The card is 0xAB, the vessel's computer 0xFE, and the card's own
//! messages go to all, 0xFF. [`Received`] reads any frame of the bus; [`CardCommand`] is what the computer asks and
//! [`CardReport`] what the (simulated) card reports, both as frames.

mod command;
mod message;
mod message_id;
mod report;
#[cfg(test)]
mod tests;

pub use crate::can::CanFrame;
pub use command::{CardCommand, CardError, per_mille};
pub use message::{BatteryStatus, DecodeError, Message, MotorDrive, Received, TEXT_LEN, Text};
pub use message_id::MessageId;
pub use report::CardReport;

/// Address of the interface card.
pub const CARD: u8 = 0xAB;
/// Address of the vessel's computer.
pub const COMPUTER: u8 = 0xFE;
/// The destination of what goes to all.
pub const ALL: u8 = 0xFF;

/// Turns of the motor for one turn of the propeller.
pub const GEAR: f64 = 7.0;
/// The largest throttle a [`CardCommand::MotorSet`] carries: full speed in per mille.
pub const FULL_THROTTLE: i16 = 1000;
/// Motors behind a card.
pub const MOTORS: u8 = 2;
/// Batteries behind a card.
pub const BATTERIES: u8 = 4;
/// Power rails of a card. Its first documents count four; the later ones, which are corrected, five.
pub const RAILS: u8 = 5;

/// The identifier of `message` from `source` to `destination`.
const fn identifier(message: MessageId, source: u8, destination: u8) -> u32 {
    (message.0 as u32) << 20 | (source as u32) << 8 | destination as u32
}
