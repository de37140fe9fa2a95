//! What somebody wants to see of the fleet and may see, and what changed of it.

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
    /// Whether events are wanted.
    pub events: bool,
}

impl Wanted {
    /// Whether this system is wanted and may be seen.
    pub fn admits_system(&self, address: u16) -> bool {
        self.grants.on(address).is_some()
            && self.systems.as_ref().is_none_or(|systems| systems.contains(&address))
    }

    /// Whether messages with this abbreviation are wanted.
    pub fn admits_message(&self, abbrev: &str) -> bool {
        self.messages.as_ref().is_none_or(|messages| messages.contains(abbrev))
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
