//! The grounding supervisor among the others: what it is told, what becomes of what it wants.

use super::{Desk, Supervise};
use crate::arbiter::Source;
use crate::entity::Entity;
use crate::grounding::{Advice, Chart, DEEP_WATER, Doing, Grounding, Stage};
use crate::output::Level;
use crate::states::Condition;
use mission::{Activity, Remedy};

impl Supervise {
    /// Looks at the water with a new estimate, or without one.
    pub(crate) fn see(&mut self, desk: &mut Desk<'_>) {
        let Some(estimate) = desk.estimate else {
            // Nobody knows where danger is; what needs a position stops by itself.
            desk.pilot.guard(crate::pilot::Gate::default(), None);
            return;
        };
        if *desk.chart() == Chart::Off {
            return;
        }
        let now = desk.bus.mono();
        let doing = match self.activity(desk) {
            Activity::Idle => Doing::Rest,
            Activity::Plan => Doing::Plan,
            Activity::Teleoperation => Doing::Operator,
            Activity::Remedy if self.arbiter.source() == Some(Source::Grounding) => Doing::Own,
            Activity::Remedy => Doing::Remedy,
        };
        let advice = self.grounding.see(now, desk.grounding, estimate, doing, desk.pilot.motors());
        desk.pilot.guard(self.grounding.gate(), self.grounding.speed_limit_mps());
        for one in advice {
            self.take(desk, one);
        }
    }

    fn take(&mut self, desk: &mut Desk<'_>, advice: Advice) {
        let now = desk.bus.mono();
        let text = self.grounding.text(desk.grounding);
        let entry = |desk: &mut Desk<'_>, level, text: String| desk.bus.entry(Entity::Grounding, level, text);
        let remedy = match advice {
            Advice::Tell(Stage::Clear) => {
                entry(desk, Level::Info, text);
                return;
            }
            Advice::Tell(stage) => {
                let level = if stage >= Stage::Close { Level::Error } else { Level::Warning };
                entry(desk, level, text);
                return;
            }
            Advice::ExemptionOver => {
                entry(desk, Level::Warning, "the exemption is over: the sea chart guards again".to_owned());
                return;
            }
            Advice::Abort => {
                let text = format!("{text}: in danger with the motors running for too long: abort");
                entry(desk, Level::Error, text);
                self.aborted();
                let by = desk.bus.address().0;
                desk.plans.tell(desk.bus, desk.pilot, mission::Input::Abort { by });
                return;
            }
            Advice::DeepWater => Remedy::Run { plan_id: DEEP_WATER.to_owned() },
            Advice::Stop => Remedy::Stop,
        };
        let done = if remedy == Remedy::Stop { "stop" } else { "back to deep water" };
        entry(desk, Level::Error, format!("{text}: {done}"));
        self.arbiter.ask(now, Source::Grounding, remedy);
        self.carry_out(desk);
    }

    /// What it does and why.
    pub(super) fn tell_grounding(&self, desk: &mut Desk<'_>) {
        let grounding = &self.grounding;
        let (condition, text) = match Grounding::chart_text(desk.chart()) {
            Err(text) => {
                let plans = if desk.grounding.refuses_without {
                    "plans are refused"
                } else {
                    "plans are not checked"
                };
                (Condition::Error, format!("{text}; {plans} and the water ahead is not watched"))
            }
            Ok(text) if *desk.chart() == Chart::Off => {
                let waits = grounding.waiting_text().map(|waits| format!("; {waits}"));
                (Condition::Normal, text + &waits.unwrap_or_default())
            }
            Ok(_) if desk.estimate.is_none() => {
                (Condition::Fault, "where the vessel is is not known: the water is not watched".to_owned())
            }
            Ok(chart) => {
                let mut parts = vec![grounding.text(desk.grounding)];
                if let Some(left_s) = grounding.exemption.left_s(desk.bus.mono()) {
                    parts.push(format!("an operator may steer unguarded for {left_s:.0} s"));
                }
                if grounding.is_blocking() {
                    parts.push("thrust towards danger is blocked".to_owned());
                }
                if grounding.speed_limit_mps().is_some() {
                    parts.push("slowed down".to_owned());
                }
                if grounding.has_asked() {
                    parts.extend(self.standing(desk.bus, Source::Grounding));
                }
                let refused = grounding.refused(desk.plans.plan_state().run);
                parts.extend(refused.map(str::to_owned));
                parts.push(chart);
                parts.extend(grounding.waiting_text());
                let condition = match grounding.stage() {
                    Stage::Clear if refused.is_none() => Condition::Normal,
                    Stage::Clear | Stage::Ahead | Stage::Near => Condition::Fault,
                    Stage::Close | Stage::Within => Condition::Error,
                };
                (condition, parts.join("; "))
            }
        };
        desk.states.set(desk.bus, Entity::Grounding, condition, text);
    }
}

impl Desk<'_> {
    fn chart(&self) -> &Chart {
        &self.grounding.chart
    }
}
