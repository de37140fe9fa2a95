//! The progress of a running plan, by the vessel's real speed.
//!
//! Progress is planned time done by planned time in all. The time to the end is the planned time left, the
//! moving part of it stretched by how much longer than planned moving has taken so far.

use super::{Span, VehicleModel, planned_mps, spans};
use crate::maneuver::Left;
use crate::plan::Plan;
use units::{LatLon, MonoTime, Now};

/// Planned and real time are taken as equal for so long, so that the first metres weigh little (s).
const TRUST_S: f64 = 30.0;
/// Bounds of the stretch.
const LEAST_STRETCH: f64 = 0.2;
const MOST_STRETCH: f64 = 10.0;

#[derive(Debug, Clone)]
pub(crate) struct Progress {
    /// By index of the maneuver; `None` when unknown or never reached.
    spans: Vec<Option<Span>>,
    /// Planned speeds by index (m/s).
    mps: Vec<f64>,
    /// Planned time in all (s), where that is known.
    total_s: Option<f64>,
    began: MonoTime,
    done: Span,
    current: Option<usize>,
    /// Progress never falls.
    best: f64,
}

/// The position in a plan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Standing {
    /// 0 to 1.
    pub(crate) progress: Option<f64>,
    pub(crate) plan_eta_s: Option<f64>,
    pub(crate) maneuver_eta_s: Option<f64>,
}

impl Progress {
    pub(crate) fn new(plan: &Plan, from: Option<LatLon>, now: Now, model: &VehicleModel) -> Self {
        let ordered = spans(plan, from, now, model);
        let total_s = if plan.is_cyclic() { None } else { super::sum(&ordered).map(|sum| sum.duration_s()) };
        let mut spans = vec![None; plan.nodes().len()];
        for (index, span) in ordered {
            spans[index] = span;
        }
        let mps = plan.nodes().iter().map(|node| planned_mps(node.maneuver(), model)).collect();
        let done = Span::default();
        Self { spans, mps, total_s, began: now.mono, done, current: None, best: 0.0 }
    }

    /// The maneuver at `index` begins; the previous one is done.
    pub(crate) fn begin(&mut self, index: usize) {
        if let Some(span) = self.current.and_then(|before| self.spans[before]) {
            self.done = self.done.and(span);
        }
        self.current = Some(index);
    }

    pub(crate) fn standing(&mut self, now: Now, left: Option<Left>) -> Standing {
        let Some(index) = self.current else { return Standing::default() };
        let span = self.spans[index];
        let (moving_s, waiting_s) = match (left, span) {
            (Some(left), _) => (left.way_m / self.mps[index], left.wait_s),
            (None, Some(span)) => (span.moving_s, span.waiting_s),
            (None, None) => return Standing::default(),
        };
        let span = span.unwrap_or_default();
        let moved_s = self.done.moving_s + (span.moving_s - moving_s).max(0.0);
        let waited_s = self.done.waiting_s + (span.waiting_s - waiting_s).max(0.0);
        let real_s = (now.mono.since(self.began).as_secs_f64() - waited_s).max(0.0);
        let stretch = ((real_s + TRUST_S) / (moved_s + TRUST_S)).clamp(LEAST_STRETCH, MOST_STRETCH);
        let maneuver_eta_s = moving_s * stretch + waiting_s;
        let Some(total_s) = self.total_s else {
            return Standing { maneuver_eta_s: Some(maneuver_eta_s), ..Standing::default() };
        };
        let later_s = |part: fn(&Span) -> f64, all: f64, done: f64| (all - done - part(&span)).max(0.0);
        let all = self.spans.iter().flatten().fold(Span::default(), |sum, span| sum.and(*span));
        let later_moving_s = later_s(|span| span.moving_s, all.moving_s, self.done.moving_s);
        let later_waiting_s = later_s(|span| span.waiting_s, all.waiting_s, self.done.waiting_s);
        let done_s = moved_s + waited_s;
        self.best = if total_s > 0.0 { self.best.max((done_s / total_s).clamp(0.0, 1.0)) } else { self.best };
        Standing {
            progress: Some(self.best),
            plan_eta_s: Some(maneuver_eta_s + later_moving_s * stretch + later_waiting_s),
            maneuver_eta_s: Some(maneuver_eta_s),
        }
    }
}
