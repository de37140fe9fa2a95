//! The services of a shore server, without HTTP: supervised, and used alike by pages, programs, the demo and tests.
//!
//! [`Shore`] holds one handle for each service. Each piece of state is owned by one task or thread, watched by [`owners`];
//! others send it typed requests over bounded channels, or read what it publishes. Everything that commands a vessel goes
//! through [`commands::Commands`].
//!
//! - [`router::Router`]: the task that owns the hub, leases, commands and alarms ([`operations::Operations`]).
//! - [`commands`]: control, orders, STOP, steering by hand; [`alarms`]; [`reports`] of vessels.
//! - [`Shore::vessel`]: which vessels are known, by name or address.
//! - [`links`]: the vessel link's sessions; the sockets are the server's.
//! - [`recorder`], [`history`], [`sinks`], [`backup`]: recording and storage.
//! - [`charts`], [`routing`], [`plans`], [`identity`]: the sea chart, routes on it, plans, accounts and the audit log.
//! - [`areas`]: no-go areas for all vessels.
//! - [`logbook`], [`missions`], [`register`]: records that people keep; [`datasets`]: data that they publish and share.
//! - [`notices`]: alarms sent by mail and webhook.
//!
//! It may depend on every crate below it, and has no knowledge of HTTP, pages, or the server's configuration: each service
//! has its own settings.
pub mod alarms;
pub mod areas;
pub mod backup;
pub mod charts;
pub mod clock;
pub mod commands;
pub mod datasets;
mod decode;
mod error;
pub mod fleet;
pub mod folder;
pub mod history;
pub mod identity;
mod known;
mod leisure;
pub mod links;
pub mod logbook;
pub mod missions;
mod months;
pub mod notices;
mod once;
pub mod owners;
mod packing;
mod parameters;
pub mod plans;
pub mod private;
pub mod recorder;
pub mod register;
pub mod reports;
pub mod router;
pub mod routing;
mod selection;
mod settings;
pub mod sinks;
mod start;
mod tls;
pub mod words;

pub use error::{Detail, Error, ErrorKind, Result};
pub use selection::{Changes, Wanted};
pub use settings::Settings;
pub use start::{Opened, Running};

use crate::alarms::Alarms;
use crate::areas::NoGoAreas;
use crate::charts::Charts;
use crate::clock::Clock;
use crate::commands::steering::Steering;
use crate::commands::{Commands, Grounding, Helms, Issuer};
use crate::datasets::Datasets;
use crate::fleet::Fleet;
use crate::history::{History, Imports};
use crate::identity::People;
use crate::links::Links;
use crate::logbook::Logbook;
use crate::missions::Missions;
use crate::notices::Notices;
use crate::owners::Owners;
use crate::recorder::Recorder;
use crate::register::Register;
use crate::reports::Reports;
use crate::router::Router;
use crate::routing::Routing;
use crate::sinks::SinkState;
use imc::Address;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// The services of a running shore.
pub struct Shore {
    /// Control, orders and STOP.
    pub commands: Commands,
    /// The guard against grounding.
    pub grounding: Grounding,
    /// Alarms of vessels and of the server.
    pub alarms: Alarms,
    /// Reports of vessels on request.
    pub reports: Reports,
    /// Accounts, sessions, tokens.
    pub people: People,
    /// The present state of the fleet.
    pub fleet: Fleet,
    /// The recorded history of the fleet.
    pub history: History,
    /// Logs that were uploaded.
    pub imports: Imports,
    /// The sea chart.
    pub charts: Charts,
    /// No-go areas, which the sea chart holds.
    pub areas: NoGoAreas,
    /// Routes on the sea chart.
    pub routing: Routing,
    /// The log book that people keep.
    pub logbook: Logbook,
    /// Recorded missions.
    pub missions: Missions,
    /// The register of studies: tags, animals, receivers.
    pub register: Register,
    /// Datasets that researchers publish, and links to them.
    pub datasets: Datasets,
    /// Messages about alarms.
    pub notices: Notices,
    /// The vessels' links.
    pub links: Links,
    /// The vessels that are steered by hand.
    pub helms: Helms,
    /// The hub: routing and the fleet's state.
    pub router: Router,
    /// The archive and history.
    pub recorder: Recorder,
    /// The clock of all services.
    pub clock: Clock,
    /// Watches the owners of state.
    pub owners: Owners,
    /// State of each sink that follows the archive.
    pub sinks: Vec<watch::Receiver<SinkState>>,
    /// Cancelled when the server is about to end.
    pub stop: CancellationToken,
    /// Tasks that outlive their request; the shutdown waits for them.
    pub tasks: TaskTracker,
}

impl Shore {
    /// Begins to steer a vessel by hand from one window.
    pub fn steering(&self, vessel: Address, by: Issuer) -> Steering {
        Steering::new(self.commands.clone(), self.links.clone(), self.helms.clone(), vessel, by)
    }
}
