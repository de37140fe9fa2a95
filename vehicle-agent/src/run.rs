//! The vessel in real time: one loop that owns the clock, the hull and the brain. It waits only for packets and deadlines:
//! the disk, sockets and printed lines have their own threads, and the motors a watchdog that stops them when this loop
//! stalls.

use crate::clock::Clock;
use crate::disk::recording::{Beginning, Recorder};
use crate::disk::{DataLock, Disk, Done, Store, Tools, Work, Worker};
use crate::due::{Due, noting};
use crate::ending::{Ending, Fault};
use crate::hull::Hull;
use crate::motor_gate::MotorGate;
use crate::net::{Event, Losses, Net};
use crate::routing::Routing;
use crate::say::{LogFormat, briefly, say};
use crate::sea_chart::ChartFolder;
use crate::setup;
use crate::transports::{self, Given};
use crate::trial;
use crate::uplink::{FromShore, Uplink, UplinkSettings};
use crate::vehicle::Vehicle;
use anyhow::{Context as _, bail};
use clap::Args;
use config::Config;
use link::ChartAboard;
use onboard::{Brain, COMMAND_LIFE, Chart, ChartFile, Input, Keep, LeaseGate, Level, Output, Peer};
use service::Lifeline;
use service::journal::VesselNames;
use std::io::Write as _;
use std::net::Ipv4Addr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use units::{MonoTime, Now};

mod hulls;
#[cfg(test)]
mod tests;

use hulls::{HullContext, hardware, simulated};

/// The loop checks for signals at least this often.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
const SECOND: Duration = Duration::from_secs(1);
/// Events taken before the brain's own deadlines are checked again.
const EVENTS_AT_ONCE: usize = 64;
/// How long the end waits for the disk, the motors having been stopped.
const DISK_END: Duration = Duration::from_secs(10);
/// Work that the disk could not take is reported at most this often.
const LOST_TOLD: Duration = Duration::from_secs(5);

/// The profile with a simulated hull.
pub(crate) const SIMULATION: &str = "Simulation";

/// The shore as a peer. Packets to it go over the link, which carries everything anyway.
const SHORE: Peer = Peer::Tcp(u32::MAX);

#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// The main configuration file, in DUNE's .ini dialect.
    config: PathBuf,
    /// Profile: Simulation sails a simulated hull, Hardware the devices of the configuration.
    #[arg(long, default_value = SIMULATION)]
    profile: String,
    /// Folder for plans and logs; one agent at a time may use it.
    #[arg(long, default_value = "lutra-agent-data")]
    data: PathBuf,
    /// Record all inputs and outputs of the brain, for `replay`.
    #[arg(long)]
    record: Option<PathBuf>,
    /// Listen on this address only.
    #[arg(long, default_value = "0.0.0.0")]
    bind: Ipv4Addr,
    /// UDP port in place of the configured one; 0 lets the system choose.
    #[arg(long)]
    udp_port: Option<u16>,
    /// TCP port of the first server in place of the configured one; 0 lets the system choose, for all servers.
    #[arg(long)]
    tcp_port: Option<u16>,
    /// Announcement port in place of the configured ones; 0 lets the system choose.
    #[arg(long)]
    announce_port: Option<u16>,
    /// End also when standard input ends, for a program that starts agents: they do not outlive it, not even when
    /// it is killed.
    #[arg(long)]
    end_with_stdin: bool,
    /// Form of the log on standard error.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) log_format: LogFormat,
    /// What is logged: error, warn, info, debug, trace or off, also by part as in `warn,vessel=debug`;
    /// without this the value of the variable LUTRA_LOG, else `info`.
    #[arg(long)]
    pub(crate) log_level: Option<String>,
    /// Log only warnings and errors.
    #[arg(long, conflicts_with = "log_level")]
    pub(crate) quiet: bool,
}

