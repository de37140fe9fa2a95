//! Waves as bounded, oscillating forces and a heading disturbance.
//!
//! A simple model for a hull that is short against the waves: five regular deep-water components around the
//! peak period (dispersion ω² = g k, D. E. Newman, "Marine Hydrodynamics", section 6.3), each with a phase
//! and a slightly different direction from the seed, their heights sharing out H_s by Σ a²/2 = H_s²/16. The
//! water's acceleration at the vessel, a ω² sin(ω t - k·x + φ) along the direction of travel, acts on the
//! virtual mass (Froude-Krylov and added mass in the long-wave limit, Newman section 6.17); its change along
//! the hull gives the yaw moment m k a_w sin χ cos χ L²/12. Drift forces, roll and pitch are left out. The
//! vessel's own movement gives the frequency of encounter.

use crate::otter::{BodyForce, Otter, OtterState};
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use std::f64::consts::TAU;

const GRAVITY_MPS2: f64 = 9.81;
const LENGTH_M: f64 = 2.0;
/// Frequency over that of the peak, and share of the energy, of each component.
const SPECTRUM: [(f64, f64); 5] = [(0.85, 0.12), (0.95, 0.28), (1.05, 0.28), (1.2, 0.2), (1.45, 0.12)];

/// A sea.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveConfig {
    /// Significant wave height (m).
    pub significant_height_m: f64,
    /// Period of the spectrum's peak (s).
    pub peak_period_s: f64,
    /// Where the waves come from (rad, clockwise from north).
    pub from_rad: f64,
    /// Half the spread of the components' directions (rad).
    pub spread_rad: f64,
}

impl Default for WaveConfig {
    /// A flat sea; a peak period of 3 s and a spread of 20° once a height is set.
    fn default() -> Self {
        Self { significant_height_m: 0.0, peak_period_s: 3.0, from_rad: 0.0, spread_rad: 0.35 }
    }
}

#[derive(Debug, Clone, Copy)]
struct Component {
    omega_radps: f64,
    number_north_radpm: f64,
    number_east_radpm: f64,
    to_rad: f64,
    phase_rad: f64,
    acceleration_mps2: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Waves {
    components: Vec<Component>,
}

impl Waves {
    pub(crate) fn new(config: &WaveConfig, seed: u64) -> Result<Self, OutOfRange> {
        let height_m = within("significant wave height (m)", config.significant_height_m, 0.0, 3.0)?;
        let period_s = within("wave peak period (s)", config.peak_period_s, 1.0, 20.0)?;
        let from_rad = within("wave direction (rad)", config.from_rad, -TAU, TAU)?;
        let spread_rad = within("wave spread (rad)", config.spread_rad, 0.0, 1.5)?;
        if height_m <= 0.0 {
            return Ok(Self { components: Vec::new() });
        }
        let mut rng = Rng::new(seed, Stream::Waves);
        let component = |&(ratio, share): &(f64, f64)| {
            let omega_radps = ratio * rng.between(0.98, 1.02) * TAU / period_s;
            let number_radpm = omega_radps * omega_radps / GRAVITY_MPS2;
            let to_rad = from_rad + TAU / 2.0 + rng.between(-spread_rad, spread_rad);
            let amplitude_m = height_m * (share / 8.0).sqrt();
            Component {
                omega_radps,
                number_north_radpm: number_radpm * to_rad.cos(),
                number_east_radpm: number_radpm * to_rad.sin(),
                to_rad,
                phase_rad: rng.between(0.0, TAU),
                acceleration_mps2: amplitude_m * omega_radps * omega_radps,
            }
        };
        Ok(Self { components: SPECTRUM.iter().map(component).collect() })
    }

    pub(crate) fn force(&self, t_s: f64, otter: &Otter, state: &OtterState) -> BodyForce {
        let mut force = BodyForce::default();
        let (mass_surge_kg, mass_sway_kg) = otter.virtual_mass_kg();
        for c in &self.components {
            let phase_rad = c.omega_radps * t_s
                - c.number_north_radpm * state.position.north_m
                - c.number_east_radpm * state.position.east_m
                + c.phase_rad;
            let (sin_phase, cos_phase) = phase_rad.sin_cos();
            let (sin_chi, cos_chi) = (c.to_rad - state.psi_rad).sin_cos();
            let number_radpm = c.omega_radps * c.omega_radps / GRAVITY_MPS2;
            force.surge_n += mass_surge_kg * c.acceleration_mps2 * sin_phase * cos_chi;
            force.sway_n += mass_sway_kg * c.acceleration_mps2 * sin_phase * sin_chi;
            force.yaw_nm -= mass_sway_kg
                * c.acceleration_mps2
                * cos_phase
                * number_radpm
                * sin_chi
                * cos_chi
                * LENGTH_M
                * LENGTH_M
                / 12.0;
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sea() -> Waves {
        Waves::new(&WaveConfig { significant_height_m: 0.4, ..WaveConfig::default() }, 1).unwrap()
    }

    #[test]
    fn shares_out_the_significant_height() {
        let energy: f64 = sea()
            .components
            .iter()
            .map(|c| (c.acceleration_mps2 / c.omega_radps.powi(2)).powi(2) / 2.0)
            .sum();
        assert!((energy - 0.4 * 0.4 / 16.0).abs() < 1e-12);
    }

    #[test]
    fn forces_oscillate_about_zero_and_stay_bounded() {
        let otter = Otter::new(25.0).unwrap();
        let waves = sea();
        let bound_n: f64 =
            waves.components.iter().map(|c| c.acceleration_mps2).sum::<f64>() * otter.virtual_mass_kg().0;
        let mut mean_n = 0.0;
        for i in 0..100_000 {
            let force = waves.force(f64::from(i) * 0.04, &otter, &OtterState::default());
            assert!(force.surge_n.abs() <= bound_n);
            mean_n += force.surge_n / 1e5;
        }
        assert!(mean_n.abs() < 0.01 * bound_n, "{mean_n}");
    }

    #[test]
    fn a_flat_sea_exerts_nothing() {
        let waves = Waves::new(&WaveConfig::default(), 1).unwrap();
        let otter = Otter::new(0.0).unwrap();
        assert_eq!(waves.force(12.0, &otter, &OtterState::default()), BodyForce::default());
    }
}
