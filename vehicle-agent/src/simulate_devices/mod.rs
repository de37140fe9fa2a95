//! `lutra-agent simulate-devices`: a simulated Otter whose devices speak their real protocols on pseudo-terminals.
//!
//! To the agent that steers it by `run --profile Hardware` they are like real devices: the compass sends the configured
//! sentences at its line's speed, the motor card is behind a serial CAN adapter and obeys only MOTOR_SET, the hydrophone
//! answers the commands for its clock, whose instants are measured. Time is the computer's. Lines on standard input begin
//! and end faults of devices.

mod adapter;
mod fault;
mod instants;
mod nonsense;
mod plug;

use crate::ending::Ending;
use crate::say::{complain, say};
use crate::setup;
use adapter::Adapter;
use anyhow::Context as _;
use clap::Args;
use config::{Config, InMemory};
use devices::can::CanFrame;
use fault::{Fault, Kind, Order};
use instants::Instants;
use plug::Plug;
use rustix::event::{PollFd, Timespec, poll};
use sim::{AtFirst, GnssConfig, Output, OutputForm, Port, Vessel};
use std::fs::File;
use std::io::{BufRead as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use units::UtcTime;

/// Lines for the devices that may be queued.
const ORDERS_WAITING: usize = 64;
/// The longest wait: how often closed ports, signals and input lines are checked.
const LONGEST_WAIT: Duration = Duration::from_millis(20);
/// Longer steps are divided into pieces of this length.
const STEP: Duration = Duration::from_millis(40);
/// Epochs of the compass a second; each sentence is sent in a configured fraction of them.
const COMPASS_HZ: u32 = 10;
/// How often the true state is written.
const TRUTH_PERIOD: Duration = Duration::from_millis(200);

#[derive(Debug, Args)]
pub(crate) struct SimulateDevicesArguments {
    /// Main configuration file: where the vessel starts, its current and its fish, as in the profile Simulation; the
    /// built-in one of an Otter without.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Make links of stable names in this folder: gnss, motors and hydrophone.
    #[arg(long, value_name = "DIR")]
    links: Option<PathBuf>,
    /// Speed of the compass' line (bit/s): at any other it is noise.
    #[arg(long, default_value_t = 115_200)]
    gnss_baud: u32,
    /// Speed of the hydrophone's line (bit/s).
    #[arg(long, default_value_t = 115_200)]
    hydrophone_baud: u32,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A compass without errors.
    #[arg(long)]
    perfect: bool,
    /// A compass that was configured before, and saved its settings; without this it sends nothing until configured.
    #[arg(long)]
    set_up: bool,
    /// Write the true positions of the vessel and its fish to this file, five times a second: an object of JSON a line.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Write what the computer sends to the devices to this file: an object of JSON for each piece.
    #[arg(long, value_name = "FILE")]
    received: Option<PathBuf>,
}

/// The vessel, its devices and their lines.
struct Bench {
    vessel: Vessel,
    gnss: Plug,
    motors: Plug,
    hydrophone: Plug,
    adapter: Adapter,
    orders: Receiver<Order>,
    instants: Instants,
    received: Option<File>,
    truth: Option<File>,
    next_truth: Duration,
    begun: Instant,
}

pub(crate) fn simulate_devices(arguments: &SimulateDevicesArguments) -> anyhow::Result<()> {
    let ending = Ending::at_signals()?;
    let mut bench = Bench::new(arguments)?;
    say!("devices {} {} {}", bench.gnss.shown(), bench.motors.shown(), bench.hydrophone.shown());
    std::io::stdout().flush().ok();
    while !ending.is_near() {
        bench.turn()?;
    }
    say!("{}", bench.instants);
    say!("the devices are unplugged");
    Ok(())
}

impl Bench {
    fn new(arguments: &SimulateDevicesArguments) -> anyhow::Result<Self> {
        let links = arguments.links.as_deref();
        if let Some(folder) = links {
            std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
        }
        let create =
            |path: &PathBuf| File::create(path).with_context(|| format!("making {}", path.display()));
        Ok(Self {
            vessel: vessel(arguments)?,
            gnss: Plug::new(Kind::Gnss.name(), links, Some(arguments.gnss_baud))?,
            motors: Plug::new(Kind::Motors.name(), links, None)?,
            hydrophone: Plug::new(Kind::Hydrophone.name(), links, Some(arguments.hydrophone_baud))?,
            adapter: Adapter::default(),
            orders: orders()?,
            instants: Instants::default(),
            received: arguments.received.as_ref().map(create).transpose()?,
            truth: arguments.truth.as_ref().map(create).transpose()?,
            next_truth: Duration::ZERO,
            begun: Instant::now(),
        })
    }

    /// Waits for the computer or the next output, and advances everything to the present.
    fn turn(&mut self) -> anyhow::Result<()> {
        self.wait();
        while let Ok(order) = self.orders.try_recv() {
            self.obey(order)?;
        }
        self.receive()?;
        self.advance();
        self.send()?;
        let now = self.begun.elapsed();
        for kind in Kind::ALL {
            self.plug_of(kind).babble(now)?;
        }
        self.write_truth()
    }

    /// Advances the vessel to the present.
    fn advance(&mut self) {
        let mut left = self.begun.elapsed().saturating_sub(Duration::from_micros(self.vessel.now().micros()));
        while !left.is_zero() {
            let step = left.min(STEP);
            self.vessel.step(step);
            left -= step;
        }
    }

    fn wait(&self) {
        let due = Duration::from_micros(self.vessel.poll_timeout().micros());
        let wait = due.saturating_sub(self.begun.elapsed()).min(LONGEST_WAIT);
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(wait.subsec_nanos()) };
        let plugs = [&self.gnss, &self.motors, &self.hydrophone];
        let mut fds: Vec<PollFd<'_>> = plugs.into_iter().filter_map(Plug::waits_at).collect();
        // An interrupted wait is only shorter.
        poll(&mut fds, Some(&timeout)).ok();
    }

    fn plug_of(&mut self, kind: Kind) -> &mut Plug {
        match kind {
            Kind::Gnss => &mut self.gnss,
            Kind::Motors => &mut self.motors,
            Kind::Hydrophone => &mut self.hydrophone,
        }
    }

    fn obey(&mut self, order: Order) -> anyhow::Result<()> {
        let Order { fault, kind } = order;
        match fault {
            Fault::Unplug => self.plug_of(kind).unplug(),
            Fault::Plug => {
                // After a power loss an adapter is closed.
                if kind == Kind::Motors {
                    self.adapter = Adapter::default();
                }
                self.plug_of(kind).plug_in()?;
            }
            Fault::Silence => self.silence(kind, true),
            Fault::Babble => self.plug_of(kind).babbles = true,
            Fault::Nonsense => self.plug_of(kind).nonsense = true,
            Fault::Refuse => self.vessel.faults_mut().channels_refused = true,
            Fault::Restart if kind == Kind::Gnss => {
                self.vessel.restart_gnss();
                self.gnss.set_baud(self.vessel.gnss_baud());
            }
            Fault::Restart => self.adapter = Adapter::default(),
            Fault::Report => {}
            Fault::Mend => {
                self.silence(kind, false);
                self.vessel.faults_mut().channels_refused &= kind != Kind::Motors;
                let plug = self.plug_of(kind);
                (plug.babbles, plug.nonsense) = (false, false);
            }
        }
        match fault {
            Fault::Report => say!("{}", self.instants),
            _ => say!("{fault:?} {}", self.plug_of(kind).shown()),
        }
        std::io::stdout().flush().ok();
        Ok(())
    }

    fn silence(&mut self, kind: Kind, silent: bool) {
        let faults = self.vessel.faults_mut();
        match kind {
            Kind::Gnss => faults.gnss_silent = silent,
            Kind::Motors => faults.card_silent = silent,
            Kind::Hydrophone => faults.hydrophone_silent = silent,
        }
    }

    /// Receives the computer's bytes.
    fn receive(&mut self) -> anyhow::Result<()> {
        // The hydrophone first, whose time is measured: it is taken as soon as the bytes are there, and the vessel advances
        // to it before it gets them.
        let bytes = self.hydrophone.receive()?;
        self.instants.take(utc_now()?, &bytes);
        if !bytes.is_empty() {
            self.advance();
            self.vessel.receive_serial(Port::Hydrophone, &bytes);
        }
        self.write_received(Kind::Hydrophone, &bytes)?;
        let bytes = self.gnss.receive()?;
        self.write_received(Kind::Gnss, &bytes)?;
        if !bytes.is_empty() {
            self.vessel.receive_serial(Port::Gnss, &bytes);
            // Its answers are sent at the previous speed.
            self.send()?;
            self.gnss.set_baud(self.vessel.gnss_baud());
        }
        let bytes = self.motors.receive()?;
        self.write_received(Kind::Motors, &bytes)?;
        let vessel = &mut self.vessel;
        let answers = self.adapter.receive(&bytes, |frame| obey_frame(vessel, &frame));
        self.motors.send(&answers)
    }

    /// Sends the devices' output up to now.
    fn send(&mut self) -> anyhow::Result<()> {
        while let Some(timed) = self.vessel.poll_output() {
            match timed.output {
                Output::Serial(Port::Gnss, bytes) => self.gnss.send_text(&bytes)?,
                Output::Serial(Port::Hydrophone, bytes) => self.hydrophone.send_text(&bytes)?,
                Output::Can(frame) => {
                    let frame = if self.motors.nonsense { nonsense::frame(&frame) } else { frame };
                    self.motors.send(&self.adapter.send(&frame))?;
                }
                Output::Reading(_) => {}
            }
        }
        Ok(())
    }

    fn write_received(&mut self, kind: Kind, bytes: &[u8]) -> anyhow::Result<()> {
        let Some(file) = self.received.as_mut().filter(|_| !bytes.is_empty()) else { return Ok(()) };
        let text = String::from_utf8_lossy(bytes);
        let line = serde_json::json!({"device": kind.name(), "utc_s": utc_now()?.seconds(), "text": text});
        writeln!(file, "{line}").context("writing what was received")
    }

    fn write_truth(&mut self) -> anyhow::Result<()> {
        let Some(file) = &mut self.truth else { return Ok(()) };
        if self.begun.elapsed() < self.next_truth {
            return Ok(());
        }
        self.next_truth = self.begun.elapsed() + TRUTH_PERIOD;
        let truth = self.vessel.truth();
        let line = serde_json::json!({
            "utc_s": truth.utc.seconds(),
            "lat_deg": truth.place.lat_deg(),
            "lon_deg": truth.place.lon_deg(),
            "heading_rad": truth.heading_rad,
            "speed_mps": truth.speed_mps,
            "port_radps": truth.state.shaft_radps.port,
            "starboard_radps": truth.state.shaft_radps.starboard,
        });
        writeln!(file, "{line}").context("writing the truth")
    }
}

