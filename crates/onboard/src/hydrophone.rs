//! What the hydrophone reads: detections of tagged fish, and the water.
//!
//! A detection gets the place the vessel was at when it was heard: at the receiver's stamp less the length of a tag's
//! transmission. A receiver whose clock was never set counts seconds since power-up; its detections get the place of
//! their arrival and no time of day. Each detection leaves as an Event that tells all of it, and as the TBRFishTag
//! that every console knows, unless that would be false ([`Detection::fish_tag`]).

use crate::bus::Bus;
use crate::entity::Entity;
use crate::navigation::Estimate;
use crate::output::Level;
use crate::poses::Poses;
use crate::states::{Condition, States};
use detections::{Detection, Effort, Noise, Origin, Protocol, ReceiverClock};
use devices::{Pair, Side, TagReading, WaterReading};
use imc::messages::{DevDataText, TBRSensor, Temperature};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// Length of a transmission (µs), "Transmission Time".
const TRANSMISSION_US: i64 = 3_000_000;
/// A motor that reported longer ago than this is not known to turn as it did then.
const MOTOR_LIFE: Duration = Duration::from_secs(2);
/// Longest name of a coding that is repeated (characters).
const LONGEST_NAME: usize = 24;
/// Longest line of a receiver that is repeated (characters).
const LONGEST_LINE: usize = 200;

/// What is known of the receiver and of how it can listen.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hydrophone {
    poses: Poses,
    last_counter: Option<u16>,
    lost_lines: u64,
    heard: u64,
    /// Those of them without a time of day.
    undated: u64,
    /// The receiver's clock is not set.
    unset: bool,
    /// Mean and peak noise as they were reported last, and when.
    noise: Option<(MonoTime, u8, u8)>,
    /// Propeller speeds (rpm, without direction), and when they were measured.
    propellers: Pair<Option<(MonoTime, f64)>>,
}

impl Hydrophone {
    /// Where the vessel is.
    pub(crate) fn at(&mut self, utc: UtcTime, estimate: &Estimate) {
        self.poses.at(utc, estimate);
    }

    /// How fast a propeller turns (rpm).
    pub(crate) fn propeller(&mut self, now: MonoTime, side: Side, rpm: f64) {
        *self.propellers.of_mut(side) = rpm.is_finite().then_some((now, rpm.abs()));
    }

    pub(crate) fn tag(&mut self, bus: &mut Bus, states: &mut States, tag: &TagReading) {
        let lines_lost = self.count(bus, tag.counter);
        let clock = ReceiverClock::read(tag.clock_s, tag.millis);
        self.clock(bus, clock);
        let heard = clock.utc().map_or(bus.utc(), |utc| UtcTime::from_micros(utc.micros() - TRANSMISSION_US));
        let name: String = tag.protocol.chars().take(LONGEST_NAME).collect();
        let detection = Detection {
            origin: Origin {
                system: bus.address(),
                entity: Entity::Hydrophone.number(),
                reported: bus.utc(),
                received: None,
            },
            receiver: tag.serial,
            clock,
            protocol: Protocol::named(&name),
            tag_id: tag.tag_id,
            data: tag.data,
            snr_db: tag.snr_db,
            frequency_khz: tag.frequency_khz,
            line: tag.counter,
            pose: self.poses.then(heard),
            effort: self.effort(bus.mono(), lines_lost),
            // No receiver writes longer lines: what is longer is not repeated.
            raw: tag.raw.clone().filter(|raw| raw.chars().count() <= LONGEST_LINE),
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

    pub(crate) fn water(&mut self, bus: &mut Bus, states: &mut States, water: &WaterReading) {
        self.count(bus, water.counter);
        self.noise = Some((bus.mono(), water.noise_average, water.noise_peak));
        let temperature = if water.temperature_c.is_finite() { water.temperature_c as f32 } else { return };
        bus.send(Entity::Hydrophone, &Temperature { value: temperature });
        let clock = ReceiverClock::read(water.clock_s, 0);
        self.clock(bus, clock);
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
            self.keep_as_text(bus, water);
        }
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// Tells when it changes whether the receiver's clock is set.
    fn clock(&mut self, bus: &mut Bus, clock: ReceiverClock) {
        let is_set = clock.utc().is_some();
        if is_set == self.unset {
            self.unset = !is_set;
            let (level, text) = if is_set {
                (Level::Info, "the receiver's clock is set: detections have a time again")
            } else {
                (Level::Warning, "the receiver's clock is not set: what it hears has no time of its own")
            };
            bus.entry(Entity::Hydrophone, level, text);
        }
    }

    /// A report of the water as text: in a TBRSensor, seconds since power-up would be taken for those since 1970.
    fn keep_as_text(&self, bus: &mut Bus, water: &WaterReading) {
        let place = self.poses.then(bus.utc()).map_or_else(String::new, |pose| {
            format!(";lat_deg={:.6};lon_deg={:.6}", pose.place.lat_deg(), pose.place.lon_deg())
        });
        let (text, arrived) = (water_text(water), bus.utc());
        let value = format!("{text};arrived_by_vessel_clock={arrived}{place}");
        bus.send(Entity::Hydrophone, &DevDataText { value: value.as_str().into() });
    }

    fn condition(&self) -> Condition {
        if self.unset { Condition::Fault } else { Condition::Normal }
    }

    fn text(&self) -> String {
        let undated = match self.undated {
            0 => String::new(),
            some => format!(", {some} of them without a time"),
        };
        let clock = if self.unset { "; the receiver's clock is not set" } else { "" };
        format!("{} detections{undated}, {} lines lost{clock}", self.heard, self.lost_lines)
    }

    /// Lines are numbered; a gap is lost lines. How many that was, where it is known.
    fn count(&mut self, bus: &mut Bus, counter: u16) -> Option<u16> {
        let last = self.last_counter.replace(counter)?;
        let missing = counter.wrapping_sub(last).wrapping_sub(1);
        if missing >= 1000 {
            // A receiver that started anew.
            return None;
        }
        if missing > 0 {
            self.lost_lines += u64::from(missing);
            let text = format!("{missing} lines of the receiver lost");
            bus.entry(Entity::Hydrophone, Level::Warning, text);
        }
        Some(missing)
    }

    fn effort(&self, now: MonoTime, lines_lost: Option<u16>) -> Effort {
        let noise = |(at, average, peak): (MonoTime, u8, u8)| Noise {
            average,
            peak,
            age_s: now.since(at).as_secs_f64(),
        };
        // Of one propeller nobody knows whether the other is faster.
        let turns = self.propellers.map(|known| known.filter(|(at, _)| now.since(*at) <= MOTOR_LIFE));
        let propeller_rpm =
            turns.port.zip(turns.starboard).map(|((_, port), (_, starboard))| port.max(starboard));
        Effort { lines_lost, noise: self.noise.map(noise), propeller_rpm }
    }
}

/// A regular report of a receiver whose clock is not set, as tuples.
fn water_text(water: &WaterReading) -> String {
    let WaterReading { serial, clock_s, temperature_c, noise_average, noise_peak, frequency_khz, counter } =
        water;
    format!(
        "clock=not set;since_power_up_s={clock_s};serial={serial};temperature_c={temperature_c:.1};\
         noise_average={noise_average};noise_peak={noise_peak};frequency_khz={frequency_khz};line={counter}"
    )
}
