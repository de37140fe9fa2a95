//! Plans on their way between consoles, the mission's engine and the pilot.
//!
//! Requests (PlanControl, PlanDB) become questions to the engine and the database; what the engine wants
//! becomes commands to the pilot and the exchange of messages that DUNE's consoles know from DUNE's tasks
//! `Plan.Engine` and `Plan.DB`. Judge the running state by PlanControlState; replies are events.

mod chart;
mod database;
mod notes;
mod requests;
mod routed;
pub(crate) mod translate;
mod ways;
mod wire;

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::{Level, Output};
use crate::pilot::{Pilot, PilotEvent};
use crate::settings::Settings;
use control::{Loiter, PathCommand, PathEnd};
use database::Database;
pub use database::{LONGEST_NAME, LONGEST_PLAN};
use guard::Waters;
use imc::messages::{
    Aborted, LoggingControl, LoggingControlOp, ManeuverControlState, ManeuverControlStateState, Message,
    PlanControl, PlanControlFlags, PlanControlOp, PlanControlType, PlanManeuver, PlanSpecification,
    VehicleCommand, VehicleCommandCommand, VehicleCommandType,
};
use imc::{Address, Nested};
use mission::{
    ActionPoint, Command, Engine, EngineConfig, Event, Kept, ManeuverEnd, NoteLevel, Operation, PathProgress,
    PathStart, Plan, PlanDraft, PlanLimits, PlanProblems, PlanState, Reply, RunId, Success, Ticket,
};
pub(crate) use requests::reads;
pub(crate) use routed::{Behind, NotStarted};
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use units::{LatLon, MonoTime};

/// Runs remembered for their specification; the engine has one at a time and perhaps the previous one.
const RUNS_KEPT: usize = 4;

/// A plan as a vessel with these settings would sail it.
///
/// # Errors
/// All that keeps it from being sailed.
pub fn checked(plan: &PlanSpecification, settings: &Settings) -> Result<Plan, PlanProblems> {
    built(plan, settings, &settings.mission.limits)
}

/// A plan of the vessel's own: out of need it may lead anywhere, also from outside the area back into it.
fn checked_own(plan: &PlanSpecification, settings: &Settings) -> Result<Plan, PlanProblems> {
    built(plan, settings, &PlanLimits { area: None, ..settings.mission.limits.clone() })
}

fn built(plan: &PlanSpecification, settings: &Settings, limits: &PlanLimits) -> Result<Plan, PlanProblems> {
    let notes = notes::notes(plan, settings);
    let draft = PlanDraft { notes, ..translate::draft(plan) };
    Plan::build(&draft, limits)
}

/// A plan under way that the chart would refuse.
#[derive(Debug)]
pub(crate) struct RefusedPlan {
    pub(crate) run: RunId,
    pub(crate) plan_id: String,
    pub(crate) why: String,
}

/// A plan that failed.
#[derive(Debug)]
pub(crate) struct Failed {
    pub(crate) plan_id: String,
    pub(crate) why: String,
}

/// Plans and the vehicle's modes.
#[derive(Debug)]
pub(crate) struct Plans {
    engine: Engine,
    database: Database,
    /// The settings that plans are checked against.
    settings: Box<Settings>,
    /// The plan of the start in hand, until the engine gives it a number.
    starting: Option<PlanSpecification>,
    /// The plan that ended last, if it failed and that has not been handled.
    failed: Option<Failed>,
    /// The last run on the vessel's own account, and whether one is being started.
    own_run: Option<RunId>,
    starts_own: bool,
    /// A plan is being resumed.
    resumes: bool,
    /// A plan led by a route is being started, which was checked just now.
    starts_routed: bool,
    /// Why starts from outside are still refused.
    pub(crate) unready: Option<String>,
    /// Why the last start on the vessel's own account failed.
    own_refusal: Option<String>,
    runs: BTreeMap<RunId, PlanSpecification>,
    plan_state: PlanState,
    vehicle_state: mission::VehicleState,
    engine_period: Duration,
    supervisor_period: Duration,
    next_engine: MonoTime,
    next_supervisor: MonoTime,
    next_maneuver: MonoTime,
    command_id: u16,
    /// The way that a maneuver requested.
    way: Option<ways::Search>,
    /// The last reference, and who gave it.
    reference: Option<(u16, u8, Message)>,
    /// Messages of plans to be acted upon as if they had been sent.
    actions: VecDeque<Message>,
}

