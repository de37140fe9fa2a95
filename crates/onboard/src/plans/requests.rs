//! Requests of other systems about plans.

use super::{Plans, chart, translate};
use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::grounding::Chart;
use crate::output::Level;
use crate::pilot::Pilot;
use guard::GuardLimits;
use imc::messages::{
    Announce, Message, PlanControl, PlanControlFlags, PlanControlOp, PlanControlType, PlanDB, PlanDBOp,
    PlanDBType, PlanSpecification, Reference,
};
use mission::{Event, NoPlan, Origin, Plan, PlanPhase, Request, RequestKind, RunId, Sighting, StartOptions};
use units::LatLon;

/// Where a plan would begin.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// Here, if the vessel knows where it is.
    From(Option<LatLon>),
    /// A maneuver of the vessel's own as a remedy: it is checked neither against chart nor area. One that a route leads to
    /// was checked against both.
    Own,
}

impl Plans {
    /// Another system says where it is.
    pub(crate) fn sighted(&mut self, bus: &mut Bus, pilot: &mut Pilot, asker: Asker, announce: &Announce) {
        let Ok(place) = LatLon::from_rad(announce.lat, announce.lon) else { return };
        let afloat = !asker.system.is_ccu();
        let sighting = Sighting { system: asker.system.0, place, afloat };
        self.tell(bus, pilot, mission::Input::Event(Event::Sighting(sighting)));
    }

    /// A request to the plan database.
    pub(crate) fn database(&mut self, bus: &mut Bus, asker: Asker, name: &str, request: &PlanDB) {
        let specification = request.arg.of::<PlanSpecification>();
        let stores = request.r#type == PlanDBType::Request && request.op == PlanDBOp::Set;
        if let Some(specification) = specification.filter(|_| stores)
            && let Err(info) = self.may_be_stored(bus, &specification)
        {
            let plan_id = request.plan_id.to_str_lossy();
            let text = format!("'{plan_id}' is not stored: refused by the sea chart: {info}");
            bus.entry_to(Entity::Grounding, asker, Level::Warning, text);
            self.database.refuse(bus, asker, request, format!("refused by the sea chart: {info}"));
            return;
        }
        self.database.request(bus, asker, name, request);
    }

    /// Whether the chart has water for a plan. One that cannot be sailed for other reasons is stored all the
    /// same, as DUNE does; it is refused at its start.
    fn may_be_stored(&self, bus: &mut Bus, specification: &PlanSpecification) -> Result<(), String> {
        if self.settings.grounding.chart == Chart::Off {
            return Ok(());
        }
        let draft = translate::draft(specification);
        match Plan::build(&draft, &self.settings.mission.limits) {
            Ok(plan) => chart::check(&self.settings, bus, &plan, None),
            Err(_) => Ok(()),
        }
    }

