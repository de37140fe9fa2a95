//! What every handler may reach: the configuration and the handles of the tasks that own state.

use crate::config::Config;
use crate::people::People;
use metrics_exporter_prometheus::PrometheusHandle;
use std::sync::Arc;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub struct AppState {
    /// As the server was started.
    pub(crate) config: Arc<Config>,
    /// Accounts, sessions, tokens.
    pub(crate) people: People,
    /// Figures for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// Says that the server is about to end.
    pub(crate) stop: CancellationToken,
    /// Sockets that outlive their request; the end waits for them.
    pub(crate) tasks: TaskTracker,
}