impl Plans {
    /// The engine with the plans that were kept.
    pub(crate) fn new(settings: &Settings, bus: &mut Bus, kept: Kept) -> Self {
        let (database, unreadable) = Database::new(kept);
        for id in unreadable {
            bus.entry(Entity::PlanDatabase, Level::Error, format!("the plan kept as '{id}' cannot be read"));
        }
        let period = |hz: f64| Duration::from_secs_f64(1.0 / hz.clamp(0.1, 10.0));
        let now = bus.mono();
        Self {
            engine: Engine::new(engine_config(settings)),
            database,
            settings: Box::new(settings.clone()),
            starting: None,
            failed: None,
            own_run: None,
            starts_own: false,
            resumes: false,
            starts_routed: false,
            unready: None,
            own_refusal: None,
            runs: BTreeMap::new(),
            plan_state: PlanState::default(),
            vehicle_state: mission::VehicleState::default(),
            engine_period: period(settings.mission.engine_report_hz),
            supervisor_period: period(settings.mission.supervisor_report_hz),
            next_engine: now,
            next_supervisor: now,
            next_maneuver: now,
            command_id: 0,
            way: None,
            reference: None,
            actions: VecDeque::new(),
        }
    }

    /// Other parameters, from here on.
    pub(crate) fn reconfigure(&mut self, settings: &Settings) {
        *self.settings = settings.clone();
        self.engine.reconfigure(engine_config(settings));
    }

    /// The state of the plan engine, and which plan runs.
    pub(crate) fn plan_state(&self) -> &PlanState {
        &self.plan_state
    }

    /// The vessel's mode.
    pub(crate) fn mode(&self) -> mission::Mode {
        self.vehicle_state.mode
    }

    /// The plan under way, if the chart in force would refuse it. The way to its first maneuver counts from `place` as
    /// long as it leads there, and not any more after that.
    pub(crate) fn refused_under_way(&self, bus: &mut Bus, place: Option<LatLon>) -> Option<RefusedPlan> {
        let run = self.plan_state.run?;
        let plan = checked(self.runs.get(&run)?, &self.settings).ok()?;
        let first = plan.node(plan.start()).map(mission::Node::id);
        let begins = self.plan_state.maneuver.as_ref().is_none_or(|(id, _)| Some(&id[..]) == first);
        let from = if begins { place } else { None };
        let why = chart::check(&self.settings, bus, &plan, from).err()?;
        Some(RefusedPlan { run, plan_id: plan.id().to_owned(), why })
    }

    /// The plan of a run.
    pub(crate) fn plan_of(&self, run: RunId) -> Option<&PlanSpecification> {
        self.runs.get(&run)
    }

    /// The plan that ended last, if it failed and that has not been handled.
    pub(crate) fn take_failed(&mut self) -> Option<Failed> {
        self.failed.take()
    }

    /// Puts that failure back to be handled, unless another came since.
    pub(crate) fn failed_before(&mut self, failed: Failed) {
        self.failed.get_or_insert(failed);
    }

    /// Whether the plan that ended last failed and that has not been handled.
    pub(crate) fn has_failed(&self) -> bool {
        self.failed.is_some()
    }

    /// Whether a plan of this name is kept.
    pub(crate) fn has(&self, id: &str) -> bool {
        self.database.plan(id).is_some()
    }

    /// A change of the plans is on the disk, or not.
    pub(crate) fn stored(&mut self, bus: &mut Bus, ticket: Ticket, outcome: Result<(), String>) {
        self.database.stored(bus, ticket, outcome);
    }

