//! The hull: what the vessel's sensors and thrusters are to the program that steers it.
//!
//! Whoever owns a [`Hull`] owns the clock: it says how far time has come and gets what has been read by then. The
//! simulated hull follows any clock, that of the computer or one that jumps from event to event; the other hull is
//! `hardware`, the devices aboard.

mod simulated;

pub(crate) use simulated::Simulated;

use control::MotorPair;
use onboard::{Brain, Input};
use units::MonoTime;

/// Sensors and thrusters.
///
/// Thrusters stop by themselves when no command comes for [`COMMAND_LIFE`](onboard::COMMAND_LIFE).
pub(crate) trait Hull {
    /// The next reading, or state of a device, that has become due up to `until`, oldest first; `None` when there is no
    /// more. Times that it is given never go back.
    fn poll(&mut self, until: MonoTime) -> Option<Input>;

    /// When to poll again at the latest; `None` for a hull that tells by itself.
    fn poll_timeout(&self) -> Option<MonoTime>;

    /// Commands both thrusters, at the time polled last.
    fn command(&mut self, motors: MotorPair);

    /// Switches a power channel of the configuration; a simulated hull has none.
    fn switch(&mut self, _channel: &str, _on: bool) {}

    /// Shows the brain to what watches its life and tells people nearby how it is; called when the loop has come round.
    fn attend(&mut self, _brain: &Brain) {}

    /// Ends, the thrusters having been commanded to stop: answers whether the devices were told so in time. After a fault
    /// of the program (`clean` is false) what would start it again is left to do so.
    fn end(&mut self, clean: bool) -> bool;
}