/// Passes a frame to the card, which ignores unknown ones.
fn obey_frame(vessel: &mut Vessel, frame: &CanFrame) {
    if let Err(error) = vessel.receive_can(frame) {
        complain!("{error}");
    }
}

/// Lines of standard input, read by a thread that ends with the program.
fn orders() -> anyhow::Result<Receiver<Order>> {
    let (sent, orders) = sync_channel(ORDERS_WAITING);
    let read = move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            match line.parse() {
                Ok(order) if sent.send(order).is_err() => return,
                Ok(_) => {}
                Err(error) => complain!("{error}"),
            }
        }
    };
    std::thread::Builder::new().name("input".to_owned()).spawn(read).context("a thread")?;
    Ok(orders)
}

/// The computer's time.
fn utc_now() -> anyhow::Result<UtcTime> {
    let since =
        SystemTime::now().duration_since(UNIX_EPOCH).context("the computer's clock is before 1970")?;
    // Until the year 294 000.
    Ok(UtcTime::from_micros(since.as_micros() as i64))
}

fn vessel(arguments: &SimulateDevicesArguments) -> anyhow::Result<Vessel> {
    let config = if let Some(path) = &arguments.config {
        setup::load(path, "Simulation")?
    } else {
        let files = InMemory::new().with("otter.ini", crate::OTTER_INI);
        Config::load(&files, Path::new("otter.ini"), &["Simulation"])
    };
    let mut vessel = setup::vessel(&config, utc_now()?, arguments.seed)?;
    vessel.form = OutputForm::Bytes;
    if arguments.perfect {
        vessel.gnss = GnssConfig::default().perfect();
    }
    // The time of reading a character says little about its arrival: the pace is measured but not checked.
    vessel.hydrophone.clock.least_pace_us = 0;
    // The computer configures what it sends, and how often.
    vessel.gnss.rate_hz = COMPASS_HZ;
    vessel.gnss.baud = arguments.gnss_baud;
    vessel.gnss.at_first = if arguments.set_up { AtFirst::Usual } else { AtFirst::Nothing };
    Ok(Vessel::new(&vessel)?)
}
