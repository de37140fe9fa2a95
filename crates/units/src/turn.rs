//! The sense of a turn.

/// Sense of a circle, seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Centre to starboard.
    Clockwise,
    /// Centre to port.
    CounterClockwise,
}

impl Turn {
    /// 1 clockwise, -1 counter-clockwise.
    pub fn sign(self) -> f64 {
        match self {
            Self::Clockwise => 1.0,
            Self::CounterClockwise => -1.0,
        }
    }
}
