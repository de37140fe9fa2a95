//! The hull: what the vessel's sensors and thrusters are to the program that steers it.
//!
//! Whoever owns a [`Hull`] owns the clock: it says how far time has come and gets what has been read by then. The
//! simulated hull follows any clock, that of the computer or one that jumps from event to event.

mod simulated;

pub(crate) use simulated::Simulated;

use control::MotorPair;
use devices::Reading;
use units::MonoTime;

/// Sensors and thrusters.
///
/// Thrusters stop by themselves when no command comes for [`COMMAND_LIFE`](onboard::COMMAND_LIFE).
pub(crate) trait Hull {
    /// The next reading that has become due up to `until`, oldest first; `None` when there is no more. Times that
    /// it is given never go back.
    fn poll(&mut self, until: MonoTime) -> Option<Reading>;

    /// When to poll again at the latest; `None` for a hull that tells by itself.
    fn poll_timeout(&self) -> Option<MonoTime>;

    /// Commands both thrusters, at the time polled last.
    fn command(&mut self, motors: MotorPair);
}
