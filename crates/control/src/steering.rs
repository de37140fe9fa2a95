//! The output of a guidance law.

/// Where to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    /// Desired course over ground (rad).
    pub course_rad: f64,
    /// How fast that course turns, positive to starboard (rad/s); 0 on straight legs.
    pub turn_rate_rad_s: f64,
}
