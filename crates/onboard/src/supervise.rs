//! The supervisors that step in automatically: lost communications, battery reserve, operational limits,
//! grounding.
//!
//! The mission's machines decide; here they get their inputs, the [arbiter](crate::arbiter) weighs their demands,
//! and remedies become plans that the engine runs. Each supervisor reports in its entity's state what it does,
//! what it will do next, and when.

mod battery;
mod context;
mod energy;
mod grounding;
mod limits;
mod next;
mod restart;
mod way_home;

pub(crate) use context::Context;

use crate::arbiter::{Arbiter, Picture, Source, Standing};
use crate::bus::Bus;
use crate::entity::Entity;
use crate::grounding::{DEEP_WATER, Exempted, Grounding};
use crate::output::Level;
use crate::pilot::Pilot;
use crate::plans::{Failed, Plans};
use crate::sensors::Sensors;
use crate::settings::{Settings, WatchSettings};
use crate::states::Condition;
use crate::under_way::{Doing, UnderWay};
use context::Started;
use mission::{
    Activity, BatteryOutput, BatteryReserve, BatteryStage, Drive, LastOutcome, LimitsOutput, LostComms,
    LostCommsInput, LostCommsOutput, OperationalLimits, Remedy, RunId, Violation,
};
use next::{next_values, now_values, outlook_text};
pub(crate) use restart::Restart;
use std::time::Duration;
use units::MonoTime;
use way_home::WayHome;

/// A console heard within this time is in contact: heartbeats come once a second.
const QUIET: Duration = Duration::from_secs(10);
/// A remedy that is not possible is reported again after this time.
const OBSTACLE_TOLD: Duration = Duration::from_mins(1);

/// The supervisors.
#[derive(Debug)]
pub(crate) struct Supervise {
    lost_comms: LostComms,
    battery: BatteryReserve,
    limits: OperationalLimits,
    pub(crate) grounding: Grounding,
    arbiter: Arbiter,
    config: WatchSettings,
    /// An operator has set the vessel in motion, without an abort since. Until then no supervisor starts
    /// the motors: the vessel may lie on its trailer or at the quay.
    under_way: bool,
    /// The silence has been reported.
    silence_told: bool,
    /// What stands in the way of a remedy, as last reported.
    obstacle: Option<String>,
    /// How the remedy of a run is carried out, where there is more to say than its name.
    how: Option<(RunId, String)>,
    /// The plan that failed, for which the vessel holds its station.
    failure: Option<String>,
    pub(crate) restart: Restart,
    way_home: WayHome,
    /// The position is not known.
    blind: bool,
    next_told: MonoTime,
    next_fuel: MonoTime,
}

impl Supervise {
    pub(crate) fn new(settings: &Settings, now: MonoTime, restart: Restart) -> Self {
        Self {
            lost_comms: LostComms::new(now, settings.watch.lost_comms.clone()),
            battery: BatteryReserve::new(settings.watch.battery.clone()),
            limits: OperationalLimits::new(settings.watch.limits.clone()),
            grounding: Grounding::default(),
            arbiter: Arbiter::default(),
            config: settings.watch.clone(),
            under_way: false,
            silence_told: false,
            obstacle: None,
            how: None,
            failure: None,
            restart,
            way_home: WayHome::default(),
            blind: false,
            next_told: now,
            next_fuel: now,
        }
    }

    pub(crate) fn reconfigure(&mut self, settings: &Settings) {
        self.lost_comms.reconfigure(settings.watch.lost_comms.clone());
        self.battery.reconfigure(settings.watch.battery.clone());
        self.limits.reconfigure(settings.watch.limits.clone());
        self.config = settings.watch.clone();
    }

    /// An abort came: the motors stay still until an operator starts something again.
    pub(crate) fn aborted(&mut self) {
        self.under_way = false;
        self.stepped_in();
    }

    /// An operator started or stopped something: what was asked before is settled.
    pub(crate) fn stepped_in(&mut self) {
        self.grounding.stepped_in();
        self.arbiter.stepped_in();
        for source in [Source::Failure, Source::Restart] {
            self.arbiter.withdraw(source);
        }
        self.failure = None;
        self.restart.forget();
    }

