//! The depth that the guard demands, and the uncertainty of position, track and chart.

use charts::depth_index::{ChartTrust, Demand, EntryRules};

/// Limits of the guard. All but the water level are 0 or more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuardLimits {
    /// Least depth in which an operator may steer the vessel by hand (m).
    pub navigable_m: f64,
    /// Least depth in which it may sail autonomously (m).
    pub autonomous_m: f64,
    /// Draught at rest (m).
    pub draught_m: f64,
    /// How much deeper it lies under way (m).
    pub squat_m: f64,
    /// Height of the water above chart datum (m); 0 is the careful assumption.
    pub water_level_m: f64,
    /// Height of the vessel above the water (m); `None` to pass under everything.
    pub air_draught_m: Option<f64>,
    /// How far the chart is trusted.
    pub trust: ChartTrust,
    /// How plans into areas whose entry is prohibited or restricted are treated.
    pub entry: EntryRules,
    /// How far the vessel may be from where it believes to be (m).
    pub position_m: f64,
    /// How far it may stray from its track (m).
    pub cross_track_m: f64,
    /// Farthest point of the hull from the point that is steered (m).
    pub hull_m: f64,
    /// How fast it drifts with its motors off (m/s).
    pub drift_mps: f64,
    /// Smaller circles of loiters are widened to this (m).
    pub least_loiter_m: f64,
    /// Smaller radii of station keeping are widened to this (m).
    pub least_station_m: f64,
}

impl Default for GuardLimits {
    /// An Otter: 1 m navigable, 5 m autonomous, 0.32 m of draught with its payload, 2 m up to its aerials.
    fn default() -> Self {
        Self {
            navigable_m: 1.0,
            autonomous_m: 5.0,
            draught_m: 0.32,
            squat_m: 0.05,
            water_level_m: 0.0,
            air_draught_m: Some(2.0),
            trust: ChartTrust::AsCharted,
            entry: EntryRules::default(),
            position_m: 3.0,
            cross_track_m: 10.0,
            hull_m: 1.2,
            drift_mps: 0.2,
            least_loiter_m: 1.0,
            least_station_m: 2.0,
        }
    }
}

/// A limit out of its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the guard's {name} is {value}; it must be a number from {least} on")]
pub struct LimitsError {
    /// The limit, by its name in a configuration.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its least value.
    pub least: f64,
}

impl GuardLimits {
    /// Whether all are numbers in range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), LimitsError> {
        let from_zero = [
            ("navigable depth", self.navigable_m),
            ("autonomous depth", self.autonomous_m),
            ("draught", self.draught_m),
            ("squat", self.squat_m),
            ("air draught", self.air_draught_m.unwrap_or(0.0)),
            ("position uncertainty", self.position_m),
            ("cross-track limit", self.cross_track_m),
            ("hull radius", self.hull_m),
            ("drift speed", self.drift_mps),
            ("least loiter radius", self.least_loiter_m),
            ("least station radius", self.least_station_m),
        ];
        let level = ("water level", self.water_level_m, -100.0);
        let mut all = from_zero.map(|(name, value)| (name, value, 0.0)).into_iter().chain([level]);
        let bad = all.find(|(_, value, least)| !value.is_finite() || value < least);
        bad.map_or(Ok(()), |(name, value, least)| Err(LimitsError { name, value, least }))
    }

    /// These limits, but never with less water than `floor` asks for, nor relying on more of a tide, nor with a weaker rule
    /// of entry.
    #[must_use]
    pub fn at_least(self, floor: &Self) -> Self {
        Self {
            navigable_m: self.navigable_m.max(floor.navigable_m),
            autonomous_m: self.autonomous_m.max(floor.autonomous_m),
            water_level_m: self.water_level_m.min(floor.water_level_m),
            entry: self.entry.at_least(floor.entry),
            ..self
        }
    }

    /// Depth needed where `least_m` is demanded (m): never less than hull and squat take.
    pub fn needed_m(&self, least_m: f64) -> f64 {
        least_m.max(self.draught_m + self.squat_m)
    }

    /// The demand for water that must be `least_m` deep.
    pub fn demand(&self, least_m: f64) -> Demand {
        let own_m = self.draught_m + self.squat_m;
        Demand {
            water_level_m: self.water_level_m,
            draught_m: self.draught_m,
            squat_m: self.squat_m,
            // No number must not become the least demand.
            reserve_m: if least_m.is_nan() { f64::NAN } else { (least_m - own_m).max(0.0) },
            air_draught_m: self.air_draught_m,
            position_m: self.position_m,
            trust: self.trust,
            entry: self.entry,
        }
    }

    /// Distance to danger that leaves a vessel room to be so far off its track (m) before its path monitor acts.
    pub fn room_m(&self, stray_m: f64) -> f64 {
        stray_m + self.hull_m + self.position_m
    }

    /// Half width of the corridor of a track, position left out (m): the index adds that.
    pub fn half_width_m(&self) -> f64 {
        self.cross_track_m + self.hull_m
    }
}
