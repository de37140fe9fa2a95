//! The vessel with a virtual clock.

use crate::disk::Journal;
use crate::disk::recording::{Beginning, Recorder};
use crate::due::{Due, noting};
use crate::hull::Simulated;
use crate::plan;
use crate::say::{complain, say};
use crate::setup;
use crate::track::{self, Track};
use crate::trial;
use crate::vehicle::Vehicle;
use anyhow::{Context as _, bail};
use clap::Args;
use config::{Config, InMemory};
use control::MotorActivity;
use imc::messages::{
    PathControlState, PlanControl, PlanControlOp, PlanControlState, PlanControlStateLastOutcome,
    PlanControlStateState, PlanControlType, PlanSpecification, VehicleState, VehicleStateOpMode,
};
use imc::{Address, Header, Packet, PacketView};
use onboard::{Brain, Entity, Input, Level, Output, Peer};
use sim::{GnssConfig, Vessel, WindConfig};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use units::{MonoTime, Now, UtcTime};

/// The console that starts the plan.
const CONSOLE: Address = Address(0x4001);
/// A plan that takes longer is given up (s).
const LONGEST_S: f64 = 7.0 * 86_400.0;
/// How long readiness is awaited (s).
const READY_S: f64 = 60.0;

/// The strongest current and wind that are simulated (m/s): a direction in the place of the speed is refused by them.
const STRONGEST_CURRENT_MPS: f64 = 10.0;
const STRONGEST_WIND_MPS: f64 = 60.0;

#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct SimulateArguments {
    /// The main configuration file; the built-in one of an Otter without.
    #[arg(long)]
    config: Option<PathBuf>,
    /// A plan to sail: PlanSpecification as IMC JSON.
    #[arg(long)]
    plan: Option<PathBuf>,
    /// When to end: DONE (the plan is over) or a number of seconds.
    #[arg(long, default_value = "DONE")]
    until: String,
    /// Start time, ISO 8601 UTC; the same at every run unless given, so that runs can be compared.
    #[arg(long, value_name = "TIME", default_value = "2026-09-21T14:13:20Z")]
    start: UtcTime,
    /// Simulated seconds per second: `max`, or a number.
    #[arg(long, default_value = "max")]
    speed: String,
    /// Wind: speed (m/s) and the direction it comes from (degrees), like 5@303; gusts of 15 % come with it.
    #[arg(long, value_name = "MPS@FROM_DEG", value_parser = wind)]
    wind: Option<(f64, f64)>,
    /// Current: speed (m/s) and the direction it flows to (degrees), like 0.3@90.
    #[arg(long, value_name = "MPS@TO_DEG", value_parser = current)]
    pub(crate) current: Option<(f64, f64)>,
    /// Write logs below this folder.
    #[arg(long)]
    log: Option<PathBuf>,
    /// Record all inputs and outputs of the brain, for `replay`.
    #[arg(long)]
    record: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A compass without errors.
    #[arg(long)]
    perfect: bool,
    /// Errors of the compass' positions on each axis (m, standard deviations): noise of each epoch, and the
    /// slow drift of 300 s that a receiver has.
    #[arg(long, value_name = "NOISE,DRIFT", default_value = "0.2,0.67", conflicts_with = "perfect")]
    gnss_error: String,
    /// Draw the true track, cross-track error, speed and motor commands while the plan ran as SVG.
    ///
    /// Legs between waypoints (Goto) and stations (StationKeeping) are measured; other maneuvers only have
    /// their track drawn.
    #[arg(long, value_name = "FILE", conflicts_with = "open_loop")]
    svg: Option<PathBuf>,
    /// Seconds between printed lines; 0 prints only the summary.
    #[arg(long, default_value_t = 5.0)]
    every: f64,
    /// Bare hull: constant propeller speeds (rad/s), port and starboard, from rest.
    #[arg(long, value_name = "N_PORT,N_STBD", allow_hyphen_values = true)]
    pub(crate) open_loop: Option<String>,
    /// Heading at the start (degrees).
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) heading: f64,
    /// Payload (kg).
    #[arg(long)]
    pub(crate) payload: Option<f64>,
    /// Where --open-loop writes its table; `-` prints it.
    #[arg(long, default_value = "-")]
    pub(crate) csv: PathBuf,
}

