//! Starts a server around the shore's services, and ends it in order.

pub(crate) mod router;
#[cfg(test)]
mod tests;

use crate::AppState;
use crate::backups::Watched;
use crate::config::Config;
use crate::pages::Manual;
use crate::tls::Keeper;
use crate::transports::{self, Open};
use crate::web::listen::Web;
use anyhow::Context as _;
use metrics_exporter_prometheus::{PrometheusBuilder, PrometheusHandle};
use shore::clock::Clock;
use shore::{Opened, Running};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// A running server.
pub struct Serving {
    /// Where it listens.
    pub address: SocketAddr,
    /// The transports that are open.
    pub transports: Open,
    /// State of the handlers.
    pub(crate) state: AppState,
    running: Running,
    web: JoinHandle<()>,
    /// Serves the certificate; `None` without encryption.
    keeper: Option<Arc<Keeper>>,
}

impl Serving {
    /// Name and one-time password of the admin made at the very first start.
    pub fn first_admin(&self) -> Option<(&str, &str)> {
        self.running.first_admin.as_ref().map(|first| (first.name, first.one_time_password.as_str()))
    }

    /// Waits until an owner of the server's state is lost, and returns its name. The server must then end: see
    /// [`Serving::stop`], which saves what it can.
    pub async fn failed(&self) -> &'static str {
        self.state.shore.owners.failed().await
    }

    /// What people and the vessels themselves call vessels, by address as the log has it.
    pub(crate) async fn vessel_names(&self) -> Vec<(String, String)> {
        let vessels = self.state.shore.people.vessels();
        let given = vessels.iter().map(|one| (imc::Address(one.address), one.name.clone()));
        // A server that is stopping hears nothing more.
        let heard = self.state.shore.fleet.heard().await.unwrap_or_default();
        let heard = heard.into_iter().filter_map(|(address, name)| Some((address, name?)));
        given.chain(heard).map(|(address, name)| (address.to_string(), name)).collect()
    }

    /// Whether the hub answers; waits without a limit.
    pub(crate) async fn hub_answers(&self) -> bool {
        self.state.shore.router.peers().await.is_ok()
    }

    /// Reads certificate and key again, and logs the result.
    pub async fn reload(&self) {
        let Some(keeper) = self.keeper.clone() else {
            tracing::info!("there is no certificate to read again; other settings are read at a start");
            return;
        };
        let (now, alarms) = (self.state.shore.clock.now(), self.state.shore.alarms.clone());
        let reload = move || {
            keeper.reload(now);
            alarms.certificate(keeper.state());
        };
        tokio::task::spawn_blocking(reload).await.ok();
    }

    /// Ends the server: no new requests, running ones end, sockets are closed.
    pub async fn stop(self) {
        self.state.shore.stop.cancel();
        self.web.await.ok();
        self.running.end().await;
    }
}

/// Starts a server; it runs until [`Serving::stop`].
///
/// # Errors
/// The address is taken or not ours, the data folder cannot be used or belongs to another program.
pub async fn serve(config: Config) -> anyhow::Result<Serving> {
    serve_by(Clock::real(), config).await
}

/// As [`serve`], with a clock that a test may move.
///
/// # Errors
/// As [`serve`].
pub async fn serve_by(clock: Clock, config: Config) -> anyhow::Result<Serving> {
    shore::folder::check(&config.data)?;
    let keeper = if config.tls.is_given() { Some(Keeper::open(&config.tls)?) } else { None };
    let tls = keeper.as_ref().map(Keeper::acceptor).transpose()?;
    let listener = TcpListener::bind(config.http.listen).await.with_context(|| {
        format!(
            "cannot listen on {}: choose another by --listen ADDRESS:PORT or http.listen",
            config.http.listen
        )
    })?;
    let address = listener.local_addr()?;
    // Before anything that reports metrics: earlier ones would be lost.
    let metrics = figures();
    let opened = Opened::open(config.shore(), clock)?;
    let scheme = if tls.is_some() { "wss" } else { "ws" };
    opened.router.ledger().opened(hub::Transport::Link, format!("{scheme}://{address}/link"));
    let waiting = transports::open(&config.transports, &config.data, &opened).await?;
    // No client is admitted before the vessels with a link are known.
    let running = opened.start().await?;
    let shore = running.shore.clone();
    let transports = waiting.serve(&shore.tasks, &shore.owners);
    let (max_connections, proxies) = (config.http.max_connections, config.http.trusted_proxies.clone());
    keep_figures(metrics.clone(), &shore.tasks, shore.stop.clone());
    let (config, backup) = (Arc::new(config), Watched::new());
    shore.tasks.spawn(backup.clone().keep(config.clone(), shore.clock.clone(), shore.stop.clone()));
    let state = AppState { config, shore: shore.clone(), backup, metrics, manual: Manual::default() };
    let web = Web { listener, tls, router: router::router(state.clone()), max_connections, proxies };
    if let Some(keeper) = keeper.clone() {
        shore.alarms.certificate(keeper.state());
        shore.tasks.spawn(keeper.keep(shore.clock.clone(), shore.alarms.clone(), shore.stop.clone()));
    }
    let web = tokio::spawn(shore.owners.watch("the web server", web.run(shore.stop.clone())));
    Ok(Serving { address, transports, state, running, web, keeper })
}

/// The recorder of metrics. Only the first server of a process (tests start several) is measured.
pub(crate) fn figures() -> PrometheusHandle {
    let recorder = PrometheusBuilder::new().build_recorder();
    let handle = recorder.handle();
    if metrics::set_global_recorder(recorder).is_err() {
        tracing::debug!("figures are recorded elsewhere");
    }
    handle
}

/// Removes old samples of metrics periodically until the server ends.
fn keep_figures(figures: PrometheusHandle, tasks: &TaskTracker, stop: CancellationToken) {
    tasks.spawn(async move {
        let mut interval = tokio::time::interval(Duration::from_secs(5));
        while stop.run_until_cancelled(interval.tick()).await.is_some() {
            figures.run_upkeep();
        }
    });
}
