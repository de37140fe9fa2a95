//! `lutra-server demo`: a server with scratch stores and simulated Otters that sail plans, all on this computer.
//!
//! Everything but hulls and sea is real: the Otters are `lutra-agent run` processes that connect by the vessel link with
//! their own tokens, and get their plans as packets through the hub. It listens on loopback only, as its password is
//! printed and need not be changed.

mod agent;
mod chart;
mod cut;
mod fleet;
mod guide;
mod past;
mod plans;
mod sail;
mod scratch;

use super::Common;
use super::say::{counted, say};
use crate::AppState;
use crate::Serving;
use crate::config::{self, Config, Overrides};
use crate::log;
use anyhow::{Context as _, bail};
use api::PlanDocument;
use api::{NewToken, Role};
use clap::Args;
use cut::{Times, Wire};
use fleet::{Link, Otter, World};
use guide::Guide;
use imc::Address;
use imc::messages::PlanSpecification;
use past::Past;
use sail::{Crew, Report};
use scratch::Scratch;
use service::journal::VesselNames;
use shore::clock;
use shore::commands::Issuer;
use shore::identity::tokens::{self, MakeLink};
use shore::identity::{
    self, Connection, Fault, one_time_password, password, persons, vessels, within_transaction,
};
use shore::plans as kept;
use std::collections::BTreeSet;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

/// Default address.
const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 8080);
/// Number of ports tried after a taken one.
const NEXT_PORTS: u16 = 20;
/// Log filter of the server: without the links that the demo cuts and ends, and the alarms that follow, which the pages show. The
/// demo says itself when it cuts a link and when an agent ends unexpectedly.
const LOG: &str = "warn,shore::links=error,shore::alarms=error";
/// How long a timed run waits for all Otters to sail.
const LONGEST_START: Duration = Duration::from_mins(1);
/// Name of the account.
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
    /// No tagged fish around the Otters.
    #[arg(long)]
    no_fish: bool,
    /// No log of another Otter's mission of yesterday.
    #[arg(long)]
    no_past: bool,
    /// No link is cut.
    #[arg(long, conflicts_with_all = ["cut_after", "cut_for", "cut_every"])]
    no_cut: bool,
    /// The link of the last Otter is cut for the first time so many seconds after it began to sail.
    #[arg(long, value_name = "S", default_value_t = 60)]
    cut_after: u64,
    /// The link stays cut for so many seconds.
    #[arg(long, value_name = "S", default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..=3600))]
    cut_for: u64,
    /// From one cut to the next, seconds.
    #[arg(long, value_name = "S", default_value_t = 240, value_parser = clap::value_parser!(u64).range(1..=86_400))]
    cut_every: u64,
}

