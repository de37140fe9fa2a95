//! Settings of the shore, fixed at its start.

use crate::{charts, identity, notices, sinks};
use std::path::PathBuf;

/// Settings of all services.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The folder of archive, history and people.
    pub data: PathBuf,
    /// The server as a node of IMC.
    pub hub: hub::Settings,
    /// Transports besides the link at which vessels that have a link are believed.
    pub trusted: Vec<hub::Transport>,
    /// Accounts and sessions.
    pub people: identity::Settings,
    /// The sea chart.
    pub charts: charts::Settings,
    /// Other stores.
    pub sinks: sinks::Settings,
    /// Messages about alarms.
    pub notices: notices::Settings,
    /// So many days after its end a day of the archive is compressed; 0 leaves all as they are.
    pub compress_after_days: u16,
    /// So many days after its end a month of the history is compressed; 0 leaves all as they are.
    pub compress_months_after_days: u16,
    /// Bytes that an uploaded log may have, unpacked.
    pub most_unpacked_bytes: u64,
}

impl Settings {
    /// The file of the chart set.
    pub fn chart_set(&self) -> PathBuf {
        let set = &self.charts.set;
        if set.as_os_str().is_empty() { self.data.join("charts/chart.gpkg") } else { set.clone() }
    }
}
