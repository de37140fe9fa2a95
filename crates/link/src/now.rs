//! The moment at which something is handled.

use units::{MonoTime, UtcTime};

/// A steady time for deadlines and the computer's idea of UTC for records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Now {
    /// Never goes back.
    pub mono: MonoTime,
    /// May be set while the program runs.
    pub utc: UtcTime,
}