/// State known from the packets.
#[derive(Default)]
struct Watch {
    plan: PlanControlState,
    ready: bool,
    cross_m: Option<f64>,
    worst_m: f64,
    squares: (f64, u64),
    /// Motor activity while the plan ran.
    activity: MotorActivity,
    packets: u64,
    bytes: u64,
}

/// A simulated run.
struct Run {
    vehicle: Vehicle<Simulated>,
    own: Address,
    recorder: Option<Recorder>,
    journal: Option<Journal>,
    watch: Watch,
    track: Option<Track>,
    due: Vec<Due>,
}

impl SimulateArguments {
    /// How long it is to last (s), or `None` until the plan is done.
    pub(crate) fn until_s(&self) -> anyhow::Result<Option<f64>> {
        let text = self.until.as_str();
        if text.eq_ignore_ascii_case("done") {
            return Ok(None);
        }
        let seconds: f64 = text.trim_end_matches('s').parse().with_context(|| format!("--until {text}"))?;
        if !(0.0..=LONGEST_S).contains(&seconds) {
            bail!("--until {text} is not within 0 to {LONGEST_S} s");
        }
        Ok(Some(seconds))
    }
}

pub(crate) fn simulate(arguments: &SimulateArguments) -> anyhow::Result<()> {
    let limit_s = arguments.until_s()?;
    let factor = match arguments.speed.as_str() {
        "max" => None,
        text => Some(text.parse::<f64>().ok().filter(|factor| *factor > 0.0).context("--speed")?),
    };
    let config = configuration(arguments)?;
    let utc = arguments.start;
    let mut run = Run::begin(arguments, &config, utc)?;
    let plan = match &arguments.plan {
        Some(path) => plan::read(path)?,
        None => plan::demonstration(run.vehicle.hull.vessel.frame().origin()),
    };
    if arguments.svg.is_some() {
        run.track = Some(Track::new(&plan, run.vehicle.hull.vessel.frame()));
    }
    let begun = Instant::now();
    run.tell(Input::Connected(Peer::Tcp(1)))?;
    run.sail(&plan, limit_s.unwrap_or(LONGEST_S), limit_s.is_none(), arguments.every, factor)?;
    run.tell(Input::Shutdown)?;
    if let Some(journal) = &mut run.journal {
        journal.close(run.vehicle.now.utc).context("closing the log")?;
    }
    if let Some(recorder) = &mut run.recorder {
        recorder.flush()?;
    }
    if let (Some(track), Some(path)) = (&run.track, &arguments.svg) {
        let conditions = conditions(&vessel(arguments, &config, utc)?);
        let plot = track.plot(&conditions, run.watch.activity.per_s());
        plot.notes.iter().for_each(|note| say!("{note}"));
        std::fs::write(path, plot.to_svg()).with_context(|| format!("writing {}", path.display()))?;
    }
    run.summary(begun.elapsed())
}

impl Run {
    fn begin(arguments: &SimulateArguments, config: &Config, utc: UtcTime) -> anyhow::Result<Self> {
        let (settings, mut doubts) = setup::settings(config, arguments.seed)?;
        doubts.extend(trial::doubts(config, &settings));
        for doubt in doubts {
            complain!("warning: {doubt}");
        }
        let vessel = Vessel::new(&vessel(arguments, config, utc)?)?;
        let now = Now { mono: vessel.now(), utc };
        let text = config.ini().to_text().map_err(|error| anyhow::anyhow!("{error}"))?;
        let recorder = match &arguments.record {
            Some(path) => {
                let (profile, uid) = ("Simulation".to_owned(), arguments.seed);
                let beginning =
                    Beginning { config: text.clone(), profile, uid, now, kept: mission::Kept::default() };
                Some(Recorder::create(path, &beginning)?)
            }
            None => None,
        };
        let journal = arguments
            .log
            .as_ref()
            .map(|base| Journal::new(base, settings.address, Entity::Logger.number(), text));
        let own = settings.address;
        let brain = Brain::new(settings, now, mission::Kept::default())?;
        let vehicle = Vehicle::new(Simulated::new(vessel), brain, now);
        Ok(Self { vehicle, own, recorder, journal, watch: Watch::default(), track: None, due: Vec::new() })
    }

