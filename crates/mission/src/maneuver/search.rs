//! The search for a way to the place of a reference that no straight way leads to.
//!
//! The engine's caller is asked for it, and answers when it can; nothing moves until then. One way is searched for at a
//! time and not more often than [`LEAST_BETWEEN`], however often the place changes: the latest place is reached by the
//! way that was found if its end can be moved there, else by the next one. So a place that moves, or two that alternate,
//! never keep a search from finishing.

use super::behaviour::Context;
use super::detour::Detour;
use super::goto::distance_m;
use crate::event::{Reference, Way};
use std::time::Duration;
use units::{LatLon, MonoTime};

/// A search that takes longer is requested again; so is one that found no way.
const AGAIN: Duration = Duration::from_mins(1);
/// Ways are not asked for more often than once in this time.
const LEAST_BETWEEN: Duration = Duration::from_secs(5);
/// A way that was found for a place that is not asked for any more is kept so long.
const SPARE_KEPT: Duration = Duration::from_secs(30);
/// Where no way leads to a place, none is searched for to another this near (m).
pub(super) const SAME_PLACE_M: f64 = 50.0;
/// A vessel that has moved so far since it asked (m) asks again for a way that is refused from where it is.
const MOVED_M: f64 = 20.0;

/// The search.
#[derive(Debug, Clone, Default)]
pub(super) struct Search {
    state: State,
    /// The reference to follow when a way is found.
    wanted: Option<Reference>,
    /// When a way was asked for last.
    asked: Option<MonoTime>,
}

#[derive(Debug, Clone, Default)]
enum State {
    #[default]
    Idle,
    /// A way from a place to a place is searched for.
    Asked { from: LatLon, goal: LatLon },
    /// No way was found.
    Nothing { goal: LatLon, until: MonoTime },
    /// A way was found to a place that another has taken the place of.
    Spare { detour: Detour, until: MonoTime },
}

/// The decision on a reference that no straight way leads to.
#[derive(Debug, Clone)]
pub(super) enum Standing {
    /// A way is searched for, or will be in some seconds.
    Looked,
    /// There is no way.
    Nothing,
    /// A way is known.
    Known(Detour),
}

impl Search {
    /// A reference to whose place no straight way leads came; the newest is the one to follow.
    pub(super) fn want(&mut self, cx: &mut Context<'_>, goal: LatLon, newest: Reference) -> Standing {
        match &self.state {
            State::Nothing { goal: closed, until }
                if cx.now.mono < *until && distance_m(*closed, goal) < SAME_PLACE_M =>
            {
                return Standing::Nothing;
            }
            State::Spare { detour, until } if cx.now.mono < *until => {
                if let Some(detour) = detour.bent_to(cx, goal, false) {
                    self.settled();
                    return Standing::Known(detour);
                }
            }
            State::Nothing { .. } | State::Spare { .. } | State::Idle | State::Asked { .. } => {}
        }
        self.wanted = Some(newest);
        self.look(cx);
        Standing::Looked
    }

    /// Asks for a way if one is wanted and it is time to.
    pub(super) fn look(&mut self, cx: &mut Context<'_>) {
        let (Some(fix), Some(goal)) = (cx.fix, self.wanted.and_then(|wanted| wanted.location)) else {
            return;
        };
        let wait = if matches!(self.state, State::Asked { .. }) { AGAIN } else { LEAST_BETWEEN };
        if self.asked.is_some_and(|asked| cx.now.mono.since(asked) < wait) {
            return;
        }
        cx.look_for_way(fix.place, goal);
        self.asked = Some(cx.now.mono);
        self.state = State::Asked { from: fix.place, goal };
    }

    /// Takes an answer: what to follow and how, or the place that no way leads to and why. `None` if it settles nothing.
    pub(super) fn take(
        &mut self,
        cx: &Context<'_>,
        way: &Way,
    ) -> Option<Result<(Reference, Detour), (LatLon, String)>> {
        let State::Asked { from, goal } = self.state else { return None };
        if way.to != goal {
            return None;
        }
        self.state = State::Idle;
        let newest = self.wanted.and_then(|wanted| wanted.location);
        match way.places.clone().and_then(|places| Detour::along(cx, goal, &places)) {
            Ok(detour) => {
                let bent = newest.and_then(|newest| detour.bent_to(cx, newest, false));
                if let (Some(detour), Some(wanted)) = (bent, self.wanted) {
                    self.settled();
                    return Some(Ok((wanted, detour)));
                }
                self.state = State::Spare { detour, until: cx.now.mono + SPARE_KEPT };
                None
            }
            Err(_)
                if cx.fix.is_some_and(|fix| way.places.is_ok() && distance_m(from, fix.place) > MOVED_M) =>
            {
                None
            }
            Err(why) => {
                self.state = State::Nothing { goal, until: cx.now.mono + AGAIN };
                let newest = newest.filter(|newest| distance_m(*newest, goal) < SAME_PLACE_M)?;
                self.wanted = None;
                Some(Err((newest, why)))
            }
        }
    }

    /// Ends the search; returns the reference that was wanted.
    pub(super) fn give_up(&mut self) -> Option<Reference> {
        self.wanted.take()
    }

    /// The system that wants it.
    pub(super) fn wanted_by(&self) -> Option<u16> {
        self.wanted.map(|wanted| wanted.system)
    }

    fn settled(&mut self) {
        (self.state, self.wanted) = (State::Idle, None);
    }
}
