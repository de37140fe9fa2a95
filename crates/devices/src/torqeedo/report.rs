//! The card's reports as frames, as the simulated card sends them.

use super::{ALL, CARD, GEAR, MessageId, identifier};
use crate::can::{CanFrame, MOST_DATA};
use crate::pair::Side;
use crate::reading::{BatteryReading, MotorReading, RailReading, Reading};

/// One report of the card.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CardReport {
    /// A motor's speed, power and temperature.
    Motor(Side, MotorReading),
    /// A battery's state.
    Battery(BatteryReading),
    /// A power rail.
    Rail(RailReading),
    /// Which channels of a rail are on: bit n is set while channel n is.
    Outputs {
        /// The rail.
        rail: u8,
        /// The channels.
        channels: u32,
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
            Self::Outputs { rail, channels } => {
                let [c0, c1, c2, c3] = channels.to_le_bytes();
                from_card(MessageId::OUTPUTS, [rail, c0, c1, c2, c3])
            }
            Self::Rail(r) => rail(r.number, r.voltage_v, r.current_a, r.fuse_a, r.flags),
        }
    }

    /// The reading for the brain; none for channels, whose names only the configuration knows.
    pub fn reading(&self) -> Option<Reading> {
        match *self {
            Self::Motor(side, reading) => Some(Reading::Motor(side, reading)),
            Self::Battery(reading) => Some(Reading::Battery(reading)),
            Self::Rail(reading) => Some(Reading::Rail(reading)),
            Self::Outputs { .. } => None,
        }
    }
}

/// A frame that the card sends to all.
fn from_card<const N: usize>(message: MessageId, data: [u8; N]) -> CanFrame {
    const { assert!(N <= MOST_DATA) };
    let frame = CanFrame::new(identifier(message, CARD, ALL), &data);
    frame.expect("invariant: nine bits before twenty are 29, and no report has more than eight bytes")
}

/// TQ_MOTOR_DRIVE: power (W), temperature of the board (°C) and speed of the motor (rpm, before the gear).
pub(super) fn motor_drive(motor: u8, power_w: f64, temperature_c: f64, motor_rpm: f64) -> CanFrame {
    // `as` from a float holds the value within the integer's range.
    let [w0, w1] = (power_w.round() as u16).to_le_bytes();
    let [t0, t1] = ((temperature_c * 10.0).round() as i16).to_le_bytes();
    let [n0, n1] = (motor_rpm.round() as i16).to_le_bytes();
    from_card(MessageId::MOTOR_DRIVE, [motor, w0, w1, t0, t1, n0, n1])
}

/// TQ_BAT_STATUS: temperature (°C), voltage (V), current (A), charge (%) and error number of one battery.
pub(super) fn battery_status(
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
    from_card(MessageId::BATTERY_STATUS, [battery, temperature, v0, v1, a0, a1, charge, error])
}

/// RAIL: voltage (V), current (A, may be negative), fuse (A) and flags of one power rail.
pub(super) fn rail(rail: u8, voltage_v: f64, current_a: f64, fuse_a: f64, flags: u8) -> CanFrame {
    let [v0, v1] = ((voltage_v * 1e3).round() as u16).to_le_bytes();
    let milliamperes = (current_a * 1e3).round().clamp(-8_388_608.0, 8_388_607.0) as i32;
    let [a0, a1, a2, _] = milliamperes.to_le_bytes();
    from_card(MessageId::RAIL, [rail, v0, v1, a0, a1, a2, (fuse_a * 2.0).round() as u8, flags])
}
