//! A speed as people give it.

use std::fmt;

/// A speed in one of the units in which plans, operators and controllers give it; the controller's table converts them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// Metres per second.
    MetresPerSecond(f64),
    /// Revolutions per minute of both motors, negative astern.
    Rpm(f64),
    /// Percent of full actuation, negative astern.
    Percent(f64),
}

impl Speed {
    /// The bare number in the unit of its variant.
    pub fn value(self) -> f64 {
        let (Self::MetresPerSecond(value) | Self::Rpm(value) | Self::Percent(value)) = self;
        value
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MetresPerSecond(mps) => write!(f, "{mps} m/s"),
            Self::Rpm(rpm) => write!(f, "{rpm} rpm"),
            Self::Percent(percent) => write!(f, "{percent} %"),
        }
    }
}
