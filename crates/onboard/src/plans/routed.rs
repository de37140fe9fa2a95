//! A plan whose beginning lies behind land: the route that leads there becomes its first maneuvers.

use super::{Plans, chart, checked, checked_own};
use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::pilot::Pilot;
use crate::routing::FoundRoute;
use crate::under_way::rest_from;
use guard::{Area, GuardLimits, Reason, WaterChart, Waters, check_way};
use imc::messages::{
    Goto, Message, PlanControl, PlanControlFlags, PlanControlOp, PlanControlType, PlanManeuver,
    PlanSpecification, PlanTransition, SpeedUnits, ZUnits,
};
use mission::{Node, PlanStatistics, RunId};
use units::{LatLon, LocalFrame, LocalPoint};

/// Speed of a route to a plan that names none (m/s).
const SPEED_MPS: f32 = 1.0;
const JOULES_PER_WH: f64 = 3600.0;
/// A vessel outside its area is back inside after so much of a route at most (m).
const OUTSIDE_M: f64 = 1_000.0;

/// Why a plan led by a route was not started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NotStarted {
    /// Guard or area refuse it from where the vessel is.
    Refused(String),
    /// It takes more energy than is left for it.
    OutOfReach(String),
    /// The engine takes no plan at this moment.
    Engine(String),
}

/// The straight way to the beginning of a plan is refused, and the plan itself is not.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Behind {
    /// Why there is no route, in words.
    pub(crate) why: String,
    /// The obstacle, in a word or two.
    pub(crate) what: &'static str,
    /// Where the plan begins.
    pub(crate) to: LatLon,
}

impl Plans {
    /// Whether a route would lead to a plan of the database to which the straight way from here does not.
    pub(crate) fn behind(&self, plan_id: &str, from: LatLon) -> Option<Behind> {
        let plan = checked(&self.database.plan(plan_id)?, &self.settings).ok()?;
        let limits = self.settings.guard_limits();
        let verdict = chart::verdict(&self.settings, &plan, Some(from), &limits)?;
        let reason = verdict.refused().next()?.reason?;
        if chart::verdict(&self.settings, &plan, None, &limits)?.is_refused() {
            return None;
        }
        let to = plan.node(plan.start()).map(Node::maneuver)?.places().first().copied()?;
        Some(Behind { why: verdict.summary(), what: word(reason), to })
    }

    /// The area that plans keep to.
    pub(crate) fn area(&self) -> Option<&Area> {
        self.settings.mission.limits.area.as_ref()
    }

    /// A plan of the database led by a route to its beginning; `ways_out` are what the way to a route that begins elsewhere
    /// than here is checked against, one of them being enough.
    ///
    /// # Errors
    /// Why guard or area refuse it.
    pub(crate) fn led_by_route(
        &self,
        (plan_id, from): (&str, LatLon),
        route: &FoundRoute,
        ways_out: &[GuardLimits],
    ) -> Result<PlanSpecification, String> {
        let plan = self.database.plan(plan_id).ok_or_else(|| format!("there is no plan '{plan_id}'"))?;
        // The first corner is where the vessel was when it asked, unless the route starts elsewhere.
        let corners =
            if route.start_moved { &route.places[..] } else { route.places.get(1..).unwrap_or_default() };
        let led = led_by(&plan, corners);
        self.may_be_sailed(&led, from, corners, if route.start_moved { ways_out } else { &[] })?;
        Ok(led)
    }

    /// The energy that a plan takes from the batteries from a place on, as far as known before it is sailed (Wh): up to a
    /// maneuver without end, such as keeping a station.
    pub(crate) fn energy_wh(&self, bus: &Bus, plan: &PlanSpecification, from: LatLon) -> f64 {
        let Ok(plan) = checked_own(plan, &self.settings) else { return 0.0 };
        let model = &self.settings.mission.engine.model;
        let statistics = PlanStatistics::of(&plan, Some(from), bus.now(), model);
        let known = statistics.maneuvers.iter().map_while(|(_, cost)| cost.energy_j);
        known.sum::<f64>() / JOULES_PER_WH
    }

