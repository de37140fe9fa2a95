//! The speeds that a plan must keep below.

use units::Speed;

/// The largest speeds a plan may ask for, by unit. The least is above 0 in each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedLimits {
    /// Metres per second.
    pub max_mps: f64,
    /// Revolutions per minute.
    pub max_rpm: f64,
    /// Percent.
    pub max_percent: f64,
}

impl Default for SpeedLimits {
    /// The top of the Otter's speed table: 6 knots, 980 rpm.
    fn default() -> Self {
        Self { max_mps: 3.09, max_rpm: 980.0, max_percent: 100.0 }
    }
}

impl SpeedLimits {
    /// `speed`, or the limit where it is faster.
    #[must_use]
    pub fn clamp(&self, speed: Speed) -> Speed {
        match speed {
            Speed::MetresPerSecond(mps) => Speed::MetresPerSecond(mps.min(self.max_mps)),
            Speed::Rpm(rpm) => Speed::Rpm(rpm.min(self.max_rpm)),
            Speed::Percent(percent) => Speed::Percent(percent.min(self.max_percent)),
        }
    }

    /// Whether `speed` is a number above 0 within the limits.
    pub fn allows(&self, speed: Speed) -> bool {
        let limit = match speed {
            Speed::MetresPerSecond(_) => self.max_mps,
            Speed::Rpm(_) => self.max_rpm,
            Speed::Percent(_) => self.max_percent,
        };
        // Single precision on the wire makes 3.09 a little more.
        speed.value() > 0.0 && speed.value() <= limit * (1.0 + 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn allows_numbers_above_zero_up_to_the_limit() {
        let limits = SpeedLimits::default();
        let cases = [
            (Speed::MetresPerSecond(1.5), true),
            (Speed::MetresPerSecond(f64::from(3.09_f32)), true),
            (Speed::MetresPerSecond(3.2), false),
            (Speed::MetresPerSecond(0.0), false),
            (Speed::MetresPerSecond(-3.0), false),
            (Speed::MetresPerSecond(f64::NAN), false),
            (Speed::Rpm(900.0), true),
            (Speed::Rpm(1600.0), false),
            (Speed::Percent(100.0), true),
            (Speed::Percent(f64::INFINITY), false),
        ];
        for (speed, allowed) in cases {
            assert_eq!(limits.allows(speed), allowed, "{speed}");
        }
    }
}
