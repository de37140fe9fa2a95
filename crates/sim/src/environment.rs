//! Current, wind and waves around one vessel, and the load they put on its hull.
//!
//! Each part is off by default. All chance comes from the seed; forces are bounded because every process
//! behind them is.

use crate::current::{Current, CurrentConfig};
use crate::otter::{Load, Otter, OtterState};
use crate::range::OutOfRange;
use crate::waves::{WaveConfig, Waves};
use crate::wind::{Wind, WindConfig};

/// The sea and the air of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnvironmentConfig {
    /// Movement of the water.
    pub current: CurrentConfig,
    /// Movement of the air.
    pub wind: WindConfig,
    /// Movement of the surface.
    pub waves: WaveConfig,
}

/// The surroundings of one vessel, stepped at a fixed interval.
#[derive(Debug, Clone)]
pub struct Environment {
    current: Current,
    wind: Wind,
    waves: Waves,
}

impl Environment {
    /// Surroundings that repeat for the same seed, to be stepped every `dt_s`.
    ///
    /// # Errors
    /// When a setting is not a number or outside what the models hold for.
    pub fn new(config: &EnvironmentConfig, seed: u64, dt_s: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            current: Current::new(&config.current, seed, dt_s)?,
            wind: Wind::new(&config.wind, seed, dt_s)?,
            waves: Waves::new(&config.waves, seed)?,
        })
    }

    /// Moves current and wind on by one interval.
    pub fn step(&mut self) {
        self.current.step();
        self.wind.step();
    }

    /// The load on a hull in this state, `t_s` after the start of the simulation.
    pub fn load(&self, t_s: f64, otter: &Otter, state: &OtterState) -> Load {
        let (north_mps, east_mps) = self.current.velocity_mps();
        let wind = self.wind.force(state);
        let mut load = self.waves.load(t_s, otter, state);
        load.current_north_mps += north_mps;
        load.current_east_mps += east_mps;
        load.force.surge_n += wind.surge_n;
        load.force.sway_n += wind.sway_n;
        load.force.yaw_nm += wind.yaw_nm;
        load
    }

    /// The current of this instant: metres per second to the north and to the east.
    pub fn current_mps(&self) -> (f64, f64) {
        self.current.velocity_mps()
    }

    /// The wind of this instant: speed (m/s) and the direction it comes from (rad, clockwise from north).
    pub fn wind(&self) -> (f64, f64) {
        self.wind.now()
    }
}