/// State of the loop.
struct Agent<H> {
    clock: Clock,
    gate: Arc<MotorGate>,
    vehicle: Vehicle<H>,
    net: Net,
    disk: Disk,
    routing: Routing,
    uplink: Option<Uplink>,
    /// Whether the shore's chart takes the place of the configured one.
    takes_chart: bool,
    due: Vec<Due>,
    next_second: Duration,
    next_lost: Duration,
    lapses: u64,
    _lock: DataLock,
}

/// Runs the vessel until its end. The log gets the vessel's name.
pub(crate) fn run(arguments: &RunArguments, names: &VesselNames) -> anyhow::Result<()> {
    let ending = Ending::at_signals()?;
    if arguments.end_with_stdin {
        ending.at_end_of_input()?;
    }
    let config = setup::load_aboard(&arguments.config, &arguments.profile, &arguments.data)?;
    names.steers(config.vehicle());
    // The vessel's clock counts from here, before the rest of the start: otherwise its times would lag by that.
    let clock = Clock::system();
    if arguments.profile == SIMULATION {
        Agent::start(arguments, config, clock, simulated)?.run(&ending)
    } else {
        Agent::start(arguments, config, clock, hardware)?.run(&ending)
    }
}

impl<H: Hull> Agent<H> {
    fn start(
        arguments: &RunArguments,
        config: Config,
        clock: Clock,
        build: impl FnOnce(&HullContext<'_>) -> anyhow::Result<(H, Arc<MotorGate>)>,
    ) -> anyhow::Result<Self> {
        let lock = DataLock::take(&arguments.data)?;
        let utc = clock.utc();
        // A number that differs at every start, as other systems expect.
        let uid = utc.micros().unsigned_abs() / 1000;
        let (settings, mut doubts) = setup::settings(&config, uid)?;
        doubts.extend(trial::doubts(&config, &settings));
        let given = Given {
            bind: arguments.bind,
            udp: arguments.udp_port,
            tcp: arguments.tcp_port,
            announce: arguments.announce_port,
        };
        let (ports, more) = transports::ports(&config, given);
        doubts.extend(more);
        let (store, kept, unreadable) = Store::open(&arguments.data.join("plans"))?;
        let now = Now { mono: MonoTime::default(), utc };
        let text = config.ini().to_text().map_err(|error| anyhow::anyhow!("{error}"))?;
        let logs = arguments.data.join("logs").join(&settings.name);
        std::fs::create_dir_all(&logs).with_context(|| format!("making {}", logs.display()))?;
        let journal = transports::journal(&config, &logs, &settings, &text);
        if journal.is_none() {
            tracing::warn!("no log is written: the configuration has Transports.Logging off");
        }
        let recorder = arguments.record.as_ref().map(|path| {
            let profile = arguments.profile.clone();
            Recorder::create(path, &Beginning { config: text, profile, uid, now, kept: kept.clone() })
        });
        let recorder = recorder.transpose()?;
        let shore = UplinkSettings::read(&config, &arguments.config, &arguments.data, &mut doubts)?;
        let takes_chart = setup::takes_chart(&config);
        let chart = if takes_chart { chart_of_shore(&arguments.data, &mut doubts) } else { None };
        for doubt in doubts {
            tracing::warn!("{doubt}");
        }
        for path in unreadable {
            tracing::error!("the plan in {path} cannot be read; it is left where it is");
        }
        let net = Net::open(&ports, settings.address)?;
        let context =
            HullContext { config: &config, clock: &clock, utc, seed: uid, inbox: Arc::clone(&net.inbox) };
        let (hull, gate) = build(&context)?;
        let inbox = Arc::clone(&net.inbox);
        let worker = Worker::new(Tools { journal, store, recorder, config, logs });
        let disk = Disk::start(worker, move |done| inbox.done(done))?;
        let mut vehicle = Vehicle::new(hull, Brain::new(settings, now, kept)?, now);
        vehicle.virtual_disk = false;
        vehicle.routes = None;
        let inbox = Arc::clone(&net.inbox);
        let routing = Routing::start(move |answer| inbox.route(answer))?;
        let aboard = chart_aboard(&vehicle.brain, takes_chart);
        let uplink = shore.map(|shore| start_uplink(shore, aboard, &net, clock.clone())).transpose()?;
        let mut agent = Self {
            clock,
            gate,
            vehicle,
            net,
            disk,
            routing,
            uplink,
            takes_chart,
            due: Vec::new(),
            next_second: Duration::ZERO,
            next_lost: Duration::ZERO,
            lapses: 0,
            _lock: lock,
        };
        let reachable = agent.net.reachable.clone();
        agent.tell(Input::Reachable(reachable));
        if let Some(chart) = chart {
            agent.tell(Input::Chart(chart));
            agent.tell_chart();
        }
        Ok(agent)
    }

    /// Steers until the end, and ends in order.
    fn run(mut self, ending: &Ending) -> anyhow::Result<()> {
        let lifeline = Lifeline::start().context("starting a thread")?;
        say!("listening {}", self.net.listening);
        std::io::stdout().flush().ok();
        service::ready();
        ending.at_panics(&self.gate);
        // A panic has already stopped the motors; the log is closed all the same.
        catch_unwind(AssertUnwindSafe(|| self.sail(ending, &lifeline))).ok();
        service::ending();
        self.end(ending)
    }

    /// Steers until the end.
    fn sail(&mut self, ending: &Ending, lifeline: &Lifeline) {
        while !ending.is_near() {
            self.catch_up();
            self.each_second();
            lifeline.beat();
            self.wait(ending);
        }
    }

    /// Motors first, then the log.
    fn end(mut self, ending: &Ending) -> anyhow::Result<()> {
        self.gate.end();
        // After a panic the brain is not called any more.
        if !ending.has_fault() {
            self.tell(Input::Shutdown);
            self.tell_lost();
        }
        if self.uplink.take().is_some_and(|uplink| !uplink.end()) {
            tracing::error!("the disk did not take the rest of the spool in time");
        }
        self.disk.hand(Work::Close(self.vehicle.now.utc));
        let closed = self.disk.finish(DISK_END);
        self.gate.close();
        let told = if self.vehicle.hull.end(!ending.has_fault()) {
            "motors stopped"
        } else {
            "the motors' port does not answer: the card stops them within a second"
        };
        let state = if closed { "log closed" } else { "log NOT closed" };
        let (dropped, unsent) = (self.net.inbox.dropped(), self.net.unsent);
        briefly(format!("{told}, {state}; packets dropped: {dropped}, not sent: {unsent}"));
        if ending.has_fault() {
            return Err(Fault.into());
        }
        if !closed {
            bail!("the disk did not take the rest of the log within {DISK_END:?}");
        }
        Ok(())
    }

    /// Passes an input to the brain and carries out its outputs.
    fn tell(&mut self, input: Input) {
        let (due, records) = (&mut self.due, self.disk.is_recording());
        self.vehicle.tell(input, &mut noting(due, records));
        self.carry_out();
    }

    /// Advances to the present: polls the hull and calls the brain.
    fn catch_up(&mut self) {
        let now = self.clock.now();
        let behind = now.mono.since(self.vehicle.now.mono);
        // The start may be slow, but nothing moves yet then.
        if behind > COMMAND_LIFE && self.vehicle.now.mono > MonoTime::default() {
            let held_up_s = behind.as_secs_f64();
            tracing::error!(held_up_s, "the loop was held up; the motors were stopped meanwhile");
        }
        let (due, records) = (&mut self.due, self.disk.is_recording());
        self.vehicle.come_to(now, &mut noting(due, records));
        self.carry_out();
    }

    /// Waits for events until the next deadline.
    fn wait(&mut self, ending: &Ending) {
        let due = self.vehicle.poll_timeout().unwrap_or_default();
        let elapsed = MonoTime::default() + self.clock.elapsed();
        let mut longest = due.since(elapsed).min(LONGEST_WAIT);
        for _ in 0..EVENTS_AT_ONCE {
            let Some(event) = self.net.inbox.take(longest) else { return };
            if ending.is_near() {
                return;
            }
            self.catch_up();
            self.take(event);
            longest = Duration::ZERO;
        }
    }

    fn take(&mut self, event: Event) {
        let input = match event {
            Event::Packet(peer, bytes) => Input::Packet(peer, bytes),
            Event::Order(peer, mandate, bytes) => Input::Order(peer, mandate, bytes),
            Event::Lease(lease) => Input::Lease(lease),
            Event::Connected(number) => Input::Connected(Peer::Tcp(number)),
            Event::Disconnected(number) => Input::Disconnected(Peer::Tcp(number)),
            Event::Route(answer) => Input::Route(answer),
            Event::Disk(Done::LogOpened(outcome)) => Input::LogOpened(outcome),
            Event::Disk(Done::Stored(ticket, outcome)) => Input::Stored(ticket, outcome),
            Event::Disk(Done::ParametersKept(label, outcome)) => Input::ParametersKept(label, outcome),
            Event::Disk(Done::NotKept(what)) => Input::NotKept(what),
            Event::Disk(Done::Host(reading)) => Input::Host(reading),
            Event::Disk(Done::Chart(chart)) => Input::Chart(chart),
        };
        let charted = matches!(input, Input::Chart(_));
        self.tell(input);
        if charted {
            self.tell_chart();
        }
    }

    /// Carries out all outputs.
    fn carry_out(&mut self) {
        for due in std::mem::take(&mut self.due) {
            match due {
                Due::Record(kind, bytes) => self.disk.hand(Work::Record(kind, bytes)),
                Due::Output(now, output) => self.do_one(now, output),
            }
        }
        if let Some(uplink) = &self.uplink {
            uplink.flush();
        }
    }

    fn do_one(&mut self, now: Now, output: Output) {
        match output {
            // The hull has got these already.
            Output::Motors(_) | Output::Power { .. } => {}
            Output::Packet { bytes, to } => {
                self.net.send(&bytes, &to);
                self.record(&bytes);
                self.disk.hand(Work::Packet(now.mono, bytes));
            }
            Output::Route(request) => self.routing.ask(self.vehicle.brain.chart(), request),
            Output::Announce(bytes) => self.net.announce(&bytes),
            Output::OpenLog { label, utc } => self.disk.hand(Work::Open(now.mono, utc, label)),
            Output::CloseLog => self.disk.hand(Work::Close(now.utc)),
            Output::Keep(Keep::Plans(effect)) => self.disk.hand(Work::Plans(effect)),
            Output::Keep(Keep::UnderWay(packet)) => self.disk.hand(Work::UnderWay(packet)),
            Output::Keep(Keep::Parameters(label, values)) => self.disk.hand(Work::Parameters(label, values)),
            Output::Console(level, text) => {
                let name = print(level, &text);
                self.disk.hand(Work::Line(now.mono, format!("[{}] - {name} - {text}", now.utc)));
            }
        }
    }

    /// Passes a packet of the vessel to the uplink.
    fn record(&self, packet: &[u8]) {
        if let Some(uplink) = &self.uplink {
            uplink.record(packet);
        }
    }

    /// Reports the chart in force to the shore.
    fn tell_chart(&self) {
        if let Some(uplink) = &self.uplink {
            uplink.chart(chart_aboard(&self.vehicle.brain, self.takes_chart));
        }
    }

    /// Periodic work once a second: the log's tick, and reports of losses.
    fn each_second(&mut self) {
        let elapsed = self.clock.elapsed();
        if elapsed < self.next_second {
            return;
        }
        self.next_second = elapsed + SECOND;
        let now = self.vehicle.now;
        self.disk.hand(Work::Tick(now.mono, now.utc));
        self.tell_chart();
        self.routing.keep_to(self.vehicle.brain.chart());
        let lapses = self.gate.lapses();
        if lapses > self.lapses {
            tracing::error!(
                times = lapses - self.lapses,
                "the watchdog stopped the motors: the loop was late"
            );
            self.lapses = lapses;
        }
        if let Some(Losses { dropped, withdrawn, commands }) = self.net.inbox.take_losses() {
            for (peer, packets) in dropped {
                tracing::warn!(?peer, packets, "sends more than can be handled; dropped");
            }
            for command in commands.withdrawn {
                tracing::warn!(command, "not carried out: an Abort came after it");
            }
            for command in commands.merged {
                tracing::info!(command, "the Abort before it was still waiting: one is carried out for both");
            }
            if withdrawn > 0 {
                tracing::warn!(commands = withdrawn, "not carried out: an Abort came after them");
            }
        }
        if elapsed >= self.next_lost && self.tell_lost() {
            self.next_lost = elapsed + LOST_TOLD;
        }
    }

    /// Reports work that the disk could not take; returns whether there was any.
    fn tell_lost(&mut self) -> bool {
        let lost = self.disk.take_lost();
        if lost.is_none() {
            return false;
        }
        self.tell(Input::NotKept(format!("the disk is too slow: {lost}")));
        true
    }
}

/// Commands of the shore are queued like those of other peers; the shore is informed when there is no room.
fn start_uplink(
    settings: UplinkSettings,
    chart: ChartAboard,
    net: &Net,
    clock: Clock,
) -> anyhow::Result<Uplink> {
    let (inbox, its_clock) = (Arc::clone(&net.inbox), clock.clone());
    // The shore is informed at once of an order that the brain would refuse, so orders are decoded here too: the brain
    // checks again when the order's turn comes.
    let mut gate = LeaseGate::default();
    let deliver = move |what: FromShore<'_>| {
        let now = clock.now().mono;
        let taken = match what {
            FromShore::Lease(lease) => {
                gate.told(now, &lease);
                inbox.lease(SHORE, lease)
            }
            FromShore::Order { mandate, packet } => {
                let decoded = imc::Packet::decode(packet).map_err(|error| format!("no packet: {error}"))?;
                if let Some(message) = decoded.message() {
                    gate.admit(now, mandate.lease, message).map_err(|why| why.to_string())?;
                }
                inbox.order(SHORE, mandate, packet)
            }
            FromShore::Chart(chart) => {
                inbox.done(Done::Chart(chart));
                true
            }
            FromShore::NotSpooled(why) => {
                inbox.done(Done::NotKept(why));
                true
            }
        };
        taken.then_some(()).ok_or_else(|| "too many packets wait for the vessel".to_owned())
    };
    Uplink::start(settings, chart, its_clock, Box::new(deliver))
}

