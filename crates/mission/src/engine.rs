//! The plan engine and the vehicle's modes, in one machine.
//!
//! DUNE keeps a plan engine and a vehicle supervisor apart, with commands, replies, timeouts and queues
//! between them. Here a request is carried out while it is handled, so that none is ever pending: a start
//! replaces what runs, a stop stops it, and what takes time (calibration, maneuvers) has deadlines.
//!
//! Invariants: at most one maneuver is active; every [`Output::PlanBegins`] is followed by exactly one
//! [`Output::PlanEnded`] of the same run; whenever no plan runs, the last command was [`Command::Drift`].
//!
//! Deviations from DUNE on purpose: a start whose plan is not possible leaves a running plan alone; a stop with
//! nothing running leaves the last outcome alone; failures carry no statistics; references and silent path
//! control time out by the clock, not by the next fix; an abort blocks starts until the next entity report,
//! even those that ignore errors.

mod request;
mod run;
mod state;
mod vehicle;

pub use request::{
    EndReason, Failure, LastOutcome, NoPlan, Operation, Origin, Reply, Request, RequestKind, RunId,
    StartOptions, Success,
};
pub use state::{
    ActionPoint, ManeuverEnd, Mode, Note, NoteLevel, Output, PlanPhase, PlanState, VehicleState,
};
pub use vehicle::EntityCondition;

use crate::command::{Command, Drive};
use crate::event::{Event, Fix, Medium};
use crate::maneuver::{Context, ManeuverConfig, Outcome, Running, Signal};
use crate::plan::Plan;
use crate::statistics::{PlanStatistics, VehicleModel};
use guard::Waters;
use run::Run;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;
use units::{MonoTime, Now};
use vehicle::Vehicle;

/// The engine's input.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// A request about plans.
    Request(Request),
    /// An event that may concern the active maneuver.
    Event(Event),
    /// The conditions of all monitored entities, by label; replaces the previous report.
    Entities(BTreeMap<String, EntityCondition>),
    /// Whether the vessel knows where it is. While it does not, a plan waits with its motors stopped.
    Position {
        /// It does.
        known: bool,
    },
    /// An abort: everything stops.
    Abort {
        /// IMC id of the system that asked.
        by: u16,
    },
}

/// Parameters of the engine.
#[derive(Debug, Clone, PartialEq)]
pub struct EngineConfig {
    /// Of the maneuvers.
    pub maneuver: ManeuverConfig,
    /// The conversion of speeds, for statistics and progress.
    pub model: VehicleModel,
    /// How long to calibrate when a start asks for it; `None` ignores the wish.
    pub calibration: Option<Duration>,
    /// Labels of the entities whose errors end even plans that ignore errors.
    pub vital: BTreeSet<String>,
    /// Labels of the entities whose errors a running plan gets by other ways: those of the position by
    /// [`Input::Position`], that of path control by [`Event::PathFailed`]. They only keep plans from starting.
    pub bridged: BTreeSet<String>,
    /// Where maneuvers may go whose goals other systems set under way.
    pub waters: Waters,
    /// How long a plan waits for the position before it fails; zero fails at once.
    pub position_patience: Duration,
}

impl Default for EngineConfig {
    fn default() -> Self {
        Self {
            maneuver: ManeuverConfig::default(),
            model: VehicleModel::default(),
            calibration: Some(Duration::from_secs(3)),
            vital: BTreeSet::new(),
            bridged: BTreeSet::new(),
            waters: Waters::default(),
            position_patience: Duration::from_mins(2),
        }
    }
}

/// The plan engine. After every input and timeout its outputs are to be drained.
#[derive(Debug, Clone)]
pub struct Engine {
    config: EngineConfig,
    outputs: VecDeque<Output>,
    vehicle: Vehicle,
    run: Option<Run>,
    last_run: RunId,
    path_ref: u32,
    fix: Option<(MonoTime, Fix)>,
    /// Since when the position is not known, after it was.
    lost_since: Option<MonoTime>,
    medium: Medium,
    drive: Drive,
    last_plan_id: String,
    last_outcome: LastOutcome,
    /// The plan is begun but its first maneuver is not.
    initializing: bool,
}

impl Engine {
    /// A vehicle that boots.
    pub fn new(config: EngineConfig) -> Self {
        Self {
            vehicle: Vehicle::new(config.vital.clone()),
            config,
            outputs: VecDeque::new(),
            run: None,
            last_run: RunId::default(),
            path_ref: 0,
            fix: None,
            lost_since: None,
            medium: Medium::Unknown,
            drive: Drive::Off,
            last_plan_id: String::new(),
            last_outcome: LastOutcome::None,
            initializing: false,
        }
    }

