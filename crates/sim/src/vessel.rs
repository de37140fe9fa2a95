//! The whole vessel: hull, surroundings, motors, battery and sensors under one clock.
//!
//! Time moves in steps of 40 ms (25 Hz), within which the hull takes two steps of its own. Whatever spans the
//! caller steps by, the same whole steps are taken; what is left over waits. An [`Output`] carries the time
//! at which its last byte reaches the computer, which may lie up to one step before the call that makes it
//! available, and comes out in that order.
//!
//! Up to 100 000 outputs wait to be polled; beyond that the oldest is lost and counted.

use crate::battery::{BatteryBank, BatteryConfig};
use crate::card::{Card, CardConfig};
use crate::environment::{Environment, EnvironmentConfig};
use crate::faults::Faults;
use crate::fish::{Fish, FishConfig, Ping};
use crate::gnss::{Gnss, GnssConfig};
use crate::hydrophone::{Hydrophone, HydrophoneConfig};
use crate::motor::Drive;
use crate::otter::{Otter, OtterState, STEP_S};
use crate::range::{OutOfRange, within};
use devices::torqeedo::{CanFrame, CardCommand, CardError, CardReport};
use devices::{MotorReading, Pair, Reading, Side, TagReading, WaterReading};
use std::collections::BTreeMap;
use std::time::Duration;
use units::{LatLon, LocalFrame, MonoTime, UtcTime, wrap_pi, wrap_two_pi};

/// One step of the vessel (µs).
const STEP_US: u64 = 40_000;
const HULL_STEPS: u32 = 2;
/// Outputs kept for polling.
const OUTPUTS_KEPT: usize = 100_000;
/// The end of the year 9999 (s since 1970), the last that four digits hold.
const LAST_START_S: f64 = 253_402_300_799.0;
/// A fish may have swum so long before the start (s); every second of it is worked out.
const LONGEST_SWIM_S: f64 = 366.0 * 86_400.0;

/// The form of a vessel's output: bytes as from the devices, the values behind them, or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OutputForm {
    /// Bytes and CAN frames.
    #[default]
    Bytes,
    /// Values.
    Values,
    /// Both, the value after its bytes.
    Both,
}

impl OutputForm {
    const fn bytes(self) -> bool {
        matches!(self, Self::Bytes | Self::Both)
    }

    const fn values(self) -> bool {
        matches!(self, Self::Values | Self::Both)
    }
}

/// A serial line of the vessel's computer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Port {
    /// The GNSS compass.
    Gnss,
    /// The hydrophone.
    Hydrophone,
}

/// An output of a device.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// A sentence or line on a serial line.
    Serial(Port, Vec<u8>),
    /// A frame on the CAN bus.
    Can(CanFrame),
    /// The values of the bytes.
    Reading(Reading),
}

/// An output and when it is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// Since the start of the simulation.
    pub at: MonoTime,
    /// The same moment in UTC.
    pub utc: UtcTime,
    /// The output.
    pub output: Output,
}

/// A vessel and its surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselConfig {
    /// Seed of all chance but that of the fish.
    pub seed: u64,
    /// UTC at the start.
    pub start_utc: UtcTime,
    /// Place at the start; the origin of the local frame.
    pub start_place: LatLon,
    /// Heading at the start (rad).
    pub heading_rad: f64,
    /// Payload (kg), 0 to 45.
    pub payload_kg: f64,
    /// Temperature of the water (°C).
    pub water_c: f64,
    /// Current, wind and waves.
    pub environment: EnvironmentConfig,
    /// Motors and their card.
    pub card: CardConfig,
    /// Batteries and hotel load.
    pub battery: BatteryConfig,
    /// GNSS compass.
    pub gnss: GnssConfig,
    /// Hydrophone.
    pub hydrophone: HydrophoneConfig,
    /// The tagged fish around.
    pub fish: Vec<FishConfig>,
    /// The form of the output.
    pub form: OutputForm,
}

impl VesselConfig {
    /// An Otter with the demonstration load of 25 kg at a place and time, heading north in still water, no
    /// fish.
    pub fn at(start_place: LatLon, start_utc: UtcTime, seed: u64) -> Self {
        Self {
            seed,
            start_utc,
            start_place,
            heading_rad: 0.0,
            payload_kg: 25.0,
            water_c: 8.0,
            environment: EnvironmentConfig::default(),
            card: CardConfig::default(),
            battery: BatteryConfig::default(),
            gnss: GnssConfig::default(),
            hydrophone: HydrophoneConfig::default(),
            fish: Vec::new(),
            form: OutputForm::default(),
        }
    }
}

