//! The vehicle's modes, as they follow from entity states and aborts.
//!
//! DUNE's mode for control loops enabled from outside is absent: only the engine enables loops.

use super::{EndReason, Engine, Mode, NoteLevel, Output};
use std::collections::{BTreeMap, BTreeSet};
use units::{Now, UtcTime};

/// Condition of an entity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EntityCondition {
    /// Starting. Counts as an error but lets the vehicle continue to boot.
    Boot,
    /// Well.
    Normal,
    /// In a fault, an error or a failure; all count alike.
    Error,
}

#[derive(Debug, Clone)]
pub(super) struct Vehicle {
    mode: Mode,
    conditions: BTreeMap<String, EntityCondition>,
    vital: BTreeSet<String>,
    /// An abort came, and no entity report since.
    aborted: bool,
    last_error: Option<(String, UtcTime)>,
}

impl Vehicle {
    pub(super) fn new(vital: BTreeSet<String>) -> Self {
        Self { mode: Mode::Boot, conditions: BTreeMap::new(), vital, aborted: false, last_error: None }
    }

    pub(super) fn set_vital(&mut self, vital: BTreeSet<String>) {
        self.vital = vital;
    }

    pub(super) fn mode(&self) -> Mode {
        self.mode
    }

    pub(super) fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
    }

    pub(super) fn last_error(&self) -> Option<&(String, UtcTime)> {
        self.last_error.as_ref()
    }

    pub(super) fn set_last_error(&mut self, error: Option<(String, UtcTime)>) {
        self.last_error = error;
    }

    /// Labels of entities with a fault; of the vital ones only if `only_vital`.
    pub(super) fn errors(&self, only_vital: bool) -> Vec<String> {
        let bad = self.conditions.iter().filter(|(_, condition)| **condition != EntityCondition::Normal);
        bad.map(|(label, _)| label.clone())
            .filter(|label| !only_vital || self.vital.contains(label))
            .collect()
    }

    /// The mode while nothing runs.
    pub(super) fn rest_mode(&self) -> Mode {
        if self.aborted || !self.errors(false).is_empty() { Mode::Error } else { Mode::Service }
    }

    /// Why no plan can start, if so.
    pub(super) fn blocks(&self, ignore_errors: bool) -> Option<String> {
        if self.mode == Mode::Boot {
            return Some("booting".to_owned());
        }
        if self.aborted {
            return Some("aborted".to_owned());
        }
        let errors = self.errors(ignore_errors);
        (!errors.is_empty()).then(|| errors.join(", "))
    }
}

impl Engine {
    pub(super) fn entities(&mut self, now: Now, conditions: BTreeMap<String, EntityCondition>) {
        let changed = self.vehicle.conditions != conditions;
        let before = self.vehicle.mode;
        self.vehicle.conditions = conditions;
        self.vehicle.aborted = false;
        let errors = self.vehicle.errors(false);
        let booting = self.vehicle.conditions.values().any(|one| *one == EntityCondition::Boot);
        match self.vehicle.mode {
            Mode::Boot if errors.is_empty() || !booting => self.vehicle.mode = self.vehicle.rest_mode(),
            Mode::Error | Mode::Service => self.vehicle.mode = self.vehicle.rest_mode(),
            Mode::Maneuver => self.check_errors(now),
            Mode::Boot | Mode::Calibration => {}
        }
        if before != Mode::Error && self.vehicle.mode == Mode::Error && !errors.is_empty() {
            let text = format!("entity error: {}", errors.join(", "));
            self.note(NoteLevel::Error, text.clone());
            self.vehicle.last_error = Some((text, now.utc));
        }
        if before != self.vehicle.mode {
            self.tell_plan(now);
        }
        if changed || before != self.vehicle.mode {
            self.tell_vehicle(now);
        }
    }

    /// Ends the plan when an entity error matters to it. An operator who steers is not to be interrupted.
    fn check_errors(&mut self, now: Now) {
        let Some(run) = &self.run else { return };
        let mut errors = self.vehicle.errors(run.options.ignore_errors);
        errors.retain(|label| !self.config.bridged.contains(label));
        if !errors.is_empty() && !self.is_steered() {
            self.end_run(now, EndReason::Entities(errors.join(", ")));
        }
    }

    pub(super) fn abort(&mut self, now: Now, by: u16) {
        let text = format!("stopped by {by:#06x}");
        self.note(NoteLevel::Warning, text.clone());
        self.vehicle.aborted = true;
        self.vehicle.last_error = Some((text, now.utc));
        if self.run.is_some() {
            self.end_run(now, EndReason::Aborted(by));
        } else {
            self.vehicle.mode = Mode::Error;
            self.command(now, crate::command::Command::Drift);
            self.tell_vehicle(now);
            self.tell_plan(now);
        }
        self.outputs.push_back(Output::Aborted { by });
    }
}
