//! What somebody wants to see of the fleet and may see, and what changed of it.

use crate::decode;
use crate::identity::Grants;
use api::{Detection, System, Update};
use std::collections::BTreeSet;

/// What somebody wants to see and may see.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// What the person may see.
    pub grants: Grants,
    /// IMC addresses; `None` for all.
    pub systems: Option<BTreeSet<u16>>,
    /// Abbreviations of messages; `None` for all.
    pub messages: Option<BTreeSet<String>>,
    /// Abbreviations of messages that are wanted of all other systems; `None` for nothing of those.
    pub of_others: Option<BTreeSet<String>>,
    /// Whether events are wanted.
    pub events: bool,
}

impl Wanted {
    /// Whether this system may be seen and something of it is wanted.
    pub fn admits_system(&self, address: u16) -> bool {
        self.grants.on(address).is_some() && (self.lists(address) || self.of_others.is_some())
    }

    /// Whether messages with this number, of a system that is [admitted](Self::admits_system), are wanted.
    pub fn admits_message(&self, address: u16, id: u16) -> bool {
        let wanted = if self.lists(address) { &self.messages } else { &self.of_others };
        wanted.as_ref().is_none_or(|messages| messages.contains(&decode::abbrev(id)))
    }

    fn lists(&self, address: u16) -> bool {
        self.systems.as_ref().is_none_or(|systems| systems.contains(&address))
    }
}

/// What changed.
#[derive(Debug, Default)]
pub struct Changes {
    /// To ask with next time.
    pub revision: u64,
    /// All wanted systems as they are, if that was asked for.
    pub systems: Vec<System>,
    /// Series with a new value.
    pub values: Vec<Update>,
    /// Events, in order.
    pub events: Vec<Update>,
    /// Detections among them and those of the past that came late.
    pub detections: Vec<Detection>,
    /// Events that were forgotten since.
    pub events_missed: u64,
    /// Who commands, where that changed.
    pub leases: Vec<api::Lease>,
    /// Commands that got further.
    pub commands: Vec<api::Command>,
    /// Alarms that changed.
    pub alarms: Vec<api::Alarm>,
    /// To ask with next time for these three.
    pub control: (u64, u64, u64),
}
