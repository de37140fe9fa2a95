//! A remedy whose plan begins behind land: the straight way there is refused by the chart, and the vessel searches for a
//! route.
//!
//! A route is requested, first with the configured clearance, then with the guard's own. Meanwhile the next weaker remedy
//! stands in. A route that is found is checked by guard and area from the vessel's place by then, and never sailed if
//! they refuse it. Where no route is found, this is reported with what is in the way, and it is tried again once a
//! minute; so it is where the remaining energy does not suffice ([`super::energy`]). A route found while the engine takes
//! no plan is kept for some minutes, and checked again with each try. Once the remedy is settled (by a stop, an abort, an
//! operator who steps in) the answer is ignored. With another chart the search starts anew, and a way under way is
//! checked again.

use super::{Context, DEEP_WATER, Supervise, entity_of};
use crate::arbiter::Source;
use crate::bus::Bus;
use crate::output::Level;
use crate::plans::{Behind, NotStarted, Plans};
use crate::routing::{FoundRoute, RouteAnswer, RouteRequest};
use crate::supervise::context::{How, Started};
use mission::Remedy;
use std::time::Duration;
use units::{LatLon, MonoTime};

/// An answer that takes longer is reported as missing. It is still taken when it comes, until the next request.
const ANSWER_WITHIN: Duration = Duration::from_mins(1);
/// Where there is no route, one is searched for again after this time.
const AGAIN: Duration = Duration::from_mins(1);

/// A route that the engine does not take is kept so long.
const FOUND_KEPT: Duration = Duration::from_mins(5);

/// The search for a way.
#[derive(Debug, Default)]
pub(super) struct WayHome {
    search: Option<Search>,
}

#[derive(Debug)]
struct Search {
    plan_id: String,
    to: LatLon,
    /// The obstacle.
    what: &'static str,
    /// Which of the clearances is asked for.
    attempt: usize,
    number: u32,
    state: State,
}

#[derive(Debug)]
enum State {
    Asked {
        until: MonoTime,
    },
    Overdue {
        until: MonoTime,
    },
    Found {
        route: FoundRoute,
        until: MonoTime,
    },
    /// None is sailed, for this reason.
    Nothing {
        text: String,
        until: MonoTime,
    },
}

impl Search {
    fn is_over(&self, now: MonoTime) -> bool {
        match &self.state {
            State::Overdue { until } | State::Nothing { until, .. } | State::Found { until, .. } => {
                now >= *until
            }
            State::Asked { .. } => false,
        }
    }

    /// Whether an answer to it is still taken.
    fn is_open(&self) -> bool {
        matches!(self.state, State::Asked { .. } | State::Overdue { .. })
    }
}

impl WayHome {
    /// Starts a plan of the database, by a route if the straight way to its beginning is refused; a route leaves the batteries
    /// the share of their charge that is kept.
    pub(super) fn start(
        &mut self,
        context: &mut Context<'_>,
        source: Source,
        plan_id: &str,
        kept: f64,
    ) -> Result<Started, String> {
        let in_need = source != Source::Failure;
        let here = context.position().ok().map(|estimate| estimate.place);
        let behind = here.filter(|_| context.grounding.routes.around);
        let behind = behind.and_then(|from| Some((from, context.plans.behind(plan_id, from)?)));
        let Some((from, behind)) = behind else {
            self.forget(context.bus);
            return context.start(&Remedy::Run { plan_id: plan_id.to_owned() }, in_need);
        };
        self.look(context, source, plan_id, from, &behind);
        if let Some(found) = self.sail_found(context, (plan_id, from), &behind, kept, in_need) {
            return found;
        }
        let Behind { why, what, .. } = behind;
        Err(match self.search.as_ref().map(|search| &search.state) {
            Some(State::Nothing { text, .. }) => format!("{why}; {text}"),
            Some(State::Overdue { .. }) => {
                format!("{why}; no route around {what} has been found within a minute")
            }
            _ => format!("{why}; a route around {what} is looked for"),
        })
    }

    /// Requests a route unless one to the same place is being searched for, known, or known not to exist.
    fn look(
        &mut self,
        context: &mut Context<'_>,
        source: Source,
        plan_id: &str,
        from: LatLon,
        behind: &Behind,
    ) {
        let now = context.bus.mono();
        if let Some(search) = &mut self.search
            && matches!(search.state, State::Asked { until } if now >= until)
        {
            search.state = State::Overdue { until: now + AGAIN };
        }
        let same = |search: &&Search| search.plan_id == plan_id && search.to == behind.to;
        if self.search.as_ref().filter(same).is_none_or(|search| search.is_over(now)) {
            let text = format!("{}; a route around {} is looked for", behind.why, behind.what);
            context.bus.entry(entity_of(source), Level::Warning, text);
            self.ask(context, plan_id, (from, behind.to), behind.what, 0);
        }
    }

