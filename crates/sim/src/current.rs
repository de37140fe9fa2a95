//! A current that is steady but for a slow variation.
//!
//! Velocity of the water = constant + a first-order process per axis, as Fossen (2021), section 10.3 models
//! the current speed. The variation is the same all over the area.

use crate::process::GaussMarkov;
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use std::f64::consts::TAU;

/// A current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentConfig {
    /// Mean speed (m/s).
    pub speed_mps: f64,
    /// Where the current flows to (rad, clockwise from north).
    pub to_rad: f64,
    /// Standard deviation of the variation, on each axis (m/s).
    pub variation_mps: f64,
    /// Time constant of the variation (s).
    pub variation_s: f64,
}

impl Default for CurrentConfig {
    /// Still water.
    fn default() -> Self {
        Self { speed_mps: 0.0, to_rad: 0.0, variation_mps: 0.0, variation_s: 600.0 }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Current {
    mean_north_mps: f64,
    mean_east_mps: f64,
    north: GaussMarkov,
    east: GaussMarkov,
    rng: Rng,
}

impl Current {
    pub(crate) fn new(config: &CurrentConfig, seed: u64, dt_s: f64) -> Result<Self, OutOfRange> {
        let speed_mps = within("current speed (m/s)", config.speed_mps, 0.0, 5.0)?;
        let to_rad = within("current direction (rad)", config.to_rad, -TAU, TAU)?;
        let sigma = within("current variation (m/s)", config.variation_mps, 0.0, 1.0)?;
        let tau_s = within("current variation time (s)", config.variation_s, 1.0, 1e6)?;
        let mut rng = Rng::new(seed, Stream::Current);
        Ok(Self {
            mean_north_mps: speed_mps * to_rad.cos(),
            mean_east_mps: speed_mps * to_rad.sin(),
            north: GaussMarkov::new(sigma, tau_s, dt_s, &mut rng),
            east: GaussMarkov::new(sigma, tau_s, dt_s, &mut rng),
            rng,
        })
    }

    pub(crate) fn step(&mut self) {
        self.north.step(&mut self.rng);
        self.east.step(&mut self.rng);
    }

    /// To the north and to the east (m/s).
    pub(crate) fn velocity_mps(&self) -> (f64, f64) {
        (self.mean_north_mps + self.north.value(), self.mean_east_mps + self.east.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flows_to_where_it_is_said_to() {
        let config = CurrentConfig { speed_mps: 0.5, to_rad: TAU / 4.0, ..CurrentConfig::default() };
        let mut current = Current::new(&config, 1, 0.04).unwrap();
        current.step();
        let (north_mps, east_mps) = current.velocity_mps();
        assert!(north_mps.abs() < 1e-12 && (east_mps - 0.5).abs() < 1e-12);
    }

    #[test]
    fn varies_slowly_about_its_mean() {
        let config = CurrentConfig {
            speed_mps: 0.3,
            variation_mps: 0.1,
            variation_s: 60.0,
            ..CurrentConfig::default()
        };
        let mut current = Current::new(&config, 1, 1.0).unwrap();
        let mut sum = 0.0;
        for _ in 0..50_000 {
            let before = current.velocity_mps().0;
            current.step();
            let after = current.velocity_mps().0;
            assert!((after - before).abs() < 0.1);
            sum += after;
        }
        assert!((sum / 5e4 - 0.3).abs() < 0.02);
    }

    #[test]
    fn refuses_what_is_no_current() {
        let config = CurrentConfig { speed_mps: f64::NAN, ..CurrentConfig::default() };
        assert!(Current::new(&config, 1, 0.04).is_err());
        let config = CurrentConfig { variation_s: 0.0, ..CurrentConfig::default() };
        assert!(Current::new(&config, 1, 0.04).is_err());
    }
}
