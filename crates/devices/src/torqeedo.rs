//! Frames of the interface card between the boat's CAN bus and its Torqeedo motors and batteries.
//!
//! Layout: from the DUNE task `Actuators.Torqeedo`. Identifiers have 29 bits:
//! message 28..20, source 15..8, destination 7..0; numbers are little endian. The card is 0xAB, the vessel's
//! computer 0xFE, and the card's own messages go to all, 0xFF.

use crate::pair::{Pair, Side};
use crate::reading::{BatteryReading, MotorReading, Reading};
use thiserror::Error;

const CARD: u32 = 0xAB;
const COMPUTER: u32 = 0xFE;
const ALL: u32 = 0xFF;

const RAIL: u32 = 3;
const OUTPUT_SET: u32 = 9;
const MOTOR_DRIVE: u32 = 12;
const MOTOR_SET: u32 = 13;
const BATTERY_STATUS: u32 = 14;

/// Turns of the motor for one turn of the propeller.
pub const GEAR: f64 = 7.0;
/// The largest throttle a [`CardCommand::MotorSet`] carries: full speed in per mille.
pub const FULL_THROTTLE: i16 = 1000;

/// One extended CAN frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: u32,
    len: u8,
    data: [u8; 8],
}

impl CanFrame {
    /// A frame; `None` for an identifier beyond 29 bits or more than eight bytes.
    pub fn new(id: u32, data: &[u8]) -> Option<Self> {
        if id >= 1 << 29 || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self { id, len: data.len() as u8, data: bytes })
    }

    /// The identifier, 29 bits.
    pub fn id(&self) -> u32 {
        self.id
    }

    /// The bytes, at most eight.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    /// A frame of at most eight bytes that the card sends to all.
    fn from_card(message: u32, bytes: &[u8]) -> Self {
        let mut data = [0; 8];
        data[..bytes.len()].copy_from_slice(bytes);
        Self { id: message << 20 | CARD << 8 | ALL, len: bytes.len() as u8, data }
    }
}

/// What the computer asks of the card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CardCommand {
    /// Throttle of both motors in per mille, -1000 to 1000.
    MotorSet(Pair<i16>),
    /// A power channel on or off.
    OutputSet {
        /// Rail of the channel.
        rail: u8,
        /// Number of the channel on its rail.
        channel: u8,
        /// On or off.
        on: bool,
    },
}

/// Why the card makes nothing of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CardError {
    /// The identifier is not that of a message from the computer to the card.
    #[error("the frame {0:08X} is not addressed by the computer to the card")]
    Address(u32),
    /// The message is none that the card obeys.
    #[error("the card obeys no message {0}")]
    Message(u32),
    /// Too few or too many bytes.
    #[error("message {message} has {len} bytes")]
    Length {
        /// The message.
        message: u32,
        /// Bytes found.
        len: u8,
    },
    /// A throttle beyond full speed.
    #[error("the throttle {0} is not within -1000 to 1000")]
    Throttle(i16),
}

impl CardCommand {
    /// Reads a frame as the card does.
    ///
    /// # Errors
    /// When the frame is not for the card, or is none that it obeys.
    pub fn parse(frame: &CanFrame) -> Result<Self, CardError> {
        if frame.id & 0xF_FFFF != COMPUTER << 8 | CARD {
            return Err(CardError::Address(frame.id));
        }
        let message = frame.id >> 20;
        match (message, frame.data()) {
            (MOTOR_SET, &[p0, p1, s0, s1]) => {
                let set = Pair::new(i16::from_le_bytes([p0, p1]), i16::from_le_bytes([s0, s1]));
                for throttle in [set.port, set.starboard] {
                    if !(-FULL_THROTTLE..=FULL_THROTTLE).contains(&throttle) {
                        return Err(CardError::Throttle(throttle));
                    }
                }
                Ok(Self::MotorSet(set))
            }
            (OUTPUT_SET, &[rail, channel, on]) => Ok(Self::OutputSet { rail, channel, on: on != 0 }),
            (MOTOR_SET | OUTPUT_SET, _) => Err(CardError::Length { message, len: frame.len }),
            _ => Err(CardError::Message(message)),
        }
    }

