//! Parameters that are kept and given back: what PushEntityParameters and PopEntityParameters do, around a
//! plan or a maneuver or on a console's word.
//!
//! Kept values are those of the moment, one entry per push and entity. Giving back sets what differs by then.

use crate::brain::Brain;
use crate::bus::Asker;
use crate::entity::Entity;
use crate::output::Level;
use crate::parameters::{self, Access};
use imc::messages::{EntityParameter, SetEntityParameters};
use std::collections::BTreeMap;

/// Entries of an entity; a push beyond them is refused and told.
const DEEPEST: usize = 16;

/// Names and values of one push.
type Kept = Vec<(&'static str, String)>;

/// What was kept and not given back, at most [`DEEPEST`] entries for each entity.
#[derive(Debug, Default)]
pub(crate) struct ParameterStack(BTreeMap<Entity, Vec<Kept>>);

impl Brain {
    /// Keeps the parameters of an entity. Unknown labels are not answered, as with the setting of parameters.
    pub(crate) fn push_parameters(&mut self, label: &str) {
        let Some(entity) = self.settings.labels.find(label) else { return };
        let kept = self.values_of(entity);
        let entries = self.kept.0.entry(entity).or_default();
        if entries.len() < DEEPEST {
            entries.push(kept);
            self.bus.entry(entity, Level::Info, "parameters are kept");
        } else {
            let text = format!("parameters are not kept: that was done {DEEPEST} times without giving back");
            self.bus.entry(entity, Level::Warning, text);
        }
    }

    /// Gives the parameters of an entity back as they were kept last.
    pub(crate) fn pop_parameters(&mut self, asker: Asker, label: &str) {
        let Some(entity) = self.settings.labels.find(label) else { return };
        let Some(kept) = self.kept.0.get_mut(&entity).and_then(Vec::pop) else {
            self.bus.entry(entity, Level::Warning, "no parameters were kept that could be given back");
            return;
        };
        let current = self.values_of(entity);
        let changed = kept.into_iter().filter(|value| !current.contains(value));
        let params = changed
            .map(|(name, value)| EntityParameter { name: name.into(), value: value.into() })
            .collect::<imc::MessageList>();
        if !params.is_empty() {
            self.set_parameters(asker, &SetEntityParameters { name: label.into(), params });
        }
    }

    /// What may be changed while the vessel runs; the rest is as it was.
    fn values_of(&self, entity: Entity) -> Kept {
        parameters::all()
            .iter()
            .filter(|parameter| parameter.entity == entity && parameter.access == Access::Live)
            .filter_map(|parameter| Some((parameter.name, parameter.get(&self.settings)?)))
            .collect()
    }
}
