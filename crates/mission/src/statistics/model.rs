//! A vessel's speeds in percent, rpm and m/s, and their power.

use thiserror::Error;
use units::Speed;

/// One row of a vehicle model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ModelPoint {
    /// Percent of full actuation.
    pub percent: f64,
    /// Revolutions per minute.
    pub rpm: f64,
    /// Speed through water (m/s).
    pub mps: f64,
    /// Power from the battery, everything included (W).
    pub power_w: f64,
}

/// Why rows are not a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ModelError {
    /// A model needs two rows.
    #[error("a vehicle model needs at least two rows")]
    TooFewRows,
    /// A value is not a number, below 0 or less than in the row before.
    #[error("row {0} of the vehicle model falls or is not a number")]
    Row(usize),
}

/// A table of speeds and power, linear between its rows, the last row being the most the vessel does.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleModel(Vec<ModelPoint>);

impl Default for VehicleModel {
    /// The speeds of the thesis' table; the power is a guess (30 W at rest, growing with the cube of speed to
    /// 1.8 kW) that a measured curve should replace.
    fn default() -> Self {
        let rpm = [0.0, 120.0, 245.0, 360.0, 490.0, 615.0, 725.0, 845.0, 980.0];
        let mps = [0.0, 1.0, 1.3, 1.6, 1.9, 2.2, 2.5, 2.8, 3.09_f64];
        let rows = rpm.into_iter().zip(mps).zip(0..);
        Self(
            rows.map(|((rpm, mps), tenth)| ModelPoint {
                percent: 10.0 * f64::from(tenth),
                rpm,
                mps,
                power_w: 30.0 + 60.0 * mps.powi(3),
            })
            .collect(),
        )
    }
}

impl VehicleModel {
    /// From its rows, the first at rest.
    ///
    /// # Errors
    /// When there are fewer than two rows or a column falls.
    pub fn new(rows: Vec<ModelPoint>) -> Result<Self, ModelError> {
        if rows.len() < 2 {
            return Err(ModelError::TooFewRows);
        }
        let mut before = ModelPoint::default();
        for (index, row) in rows.iter().enumerate() {
            let columns = [
                (before.percent, row.percent),
                (before.rpm, row.rpm),
                (before.mps, row.mps),
                (before.power_w, row.power_w),
            ];
            if columns.iter().any(|(before, value)| !value.is_finite() || value < before) {
                return Err(ModelError::Row(index));
            }
            before = *row;
        }
        Ok(Self(rows))
    }

    /// A speed in metres per second.
    pub fn mps(&self, speed: Speed) -> f64 {
        match speed {
            Speed::MetresPerSecond(mps) => mps.max(0.0),
            Speed::Rpm(rpm) => self.look_up(rpm, |row| row.rpm, |row| row.mps),
            Speed::Percent(percent) => self.look_up(percent, |row| row.percent, |row| row.mps),
        }
    }

    /// The fastest speed that it knows (m/s).
    pub fn fastest_mps(&self) -> f64 {
        self.0.last().map_or(0.0, |row| row.mps)
    }

    /// The power a speed takes (W).
    pub fn power_w(&self, mps: f64) -> f64 {
        self.look_up(mps, |row| row.mps, |row| row.power_w)
    }

    fn look_up(&self, key: f64, keys: fn(&ModelPoint) -> f64, values: fn(&ModelPoint) -> f64) -> f64 {
        let above = self.0.iter().position(|row| keys(row) >= key);
        match above {
            Some(0) => values(&self.0[0]),
            Some(above) => {
                let (from, to) = (&self.0[above - 1], &self.0[above]);
                let share = (key - keys(from)) / (keys(to) - keys(from));
                values(from) + share * (values(to) - values(from))
            }
            None => self.0.last().map_or(0.0, values),
        }
    }
}