    /// Control ashore has changed hands; returns whether that ends an exemption of the previous holder.
    pub(crate) fn commander_changed(&mut self, now: MonoTime) -> bool {
        self.grounding.exemption.request(now, 0.0) == Exempted::Ended
    }

    /// A console was heard.
    pub(crate) fn contact(&mut self, now: MonoTime) {
        self.lost_comms.handle_input(now, LostCommsInput::Contact);
    }

    /// Whether an operator has set the vessel in motion, without an abort since.
    fn is_under_way(&self) -> bool {
        self.under_way
    }

    /// The plan of the remedy that waits for what it needs, such as a position: the vessel drifts, but not on purpose.
    fn waiting_plan(&self, plans: &Plans, holds_after_failure: bool) -> Option<String> {
        let holds = || (holds_after_failure && plans.has_failed()).then_some(Remedy::Hold);
        match self.arbiter.wanted().or_else(holds)? {
            Remedy::Run { plan_id } => Some(plan_id),
            Remedy::Hold | Remedy::Stop => Some(context::HOLD_PLAN.to_owned()),
        }
    }

    /// The present activity, as needed after a restart; `None` at rest.
    pub(crate) fn under_way(
        &self,
        plans: &Plans,
        pilot: &Pilot,
        holds_after_failure: bool,
    ) -> Option<UnderWay> {
        if let Some(pending) = self.restart.pending() {
            return Some(pending.clone());
        }
        let state = plans.plan_state();
        let maneuver = state.maneuver.as_ref().map(|(id, _)| id.clone()).unwrap_or_default();
        let of = |doing, plan| UnderWay { doing, plan_id: state.plan_id.clone(), maneuver, plan };
        match (state.run, pilot.drive()) {
            (Some(run), _) if self.remedy_run() == Some(run) => Some(of(Doing::Remedy, None)),
            (Some(_), Drive::Teleoperation(_)) => Some(of(Doing::Teleoperation, None)),
            (Some(run), _) => Some(of(Doing::Plan, plans.plan_of(run).cloned())),
            (None, _) if !self.is_under_way() => None,
            (None, _) => Some(match self.waiting_plan(plans, holds_after_failure) {
                Some(plan_id) => {
                    UnderWay { doing: Doing::Remedy, plan_id, maneuver: String::new(), plan: None }
                }
                None => of(Doing::Drift, None),
            }),
        }
    }

    /// The run of a remedy, if one runs.
    pub(crate) fn remedy_run(&self) -> Option<RunId> {
        self.arbiter.run()
    }

    pub(crate) fn poll_timeout(&self) -> Option<MonoTime> {
        self.lost_comms.poll_timeout()
    }

    /// Looks at everything, and does what falls due.
    pub(crate) fn watch(&mut self, context: &mut Context<'_>, sensors: &Sensors) {
        let now = context.bus.mono();
        let activity = self.activity(context);
        self.blind = context.estimate.is_none();
        self.lost_comms.handle_input(now, LostCommsInput::Activity(activity));
        if let Some(percent) = sensors.charge_percent() {
            self.battery.handle_charge(now, percent / 100.0);
        }
        if let Some(voltage_v) = sensors.voltage_v() {
            self.battery.handle_voltage(now, voltage_v);
        }
        if let Some(estimate) = context.estimate {
            self.limits.handle_fix(now, &estimate.fix());
        }
        self.look_at_restart(context);
        self.look_at_failures(context);
        self.drain(context);
        self.carry_out(context);
        self.tell(context);
        self.tell_battery(context, sensors);
    }

    /// Only what is due by the clock.
    pub(crate) fn tick(&mut self, context: &mut Context<'_>) {
        let now = context.bus.mono();
        if self.lost_comms.poll_timeout().is_some_and(|due| due <= now) {
            let activity = self.activity(context);
            self.lost_comms.handle_input(now, LostCommsInput::Activity(activity));
            self.lost_comms.handle_timeout(now);
            self.drain(context);
            self.carry_out(context);
        }
        self.look_at_way_home(context.bus);
    }

