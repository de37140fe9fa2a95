//! The vessel in real time: one loop that owns the brain, the simulated hull, the log and the plans on disk.

use crate::host::Host;
use crate::journal::{Journal, Room};
use crate::net::{Event, Net, Ports};
use crate::recording::{Beginning, Recorder};
use crate::say::{Console, complain, say};
use crate::setup;
use crate::store::Store;
use crate::world::{Happening, World};
use anyhow::{Context as _, bail};
use clap::Args;
use config::Config;
use config::schema::transport;
use onboard::{Brain, Entity, Input, Keep, Level, Now, Output, Peer};
use sim::Vessel;
use std::io::Write as _;
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use units::{MonoTime, UtcTime};

/// The loop looks at the signals at least this often.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
const SECOND: Duration = Duration::from_secs(1);
/// Events taken before the brain's own deadlines are looked at again.
const EVENTS_AT_ONCE: usize = 64;

#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// The main configuration file, in DUNE's .ini dialect.
    config: PathBuf,
    /// Profile; only Simulation has devices so far.
    #[arg(long, default_value = "Simulation")]
    profile: String,
    /// Folder for plans, logs and saved parameters.
    #[arg(long, default_value = "lutra-data")]
    data: PathBuf,
    /// Record everything the brain is told and wants, for `replay`.
    #[arg(long)]
    record: Option<PathBuf>,
    /// Listen on this address only.
    #[arg(long, default_value = "0.0.0.0")]
    bind: Ipv4Addr,
    /// UDP port in place of the configured one; 0 lets the system choose.
    #[arg(long)]
    udp_port: Option<u16>,
    /// TCP port in place of the configured one; 0 lets the system choose.
    #[arg(long)]
    tcp_port: Option<u16>,
    /// Announcement port in place of the configured ones; 0 lets the system choose.
    #[arg(long)]
    announce_port: Option<u16>,
    /// Print only warnings and errors.
    #[arg(long)]
    quiet: bool,
}

/// Everything the loop owns.
struct Agent {
    world: World,
    net: Net,
    journal: Journal,
    store: Store,
    host: Host,
    recorder: Option<Recorder>,
    config: Config,
    logs: PathBuf,
    quiet: bool,
    console: Console,
    happened: Vec<(Now, Happening)>,
}

pub(crate) fn run(arguments: &RunArguments) -> anyhow::Result<()> {
    if arguments.profile != "Simulation" {
        bail!("the profile `{}` needs device drivers, which this version does not have", arguments.profile);
    }
    let ending = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&ending)).context("signals")?;
    }
    let config = setup::load(&arguments.config, &arguments.profile)?;
    // The vessel's clock counts from here, not from the end of the start: its times would lag by that.
    let started = Instant::now();
    let mut agent = Agent::start(arguments, config)?;
    say!("listening {}", agent.net.listening);
    std::io::stdout().flush().ok();
    let mut next_host = Duration::ZERO;
    while !ending.load(Ordering::Relaxed) {
        let elapsed = started.elapsed();
        agent.catch_up(elapsed);
        if elapsed >= next_host {
            next_host = elapsed + SECOND;
            let reading = agent.host.read(&agent.logs);
            agent.tell(Input::Host(reading));
            agent.keep_time();
        }
        agent.wait(started)?;
    }
    agent.tell(Input::Shutdown);
    agent.journal.close(agent.world.now().utc);
    if let Some(recorder) = &mut agent.recorder {
        recorder.flush()?;
    }
    let (dropped, unsent) = (agent.net.dropped(), agent.net.unsent);
    say!("motors stopped, log closed; datagrams dropped: {dropped}, not sent: {unsent}");
    Ok(())
}

