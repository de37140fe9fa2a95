//! The conditions of the watched parts, as reported to the plan engine.

use crate::entity::{Entity, Labels};
use crate::states::{Condition, States};
use mission::EntityCondition;
use std::collections::BTreeMap;
use std::time::Duration;
use units::MonoTime;

/// They are reported again after this time, changed or not.
const PERIOD: Duration = Duration::from_secs(1);

/// Conditions by the labels of the parts.
type ByLabel = BTreeMap<String, EntityCondition>;

/// The last report to the engine, and when the next is due.
#[derive(Debug)]
pub(crate) struct Conditions {
    last: ByLabel,
    next: MonoTime,
}

impl Conditions {
    pub(crate) fn new(now: MonoTime) -> Self {
        Self { last: ByLabel::new(), next: now }
    }

    /// After an abort the vessel stays in error until the engine gets the watched parts' conditions again: in a second,
    /// as with DUNE, and not whenever their next report happens to be due.
    pub(crate) fn hold(&mut self, now: MonoTime) {
        self.next = now + PERIOD;
    }

    /// The report to the engine, when it changed or is due again.
    pub(crate) fn due(
        &mut self,
        now: MonoTime,
        watched: &[Entity],
        states: &States,
        labels: &Labels,
    ) -> Option<ByLabel> {
        let condition = |entity: Entity| match states.condition(entity) {
            Condition::Boot => EntityCondition::Boot,
            Condition::Normal => EntityCondition::Normal,
            Condition::Fault | Condition::Error | Condition::Failure => EntityCondition::Error,
        };
        let conditions: ByLabel =
            watched.iter().map(|entity| (labels.of(*entity).to_owned(), condition(*entity))).collect();
        if conditions == self.last && now < self.next {
            return None;
        }
        self.next = now + PERIOD;
        self.last.clone_from(&conditions);
        Some(conditions)
    }
}