    /// Starts a plan led by a route, on the vessel's own account.
    ///
    /// # Errors
    /// Why the engine does not take it.
    pub(crate) fn start_led(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        led: PlanSpecification,
        in_need: bool,
    ) -> Result<RunId, String> {
        let before = self.plan_state.run;
        self.own_refusal = None;
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: led.plan_id.clone(),
            flags: if in_need { PlanControlFlags::IGNORE_ERRORS } else { PlanControlFlags::empty() },
            arg: Message::from(led).into(),
            ..PlanControl::default()
        };
        let own = Asker { system: bus.address(), entity: Entity::Supervisor.number() };
        (self.starts_own, self.starts_routed) = (true, true);
        self.control(bus, pilot, own, "the vessel itself", &request);
        (self.starts_own, self.starts_routed) = (false, false);
        self.begun_since(before)
    }

    /// Sends the plan under way again if it is the vessel's own: a console that missed it does not know the route.
    pub(crate) fn tell_own_again(&self, bus: &mut Bus) {
        let run = self.plan_state.run.filter(|run| self.own_run == Some(*run));
        if let Some(plan) = run.and_then(|run| self.runs.get(&run)) {
            bus.send(Entity::PlanEngine, plan);
        }
    }

    /// Why the plan under way may not continue from here by chart and area, if it was started on the vessel's own account:
    /// judged is what lies ahead.
    pub(crate) fn own_way_refused(&self, from: LatLon) -> Option<String> {
        let run = self.plan_state.run.filter(|run| self.own_run == Some(*run))?;
        let maneuver = self.plan_state.maneuver.as_ref().map(|(id, _)| id.as_str()).unwrap_or_default();
        let rest = rest_from(self.runs.get(&run)?, maneuver);
        self.may_be_sailed(&rest, from, &[], &[]).err()
    }

    /// Whether guard and area let the vessel sail a plan led by a route from where it is.
    fn may_be_sailed(
        &self,
        plan: &PlanSpecification,
        from: LatLon,
        corners: &[LatLon],
        ways_out: &[GuardLimits],
    ) -> Result<(), String> {
        let limits = self.settings.guard_limits();
        let checked = checked_own(plan, &self.settings).map_err(|problems| problems.to_string())?;
        let start = match (corners.first(), &chart::of_waters(&self.settings)) {
            (Some(first), WaterChart::Loaded(index, _)) if !ways_out.is_empty() => {
                let way = |limits: &GuardLimits| {
                    check_way("the way back to deep water", from, *first, index, limits)
                };
                // Looser limits lead out of water that the guard refuses already, and never into it.
                let is_stuck = check_way("here", from, from, index, &limits).reason.is_some();
                let ways_out = if is_stuck { ways_out } else { std::slice::from_ref(&limits) };
                if ways_out.iter().all(|limits| way(limits).reason.is_some()) {
                    return Err(way(&limits).to_string());
                }
                *first
            }
            _ => from,
        };
        chart::refusal(&self.settings, &checked, Some(start), &limits)?;
        // Without a route before it nothing leads back into the area: the plan has to do that itself.
        if corners.is_empty() {
            return Ok(());
        }
        let waters = Waters { area: self.settings.mission.limits.area.clone(), chart: WaterChart::Off };
        // A vessel outside has left the area already: it is led back in, and stays inside from there on.
        let way: Vec<LatLon> = std::iter::once(from).chain(corners.iter().copied()).collect();
        let outside = way.iter().take_while(|place| waters.place(**place).is_err()).count();
        if outside > 0 {
            let back_m: f64 = way.windows(2).take(outside).map(|leg| length_m(leg[0], leg[1])).sum();
            if outside == way.len() || back_m > OUTSIDE_M {
                return Err(format!(
                    "the first {back_m:.0} m of the route lie outside the area of operation; at most {OUTSIDE_M:.0} m are allowed"
                ));
            }
        }
        way[outside..].windows(2).try_for_each(|leg| waters.way(leg[0], leg[1]))
    }
}

fn length_m(from: LatLon, to: LatLon) -> f64 {
    let LocalPoint { north_m, east_m } = LocalFrame::new(from).to_local(to);
    north_m.hypot(east_m)
}

/// The reason why a leg is refused, in a word or two.
fn word(reason: Reason) -> &'static str {
    match reason {
        Reason::Land => "land",
        Reason::TooShallow | Reason::TooShallowAlone => "shallow water",
        Reason::NoData => "uncharted water",
        Reason::Entry(_) => "a closed area",
        Reason::Obstacle | Reason::UnknownDepth | Reason::TooLow => "a danger",
    }
}

/// The plan with a maneuver for each corner before its first.
fn led_by(plan: &PlanSpecification, corners: &[LatLon]) -> PlanSpecification {
    let nodes: Vec<PlanManeuver> = plan.maneuvers.of().collect();
    let first = nodes.iter().find(|node| node.maneuver_id == plan.start_man_id);
    let (speed, speed_units) =
        first.and_then(|node| speed_of(&node.data.get()?)).unwrap_or((SPEED_MPS, SpeedUnits::MetersPs));
    let mut name = "route".to_owned();
    while nodes.iter().any(|node| node.maneuver_id.to_str_lossy().starts_with(&name)) {
        name.push('_');
    }
    let names: Vec<String> = (1..=corners.len()).map(|number| format!("{name} {number}")).collect();
    let legs = names.iter().zip(corners).map(|(name, corner)| {
        let (lat, lon) = (corner.lat_rad(), corner.lon_rad());
        let goto = Goto { lat, lon, z_units: ZUnits::Depth, speed, speed_units, ..Goto::default() };
        PlanManeuver {
            maneuver_id: name.as_str().into(),
            data: Message::from(goto).into(),
            ..PlanManeuver::default()
        }
    });
    let next = names.iter().skip(1).map(|name| name.as_str().into()).chain([plan.start_man_id.clone()]);
    let ways = names.iter().zip(next).map(|(from, to)| PlanTransition {
        source_man: from.as_str().into(),
        dest_man: to,
        ..PlanTransition::default()
    });
    PlanSpecification {
        start_man_id: names.first().map_or_else(|| plan.start_man_id.clone(), |name| name.as_str().into()),
        maneuvers: legs.chain(nodes.iter().cloned()).collect(),
        transitions: ways.chain(plan.transitions.of::<PlanTransition>()).collect(),
        ..plan.clone()
    }
}

fn speed_of(maneuver: &Message) -> Option<(f32, SpeedUnits)> {
    Some(match maneuver {
        Message::Goto(m) => (m.speed, m.speed_units),
        Message::Launch(m) => (m.speed, m.speed_units),
        Message::Loiter(m) => (m.speed, m.speed_units),
        Message::StationKeeping(m) => (m.speed, m.speed_units),
        Message::FollowPath(m) => (m.speed, m.speed_units),
        Message::FollowTrajectory(m) => (m.speed, m.speed_units),
        Message::Rows(m) => (m.speed, m.speed_units),
        Message::RowsCoverage(m) => (m.speed, m.speed_units),
        _ => return None,
    })
}
