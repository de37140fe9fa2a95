//! `lutra-server serve`.

use super::say::say;
use super::{Common, files};
use crate::{Serving, log};
use anyhow::Context as _;
use clap::Args;
use service::journal::VesselNames;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// How soon the journal has the name of a vessel that was just named.
const NAMES_EVERY: Duration = Duration::from_secs(5);

#[derive(Debug, Args)]
pub(super) struct ServeArguments {
    /// Address and port of the web pages [default: 127.0.0.1:8080]; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = listen)]
    listen: Option<SocketAddr>,
}

fn listen(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| "write an address and a port, like 127.0.0.1:8080 or [::1]:8080".to_owned())
}

/// Runs the server until a signal that ends it.
pub(super) fn serve(common: &Common, arguments: &ServeArguments) -> anyhow::Result<()> {
    let listen = arguments.listen.map(|listen| ("http.listen".to_owned(), listen.to_string()));
    let config = common.load(listen.into_iter().collect())?;
    let names = VesselNames::default();
    log::start(&config.log, &names);
    if let Err(problem) = files::raise(&config) {
        tracing::warn!("{problem}");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .context("cannot start the runtime")?;
    let ended = runtime.block_on(async {
        let mut terminate = signal(SignalKind::terminate())?;
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut hang_up = signal(SignalKind::hangup())?;
        let scheme = if config.tls.is_given() { "https" } else { "http" };
        let serving = crate::serve(config).await?;
        say!("listening {scheme}://{}", serving.address);
        if let Some(address) = serving.transports.imcproxy {
            say!("imcproxy ws://{address}");
        }
        if let Some(address) = serving.transports.udp {
            say!("udp {address}");
        }
        if let Some((name, password)) = serving.first_admin() {
            say!("first start: log in as {name} with the one-time password {password}");
        }
        let lifeline = service::Lifeline::start().context("cannot start a thread")?;
        service::ready();
        let lost = tokio::select! {
            _ = terminate.recv() => None,
            _ = interrupt.recv() => None,
            lost = serving.failed() => Some(lost),
            () = beat(&serving, &lifeline) => None,
            () = tell_names(&serving, &names) => None,
            () = reload_when_asked(&serving, &mut hang_up) => None,
        };
        tracing::info!("stopping");
        service::ending();
        serving.stop().await;
        match lost {
            None => Ok(()),
            Some(lost) => anyhow::bail!(
                "{lost} was lost to a fault; everything that could be saved is saved. Restart the server; the log says \
                 where the fault is"
            ),
        }
    });
    // A thread that waits for a disk that hangs must not keep the program running.
    runtime.shutdown_background();
    ended
}

/// Gives the journal the names of the vessels, as they are now and whenever that is another list.
async fn tell_names(serving: &Serving, names: &VesselNames) {
    let mut due = tokio::time::interval(NAMES_EVERY);
    loop {
        due.tick().await;
        names.set(serving.vessel_names().await);
    }
}

/// Reads the certificate again at each SIGHUP, as `systemctl reload` sends it.
async fn reload_when_asked(serving: &Serving, hang_up: &mut Signal) {
    while hang_up.recv().await.is_some() {
        serving.reload().await;
    }
    std::future::pending::<()>().await;
}

/// Feeds systemd's watchdog while the hub, which everything depends on, answers. A disk that hangs is no reason for a
/// restart: queued data would be lost.
async fn beat(serving: &Serving, lifeline: &service::Lifeline) {
    let Some(every) = service::watched_every() else { return std::future::pending().await };
    let mut due = tokio::time::interval(every / 2);
    loop {
        due.tick().await;
        if serving.hub_answers().await {
            lifeline.beat();
        }
    }
}
