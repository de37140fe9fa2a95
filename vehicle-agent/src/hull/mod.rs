//! The hull: the interface between the control program and the vessel's sensors and thrusters.
//!
//! The owner of a [`Hull`] has the clock: it passes the time and gets the readings up to then. The simulated hull follows
//! any clock, the computer's or a virtual one that jumps from event to event; the other hull is `hardware`, the devices
//! aboard.

mod simulated;

pub(crate) use simulated::Simulated;

use control::MotorPair;
use onboard::{Brain, Input};
use units::MonoTime;

/// Sensors and thrusters.
///
/// Thrusters stop automatically when no command comes for [`COMMAND_LIFE`](onboard::COMMAND_LIFE).
pub(crate) trait Hull {
    /// The next reading, or state of a device, up to `until`, oldest first; `None` when there are no more. `until` never
    /// goes back.
    fn poll(&mut self, until: MonoTime) -> Option<Input>;

    /// When to poll again at the latest; `None` for a hull that wakes the loop itself.
    fn poll_timeout(&self) -> Option<MonoTime>;

    /// Commands both thrusters, at the time of the last poll.
    fn command(&mut self, motors: MotorPair);

    /// Switches a power channel of the configuration; a simulated hull has none.
    fn switch(&mut self, _channel: &str, _on: bool) {}

    /// Passes the brain's state to the hardware watchdog and the signal light; called in each cycle of the loop.
    fn attend(&mut self, _brain: &Brain) {}

    /// Ends, after the thrusters were commanded to stop: returns whether the devices got that in time. After a panic
    /// (`clean` is false) the hardware watchdog is left on to restart the computer.
    fn end(&mut self, clean: bool) -> bool;
}