    /// Uploads and starts the plan when the vessel is ready, and continues to the end.
    fn sail(
        &mut self,
        plan: &PlanSpecification,
        limit_s: f64,
        until_done: bool,
        every_s: f64,
        factor: Option<f64>,
    ) -> anyhow::Result<()> {
        let begun = Instant::now();
        let (mut started, mut next_line, mut next_beat) = (false, 0.0, 0.0);
        if every_s > 0.0 {
            say!("    time    north     east  speed  heading  course  cross-track  plan");
        }
        loop {
            let now_s = self.vehicle.now.mono.micros() as f64 / 1e6;
            if now_s >= limit_s || (until_done && started && self.is_over()) {
                return Ok(());
            }
            if now_s >= next_beat {
                next_beat = now_s + 1.0;
                self.send(imc::messages::Heartbeat)?;
            }
            if !started && self.watch.ready {
                started = true;
                self.send(start(plan))?;
            } else if !started && until_done && now_s > READY_S {
                bail!("the vessel is not ready after {READY_S} s");
            }
            if every_s > 0.0 && now_s >= next_line {
                next_line = now_s + every_s;
                self.line(now_s);
            }
            if let Some(track) = &mut self.track {
                let running = self.watch.plan.state == PlanControlStateState::Executing;
                let maneuver = self.watch.plan.man_id.to_str_lossy();
                let truth = self.vehicle.hull.vessel.truth();
                track.see(now_s, running.then_some(&*maneuver), truth.state.position, truth.speed_mps);
            }
            if let Some(factor) = factor {
                let ahead_s = now_s / factor - begun.elapsed().as_secs_f64();
                std::thread::sleep(Duration::from_secs_f64(ahead_s.clamp(0.0, 1.0)));
            }
            let until = MonoTime::default() + Duration::from_secs_f64(next_beat.min(limit_s));
            let (due, records) = (&mut self.due, self.recorder.is_some());
            self.vehicle.advance(until, &mut noting(due, records));
            self.take()?;
        }
    }

    fn is_over(&self) -> bool {
        let state = &self.watch.plan;
        state.state == PlanControlStateState::Ready && state.last_outcome != PlanControlStateLastOutcome::None
    }

    fn tell(&mut self, input: Input) -> anyhow::Result<()> {
        let (due, records) = (&mut self.due, self.recorder.is_some());
        self.vehicle.tell(input, &mut noting(due, records));
        self.take()
    }

    fn send(&mut self, message: impl Into<imc::Message>) -> anyhow::Result<()> {
        let timestamp = self.vehicle.now.utc.seconds();
        let header = Header { timestamp, src: CONSOLE, dst: self.own, ..Header::default() };
        self.tell(Input::Packet(Peer::Tcp(1), Packet::new(header, message).encode()?))
    }

    /// Records and logs what happened, and updates the state.
    fn take(&mut self) -> anyhow::Result<()> {
        while !self.due.is_empty() {
            for due in std::mem::take(&mut self.due) {
                match (due, &mut self.recorder) {
                    (Due::Record(kind, bytes), Some(recorder)) => recorder.put(kind, &bytes)?,
                    (Due::Record(..), None) => {}
                    (Due::Output(now, output), _) => self.take_one(now, &output)?,
                }
            }
        }
        Ok(())
    }