/// The chart in force, as reported to the shore.
fn chart_aboard(brain: &Brain, takes: bool) -> ChartAboard {
    let edition = match brain.chart() {
        Chart::Loaded(file) => file.edition(),
        Chart::Off | Chart::Unreadable { .. } => String::new(),
    };
    ChartAboard {
        held: brain.chart().digest().unwrap_or_default(),
        edition,
        takes,
        waits: brain.chart_waits().unwrap_or_default().to_owned(),
    }
}

/// The chart that the shore sent last, or that an operator copied there.
fn chart_of_shore(data: &Path, doubts: &mut Vec<String>) -> Option<ChartFile> {
    let loaded = ChartFolder::new(data).load();
    loaded.unwrap_or_else(|error| {
        doubts.push(format!("the shore's chart cannot be read and is fetched again: {error}"));
        None
    })
}

/// Writes a message of the brain into the program's log; returns the level's name.
fn print(level: Level, text: &str) -> &'static str {
    match level {
        Level::Debug => {
            tracing::debug!(target: "vessel", "{text}");
            "debug"
        }
        Level::Info => {
            tracing::info!(target: "vessel", "{text}");
            "info"
        }
        Level::Warning => {
            tracing::warn!(target: "vessel", "{text}");
            "warning"
        }
        Level::Error => {
            tracing::error!(target: "vessel", "{text}");
            "error"
        }
    }
}