    /// New parameters; running maneuvers use them from then on.
    pub fn reconfigure(&mut self, config: EngineConfig) {
        self.vehicle.set_vital(config.vital.clone());
        self.config = config;
    }

    /// The caller was stalled until `now`: path control could not have been heard meanwhile.
    pub fn held_up(&mut self, now: MonoTime) {
        if let Some(heard) = self.run.as_mut().and_then(|run| run.path_heard.as_mut()) {
            *heard = now;
        }
    }

    /// Takes an input. Deadlines that have passed by `now` are honoured first.
    pub fn handle_input(&mut self, now: Now, input: Input) {
        self.handle_timeout(now);
        match input {
            Input::Request(request) => self.request(now, request),
            Input::Event(event) => self.event(now, &event),
            Input::Entities(conditions) => self.entities(now, conditions),
            Input::Position { known } => self.position(now, known),
            Input::Abort { by } => self.abort(now, by),
        }
    }

    /// The time of [`Engine::poll_timeout`] came; calling it early is harmless.
    pub fn handle_timeout(&mut self, now: Now) {
        let reached = |deadline: Option<MonoTime>| deadline.is_some_and(|deadline| deadline <= now.mono);
        if reached(self.run.as_ref().and_then(|run| run.calibrating_until)) {
            self.calibrated(now);
        }
        if reached(self.run.as_ref().and_then(Run::maneuver_deadline)) {
            self.with_maneuver(now, Running::timeout);
            self.go_on(now);
        }
        if reached(self.position_deadline()) {
            self.end_run(now, EndReason::PositionLost);
        }
        if reached(self.path_deadline()) {
            self.with_maneuver(now, |_, cx| cx.fail(crate::maneuver::FailReason::PathSilent));
            self.go_on(now);
        }
    }