/// The true state; for tests and displays, never for the vessel's own computer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// UTC of this state: that of the last whole step.
    pub utc: UtcTime,
    /// Place of the point amidships.
    pub place: LatLon,
    /// Position in the local frame, velocities and shaft speeds.
    pub state: OtterState,
    /// Heading in (-π, π] (rad).
    pub heading_rad: f64,
    /// Course over ground in [0, 2π) (rad).
    pub course_rad: f64,
    /// Speed over ground (m/s).
    pub speed_mps: f64,
    /// Current to the north and to the east (m/s).
    pub current_mps: (f64, f64),
    /// Wind speed (m/s) and the direction it comes from (rad).
    pub wind: (f64, f64),
    /// Mean charge of the batteries (%).
    pub charge_percent: f64,
    /// Energy left (Wh).
    pub stored_wh: f64,
}

/// A simulated vessel.
#[derive(Debug, Clone)]
pub struct Vessel {
    form: OutputForm,
    start_utc: UtcTime,
    frame: LocalFrame,
    otter: Otter,
    state: OtterState,
    environment: Environment,
    card: Card,
    battery: BatteryBank,
    gnss: Gnss,
    hydrophone: Hydrophone,
    fish: Vec<Fish>,
    faults: Faults,
    /// Time of the state, in whole steps (µs).
    stepped_us: u64,
    /// Time the caller has asked for (µs).
    asked_us: u64,
    outputs: BTreeMap<(MonoTime, u64), Output>,
    made: u64,
    lost: u64,
    reports: Vec<(MonoTime, CardReport)>,
    heard: Vec<(UtcTime, Reading)>,
    /// Lines lost since the last that came as a value; unknown before the first.
    lines_lost: Option<u16>,
}

impl Vessel {
    /// A vessel at rest.
    ///
    /// # Errors
    /// When a setting is not a number or outside what the models hold for.
    pub fn new(config: &VesselConfig) -> Result<Self, OutOfRange> {
        let psi_rad = within("heading (rad)", config.heading_rad, -10.0, 10.0)?;
        let water_c = within("water temperature (°C)", config.water_c, -2.0, 40.0)?;
        let (seed, start_utc) = (config.seed, config.start_utc);
        within("start (s since 1970)", start_utc.seconds(), 0.0, LAST_START_S)?;
        Ok(Self {
            form: config.form,
            start_utc,
            frame: LocalFrame::new(config.start_place),
            otter: Otter::new(config.payload_kg)?,
            state: OtterState { psi_rad, ..OtterState::default() },
            environment: Environment::new(&config.environment, seed, STEP_US as f64 / 1e6)?,
            card: Card::new(&config.card, water_c),
            battery: BatteryBank::new(&config.battery, water_c, seed)?,
            gnss: Gnss::new(&config.gnss, seed, start_utc)?,
            hydrophone: Hydrophone::new(&config.hydrophone, water_c, seed, start_utc)?,
            fish: config.fish.iter().map(|fish| swimming(fish, start_utc)).collect::<Result<_, _>>()?,
            faults: Faults::default(),
            stepped_us: 0,
            asked_us: 0,
            outputs: BTreeMap::new(),
            made: 0,
            lost: 0,
            reports: Vec::new(),
            heard: Vec::new(),
            lines_lost: None,
        })
    }

    /// The time stepped to so far.
    pub fn now(&self) -> MonoTime {
        MonoTime::from_micros(self.asked_us)
    }

    /// The same time in UTC.
    pub fn utc(&self) -> UtcTime {
        self.utc_at(self.now())
    }

    /// The local frame; its origin is where the vessel started.
    pub fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// Asks the motors for a throttle each, -1 to 1, as a frame from the computer would: it lasts until the
    /// card's time-out.
    ///
    /// # Errors
    /// When a throttle is not a number within -1 to 1; the previous command stays in force.
    pub fn command(&mut self, port: f64, starboard: f64) -> Result<(), OutOfRange> {
        within("port throttle", port, -1.0, 1.0)?;
        within("starboard throttle", starboard, -1.0, 1.0)?;
        self.card.command(self.now(), Pair::new(Drive::Throttle(port), Drive::Throttle(starboard)));
        Ok(())
    }

    /// Asks the motors for a propeller speed each (rpm), which the motors' limits bound; it lasts until the
    /// card's time-out.
    ///
    /// # Errors
    /// When a speed is not a number within -3000 to 3000; the previous command stays in force.
    pub fn command_rpm(&mut self, port: f64, starboard: f64) -> Result<(), OutOfRange> {
        within("port speed (rpm)", port, -3000.0, 3000.0)?;
        within("starboard speed (rpm)", starboard, -3000.0, 3000.0)?;
        self.card.command(self.now(), Pair::new(Drive::Rpm(port), Drive::Rpm(starboard)));
        Ok(())
    }