impl Agent {
    fn start(arguments: &RunArguments, config: Config) -> anyhow::Result<Self> {
        let utc = utc_now()?;
        // A number that differs at every start, as others expect of it.
        let uid = utc.micros().unsigned_abs() / 1000;
        let (settings, doubts) = setup::settings(&config, uid)?;
        let vessel = Vessel::new(&setup::vessel(&config, utc, uid)?)?;
        let (store, kept, unreadable) = Store::open(&arguments.data.join("plans"))?;
        let now = Now { mono: MonoTime::default(), utc };
        let text = config.ini().to_text().map_err(|error| anyhow::anyhow!("{error}"))?;
        let logs = arguments.data.join("logs").join(&settings.name);
        std::fs::create_dir_all(&logs).with_context(|| format!("making {}", logs.display()))?;
        let room =
            config.running(&transport::logging::LOGGING).next().map_or(Room::default(), |section| Room {
                remove_oldest: section.get(&transport::logging::REMOVE_OLDEST),
                keep_free_mib: section.get(&transport::logging::KEEP_FREE).unsigned_abs(),
            });
        let journal = Journal::new(&logs, settings.address, Entity::Logger.number(), text.clone());
        let journal = journal.with_room(room);
        let recorder = match &arguments.record {
            Some(path) => {
                let profile = arguments.profile.clone();
                let beginning = Beginning { config: text, profile, uid, now, kept: kept.clone() };
                Some(Recorder::create(path, &beginning)?)
            }
            None => None,
        };
        let net = Net::open(&ports(arguments, &config))?;
        let mut world = World::new(vessel, Brain::new(settings, now, kept)?);
        world.virtual_disk = false;
        let mut agent = Self {
            world,
            net,
            journal,
            store,
            host: Host::new(),
            recorder,
            config,
            logs,
            quiet: arguments.quiet,
            console: Console::start(),
            happened: Vec::new(),
        };
        for doubt in doubts {
            complain!("warning: {doubt}");
        }
        for path in unreadable {
            complain!("error: the plan in {path} cannot be read; it is left where it is");
        }
        let reachable = agent.net.reachable.clone();
        agent.tell(Input::Reachable(reachable));
        Ok(agent)
    }

    /// Tells the brain something and carries out what it wants.
    fn tell(&mut self, input: Input) {
        let happened = &mut self.happened;
        self.world.tell(input, &mut |now, happening| happened.push((now, happening)));
        self.carry_out();
    }

    /// Lets the simulated world come to `elapsed`.
    fn catch_up(&mut self, elapsed: Duration) {
        let until = MonoTime::default() + elapsed;
        let happened = &mut self.happened;
        self.world.run(until, &mut |now, happening| happened.push((now, happening)));
        self.carry_out();
    }