    /// The frame by which the computer asks for this.
    pub fn frame(self) -> CanFrame {
        let (message, len, data) = match self {
            Self::MotorSet(set) => {
                let ([p0, p1], [s0, s1]) = (set.port.to_le_bytes(), set.starboard.to_le_bytes());
                (MOTOR_SET, 4, [p0, p1, s0, s1, 0, 0, 0, 0])
            }
            Self::OutputSet { rail, channel, on } => {
                (OUTPUT_SET, 3, [rail, channel, u8::from(on), 0, 0, 0, 0, 0])
            }
        };
        CanFrame { id: message << 20 | COMPUTER << 8 | CARD, len, data }
    }
}

/// One report of the card.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CardReport {
    /// A motor's speed, power and temperature.
    Motor(Side, MotorReading),
    /// A battery's state.
    Battery(BatteryReading),
    /// A power rail.
    Rail {
        /// Number of the rail.
        rail: u8,
        /// Voltage (V).
        voltage_v: f64,
        /// Current (A).
        current_a: f64,
        /// Fuse (A).
        fuse_a: f64,
    },
}

impl CardReport {
    /// The frame that carries this report.
    pub fn frame(&self) -> CanFrame {
        match *self {
            Self::Motor(side, r) => {
                motor_drive(side.index(), r.power_w, r.temperature_c, r.propeller_rpm * GEAR)
            }
            Self::Battery(r) => {
                battery_status(r.number, r.temperature_c, r.voltage_v, r.current_a, r.charge_percent, 0)
            }
            Self::Rail { rail: number, voltage_v, current_a, fuse_a } => {
                rail(number, voltage_v, current_a, fuse_a, 0)
            }
        }
    }

    /// What the brain is given of it: nothing of the rails.
    pub fn reading(&self) -> Option<Reading> {
        match *self {
            Self::Motor(side, reading) => Some(Reading::Motor(side, reading)),
            Self::Battery(reading) => Some(Reading::Battery(reading)),
            Self::Rail { .. } => None,
        }
    }
}

/// TQ_MOTOR_DRIVE: power (W), temperature of the board (°C) and speed of the motor (rpm, before the gear).
fn motor_drive(motor: u8, power_w: f64, temperature_c: f64, motor_rpm: f64) -> CanFrame {
    // `as` from a float holds the value within the integer's range.
    let [w0, w1] = (power_w.round() as u16).to_le_bytes();
    let [t0, t1] = ((temperature_c * 10.0).round() as i16).to_le_bytes();
    let [n0, n1] = (motor_rpm.round() as i16).to_le_bytes();
    CanFrame::from_card(MOTOR_DRIVE, &[motor, w0, w1, t0, t1, n0, n1])
}

/// TQ_BAT_STATUS: temperature (°C), voltage (V), current (A), charge (%) and error number of one battery.
fn battery_status(
    battery: u8,
    temperature_c: f64,
    voltage_v: f64,
    current_a: f64,
    charge_percent: f64,
    error: u8,
) -> CanFrame {
    let [v0, v1] = ((voltage_v * 100.0).round() as u16).to_le_bytes();
    let [a0, a1] = ((current_a * 10.0).round() as u16).to_le_bytes();
    let charge = charge_percent.round().clamp(0.0, 100.0) as u8;
    let temperature = temperature_c.round() as u8;
    CanFrame::from_card(BATTERY_STATUS, &[battery, temperature, v0, v1, a0, a1, charge, error])
}

