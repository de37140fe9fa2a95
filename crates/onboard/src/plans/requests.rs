//! What others ask about plans.

use super::{Plans, chart, translate};
use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::grounding::Chart;
use crate::output::Level;
use crate::pilot::Pilot;
use imc::messages::{
    Message, PlanControl, PlanControlFlags, PlanControlOp, PlanControlType, PlanDB, PlanDBOp, PlanDBType,
    PlanSpecification, Reference,
};
use mission::{Ask, Event, NoPlan, Origin, Plan, PlanPhase, Request, StartOptions};
use units::LatLon;

/// Where a plan would begin.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// Here, if the vessel knows where it is.
    From(Option<LatLon>),
    /// A maneuver of the vessel's own leads out of need: it is not held against the chart.
    Own,
}

impl Plans {
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
                let own_maneuver = asker.system == bus.address() && request.arg.get().is_some();
                let way = if own_maneuver { Way::Own } else { Way::From(pilot.place()) };
                let plan = self.plan(bus, name, &plan_id, request.arg.get(), way);
                let options = StartOptions {
                    calibrate: request.flags.contains(PlanControlFlags::CALIBRATE),
                    ignore_errors: request.flags.contains(PlanControlFlags::IGNORE_ERRORS),
                };
                ("start", Ask::Start { plan, options })
            }
            PlanControlOp::Load => {
                let plan = self.plan(bus, name, &plan_id, request.arg.get(), Way::From(pilot.place()));
                ("load", Ask::Load { plan })
            }
            PlanControlOp::Stop => ("stop", Ask::Stop),
            PlanControlOp::Get => ("get", Ask::Get),
            PlanControlOp::Unlisted(_) => return,
        };
        let who = if name.is_empty() { asker.system.to_string() } else { name.to_owned() };
        bus.entry(Entity::PlanEngine, Level::Info, format!("request {verb} '{plan_id}' by {who}"));
        let origin = Origin { system: asker.system.0, entity: asker.entity, request: request.request_id };
        self.tell(bus, pilot, mission::Input::Request(Request { origin, plan_id, ask }));
        self.starting = None;
    }

    /// Starts a plan of the database on the vessel's own account.
    pub(crate) fn start_own(
        &mut self,
        bus: &mut Bus,
        pilot: &mut Pilot,
        plan_id: &str,
        message: Option<Message>,
    ) {
        let request = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: plan_id.into(),
            flags: PlanControlFlags::IGNORE_ERRORS,
            arg: message.into(),
            ..PlanControl::default()
        };
        let own = Asker { system: bus.address(), entity: Entity::Supervisor.number() };
        self.control(bus, pilot, own, "the vessel itself", &request);
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
        let specification: PlanSpecification = match arg {
            None => self.database.plan(plan_id).ok_or(NoPlan::Undefined)?,
            Some(Message::PlanSpecification(plan)) => {
                if plan.plan_id == *plan_id {
                    self.database.keep_started(bus, name, &plan);
                }
                *plan
            }
            Some(message) if translate::is_maneuver(&message) => translate::quick_plan(plan_id, message),
            Some(message) => {
                let what = format!("{} is neither a plan nor a maneuver", message.abbrev());
                return Err(NoPlan::Unreadable(what));
            }
        };
        let plan = super::checked(&specification, &self.settings)?;
        if let Way::From(from) = way {
            chart::check(&self.settings, bus, &plan, from).map_err(NoPlan::Grounding)?;
        }
        self.starting = Some(specification);
        Ok(Box::new(plan))
    }
}
