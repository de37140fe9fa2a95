//! Ways that maneuvers search for under way: first with the configured clearance, then with the guard's own.
//!
//! The maneuver checks a way against area and chart before it follows it.

use super::Plans;
use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::pilot::Pilot;
use crate::routing::{RouteAnswer, RouteRequest};
use mission::{Event, Way};
use units::LatLon;

/// A way that is being searched for.
#[derive(Debug)]
pub(super) struct Search {
    number: u32,
    from: LatLon,
    to: LatLon,
    /// Which of the clearances is asked for.
    attempt: usize,
}

impl Plans {
    /// A maneuver wants a way.
    pub(super) fn look_for_way(&mut self, bus: &mut Bus, from: LatLon, to: LatLon) {
        self.ask_for_way(bus, from, to, 0);
    }

    /// The plan whose maneuver waits for a way has ended; the system that asked for a place behind land is informed.
    pub(super) fn give_up_way(&mut self, bus: &mut Bus, plan_id: &str) {
        let Some(search) = self.way.take() else { return };
        bus.give_up_route(search.number);
        let asked_by =
            self.reference.as_ref().map_or_else(String::new, |(system, ..)| format!(" by {system:#06x}"));
        let text = format!(
            "the search for a route to the place asked for{asked_by} has stopped: '{plan_id}' has ended"
        );
        bus.entry(Entity::PlanEngine, Level::Warning, text);
    }

    /// Control ashore has changed hands: the search was for the previous holder, and its answer moves nothing.
    pub(crate) fn commander_changed(&mut self, bus: &mut Bus, pilot: &mut Pilot) {
        if let Some(search) = self.way.take() {
            bus.give_up_route(search.number);
        }
        self.tell(bus, pilot, mission::Input::Event(Event::CommanderChanged));
    }

    /// An answer came; nothing happens if it is not what the maneuver under way waits for.
    pub(crate) fn route_came(&mut self, bus: &mut Bus, pilot: &mut Pilot, answer: &RouteAnswer) {
        let Some(search) = self.way.take_if(|search| search.number == answer.number) else { return };
        let Search { from, to, attempt, .. } = search;
        let places = match &answer.outcome {
            Ok(found) if !found.start_moved => Ok(found.places.clone()),
            Ok(_) | Err(_) if attempt + 1 < self.clearances_m().len() => {
                self.ask_for_way(bus, from, to, attempt + 1);
                return;
            }
            Ok(_) => Err("the vessel lies too near danger to set out".to_owned()),
            Err(why) => Err(why.clone()),
        };
        self.tell(bus, pilot, mission::Input::Event(Event::Way(Way { to, places })));
    }

    fn ask_for_way(&mut self, bus: &mut Bus, from: LatLon, to: LatLon, attempt: usize) {
        let limits = self.settings.guard_limits();
        let clearances_m = self.clearances_m();
        let clearance_m = clearances_m[attempt.min(clearances_m.len() - 1)];
        let longest_m = self.settings.grounding.routes.longest_m;
        let area = self.settings.mission.limits.area.as_ref();
        let request = RouteRequest::new((from, to), &limits, area, clearance_m, longest_m);
        let number = bus.ask_route(request);
        self.way = Some(Search { number, from, to, attempt });
    }

    fn clearances_m(&self) -> Vec<f64> {
        self.settings.grounding.routes.clearances_m(&self.settings.guard_limits())
    }
}