/// RAIL: voltage (V), current (A, may be negative), fuse (A) and flags of one power rail.
fn rail(rail: u8, voltage_v: f64, current_a: f64, fuse_a: f64, flags: u8) -> CanFrame {
    let [v0, v1] = ((voltage_v * 1e3).round() as u16).to_le_bytes();
    let milliamperes = (current_a * 1e3).round().clamp(-8_388_608.0, 8_388_607.0) as i32;
    let [a0, a1, a2, _] = milliamperes.to_le_bytes();
    CanFrame::from_card(RAIL, &[rail, v0, v1, a0, a1, a2, (fuse_a * 2.0).round() as u8, flags])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(id: u32, data: &[u8]) -> Result<CardCommand, CardError> {
        CardCommand::parse(&CanFrame::new(id, data).unwrap())
    }

    #[test]
    fn obeys_only_whole_commands_for_the_card() {
        assert_eq!(set(0x00D0_FEAB, &[0xF4, 1, 6, 0xFF]), Ok(CardCommand::MotorSet(Pair::new(500, -250))));
        assert_eq!(set(0x00D0_FEAC, &[0; 4]), Err(CardError::Address(0x00D0_FEAC)));
        assert_eq!(set(0x00D1_FEAB, &[0; 4]), Err(CardError::Address(0x00D1_FEAB)));
        assert_eq!(set(0x00D0_FEAB, &[0; 3]), Err(CardError::Length { message: 13, len: 3 }));
        assert_eq!(set(0x00D0_FEAB, &[0xE9, 3, 0, 0]), Err(CardError::Throttle(1001)));
        assert_eq!(set(0x00C0_FEAB, &[0; 4]), Err(CardError::Message(12)));
    }

    #[test]
    fn a_frame_holds_eight_bytes_and_29_bits() {
        assert!(CanFrame::new(1 << 29, &[]).is_none());
        assert!(CanFrame::new(1, &[0; 9]).is_none());
        assert_eq!(CanFrame::new(1, &[7, 8]).unwrap().data(), [7, 8]);
    }

    #[test]
    fn values_beyond_the_field_stop_at_its_ends() {
        assert_eq!(motor_drive(0, 1e9, -1e9, f64::NAN).data(), [0, 0xFF, 0xFF, 0, 0x80, 0, 0]);
        assert_eq!(battery_status(0, -5.0, 700.0, -1.0, 130.0, 0).data(), [0, 0, 0xFF, 0xFF, 0, 0, 100, 0]);
    }

    /// The number that follows `name` in the meaning of a vector.
    fn number(meaning: &str, name: &str) -> f64 {
        let rest = meaning.split(&format!("\"\"{name}\"\": ")).nth(1).unwrap();
        rest.split([',', '}']).next().unwrap().parse().unwrap()
    }

    fn vector_frame(kind: &str, meaning: &str, sent: &CanFrame) -> Option<CanFrame> {
        let index = || number(meaning, "index") as u8;
        Some(match kind {
            "TQ_BAT_STATUS" => battery_status(
                index(),
                number(meaning, "temperature_c"),
                number(meaning, "voltage_v"),
                number(meaning, "current_a"),
                number(meaning, "soc_pct"),
                number(meaning, "error") as u8,
            ),
            "RAIL" => rail(
                index(),
                number(meaning, "voltage_v"),
                number(meaning, "current_a_signed24"),
                number(meaning, "fuse_a"),
                number(meaning, "flags") as u8,
            ),
            "TQ_MOTOR_DRIVE" => motor_drive(
                index(),
                number(meaning, "power_w"),
                number(meaning, "temperature_c"),
                number(meaning, "motor_rpm"),
            ),
            "TQ_MOTOR_SET(tx)" => {
                // The driver truncates towards zero; the fifth decimal is beyond the table's four.
                let per_mille = |side| (number(meaning, side) * 1000.0 + 1e-9 * number(meaning, side)) as i16;
                let set = Pair::new(per_mille("port"), per_mille("starboard"));
                assert_eq!(CardCommand::parse(sent), Ok(CardCommand::MotorSet(set)));
                CardCommand::MotorSet(set).frame()
            }
            "OUTPUT_SET(tx)" => CardCommand::parse(sent).unwrap().frame(),
            _ => return None,
        })
    }

    #[test]
    fn every_vector_of_the_bus_is_met() {
        let Some(path) = testkit::shared("data/onboard/torqeedo_can_vectors.csv") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let mut count = 0;
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.splitn(4, ',').collect();
            let bytes: Vec<u8> = (0..fields[1].len() / 2)
                .map(|i| u8::from_str_radix(&fields[1][2 * i..2 * i + 2], 16).unwrap())
                .collect();
            let sent = CanFrame::new(u32::from_str_radix(fields[0], 16).unwrap(), &bytes).unwrap();
            assert_eq!(vector_frame(fields[2], fields[3], &sent), Some(sent), "{line}");
            count += 1;
        }
        assert!(count >= 20);
    }
}
