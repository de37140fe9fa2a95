//! The limits of plans.

use crate::kind::ManeuverKind;
use crate::speed::SpeedLimits;
use guard::Area;
use std::collections::BTreeSet;

/// The limits of plans.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanLimits {
    /// Largest speeds.
    pub speed: SpeedLimits,
    /// Largest speed that the times of a FollowTrajectory may need (m/s).
    pub max_timed_mps: f64,
    /// Kinds that this vessel does not do.
    pub refused: BTreeSet<ManeuverKind>,
    /// Greatest depth a maneuver may want (m); 0 on the surface.
    pub max_depth_m: f64,
    /// Largest radius (m).
    pub max_radius_m: f64,
    /// Farthest offset of a point from its reference, north or east (m).
    pub max_offset_m: f64,
    /// Most maneuvers of a plan.
    pub max_maneuvers: usize,
    /// Most points of a maneuver.
    pub max_points: usize,
    /// All places must be inside, if there is an area.
    pub area: Option<Area>,
}

impl Default for PlanLimits {
    fn default() -> Self {
        Self {
            speed: SpeedLimits::default(),
            max_timed_mps: SpeedLimits::default().max_mps,
            refused: BTreeSet::new(),
            max_depth_m: 0.0,
            max_radius_m: 5_000.0,
            max_offset_m: 50_000.0,
            max_maneuvers: 5_000,
            max_points: 10_000,
            area: None,
        }
    }
}
