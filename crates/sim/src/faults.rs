//! Faults that a test or an operator's exercise can switch on and off.

use devices::Pair;
use units::LocalPoint;

/// The present faults; by default none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "faults are independent of each other")]
pub struct Faults {
    /// The compass sends nothing at all.
    pub gnss_silent: bool,
    /// The compass sends sentences without a fix.
    pub gnss_no_fix: bool,
    /// The positions sent are off by this much (m).
    pub position_jump: Option<LocalPoint>,
    /// The heading sent is not a number.
    pub heading_nan: bool,
    /// A motor reports nothing any more; it still obeys.
    pub motor_feedback_lost: Pair<bool>,
    /// The card sends nothing at all; it still obeys.
    pub card_silent: bool,
    /// The card receives nothing any more.
    pub card_deaf: bool,
    /// The card switches no output any more.
    pub channels_refused: bool,
    /// The hydrophone sends nothing at all.
    pub hydrophone_silent: bool,
}
