//! `lutra-server demo`: a server with scratch stores and simulated Otters that sail plans, all on this computer.
//!
//! Everything is what it is in earnest: the Otters are real `lutra-agent run` processes that come in by the vessel
//! link with tokens of their own, and get their plans as packets through the hub. Only the hulls and the sea are
//! simulated. It listens on loopback only, for its password is printed and need not be changed.

mod agent;
mod chart;
mod fleet;
mod plans;
mod sail;
mod scratch;

use super::Common;
use super::say::say;
use crate::Serving;
use crate::clock;
use crate::config::{self, Config, Overrides};
use crate::log;
use crate::people::{self, Fault, db, one_time_password, password, persons, tokens, vessels};
use anyhow::{Context as _, bail};
use api::Role;
use clap::Args;
use fleet::Otter;
use sail::{Report, Shore};
use scratch::Scratch;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

/// Where it listens unless told.
const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 8080);
/// Ports after a taken one that are tried.
const NEXT_PORTS: u16 = 20;
/// What the server logs: not that links go down when the demo ends the agents, and of an agent's own end it tells.
const LOG: &str = "warn,server::doors::link=error";
/// How long an end by the clock waits for all Otters to sail.
const LONGEST_START: Duration = Duration::from_mins(1);
/// Who may log in.
const ADMIN: &str = "admin";

#[derive(Debug, Args)]
pub(super) struct DemoArguments {
    /// Simulated Otters.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=24))]
    otters: u16,
    /// Use this folder, which must be new or empty, and keep it; without this everything is removed at the end.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Loopback address and port of the web pages; the next free port is taken [default: 127.0.0.1:8080].
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<SocketAddr>,
    /// End so many seconds after all Otters have begun to sail; one that has not after a minute is an error.
    #[arg(long, value_name = "S", env = "LUTRA_DEMO_SECONDS")]
    seconds: Option<u64>,
}

/// Runs the demo until a signal, or as long as told.
pub(super) fn demo(common: &Common, arguments: &DemoArguments) -> anyhow::Result<()> {
    if common.config.is_some() || common.data.is_some() {
        bail!(
            "the demo brings its own configuration and data: leave --config (LUTRA_CONFIG) and --data away; --keep \
             DIR chooses its folder, --set KEY=VALUE changes a key"
        );
    }
    let program = agent::find()?;
    let listen = free(arguments.listen.unwrap_or(USUAL))?;
    let scratch = match &arguments.keep {
        Some(folder) => Scratch::kept(folder)?,
        None => Scratch::temporary()?,
    };
    let config = configuration(common, listen, scratch.path())?;
    log::start(&config.log);
    let plural = if arguments.otters == 1 { "" } else { "s" };
    say!("A shore server and {} simulated Otter{plural}, with everything in {scratch}", arguments.otters);
    let otters = fleet::otters(arguments.otters);
    let access = admit(&config.data, &otters)?;
    let chart = chart::bring_in(scratch.path(), &config.chart_set())?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .context("cannot start the runtime")?;
    runtime.block_on(async {
        let (under_way, sailing) = watch::channel(0);
        let enough = async move {
            let Some(seconds) = arguments.seconds else { return std::future::pending().await };
            let mut sailing = sailing;
            // The task that counts ends only with the demo.
            let all = sailing.wait_for(|count| *count >= arguments.otters);
            tokio::time::timeout(LONGEST_START, all).await.ok();
            tokio::time::sleep(Duration::from_secs(seconds)).await;
        };
        let ended = ended(enough)?;
        let serving = crate::serve(config).await?;
        say!("server    http://{}  log in as {ADMIN} with the password {}", serving.address, access.password);
        fleet::write(scratch.path(), serving.address, &otters, &access.tokens, &chart, clock::now())?;
        let missing = run(serving, &program, scratch.path(), otters, under_way, ended).await?;
        if missing.is_empty() { Ok(()) } else { bail!("{}", missing.join("; ")) }
    })
}

/// Starts the Otters and keeps them going until `ended`. What an end by the clock finds missing.
async fn run(
    serving: Serving,
    program: &Path,
    folder: &Path,
    otters: Vec<Otter>,
    under_way: watch::Sender<u16>,
    ended: impl Future<Output = bool>,
) -> anyhow::Result<Vec<String>> {
    let (stop, mut sailing) = (CancellationToken::new(), JoinSet::new());
    for otter in otters {
        let (program, folder) = (program.to_owned(), folder.to_owned());
        let shore = Shore { relay: serving.relay.clone(), under_way: under_way.clone() };
        sailing.spawn(sail::sail(otter, program, folder, shore, stop.clone()));
    }
    say!(
        "look at   the map, where the Otters move; the latest values of the one chosen; CSV of EstimatedState or"
    );
    say!("          TBRFishTag (they hear three tagged fish). Ctrl-C ends the demo.");
    let by_clock = ended.await;
    say!("ending    the agents, then the server");
    stop.cancel();
    let mut reports: Vec<Report> = Vec::new();
    while let Some(report) = sailing.join_next().await {
        reports.push(report.context("an Otter's task broke off")?);
    }
    reports.sort_by(|one, other| one.name.cmp(&other.name));
    let recording = serving.recorder.state();
    serving.stop().await;
    for report in &reports {
        say!("{report}");
    }
    say!("{} packets recorded", recording.borrow().recorded);
    let mut missing: Vec<String> = reports.iter().filter_map(Report::missing).collect();
    if let Some(trouble) = &recording.borrow().trouble {
        missing.push(trouble.text.clone());
    }
    // Whoever presses Ctrl-C in the first second knows that nothing has happened yet.
    Ok(if by_clock { missing } else { Vec::new() })
}

