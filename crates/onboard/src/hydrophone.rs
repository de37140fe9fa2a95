//! What the hydrophone reads: detections of tagged fish, and the water.
//!
//! A detection gets the hydrophone's position when the transmission began: at the receiver's stamp less the length of a
//! tag's transmission, or at the arrival of its line less the same where the receiver's clock was never set or is lost.
//! Such detections have no time of day. Each detection is sent as an Event with all its values, and as the TBRFishTag
//! that every console knows, unless that would be false ([`Detection::fish_tag`]). How the receiver listens is reported
//! also while it hears nothing ([`Listening`]).

use crate::bus::Bus;
use crate::entity::Entity;
use crate::input::DeviceState;
use crate::navigation::Estimate;
use crate::output::Level;
use crate::poses::{LeverArm, Poses};
use crate::settings::HydrophoneSettings;
use crate::states::{Condition, States};
use control::MotorPair;
use detections::{ClockState, Detection, Effort, Listening, Noise, Origin, Pose, Protocol, ReceiverClock};
use devices::{Pair, ReceiverReading, Side, TagReading, WaterReading};
use imc::messages::{DevDataText, TBRSensor, Temperature};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// A motor that reported longer ago than this is not known to turn as it did then.
const MOTOR_LIFE: Duration = Duration::from_secs(2);
/// Longest name of a coding that is repeated (characters).
const LONGEST_NAME: usize = 24;
/// Longest line of a receiver that is repeated (characters).
const LONGEST_LINE: usize = 200;
/// How the receiver listens is reported again after this, for consoles that connected meanwhile.
const TOLD_AGAIN: Duration = Duration::from_secs(30);
/// Thrust that differs by this from the last report is reported again.
const OTHER_THRUST: f64 = 0.15;

/// The state of the receiver and of how it can listen.
#[derive(Debug, Clone)]
pub(crate) struct Hydrophone {
    settings: HydrophoneSettings,
    poses: Poses,
    lost_lines: u64,
    heard: u64,
    /// Those of them without a time of day.
    undated: u64,
    /// The receiver's clock is not set.
    unset: bool,
    /// How its driver finds it; a simulated receiver has none.
    device: Option<DeviceState>,
    /// How it listens and its clock is kept, as its driver knows it.
    receiver: Option<ReceiverReading>,
    serial: Option<u32>,
    frequency_khz: Option<u8>,
    /// The last report of how it listens, and when.
    told: Option<(MonoTime, Listening)>,
    /// Mean and peak noise as they were reported last, and when.
    noise: Option<(MonoTime, u8, u8)>,
    /// Propeller speeds (rpm, without direction), and when they were measured.
    propellers: Pair<Option<(MonoTime, f64)>>,
}

impl Hydrophone {
    pub(crate) fn new(settings: &HydrophoneSettings) -> Self {
        Self {
            settings: *settings,
            poses: Poses::default(),
            lost_lines: 0,
            heard: 0,
            undated: 0,
            unset: false,
            device: None,
            receiver: None,
            serial: None,
            frequency_khz: None,
            told: None,
            noise: None,
            propellers: Pair::default(),
        }
    }

    /// Where the vessel is.
    pub(crate) fn at(&mut self, now: MonoTime, estimate: &Estimate) {
        self.poses.at(now, estimate);
    }

    /// How fast a propeller turns (rpm).
    pub(crate) fn propeller(&mut self, now: MonoTime, side: Side, rpm: f64) {
        *self.propellers.of_mut(side) = rpm.is_finite().then_some((now, rpm.abs()));
    }

