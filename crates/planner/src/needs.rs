//! How deep and how far off.

use charts::depth_index::Demand;

/// Farthest that a way can be asked to keep off (m).
const MOST_CLEARANCE_M: f64 = 20_000.0;

/// What a vessel needs of the water around its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// What of the water under and over it.
    pub demand: Demand,
    /// How far the way keeps from all that does not meet the demand (m); the uncertainty of the position
    /// ([`Demand::position_m`]) is added.
    pub clearance_m: f64,
}

/// Needs that nothing can meet.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the {name} is {value}; it must be a number from {least} to {most}")]
pub struct NeedsError {
    /// The need, by its name in a request.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// Its bounds.
    pub least: f64,
    /// Its bounds.
    pub most: f64,
}

impl NeedsError {
    /// If a value is out of its bounds.
    pub(crate) fn of(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), Self> {
        let good = (least..=most).contains(&value);
        if good { Ok(()) } else { Err(Self { name, value, least, most }) }
    }
}

impl Needs {
    /// A least depth and a clearance, both in metres, and nothing else.
    pub fn depth_and_clearance(depth_m: f64, clearance_m: f64) -> Self {
        Self { demand: Demand::least_depth(depth_m), clearance_m }
    }

    /// Whether all are numbers in range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), NeedsError> {
        let all = [
            ("least depth (m)", self.demand.needed_m(), -100.0, 12_000.0),
            ("clearance (m)", self.clearance_m, 0.0, MOST_CLEARANCE_M),
            ("uncertainty of the position (m)", self.demand.position_m, 0.0, MOST_CLEARANCE_M),
            ("water level (m)", self.demand.water_level_m, -100.0, 100.0),
        ];
        all.into_iter().try_for_each(|(name, value, least, most)| NeedsError::of(name, value, least, most))
    }

    /// How far from every barrier the way keeps (m).
    pub(crate) fn reach_m(&self) -> f64 {
        self.clearance_m + self.demand.position_m
    }
}