    fn activity(&mut self, context: &Context<'_>) -> Activity {
        let run = context.plans.plan_state().run;
        let activity = match (run, context.pilot.drive()) {
            (None, _) => Activity::Idle,
            (Some(_), _) if run == self.arbiter.run() => Activity::Remedy,
            (Some(_), Drive::Teleoperation(_)) => Activity::Teleoperation,
            (Some(_), Drive::Off | Drive::Path) => Activity::Plan,
        };
        self.under_way |= matches!(activity, Activity::Plan | Activity::Teleoperation);
        activity
    }

    /// A plan that failed under way leaves no vessel adrift, unless that is what the files say.
    fn look_at_failures(&mut self, context: &mut Context<'_>) {
        let Some(Failed { plan_id, why }) = context.plans.take_failed() else { return };
        if self.under_way && context.holds_after_failure {
            self.failure = Some(format!("'{plan_id}' failed: {why}"));
            self.arbiter.ask(context.bus.mono(), Source::Failure, Remedy::Hold);
        }
    }

    fn drain(&mut self, context: &mut Context<'_>) {
        let now = context.bus.mono();
        let is_silent = self.lost_comms.is_silent(now);
        if is_silent && !self.silence_told && !self.lost_comms.is_lost() {
            let text = "no console is heard: carries on, as the files have it for what it does";
            context.bus.entry(Entity::LostComms, Level::Warning, text);
        }
        self.silence_told = is_silent;
        while let Some(output) = self.lost_comms.poll_output() {
            match output {
                LostCommsOutput::Regained => {
                    self.arbiter.withdraw(Source::LostComms);
                    context.plans.tell_own_again(context.bus);
                    context.bus.entry(Entity::LostComms, Level::Info, "a console is heard again");
                }
                LostCommsOutput::Act(remedy) => {
                    let text = format!("no console is heard: {remedy}");
                    context.bus.entry(Entity::LostComms, Level::Warning, text);
                    self.arbiter.ask(now, Source::LostComms, remedy);
                }
            }
        }
        while let Some(output) = self.battery.poll_output() {
            match output {
                BatteryOutput::Stage(stage) => {
                    if stage < BatteryStage::Reserve {
                        self.arbiter.withdraw(Source::Battery);
                    }
                    let level = if stage == BatteryStage::Normal { Level::Info } else { Level::Warning };
                    context.bus.entry(Entity::Fuel, level, format!("battery: {}", stage_text(stage)));
                }
                BatteryOutput::Act(remedy) => self.arbiter.ask(now, Source::Battery, remedy),
            }
        }
        while let Some(output) = self.limits.poll_output() {
            match output {
                LimitsOutput::Kept(violation) => {
                    if self.limits.passed().next().is_none() {
                        self.arbiter.withdraw(Source::Limits);
                    }
                    let text = format!("{} again", kept_text(violation));
                    context.bus.entry(Entity::Limits, Level::Info, text);
                }
                LimitsOutput::Passed(violation, remedy) => {
                    let done = remedy.as_ref().map_or("only reported".to_owned(), Remedy::to_string);
                    let text = format!("{}: {done}", passed_text(violation));
                    context.bus.entry(Entity::Limits, Level::Error, text);
                    if let Some(remedy) = remedy {
                        self.arbiter.ask(now, Source::Limits, remedy);
                    }
                }
            }
        }
    }

