//! What every handler may reach: the configuration and the handles of the tasks that own state.
//!
//! The fleet belongs to the task that owns the hub and is asked through [`Fleet`]; the history is read through
//! [`History`], on threads where slow work may be done.

pub(crate) mod alarms;
pub(crate) mod control;
mod decode;
pub(crate) mod export;
mod fleet;
mod helms;
pub(crate) mod history;
pub(crate) mod imports;
pub(crate) mod parameters;

pub(crate) use fleet::Fleet;
pub(crate) use helms::{Helm, Helms};
pub(crate) use history::History;
pub(crate) use imports::Imports;

use crate::charts::Charts;
use crate::clock::Clock;
use crate::config::Config;
use crate::doors::link::Links;
use crate::http::stop::Stops;
use crate::owners::Owners;
use crate::people::{Grants, People};
use crate::relay::{Recorder, Relay};
use crate::sinks::SinkState;
use api::{System, Update};
use metrics_exporter_prometheus::PrometheusHandle;
use std::collections::BTreeSet;
use std::sync::Arc;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub(crate) struct AppState {
    /// As the server was started.
    pub(crate) config: Arc<Config>,
    /// What everything here is decided and recorded by.
    pub(crate) clock: Clock,
    /// Accounts, sessions, tokens.
    pub(crate) people: People,
    /// The fleet as it is.
    pub(crate) fleet: Fleet,
    /// The fleet as it was.
    pub(crate) history: History,
    /// Logs that were uploaded.
    pub(crate) imports: Imports,
    /// The sea chart.
    pub(crate) charts: Charts,
    /// Figures for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// Says that the server is about to end.
    pub(crate) stop: CancellationToken,
    /// Sockets that outlive their request; the end waits for them.
    pub(crate) tasks: TaskTracker,
    /// The vessels that came in by the link.
    pub(crate) links: Links,
    /// Who steers which vessel by hand.
    pub(crate) helms: Helms,
    /// The stops of the last minutes.
    pub(crate) stops: Stops,
    /// The hub: routing and the fleet's state.
    pub(crate) relay: Relay,
    /// The archive and history.
    pub(crate) recorder: Recorder,
    /// Whether those who own state are there.
    pub(crate) owners: Owners,
    /// How the InfluxDB that gets everything too gets on; `None` without one.
    pub(crate) influx: Option<watch::Receiver<SinkState>>,
}

/// What somebody wants to see and may see.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wanted {
    /// What the person may see.
    pub(crate) grants: Grants,
    /// IMC addresses; `None` for all.
    pub(crate) systems: Option<BTreeSet<u16>>,
    /// Abbreviations of messages; `None` for all.
    pub(crate) messages: Option<BTreeSet<String>>,
    /// Whether events are wanted.
    pub(crate) events: bool,
}

impl Wanted {
    /// Whether this system is wanted and may be seen.
    pub(crate) fn admits_system(&self, address: u16) -> bool {
        self.grants.on(address).is_some()
            && self.systems.as_ref().is_none_or(|systems| systems.contains(&address))
    }

    /// Whether messages with this abbreviation are wanted.
    pub(crate) fn admits_message(&self, abbrev: &str) -> bool {
        self.messages.as_ref().is_none_or(|messages| messages.contains(abbrev))
    }
}

/// What changed.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    /// To ask with next time.
    pub(crate) revision: u64,
    /// All wanted systems as they are, if that was asked for.
    pub(crate) systems: Vec<System>,
    /// Series with a new value.
    pub(crate) values: Vec<Update>,
    /// Events, in order.
    pub(crate) events: Vec<Update>,
    /// Events that were forgotten since.
    pub(crate) events_missed: u64,
    /// Who commands, where that changed.
    pub(crate) leases: Vec<api::Lease>,
    /// Commands that got further.
    pub(crate) commands: Vec<api::Command>,
    /// Alarms that changed.
    pub(crate) alarms: Vec<api::Alarm>,
    /// To ask with next time for these three.
    pub(crate) control: (u64, u64, u64),
}
