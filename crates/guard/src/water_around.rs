//! Chart queries of a vessel under way: the water around it and ahead.

use crate::limits::GuardLimits;
use charts::depth_index::{Demand, DepthAnswer, DepthIndex, EntryRules, Leg};
use units::{LatLon, LocalFrame, LocalPoint};

/// Positions are normal: so many standard deviations of each axis hold 95 % of them.
const SIGMAS: f64 = 2.45;
/// The cone widens by this share of the distance: the course is known to some degrees.
const WIDENING: f64 = 0.07;
/// The cone is covered by corridors that end at these shares of its length.
const STEPS: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// A prohibited area does not damage the hull: a vessel inside one must be able to steer out of it, so it is not
/// braked, turned back or aborted for it.
const UNDER_WAY: EntryRules = EntryRules::IGNORE;
/// Halvings of an interval when a clear radius is searched for.
const HALVINGS: u32 = 9;

/// Danger ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// Way until hull and position uncertainty touch it (m).
    pub distance_m: f64,
    /// What the chart says there.
    pub answer: DepthAnswer,
}

/// The water around a vessel, and what it needs of it.
#[derive(Debug, Clone, Copy)]
pub struct WaterAround<'a> {
    pub(crate) index: &'a DepthIndex,
    pub(crate) demand: Demand,
    pub(crate) hull_m: f64,
    pub(crate) place: LatLon,
}

impl<'a> WaterAround<'a> {
    /// Around a place that is known with this standard deviation (m), needing `least_m` of water.
    pub fn new(
        index: &'a DepthIndex,
        limits: &GuardLimits,
        (place, sigma_m): (LatLon, f64),
        least_m: f64,
    ) -> Self {
        let mut demand = limits.demand(least_m);
        // What navigation knows of its error counts, never less than what is stated.
        demand.position_m = limits.position_m.max(SIGMAS * sigma_m);
        demand.entry = UNDER_WAY;
        Self { index, demand, hull_m: limits.hull_m, place }
    }

    /// The same place with another demand of depth.
    pub(crate) fn needing(&self, limits: &GuardLimits, least_m: f64) -> Self {
        let demand =
            Demand { position_m: self.demand.position_m, entry: UNDER_WAY, ..limits.demand(least_m) };
        Self { demand, ..*self }
    }

    /// Whether the hull may be where it is, wherever within the uncertainty that is.
    pub fn is_clear(&self) -> bool {
        self.index.shallowest_within(self.place, self.hull_m, &self.demand).navigable
    }

    /// Where it is.
    pub fn place(&self) -> LatLon {
        self.place
    }

    /// How far the hull may be from that (m).
    pub fn reach_m(&self) -> f64 {
        self.hull_m + self.demand.position_m
    }

    /// The first danger within `length_m` in a direction.
    pub fn ahead(&self, direction_rad: f64, length_m: f64) -> Option<Ahead> {
        let frame = LocalFrame::new(self.place);
        let at = |way_m: f64| frame.to_place(LocalPoint::default().displaced(direction_rad, way_m));
        let mut begun_m = 0.0;
        for step in STEPS {
            let end_m = step * length_m;
            let half_width_m = self.hull_m + WIDENING * end_m;
            let leg = Leg { from: at(begun_m), to: at(end_m) };
            if let Some(answer) = self.index.first_danger_along(leg, half_width_m, &self.demand) {
                return Some(Ahead { distance_m: begun_m + answer.along_m, answer });
            }
            begun_m = end_m;
        }
        None
    }

    /// Radius around a place within which all is deep (m), at most `most_m`; hull and uncertainty are not taken
    /// off.
    pub fn clear_radius_m(&self, place: LatLon, most_m: f64) -> f64 {
        let demand = Demand { position_m: 0.0, ..self.demand };
        let clear = |radius_m: f64| self.index.shallowest_within(place, radius_m, &demand).navigable;
        if clear(most_m) {
            return most_m;
        }
        let (mut least_m, mut most_m) = (0.0, most_m);
        for _ in 0..HALVINGS {
            let middle_m = f64::midpoint(least_m, most_m);
            if clear(middle_m) { least_m = middle_m } else { most_m = middle_m }
        }
        least_m
    }
}
