//! The state of every part of the vessel: entity states, once a second and on every change.

use crate::bus::Bus;
use crate::entity::{Entity, Labels};
use imc::messages::{EntityMonitoringState, EntityState, EntityStateState, Event};
use imc::tuples;
use std::time::Duration;
use units::MonoTime;

const PERIOD: Duration = Duration::from_secs(1);
/// A part's values for programs are sent again after this time, for new listeners.
const AGAIN: Duration = Duration::from_secs(10);
/// The topic of the Event by which a part says in names and values what its entity state says in words.
const TOPIC: &str = "EntityStateValues";

/// How a part is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Condition {
    /// Not known yet.
    #[default]
    Boot,
    /// Well.
    Normal,
    /// To be looked at.
    Fault,
    /// Not working.
    Error,
    /// Broken.
    Failure,
}

impl Condition {
    fn wire(self) -> EntityStateState {
        match self {
            Self::Boot => EntityStateState::Boot,
            Self::Normal => EntityStateState::Normal,
            Self::Fault => EntityStateState::Fault,
            Self::Error => EntityStateState::Error,
            Self::Failure => EntityStateState::Failure,
        }
    }

    /// Whether a vessel must not sail with a part like this.
    pub fn is_bad(self) -> bool {
        self >= Self::Fault
    }
}

/// The states of all parts, and the watch over those that matter.
#[derive(Debug)]
pub(crate) struct States {
    pub(crate) all: [(Condition, String); Entity::ALL.len()],
    monitored: Vec<Entity>,
    next: MonoTime,
    last_error: (String, f64),
    reported: Option<(Vec<Entity>, Vec<Entity>)>,
    values: Vec<Values>,
}

/// A part's values for programs.
#[derive(Debug)]
struct Values {
    entity: Entity,
    list: String,
    /// The last report, and when to repeat it.
    sent: Option<(String, MonoTime)>,
}

impl States {
    pub(crate) fn new(monitored: Vec<Entity>, now: MonoTime) -> Self {
        Self {
            all: std::array::from_fn(|_| (Condition::Boot, String::new())),
            monitored,
            next: now,
            last_error: (String::new(), -1.0),
            reported: None,
            values: Vec::new(),
        }
    }

    /// A part's state and what it says of itself; a change of state goes out at once.
    pub(crate) fn set(
        &mut self,
        bus: &mut Bus,
        entity: Entity,
        condition: Condition,
        text: impl Into<String>,
    ) {
        let slot = &mut self.all[usize::from(entity.number())];
        let changed = slot.0 != condition;
        *slot = (condition, text.into());
        if changed {
            if condition.is_bad() {
                let what = format!("{}: {}", entity.label_and_task().0, slot.1);
                self.last_error = (what, bus.seconds());
            }
            send(bus, entity, condition, &self.all[usize::from(entity.number())].1);
        }
    }

    /// The same as a part's words in names and values, as an Event of [`TOPIC`] from it: programs need not read sentences. A
    /// change goes out with the next states, and all again each ten seconds.
    pub(crate) fn values(&mut self, entity: Entity, pairs: &[(&str, String)]) {
        let list = tuples::build(pairs.iter().map(|(name, value)| (name, value)));
        match self.values.iter_mut().find(|values| values.entity == entity) {
            Some(values) => values.list = list,
            None => self.values.push(Values { entity, list, sent: None }),
        }
    }

    pub(crate) fn condition(&self, entity: Entity) -> Condition {
        self.all[usize::from(entity.number())].0
    }

    /// Watched parts with a fault.
    fn bad(&self) -> Vec<Entity> {
        self.monitored.iter().copied().filter(|entity| self.condition(*entity).is_bad()).collect()
    }

    /// Watched parts that have not started yet.
    fn booting(&self) -> Vec<Entity> {
        let all = self.monitored.iter().copied();
        all.filter(|entity| self.condition(*entity) == Condition::Boot).collect()
    }

    pub(crate) fn poll_timeout(&self) -> MonoTime {
        self.next
    }

    /// Reports what is due.
    pub(crate) fn tick(&mut self, bus: &mut Bus, labels: &Labels) {
        let (bad, booting) = (self.bad(), self.booting());
        let due = bus.mono() >= self.next;
        if due {
            self.next = bus.mono() + PERIOD;
            for entity in Entity::ALL {
                let (condition, text) = &self.all[usize::from(entity.number())];
                send(bus, entity, *condition, text);
            }
            for values in &mut self.values {
                values.tell(bus);
            }
        }
        let picture = Some((bad, booting));
        if due || self.reported != picture {
            self.reported = picture;
            self.report(bus, labels);
        }
    }

    fn report(&self, bus: &mut Bus, labels: &Labels) {
        let Some((bad, booting)) = &self.reported else { return };
        let names = |entities: &[Entity]| {
            entities.iter().map(|entity| labels.of(*entity)).collect::<Vec<_>>().join(",").into()
        };
        // A vessel has fewer than 255 parts.
        let message = EntityMonitoringState {
            mcount: self.monitored.len() as u8,
            mnames: names(&self.monitored),
            ecount: booting.len() as u8,
            enames: names(booting),
            ccount: bad.len() as u8,
            cnames: names(bad),
            last_error: self.last_error.0.as_str().into(),
            last_error_time: self.last_error.1,
        };
        bus.send(Entity::Monitor, &message);
    }
}

impl Values {
    /// Sends states that changed, or were not sent for a while.
    fn tell(&mut self, bus: &mut Bus) {
        let known = self.sent.as_ref().is_some_and(|(list, again)| *list == self.list && bus.mono() < *again);
        if !known {
            self.sent = Some((self.list.clone(), bus.mono() + AGAIN));
            bus.send(self.entity, &Event { topic: TOPIC.into(), data: self.list.as_str().into() });
        }
    }
}

fn send(bus: &mut Bus, entity: Entity, condition: Condition, text: &str) {
    let message = EntityState { state: condition.wire(), description: text.into(), ..EntityState::default() };
    bus.send(entity, &message);
}
