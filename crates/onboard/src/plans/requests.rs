//! What others ask about plans.

use super::{Plans, translate};
use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::Level;
use crate::pilot::Pilot;
use imc::messages::{
    Message, PlanControl, PlanControlFlags, PlanControlOp, PlanControlType, PlanDB, PlanSpecification,
    Reference,
};
use mission::{Ask, Event, NoPlan, Origin, Plan, PlanPhase, Request, StartOptions};

impl Plans {
    /// A request to the plan database.
    pub(crate) fn database(&mut self, bus: &mut Bus, asker: Asker, name: &str, request: &PlanDB) {
        self.database.request(bus, asker, name, request);
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
                let plan = self.plan(bus, name, &plan_id, request.arg.get());
                let options = StartOptions {
                    calibrate: request.flags.contains(PlanControlFlags::CALIBRATE),
                    ignore_errors: request.flags.contains(PlanControlFlags::IGNORE_ERRORS),
                };
                ("start", Ask::Start { plan, options })
            }
            PlanControlOp::Load => {
                let plan = self.plan(bus, name, &plan_id, request.arg.get());
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
        self.starting = Some(specification);
        Ok(Box::new(plan))
    }
}
