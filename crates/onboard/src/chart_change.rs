//! Replaces the sea chart in force while the program runs.
//!
//! The new chart is used at once, because its corrections must apply at once. There are two exceptions. A vessel under
//! way at a place where the new chart has no data keeps the old chart until it rests: a chart of another area would stop
//! it where it is. A vessel that sails without a chart continues so until it is where the new chart has data.
//!
//! A plan under way is checked against the new chart, all of it but the way to its first maneuver once that is over. A
//! refused plan continues, as its danger may be far away or passed, but this is reported: in the log book, and as a fault
//! of the grounding supervisor until the plan ends. The supervisor watches the water ahead by the new chart and acts
//! before danger as always. Stored plans are checked against the chart when they start. A way home under way, which may
//! not be visible ashore, is given up if the rest of it is refused, and another is searched for.

use crate::entity::Entity;
use crate::grounding::{Chart, ChartFile, GroundingAction};
use crate::navigation::Estimate;
use crate::output::Level;
use crate::parameters::Live;
use charts::depth_index::Water;

impl Live<'_> {
    /// Another chart came.
    pub(crate) fn chart_came(&mut self, chart: ChartFile, estimate: Option<&Estimate>) {
        let waiting = self.supervise.grounding.waiting_chart.as_ref();
        if waiting.is_some_and(|(waiting, _)| waiting.digest() == chart.digest()) {
            return;
        }
        if self.settings.grounding.chart.digest() == Some(chart.digest()) {
            self.supervise.grounding.waiting_chart = None;
            return;
        }
        match self.reason_to_wait(&chart, estimate) {
            None => self.put_in_force(chart),
            Some(why) => {
                let text = format!("the chart {} came and waits: {why}", chart.edition());
                self.bus.entry(Entity::Grounding, Level::Info, text);
                self.supervise.grounding.waiting_chart = Some((chart, why.to_owned()));
            }
        }
    }

    /// Looks again at a chart that waits.
    pub(crate) fn retry_waiting_chart(&mut self, estimate: Option<&Estimate>) {
        let Some((chart, _)) = self.supervise.grounding.waiting_chart.clone() else { return };
        match self.reason_to_wait(&chart, estimate) {
            None => self.put_in_force(chart),
            Some(why) => self.supervise.grounding.waiting_chart = Some((chart, why.to_owned())),
        }
    }

    fn reason_to_wait(&self, chart: &ChartFile, estimate: Option<&Estimate>) -> Option<&'static str> {
        let unguarded = self.settings.grounding.chart == Chart::Off;
        if !unguarded && self.plans.plan_state().run.is_none() {
            return None;
        }
        let Some(estimate) = estimate else {
            return unguarded.then_some("the position of the vessel is not known yet");
        };
        let limits = &self.settings.grounding.limits;
        let water = chart.index().depth_at(estimate.place, &limits.demand(limits.navigable_m)).water;
        (water == Water::NoData).then_some(if unguarded {
            "it has no data where the vessel is"
        } else {
            "it has no data where the vessel is; it is used when the vessel rests"
        })
    }

    fn put_in_force(&mut self, chart: ChartFile) {
        let text = format!("the sea chart is {} from here on", chart.edition());
        self.settings.grounding.chart = Chart::Loaded(chart);
        self.plans.reconfigure(self.settings);
        self.bus.entry(Entity::Grounding, Level::Info, text);
        let own = self.supervise.remedy_run();
        let place = self.pilot.place();
        let refused = self.plans.refused_under_way(self.bus, place);
        self.supervise.charted(self.bus, self.plans, place);
        let refused = refused.filter(|refused| Some(refused.run) != own);
        let refused = refused.map(|refused| {
            let then = match self.settings.grounding.action {
                GroundingAction::Warn => "nothing but a warning comes before danger: stop it",
                GroundingAction::Slow => "the vessel only slows down before danger: stop it",
                GroundingAction::Stop => "the vessel stops before danger",
                GroundingAction::DeepWater => "the vessel turns back before danger",
            };
            let text =
                format!("by the new chart '{}' would be refused: {}; {then}", refused.plan_id, refused.why);
            self.bus.entry(Entity::Grounding, Level::Error, text.clone());
            (refused.run, text)
        });
        self.supervise.grounding.charted(refused);
    }
}