    /// How the receiver is, as its driver knows it.
    pub(crate) fn device(&mut self, bus: &mut Bus, states: &mut States, state: DeviceState) {
        self.device = Some(state);
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// How the receiver listens and its clock is kept.
    pub(crate) fn receiver(&mut self, bus: &mut Bus, states: &mut States, reading: &ReceiverReading) {
        let before = self.receiver.replace(reading.clone());
        let was_lost = before.is_some_and(|before| before.clock == devices::ClockState::Lost);
        let is_lost = self.lost_clock().is_some();
        if is_lost && !was_lost {
            bus.entry(Entity::Hydrophone, Level::Warning, reading.clock_fault.clone());
        } else if was_lost && !is_lost {
            bus.entry(Entity::Hydrophone, Level::Info, "the receiver's clock is good again");
        }
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// A tag was heard; its line came at `at`.
    pub(crate) fn tag(&mut self, bus: &mut Bus, states: &mut States, at: MonoTime, tag: TagReading) {
        self.line(bus, tag.serial, tag.frequency_khz, tag.lines_lost);
        let clock = self.clock_of(tag.clock_s, tag.millis);
        self.told_set(bus, clock);
        let name: String = tag.protocol.chars().take(LONGEST_NAME).collect();
        let detection = Detection {
            origin: Origin {
                system: bus.address(),
                entity: Entity::Hydrophone.number(),
                reported: bus.utc(),
                received: None,
            },
            receiver: tag.serial,
            maker: None,
            clock,
            protocol: Protocol::named(&name),
            tag_id: tag.tag_id,
            data: tag.data,
            // A VR2C may not say it.
            snr_db: Some(tag.snr_db).filter(|snr_db| *snr_db != 0),
            frequency_khz: Some(tag.frequency_khz).filter(|khz| *khz != 0),
            line: tag.counter,
            pose: self.pose(bus, at, clock.utc()),
            effort: self.effort(bus.mono(), tag.lines_lost),
            // No receiver writes longer lines: what is longer is not repeated.
            raw: tag.raw.filter(|raw| raw.chars().count() <= LONGEST_LINE),
        };
        self.heard += 1;
        self.undated += u64::from(clock.utc().is_none());
        // Both have one moment, by which they are found to be one detection.
        bus.send(Entity::Hydrophone, &detection.report());
        if let Some(tag) = detection.fish_tag() {
            bus.send(Entity::Hydrophone, &tag);
        }
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// Where the hydrophone was when the transmission began whose line came at `at` with this stamp, if it is trusted.
    fn pose(&self, bus: &Bus, at: MonoTime, stamp: Option<UtcTime>) -> Option<Pose> {
        // Both clocks count microseconds in 63 bits; a UTC stamp is converted by the present offset between them.
        let micros = |at: MonoTime| at.micros() as i64;
        let heard_us = stamp.map_or(micros(at), |stamp| micros(bus.mono()) - (bus.utc() - stamp));
        let transmission_us = self.settings.transmission.as_micros() as i64;
        self.poses.then(heard_us.saturating_sub(transmission_us), &self.settings.arm)
    }

    /// A report of the water, which came at `at`.
    pub(crate) fn water(&mut self, bus: &mut Bus, states: &mut States, at: MonoTime, water: &WaterReading) {
        self.line(bus, water.serial, water.frequency_khz, water.lines_lost);
        self.noise = Some((at, water.noise_average, water.noise_peak));
        let temperature = if water.temperature_c.is_finite() { water.temperature_c as f32 } else { return };
        bus.send(Entity::Hydrophone, &Temperature { value: temperature });
        let clock = self.clock_of(water.clock_s, 0);
        self.told_set(bus, clock);
        if clock.utc().is_some() {
            let message = TBRSensor {
                serial_no: water.serial,
                unix_timestamp: water.clock_s,
                temperature,
                avg_noise_level: water.noise_average,
                peak_noise_level: water.noise_peak,
                recv_listen_freq: water.frequency_khz,
                recv_mem_addr: water.counter,
            };
            bus.send(Entity::Hydrophone, &message);
        } else {
            self.keep_as_text(bus, at, clock, water);
        }
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// The receiver's count, and what is known of it: a stamp says whether it was ever set, the driver whether it is kept.
    fn clock_of(&self, seconds: u32, millis: u16) -> ReceiverClock {
        let mut clock = ReceiverClock::read(seconds, millis);
        if let Some(known) = self.known_clock() {
            clock.state = clock.state.with(known);
        }
        clock
    }

    /// What the driver knows of the clock; `None` where it knows nothing.
    fn known_clock(&self) -> Option<ClockState> {
        match self.receiver.as_ref()?.clock {
            devices::ClockState::Lost => Some(ClockState::Lost),
            devices::ClockState::Disciplined => Some(ClockState::Disciplined),
            devices::ClockState::Set => Some(ClockState::Set),
            devices::ClockState::Unset => Some(ClockState::NotSet),
            devices::ClockState::Unknown => None,
        }
    }

    /// Why the clock is lost, if it is.
    fn lost_clock(&self) -> Option<&str> {
        let lost = self.receiver.as_ref().filter(|receiver| receiver.clock == devices::ClockState::Lost);
        lost.map(|receiver| receiver.clock_fault.as_str())
    }

    /// Reports when it changes whether the receiver's clock is set.
    fn told_set(&mut self, bus: &mut Bus, clock: ReceiverClock) {
        let unset = clock.state == ClockState::NotSet;
        if unset != self.unset {
            self.unset = unset;
            let (level, text) = if unset {
                (Level::Warning, "the receiver's clock is not set: what it hears has no time of its own")
            } else {
                (Level::Info, "the receiver's clock is set: detections have a time again")
            };
            bus.entry(Entity::Hydrophone, level, text);
        }
    }

    /// A report of the water as text: in a TBRSensor, seconds since power-up would be taken for those since 1970.
    fn keep_as_text(&self, bus: &mut Bus, at: MonoTime, clock: ReceiverClock, water: &WaterReading) {
        let place = self.poses.then(at.micros() as i64, &self.settings.arm);
        let place = place.map_or_else(String::new, |pose| {
            format!(";lat_deg={:.6};lon_deg={:.6}", pose.place.lat_deg(), pose.place.lon_deg())
        });
        let (text, arrived) = (water_text(clock, water), bus.utc_of(at));
        let value = format!("{text};arrived_by_vessel_clock={arrived}{place}");
        bus.send(Entity::Hydrophone, &DevDataText { value: value.as_str().into() });
    }

    fn condition(&self) -> Condition {
        let device = self.device.as_ref().map(|state| state.condition);
        match device {
            // It hears: settings that its driver still waits for do not matter.
            Some(Condition::Boot) if self.heard == 0 && self.noise.is_none() => Condition::Boot,
            Some(bad) if bad.is_bad() => bad,
            _ if self.unset || self.lost_clock().is_some() => Condition::Fault,
            _ => Condition::Normal,
        }
    }

    fn text(&self) -> String {
        let why = self.device.as_ref().filter(|state| state.condition.is_bad());
        let why = why.map_or_else(String::new, |state| format!("{}; ", state.text));
        let lost = self.lost_clock().map_or_else(String::new, |why| {
            format!("{why}; until then detections have no time of day and no TBRFishTag; ")
        });
        let undated = match self.undated {
            0 => String::new(),
            some => format!(", {some} of them without a time"),
        };
        let clock = if self.unset && lost.is_empty() { "; the receiver's clock is not set" } else { "" };
        format!("{why}{lost}{} detections{undated}, {} lines lost{clock}", self.heard, self.lost_lines)
    }

    /// A line came. Its driver counts by the running numbers how many were lost before it.
    fn line(&mut self, bus: &mut Bus, serial: u32, frequency_khz: u8, lost: Option<u16>) {
        self.serial = Some(serial);
        self.frequency_khz = Some(frequency_khz);
        if let Some(lost) = lost.filter(|lost| *lost > 0) {
            self.lost_lines += u64::from(lost);
            let text = format!("{lost} lines of the receiver lost");
            bus.entry(Entity::Hydrophone, Level::Warning, text);
        }
    }

    fn effort(&self, now: MonoTime, lines_lost: Option<u16>) -> Effort {
        let noise = |(at, average, peak): (MonoTime, u8, u8)| Noise {
            average,
            peak,
            age_s: now.since(at).as_secs_f64(),
        };
        Effort { lines_lost, noise: self.noise.map(noise), propeller_rpm: self.propeller_rpm(now) }
    }

    /// Speed of the faster propeller (rpm). Absent if only one is known, as the other may be faster.
    fn propeller_rpm(&self, now: MonoTime) -> Option<f64> {
        let turns = self.propellers.map(|known| known.filter(|(at, _)| now.since(*at) <= MOTOR_LIFE));
        turns.port.zip(turns.starboard).map(|((_, port), (_, starboard))| port.max(starboard))
    }

    /// Reports how the receiver listens when that changed, and again after a while. Called once a second.
    pub(crate) fn tell(&mut self, bus: &mut Bus, motors: MotorPair) {
        if self.device.is_none() && self.receiver.is_none() && self.serial.is_none() {
            // The vessel has none.
            return;
        }
        let now = bus.mono();
        let listening = self.listening(now, motors);
        let due =
            self.told.is_none_or(|(at, told)| now.since(at) >= TOLD_AGAIN || is_other(&told, &listening));
        if due {
            self.told = Some((now, listening));
            bus.send(Entity::Hydrophone, &listening.report());
        }
    }

    fn listening(&self, now: MonoTime, motors: MotorPair) -> Listening {
        let receiver = self.receiver.as_ref();
        let LeverArm { down_m, .. } = self.settings.arm;
        Listening {
            // A simulated receiver has no driver, and listens.
            on: receiver.map_or(self.device.is_none(), |receiver| receiver.listening),
            receiver: self.serial,
            frequency_khz: receiver.and_then(|receiver| receiver.frequency_khz).or(self.frequency_khz),
            protocols: receiver.and_then(|receiver| receiver.protocols),
            thrust: Some(motors.port.abs().max(motors.starboard.abs())),
            propeller_rpm: self.propeller_rpm(now),
            clock: self.known_clock().or(self.unset.then_some(ClockState::NotSet)),
            clock_offset_s: receiver.and_then(|receiver| receiver.clock_offset_s),
            below_antenna_m: (down_m != 0.0).then_some(down_m),
        }
    }
}

/// Whether a receiver listens otherwise than last reported.
fn is_other(told: &Listening, now: &Listening) -> bool {
    let facts = |one: &Listening| (one.on, one.receiver, one.frequency_khz, one.protocols, one.clock);
    let thrust = told.thrust.zip(now.thrust);
    facts(told) != facts(now)
        || thrust
            .is_none_or(|(told, now)| (told - now).abs() >= OTHER_THRUST || (told == 0.0) != (now == 0.0))
}

/// A regular report of a receiver whose clock is not set or lost, as tuples.
fn water_text(clock: ReceiverClock, water: &WaterReading) -> String {
    let WaterReading {
        serial,
        clock_s,
        temperature_c,
        noise_average,
        noise_peak,
        frequency_khz,
        counter,
        ..
    } = water;
    let (state, count) = match clock.state {
        ClockState::NotSet => ("not set", "since_power_up_s"),
        other => (other.word(), "clock_s"),
    };
    format!(
        "clock={state};{count}={clock_s};serial={serial};temperature_c={temperature_c:.1};\
         noise_average={noise_average};noise_peak={noise_peak};frequency_khz={frequency_khz};line={counter}"
    )
}
