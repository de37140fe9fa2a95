//! The depth that a vessel demands, and how far the chart is trusted.
//!
//! Depth available = charted depth + water level - error of the chart; depth needed = draught + squat + reserve
//! under the keel. The margin is their difference. None of this is baked into an index.

use super::object::Water;
use super::restricted::EntryRules;

/// Errors of a zone of confidence: positions within `horizontal_m`, depths within `fixed_m + share · depth`,
/// both at 95 % (S-57 appendix A, attribute CATZOC).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneError {
    /// Of positions (m).
    pub horizontal_m: f64,
    /// Of depths, at any depth (m).
    pub fixed_m: f64,
    /// Of depths, growing with them.
    pub share: f64,
}

/// How far the chart is trusted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ChartTrust {
    /// As it is drawn; its quality is reported with every answer.
    #[default]
    AsCharted,
    /// Depths are reduced by the error of the worst zone of confidence that the corridor comes near.
    DepthErrors(
        /// For CATZOC 1 to 6.
        [ZoneError; 6],
    ),
    /// And every width grows by the error of positions.
    AllErrors(
        /// For CATZOC 1 to 6.
        [ZoneError; 6],
    ),
}

impl ChartTrust {
    /// The errors of S-57 for A1 to C. D is "worse than C" and U not assessed: both are taken as twice C.
    pub const STANDARD: [ZoneError; 6] = [
        ZoneError { horizontal_m: 5.0, fixed_m: 0.5, share: 0.01 },
        ZoneError { horizontal_m: 20.0, fixed_m: 1.0, share: 0.02 },
        ZoneError { horizontal_m: 50.0, fixed_m: 1.0, share: 0.02 },
        ZoneError { horizontal_m: 500.0, fixed_m: 2.0, share: 0.05 },
        ZoneError { horizontal_m: 1000.0, fixed_m: 4.0, share: 0.10 },
        ZoneError { horizontal_m: 1000.0, fixed_m: 4.0, share: 0.10 },
    ];

    pub(super) fn errors(&self) -> Option<(&[ZoneError; 6], bool)> {
        match self {
            Self::AsCharted => None,
            Self::DepthErrors(errors) => Some((errors, false)),
            Self::AllErrors(errors) => Some((errors, true)),
        }
    }
}

/// The depth that a vessel demands.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Demand {
    /// Height of the water above chart datum (m); 0 where it is not known.
    pub water_level_m: f64,
    /// Draught at rest (m).
    pub draught_m: f64,
    /// How much deeper it lies under way (m).
    pub squat_m: f64,
    /// Water wanted under the keel (m).
    pub reserve_m: f64,
    /// Height above the water (m); `None` to pass under everything.
    pub air_draught_m: Option<f64>,
    /// How far the vessel may be from where it believes to be (m); every width grows by it.
    pub position_m: f64,
    /// How far the chart is trusted.
    pub trust: ChartTrust,
    /// How it treats areas whose entry is prohibited or restricted.
    pub entry: EntryRules,
}

impl Demand {
    /// A least depth and nothing else but the usual rules of entry, such as 5 m for autonomous operation.
    pub fn least_depth(depth_m: f64) -> Self {
        Self { draught_m: depth_m, ..Self::default() }
    }

    /// Depth needed (m).
    pub fn needed_m(&self) -> f64 {
        self.draught_m + self.squat_m + self.reserve_m
    }

    /// The error of a charted depth (m).
    pub(super) fn depth_error_m(error: Option<ZoneError>, depth_m: f64) -> f64 {
        error.map_or(0.0, |error| error.fixed_m + error.share * depth_m.max(0.0))
    }

    /// Margin of a charted depth (m); negative = too shallow.
    pub(super) fn margin_m(&self, error: Option<ZoneError>, depth_m: f64) -> f64 {
        depth_m + self.water_level_m - Self::depth_error_m(error, depth_m) - self.needed_m()
    }

    /// A charted depth (mm) from which on nothing is too shallow; NaN anywhere makes everything so.
    pub(super) fn enough_mm(&self, error: Option<ZoneError>) -> i32 {
        let (fixed_m, share) = error.map_or((0.0, 0.0), |error| (error.fixed_m, error.share));
        let plain_m = self.needed_m() - self.water_level_m + fixed_m;
        let depth_m = if plain_m > 0.0 { plain_m / (1.0 - share.clamp(0.0, 0.99)) } else { plain_m };
        if depth_m.is_nan() { i32::MAX } else { (depth_m * 1000.0).ceil().clamp(-2e9, 2e9) as i32 + 1 }
    }

    /// Whether the vessel may be there, and by how much (m).
    pub(super) fn judge(&self, water: Water, error: Option<ZoneError>) -> (bool, Option<f64>) {
        match water {
            Water::Depth { least_m, .. } => {
                let margin_m = self.margin_m(error, least_m);
                (margin_m >= 0.0, Some(margin_m))
            }
            Water::Land | Water::Obstacle | Water::UnknownDepth | Water::NoData | Water::TooLow { .. } => {
                (false, None)
            }
        }
    }

    /// Whether the vessel fits under something. Clearances are given above high water, so only water above
    /// chart datum can lessen them.
    pub(super) fn fits_under(&self, clearance_m: Option<f64>) -> bool {
        let Some(air_draught_m) = self.air_draught_m else { return true };
        clearance_m.is_some_and(|clearance_m| clearance_m - self.water_level_m.max(0.0) >= air_draught_m)
    }
}