    /// The next message of a plan to be acted upon.
    pub(crate) fn poll_action(&mut self) -> Option<Message> {
        self.actions.pop_front()
    }

    pub(crate) fn poll_timeout(&self) -> MonoTime {
        let own = self.next_engine.min(self.next_supervisor);
        self.engine.poll_timeout().map_or(own, |engine| engine.min(own))
    }

    /// The program was stalled; that path control was silent meanwhile is not a fault.
    pub(crate) fn held_up(&mut self, bus: &Bus) {
        self.engine.held_up(bus.mono());
    }

    /// Gives the engine an input and carries out its outputs.
    pub(crate) fn tell(&mut self, bus: &mut Bus, pilot: &mut Pilot, input: mission::Input) {
        self.engine.handle_input(bus.now(), input);
        self.drain(bus, pilot);
    }

    /// Gives the engine the events of steering, until there are no more.
    pub(crate) fn follow_up(&mut self, bus: &mut Bus, pilot: &mut Pilot) {
        while let Some(event) = pilot.poll_event() {
            let event = match event {
                PilotEvent::Path(status) => Event::Path(PathProgress {
                    path_ref: status.path_ref,
                    near: status.near,
                    loitering: status.loitering,
                    left_m: status.left_m,
                    cross_m: status.geometry.cross_m(),
                    eta_s: f64::from(status.eta_s),
                }),
                PilotEvent::Failed { path_ref, reason } => Event::PathFailed { path_ref, reason },
                PilotEvent::Exit { from } => Event::TeleoperationDone { from },
            };
            self.tell(bus, pilot, mission::Input::Event(event));
        }
    }

    /// Whatever falls due: the engine's deadlines and the regular reports.
    pub(crate) fn tick(&mut self, bus: &mut Bus, pilot: &mut Pilot) {
        let now = bus.mono();
        if self.engine.poll_timeout().is_some_and(|due| due <= now) {
            self.engine.handle_timeout(bus.now());
            self.drain(bus, pilot);
        }
        if now >= self.next_engine {
            self.next_engine = now + self.engine_period;
            self.plan_state = self.engine.plan_state(bus.now());
            bus.send(Entity::PlanEngine, &wire::plan_state(&self.plan_state));
        }
        if now >= self.next_supervisor {
            self.next_supervisor = now + self.supervisor_period;
            self.vehicle_state = self.engine.vehicle_state(bus.now());
            bus.send(Entity::Supervisor, &wire::vehicle_state(&self.vehicle_state, pilot.loops()));
        }
        if now >= self.next_maneuver {
            self.next_maneuver = now + Duration::from_secs(1);
            if self.vehicle_state.maneuver.is_some() {
                let eta = wire::vehicle_state(&self.vehicle_state, pilot.loops()).maneuver_eta;
                let state = ManeuverControlState {
                    state: ManeuverControlStateState::Executing,
                    eta,
                    ..ManeuverControlState::default()
                };
                bus.send(Entity::Maneuver, &state);
            }
        }
    }

    fn drain(&mut self, bus: &mut Bus, pilot: &mut Pilot) {
        while let Some(output) = self.engine.poll_output() {
            self.carry_out(bus, pilot, output);
        }
    }

