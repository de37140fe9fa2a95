//! The meaning of any frame of the bus.
//!
//! Bytes are unsigned but where a field is known to go below zero: the DUNE task takes them for C's `char`, whose sign
//! differs between processors. Frames may be longer than their fields, as a later card's would be; shorter ones are
//! errors.

use super::{ALL, BATTERIES, CARD, COMPUTER, GEAR, MOTORS, MessageId, RAILS};
use crate::can::{CanFrame, CanId, MOST_DATA};
use crate::reading::{BatteryReading, MotorReading, RailReading};
use thiserror::Error;

/// The most characters of a [`Message::Text`].
pub const TEXT_LEN: usize = MOST_DATA;

/// A frame that has been read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Received {
    /// Address of the sender.
    pub source: u8,
    /// Address it is meant for.
    pub destination: u8,
    /// Its contents.
    pub message: Message,
}

/// The contents of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Message {
    /// Up to eight characters for a person who looks for faults.
    Text(Text),
    /// A power rail.
    Rail(RailReading),
    /// Which channels of a rail are on.
    Outputs {
        /// The rail.
        rail: u8,
        /// Bit n is set while channel n is on.
        channels: u32,
    },
    /// The computer switches a power channel.
    OutputSet {
        /// Rail of the channel.
        rail: u8,
        /// Number of the channel on its rail.
        channel: u8,
        /// On or off.
        on: bool,
    },
    /// How long the card has been on.
    Uptime {
        /// Time since its start (s).
        uptime_s: u32,
        /// Why it started, as the card counts.
        reset_cause: u8,
    },
    /// A motor at work.
    MotorDrive(MotorDrive),
    /// The computer sets the throttles of motor 0 and motor 1 (per mille of full speed).
    MotorSet([i16; 2]),
    /// A battery's state.
    BatteryStatus(BatteryStatus),
    /// A battery's controller.
    BatteryControl {
        /// The battery.
        battery: u8,
        /// Error of the controller; 0 for none.
        master_error: u8,
        /// Errors counted.
        error_count: u8,
        /// Version of its firmware.
        firmware: u8,
    },
    /// A motor's errors and status, bit by bit.
    MotorStatus {
        /// The motor.
        motor: u8,
        /// Errors.
        errors: u16,
        /// Status.
        status: u8,
    },
    /// Who made the card, and which it is.
    Id {
        /// Number of the maker.
        company: u16,
        /// Number of the product.
        product: u16,
        /// Serial number.
        serial: u16,
        /// Version of the firmware.
        firmware: u16,
    },
    /// A message whose content no document explains, or that no document lists. Its data stay in the frame.
    Other(MessageId),
}

/// Characters that a card sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Text {
    len: u8,
    bytes: [u8; TEXT_LEN],
}

impl Text {
    /// The characters, without those that fill the frame up.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }
}

/// A motor at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorDrive {
    /// Number of the motor.
    pub motor: u8,
    /// Electrical power drawn (W).
    pub power_w: f64,
    /// Temperature of the electronics (°C).
    pub temperature_c: f64,
    /// Speed of the motor before its gear (rpm), ahead positive.
    pub motor_rpm: i16,
}

impl MotorDrive {
    /// Speed of the propeller in whole turns a minute, truncated toward zero as the DUNE task has it.
    pub fn propeller_rpm(&self) -> i16 {
        self.motor_rpm / GEAR as i16
    }

    /// The same as the brain is given it.
    pub fn reading(&self) -> MotorReading {
        MotorReading {
            propeller_rpm: f64::from(self.propeller_rpm()),
            power_w: self.power_w,
            temperature_c: self.temperature_c,
        }
    }
}

/// A battery's state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryStatus {
    /// What it measures.
    pub reading: BatteryReading,
    /// Number of its error; 0 for none.
    pub error: u8,
}

/// Why nothing is read from a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// Another device's frame: the card's have extended identifiers whose bits 19 to 16 are zero, and data.
    #[error(
        "frame {0:X} is not of the card's protocol: it needs a 29-bit identifier with bits 19 to 16 zero, and data"
    )]
    Foreign(u32),
    /// Too few bytes.
    #[error("{message} has {len} bytes and needs {needs}")]
    Short {
        /// The message.
        message: MessageId,
        /// Bytes found.
        len: u8,
        /// Bytes that its fields take.
        needs: u8,
    },
    /// A number of a motor, battery or rail that does not exist.
    #[error("{message} is about number {index}, and there are {count}, counted from 0")]
    Index {
        /// The message.
        message: MessageId,
        /// The number found.
        index: u8,
        /// How many exist.
        count: u8,
    },
}

impl Received {
    /// Reads a frame of any sender.
    ///
    /// # Errors
    /// When the frame is not of the card's protocol, lacks bytes, or is about a motor, battery or rail that does not
    /// exist.
    pub fn decode(frame: &CanFrame) -> Result<Self, DecodeError> {
        let id = frame.id();
        let extended = matches!(frame.full_id(), CanId::Extended(_));
        if !extended || frame.is_request() || id >> 16 & 0xF != 0 {
            return Err(DecodeError::Foreign(id));
        }
        // 29 bits less 20 are 9, and addresses are single bytes.
        let message = Message::decode(MessageId((id >> 20) as u16), frame.data())?;
        Ok(Self { source: (id >> 8) as u8, destination: id as u8, message })
    }

    /// Whether the vessel's own computer may believe this. A rail it believes only from the card to all, for other
    /// senders on the bus report rails of their own; the sender of the other messages is not checked, as no document
    /// says that they come from the card alone, and the DUNE task does not check it. Its own messages it ignores.
    pub fn concerns_computer(&self) -> bool {
        match self.message {
            Message::Rail(_) => self.source == CARD && self.destination == ALL,
            Message::OutputSet { .. } | Message::MotorSet(_) => false,
            _ => self.source != COMPUTER && matches!(self.destination, ALL | COMPUTER),
        }
    }
}

