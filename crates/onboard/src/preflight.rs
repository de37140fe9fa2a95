//! The preflight check: the motors are not armed until position, heading, clock, CAN and chart are good, or a person
//! overrides it with a reason.
//!
//! It applies to each start that is requested from outside: of plans, of a single maneuver such as Goto, of manual
//! control, which are all starts of the plan engine. Once all was good the motors are armed until the program ends:
//! failures under way are left to the supervisors, and a vessel must be able to come home. It does not apply to what the
//! vessel starts on its own, as a remedy or after a restart under way. A vessel without a configured chart passes the
//! check of the chart.
//!
//! A person overrides it by the parameter [`OVERRIDE`] of this part, whose value is the reason. The parameter is not in the
//! files: it is written to the log book, holds for this run of the program, and is never saved.

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::Level;
use crate::states::{Condition, States};
use imc::Text;
use imc::messages::{EntityParameter, EntityParameters, SetEntityParameters};

/// The parameter by which a person overrides the preflight.
pub(crate) const OVERRIDE: &str = "Override";
/// Letters of a reason that are kept.
const LONGEST_REASON: usize = 200;

/// The state of the preflight.
#[derive(Debug, Default)]
pub(crate) struct Preflight {
    /// All was good at one moment of this run.
    passed: bool,
    /// The person who overrides it, and the reason.
    overridden: Option<(String, String)>,
    missing: Vec<String>,
}

impl Preflight {
    /// This is missing now.
    pub(crate) fn look(&mut self, bus: &mut Bus, states: &mut States, missing: Vec<String>) {
        if missing.is_empty() && !self.passed {
            self.passed = true;
            bus.entry(Entity::Preflight, Level::Info, "position, heading, clock, CAN and chart are good");
        }
        self.missing = missing;
        let list = self.missing.join(", ");
        let (condition, text) = match &self.overridden {
            _ if self.passed => (Condition::Normal, "passed: the motors may be armed".to_owned()),
            Some((who, why)) => (Condition::Fault, format!("overridden by {who}: {why}; missing: {list}")),
            None => (Condition::Boot, format!("the motors are not armed; missing: {list}")),
        };
        states.set(bus, Entity::Preflight, condition, text);
    }

    /// Why starts are refused; `label` is this part's name.
    pub(crate) fn refusal(&self, label: &str) -> Option<String> {
        (!self.passed && self.overridden.is_none()).then(|| {
            let list = self.missing.join(", ");
            format!("missing: {list}; mend it, or set the parameter `{OVERRIDE}` of `{label}` to your reason")
        })
    }

    /// A person overrides the preflight, or ends that with no reason.
    pub(crate) fn set(&mut self, bus: &mut Bus, asker: Asker, name: &str, set: &SetEntityParameters) {
        let who = if name.is_empty() { asker.system.to_string() } else { name.to_owned() };
        for wanted in set.params.of::<EntityParameter>() {
            let value = wanted.value.to_str_lossy();
            let known = wanted.name.to_str_lossy() == OVERRIDE;
            // Actions of plans come from the vessel itself.
            if !known || asker.system == bus.address() {
                let text =
                    format!("{} is refused: a person sets `{OVERRIDE}` alone", wanted.name.to_str_lossy());
                bus.entry_to(Entity::Preflight, asker, Level::Warning, text);
                continue;
            }
            let reason: String = value.trim().chars().take(LONGEST_REASON).collect();
            if reason.is_empty() {
                self.overridden = None;
                bus.entry(Entity::Preflight, Level::Info, format!("{who} ends the override"));
            } else {
                let list = if self.passed { "nothing".to_owned() } else { self.missing.join(", ") };
                let text = format!("{who} overrides the preflight: {reason}; missing: {list}");
                bus.entry(Entity::Preflight, Level::Warning, text);
                self.overridden = Some((who.clone(), reason));
            }
            self.answer(bus, asker, &set.name);
        }
    }

    /// Reports the reason in force, empty for none.
    pub(crate) fn answer(&self, bus: &mut Bus, asker: Asker, label: &Text) {
        let reason = self.overridden.as_ref().map_or("", |(_, reason)| reason);
        let value = EntityParameter { name: OVERRIDE.into(), value: reason.into() };
        let params = [value].into_iter().collect();
        bus.send_to(Entity::Preflight, asker, &EntityParameters { name: label.clone(), params });
    }
}