    fn carry_out(&mut self, bus: &mut Bus, pilot: &mut Pilot, output: mission::Output) {
        match output {
            mission::Output::Command(command) => self.command(bus, pilot, &command),
            mission::Output::Reply(reply) => self.reply(bus, &reply),
            mission::Output::PlanBegins { run, plan_id } => self.begin(bus, run, &plan_id),
            mission::Output::LookForWay { from, to } => self.look_for_way(bus, from, to),
            mission::Output::PlanEnded { run, plan_id, reason } => {
                self.give_up_way(bus, &plan_id);
                open_log(bus, "");
                // A failed remedy is handled by its supervisor.
                let failed = reason.is_failure() && self.own_run != Some(run);
                self.failed = failed.then(|| Failed { plan_id, why: reason.to_string() });
            }
            mission::Output::Actions { run, point } => self.act(run, &point),
            mission::Output::Calibrate(span) => {
                let text = format!("calibrating for {} s", span.as_secs());
                bus.entry(Entity::Supervisor, Level::Info, text);
            }
            mission::Output::ManeuverBegins { run, id, .. } => self.maneuver_begins(bus, run, &id),
            mission::Output::ManeuverEnded { end, .. } => {
                let (state, info) = match end {
                    ManeuverEnd::Done => (ManeuverControlStateState::Done, String::new()),
                    ManeuverEnd::Failed(reason) => (ManeuverControlStateState::Error, reason),
                    ManeuverEnd::Stopped => (ManeuverControlStateState::Stopped, String::new()),
                };
                bus.send(Entity::Maneuver, &ManeuverControlState { state, eta: 0, info: info.into() });
            }
            mission::Output::Reference(state) => {
                let (system, entity, message) = match &self.reference {
                    Some((system, entity, message)) => (*system, *entity, Some(message.clone())),
                    None => (0xFFFF, 0xFF, None),
                };
                bus.send(Entity::Maneuver, &wire::reference_state(&state, (system, entity), message));
            }
            mission::Output::PlanState(state) => {
                self.plan_state = *state;
                bus.send(Entity::PlanEngine, &wire::plan_state(&self.plan_state));
            }
            mission::Output::VehicleState(state) => {
                self.vehicle_state = *state;
                bus.send(Entity::Supervisor, &wire::vehicle_state(&self.vehicle_state, pilot.loops()));
            }
            mission::Output::Aborted { .. } => bus.send(Entity::Supervisor, &Aborted),
            mission::Output::Note(note) => {
                let level = match note.level {
                    NoteLevel::Info => Level::Info,
                    NoteLevel::Warning => Level::Warning,
                    NoteLevel::Error => Level::Error,
                };
                bus.entry(Entity::PlanEngine, level, note.text);
            }
        }
    }

    fn command(&mut self, bus: &mut Bus, pilot: &mut Pilot, command: &Command) {
        match command {
            Command::Drift => pilot.drift(bus),
            Command::ChangeSpeed(speed) => pilot.change_speed(bus, *speed),
            Command::Teleoperate(operator) => pilot.teleoperate(bus, *operator),
            Command::Follow(path) => {
                let loiter =
                    path.circle.map(|circle| Loiter { radius_m: circle.radius_m, turn: circle.turn });
                let start = match path.start {
                    PathStart::Chained => control::PathStart::Chained,
                    PathStart::Here => control::PathStart::Here,
                    PathStart::At(place) => control::PathStart::At(place),
                };
                let end = PathEnd::At(path.end);
                let wanted = PathCommand { path_ref: path.path_ref, start, end, loiter };
                if let Err(failure) = pilot.follow(bus, &wanted, path.speed) {
                    let event = Event::PathFailed { path_ref: path.path_ref, reason: failure.to_string() };
                    let now = bus.now();
                    // The engine's outputs are handled by the loop that called this.
                    self.engine.handle_input(now, mission::Input::Event(event));
                }
            }
        }
    }

    fn begin(&mut self, bus: &mut Bus, run: RunId, plan_id: &str) {
        open_log(bus, plan_id);
        if self.starts_own {
            self.own_run = Some(run);
        }
        if let Some(plan) = self.starting.take() {
            bus.send(Entity::PlanEngine, &plan);
            self.runs.insert(run, plan);
            while self.runs.len() > RUNS_KEPT {
                self.runs.pop_first();
            }
        }
    }