    /// The next output to carry out or report.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When the engine wants to be woken.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        let run = self.run.as_ref();
        [
            run.and_then(|run| run.calibrating_until),
            run.and_then(Run::maneuver_deadline),
            self.path_deadline(),
            self.position_deadline(),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// The running plan.
    pub fn running(&self) -> Option<(RunId, &Plan)> {
        self.run.as_ref().map(|run| (run.id, &run.plan))
    }

    /// The state of plans.
    pub fn plan_state(&mut self, now: Now) -> PlanState {
        let run = self.run.as_ref().filter(|_| !self.initializing);
        let phase = match (self.initializing, run, self.vehicle.mode()) {
            (true, _, _) => PlanPhase::Initializing,
            (false, Some(run), _) if run.calibrating_until.is_some() => PlanPhase::Initializing,
            (false, Some(_), _) => PlanPhase::Executing,
            (false, None, Mode::Service) => PlanPhase::Ready,
            (false, None, _) => PlanPhase::Blocked,
        };
        let plan_id = run.map_or(&self.last_plan_id, |run| &run.plan_id).clone();
        let (id, last_outcome) = (run.map(|run| run.id), self.last_outcome);
        let maneuver = run.and_then(Run::maneuver).map(|node| (node.id().to_owned(), node.maneuver().kind()));
        let standing = self.run.as_mut().map(|run| run.standing(now)).unwrap_or_default();
        PlanState {
            phase,
            plan_id,
            run: id,
            plan_eta_s: standing.plan_eta_s,
            progress: standing.progress,
            maneuver,
            maneuver_eta_s: standing.maneuver_eta_s,
            last_outcome,
        }
    }

    /// The state of the vehicle.
    pub fn vehicle_state(&mut self, now: Now) -> VehicleState {
        let standing = self.run.as_mut().map(|run| run.standing(now)).unwrap_or_default();
        let run = self.run.as_ref();
        let maneuver = run.and_then(Run::maneuver).map(|node| node.maneuver().kind());
        VehicleState {
            mode: self.vehicle.mode(),
            errors: self.vehicle.errors(false),
            maneuver,
            maneuver_began: maneuver.and_then(|_| run?.maneuver_began),
            maneuver_eta_s: standing.maneuver_eta_s,
            drive: self.drive,
            maneuver_done: run.is_some_and(|run| run.outcome == Some(Outcome::Done)),
            last_error: self.vehicle.last_error().cloned(),
        }
    }

    fn event(&mut self, now: Now, event: &Event) {
        match event {
            Event::Fix(fix) => self.fix = Some((now.mono, *fix)),
            Event::Medium(medium) => self.medium = *medium,
            Event::Path(progress) if !self.is_current_path(progress.path_ref) => return,
            Event::PathFailed { path_ref, .. } if !self.is_current_path(*path_ref) => return,
            Event::Path(_) => {
                if let Some(run) = &mut self.run {
                    run.path_heard = Some(now.mono);
                }
            }
            Event::PathFailed { .. }
            | Event::Reference(_)
            | Event::Sighting(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
        self.with_maneuver(now, |running, cx| running.event(cx, event));
        self.go_on(now);
    }

    fn is_current_path(&self, path_ref: u32) -> bool {
        self.drive == Drive::Path && path_ref == self.path_ref
    }

    /// A plan that waits for the position continues where it was: path control keeps its path.
    fn position(&mut self, now: Now, known: bool) {
        if known == self.lost_since.is_none() {
            return;
        }
        self.lost_since = (!known).then_some(now.mono);
        self.held_up(now.mono);
        if self.run.is_none() || self.is_steered() {
            return;
        }
        if known {
            self.note(NoteLevel::Info, "the position is good again: the plan goes on".to_owned());
            return;
        }
        let patience_s = self.config.position_patience.as_secs();
        if patience_s > 0 {
            let text = format!(
                "the position is lost: the plan waits with its motors stopped, and fails after {patience_s} s"
            );
            self.note(NoteLevel::Warning, text);
        }
        self.handle_timeout(now);
    }

    /// An operator steers: that needs no position.
    fn is_steered(&self) -> bool {
        let kind = self.run.as_ref().and_then(Run::maneuver).map(|node| node.maneuver().kind());
        kind == Some(crate::kind::ManeuverKind::Teleoperation)
    }

    fn position_deadline(&self) -> Option<MonoTime> {
        let since = self.lost_since.filter(|_| self.run.is_some() && !self.is_steered())?;
        Some(since + self.config.position_patience)
    }

    fn path_deadline(&self) -> Option<MonoTime> {
        if self.lost_since.is_some() {
            return None;
        }
        let heard = self.run.as_ref().filter(|_| self.drive == Drive::Path)?.path_heard?;
        Some(heard + self.config.maneuver.path_silence)
    }

    /// Lets the active maneuver act, and carries its signals out.
    fn with_maneuver(&mut self, now: Now, act: impl FnOnce(&mut Running, &mut Context<'_>)) {
        let Some(run) = &mut self.run else { return };
        let Some(running) = &mut run.running else { return };
        let mut signals = Vec::new();
        let max_age = self.config.maneuver.fix_max_age;
        let mut cx = Context {
            now,
            config: &self.config.maneuver,
            fix: self.fix.filter(|(at, _)| now.mono.since(*at) <= max_age).map(|(_, fix)| fix),
            medium: self.medium,
            waters: &self.config.waters,
            signals: &mut signals,
            path_ref: &mut self.path_ref,
            outcome: None,
        };
        act(running, &mut cx);
        run.outcome = cx.outcome;
        for signal in signals {
            match signal {
                Signal::Command(command) => self.command(now, command),
                Signal::Way(from, to) => self.outputs.push_back(Output::LookForWay { from, to }),
                Signal::Reference(state) => self.outputs.push_back(Output::Reference(state)),
                Signal::Warning(text) => self.note(NoteLevel::Warning, text),
            }
        }
    }

    fn command(&mut self, now: Now, command: Command) {
        self.drive = command.drive(self.drive);
        if let (Command::Follow(_), Some(run)) = (&command, &mut self.run) {
            run.path_heard = Some(now.mono);
        }
        self.outputs.push_back(Output::Command(command));
    }

    fn statistics(&self, now: Now, plan: &Plan) -> PlanStatistics {
        let here = self.fix.map(|(_, fix)| fix.place);
        PlanStatistics::of(plan, here, now, &self.config.model)
    }

    fn note(&mut self, level: NoteLevel, text: String) {
        self.outputs.push_back(Output::Note(Note { level, text }));
    }

    fn tell_vehicle(&mut self, now: Now) {
        let state = self.vehicle_state(now);
        self.outputs.push_back(Output::VehicleState(Box::new(state)));
    }

    fn tell_plan(&mut self, now: Now) {
        let state = self.plan_state(now);
        self.outputs.push_back(Output::PlanState(Box::new(state)));
    }
}

#[cfg(test)]
mod tests;
