//! Waves as bounded, oscillating forces on the hull and movements of the water around it.
//!
//! A simple model for a hull that is short against the waves: five regular deep-water components around the
//! peak period (dispersion ω² = g k, J. N. Newman, "Marine Hydrodynamics", 1977,
//! chapter 6), each with a phase
//! and a slightly different direction from the seed, their heights sharing out H_s by Σ a²/2 = H_s²/16. The
//! water moves along the direction of travel with -a ω cos(ω t - k·x + φ) and accelerates with a ω² sin(..).
//! The acceleration acts on the virtual mass (Froude-Krylov and added mass in the long-wave limit, as
//! in Newman) and the velocity joins the current, so that the hull rides with the water; the change of
//! the acceleration along the hull gives the yaw moment m k a_w sin χ cos χ L²/12. Drift forces, roll and
//! pitch are left out. The vessel's own movement gives the frequency of encounter. By the second order of
//! these terms a hull that is not steered turns slowly, within minutes, towards the waves.

use crate::otter::{Load, Otter, OtterState};
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
    number_radpm: f64,
    /// Unit vector of the direction of travel.
    to_north: f64,
    to_east: f64,
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
                number_radpm,
                to_north: to_rad.cos(),
                to_east: to_rad.sin(),
                phase_rad: rng.between(0.0, TAU),
                acceleration_mps2: amplitude_m * omega_radps * omega_radps,
            }
        };
        Ok(Self { components: SPECTRUM.iter().map(component).collect() })
    }

    /// The force on a hull in this state, and the velocity of the water at it to the north and to the east
    /// (m/s), `t_s` after the start.
    pub(crate) fn load(&self, t_s: f64, otter: &Otter, state: &OtterState) -> Load {
        let mut load = Load::default();
        let (mass_surge_kg, mass_sway_kg) = otter.virtual_mass_kg();
        // The hull floats level, so its displacement is centred where its mass is.
        let moment_kgm = otter.mass_moment_kgm();
        let (sin_psi, cos_psi) = state.psi_rad.sin_cos();
        for c in &self.components {
            let phase_rad = c.omega_radps * t_s
                - c.number_radpm * (c.to_north * state.position.north_m + c.to_east * state.position.east_m)
                + c.phase_rad;
            let (sin_phase, cos_phase) = phase_rad.sin_cos();
            // The direction of travel seen from the hull.
            let ahead = c.to_north * cos_psi + c.to_east * sin_psi;
            let aside = c.to_east * cos_psi - c.to_north * sin_psi;
            load.force.surge_n += mass_surge_kg * c.acceleration_mps2 * sin_phase * ahead;
            load.force.sway_n += mass_sway_kg * c.acceleration_mps2 * sin_phase * aside;
            let slope = c.number_radpm * LENGTH_M * LENGTH_M / 12.0;
            load.force.yaw_nm += moment_kgm * c.acceleration_mps2 * sin_phase * aside;
            load.force.yaw_nm -= mass_sway_kg * c.acceleration_mps2 * cos_phase * slope * ahead * aside;
            let speed_mps = -c.acceleration_mps2 / c.omega_radps * cos_phase;
            load.current_north_mps += speed_mps * c.to_north;
            load.current_east_mps += speed_mps * c.to_east;
        }
        load
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
            let force = waves.load(f64::from(i) * 0.04, &otter, &OtterState::default()).force;
            assert!(force.surge_n.abs() <= bound_n);
            mean_n += force.surge_n / 1e5;
        }
        assert!(mean_n.abs() < 0.01 * bound_n, "{mean_n}");
    }

    #[test]
    fn a_flat_sea_exerts_nothing() {
        let waves = Waves::new(&WaveConfig::default(), 1).unwrap();
        let otter = Otter::new(0.0).unwrap();
        assert_eq!(waves.load(12.0, &otter, &OtterState::default()), Load::default());
    }

    #[test]
    fn velocity_is_the_integral_of_the_acceleration() {
        let otter = Otter::new(25.0).unwrap();
        let waves = sea();
        let at = |t_s: f64| waves.load(t_s, &otter, &OtterState::default());
        for i in 0..50 {
            let t_s = f64::from(i) * 0.37;
            let slope = (at(t_s + 1e-4).current_north_mps - at(t_s - 1e-4).current_north_mps) / 2e-4;
            // Heading north, surge is north.
            let acceleration_mps2 = at(t_s).force.surge_n / otter.virtual_mass_kg().0;
            assert!((slope - acceleration_mps2).abs() < 1e-5, "{slope} {acceleration_mps2}");
        }
    }
}
