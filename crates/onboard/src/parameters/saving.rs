//! The parameters of the next start: the values of the files, and those saved since.
//!
//! They are sent to consoles that ask with visibility `developer`, so that a value that is lost with the next start
//! is not taken for saved.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::{Keep, Level, Output};
use crate::parameters::{self, Access};
use crate::settings::Settings;
use std::collections::BTreeMap;

/// Values by name.
type Values = Vec<(&'static str, String)>;

/// The saved value of each parameter, and writes under way.
#[derive(Debug)]
pub(crate) struct Saving {
    saved: BTreeMap<(Entity, &'static str), String>,
    /// The latest values of an entity that the disk was handed, and how many of its answers are to come.
    waiting: BTreeMap<Entity, (Values, u32)>,
}

impl Saving {
    /// At the start all is as the files say.
    pub(crate) fn new(settings: &Settings) -> Self {
        let value = |one: parameters::Parameter| Some(((one.entity, one.name), one.get(settings)?));
        Self { saved: parameters::all().into_iter().filter_map(value).collect(), waiting: BTreeMap::new() }
    }

    /// The values of the next start.
    pub(crate) fn value(&self, entity: Entity, name: &'static str) -> Option<&str> {
        self.saved.get(&(entity, name)).map(String::as_str)
    }

    /// Has the values of an entity kept for the next start.
    pub(crate) fn save(&mut self, bus: &mut Bus, settings: &Settings, label: &str) {
        let Some(entity) = settings.labels.find(label) else { return };
        let values: Values = parameters::all()
            .iter()
            .filter(|parameter| parameter.entity == entity && parameter.access == Access::Live)
            .filter_map(|parameter| Some((parameter.name, parameter.get(settings)?)))
            .collect();
        let texts = values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        bus.put(Output::Keep(Keep::Parameters(label.to_owned(), texts)));
        let waiting = self.waiting.entry(entity).or_default();
        *waiting = (values, waiting.1.saturating_add(1));
    }

    /// The disk's answer about the values of an entity.
    pub(crate) fn kept(
        &mut self,
        bus: &mut Bus,
        settings: &Settings,
        label: &str,
        outcome: Result<(), String>,
    ) {
        let Some(entity) = settings.labels.find(label) else { return };
        let Some((values, count)) = self.waiting.get_mut(&entity) else { return };
        *count = count.saturating_sub(1);
        let last = *count == 0;
        match outcome {
            // Of several that were under way the last one counts.
            Ok(()) if last => {
                let values = std::mem::take(values);
                self.saved.extend(values.into_iter().map(|(name, value)| ((entity, name), value)));
                bus.entry(entity, Level::Info, "parameters are saved");
            }
            Ok(()) => {}
            Err(why) => bus.entry(entity, Level::Error, format!("parameters are not saved: {why}")),
        }
        if last {
            self.waiting.remove(&entity);
        }
    }
}
