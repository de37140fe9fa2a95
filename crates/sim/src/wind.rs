//! Wind with gusts, and its force on the Otter above the water.
//!
//! Speed = mean + a first-order gust along the wind, direction = mean + a first-order veer. The gust's
//! standard deviation is a share of the mean (turbulence intensity, 0.1 to 0.2 over open water; the
//! calmest class of IEC 61400-1 has 0.12).
//!
//! Force: Fossen (2021), section 10.1, for a symmetrical vessel,
//! X = -½ρV² c_x cos γ A_F, Y = ½ρV² c_y sin γ A_L, N = ½ρV² c_n sin 2γ A_L L, with V and γ of the air
//! relative to the vessel and the coefficients from the middle of the ranges given there (c_x 0.50 to 0.90,
//! c_y 0.70 to 0.95, c_n 0.05 to 0.20). The areas are estimates from the Otter's outline (2.0 x 1.08 m,
//! 1.065 m high with 0.2 m of it in the water): pontoons and deck box closed, mast and rails as a quarter.

use crate::otter::{BodyForce, OtterState};
use crate::process::GaussMarkov;
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use std::f64::consts::TAU;
use units::wrap_two_pi;

const AIR_KGPM3: f64 = 1.225;
const FRONT_M2: f64 = 0.35;
const SIDE_M2: f64 = 0.70;
const LENGTH_M: f64 = 2.0;
const C_X: f64 = 0.7;
const C_Y: f64 = 0.8;
const C_N: f64 = 0.1;

/// A wind at the height of the vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindConfig {
    /// Mean speed (m/s).
    pub speed_mps: f64,
    /// Where the wind comes from (rad, clockwise from north).
    pub from_rad: f64,
    /// Standard deviation of the gusts as a share of the mean speed.
    pub gust_share: f64,
    /// Time constant of the gusts (s).
    pub gust_s: f64,
    /// Standard deviation of the direction (rad).
    pub veer_rad: f64,
    /// Time constant of the direction (s).
    pub veer_s: f64,
}

