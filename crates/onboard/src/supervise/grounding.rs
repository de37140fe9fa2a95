//! The grounding supervisor among the others: its inputs, and how its demands are carried out.

use super::{Context, Supervise};
use crate::arbiter::Source;
use crate::entity::Entity;
use crate::grounding::{Advice, Chart, DEEP_WATER, Doing, Grounding, Stage};
use crate::output::Level;
use crate::states::Condition;
use mission::{Activity, Remedy};

impl Supervise {
    /// Looks at the water with a new estimate, or without one.
    pub(crate) fn see(&mut self, context: &mut Context<'_>) {
        let Some(estimate) = context.estimate else {
            // Where danger lies is unknown; whatever needs a position stops on its own.
            context.pilot.guard(crate::pilot::Gate::default(), None);
            return;
        };
        if *context.chart() == Chart::Off {
            return;
        }
        let now = context.bus.mono();
        let doing = match self.activity(context) {
            Activity::Idle => Doing::Rest,
            Activity::Plan => Doing::Plan,
            Activity::Teleoperation => Doing::Operator,
            Activity::Remedy if self.arbiter.source() == Some(Source::Grounding) => Doing::Own,
            Activity::Remedy => Doing::Remedy,
        };
        let advice = self.grounding.see(now, context.grounding, estimate, doing, context.pilot.motors());
        context.pilot.guard(self.grounding.gate(), self.grounding.speed_limit_mps());
        for one in advice {
            self.take(context, one);
        }
    }

    fn take(&mut self, context: &mut Context<'_>, advice: Advice) {
        let now = context.bus.mono();
        let text = self.grounding.text(context.grounding);
        let entry = |context: &mut Context<'_>, level, text: String| {
            context.bus.entry(Entity::Grounding, level, text);
        };
        let remedy = match advice {
            Advice::Tell(Stage::Clear) => {
                entry(context, Level::Info, text);
                return;
            }
            Advice::Tell(stage) => {
                let level = if stage >= Stage::Close { Level::Error } else { Level::Warning };
                entry(context, level, text);
                return;
            }
            Advice::ExemptionOver => {
                entry(
                    context,
                    Level::Warning,
                    "the exemption is over: the sea chart guards again".to_owned(),
                );
                return;
            }
            Advice::Abort => {
                let text = format!("{text}: in danger with the motors running for too long: abort");
                entry(context, Level::Error, text);
                self.aborted();
                let by = context.bus.address().0;
                context.plans.tell(context.bus, context.pilot, mission::Input::Abort { by });
                return;
            }
            Advice::DeepWater => Remedy::Run { plan_id: DEEP_WATER.to_owned() },
            Advice::Stop => Remedy::Stop,
        };
        let done = if remedy == Remedy::Stop { "stop" } else { "back to deep water" };
        entry(context, Level::Error, format!("{text}: {done}"));
        self.arbiter.ask(now, Source::Grounding, remedy);
        self.carry_out(context);
    }

    /// Its action and the reason.
    pub(super) fn tell_grounding(&self, context: &mut Context<'_>) {
        let grounding = &self.grounding;
        let (condition, text) = match Grounding::chart_text(context.chart()) {
            Err(text) => {
                let plans = if context.grounding.refuses_without {
                    "plans are refused"
                } else {
                    "plans are not checked"
                };
                (Condition::Error, format!("{text}; {plans} and the water ahead is not watched"))
            }
            Ok(text) if *context.chart() == Chart::Off => {
                let waits = grounding.waiting_text().map(|waits| format!("; {waits}"));
                (Condition::Normal, text + &waits.unwrap_or_default())
            }
            Ok(_) if context.estimate.is_none() => (
                Condition::Fault,
                "the position of the vessel is not known: the water is not watched".to_owned(),
            ),
            Ok(chart) => {
                let mut parts = vec![grounding.text(context.grounding)];
                if let Some(left_s) = grounding.exemption.left_s(context.bus.mono()) {
                    parts.push(format!("an operator may steer unguarded for {left_s:.0} s"));
                }
                if grounding.is_blocking() {
                    parts.push("thrust towards danger is blocked".to_owned());
                }
                if grounding.speed_limit_mps().is_some() {
                    parts.push("slowed down".to_owned());
                }
                if grounding.has_asked() {
                    parts.extend(self.standing(context.bus, Source::Grounding));
                }
                let refused = grounding.refused(context.plans.plan_state().run);
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
        context.states.set(context.bus, Entity::Grounding, condition, text);
        let now = context.bus.mono();
        let on = *context.chart() != Chart::Off;
        let unguarded_s =
            grounding.exemption.left_s(now).map(|left_s| ("unguarded_s", format!("{left_s:.0}")));
        let values =
            [("on", i32::from(on).to_string()), ("blocks", i32::from(grounding.is_blocking()).to_string())];
        let values: Vec<_> = values.into_iter().chain(unguarded_s).collect();
        context.states.values(Entity::Grounding, &values);
    }
}

impl Context<'_> {
    fn chart(&self) -> &Chart {
        &self.grounding.chart
    }
}