    /// Takes a frame that the computer sends on the CAN bus.
    ///
    /// # Errors
    /// When the card makes nothing of it.
    pub fn receive_can(&mut self, frame: &CanFrame) -> Result<(), CardError> {
        let command = CardCommand::parse(frame)?;
        let refused = self.faults.channels_refused && matches!(command, CardCommand::OutputSet { .. });
        if !self.faults.card_deaf && !refused {
            self.card.obey(self.now(), command);
        }
        Ok(())
    }

    /// Takes bytes that the computer sends on a serial line. The hydrophone obeys and answers commands for
    /// its clock and settings, the compass those for what it sends.
    pub fn receive_serial(&mut self, port: Port, bytes: &[u8]) {
        match port {
            Port::Gnss => {
                let answers = self.gnss.settings_mut().receive(bytes);
                if self.form.bytes() && !answers.is_empty() && !self.faults.gnss_silent {
                    self.put(self.now(), Output::Serial(Port::Gnss, answers));
                }
            }
            Port::Hydrophone => {
                let now = self.utc();
                self.hydrophone.clock_mut().receive(now, bytes);
            }
        }
    }

    /// The speed of the compass' line (bit/s), which a command may change.
    pub fn gnss_baud(&self) -> u32 {
        self.gnss.settings().baud()
    }

    /// The compass loses its power for a moment: it is as it was saved.
    pub fn restart_gnss(&mut self) {
        self.gnss.settings_mut().restart();
    }

    /// Takes a transmission of a tag that is not among the vessel's own fish.
    pub fn hear(&mut self, ping: Ping) {
        self.hydrophone.hear(ping);
    }

    /// The faults.
    pub fn faults(&self) -> &Faults {
        &self.faults
    }

    /// The faults, to change.
    pub fn faults_mut(&mut self) -> &mut Faults {
        &mut self.faults
    }

    /// Takes charge out of the batteries until their mean is `percent`; never puts any in.
    pub fn drain_to(&mut self, percent: f64) {
        self.battery.drain_to(percent);
    }

    /// A motor's report at this moment, also where its feedback is broken.
    pub fn motor(&self, side: Side) -> MotorReading {
        self.card.motor(side)
    }

    /// The batteries.
    pub fn battery(&self) -> &BatteryBank {
        &self.battery
    }

    /// Outputs lost because they were not polled.
    pub fn outputs_lost(&self) -> u64 {
        self.lost
    }

    /// The true state.
    pub fn truth(&self) -> Truth {
        let (north_mps, east_mps) = self.state.ground_velocity_mps();
        Truth {
            utc: self.utc_at(MonoTime::from_micros(self.stepped_us)),
            place: self.frame.to_place(self.state.position),
            state: self.state,
            heading_rad: wrap_pi(self.state.psi_rad),
            course_rad: wrap_two_pi(east_mps.atan2(north_mps)),
            speed_mps: north_mps.hypot(east_mps),
            current_mps: self.environment.current_mps(),
            wind: self.environment.wind(),
            charge_percent: self.battery.charge_percent(),
            stored_wh: self.battery.stored_wh(),
        }
    }

    /// Where the vessel's own fish are: place and depth (m) of each, in the order of the configuration.
    pub fn fish_truth(&self) -> Vec<(LatLon, f64)> {
        let utc = self.utc_at(MonoTime::from_micros(self.stepped_us));
        self.fish.iter().map(|fish| fish.truth(utc)).collect()
    }

    /// Moves everything on by `dt`.
    pub fn step(&mut self, dt: Duration) {
        self.asked_us = (self.now() + dt).micros();
        while self.stepped_us + STEP_US <= self.asked_us {
            self.step_once();
        }
    }

    /// The next output that is there by now; call until `None`.
    pub fn poll_output(&mut self) -> Option<Timed> {
        let now = self.now();
        let entry = self.outputs.first_entry()?;
        let at = entry.key().0;
        if at > now {
            return None;
        }
        let output = entry.remove();
        Some(Timed { at, utc: self.utc_at(at), output })
    }

    /// When there is something to poll or to step for: the next output known or the next whole step.
    pub fn poll_timeout(&self) -> MonoTime {
        let step = MonoTime::from_micros(self.stepped_us + STEP_US);
        self.outputs.first_key_value().map_or(step, |(&(at, _), _)| at.min(step))
    }

    fn step_once(&mut self) {
        let dt_s = STEP_US as f64 / 1e6;
        let begin = MonoTime::from_micros(self.stepped_us);
        let energy_left = !self.battery.is_empty();
        let goal = self.card.goal_radps(begin, energy_left);
        self.environment.step();
        let middle_s = self.stepped_us as f64 / 1e6 + 0.5 * dt_s;
        let load = self.environment.load(middle_s, &self.otter, &self.state);
        for _ in 0..HULL_STEPS {
            self.state = self.otter.step(&self.state, goal, &load, STEP_S);
        }
        let motors_w = self.card.step(self.state.shaft_radps, energy_left, dt_s);
        self.battery.drain(motors_w, dt_s);
        self.stepped_us += STEP_US;
        self.sense_position();
        self.sense_sound();
        self.report();
    }