    /// Starts what was found, or says what keeps it from starting for the time being. `None` where nothing is found, or it
    /// must not be sailed: the search continues.
    fn sail_found(
        &mut self,
        context: &mut Context<'_>,
        (plan_id, from): (&str, LatLon),
        behind: &Behind,
        kept: f64,
        in_need: bool,
    ) -> Option<Result<Started, String>> {
        let search = self.search.as_ref()?;
        let State::Found { route, .. } = &search.state else { return None };
        let (found, attempt, left) = (route.clone(), search.attempt, context.energy_left(kept));
        let text = route_text(&found, behind);
        let refused = match context.start_by_route(plan_id, from, &found, left, in_need) {
            Ok(run) => {
                self.search = None;
                let how = How { text: format!("returning by {text}"), is_doubtful: false };
                return Some(Ok(Started { run: Some(run), how: Some(how) }));
            }
            Err(NotStarted::Engine(why)) => {
                return Some(Err(format!("{}; {text} was found and cannot start yet: {why}", behind.why)));
            }
            Err(NotStarted::Refused(why)) => no_route_text(behind.what, &why),
            Err(NotStarted::OutOfReach(why)) => format!("{text} is out of reach: {why}"),
        };
        self.next(context, attempt, refused);
        None
    }

    /// Whether an answer is waited for.
    pub(super) fn waits(&self) -> bool {
        self.search.as_ref().is_some_and(|search| matches!(search.state, State::Asked { .. }))
    }

    /// Takes an answer; false if no search waits for it.
    fn take(&mut self, context: &mut Context<'_>, answer: &RouteAnswer) -> bool {
        let until = context.bus.mono() + FOUND_KEPT;
        let asked = |search: &&mut Search| search.number == answer.number && search.is_open();
        let Some(search) = self.search.as_mut().filter(asked) else { return false };
        let attempt = search.attempt;
        match &answer.outcome {
            Ok(route) => search.state = State::Found { route: route.clone(), until },
            Err(why) => {
                let text = no_route_text(search.what, why);
                self.next(context, attempt, text);
            }
        }
        true
    }

    /// The search is not needed any more.
    fn forget(&mut self, bus: &mut Bus) {
        if let Some(search) = self.search.take().filter(Search::is_open) {
            bus.give_up_route(search.number);
        }
    }

    fn ask(
        &mut self,
        context: &mut Context<'_>,
        plan_id: &str,
        (from, to): (LatLon, LatLon),
        what: &'static str,
        attempt: usize,
    ) {
        let routes = &context.grounding.routes;
        let clearances_m = routes.clearances_m(&context.guard);
        let clearance_m = clearances_m[attempt.min(clearances_m.len() - 1)];
        let area = context.plans.area();
        let request = RouteRequest::new((from, to), &context.guard, area, clearance_m, routes.longest_m);
        let number = context.bus.ask_route(request);
        let state = State::Asked { until: context.bus.mono() + ANSWER_WITHIN };
        self.search = Some(Search { plan_id: plan_id.to_owned(), to, what, attempt, number, state });
    }

    /// A search failed: the next clearance, or none for a while.
    fn next(&mut self, context: &mut Context<'_>, attempt: usize, text: String) {
        let here = context.position().ok().map(|estimate| estimate.place);
        let Some(search) = &mut self.search else { return };
        let more = attempt + 1 < context.grounding.routes.clearances_m(&context.guard).len();
        match here.filter(|_| more) {
            Some(from) => {
                let (plan_id, to, what) = (search.plan_id.clone(), search.to, search.what);
                self.ask(context, &plan_id, (from, to), what, attempt + 1);
            }
            None => search.state = State::Nothing { text, until: context.bus.mono() + AGAIN },
        }
    }
}

impl Supervise {
    /// An answer came. It moves nothing on its own: the remedy is decided upon again, if it is still wanted.
    pub(crate) fn route_came(&mut self, context: &mut Context<'_>, answer: &RouteAnswer) {
        // Contact that came back meanwhile is handled first.
        self.drain(context);
        if self.way_home.take(context, answer) {
            self.arbiter.try_now(context.bus.mono());
            self.carry_out(context);
        }
    }

    /// Another chart is in force: searches by the previous one start anew, and a plan that carries out a
    /// remedy is given up if what lies ahead of it is refused. It is then decided upon again, at the next check.
    pub(crate) fn charted(&mut self, bus: &mut Bus, plans: &Plans, place: Option<LatLon>) {
        self.way_home.forget(bus);
        let leads_home =
            matches!(self.arbiter.remedy(), Some(Remedy::Run { plan_id }) if plan_id != DEEP_WATER);
        let Some(why) = place.filter(|_| leads_home).and_then(|place| plans.own_way_refused(place)) else {
            return;
        };
        if let Some(source) = self.arbiter.begin_again(bus.mono()) {
            let text =
                format!("the new chart closes the way home: {why}; the vessel holds and looks for another");
            bus.entry(entity_of(source), Level::Error, text);
        }
    }

    /// Gives up looking for a way to a plan that is not wanted any more.
    pub(super) fn look_at_way_home(&mut self, bus: &mut Bus) {
        let Some(search) = &self.way_home.search else { return };
        let wanted =
            matches!(self.arbiter.wanted(), Some(Remedy::Run { plan_id }) if plan_id == search.plan_id);
        if !(wanted && self.under_way) {
            self.way_home.forget(bus);
        }
    }
}

fn no_route_text(what: &str, why: &str) -> String {
    format!("there is no route around {what} either: {why}")
}

/// A route in words.
fn route_text(found: &FoundRoute, behind: &Behind) -> String {
    let length = match found.length_m {
        length_m if length_m < 1_000.0 => format!("{length_m:.0} m"),
        length_m => format!("{:.1} km", length_m / 1e3),
    };
    let out = if found.start_moved { ", first back to deep water" } else { "" };
    format!("a route of {length} around {}{out}", behind.what)
}
