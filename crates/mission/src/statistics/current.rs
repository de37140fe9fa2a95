//! The effect of a steady current on speed over ground, and a straight leg's time and energy in it.

use super::{Cost, VehicleModel};

/// A steady current.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Current {
    /// Where it flows to (rad), clockwise from true north.
    pub set_rad: f64,
    /// How fast (m/s).
    pub drift_mps: f64,
}

impl Current {
    /// Speed over ground (m/s) of a vessel that steers up against the current to make good a course; `None` where the
    /// current is too strong for that.
    pub fn over_ground_mps(&self, course_rad: f64, through_water_mps: f64) -> Option<f64> {
        let off_rad = self.set_rad - course_rad;
        let (across_mps, along_mps) = (self.drift_mps * off_rad.sin(), self.drift_mps * off_rad.cos());
        let left = through_water_mps.powi(2) - across_mps.powi(2);
        let made_good_mps = along_mps + left.max(0.0).sqrt();
        (left >= 0.0 && made_good_mps > 1e-3).then_some(made_good_mps)
    }
}

impl Cost {
    /// Of a straight leg at a speed through the water; without time and energy where the current is too strong, without energy
    /// at speeds that the model does not know.
    pub fn of_leg(
        length_m: f64,
        course_rad: f64,
        through_water_mps: f64,
        current: Current,
        model: &VehicleModel,
    ) -> Self {
        let over_ground_mps = current.over_ground_mps(course_rad, through_water_mps);
        let duration_s = over_ground_mps.map(|mps| length_m / mps);
        let known = through_water_mps <= model.fastest_mps();
        let energy_j =
            duration_s.filter(|_| known).map(|duration_s| duration_s * model.power_w(through_water_mps));
        Self { length_m: Some(length_m), duration_s, energy_j }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_current_helps_hinders_sets_aside_and_stops() {
        let east = Current { set_rad: FRAC_PI_2, drift_mps: 0.6 };
        let over_ground = |course_rad: f64, mps: f64| east.over_ground_mps(course_rad, mps);
        assert!((over_ground(FRAC_PI_2, 1.0).unwrap() - 1.6).abs() < 1e-12);
        assert!((over_ground(-FRAC_PI_2, 1.0).unwrap() - 0.4).abs() < 1e-12);
        // 3, 4, 5.
        assert!((over_ground(0.0, 1.0).unwrap() - 0.8).abs() < 1e-12);
        assert_eq!((over_ground(0.0, 0.5), over_ground(-FRAC_PI_2, 0.6)), (None, None));
        let model = VehicleModel::default();
        let cost = Cost::of_leg(800.0, 0.0, 1.0, east, &model);
        assert!((cost.duration_s.unwrap() - 1_000.0).abs() < 1e-9);
        assert!((cost.energy_j.unwrap() - 1_000.0 * model.power_w(1.0)).abs() < 1e-6);
        assert_eq!(Cost::of_leg(800.0, 0.0, 0.5, east, &model).energy_j, None);
        let racing = Cost::of_leg(800.0, 0.0, 10.0, east, &model);
        assert!(racing.duration_s.is_some() && racing.energy_j.is_none(), "{racing:?}");
    }
}
