//! What every handler may reach.

use crate::backups::Watched;
use crate::config::Config;
use crate::pages::Manual;
use metrics_exporter_prometheus::PrometheusHandle;
use shore::Shore;
use std::sync::Arc;

/// Shared by all handlers; cheap to clone.
#[derive(Clone)]
pub(crate) struct AppState {
    /// As the server was started.
    pub(crate) config: Arc<Config>,
    /// The services.
    pub(crate) shore: Arc<Shore>,
    /// How the configured backup was found last.
    pub(crate) backup: Watched,
    /// Figures for Prometheus.
    pub(crate) metrics: PrometheusHandle,
    /// The manual that the pages link to.
    pub(crate) manual: Manual,
}
