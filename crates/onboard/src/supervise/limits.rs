//! The operational limits among the other supervisors: their reports.

use super::{Context, Supervise, outlook_text, passed_text};
use crate::arbiter::Source;
use crate::entity::Entity;
use crate::states::Condition;
use mission::{LimitsConfig, Remedy};

impl Supervise {
    pub(super) fn tell_limits(&self, context: &mut Context<'_>) {
        let LimitsConfig { area, area_remedy, max_speed_mps, speed_remedy, .. } = &self.config.limits;
        let what = |remedy: &Option<Remedy>| remedy.as_ref().map_or("tell".to_owned(), Remedy::to_string);
        let mut watched = Vec::new();
        if area.is_some() {
            watched.push(format!("outside the area: {}", what(area_remedy)));
        }
        if let Some(limit_mps) = max_speed_mps {
            watched.push(format!("above {limit_mps:.1} m/s: {}", what(speed_remedy)));
        }
        let passed: Vec<_> = self.limits.passed().map(passed_text).collect();
        let (condition, text) = if !passed.is_empty() {
            let done =
                self.standing(context.bus, Source::Limits).unwrap_or_else(|| "only reported".to_owned());
            (Condition::Error, format!("{}; {done}", passed.join(", ")))
        } else if let Some(next) = self.limits.outlook() {
            (Condition::Fault, format!("a limit is passed; next: {}", outlook_text(context.bus, &next)))
        } else if watched.is_empty() {
            (Condition::Normal, "no limits are set".to_owned())
        } else {
            let depth = self.limits.depth_m().map(|depth_m| format!("{depth_m:.0} m inside the area; "));
            let kept = depth.unwrap_or_else(|| "kept; ".to_owned());
            (Condition::Normal, format!("{kept}next: {}", watched.join(", ")))
        };
        context.states.set(context.bus, Entity::Limits, condition, text);
    }
}