    fn sense_position(&mut self) {
        let now_utc = self.utc_at(MonoTime::from_micros(self.stepped_us));
        while self.gnss.next_epoch() <= now_utc {
            let back_s = (now_utc - self.gnss.next_epoch()) as f64 / 1e6;
            let state = self.state.moved(-back_s);
            let epoch = self.gnss.epoch(&state, &self.frame, &self.faults, self.form.bytes());
            let Some(epoch) = epoch else { continue };
            for (utc, bytes) in epoch.sentences {
                self.put(self.mono_at(utc), Output::Serial(Port::Gnss, bytes));
            }
            if self.form.values() {
                self.put(self.mono_at(epoch.complete_utc), Output::Reading(Reading::Gnss(epoch.reading)));
            }
        }
    }

    fn sense_sound(&mut self) {
        let now = MonoTime::from_micros(self.stepped_us);
        let now_utc = self.utc_at(now);
        for fish in &mut self.fish {
            while let Some(ping) = fish.advance(now_utc) {
                self.hydrophone.hear(ping);
            }
        }
        let mut heard = std::mem::take(&mut self.heard);
        self.hydrophone.step(now_utc, &self.state, &self.frame, &mut heard);
        let answer = self.hydrophone.clock_mut().answer(now_utc);
        if self.faults.hydrophone_silent {
            // Fewer lines than 16 bits count in a step.
            let lost = heard.drain(..).count() as u16;
            self.lines_lost = self.lines_lost.map(|before| before.saturating_add(lost));
        } else if let Some(answer) = answer.filter(|_| self.form.bytes()) {
            self.put(now, Output::Serial(Port::Hydrophone, answer));
        }
        for (utc, mut reading) in heard.drain(..) {
            let at = self.mono_at(utc);
            if self.form.bytes() {
                let bytes = match &reading {
                    Reading::Tag(tag) => tag.encode(),
                    Reading::Water(water) => water.encode(),
                    Reading::Gnss(_)
                    | Reading::Motor(..)
                    | Reading::Battery(_)
                    | Reading::Rail(_)
                    | Reading::PowerChannel(_)
                    | Reading::Pulse(_)
                    | Reading::Trouble(_)
                    | Reading::Receiver(_) => continue,
                };
                self.put(at, Output::Serial(Port::Hydrophone, bytes));
            }
            if self.form.values() {
                if let Reading::Tag(TagReading { lines_lost, .. })
                | Reading::Water(WaterReading { lines_lost, .. }) = &mut reading
                {
                    *lines_lost = self.lines_lost.replace(0);
                }
                self.put(at, Output::Reading(reading));
            }
        }
        self.heard = heard;
    }

    fn report(&mut self) {
        let mut reports = std::mem::take(&mut self.reports);
        self.card.reports(MonoTime::from_micros(self.stepped_us), &self.battery, &mut reports);
        for (at, report) in reports.drain(..) {
            let lost = match report {
                CardReport::Motor(side, _) => *self.faults.motor_feedback_lost.of(side),
                CardReport::Battery(_) | CardReport::Rail(_) | CardReport::Outputs { .. } => false,
            };
            if lost || self.faults.card_silent {
                continue;
            }
            if self.form.bytes() {
                self.put(at, Output::Can(report.frame()));
            }
            if let Some(reading) = report.reading().filter(|_| self.form.values()) {
                self.put(at, Output::Reading(reading));
            }
        }
        self.reports = reports;
    }

    fn put(&mut self, at: MonoTime, output: Output) {
        if self.outputs.len() >= OUTPUTS_KEPT {
            self.outputs.pop_first();
            self.lost += 1;
        }
        self.outputs.insert((at, self.made), output);
        self.made += 1;
    }

    fn utc_at(&self, at: MonoTime) -> UtcTime {
        // A simulation stays within the 292 000 years that 64 bits of microseconds hold.
        UtcTime::from_micros(self.start_utc.micros() + at.micros() as i64)
    }

    fn mono_at(&self, utc: UtcTime) -> MonoTime {
        MonoTime::from_micros(u64::try_from(utc - self.start_utc).unwrap_or(0))
    }
}

/// A fish that has swum until `start`; earlier transmissions of its tag were not heard.
fn swimming(config: &FishConfig, start: UtcTime) -> Result<Fish, OutOfRange> {
    within("beginning of the fish (s since 1970)", config.since.seconds(), 0.0, LAST_START_S)?;
    let swum_s = start.seconds() - config.since.seconds();
    within("age of the fish at the start (s)", swum_s, -LAST_START_S, LONGEST_SWIM_S)?;
    let mut fish = Fish::new(config)?;
    while fish.advance(start).is_some() {}
    Ok(fish)
}
