//! What every handler may reach: the configuration and the handles of the tasks that own state.
//!
//! The fleet belongs to the task that owns the hub and is asked through [`Fleet`]; the history is read through
//! [`History`], on threads where slow work may be done.

mod decode;
mod fleet;
mod history;

pub(crate) use fleet::Fleet;
pub(crate) use history::Stored;

use crate::config::Config;
use crate::doors::link::Links;
use crate::people::{Grants, People};
use crate::relay::{Recorder, Relay};
use api::{ExportQuery, Recorded, System, TrackPoint, TrackQuery, Update};
use metrics_exporter_prometheus::PrometheusHandle;
use std::collections::BTreeSet;
use std::io::Write;
use std::sync::Arc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub(crate) struct AppState {
    /// As the server was started.
    pub(crate) config: Arc<Config>,
    /// Accounts, sessions, tokens.
    pub(crate) people: People,
    /// The fleet as it is.
    pub(crate) fleet: Fleet,
    /// The fleet as it was; `None` where nothing is recorded.
    pub(crate) history: Option<Arc<dyn History>>,
    /// Figures for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// Says that the server is about to end.
    pub(crate) stop: CancellationToken,
    /// Sockets that outlive their request; the end waits for them.
    pub(crate) tasks: TaskTracker,
    /// The vessels that came in by the link.
    pub(crate) links: Links,
    /// The hub: routing and the fleet's state.
    pub(crate) relay: Relay,
    /// The archive and history.
    pub(crate) recorder: Recorder,
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
    /// All wanted systems as they are.
    pub(crate) systems: Vec<System>,
    /// Series with a new value.
    pub(crate) values: Vec<Update>,
    /// Events, in order.
    pub(crate) events: Vec<Update>,
    /// Events that were forgotten since.
    pub(crate) events_missed: u64,
}

/// What was recorded. All of it may take long and is called where that is allowed.
pub(crate) trait History: Send + Sync + 'static {
    /// Which messages there are of which system.
    ///
    /// # Errors
    /// The history cannot be read.
    fn recorded(&self) -> anyhow::Result<Vec<Recorded>>;

    /// A track, simplified to the points asked for.
    ///
    /// # Errors
    /// The history cannot be read.
    fn track(&self, vessel: u16, query: &TrackQuery) -> anyhow::Result<Vec<TrackPoint>>;

    /// Writes CSV of the vessels that `may` admits. Stops when `out` fails, which it does when nobody reads any
    /// more.
    ///
    /// # Errors
    /// The history cannot be read, or `out` failed.
    fn export(
        &self,
        query: &ExportQuery,
        may: &dyn Fn(u16) -> bool,
        out: &mut dyn Write,
    ) -> anyhow::Result<()>;
}