impl Message {
    fn decode(id: MessageId, data: &[u8]) -> Result<Self, DecodeError> {
        let fields = Fields { id, data };
        Ok(match id {
            MessageId::TEXT => Self::Text(text(data)),
            MessageId::RAIL => Self::Rail(rail(fields)?),
            MessageId::OUTPUTS => {
                let [rail, c0, c1, c2, c3] = fields.first()?;
                let rail = fields.index(rail, RAILS)?;
                Self::Outputs { rail, channels: u32::from_le_bytes([c0, c1, c2, c3]) }
            }
            MessageId::OUTPUT_SET => {
                let [rail, channel, on] = fields.first()?;
                Self::OutputSet { rail, channel, on: on != 0 }
            }
            MessageId::UPTIME => {
                let [s0, s1, s2, reset_cause] = fields.first()?;
                Self::Uptime { uptime_s: u32::from_le_bytes([s0, s1, s2, 0]), reset_cause }
            }
            MessageId::MOTOR_DRIVE => Self::MotorDrive(motor_drive(fields)?),
            MessageId::MOTOR_SET => {
                let [a0, a1, b0, b1] = fields.first()?;
                Self::MotorSet([i16::from_le_bytes([a0, a1]), i16::from_le_bytes([b0, b1])])
            }
            MessageId::BATTERY_STATUS => Self::BatteryStatus(battery_status(fields)?),
            MessageId::BATTERY_CONTROL => {
                let [battery, master_error, error_count, firmware] = fields.first()?;
                // The number is in the low four bits; of the high ones nothing is known.
                let battery = fields.index(battery & 0x0F, BATTERIES)?;
                Self::BatteryControl { battery, master_error, error_count, firmware }
            }
            MessageId::MOTOR_STATUS => {
                let [motor, e0, e1, status] = fields.first()?;
                let motor = fields.index(motor, MOTORS)?;
                Self::MotorStatus { motor, errors: u16::from_le_bytes([e0, e1]), status }
            }
            MessageId::ID_V2 => {
                let [c0, c1, p0, p1, s0, s1, f0, f1] = fields.first()?;
                Self::Id {
                    company: u16::from_le_bytes([c0, c1]),
                    product: u16::from_le_bytes([p0, p1]),
                    serial: u16::from_le_bytes([s0, s1]),
                    firmware: u16::from_le_bytes([f0, f1]),
                }
            }
            other => Self::Other(other),
        })
    }
}

/// The data of a message, from which fields are taken.
#[derive(Clone, Copy)]
struct Fields<'a> {
    id: MessageId,
    data: &'a [u8],
}

impl Fields<'_> {
    /// The first `N` bytes; more are let be.
    fn first<const N: usize>(self) -> Result<[u8; N], DecodeError> {
        // Neither length goes beyond the eight bytes of a frame.
        let short = DecodeError::Short { message: self.id, len: self.data.len() as u8, needs: N as u8 };
        self.data.first_chunk().copied().ok_or(short)
    }

    /// `index`, where it is below `count`.
    fn index(self, index: u8, count: u8) -> Result<u8, DecodeError> {
        let beyond = DecodeError::Index { message: self.id, index, count };
        if index < count { Ok(index) } else { Err(beyond) }
    }
}

/// The characters up to the zeros that may fill the frame up.
fn text(data: &[u8]) -> Text {
    let len = data.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1).min(TEXT_LEN);
    let mut bytes = [0; TEXT_LEN];
    bytes[..len].copy_from_slice(&data[..len]);
    Text { len: len as u8, bytes }
}

fn rail(fields: Fields<'_>) -> Result<RailReading, DecodeError> {
    let [rail, v0, v1, a0, a1, a2, fuse, flags] = fields.first()?;
    // The current has a sign: rails are charged too, and a rail without load reads a few mA to either side of zero.
    // The DUNE task leaves the sign of the 24 bits out and reports -3 mA as 16777 A. Shifting the number up to the
    // sign bit of 32 and back repeats its own.
    let milliamperes = i32::from_le_bytes([0, a0, a1, a2]) >> 8;
    Ok(RailReading {
        number: fields.index(rail, RAILS)?,
        voltage_v: f64::from(u16::from_le_bytes([v0, v1])) / 1e3,
        current_a: f64::from(milliamperes) / 1e3,
        fuse_a: f64::from(fuse) / 2.0,
        flags,
    })
}

fn motor_drive(fields: Fields<'_>) -> Result<MotorDrive, DecodeError> {
    let [motor, w0, w1, t0, t1, n0, n1] = fields.first()?;
    Ok(MotorDrive {
        motor: fields.index(motor, MOTORS)?,
        power_w: f64::from(u16::from_le_bytes([w0, w1])),
        temperature_c: f64::from(i16::from_le_bytes([t0, t1])) / 10.0,
        motor_rpm: i16::from_le_bytes([n0, n1]),
    })
}

fn battery_status(fields: Fields<'_>) -> Result<BatteryStatus, DecodeError> {
    let [battery, temperature, v0, v1, a0, a1, charge, error] = fields.first()?;
    let reading = BatteryReading {
        number: fields.index(battery, BATTERIES)?,
        voltage_v: f64::from(u16::from_le_bytes([v0, v1])) / 100.0,
        current_a: f64::from(u16::from_le_bytes([a0, a1])) / 10.0,
        charge_percent: f64::from(charge),
        temperature_c: f64::from(temperature),
    };
    Ok(BatteryStatus { reading, error })
}
