//! What every handler may reach: the configuration and the handles of the tasks that own state.

use crate::config::Config;
use crate::relay::{Recorder, Relay};
use metrics_exporter_prometheus::PrometheusHandle;
use std::sync::Arc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub struct AppState {
    /// As the server was started.
    pub(crate) config: Arc<Config>,
    /// Figures for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// Says that the server is about to end.
    pub(crate) stop: CancellationToken,
    /// Sockets that outlive their request; the end waits for them.
    pub(crate) tasks: TaskTracker,
    /// The hub: routing and the fleet's state.
    pub(crate) relay: Relay,
    /// The archive and history.
    pub(crate) recorder: Recorder,
}