    /// Does what the arbiter decides.
    fn carry_out(&mut self, context: &mut Context<'_>) {
        let state = context.plans.plan_state();
        let ended_well = state.last_outcome == LastOutcome::Success;
        let picture = Picture { run: state.run, ended_well, under_way: self.under_way };
        let Some((source, wanted)) = self.arbiter.decide(context.bus.mono(), picture) else { return };
        let mut obstacle = None;
        // The next weaker one replaces a remedy that is not possible, at last the stop.
        for remedy in stand_ins(&wanted) {
            if remedy != wanted && self.arbiter.carries(&remedy) {
                break;
            }
            let started = match &remedy {
                Remedy::Run { plan_id } if plan_id != DEEP_WATER => {
                    let kept = self.config.battery.critical;
                    self.way_home.start(context, source, plan_id, kept)
                }
                other => context.start(other, source != Source::Failure),
            };
            match started {
                Ok(Started { run: Some(run), how }) => {
                    if let Some(how) = &how {
                        let level = if how.is_doubtful { Level::Error } else { Level::Warning };
                        context.bus.entry(entity_of(source), level, format!("{wanted}: {}", how.text));
                    }
                    self.how = how.map(|how| (run, how.text));
                    self.arbiter.began(run, source, remedy);
                }
                Ok(Started { run: None, .. }) => {}
                Err(reason) => {
                    obstacle = Some(match obstacle {
                        None => reason,
                        Some(before) => format!("{before}; nor is '{remedy}': {reason}"),
                    });
                    continue;
                }
            }
            break;
        }
        let now = context.bus.mono();
        if let Some(reason) = &obstacle
            && !(self.way_home.waits() && context.plans.plan_state().run.is_some())
            && (self.obstacle.as_ref() != Some(reason) || now >= self.next_told)
        {
            self.next_told = now + OBSTACLE_TOLD;
            let instead = match context.plans.plan_state().run {
                Some(_) => "another plan runs meanwhile",
                None => "the vessel drifts with its motors stopped until then",
            };
            let text =
                format!("'{wanted}' is not possible: {reason}; it is tried again and again; {instead}");
            context.bus.entry(entity_of(source), Level::Error, text);
        }
        self.obstacle = obstacle;
    }

    /// The outcome of a supervisor's demand.
    fn standing(&self, bus: &Bus, source: Source) -> Option<String> {
        let (remedy, standing) = self.arbiter.standing(source)?;
        Some(match (standing, &self.obstacle) {
            (Standing::Holds, _) => self.in_force_text(source, remedy),
            (Standing::Waits(at), Some(why)) => {
                let meanwhile = match self.arbiter.remedy() {
                    Some(_) if self.blind => {
                        "waits for a position with the motors stopped, meanwhile".to_owned()
                    }
                    Some(running) => format!("{running} meanwhile"),
                    None => "adrift with the motors stopped meanwhile".to_owned(),
                };
                format!("{remedy}: not possible ({why}); {meanwhile}; next try at {}", clock_text(bus, at))
            }
            (Standing::Waits(at), None) => format!("{remedy}: next try at {}", clock_text(bus, at)),
            (Standing::AtRest, _) => {
                format!("{remedy}: not before an operator has set the vessel in motion")
            }
            (Standing::Settled, _) => format!("{remedy}: done, or an operator decided otherwise"),
        })
    }

    /// A remedy that is in force, or what is in its place, and how that is carried out.
    fn in_force_text(&self, source: Source, remedy: &Remedy) -> String {
        let instead = self.arbiter.instead(source);
        let deed = instead.unwrap_or(remedy);
        if self.blind && *deed != Remedy::Stop {
            return format!("{deed}: waits for a position with the motors stopped");
        }
        let force = match instead {
            Some(running) => format!("{remedy}: {running} is in force instead"),
            None => format!("{remedy}: in force"),
        };
        let how = self.how.as_ref().filter(|(run, _)| self.arbiter.run() == Some(*run));
        match how {
            Some((_, how)) => format!("{force}; {how}"),
            None => force,
        }
    }

