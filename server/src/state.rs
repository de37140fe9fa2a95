//! State that is shared by all handlers.

use crate::backups::Watched;
use crate::config::Config;
use crate::pages::Manual;
use metrics_exporter_prometheus::PrometheusHandle;
use shore::Shore;
use std::sync::Arc;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub(crate) struct AppState {
    /// Configuration of the server.
    pub(crate) config: Arc<Config>,
    /// The services.
    pub(crate) shore: Arc<Shore>,
    /// Last known state of the configured backup.
    pub(crate) backup: Watched,
    /// Metrics for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// The manual that the pages link to.
    pub(crate) manual: Manual,
}
