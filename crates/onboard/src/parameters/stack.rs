//! Parameters that are kept and given back: what PushEntityParameters and PopEntityParameters do, around a
//! plan or a maneuver or on a console's request.
//!
//! Kept values are those of the moment, one entry per push and entity. Giving back sets what differs by then.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::parameters::{self, Access};
use crate::settings::Settings;
use imc::messages::{EntityParameter, SetEntityParameters};
use std::collections::BTreeMap;

/// Entries of an entity; a push beyond them is refused and reported.
const DEEPEST: usize = 16;

/// Names and values of one push.
type Kept = Vec<(&'static str, String)>;

/// Pushed values that were not popped, at most [`DEEPEST`] entries for each entity.
#[derive(Debug, Default)]
pub(crate) struct ParameterStack(BTreeMap<Entity, Vec<Kept>>);

impl ParameterStack {
    /// Keeps the parameters of an entity. Unknown labels are not answered, as with the setting of parameters.
    pub(crate) fn push(&mut self, bus: &mut Bus, settings: &Settings, label: &str) {
        let Some(entity) = settings.labels.find(label) else { return };
        let kept = values_of(settings, entity);
        let entries = self.0.entry(entity).or_default();
        if entries.len() < DEEPEST {
            entries.push(kept);
            bus.entry(entity, Level::Info, "parameters are kept");
        } else {
            let text = format!("parameters are not kept: the stack of {DEEPEST} sets is full");
            bus.entry(entity, Level::Warning, text);
        }
    }

    /// Takes the parameters of an entity as they were kept last; answers what is to be set for that.
    pub(crate) fn pop(
        &mut self,
        bus: &mut Bus,
        settings: &Settings,
        label: &str,
    ) -> Option<SetEntityParameters> {
        let entity = settings.labels.find(label)?;
        let Some(kept) = self.0.get_mut(&entity).and_then(Vec::pop) else {
            bus.entry(entity, Level::Warning, "the stack of parameters is empty: nothing to restore");
            return None;
        };
        let current = values_of(settings, entity);
        let changed = kept.into_iter().filter(|value| !current.contains(value));
        let params = changed
            .map(|(name, value)| EntityParameter { name: name.into(), value: value.into() })
            .collect::<imc::MessageList>();
        (!params.is_empty()).then(|| SetEntityParameters { name: label.into(), params })
    }
}

/// The parameters that may be changed while the vessel runs; the rest is unchanged.
fn values_of(settings: &Settings, entity: Entity) -> Kept {
    parameters::all()
        .iter()
        .filter(|parameter| parameter.entity == entity && parameter.access == Access::Live)
        .filter_map(|parameter| Some((parameter.name, parameter.get(settings)?)))
        .collect()
}