    /// Each supervisor's action, its next one, and when.
    fn tell(&self, context: &mut Context<'_>) {
        let outlook = self.lost_comms.outlook().map(|outlook| outlook_text(context.bus, &outlook));
        let next = outlook.clone().unwrap_or_else(|| "carry on".to_owned());
        let (condition, text) = if self.lost_comms.is_lost() {
            let now =
                self.standing(context.bus, Source::LostComms).unwrap_or_else(|| "nothing asked".to_owned());
            let next = outlook.unwrap_or_else(|| "nothing further".to_owned());
            (Condition::Fault, format!("no console is heard; {now}; next: {next}"))
        } else if let Some(silence) = self.lost_comms.silence(context.bus.mono()) {
            let heard = self.lost_comms.has_heard();
            let silent = || {
                let span = span_text(silence);
                if heard {
                    format!("not heard for {span}")
                } else {
                    format!("none was heard since the start {span} ago")
                }
            };
            if self.lost_comms.is_silent(context.bus.mono()) {
                (Condition::Fault, format!("no console is heard, {}; next: {next}", silent()))
            } else if silence >= QUIET || !heard {
                (Condition::Normal, format!("{}; without: {next}", silent()))
            } else {
                (Condition::Normal, format!("in contact; without: {next}"))
            }
        } else {
            (Condition::Normal, "no console was ever heard; acts once one was".to_owned())
        };
        context.states.set(context.bus, Entity::LostComms, condition, text);
        context.states.values(Entity::LostComms, &self.lost_comms_values(context.bus.mono()));
        let (condition, text) = match (&self.failure, self.standing(context.bus, Source::Failure)) {
            (Some(failure), Some(standing)) => (Condition::Fault, format!("{failure}; {standing}")),
            _ => match self.restart_text(context.bus) {
                Some(text) => (Condition::Fault, text),
                None => (Condition::Normal, "active".to_owned()),
            },
        };
        context.states.set(context.bus, Entity::PlanEngine, condition, text);
        self.tell_limits(context);
        self.tell_grounding(context);
    }

    /// What the supervisor of lost communications does and will do, for programs.
    fn lost_comms_values(&self, now: MonoTime) -> Vec<(&'static str, String)> {
        let (acted, outlook) = (self.lost_comms.is_lost(), self.lost_comms.outlook());
        let lost = acted || self.lost_comms.is_silent(now);
        let mut values = vec![("lost", i32::from(lost).to_string())];
        if let Some(at) = outlook.as_ref().and_then(|outlook| outlook.at) {
            values.push(("due_s", format!("{:.0}", at.since(now).as_secs_f64())));
        }
        // Before a console was heard nothing comes next: its sentence says so.
        if acted || self.lost_comms.silence(now).is_some() {
            values.extend(next_values(outlook.as_ref(), acted));
        }
        if let Some(asked) = self.arbiter.standing(Source::LostComms).filter(|_| acted) {
            values.extend(now_values(asked, self.arbiter.instead(Source::LostComms), self.blind));
        }
        values
    }
}

/// A remedy and its substitutes where it is not possible, in this order.
fn stand_ins(remedy: &Remedy) -> Vec<Remedy> {
    match remedy {
        Remedy::Run { .. } => vec![remedy.clone(), Remedy::Hold, Remedy::Stop],
        Remedy::Hold => vec![Remedy::Hold, Remedy::Stop],
        Remedy::Stop => vec![Remedy::Stop],
    }
}

fn entity_of(source: Source) -> Entity {
    match source {
        Source::Failure | Source::Restart => Entity::PlanEngine,
        Source::LostComms => Entity::LostComms,
        Source::Battery => Entity::Fuel,
        Source::Limits => Entity::Limits,
        Source::Grounding => Entity::Grounding,
    }
}

/// A deadline by the clock.
fn clock_text(bus: &Bus, at: MonoTime) -> String {
    let left = at.since(bus.mono());
    // Deadlines lie within days.
    let utc = units::UtcTime::from_micros(bus.utc().micros().saturating_add(left.as_micros() as i64)).civil();
    format!("{:02}:{:02}:{:02} UTC", utc.hour, utc.minute, utc.second)
}

/// A span in seconds, or from two minutes on in minutes.
fn span_text(span: Duration) -> String {
    match span.as_secs() {
        seconds @ 0..120 => format!("{seconds} s"),
        seconds => format!("{} min", seconds / 60),
    }
}

fn passed_text(violation: Violation) -> &'static str {
    match violation {
        Violation::Area => "outside the area",
        Violation::Speed => "faster than allowed",
    }
}

fn kept_text(violation: Violation) -> &'static str {
    match violation {
        Violation::Area => "inside the area",
        Violation::Speed => "as slow as allowed",
    }
}

fn stage_text(stage: BatteryStage) -> &'static str {
    match stage {
        BatteryStage::Normal => "enough",
        BatteryStage::Low => "low",
        BatteryStage::Reserve => "down to the reserve",
        BatteryStage::Critical => "nearly empty",
    }
}