/// Waits for a signal or for the time to be up; true for the latter.
fn ended(enough: impl Future<Output = ()>) -> anyhow::Result<impl Future<Output = bool>> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut hangup = signal(SignalKind::hangup())?;
    Ok(async move {
        tokio::select! {
            _ = terminate.recv() => false,
            _ = interrupt.recv() => false,
            _ = hangup.recv() => false,
            () = enough => true,
        }
    })
}

/// `wanted`, or where its port is taken the next free one of that address.
fn free(wanted: SocketAddr) -> anyhow::Result<SocketAddr> {
    if !wanted.ip().is_loopback() {
        bail!(
            "--listen {wanted} is beyond loopback, where the demo's printed password would open the server to \
             everybody: use 127.0.0.1 or [::1], or `lutra-server serve` for more than a demo"
        );
    }
    let last = wanted.port().saturating_add(NEXT_PORTS);
    for port in wanted.port()..=last {
        let address = SocketAddr::new(wanted.ip(), port);
        match TcpListener::bind(address) {
            Ok(listener) => {
                if port != wanted.port() {
                    say!("port {} is taken; {port} is free", wanted.port());
                }
                return Ok(listener.local_addr()?);
            }
            Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {}
            Err(error) => return Err(error).with_context(|| format!("cannot listen on {address}")),
        }
    }
    bail!(
        "the ports {} to {last} of {} are all taken: choose another by --listen",
        wanted.port(),
        wanted.ip()
    )
}

/// Defaults, as changed by `--set`; neither file nor variables, which may be meant for a server in earnest.
fn configuration(common: &Common, listen: SocketAddr, folder: &Path) -> anyhow::Result<Config> {
    let own = |key: &str, value: String| (key.to_owned(), value);
    let mut flags = vec![own("log.level", LOG.to_owned()), own("http.listen", listen.to_string())];
    flags.extend(common.set.iter().cloned());
    flags.push(own("data", folder.join("shore").display().to_string()));
    let config = config::load(None, &Overrides { flags, ..Overrides::default() })?;
    if !config.http.listen.ip().is_loopback() || config.tls.is_given() {
        bail!("the demo listens on loopback and unencrypted: leave http.listen and tls away");
    }
    Ok(config)
}

/// What opens the server: the admin's password, and each Otter's link token in their order.
struct Access {
    password: String,
    tokens: Vec<String>,
}

/// Makes the admin, the vessels and their tokens in a new database of people.
fn admit(data: &Path, otters: &[Otter]) -> Result<Access, Fault> {
    let mut connection = people::open(data)?;
    db::within_transaction(&mut connection, |db| {
        let (now, password) = (clock::now(), one_time_password());
        let admin = persons::add(db, ADMIN, &password::hash(&password), false, now)?;
        persons::set_permission(db, admin, None, Some(Role::Admin))?;
        let mut made = Vec::new();
        for otter in otters {
            vessels::add(db, otter.address.0, &otter.name, now)?;
            let link = tokens::NewLink { label: "demo", vessel: otter.address.0, days: None };
            made.push(tokens::make_link(db, &link, now)?.secret);
        }
        Ok(Access { password, tokens: made })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_loopback_it_does_not_listen() {
        for beyond in ["0.0.0.0:0", "10.0.0.1:8080", "[::]:0"] {
            let told = free(beyond.parse().unwrap()).unwrap_err().to_string();
            assert!(told.contains("beyond loopback"), "{told}");
        }
        let common =
            Common { config: None, data: None, set: vec![("http.listen".into(), "0.0.0.0:0".into())] };
        let set = configuration(&common, USUAL, "/nowhere".as_ref());
        assert!(set.unwrap_err().to_string().contains("loopback"));
    }

    #[test]
    fn a_taken_port_is_passed_over() {
        let taken = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let keep = TcpListener::bind(taken).unwrap();
        let found = free(taken).unwrap();
        assert!(found.port() > taken.port() && found.ip() == taken.ip());
        drop(keep);
    }
}