    fn take_one(&mut self, now: Now, output: &Output) -> anyhow::Result<()> {
        if let (Some(track), Output::Motors(motors)) = (&mut self.track, output) {
            track.command(*motors);
        }
        self.watch.see(now, self.own, output)?;
        let Some(journal) = &mut self.journal else { return Ok(()) };
        match output {
            Output::OpenLog { label, utc } => {
                let opened = Input::LogOpened(Ok(journal.open(now.mono, *utc, label)?));
                let (due, records) = (&mut self.due, self.recorder.is_some());
                self.vehicle.tell(opened, &mut noting(due, records));
            }
            Output::Packet { bytes, .. } => {
                journal.write(now.mono, bytes)?;
            }
            Output::Console(_, text) => {
                journal.line(now.mono, &format!("[{}] - {text}", now.utc))?;
            }
            _ => {}
        }
        Ok(())
    }

    fn line(&self, now_s: f64) {
        let truth = self.vehicle.hull.vessel.truth();
        let cross = self.watch.cross_m.map_or_else(|| "-".to_owned(), |cross_m| format!("{cross_m:+.2} m"));
        say!(
            "{now_s:7.0} s {:7.1} m {:7.1} m {:5.2}  {:6.0}°  {:5.0}°  {cross:>11}  {} {}",
            truth.state.position.north_m,
            truth.state.position.east_m,
            truth.speed_mps,
            truth.heading_rad.to_degrees().rem_euclid(360.0),
            truth.course_rad.to_degrees(),
            self.watch.plan.plan_id,
            self.watch.plan.man_id,
        );
    }

    fn summary(&self, took: Duration) -> anyhow::Result<()> {
        let simulated_s = self.vehicle.now.mono.micros() as f64 / 1e6;
        let (sum, count) = self.watch.squares;
        say!(
            "{simulated_s:.0} s simulated in {:.2} s ({:.0} times real time), {} packets, {} bytes",
            took.as_secs_f64(),
            simulated_s / took.as_secs_f64().max(1e-6),
            self.watch.packets,
            self.watch.bytes,
        );
        if count > 0 {
            let rms_m = (sum / count as f64).sqrt();
            say!(
                "cross-track error as the vessel sees it: RMS {rms_m:.2} m, largest {:.2} m",
                self.watch.worst_m
            );
        }
        if let Some(per_s) = self.watch.activity.per_s() {
            say!("{}", track::activity(per_s));
        }
        match self.watch.plan.last_outcome {
            PlanControlStateLastOutcome::Success => say!("plan '{}' completed", self.watch.plan.plan_id),
            PlanControlStateLastOutcome::Failure => bail!("plan '{}' failed", self.watch.plan.plan_id),
            _ => say!("no plan ended"),
        }
        Ok(())
    }
}

impl Watch {
    fn see(&mut self, now: Now, own: Address, output: &Output) -> anyhow::Result<()> {
        match output {
            Output::Motors(motors) if self.plan.state == PlanControlStateState::Executing => {
                self.activity.see(now.mono, *motors);
            }
            Output::Motors(_) => self.activity.pause(),
            Output::Console(level, text) if *level >= Level::Warning => say!("{text}"),
            Output::Packet { bytes, .. } => {
                self.packets += 1;
                self.bytes += bytes.len() as u64;
                let view = PacketView::new(bytes)?;
                if view.src() != own {
                    return Ok(());
                }
                if let Some(state) = imc::decode::<PlanControlState>(&view)? {
                    self.plan = state;
                } else if let Some(state) = imc::decode::<VehicleState>(&view)? {
                    self.ready = state.op_mode == VehicleStateOpMode::Service;
                } else if let Some(state) = imc::decode::<PathControlState>(&view)? {
                    let cross_m = f64::from(state.y);
                    self.cross_m = Some(cross_m);
                    self.worst_m = self.worst_m.max(cross_m.abs());
                    self.squares = (self.squares.0 + cross_m * cross_m, self.squares.1 + 1);
                }
            }
            _ => {}
        }
        Ok(())
    }
}

fn start(plan: &PlanSpecification) -> PlanControl {
    PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        request_id: 1,
        plan_id: plan.plan_id.clone(),
        arg: plan.clone().into(),
        ..PlanControl::default()
    }
}