    /// The messages between DUNE's engine and supervisor at a new maneuver.
    fn maneuver_begins(&mut self, bus: &mut Bus, run: RunId, id: &str) {
        self.command_id = self.command_id.wrapping_add(1);
        let plan = self.runs.get(&run);
        let node =
            plan.and_then(|plan| plan.maneuvers.of::<PlanManeuver>().find(|node| node.maneuver_id == id));
        let request = VehicleCommand {
            r#type: VehicleCommandType::Request,
            request_id: self.command_id,
            command: VehicleCommandCommand::ExecManeuver,
            maneuver: node.map(|node| node.data).unwrap_or_default(),
            ..VehicleCommand::default()
        };
        bus.send(Entity::PlanEngine, &request);
        let done =
            VehicleCommand { r#type: VehicleCommandType::Success, maneuver: Nested::none(), ..request };
        bus.send(Entity::Supervisor, &done);
    }

    fn act(&mut self, run: RunId, point: &ActionPoint) {
        let Some(plan) = self.runs.get(&run) else { return };
        let node = |id: &str| plan.maneuvers.of::<PlanManeuver>().find(|node| node.maneuver_id == *id);
        let list = match point {
            ActionPoint::PlanStart => Some(plan.start_actions.clone()),
            ActionPoint::PlanEnd => Some(plan.end_actions.clone()),
            ActionPoint::ManeuverStart(id) => node(id).map(|node| node.start_actions),
            ActionPoint::ManeuverEnd(id) => node(id).map(|node| node.end_actions),
            ActionPoint::Transition { from, to } => plan
                .transitions
                .of::<imc::messages::PlanTransition>()
                .find(|transition| transition.source_man == **from && transition.dest_man == **to)
                .map(|transition| transition.actions),
        };
        self.actions.extend(list.unwrap_or_default().iter().flatten());
    }

    fn reply(&mut self, bus: &mut Bus, reply: &Reply) {
        let Reply { origin, operation, plan_id, result } = reply;
        let (kind, info, arg) = match result {
            Ok(success) => {
                let arg = match success {
                    Success::Loaded(statistics) => {
                        Some(wire::statistics(statistics, self.settings.mission.capacity_wh).into())
                    }
                    Success::Running(run) => self.runs.get(run).cloned().map(Message::from),
                    Success::Executing { .. } | Success::Completed | Success::Stopped => None,
                };
                (PlanControlType::Success, success.to_string(), arg)
            }
            Err(failure) => {
                if *operation == Operation::Start && origin.system == bus.address().0 {
                    self.own_refusal = Some(failure.to_string());
                }
                (PlanControlType::Failure, failure.to_string(), None)
            }
        };
        let message = PlanControl {
            r#type: kind,
            op: match operation {
                Operation::Start => PlanControlOp::Start,
                Operation::Stop => PlanControlOp::Stop,
                Operation::Load => PlanControlOp::Load,
                Operation::Get => PlanControlOp::Get,
            },
            request_id: origin.request,
            plan_id: plan_id.as_str().into(),
            flags: PlanControlFlags::empty(),
            arg: arg.into(),
            info: info.as_str().into(),
        };
        bus.console(Level::Debug, format!("Plan Engine: '{plan_id}': {info}"));
        let asker = Asker { system: Address(origin.system), entity: origin.entity };
        bus.send_to(Entity::PlanEngine, asker, &message);
    }
}

/// The engine's parameters, with the labels of vital entities.
fn engine_config(settings: &Settings) -> EngineConfig {
    let vital = settings.watch.vital.iter().map(|entity| settings.labels.of(*entity).to_owned()).collect();
    let bridged = [Entity::Gps, Entity::Navigation, Entity::Path];
    let bridged = bridged.map(|entity| settings.labels.of(entity).to_owned()).into();
    let waters = Waters { area: settings.mission.limits.area.clone(), chart: chart::of_waters(settings) };
    let mut config = EngineConfig { vital, bridged, waters, ..settings.mission.engine.clone() };
    config.maneuver.reference.routes_around = settings.grounding.routes.around;
    config
}

/// Asks for a new log as DUNE's engine does, and has it opened.
fn open_log(bus: &mut Bus, label: &str) {
    let request = LoggingControl { op: LoggingControlOp::RequestStart, name: label.into() };
    bus.send(Entity::PlanEngine, &request);
    let utc = bus.utc();
    bus.put(Output::OpenLog { label: label.to_owned(), utc });
}
