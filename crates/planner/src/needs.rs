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
    /// Which.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// Its bounds.
    pub least: f64,
    /// Its bounds.
    pub most: f64,
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
        let bad = all.into_iter().find(|(_, value, least, most)| !(*least..=*most).contains(value));
        bad.map_or(Ok(()), |(name, value, least, most)| Err(NeedsError { name, value, least, most }))
    }

    /// How far from every barrier the way keeps (m).
    pub(crate) fn reach_m(&self) -> f64 {
        self.clearance_m + self.demand.position_m
    }
}