fn configuration(arguments: &SimulateArguments) -> anyhow::Result<Config> {
    if let Some(path) = &arguments.config {
        return setup::load(path, "Simulation");
    }
    let files = InMemory::new().with("otter.ini", crate::OTTER_INI);
    Ok(Config::load(&files, "otter.ini".as_ref(), &["Simulation"]))
}

fn vessel(arguments: &SimulateArguments, config: &Config, utc: UtcTime) -> anyhow::Result<sim::VesselConfig> {
    let mut vessel = setup::vessel(config, utc, arguments.seed)?;
    vessel.heading_rad = units::wrap_pi(arguments.heading.to_radians());
    if let Some(payload_kg) = arguments.payload {
        vessel.payload_kg = payload_kg;
    }
    if arguments.perfect {
        let GnssConfig { rate_hz, baud, .. } = vessel.gnss;
        vessel.gnss = GnssConfig { rate_hz, baud, ..GnssConfig::default() }.perfect();
    }
    if !arguments.perfect {
        (vessel.gnss.position_white_m, vessel.gnss.position_slow_m) =
            pair(&arguments.gnss_error).context("--gnss-error")?;
    }
    if let Some((speed_mps, to_deg)) = arguments.current {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) =
            (speed_mps, to_deg.to_radians());
    }
    if let Some((speed_mps, from_deg)) = arguments.wind {
        let from_rad = from_deg.to_radians();
        vessel.environment.wind = WindConfig { speed_mps, from_rad, ..vessel.environment.wind };
    }
    Ok(vessel)
}

/// The disturbances of a run in a line.
fn conditions(vessel: &sim::VesselConfig) -> String {
    let (current, wind, gnss) = (&vessel.environment.current, &vessel.environment.wind, &vessel.gnss);
    let degrees = |angle_rad: f64| angle_rad.to_degrees().rem_euclid(360.0);
    let water = match current.speed_mps {
        0.0 => "no current".to_owned(),
        speed_mps => format!("current {speed_mps} m/s to {:.0}°", degrees(current.to_rad)),
    };
    let air = match wind.speed_mps {
        0.0 => "no wind".to_owned(),
        speed_mps => {
            let (from_deg, share) = (degrees(wind.from_rad), wind.gust_share * 100.0);
            format!("wind {speed_mps} m/s from {from_deg:.0}° with gusts of {share:.0} %")
        }
    };
    let (noise_m, drift_m) = (gnss.position_white_m, gnss.position_slow_m);
    format!("{water}; {air}; positions: noise {noise_m} m, slow drift {drift_m} m; seed {}", vessel.seed)
}

fn current(text: &str) -> Result<(f64, f64), String> {
    flow(text, STRONGEST_CURRENT_MPS).ok_or_else(|| {
        format!(
            "give how fast it flows, 0 to {STRONGEST_CURRENT_MPS} m/s, and where to in degrees, like 0.3@90"
        )
    })
}

fn wind(text: &str) -> Result<(f64, f64), String> {
    flow(text, STRONGEST_WIND_MPS).ok_or_else(|| {
        format!(
            "give its speed, 0 to {STRONGEST_WIND_MPS} m/s, and where it comes from in degrees, like 5@303"
        )
    })
}

/// A speed (m/s), at most `most_mps`, and a direction (degrees), with an @ between; a comma is taken too.
fn flow(text: &str, most_mps: f64) -> Option<(f64, f64)> {
    let (speed, direction) = text.split_once('@').or_else(|| text.split_once(','))?;
    let (speed_mps, direction_deg) = (speed.trim().parse().ok()?, direction.trim().parse().ok()?);
    let possible = (0.0..=most_mps).contains(&speed_mps) && (-360.0..=360.0).contains(&direction_deg);
    possible.then_some((speed_mps, direction_deg))
}

/// Two numbers with a comma between.
pub(crate) fn pair(text: &str) -> anyhow::Result<(f64, f64)> {
    let (first, second) = text.split_once(',').with_context(|| format!("`{text}` is not two numbers"))?;
    Ok((first.trim().parse()?, second.trim().parse()?))
}

#[cfg(test)]
mod tests;
