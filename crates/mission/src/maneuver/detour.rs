//! A way around what the chart refuses, to the place of a reference.
//!
//! Whoever runs the engine is asked for it, and answers when it can. Nothing moves until then; what comes is held against
//! area and chart from where the vessel is by then, leg by leg, and again whenever the vessel sets out anew.

use super::behaviour::Context;
use super::goto::distance_m;
use crate::event::{Reference, Way};
use std::collections::VecDeque;
use std::time::Duration;
use units::{LatLon, MonoTime};

/// An answer that takes longer is asked for again, and where there was no way, one is looked for again.
const AGAIN: Duration = Duration::from_mins(1);
/// A way that ends farther from the place than this (m) does not lead there.
const AT_THE_PLACE_M: f64 = 1.0;

/// What is looked for.
#[derive(Debug, Clone)]
pub(super) struct Search {
    goal: LatLon,
    /// What is to be followed when it is found; nothing where there is no way.
    wanted: Option<Reference>,
    /// When it is looked for again.
    until: MonoTime,
}

/// How a search stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standing {
    /// It is looked for.
    Asked,
    /// There is no way.
    Nothing,
    /// The answer is overdue, or it is time to look again.
    Over,
}

impl Search {
    /// Asks for a way from a place to that of a reference.
    pub(super) fn ask(cx: &mut Context<'_>, from: LatLon, goal: LatLon, wanted: Reference) -> Self {
        cx.look_for_way(from, goal);
        Self { goal, wanted: Some(wanted), until: cx.now.mono + AGAIN }
    }

    /// Whether it is one for this place.
    pub(super) fn leads_to(&self, goal: LatLon) -> bool {
        self.goal == goal
    }

    /// How it stands now that this reference came; the newest is the one to follow.
    pub(super) fn standing(&mut self, now: MonoTime, newest: Reference) -> Standing {
        if now >= self.until {
            return Standing::Over;
        }
        match &mut self.wanted {
            Some(wanted) => {
                *wanted = newest;
                Standing::Asked
            }
            None => Standing::Nothing,
        }
    }

    /// Takes an answer: what to follow and how, or why there is nothing to follow. `None` if nobody waits for it.
    pub(super) fn take(
        &mut self,
        cx: &Context<'_>,
        way: &Way,
    ) -> Option<Result<(Reference, Detour), String>> {
        if way.to != self.goal {
            return None;
        }
        let wanted = self.wanted.take()?;
        let found = way.places.clone().and_then(|places| Detour::along(cx, self.goal, &places));
        self.until = cx.now.mono + AGAIN;
        Some(found.map(|detour| (wanted, detour)))
    }
}

/// A way that is followed.
#[derive(Debug, Clone)]
pub(super) struct Detour {
    goal: LatLon,
    /// The corners that lie ahead, the place itself last.
    corners: VecDeque<LatLon>,
}

impl Detour {
    /// Along these places, of which the first is where the vessel was when it asked.
    fn along(cx: &Context<'_>, goal: LatLon, places: &[LatLon]) -> Result<Self, String> {
        let [_, between @ .., last] = places else { return Err("it cannot be reached".to_owned()) };
        if distance_m(*last, goal) > AT_THE_PLACE_M {
            return Err("it cannot be reached".to_owned());
        }
        let corners = between.iter().copied().chain([goal]).collect();
        let detour = Self { goal, corners };
        detour.check(cx).map(|()| detour)
    }

    /// Whether it leads to this place.
    pub(super) fn leads_to(&self, goal: LatLon) -> bool {
        self.goal == goal
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
}
