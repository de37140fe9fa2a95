//! Faults that motors and batteries report, in sentences; and implausible reports.

use super::outbox::Outbox;
use crate::Note;
use devices::torqeedo::{BATTERIES, MOTORS};
use devices::{BatteryReading, MotorReading, Part, RailReading, Reading, Side, TroubleReading};
use std::time::Duration;
use units::{MonoTime, Now};

/// A lasting fault is reported again after this time, for a part of the program that missed it.
const AGAIN: Duration = Duration::from_secs(10);

/// The last report of each part.
#[derive(Debug, Clone, Default)]
pub(super) struct Troubles {
    batteries: [Told; BATTERIES as usize],
    motors: [Told; MOTORS as usize],
}

/// A part's error, and when it was reported.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    error: u16,
    at: MonoTime,
}

impl Told {
    /// Whether the error is another than before; `None` when it need not be reported now.
    fn take(&mut self, now: MonoTime, error: u16) -> Option<bool> {
        let changed = self.error != error;
        if !changed && (error == 0 || now.since(self.at) < AGAIN) {
            return None;
        }
        *self = Self { error, at: now };
        Some(changed)
    }
}

impl Troubles {
    /// A battery reports an error, or none.
    pub(super) fn battery(&mut self, now: Now, number: u8, error: u8, out: &mut Outbox) {
        let Some(told) = self.batteries.get_mut(usize::from(number)) else { return };
        let text = match error {
            0 => String::new(),
            error => format!(
                "reports error {error}: come back on the other batteries, switch this one off and on, and look the number up in its \
                 manual"
            ),
        };
        tell(
            told.take(now.mono, error.into()),
            now,
            Part::Battery(number),
            &format!("battery {number}"),
            text,
            out,
        );
    }

    /// A motor reports error bits, or none.
    pub(super) fn motor(
        &mut self,
        now: Now,
        motor: u8,
        side: Side,
        errors: u16,
        status: u8,
        out: &mut Outbox,
    ) {
        let Some(told) = self.motors.get_mut(usize::from(motor)) else { return };
        let text = match errors {
            0 => String::new(),
            bits => format!(
                "reports the error bits {bits:04X}, status {status:02X}: look for weed or a line in its propeller, let it cool, and \
                 switch it off and on by its power channel; its manual explains the bits"
            ),
        };
        tell(told.take(now.mono, errors), now, Part::Motor(side), motor_name(side), text, out);
    }
}

/// A motor as people call it.
pub(super) const fn motor_name(side: Side) -> &'static str {
    match side {
        Side::Port => "the port motor",
        Side::Starboard => "the starboard motor",
    }
}

fn tell(due: Option<bool>, now: Now, part: Part, name: &str, text: String, out: &mut Outbox) {
    let Some(changed) = due else { return };
    if changed {
        let what = if text.is_empty() { "reports no error any more" } else { &text };
        out.note(Note { warning: !text.is_empty(), text: format!("{name} {what}") });
    }
    out.reading(now, Reading::Trouble(TroubleReading { part, text }));
}

/// Whether a motor can be like this. Those of an Otter turn at 1200 rpm at most.
pub(super) fn motor_is_plausible(reading: &MotorReading) -> bool {
    reading.propeller_rpm.abs() <= 3000.0
        && (0.0..=20_000.0).contains(&reading.power_w)
        && (-60.0..=150.0).contains(&reading.temperature_c)
}

/// Whether a battery can be like this. Those of an Otter have 30 V and deliver some 100 A at most.
pub(super) fn battery_is_plausible(reading: &BatteryReading) -> bool {
    (0.0..=80.0).contains(&reading.voltage_v)
        && (0.0..=1000.0).contains(&reading.current_a)
        && (0.0..=100.0).contains(&reading.charge_percent)
        && (-60.0..=120.0).contains(&reading.temperature_c)
}

/// Whether a power rail can be like this.
pub(super) fn rail_is_plausible(reading: &RailReading) -> bool {
    (0.0..=80.0).contains(&reading.voltage_v) && reading.current_a.abs() <= 1000.0
}
