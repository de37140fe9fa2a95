//! Length, duration and energy of a plan, told before it starts.

/// What a plan will take, as far as that can be told before it starts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanStatistics {
    /// Name of the plan.
    pub plan_id: String,
    /// All maneuvers together; a cyclic plan has no total.
    pub total: Cost,
    /// By maneuver, in the order they are sailed.
    pub maneuvers: Vec<(String, Cost)>,
}

/// What something takes; what cannot be told is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Way (m).
    pub length_m: Option<f64>,
    /// Time (s).
    pub duration_s: Option<f64>,
    /// Energy from the battery (J).
    pub energy_j: Option<f64>,
}
