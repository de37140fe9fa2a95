//! Parameters on the bus: query, change, save, push and pop.

use super::saving::Saving;
use super::stack::ParameterStack;
use super::{Parameter, ParameterError};
use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::grounding::Exempted;
use crate::navigation::Navigation;
use crate::output::Level;
use crate::parameters;
use crate::pilot::Pilot;
use crate::plans::Plans;
use crate::settings::Settings;
use crate::supervise::Supervise;
use imc::entities::SAVED_SUFFIX;
use imc::messages::{EntityParameter, EntityParameters, Message, QueryEntityParameters, SetEntityParameters};

/// The parts that a changed parameter reaches.
pub(crate) struct Live<'a> {
    pub(crate) bus: &'a mut Bus,
    pub(crate) settings: &'a mut Settings,
    pub(crate) pilot: &'a mut Pilot,
    pub(crate) navigation: &'a mut Navigation,
    pub(crate) supervise: &'a mut Supervise,
    pub(crate) plans: &'a mut Plans,
}

impl Live<'_> {
    /// Changes one parameter everywhere, or nowhere.
    fn change(&mut self, parameter: &Parameter, value: &str) -> Result<(), ParameterError> {
        let settings = parameter.try_live(self.settings, value)?;
        if let Err(refusal) = self.pilot.reconfigure(&settings) {
            // Values taken before the refusal are reverted; the old settings were in use and are valid.
            self.pilot.reconfigure(self.settings).ok();
            return Err(ParameterError::Refused(refusal.to_string()));
        }
        self.navigation.reconfigure(settings.navigation);
        self.supervise.reconfigure(&settings);
        self.plans.reconfigure(&settings);
        self.bus.node.reconfigure(settings.node.clone());
        *self.settings = settings;
        Ok(())
    }

    fn value(&self, parameter: &Parameter) -> Option<EntityParameter> {
        let value = parameter.get(self.settings)?;
        Some(EntityParameter { name: parameter.name.into(), value: value.into() })
    }

    /// Changes parameters, each separately; answers with those that were taken, and for each refused one with
    /// an entry of the log book that says why.
    pub(crate) fn set(&mut self, asker: Asker, set: &SetEntityParameters) {
        let label = set.name.to_str_lossy().into_owned();
        let Some(entity) = self.settings.labels.find(&label) else { return };
        let mut taken = Vec::new();
        for wanted in set.params.of::<EntityParameter>() {
            let (name, value) = (wanted.name.to_str_lossy(), wanted.value.to_str_lossy());
            let outcome = parameters::all()
                .into_iter()
                .find(|parameter| parameter.entity == entity && parameter.name == name)
                .ok_or_else(|| {
                    let name = name.to_string();
                    let known = parameters::in_files(entity, &name);
                    if known { ParameterError::FileOnly(name) } else { ParameterError::Unknown(name) }
                })
                .and_then(|parameter| self.change(&parameter, &value).map(|()| parameter));
            match outcome {
                Ok(parameter) => {
                    self.bus.entry(entity, Level::Info, format!("{name} = {value}"));
                    if entity == Entity::Grounding {
                        self.exempt(asker, &name);
                    }
                    taken.extend(self.value(&parameter));
                }
                Err(error) => {
                    let text = format!("{name} = {value} is refused: {error}");
                    self.bus.entry_to(entity, asker, Level::Warning, text);
                }
            }
        }
        if !taken.is_empty() {
            let message = EntityParameters { name: set.name.clone(), params: taken.into_iter().collect() };
            self.bus.send_to(entity, asker, &message);
        }
    }

    /// An operator asks to steer unguarded, or confirms it. Plans never can: they are checked against the chart.
    fn exempt(&mut self, asker: Asker, name: &str) {
        use config::schema::watch::grounding::{CONFIRM, OVERRIDE};
        if asker.system == self.bus.address() {
            return;
        }
        let now = self.bus.mono();
        let exemption = &mut self.supervise.grounding.exemption;
        let settings = &self.settings.grounding;
        let (answer, seconds) = if name == OVERRIDE.spec.name {
            (exemption.request(now, settings.override_request_s), settings.override_request_s)
        } else if name == CONFIRM.spec.name {
            (exemption.confirm(now, settings.override_confirm_s), settings.override_confirm_s)
        } else {
            return;
        };
        let who = asker.system;
        let (level, text) = match answer {
            Exempted::Nothing => return,
            Exempted::Requested => {
                let confirm = CONFIRM.spec.name;
                let text = format!(
                    "{who} asks to steer unguarded for {seconds:.0} s; it waits for '{confirm}' of the same time"
                );
                (Level::Warning, text)
            }
            Exempted::Granted => {
                (Level::Warning, format!("{who} steers unguarded by the sea chart for {seconds:.0} s"))
            }
            Exempted::Refused => {
                let request = OVERRIDE.spec.name;
                let text = format!("{who}: no exemption; set '{request}' first, then the same time again");
                (Level::Warning, text)
            }
            Exempted::Ended => (Level::Info, format!("{who} ends the exemption: the sea chart guards again")),
        };
        self.bus.entry(Entity::Grounding, level, text);
    }
}

