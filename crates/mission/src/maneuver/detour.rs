//! A way around what the chart refuses, to the place of a reference.
//!
//! It is held against area and chart from where the vessel is, leg by leg, when it is taken and again whenever the vessel sets
//! out anew. A place that moves a little is reached by the same way with another end.

use super::behaviour::Context;
use super::goto::distance_m;
use std::collections::VecDeque;
use units::LatLon;

/// A way that ends farther from the place than this (m) does not lead there.
const AT_THE_PLACE_M: f64 = 1.0;
/// A place may move by this share of what lies ahead, or so far (m), before another way is looked for. Bent by a share s
/// a way is longer than the shortest by a factor of (1 + s) / (1 - s) at most: the triangle inequality, applied twice.
const BENT_SHARE: f64 = 0.25;
const BENT_M: f64 = 50.0;
/// A place that keeps moving leaves no more corners behind it than this.
const MOST_CORNERS: usize = 64;

/// A way that is followed.
#[derive(Debug, Clone)]
pub(super) struct Detour {
    /// The place that it was looked for to lead to.
    found_for: LatLon,
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
        let detour = Self { found_for: goal, corners };
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

    /// The same way with another end, if that is not far from the old one: it leaves the way at the corner from which the
    /// whole is shortest, straight for the place. `None` where that is refused.
    pub(super) fn bent_to(&self, cx: &Context<'_>, goal: LatLon) -> Option<Self> {
        let may_move_m = BENT_M.max(BENT_SHARE * self.length_m(cx)?);
        if self.corners.len() >= MOST_CORNERS
            || distance_m(self.found_for, goal) > may_move_m
            || self.check(cx).is_err()
        {
            return None;
        }
        let ends = (1..=self.corners.len()).filter(|kept| {
            let left = self.corners[kept - 1];
            left == goal || cx.waters.way(left, goal).is_ok()
        });
        let bent = ends.map(|kept| {
            let way = self.corners.iter().take(kept).copied();
            let end = (self.corners[kept - 1] != goal).then_some(goal);
            Self { found_for: self.found_for, corners: way.chain(end).collect() }
        });
        let lengths = bent.filter_map(|bent| Some((bent.length_m(cx)?, bent)));
        lengths.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, bent)| bent)
    }

    /// How long the way ahead is, if the position is known (m).
    fn length_m(&self, cx: &Context<'_>) -> Option<f64> {
        let fix = cx.fix?;
        let starts = std::iter::once(&fix.place).chain(&self.corners);
        Some(starts.zip(&self.corners).map(|(from, to)| distance_m(*from, *to)).sum())
    }
}
