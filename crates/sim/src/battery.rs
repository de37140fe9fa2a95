//! Four lithium-ion batteries in parallel, 915 Wh each.
//!
//! Voltage: eight cells in series; open-circuit voltage per cell over charge as of a usual manganese-cobalt
//! cell (4.2 V full, 3.0 V empty), fitted to the one public reading of such a battery, 32.66 V at 94 %
//! on the TQ bus; internal resistance an assumption. Hotel load: 33.8 W, the sum of
//! computer, compass, radio, router, light and hydrophone in the power budget of the NTNU Otters.
//!
//! The batteries share the load in proportion to the energy they hold, so that all run empty together. Energy
//! lost in their resistance counts as drained.

use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use devices::BatteryReading;

const PACKS: usize = 4;
const CELLS: f64 = 8.0;
const RESISTANCE_OHM: f64 = 0.08;
const JOULES_PER_WH: f64 = 3600.0;
/// Volts per cell at 0 %, 10 % ... 100 %.
const CELL_V: [f64; 11] = [3.00, 3.45, 3.58, 3.63, 3.67, 3.72, 3.79, 3.87, 3.96, 4.05, 4.20];
/// Spread of the batteries' charges at the start, either way (%).
const IMBALANCE_PERCENT: f64 = 1.0;

/// The energy aboard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryConfig {
    /// Energy of one full battery (Wh).
    pub capacity_wh: f64,
    /// Mean charge at the start (%).
    pub charge_percent: f64,
    /// Power that all but the motors draw (W).
    pub hotel_w: f64,
}

impl Default for BatteryConfig {
    /// 915 Wh each, full, 33.8 W of hotel load.
    fn default() -> Self {
        Self { capacity_wh: 915.0, charge_percent: 100.0, hotel_w: 33.8 }
    }
}

/// The four batteries.
#[derive(Debug, Clone)]
pub struct BatteryBank {
    capacity_j: f64,
    hotel_w: f64,
    water_c: f64,
    stored_j: [f64; PACKS],
    voltage_v: [f64; PACKS],
    current_a: [f64; PACKS],
}

impl BatteryBank {
    /// Batteries that float in water of the given temperature (°C).
    ///
    /// # Errors
    /// When a setting is not a number or out of range.
    pub fn new(config: &BatteryConfig, water_c: f64, seed: u64) -> Result<Self, OutOfRange> {
        let capacity_j = within("battery capacity (Wh)", config.capacity_wh, 1.0, 1e5)? * JOULES_PER_WH;
        let charge_percent = within("battery charge (%)", config.charge_percent, 0.0, 100.0)?;
        let hotel_w = within("hotel load (W)", config.hotel_w, 0.0, 1e4)?;
        let mut rng = Rng::new(seed, Stream::Battery);
        let stored_j = std::array::from_fn(|_| {
            let off_percent = rng.between(-IMBALANCE_PERCENT, IMBALANCE_PERCENT);
            // No imbalance at either end: a full or an empty battery has none.
            let room = (charge_percent.min(100.0 - charge_percent) / 10.0).min(1.0);
            capacity_j * (charge_percent + off_percent * room) / 100.0
        });
        let mut bank =
            Self { capacity_j, hotel_w, water_c, stored_j, voltage_v: [0.0; PACKS], current_a: [0.0; PACKS] };
        bank.drain(0.0, 0.0);
        Ok(bank)
    }

    /// Draws the motors' power (W, not below 0) and the hotel load for `dt_s`.
    pub fn drain(&mut self, motors_w: f64, dt_s: f64) {
        let stored_j: f64 = self.stored_j.iter().sum();
        let load_w = if stored_j > 0.0 { self.hotel_w + motors_w.max(0.0) } else { 0.0 };
        for pack in 0..PACKS {
            let open_v = CELLS * cell_v(self.stored_j[pack] / self.capacity_j);
            let share_w = if stored_j > 0.0 { load_w * self.stored_j[pack] / stored_j } else { 0.0 };
            // V = E - R I and P = V I: the root with the higher voltage. Beyond the power the battery can
            // give at all, half the open voltage is what is left.
            let root_v = (open_v * open_v - 4.0 * RESISTANCE_OHM * share_w).max(0.0).sqrt();
            self.voltage_v[pack] = 0.5 * (open_v + root_v);
            self.current_a[pack] = (open_v - self.voltage_v[pack]) / RESISTANCE_OHM;
            self.stored_j[pack] = (self.stored_j[pack] - open_v * self.current_a[pack] * dt_s).max(0.0);
        }
    }