/// Answers requests for parameters, and holds the saved and pushed values.
#[derive(Debug)]
pub(crate) struct ParameterService {
    saving: Saving,
    stack: ParameterStack,
}

impl ParameterService {
    /// At the start all is as the files say.
    pub(crate) fn new(settings: &Settings) -> Self {
        Self { saving: Saving::new(settings), stack: ParameterStack::default() }
    }

    /// Acts upon a message about parameters; `for_us` is whether it names this vessel, which a change must.
    pub(crate) fn on_message(&mut self, live: &mut Live<'_>, asker: Asker, for_us: bool, message: &Message) {
        match message {
            Message::QueryEntityParameters(query) => self.query(live, asker, query),
            Message::SetEntityParameters(set) if for_us => live.set(asker, set),
            Message::SaveEntityParameters(save) if for_us => {
                self.saving.save(live.bus, live.settings, &save.name.to_str_lossy());
            }
            Message::PushEntityParameters(push) if for_us => {
                self.stack.push(live.bus, live.settings, &push.name.to_str_lossy());
            }
            Message::PopEntityParameters(pop) if for_us => {
                let label = pop.name.to_str_lossy();
                if let Some(set) = self.stack.pop(live.bus, live.settings, &label) {
                    live.set(asker, &set);
                }
            }
            _ => {}
        }
    }

    /// The disk's answer about the values of an entity.
    pub(crate) fn kept(
        &mut self,
        bus: &mut Bus,
        settings: &Settings,
        label: &str,
        outcome: Result<(), String>,
    ) {
        self.saving.kept(bus, settings, label, outcome);
    }

    /// Reports the parameters of an entity. Unknown words are not answered, as in DUNE.
    ///
    /// All of Lutra's parameters hold at any time, which is the scope `global`: for one of DUNE's other scopes there
    /// are none. Visibility `developer` adds of each what the next start will have.
    fn query(&self, live: &mut Live<'_>, asker: Asker, query: &QueryEntityParameters) {
        let developer = match &*query.visibility.to_str_lossy() {
            "user" => false,
            "developer" => true,
            _ => return,
        };
        let global = match &*query.scope.to_str_lossy() {
            "global" => true,
            "idle" | "plan" | "maneuver" => false,
            _ => return,
        };
        let Some(entity) = live.settings.labels.find(&query.name.to_str_lossy()) else { return };
        let all = parameters::all();
        let asked = all.iter().filter(|parameter| global && parameter.entity == entity);
        let mut params = Vec::new();
        for parameter in asked {
            params.extend(live.value(parameter));
            if developer && let Some(saved) = self.saving.value(entity, parameter.name) {
                let name = format!("{}{SAVED_SUFFIX}", parameter.name);
                params.push(EntityParameter { name: name.into(), value: saved.into() });
            }
        }
        let params = params.into_iter().collect();
        live.bus.send_to(entity, asker, &EntityParameters { name: query.name.clone(), params });
    }
}