    /// Waits for packets until the next deadline.
    fn wait(&mut self, started: Instant) -> anyhow::Result<()> {
        let due = self.world.brain.poll_timeout().unwrap_or_default().min(self.world.vessel.poll_timeout());
        let elapsed = MonoTime::default() + started.elapsed();
        let wait = due.since(elapsed).min(LONGEST_WAIT);
        let mut event = self.net.events.recv_timeout(wait);
        for _ in 0..EVENTS_AT_ONCE {
            match event {
                Ok(event) => {
                    self.catch_up(started.elapsed());
                    self.take(event);
                }
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => bail!("all sockets are closed"),
            }
            event = self.net.events.recv_timeout(Duration::ZERO);
        }
        Ok(())
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Packet(peer, bytes) => self.tell(Input::Packet(peer, bytes)),
            Event::Connected(number, client) => {
                self.net.connected(number, client);
                self.tell(Input::Connected(Peer::Tcp(number)));
            }
            Event::Disconnected(number) => {
                self.net.disconnected(number);
                self.tell(Input::Disconnected(Peer::Tcp(number)));
            }
        }
    }

    /// Carries out all that is wanted, and what is wanted because of that.
    fn carry_out(&mut self) {
        while !self.happened.is_empty() {
            for (now, happening) in std::mem::take(&mut self.happened) {
                let recorded = match (&mut self.recorder, &happening) {
                    (None, _) => Ok(()),
                    (Some(recorder), Happening::Told(input)) => recorder.told(now, input),
                    (Some(recorder), Happening::Wanted(output)) => recorder.wanted(output),
                };
                if let Err(error) = recorded {
                    complain!("error: the recording ends: {error}");
                    self.recorder = None;
                }
                if let Happening::Wanted(output) = happening {
                    self.do_one(now, output);
                }
            }
        }
    }

    fn do_one(&mut self, now: Now, output: Output) {
        match output {
            // The world has carried this out.
            Output::Motors(_) => {}
            Output::Packet { bytes, to } => {
                self.net.send(&bytes, &to);
                let written = self.journal.write(now.mono, &bytes);
                self.logged(written);
            }
            Output::Announce(bytes) => self.net.announce(&bytes),
            Output::OpenLog { label, utc } => {
                let outcome = self.journal.open(now.mono, utc, &label).map_err(|error| error.to_string());
                self.later(Input::LogOpened(outcome));
            }
            Output::CloseLog => self.journal.close(now.utc),
            Output::Keep(Keep::Plans(effect)) => {
                let outcome = self.store.carry_out(&effect).map_err(|error| format!("{error:#}"));
                self.later(Input::Stored(effect.ticket(), outcome));
            }
            Output::Keep(Keep::Parameters(label, values)) => {
                if let Err(error) = self.save(&label, &values) {
                    self.later(Input::NotKept(format!("parameters of {label}: {error:#}")));
                }
            }
            Output::Console(level, text) => self.print(now, level, &text),
        }
    }

    /// Tells the brain of the outcome of what it wanted; what it wants then is carried out after the rest.
    fn later(&mut self, input: Input) {
        let happened = &mut self.happened;
        self.world.tell(input, &mut |now, happening| happened.push((now, happening)));
    }

    fn logged(&mut self, outcome: std::io::Result<()>) {
        if let Err(error) = outcome {
            self.later(Input::LogOpened(Err(error.to_string())));
        }
    }

    /// What the log and the recording need once a second.
    fn keep_time(&mut self) {
        let now = self.world.now();
        match self.journal.tick(now.mono, now.utc) {
            Ok(None) => {}
            Ok(Some(opened)) => self.tell(Input::LogOpened(opened.map_err(|error| error.to_string()))),
            Err(error) => self.tell(Input::LogOpened(Err(error.to_string()))),
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.flush().ok();
        }
    }

    fn print(&mut self, now: Now, level: Level, text: &str) {
        let name = match level {
            Level::Debug => "debug",
            Level::Info => "info",
            Level::Warning => "warning",
            Level::Error => "error",
        };
        if level >= Level::Warning || (!self.quiet && level >= Level::Info) {
            self.console.line(format!("{} {name}: {text}", now.utc));
        }
        let written = self.journal.line(now.mono, &format!("[{}] - {name} - {text}", now.utc));
        self.logged(written);
    }

    /// Writes changed parameters beside the main file, to be read after all others at the next start.
    fn save(&mut self, label: &str, values: &[(String, String)]) -> anyhow::Result<()> {
        let path = self.config.saved_path().context("the vehicle has no name for a file")?;
        let (ini, _) = config::Ini::read(&config::Disk, &path);
        let mut saved = config::Saved::from_ini(&ini);
        setup::save(&self.config, &mut saved, label, values)?;
        let text = saved.to_text().map_err(|error| anyhow::anyhow!("{error}"))?;
        config::write_atomically(&path, &text).with_context(|| format!("writing {}", path.display()))
    }
}

fn ports(arguments: &RunArguments, config: &Config) -> Ports {
    let port = |number: i64| u16::try_from(number).unwrap_or(0);
    let udp =
        config.running(&transport::udp::UDP).next().map_or(6002, |s| port(s.get(&transport::udp::PORT)));
    let tcp = config.running(&transport::tcp::SERVER).next();
    let tcp = tcp.map_or(7001, |section| port(section.get(&transport::tcp::PORT)));
    let announce = config.running(&transport::announce::ANNOUNCE).next();
    let announce = announce.map_or((30_100..=30_104).collect(), |section| {
        section.get(&transport::announce::PORTS).into_iter().map(port).collect::<Vec<_>>()
    });
    Ports {
        bind: arguments.bind,
        udp: arguments.udp_port.unwrap_or(udp),
        tcp: arguments.tcp_port.unwrap_or(tcp),
        announce: arguments.announce_port.map_or(announce, |port| vec![port]),
    }
}

fn utc_now() -> anyhow::Result<UtcTime> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).context("the clock is before 1970")?;
    // Until the year 294 000.
    Ok(UtcTime::from_micros(since.as_micros() as i64))
}