    /// Takes charge away until the mean is `percent`, held within 0 and the present charge.
    pub fn drain_to(&mut self, percent: f64) {
        let now = self.charge_percent();
        if percent.is_nan() || percent >= now {
            return;
        }
        let keep = percent.max(0.0) / now;
        for stored_j in &mut self.stored_j {
            *stored_j *= keep;
        }
        self.drain(0.0, 0.0);
    }

    /// Whether there is nothing left.
    pub fn is_empty(&self) -> bool {
        self.stored_j.iter().all(|&stored_j| stored_j <= 0.0)
    }

    /// Energy held by all (Wh).
    pub fn stored_wh(&self) -> f64 {
        self.stored_j.iter().sum::<f64>() / JOULES_PER_WH
    }

    /// Mean charge (%).
    pub fn charge_percent(&self) -> f64 {
        100.0 * self.stored_j.iter().sum::<f64>() / (self.capacity_j * PACKS as f64)
    }

    /// Mean voltage under load (V).
    pub fn voltage_v(&self) -> f64 {
        self.voltage_v.iter().sum::<f64>() / PACKS as f64
    }

    /// The report of each battery.
    pub fn readings(&self) -> [BatteryReading; PACKS] {
        std::array::from_fn(|pack| BatteryReading {
            // Four batteries.
            number: pack as u8,
            voltage_v: self.voltage_v[pack],
            current_a: self.current_a[pack],
            charge_percent: 100.0 * self.stored_j[pack] / self.capacity_j,
            // Two kelvin at 10 A: the heat of the resistance against the water around the pontoon.
            temperature_c: self.water_c + 0.02 * self.current_a[pack].powi(2),
        })
    }
}

/// Open-circuit voltage of a cell that holds a share, 0 to 1, of its energy.
fn cell_v(share: f64) -> f64 {
    let place = share.clamp(0.0, 1.0) * 10.0;
    let below = (place as usize).min(CELL_V.len() - 2);
    CELL_V[below] + (CELL_V[below + 1] - CELL_V[below]) * (place - below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voltage_meets_the_public_reading() {
        // 32.66 V at 94 %.
        assert!((CELLS * cell_v(0.94) - 32.66).abs() < 0.3, "{}", CELLS * cell_v(0.94));
    }

    #[test]
    fn full_motors_and_hotel_load_last_four_hours_and_a_half() {
        // Power budget of the NTNU Otters: 3660 Wh / 833.8 W = 4.39 h; the resistance costs some of it.
        let mut bank = BatteryBank::new(&BatteryConfig::default(), 8.0, 1).unwrap();
        let mut seconds = 0;
        while !bank.is_empty() {
            bank.drain(800.0, 1.0);
            seconds += 1;
        }
        let hours = f64::from(seconds) / 3600.0;
        assert!((4.2..4.4).contains(&hours), "{hours}");
    }

    #[test]
    fn drains_to_a_charge_but_never_upwards() {
        let config = BatteryConfig { charge_percent: 60.0, ..BatteryConfig::default() };
        let mut bank = BatteryBank::new(&config, 8.0, 1).unwrap();
        bank.drain_to(20.0);
        assert!((bank.charge_percent() - 20.0).abs() < 1e-9);
        bank.drain_to(50.0);
        bank.drain_to(f64::NAN);
        assert!((bank.charge_percent() - 20.0).abs() < 1e-9);
        bank.drain_to(-1.0);
        assert!(bank.is_empty());
        assert!(bank.readings().iter().all(|r| r.current_a < 1e-9 && r.voltage_v.is_finite()));
    }
}
