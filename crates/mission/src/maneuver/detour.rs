//! A way around what the chart refuses, to the place of a reference.
//!
//! It is checked against area and chart from the vessel's place, leg by leg, when it is taken and again whenever the vessel
//! starts again. A place that moves a little is reached by the same way with another end.

use super::behaviour::Context;
use super::goto::distance_m;
use std::collections::VecDeque;
use units::LatLon;

/// A way that ends farther from the place than this (m) does not lead there.
const AT_THE_PLACE_M: f64 = 1.0;
/// A place may move by this share of the whole way, or so far (m), before another way is searched for. Bent once by a
/// share s a way is longer than the shortest by a factor of (1 + s) / (1 - s) at most: the triangle inequality, applied
/// twice. A place that wanders leaves corners behind; a way that they make longer than that factor is searched for anew.
const BENT_SHARE: f64 = 0.25;
const BENT_M: f64 = 50.0;
/// A place that keeps moving leaves no way of more corners behind it than this.
const MOST_CORNERS: usize = 256;

/// A way that is followed.
#[derive(Debug, Clone)]
pub(super) struct Detour {
    /// The place for which it was searched for.
    found_for: LatLon,
    /// How long it was then (m).
    found_m: f64,
    /// The corners that lie ahead, the place itself last.
    corners: VecDeque<LatLon>,
}

impl Detour {
    /// Along these places, of which the first is where the vessel was when it asked.
    pub(super) fn along(cx: &Context<'_>, goal: LatLon, places: &[LatLon]) -> Result<Self, String> {
        let [_, between @ .., last] = places else { return Err("it cannot be reached".to_owned()) };
        if distance_m(*last, goal) > AT_THE_PLACE_M {
            return Err("it cannot be reached".to_owned());
        }
        let corners = between.iter().copied().chain([goal]).collect();
        let detour = Self { found_for: goal, found_m: length_m(places), corners };
        detour.check(cx).map(|()| detour)
    }

    /// Whether it leads to this place.
    pub(super) fn leads_to(&self, goal: LatLon) -> bool {
        self.corners.back() == Some(&goal)
    }

    /// The next corner.
    pub(super) fn next(&self) -> Option<LatLon> {
        self.corners.front().copied()
    }

    /// A corner was reached; the next one, if there is one.
    pub(super) fn pass(&mut self) -> Option<LatLon> {
        self.corners.pop_front();
        self.next()
    }

    /// Whether all that lies ahead keeps to area and deep water, from where the vessel is.
    ///
    /// # Errors
    /// Why not.
    pub(super) fn check(&self, cx: &Context<'_>) -> Result<(), String> {
        let fix = cx.fix.ok_or("the position is not known")?;
        let starts = std::iter::once(&fix.place).chain(&self.corners);
        starts.zip(&self.corners).try_for_each(|(from, to)| cx.waters.way(*from, *to))
    }

    /// The same way with another end, if that is not far from the old one: straight from its last corner, or on from its old
    /// end. The corners before stay, which keep farther from danger than the guard demands; the way to the first of them is
    /// checked against area and chart unless the vessel is on it. `None` where anything is refused.
    pub(super) fn bent_to(&self, cx: &Context<'_>, goal: LatLon, on_it: bool) -> Option<Self> {
        let here = cx.fix?.place;
        let may_move_m = BENT_M.max(BENT_SHARE * self.found_m);
        let is_near = distance_m(self.found_for, goal) <= may_move_m;
        if !is_near || !(on_it || self.check(cx).is_ok()) {
            return None;
        }
        if self.leads_to(goal) {
            return Some(self.clone());
        }
        let ends = [self.corners.len().saturating_sub(1), self.corners.len()];
        let longest_m = (self.found_m + 2.0 * BENT_M) * (1.0 + BENT_SHARE) / (1.0 - BENT_SHARE);
        let is_open = |kept: &usize| {
            let before: Vec<LatLon> =
                std::iter::once(here).chain(self.corners.iter().take(*kept).copied()).collect();
            let last = before[*kept];
            let bent_m = length_m(&before) + distance_m(last, goal);
            bent_m <= longest_m && *kept < MOST_CORNERS && cx.waters.way(last, goal).is_ok()
        };
        let kept = ends.into_iter().find(is_open)?;
        let corners = self.corners.iter().take(kept).copied().chain([goal]).collect();
        Some(Self { corners, ..*self })
    }
}

fn length_m(places: &[LatLon]) -> f64 {
    places.windows(2).map(|leg| distance_m(leg[0], leg[1])).sum()
}
