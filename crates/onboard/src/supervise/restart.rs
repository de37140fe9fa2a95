//! A restart of the program under way, for example by the computer's watchdog. It reports what was under way, and the
//! vessel does not drift unless that is configured.

use super::{Context, Supervise, clock_text};
use crate::arbiter::Source;
use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::settings::AfterRestart;
use crate::under_way::{Doing, UnderWay};
use imc::messages::PlanSpecification;
use mission::Remedy;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// The motors do not start before this time is over, so that people at the quay can step back or stop it.
const WARNING: Duration = Duration::from_secs(5);

/// The handling of the activity before the restart.
#[derive(Debug, Default)]
pub(crate) struct Restart {
    /// The stored activity and its time, until it is known how long ago that was.
    found: Option<(UtcTime, UnderWay)>,
    /// The action, and from when on.
    begins: Option<(MonoTime, Remedy)>,
    /// The plan that is to resume, and when.
    resume: Option<(UnderWay, Option<MonoTime>)>,
    /// The stored activity in words, while an action is under way.
    text: Option<String>,
}

impl Restart {
    /// With what the disk held.
    pub(crate) fn new(found: Option<(UtcTime, UnderWay)>) -> Self {
        Self { found, ..Self::default() }
    }

    /// Whether the record on disk is still undecided: it must stay there unchanged, with its time.
    pub(crate) fn is_open(&self) -> bool {
        self.found.is_some() || self.begins.is_some()
    }

    /// The plan that is to resume, whatever runs meanwhile.
    pub(crate) fn pending(&self) -> Option<&UnderWay> {
        self.resume.as_ref().map(|(plan, _)| plan)
    }

    /// An operator decides from here on.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Supervise {
    /// Decides what to do as soon as the satellites' time is known, and resumes what is due.
    pub(super) fn look_at_restart(&mut self, context: &mut Context<'_>) {
        if let Some(utc) = context.satellite_utc
            && let Some((at, under_way)) = self.restart.found.take()
        {
            self.restarted(context, utc, at, under_way);
        }
        if let Some((_, under_way)) = self.restart.found.as_ref().filter(|_| self.restart.text.is_none()) {
            let what = under_way.text();
            let text = format!(
                "{what} when the program ended: it waits for the time of the satellites to know how long ago"
            );
            context.bus.entry(Entity::PlanEngine, Level::Warning, text.clone());
            self.restart.text = Some(text);
        }
        let now = context.bus.mono();
        if let Some((_, remedy)) = self.restart.begins.take_if(|(at, _)| *at <= now) {
            self.arbiter.ask(now, Source::Restart, remedy);
        }
        if self.arbiter.asks_besides(Source::Restart) {
            // It would replace the plan at once, or already leads the vessel.
            self.end_resumption(context, "another supervisor asks for something");
        }
        let Some((under_way, due)) = &mut self.restart.resume else { return };
        if self.arbiter.source() != Some(Source::Restart) {
            // Not before the vessel holds.
            if due.is_some() {
                self.end_resumption(context, "the vessel does not hold any more");
            }
            return;
        }
        let Some(due) = *due else {
            let at = now + context.restart.countdown;
            let text = format!(
                "'{}' resumes at {}, unless it is stopped or another plan is started",
                under_way.plan_id,
                clock_text(context.bus, at)
            );
            *due = Some(at);
            context.bus.entry(Entity::PlanEngine, Level::Warning, text);
            return;
        };
        if now >= due
            && let Some(plan) = under_way.rest_of_plan()
        {
            self.resume(context, plan);
        }
    }

    fn restarted(&mut self, context: &mut Context<'_>, utc: UtcTime, at: UtcTime, under_way: UnderWay) {
        self.restart.text = None;
        let away_s = (utc - at) as f64 / 1e6;
        let what = under_way.text();
        let memory_s = context.restart.memory.as_secs_f64();
        if away_s.abs() > memory_s {
            let text =
                format!("{what} when the program ended, too long ago to act upon: the vessel is at rest");
            context.bus.entry(Entity::PlanEngine, Level::Warning, text);
            return;
        }
        self.under_way = true;
        if under_way.doing != Doing::Drift {
            // A vessel that was stopped may lie on its trailer by now, out of contact.
            self.lost_comms.arm();
        }
        let remedy = match &context.restart.action {
            _ if under_way.doing == Doing::Drift => None,
            AfterRestart::Drift => None,
            AfterRestart::Hold | AfterRestart::Resume => Some(Remedy::Hold),
            AfterRestart::Return(plan_id) => Some(Remedy::Run { plan_id: plan_id.clone() }),
        };
        let at = context.bus.mono() + WARNING;
        let then = remedy.as_ref().map_or_else(
            || "drift".to_owned(),
            |remedy| format!("{remedy} from {} on, unless it is stopped", clock_text(context.bus, at)),
        );
        let text = format!("{what} when the program ended {:.0} s ago: {then}", away_s.max(0.0));
        context.bus.entry(Entity::PlanEngine, Level::Warning, text);
        let Some(remedy) = remedy else { return };
        self.restart.text = Some(format!("{what} when the program ended"));
        self.restart.begins = Some((at, remedy));
        if context.restart.action == AfterRestart::Resume && under_way.doing == Doing::Plan {
            let whole = under_way.plan.is_some();
            self.restart.resume = Some((under_way, None));
            if !whole {
                self.end_resumption(context, "it is too large to be kept with what is under way");
            }
        }
    }

    fn resume(&mut self, context: &mut Context<'_>, plan: PlanSpecification) {
        match context.plans.resume(context.bus, context.pilot, plan) {
            Ok(_) => {
                self.arbiter.withdraw(Source::Restart);
                self.restart.forget();
            }
            Err(why) => self.end_resumption(context, &why),
        }
    }

    fn end_resumption(&mut self, context: &mut Context<'_>, why: &str) {
        if let Some((under_way, _)) = self.restart.resume.take() {
            let text = format!("'{}' is not resumed: {why}", under_way.plan_id);
            context.bus.entry(Entity::PlanEngine, Level::Error, text);
        }
    }

    /// The stored activity and the action, while that lasts.
    pub(super) fn restart_text(&self, bus: &Bus) -> Option<String> {
        let text = self.restart.text.as_ref()?;
        if let Some((at, remedy)) = &self.restart.begins {
            return Some(format!("{text}; {remedy} from {} on, unless it is stopped", clock_text(bus, *at)));
        }
        if self.restart.is_open() {
            return Some(text.clone());
        }
        let standing = self.standing(bus, Source::Restart)?;
        let resumes = self.restart.resume.as_ref().and_then(|(under_way, due)| Some((under_way, (*due)?)));
        Some(match resumes {
            Some((under_way, due)) => {
                format!("{text}; {standing}; '{}' resumes at {}", under_way.plan_id, clock_text(bus, due))
            }
            None => format!("{text}; {standing}"),
        })
    }
}
