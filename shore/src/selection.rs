//! The part of the fleet that a user requests and may see, and its changes.

use crate::decode;
use crate::identity::Grants;
use api::{Detection, System, Update};
use std::collections::BTreeSet;

/// What a user requests and may see.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// The user's roles.
    pub grants: Grants,
    /// IMC addresses; `None` for all.
    pub systems: Option<BTreeSet<u16>>,
    /// Abbreviations of messages; `None` for all.
    pub messages: Option<BTreeSet<String>>,
    /// Abbreviations of messages that are wanted of all other systems; `None` for nothing of those.
    pub of_others: Option<BTreeSet<String>>,
    /// Whether events are requested.
    pub events: bool,
}

impl Wanted {
    /// Whether this system may be seen, and something of it is requested.
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
    /// Revision for the next query.
    pub revision: u64,
    /// The state of all requested systems, if asked for.
    pub systems: Vec<System>,
    /// Series with a new value.
    pub values: Vec<Update>,
    /// Events, in order.
    pub events: Vec<Update>,
    /// Detections among them and those of the past that came late.
    pub detections: Vec<Detection>,
    /// Number of events that were dropped since.
    pub events_missed: u64,
    /// Leases that changed.
    pub leases: Vec<api::Lease>,
    /// Commands that changed.
    pub commands: Vec<api::Command>,
    /// Alarms that changed.
    pub alarms: Vec<api::Alarm>,
    /// Revisions of these three for the next query.
    pub control: (u64, u64, u64),
}
