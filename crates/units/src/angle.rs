//! Angles on a circle.

use std::f64::consts::{PI, TAU};

/// The same direction in (-π, π]. NaN and infinities give NaN.
pub fn wrap_pi(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// The same direction in [0, 2π). NaN and infinities give NaN.
pub fn wrap_two_pi(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    // A tiny negative angle rounds up to a whole turn.
    if wrapped >= TAU { 0.0 } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_to_the_half_open_intervals() {
        assert_eq!(wrap_pi(PI).to_bits(), PI.to_bits());
        assert_eq!(wrap_pi(-PI).to_bits(), PI.to_bits());
        assert!((wrap_pi(3.0 * PI / 2.0) + PI / 2.0).abs() < 1e-15);
        assert!((wrap_two_pi(-PI / 2.0) - 3.0 * PI / 2.0).abs() < 1e-15);
        assert!(wrap_two_pi(-1e-18).abs() < f64::EPSILON);
        assert!(wrap_pi(f64::NAN).is_nan());
        assert!(wrap_pi(f64::INFINITY).is_nan());
    }
}
