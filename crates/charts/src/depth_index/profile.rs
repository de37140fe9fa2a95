//! How long a leg is and how deep it is right below it, for drawings.

use super::along::{Leg, divide};
use super::coords::{Spot, distance_m};
use super::index::DepthIndex;
use super::object::Water;

impl Leg {
    /// Its length (m), within 1 mm per km.
    pub fn length_m(self) -> f64 {
        divide(self).map(|(from, to)| distance_m(from, to)).sum()
    }
}

impl DepthIndex {
    /// What is charted at the leg's ends and between them at most `step_m` apart, by how far along (m) it is.
    /// Between those points anything may be: for safety ask [`Self::shallowest_along`]. At most 10,000 points.
    pub fn profile(&self, leg: Leg, step_m: f64) -> Vec<(f64, Water)> {
        const MOST: f64 = 10_000.0;
        let least_m = leg.length_m() / MOST;
        let step_m = if step_m > least_m { step_m } else { least_m.max(1e-3) };
        let mut points = Vec::new();
        let mut before_m = 0.0;
        let water = |at: Spot| self.state_at(at).stored.water();
        for (from, to) in divide(leg) {
            let length_m = distance_m(from, to);
            let steps = (length_m / step_m).ceil().clamp(1.0, MOST) as u32;
            for step in 0..steps {
                let share = f64::from(step) / f64::from(steps);
                let at = Spot { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
                points.push((before_m + share * length_m, water(at)));
            }
            before_m += length_m;
        }
        points.push((before_m, water(Spot::of(leg.to))));
        points
    }
}