    /// A request to the plan engine.
    pub(crate) fn control(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        asker: Asker,
        name: &str,
        request: &PlanControl,
    ) {
        if request.r#type != PlanControlType::Request {
            return;
        }
        let plan_id = request.plan_id.to_str_lossy().into_owned();
        let (verb, ask) = match request.op {
            PlanControlOp::Start => {
                let own = asker.system == bus.address();
                let is_maneuver = || request.arg.get().is_some_and(|arg| translate::is_maneuver(&arg));
                let own_maneuver = own && (self.starts_routed || is_maneuver());
                let way = if own_maneuver { Way::Own } else { Way::From(pilot.place()) };
                let plan = match &self.unready {
                    Some(why) if !(own || self.starts_own || self.resumes) => {
                        Err(NoPlan::NotArmed(why.clone()))
                    }
                    _ => self.plan(bus, name, &plan_id, request.arg.get(), way),
                };
                let options = StartOptions {
                    calibrate: request.flags.contains(PlanControlFlags::CALIBRATE),
                    ignore_errors: request.flags.contains(PlanControlFlags::IGNORE_ERRORS),
                };
                ("start", RequestKind::Start { plan, options })
            }
            PlanControlOp::Load => {
                let plan = self.plan(bus, name, &plan_id, request.arg.get(), Way::From(pilot.place()));
                ("load", RequestKind::Load { plan })
            }
            PlanControlOp::Stop => ("stop", RequestKind::Stop),
            PlanControlOp::Get => ("get", RequestKind::Get),
            PlanControlOp::Unlisted(_) => return,
        };
        let who = if name.is_empty() { asker.system.to_string() } else { name.to_owned() };
        bus.entry(Entity::PlanEngine, Level::Info, format!("request {verb} '{plan_id}' by {who}"));
        let origin = Origin { system: asker.system.0, entity: asker.entity, request: request.request_id };
        self.tell(bus, pilot, mission::Input::Request(Request { origin, plan_id, ask }));
        self.starting = None;
    }

    /// Starts a plan of the database, or a maneuver, on the vessel's own account; in need, in spite of errors of parts.
    ///
    /// # Errors
    /// Why it failed.
    pub(crate) fn start_own(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        plan_id: &str,
        message: Option<Message>,
        in_need: bool,
    ) -> Result<RunId, String> {
        let before = self.plan_state.run;
        self.own_refusal = None;
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: plan_id.into(),
            flags: if in_need { PlanControlFlags::IGNORE_ERRORS } else { PlanControlFlags::empty() },
            arg: message.into(),
            ..PlanControl::default()
        };
        let own = Asker { system: bus.address(), entity: Entity::Supervisor.number() };
        self.starts_own = true;
        self.control(bus, pilot, own, "the vessel itself", &request);
        self.starts_own = false;
        self.begun_since(before)
    }

    /// Resumes a plan that was under way when the program ended.
    ///
    /// # Errors
    /// Why it failed.
    pub(crate) fn resume(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        plan: PlanSpecification,
    ) -> Result<RunId, String> {
        let before = self.plan_state.run;
        self.own_refusal = None;
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: plan.plan_id.clone(),
            arg: Message::from(plan).into(),
            ..PlanControl::default()
        };
        let own = Asker { system: bus.address(), entity: Entity::Supervisor.number() };
        self.resumes = true;
        self.control(bus, pilot, own, "the vessel itself", &request);
        self.resumes = false;
        self.begun_since(before)
    }

    pub(super) fn begun_since(&mut self, before: Option<RunId>) -> Result<RunId, String> {
        let run = self.plan_state.run.filter(|run| Some(*run) != before);
        run.ok_or_else(|| self.own_refusal.take().unwrap_or_else(|| "the plan engine refuses".to_owned()))
    }

    /// Whether the chart has water for a maneuver of the vessel's own, from a place on, by these limits.
    ///
    /// # Errors
    /// Why not.
    pub(crate) fn may_lead(
        &self,
        maneuver: Message,
        from: LatLon,
        limits: &GuardLimits,
    ) -> Result<(), String> {
        let specification = translate::quick_plan("way", maneuver);
        let plan = super::checked_own(&specification, &self.settings).map_err(|error| error.to_string())?;
        chart::refusal(&self.settings, &plan, Some(from), limits)
    }

    /// Stops whatever runs, on the vessel's own account.
    pub(crate) fn stop_own(&mut self, bus: &mut Bus, pilot: &mut Pilot) {
        if !matches!(self.plan_state.phase, PlanPhase::Initializing | PlanPhase::Executing) {
            return;
        }
        let request = PlanControl { op: PlanControlOp::Stop, ..PlanControl::default() };
        let own = Asker { system: bus.address(), entity: Entity::Supervisor.number() };
        self.control(bus, pilot, own, "the vessel itself", &request);
    }

    /// A commander's reference.
    pub(crate) fn reference(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        asker: Asker,
        reference: &Reference,
    ) {
        let event = translate::reference(asker.system.0, asker.entity, reference);
        self.reference = Some((asker.system.0, asker.entity, reference.clone().into()));
        self.tell(bus, pilot, mission::Input::Event(Event::Reference(event)));
    }

    /// The plan a request is about, from its argument or from the database.
    fn plan(
        &mut self,
        bus: &mut Bus,
        name: &str,
        plan_id: &str,
        arg: Option<Message>,
        way: Way,
    ) -> Result<Box<Plan>, NoPlan> {
        let mut came = false;
        let specification: PlanSpecification = match arg {
            None => self.database.plan(plan_id).ok_or(NoPlan::Undefined)?,
            Some(Message::PlanSpecification(plan)) => {
                // One that resumes is the rest of a plan only, one led by a route more than it.
                came = plan.plan_id == *plan_id && !self.resumes && !self.starts_routed;
                *plan
            }
            Some(message) if translate::is_maneuver(&message) => translate::quick_plan(plan_id, message),
            Some(message) => {
                let what = format!("{} is neither a plan nor a maneuver", message.abbrev());
                return Err(NoPlan::Unreadable(what));
            }
        };
        let plan = match way {
            Way::From(_) => super::checked(&specification, &self.settings)?,
            Way::Own => super::checked_own(&specification, &self.settings)?,
        };
        if let Way::From(from) = way {
            chart::check(&self.settings, bus, &plan, from).map_err(NoPlan::Grounding)?;
        }
        // A broken plan does not take the place of a good one that is stored.
        if came {
            self.database.keep_started(bus, name, &specification);
        }
        self.starting = Some(specification);
        Ok(Box::new(plan))
    }
}

/// Whether an operation on the plan database changes nothing.
pub(crate) fn reads(op: PlanDBOp) -> bool {
    matches!(op, PlanDBOp::Get | PlanDBOp::GetInfo | PlanDBOp::GetState | PlanDBOp::GetDstate)
}