/// Runs the demo until a signal, or for the given time.
pub(super) fn demo(common: &Common, arguments: &DemoArguments) -> anyhow::Result<()> {
    if common.config.is_some() || common.data.is_some() {
        bail!(
            "the demo brings its own configuration and data: leave --config (LUTRA_CONFIG) and --data away; --keep \
             DIR chooses its folder, --set KEY=VALUE changes a key"
        );
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .context("cannot start the runtime")?;
    // First of all: a signal that comes while the demo is set up ends it once it is, and its folder is removed.
    let signals = {
        let _runtime = runtime.enter();
        Signals::watched()?
    };
    let program = agent::find()?;
    let listen = free(arguments.listen.unwrap_or(USUAL))?;
    let scratch = if let Some(folder) = &arguments.keep {
        Scratch::kept(folder)?
    } else {
        scratch::remove_left(&std::env::temp_dir());
        Scratch::temporary()?
    };
    let config = configuration(common, listen, scratch.path())?;
    log::start(&config.log, &VesselNames::default());
    let otters = counted(arguments.otters, "simulated Otter");
    say!("A shore server and {otters}, with everything in {scratch}");
    let mut crew = Vec::new();
    for otter in fleet::otters(arguments.otters) {
        let (document, plan) = plans::drawn(&otter)?;
        crew.push(Member { otter, document, plan });
    }
    let past = (!arguments.no_past).then(|| Past::before(clock::now()));
    let access = identity::with(&config.data, async |db| admit(db, &crew, past.as_ref()).await)?;
    let chart = chart::bring_in(scratch.path(), &config.chart_set())?;
    let stage = Stage { program, folder: scratch.path().to_owned(), chart, fish: !arguments.no_fish, past };
    runtime.block_on(async {
        let (under_way, sailing) = watch::channel(BTreeSet::new());
        let enough = async {
            let Some(seconds) = arguments.seconds else { return std::future::pending().await };
            all_sail(sailing, usize::from(arguments.otters)).await;
            tokio::time::sleep(Duration::from_secs(seconds)).await;
        };
        let ended = signals.or(enough);
        let serving = crate::serve(config).await?;
        say!("server    http://{}  log in as {ADMIN} with the password {}", serving.address, access.password);
        let missing = run(serving, &stage, crew, &access, arguments.times(), under_way, ended).await?;
        if missing.is_empty() { Ok(()) } else { bail!("{}", missing.join("; ")) }
    })
}

impl DemoArguments {
    /// When links are cut, if at all.
    fn times(&self) -> Option<Times> {
        let [first, lasts, every] = [self.cut_after, self.cut_for, self.cut_every].map(Duration::from_secs);
        (!self.no_cut).then_some(Times { first, lasts, every })
    }
}

/// An Otter and its plan, in the forms for people and for the vessel.
struct Member {
    otter: Otter,
    document: PlanDocument,
    plan: PlanSpecification,
}

/// Resources of the demo.
#[derive(Clone)]
struct Stage {
    /// lutra-agent.
    program: PathBuf,
    folder: PathBuf,
    /// The chart's depth index.
    chart: PathBuf,
    fish: bool,
    past: Option<Past>,
}

/// Waits until this many Otters sail, with a time limit.
async fn all_sail(mut sailing: watch::Receiver<BTreeSet<Address>>, count: usize) {
    // The tasks that count the Otters end only with the demo.
    let all = sailing.wait_for(|all| all.len() >= count);
    tokio::time::timeout(LONGEST_START, all).await.ok();
}

/// Starts the Otters and keeps them running until `ended`. Returns what a timed run finds missing.
async fn run(
    serving: Serving,
    stage: &Stage,
    crew: Vec<Member>,
    access: &Access,
    cut: Option<Times>,
    under_way: watch::Sender<BTreeSet<Address>>,
    ended: impl Future<Output = bool>,
) -> anyhow::Result<Vec<String>> {
    let (stop, mut sailing, mut beside) = (CancellationToken::new(), JoinSet::new(), JoinSet::new());
    let shore = serving.state.shore.clone();
    let who = shore.people.by_token(&access.script).await?.context("the demo's own token")?;
    let by = Issuer { who, from: serving.address.ip().to_string(), window: String::new() };
    let (server, url) = (serving.address, format!("http://{}", serving.address));
    let Stage { program, folder, chart, fish, past } = stage;
    let world = World { chart, since: clock::now(), fish: *fish };
    let cut = cut.zip(crew.last().map(|member| member.otter.clone()));
    // The relay runs until the agents have ended.
    let whole = CancellationToken::new();
    let wire = match &cut {
        Some(_) => Some(Wire::lay(server, whole.clone()).await.context("a wire on loopback")?),
        None => None,
    };
    let guide =
        Guide { url: &url, first: &crew[0].otter, fish: *fish, past: past.as_ref(), cut: cut.as_ref() };
    let (guide, count) = (guide.to_string(), crew.len());
    fleet::prepare(folder)?;
    for (Member { otter, plan, .. }, token) in crew.into_iter().zip(&access.tokens) {
        let by_wire = cut.as_ref().filter(|(_, one)| one.address == otter.address).and(wire.as_ref());
        let link = Link { server: by_wire.map_or(server, |wire| wire.address), token: token.clone() };
        fleet::write(folder, world, &otter, Some(&link))?;
        let crew = Crew { shore: shore.clone(), by: by.clone(), under_way: under_way.clone() };
        sailing.spawn(sail::sail((otter, plan), program.clone(), folder.clone(), crew, stop.clone()));
    }
    say!("{guide}");
    if let Some(((times, otter), wire)) = cut.zip(wire) {
        let (mut sails, state, url) = (under_way.subscribe(), serving.state.clone(), url.clone());
        beside.spawn(async move {
            sails.wait_for(|all| all.contains(&otter.address)).await.ok();
            cut::again_and_again(wire, otter, times, state, url).await;
        });
    }
    if past.is_some() {
        beside.spawn(yesterday(stage.clone(), count, under_way.subscribe(), serving.state.clone(), url));
    }
    let by_clock = ended.await;
    say!("ending    the agents, then the server");
    beside.shutdown().await;
    stop.cancel();
    let mut reports = Vec::new();
    while let Some(report) = sailing.join_next().await {
        reports.push(report.context("an Otter's task broke off")?);
    }
    whole.cancel();
    let missing = report(serving, reports).await;
    // After Ctrl-C in the first second, incomplete results are no error.
    Ok(if by_clock { missing } else { Vec::new() })
}

/// Imports yesterday's log, in the background.
async fn yesterday(
    stage: Stage,
    count: usize,
    under_way: watch::Receiver<BTreeSet<Address>>,
    state: AppState,
    url: String,
) {
    let Some(past) = &stage.past else { return };
    all_sail(under_way, count).await;
    let outcome = past.bring_in(&stage.program, &stage.folder, &stage.chart, stage.fish, &state).await;
    past::tell(past, &url, outcome);
}

/// Ends the server and reports the outcome; returns what is missing.
async fn report(serving: Serving, mut reports: Vec<Report>) -> Vec<String> {
    reports.sort_by(|one, other| one.name.cmp(&other.name));
    let recording = serving.state.shore.recorder.state();
    serving.stop().await;
    for report in &reports {
        say!("{report}");
    }
    say!("{} recorded", counted(recording.borrow().recorded, "packet"));
    let mut missing: Vec<String> = reports.iter().filter_map(Report::missing).collect();
    if let Some(trouble) = &recording.borrow().trouble {
        missing.push(trouble.text.clone());
    }
    missing
}

/// The signals that end the demo.
struct Signals([Signal; 3]);

impl Signals {
    /// They are watched from here on, and no longer end the program by themselves.
    ///
    /// # Errors
    /// The system does not let them be watched.
    fn watched() -> anyhow::Result<Self> {
        let kinds = [SignalKind::terminate(), SignalKind::interrupt(), SignalKind::hangup()];
        let [terminate, interrupt, hangup] = kinds.map(signal);
        Ok(Self([terminate?, interrupt?, hangup?]))
    }

    /// Waits for one, also one that came before, or for the end of the time; true for the latter.
    async fn or(self, enough: impl Future<Output = ()>) -> bool {
        let Self([mut terminate, mut interrupt, mut hangup]) = self;
        tokio::select! {
            _ = terminate.recv() => false,
            _ = interrupt.recv() => false,
            _ = hangup.recv() => false,
            () = enough => true,
        }
    }
}

/// `wanted`, or the next free port of that address.
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

/// Defaults, as changed by `--set`; neither file nor variables, which may be for a production server.
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

/// Credentials: the admin's password, the demo's own token, and each Otter's link token in order.
struct Access {
    password: String,
    tokens: Vec<String>,
    /// The token with which the demo itself commands.
    script: String,
}

/// Makes the admin, the vessels, their tokens and their plans in a new database of people.
async fn admit(db: &mut Connection, crew: &[Member], past: Option<&Past>) -> Result<Access, Fault> {
    let (now, password) = (clock::now(), one_time_password());
    let (name, password_hash) = (ADMIN.to_owned(), password::hash(&password));
    let admin =
        persons::Add { name, password_hash, must_change: false, vessel: None, role: Some(Role::Admin), now };
    let admin = within_transaction(db, admin).await?;
    let mut links = Vec::new();
    for (index, Member { otter, document, .. }) in crew.iter().enumerate() {
        let vessel = otter.address.0;
        within_transaction(db, vessels::Add { address: vessel, name: otter.name.clone(), now }).await?;
        let link = MakeLink { label: "demo".to_owned(), vessel, days: None, now };
        links.push(within_transaction(db, link).await?.secret);
        // Further Otters sail plans of the same names elsewhere.
        if index < fleet::Pattern::ALL.len() {
            let change = kept::Change { author: ADMIN.to_owned(), now, draft: false };
            within_transaction(db, kept::Create { plan: document.clone(), change }).await?;
        }
    }
    if let Some(past) = past {
        within_transaction(db, past.vessel(now)).await?;
    }
    let new = NewToken { label: "demo".to_owned(), vessel: None, role: Role::Operator, days: 30 };
    let script = within_transaction(db, tokens::Make { person: admin, new, now }).await?.secret;
    Ok(Access { password, tokens: links, script })
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
