//! Pure pursuit: steer for the end of the leg, wherever the track runs.
//!
//! χ_d = λ, the bearing to the end (DUNE's Control.Path.PurePursuit without its crab angle, which the yaw
//! loop steers).

use crate::path::LegPosition;

/// Desired course (rad) on a leg.
pub(crate) fn course_rad(leg: &LegPosition) -> f64 {
    leg.end_bearing_rad
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steers_for_the_end_from_anywhere() {
        for cross_m in [-30.0, 0.0, 30.0] {
            let leg = LegPosition {
                along_m: 5.0,
                cross_m,
                length_m: 100.0,
                bearing_rad: 0.3,
                end_bearing_rad: -1.1,
            };
            assert!((course_rad(&leg) + 1.1).abs() < 1e-12);
        }
    }
}
