//! The two propeller motors: from a throttle or a shaft speed asked for to speed, power and temperature.
//!
//! Throttle: the card takes -1 to 1. Either shaft speed is proportional to it up to the model's limits, or it
//! follows the table measured on the boats (dune-otter-public, `basic.ini`, speed conversion RPM), which saturates at 980 rpm.
//!
//! Power: a propeller's torque grows with n² and its power with n³ (affinity law). The electrical power at
//! the shaft limit ahead is that of the Torqeedo Ultralight 403, 400 W (power budget of the NTNU Otters);
//! astern the same law holds. Standby power is an assumption.
//!
//! Temperature: one thermal mass, τ dT/dt = T_water + R P - T. R and τ are assumptions: 30 K above the water
//! at full power after some ten minutes.

use crate::otter::{shaft_max_radps, shaft_min_radps};
use devices::MotorReading;

const RATED_W: f64 = 400.0;
const STANDBY_W: f64 = 1.0;
const HEATING_KPW: f64 = 30.0 / RATED_W;
const HEATING_S: f64 = 300.0;

const RPM_PER_RADPS: f64 = 30.0 / std::f64::consts::PI;

/// Shaft speed in revolutions per minute from radians per second.
pub fn rpm(shaft_radps: f64) -> f64 {
    shaft_radps * RPM_PER_RADPS
}

/// Shaft speed in radians per second from revolutions per minute.
pub fn radps(shaft_rpm: f64) -> f64 {
    shaft_rpm / RPM_PER_RADPS
}

/// How a throttle becomes a shaft speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ThrottleMap {
    /// In proportion to the limits of the model, ahead and astern.
    #[default]
    Proportional,
    /// By the table measured on the boats; astern mirrored.
    Measured,
}

impl ThrottleMap {
    /// Shaft speed (rad/s) for a throttle, which is held within -1 to 1; a throttle that is not a number stops.
    pub fn shaft_radps(self, throttle: f64) -> f64 {
        if throttle.is_nan() {
            return 0.0;
        }
        let throttle = throttle.clamp(-1.0, 1.0);
        match self {
            Self::Proportional if throttle >= 0.0 => throttle * shaft_max_radps(),
            Self::Proportional => -throttle * shaft_min_radps(),
            Self::Measured => radps(measured_rpm(throttle.abs())).copysign(throttle),
        }
    }
}

fn measured_rpm(throttle: f64) -> f64 {
    const TABLE: [f64; 11] = [0.0, 120.0, 240.0, 360.0, 480.0, 610.0, 726.0, 845.0, 960.0, 980.0, 980.0];
    let place = throttle * 10.0;
    // `throttle` is within 0 to 1, so the index is within 0 to 9.
    let below = (place as usize).min(TABLE.len() - 2);
    TABLE[below] + (TABLE[below + 1] - TABLE[below]) * (place - below as f64)
}

/// The command to a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// A share of full thrust speed, -1 to 1.
    Throttle(f64),
    /// A shaft speed in revolutions per minute.
    Rpm(f64),
}

impl Drive {
    /// The shaft speed asked for (rad/s); what is not a number asks for standstill.
    pub fn shaft_radps(self, map: ThrottleMap) -> f64 {
        match self {
            Self::Throttle(throttle) => map.shaft_radps(throttle),
            Self::Rpm(rpm) if rpm.is_nan() => 0.0,
            Self::Rpm(rpm) => radps(rpm).clamp(shaft_min_radps(), shaft_max_radps()),
        }
    }
}

/// One motor's power and temperature.
#[derive(Debug, Clone)]
pub struct Motor {
    water_c: f64,
    reading: MotorReading,
}

impl Motor {
    /// A motor at rest in water of the given temperature (°C).
    pub fn new(water_c: f64) -> Self {
        let reading = MotorReading { propeller_rpm: 0.0, power_w: 0.0, temperature_c: water_c };
        Self { water_c, reading }
    }

    /// Runs for `dt_s` at a shaft speed (rad/s); `powered` is whether the motor's supply is on.
    pub fn step(&mut self, shaft_radps: f64, powered: bool, dt_s: f64) {
        let share = shaft_radps.abs() / shaft_max_radps();
        let power_w = if powered { STANDBY_W + (RATED_W - STANDBY_W) * share.powi(3) } else { 0.0 };
        let goal_c = self.water_c + HEATING_KPW * power_w;
        let temperature_c =
            self.reading.temperature_c + (goal_c - self.reading.temperature_c) * (dt_s / HEATING_S).min(1.0);
        self.reading = MotorReading { propeller_rpm: rpm(shaft_radps), power_w, temperature_c };
    }

    /// The motor's report after the last step.
    pub fn reading(&self) -> MotorReading {
        self.reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn throttle_reaches_the_limits_of_the_model() {
        // (throttle, rad/s) of the model's limits, 103.93 and -101.74 rad/s.
        for (throttle, expected) in [(0.0, 0.0), (1.0, 103.93), (-1.0, -101.74), (0.5, 51.965), (7.0, 103.93)]
        {
            let shaft = ThrottleMap::Proportional.shaft_radps(throttle);
            assert!((shaft - expected).abs() < 0.01, "{throttle}: {shaft}");
        }
        assert!(ThrottleMap::Proportional.shaft_radps(f64::NAN).abs() < f64::MIN_POSITIVE);
        assert!(Drive::Rpm(f64::NAN).shaft_radps(ThrottleMap::Measured).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn measured_throttle_follows_the_boats_table() {
        for (throttle, expected) in [(0.1, 120.0), (0.45, 545.0), (0.8, 960.0), (1.0, 980.0), (-0.6, -726.0)]
        {
            let found = rpm(ThrottleMap::Measured.shaft_radps(throttle));
            assert!((found - expected).abs() < 1e-9, "{throttle}: {found}");
        }
    }

    #[test]
    fn power_grows_with_the_cube_of_the_speed() {
        let power = |shaft: f64| {
            let mut motor = Motor::new(8.0);
            motor.step(shaft, true, 0.04);
            motor.reading().power_w
        };
        assert!((power(shaft_max_radps()) - 400.0).abs() < 1e-9);
        assert!(((power(40.0) - 1.0) / (power(20.0) - 1.0) - 8.0).abs() < 1e-9);
        assert!((power(-40.0) - power(40.0)).abs() < 1e-12);
    }

    #[test]
    fn warms_up_to_thirty_degrees_above_the_water() {
        let mut motor = Motor::new(8.0);
        for _ in 0..3_600 {
            motor.step(shaft_max_radps(), true, 1.0);
        }
        assert!((motor.reading().temperature_c - 38.0).abs() < 0.01);
    }
}
