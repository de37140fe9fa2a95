//! Starts everything a running server consists of and ends it in order.

use super::listen::Web;
use super::stop::Stops;
use super::{orders, routes};
use crate::charts::{Charts, ChartsAboard};
use crate::config::Config;
use crate::doors::link::Links;
use crate::doors::{self, Open};
use crate::owners::Owners;
use crate::people::{FirstAdmin, People};
use crate::relay::{Recorder, Relay};
use crate::shore::{AppState, Fleet, Helms, History, Imports, alarms};
use crate::sinks::influx::Sink;
use crate::{folder, private, tls};
use anyhow::Context as _;
use imc::Address;
use metrics_exporter_prometheus::{PrometheusBuilder, PrometheusHandle};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use store::Store;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// How long what waits may take to get to the disk at the end.
const LAST_WRITE: Duration = Duration::from_secs(30);
/// How long open sockets may take to say good-bye.
const GOOD_BYE: Duration = Duration::from_secs(2);

/// A running server.
pub struct Serving {
    /// Where it listens.
    pub address: SocketAddr,
    /// The doors that are open.
    pub doors: Open,
    /// The hub.
    pub(crate) relay: Relay,
    /// The archive and history.
    pub(crate) recorder: Recorder,
    /// What handlers reach.
    pub(crate) state: AppState,
    pub(crate) owners: Owners,
    recording: std::thread::JoinHandle<()>,
    stop: CancellationToken,
    first: Option<FirstAdmin>,
    web: JoinHandle<()>,
    tasks: TaskTracker,
}

impl Serving {
    /// Name and one-time password of the admin made at the very first start.
    pub fn first_admin(&self) -> Option<(&str, &str)> {
        self.first.as_ref().map(|first| (first.name, first.one_time_password.as_str()))
    }

    /// Waits until one of those who own the server's state is lost to a fault, and says which. The server must end then:
    /// see [`Serving::stop`], which saves what can be saved.
    pub async fn failed(&self) -> &'static str {
        self.owners.failed().await
    }

    /// Ends the server: no new requests, running ones end, sockets are closed.
    pub async fn stop(self) {
        self.stop.cancel();
        self.web.await.ok();
        self.tasks.close();
        if tokio::time::timeout(GOOD_BYE, self.tasks.wait()).await.is_err() {
            tracing::warn!("{} sockets were cut off", self.tasks.len());
        }
        self.state.people.finish().await;
        self.recorder.close();
        let recorded = tokio::task::spawn_blocking(|| self.recording.join());
        if tokio::time::timeout(LAST_WRITE, recorded).await.is_err() {
            tracing::error!("the disk hangs: what waited for it is not recorded");
        }
    }
}

/// Starts a server; it runs until [`Serving::stop`].
///
/// # Errors
/// The address is taken or not ours, the data folder cannot be used or is none of Lutra's.
pub async fn serve(config: Config) -> anyhow::Result<Serving> {
    folder::check(&config.data)?;
    let tls = if config.tls.is_given() { Some(tls::acceptor(&config.tls)?) } else { None };
    let listener = TcpListener::bind(config.http.listen).await.with_context(|| {
        format!(
            "cannot listen on {}: choose another by --listen ADDRESS:PORT or http.listen",
            config.http.listen
        )
    })?;
    let address = listener.local_addr()?;
    let stop = CancellationToken::new();
    let (tasks, owners) = (TaskTracker::new(), Owners::default());
    for told in private::keep(&config.data).with_context(|| config.data.display().to_string())?.told(true) {
        tracing::warn!("{told}");
    }
    let store = Store::open_at_once(&config.data)?;
    for note in &store.repairs().notes {
        tracing::warn!("{note}");
    }
    let (recorder, recording) = Recorder::start(store, &owners).context("cannot start a thread")?;
    let relay = Relay::start(config.imc.settings(), recorder.clone(), &tasks, &owners, stop.clone());
    let scheme = if tls.is_some() { "wss" } else { "ws" };
    relay.ledger().opened(hub::Door::Link, format!("{scheme}://{address}/link"));
    let doors = doors::open(&config.doors, &config.data, &relay, (&tasks, &owners), &stop).await?;
    // Last of all that can fail: a one-time password that is made must also be told.
    let (people, first) = People::start(&config.data, &config.people, &owners).await?;
    // Nobody comes in before it is known who has a link.
    let (linked, trusted) = (people.linked(), config.doors.trusted());
    let believe = move |hub: &mut hub::Hub, _| {
        hub.trust_doors(trusted);
        hub.set_linked(linked.into_iter().map(Address).collect());
    };
    relay.look(believe).await?;
    let open = doors.serve(&tasks, &owners);
    let (history, imports) = (History::new(&config.data), Imports::new(&config));
    let (max_connections, proxies) = (config.http.max_connections, config.http.trusted_proxies.clone());
    let charts = Charts::new(&config);
    let (first_load, kept) = (charts.clone(), charts.clone());
    tokio::task::spawn_blocking(move || first_load.look()).await?;
    tasks.spawn(kept.keep(stop.clone()));
    let sink = Sink::new(&config.sinks.influx, &config.data, recorder.clone())?;
    let known = (charts.clone(), ChartsAboard::open(&config.data));
    let links = Links::new(relay.clone(), recorder.clone(), known, tasks.clone(), stop.clone());
    let state = AppState {
        influx: sink.as_ref().map(Sink::state),
        config: Arc::new(config),
        people,
        fleet: Fleet::new(relay.clone()),
        history,
        imports,
        charts,
        metrics: figures(&tasks, stop.clone()),
        stop: stop.clone(),
        tasks: tasks.clone(),
        links,
        helms: Helms::default(),
        stops: Stops::default(),
        relay: relay.clone(),
        recorder: recorder.clone(),
        owners: owners.clone(),
    };
    state.people.keep(&owners, &tasks, &stop);
    if let Some(sink) = sink {
        tasks.spawn(sink.run(stop.clone()));
    }
    let kept = orders::keep_log(relay.clone(), state.people.clone(), stop.clone());
    tasks.spawn(owners.watch("the log of orders", kept));
    tasks.spawn(owners.watch("the watch for alarms", alarms::watch(state.clone())));
    let web = Web { listener, tls, router: routes::router(state.clone()), max_connections, proxies };
    let web = tokio::spawn(owners.watch("the web server", web.run(stop.clone())));
    Ok(Serving { address, doors: open, relay, recorder, state, owners, recording, stop, first, web, tasks })
}

/// The recorder of figures. Only the first server of a process (tests start several) is measured.
pub(super) fn figures(tasks: &TaskTracker, stop: CancellationToken) -> PrometheusHandle {
    let recorder = PrometheusBuilder::new().build_recorder();
    let handle = recorder.handle();
    if metrics::set_global_recorder(recorder).is_err() {
        tracing::debug!("figures are recorded elsewhere");
    }
    let upkeep = handle.clone();
    tasks.spawn(async move {
        let mut interval = tokio::time::interval(Duration::from_secs(5));
        while stop.run_until_cancelled(interval.tick()).await.is_some() {
            upkeep.run_upkeep();
        }
    });
    handle
}
