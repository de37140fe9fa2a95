//! What a shore server does, without HTTP: supervised services that pages, programs, the demo and tests use alike.
//!
//! [`Shore`] holds one handle for each service. Whoever owns state is a task or a thread, watched by [`owners`]; others send
//! it typed requests over bounded channels, or read what it publishes. Everything that commands a vessel goes through
//! [`commands::Commands`].
//!
//! - [`router::Router`]: the task that owns the hub and what people do with it ([`operations::Operations`]).
//! - [`commands`]: control, orders, STOP, steering by hand; [`alarms`]; [`reports`] of vessels.
//! - [`links`]: the vessel link's sessions; the sockets are the server's.
//! - [`recorder`], [`history`], [`sinks`], [`backup`]: what is kept.
//! - [`charts`], [`routing`], [`plans`], [`identity`]: the sea chart, routes on it, plans as people draw them, accounts
//!   and the audit log.
//! - [`areas`]: what people close to all vessels.
//! - [`logbook`], [`missions`], [`register`]: what people write down; [`datasets`]: what they publish and share.
//! - [`notices`]: alarms told by mail and webhook.
//!
//! It may know every crate below it, and knows nothing of HTTP, pages, or how a server is configured: each service has
//! settings of its own.
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
pub mod links;
pub mod logbook;
pub mod missions;
pub mod notices;
mod once;
pub mod owners;
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
    /// What is wrong.
    pub alarms: Alarms,
    /// What vessels report when they are asked.
    pub reports: Reports,
    /// Accounts, sessions, tokens.
    pub people: People,
    /// The fleet as it is.
    pub fleet: Fleet,
    /// The fleet as it was.
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
    /// Missions that people record.
    pub missions: Missions,
    /// The register of studies: tags, animals, receivers.
    pub register: Register,
    /// Datasets that researchers publish, and links to them.
    pub datasets: Datasets,
    /// Messages about alarms.
    pub notices: Notices,
    /// The vessels that came in by the link.
    pub links: Links,
    /// Who steers which vessel by hand.
    pub helms: Helms,
    /// The hub: routing and the fleet's state.
    pub router: Router,
    /// The archive and history.
    pub recorder: Recorder,
    /// What everything here is decided and recorded by.
    pub clock: Clock,
    /// Whether those who own state are there.
    pub owners: Owners,
    /// How each store that follows the archive gets on.
    pub sinks: Vec<watch::Receiver<SinkState>>,
    /// Says that the server is about to end.
    pub stop: CancellationToken,
    /// Work that outlives its request; the end waits for it.
    pub tasks: TaskTracker,
}

impl Shore {
    /// Begins to steer a vessel by hand from one window.
    pub fn steering(&self, vessel: Address, by: Issuer) -> Steering {
        Steering::new(self.commands.clone(), self.links.clone(), self.helms.clone(), vessel, by)
    }
}
