//! Signs of life, for the watchdog of the computer's board and for the signal light.

use imc::messages::PowerOperationOp;
use mission::Mode;
use units::UtcTime;

/// How the brain is at this moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Vitals {
    /// How often it has looked where the vessel is. A brain that steers moves on, several times a second; one that hangs,
    /// or whose loop does, stands still.
    pub steps: u64,
    /// The vessel's mode.
    pub mode: Mode,
    /// The batteries are below their warning level.
    pub fuel_low: bool,
    /// The computer's power is being turned off.
    pub powering_off: bool,
    /// The last time from the GNSS receiver: the computer's clock when it came, and the satellites' minus that (µs), which
    /// is late by the time that the message took.
    pub satellite_time: Option<(UtcTime, i64)>,
}

/// Whether the power goes off after this report; `before` is whether it did.
pub(crate) fn powers_off(said: PowerOperationOp, before: bool) -> bool {
    match said {
        PowerOperationOp::PwrDownIp => true,
        PowerOperationOp::PwrDownAborted | PowerOperationOp::PwrUp | PowerOperationOp::PwrUpIp => false,
        // A requested or planned activity has not begun yet.
        _ => before,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_in_progress_turns_the_power_off() {
        assert!(!powers_off(PowerOperationOp::PwrDown, false));
        assert!(powers_off(PowerOperationOp::PwrDownIp, false));
        assert!(powers_off(PowerOperationOp::SchedPwrDown, true));
        assert!(!powers_off(PowerOperationOp::PwrDownAborted, true));
    }
}