impl Default for WindConfig {
    /// Calm; gusts of 15 % and 10 s and a veer of 6° and 60 s once a speed is set.
    fn default() -> Self {
        Self { speed_mps: 0.0, from_rad: 0.0, gust_share: 0.15, gust_s: 10.0, veer_rad: 0.1, veer_s: 60.0 }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Wind {
    config: WindConfig,
    gust: GaussMarkov,
    veer: GaussMarkov,
    rng: Rng,
    blows_north_mps: f64,
    blows_east_mps: f64,
}

impl Wind {
    pub(crate) fn new(config: &WindConfig, seed: u64, dt_s: f64) -> Result<Self, OutOfRange> {
        let speed_mps = within("wind speed (m/s)", config.speed_mps, 0.0, 40.0)?;
        within("wind direction (rad)", config.from_rad, -TAU, TAU)?;
        let share = within("gusts as a share of the wind", config.gust_share, 0.0, 1.0)?;
        let gust_s = within("gust time (s)", config.gust_s, 0.1, 1e5)?;
        let veer_rad = within("wind veer (rad)", config.veer_rad, 0.0, 1.0)?;
        let veer_s = within("wind veer time (s)", config.veer_s, 0.1, 1e5)?;
        let mut rng = Rng::new(seed, Stream::Wind);
        let veer_rad = if speed_mps > 0.0 { veer_rad } else { 0.0 };
        let mut wind = Self {
            config: *config,
            gust: GaussMarkov::new(share * speed_mps, gust_s, dt_s, &mut rng),
            veer: GaussMarkov::new(veer_rad, veer_s, dt_s, &mut rng),
            rng,
            blows_north_mps: 0.0,
            blows_east_mps: 0.0,
        };
        wind.settle();
        Ok(wind)
    }

    pub(crate) fn step(&mut self) {
        if self.config.speed_mps > 0.0 {
            self.gust.step(&mut self.rng);
            self.veer.step(&mut self.rng);
            self.settle();
        }
    }

    /// Speed (m/s) and the direction the wind comes from in [0, 2π) (rad).
    pub(crate) fn now(&self) -> (f64, f64) {
        let from_rad = wrap_two_pi(self.config.from_rad + self.veer.value());
        ((self.config.speed_mps + self.gust.value()).max(0.0), from_rad)
    }

    fn settle(&mut self) {
        let (speed_mps, from_rad) = self.now();
        self.blows_north_mps = -speed_mps * from_rad.cos();
        self.blows_east_mps = -speed_mps * from_rad.sin();
    }

    /// Force on a vessel in this state; nothing in a calm, where the model's damping stands for the air too.
    pub(crate) fn force(&self, state: &OtterState) -> BodyForce {
        if self.config.speed_mps <= 0.0 {
            return BodyForce::default();
        }
        let (sin, cos) = state.psi_rad.sin_cos();
        // Velocity of the air relative to the vessel, in the body frame.
        let ahead_mps = self.blows_north_mps * cos + self.blows_east_mps * sin - state.u_mps;
        let aside_mps = self.blows_east_mps * cos - self.blows_north_mps * sin - state.v_mps;
        let pressure = 0.5 * AIR_KGPM3;
        let speed_mps = ahead_mps.hypot(aside_mps);
        BodyForce {
            // V² cos γ is V times the component; the source's γ is measured against the wind, hence the signs.
            surge_n: pressure * C_X * FRONT_M2 * speed_mps * ahead_mps,
            sway_n: pressure * C_Y * SIDE_M2 * speed_mps * aside_mps,
            yaw_nm: -pressure * C_N * SIDE_M2 * LENGTH_M * 2.0 * ahead_mps * aside_mps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(speed_mps: f64, from_deg: f64) -> Wind {
        let config = WindConfig {
            speed_mps,
            from_rad: from_deg.to_radians(),
            gust_share: 0.0,
            veer_rad: 0.0,
            ..WindConfig::default()
        };
        Wind::new(&config, 1, 0.04).unwrap()
    }

    #[test]
    fn pushes_away_from_where_it_comes() {
        // (from, surge sign, sway sign) on a vessel that heads north at rest.
        for (from_deg, surge, sway) in
            [(0.0, -1.0, 0.0), (180.0, 1.0, 0.0), (90.0, 0.0, -1.0), (270.0, 0.0, 1.0)]
        {
            let force = steady(10.0, from_deg).force(&OtterState::default());
            assert!((force.surge_n.signum() - surge).abs() < 0.5 || surge == 0.0, "{from_deg} {force:?}");
            assert!((force.sway_n.signum() - sway).abs() < 0.5 || sway == 0.0, "{from_deg} {force:?}");
        }
    }

    #[test]
    fn ten_metres_a_second_ahead_push_with_fifteen_newtons() {
        // ½ 1.225 · 100 · 0.7 · 0.35 = 15.0 N.
        let force = steady(10.0, 0.0).force(&OtterState::default());
        assert!((force.surge_n + 15.006).abs() < 0.01, "{force:?}");
        assert!(force.sway_n.abs() < 1e-9 && force.yaw_nm.abs() < 1e-9);
    }

    #[test]
    fn a_wind_on_the_bow_quarter_turns_the_vessel_beam_to_it() {
        // Symmetrical form: N = ½ρV² c_n sin 2γ A L with γ counted from the bow; from 45° to starboard it
        // turns the bow away, to port, which is positive γ: the stable heading is beam to the wind.
        let force = steady(10.0, 45.0).force(&OtterState::default());
        assert!(force.yaw_nm < 0.0, "{force:?}");
        let force = steady(10.0, 135.0).force(&OtterState::default());
        assert!(force.yaw_nm > 0.0, "{force:?}");
    }

    #[test]
    fn gusts_have_their_share() {
        let config = WindConfig { speed_mps: 8.0, gust_share: 0.2, ..WindConfig::default() };
        let mut wind = Wind::new(&config, 5, 1.0).unwrap();
        let speeds: Vec<f64> = (0..100_000)
            .map(|_| {
                wind.step();
                wind.now().0
            })
            .collect();
        let mean = speeds.iter().sum::<f64>() / 1e5;
        let deviation = (speeds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / 1e5).sqrt();
        assert!((mean - 8.0).abs() < 0.1 && (deviation - 1.6).abs() < 0.1, "{mean} {deviation}");
    }
}
