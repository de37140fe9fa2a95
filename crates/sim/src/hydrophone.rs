//! The Thelma hydrophone: which transmissions of tags it hears, when, and how loud.
//!
//! Time of arrival = time of transmission + distance / c + jitter, the distance to where the vessel is on
//! arrival. SNR = 50 dB - 0.05 dB/m · distance - motor noise + scatter; below a limit, and by chance, a
//! transmission is missed (as the fish-tag simulator of the Otters has it). Motor noise grows
//! with the mean shaft speed; the default loses more than half of the range at full speed, as Dallolio et
//! al., Front. Mar. Sci. 2022, 857623 report of a thruster. Trains of pulses that overlap destroy each other. A line leaves when the train has ended.
//!
//! The receiver stamps by its own clock, which may be off, may drift, and counts from power-up until set.

use crate::fish::Ping;
use crate::otter::{OtterState, shaft_max_radps};
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use crate::tbr_clock::{ClockConfig, ReceiverClock};
use devices::tbr::rounded_temperature_c;
use devices::{Reading, TagReading, WaterReading};
use units::{LocalFrame, UtcTime};

/// Transmissions farther away than this (m) are not followed.
const REACH_M: f64 = 3_000.0;
/// Sound that arrived longer ago than this (s) is past hearing: the transmission was handed in too late.
const STALE_S: f64 = 1.0;
/// Transmissions followed at a time; what comes beyond them is not heard.
const UNDER_WAY_KEPT: usize = 1_000;
/// From the end of a train to its line (s).
const DECODING_S: f64 = 0.1;

/// A hydrophone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HydrophoneConfig {
    /// Serial number.
    pub serial: u32,
    /// Frequency listened to (kHz).
    pub frequency_khz: u8,
    /// Depth below the surface (m).
    pub depth_m: f64,
    /// Speed of sound (m/s).
    pub sound_mps: f64,
    /// SNR of a tag close by (dB).
    pub source_snr_db: f64,
    /// SNR lost per metre (dB/m).
    pub loss_dbpm: f64,
    /// Standard deviation of the SNR (dB).
    pub scatter_db: f64,
    /// SNR below which nothing is detected (dB).
    pub limit_snr_db: f64,
    /// Share of the transmissions loud enough that is missed all the same.
    pub miss_probability: f64,
    /// SNR lost to both motors at full speed (dB).
    pub motor_noise_db: f64,
    /// Standard deviation of the time of arrival (s).
    pub jitter_s: f64,
    /// Length of a train of pulses (s).
    pub train_s: f64,
    /// Time between reports of the water (s); 0 for none.
    pub sensor_interval_s: f64,
    /// The receiver's clock.
    pub clock: ClockConfig,
}

impl Default for HydrophoneConfig {
    /// A TBR 700 on 69 kHz, 1 m deep, its clock set; sound speed, SNR and its loss as in the Otters'
    /// simulator.
    fn default() -> Self {
        Self {
            serial: 1_000_042,
            frequency_khz: 69,
            depth_m: 1.0,
            sound_mps: 1485.0,
            source_snr_db: 50.0,
            loss_dbpm: 0.05,
            scatter_db: 2.0,
            limit_snr_db: 6.0,
            miss_probability: 0.1,
            motor_noise_db: 25.0,
            jitter_s: 0.001,
            train_s: 3.5,
            sensor_interval_s: 300.0,
            clock: ClockConfig::default(),
        }
    }
}

impl HydrophoneConfig {
    fn check(&self) -> Result<(), OutOfRange> {
        within("depth of the hydrophone (m)", self.depth_m, 0.0, 100.0)?;
        within("speed of sound (m/s)", self.sound_mps, 1000.0, 2000.0)?;
        within("SNR of a near tag (dB)", self.source_snr_db, 0.0, 200.0)?;
        within("SNR lost per metre (dB/m)", self.loss_dbpm, 0.0, 10.0)?;
        within("scatter of the SNR (dB)", self.scatter_db, 0.0, 50.0)?;
        within("least SNR (dB)", self.limit_snr_db, 0.0, 200.0)?;
        within("share of missed transmissions", self.miss_probability, 0.0, 1.0)?;
        within("motor noise (dB)", self.motor_noise_db, 0.0, 200.0)?;
        within("arrival jitter (s)", self.jitter_s, 0.0, 1.0)?;
        within("length of a pulse train (s)", self.train_s, 0.1, 30.0)?;
        within("sensor interval (s)", self.sensor_interval_s, 0.0, 86_400.0)?;
        Ok(())
    }
}

/// A detection that waits for the end of its train.
#[derive(Debug, Clone, Copy)]
struct Heard {
    arrival_us: i64,
    /// By the receiver's clock as it went then (µs).
    stamp_us: i64,
    ping: Ping,
    snr_db: f64,
    garbled: bool,
}

/// The hydrophone.
#[derive(Debug, Clone)]
pub(crate) struct Hydrophone {
    config: HydrophoneConfig,
    water_c: f64,
    clock: ReceiverClock,
    counter: u16,
    under_way: Vec<Ping>,
    heard: Vec<Heard>,
    next_sensor_us: i64,
    rng: Rng,
}

impl Hydrophone {
    pub(crate) fn new(
        config: &HydrophoneConfig,
        water_c: f64,
        seed: u64,
        start: UtcTime,
    ) -> Result<Self, OutOfRange> {
        config.check()?;
        let clock = ReceiverClock::new(&config.clock, start)?;
        let mut hydrophone = Self {
            config: *config,
            water_c,
            clock,
            counter: 0,
            under_way: Vec::new(),
            heard: Vec::new(),
            next_sensor_us: i64::MAX,
            rng: Rng::new(seed, Stream::Hydrophone),
        };
        if config.sensor_interval_s > 0.0 {
            hydrophone.next_sensor_us = start.micros() + hydrophone.sensor_interval_us();
        }
        Ok(hydrophone)
    }

    fn sensor_interval_us(&self) -> i64 {
        ((self.config.sensor_interval_s * 1e6) as i64).max(1)
    }

    /// The receiver's clock, for its commands.
    pub(crate) fn clock_mut(&mut self) -> &mut ReceiverClock {
        &mut self.clock
    }

    /// A tag has transmitted; it will be heard, if at all, when the sound has come.
    pub(crate) fn hear(&mut self, ping: Ping) {
        if ping.frequency_khz == self.config.frequency_khz && self.under_way.len() < UNDER_WAY_KEPT {
            self.under_way.push(ping);
        }
    }

    /// Advances to `now`, at which the vessel is in the given state; lines that are due are added to `out`.
    pub(crate) fn step(
        &mut self,
        now: UtcTime,
        state: &OtterState,
        frame: &LocalFrame,
        out: &mut Vec<(UtcTime, Reading)>,
    ) {
        let mut i = 0;
        while i < self.under_way.len() {
            if self.travel(i, now, state, frame) {
                self.under_way.remove(i);
            } else {
                i += 1;
            }
        }
        self.report(now, out);
        if now.micros() >= self.next_sensor_us {
            let at = UtcTime::from_micros(self.next_sensor_us);
            self.next_sensor_us += self.sensor_interval_us();
            let line = self.sensor_line(at, state);
            out.push((at, Reading::Water(line)));
        }
    }

    /// Whether the sound of a transmission is done with: it has arrived or passed out of reach.
    fn travel(&mut self, index: usize, now: UtcTime, state: &OtterState, frame: &LocalFrame) -> bool {
        let ping = self.under_way[index];
        let travelled_m = (now - ping.utc) as f64 / 1e6 * self.config.sound_mps;
        let tag = frame.to_local(ping.place);
        let (north_m, east_m) = (state.position.north_m - tag.north_m, state.position.east_m - tag.east_m);
        let distance_m = north_m.hypot(east_m).hypot(ping.depth_m - self.config.depth_m);
        if travelled_m < distance_m {
            return travelled_m > REACH_M;
        }
        // Back to the moment at which the sound met the moving vessel.
        let (north_mps, east_mps) = state.ground_velocity_mps();
        let opening_mps = (north_m * north_mps + east_m * east_mps) / distance_m.max(1.0);
        let late_s = (travelled_m - distance_m) / (self.config.sound_mps - opening_mps);
        if late_s <= STALE_S {
            self.arrive(ping, now.micros() as f64 - late_s * 1e6, distance_m, state);
        }
        true
    }

    fn arrive(&mut self, ping: Ping, arrival_us: f64, distance_m: f64, state: &OtterState) {
        let c = self.config;
        let noise_share =
            0.5 * (state.shaft_radps.port.abs() + state.shaft_radps.starboard.abs()) / shaft_max_radps();
        // All chance is drawn whatever comes of it, so that one detection does not shift the next ones.
        let scatter_db = c.scatter_db * self.rng.normal();
        let jitter_s = c.jitter_s * self.rng.normal();
        let missed = self.rng.chance(c.miss_probability);
        let snr_db = c.source_snr_db - c.loss_dbpm * distance_m - c.motor_noise_db * noise_share + scatter_db;
        if snr_db < c.limit_snr_db || missed {
            return;
        }
        let arrival_us = (arrival_us + jitter_s * 1e6).round() as i64;
        let stamp_us = self.clock.reading_us(UtcTime::from_micros(arrival_us)).max(0);
        let mut heard = Heard { arrival_us, stamp_us, ping, snr_db, garbled: false };
        for other in &mut self.heard {
            if (other.arrival_us - arrival_us).abs() < (c.train_s * 1e6) as i64 {
                other.garbled = true;
                heard.garbled = true;
            }
        }
        self.heard.push(heard);
    }

    fn report(&mut self, now: UtcTime, out: &mut Vec<(UtcTime, Reading)>) {
        let wait_us = ((self.config.train_s + DECODING_S) * 1e6) as i64;
        while let Some(index) = self.heard.iter().position(|h| h.arrival_us + wait_us <= now.micros()) {
            let Heard { arrival_us, stamp_us, ping, snr_db, garbled } = self.heard.remove(index);
            if garbled {
                continue;
            }
            let mut line = TagReading {
                serial: self.config.serial,
                clock_s: u32::try_from(stamp_us / 1_000_000).unwrap_or(u32::MAX),
                millis: (stamp_us / 1000 % 1000) as u16,
                protocol: ping.protocol.name().to_owned(),
                tag_id: ping.tag_id,
                data: ping.data,
                snr_db: snr_db.round().clamp(0.0, 255.0) as u8,
                frequency_khz: ping.frequency_khz,
                counter: self.count(),
                raw: None,
                lines_lost: None,
            };
            line.raw = Some(line.line());
            out.push((UtcTime::from_micros(arrival_us + wait_us), Reading::Tag(line)));
        }
    }

    fn sensor_line(&mut self, at: UtcTime, state: &OtterState) -> WaterReading {
        let noise_share =
            0.5 * (state.shaft_radps.port.abs() + state.shaft_radps.starboard.abs()) / shaft_max_radps();
        let average = 3.0 + self.config.motor_noise_db * noise_share + self.rng.uniform();
        let clock_s = self.clock.reading_us(at).max(0) / 1_000_000;
        WaterReading {
            serial: self.config.serial,
            clock_s: u32::try_from(clock_s).unwrap_or(u32::MAX),
            temperature_c: rounded_temperature_c(self.water_c),
            noise_average: average as u8,
            noise_peak: (average + self.rng.between(3.0, 15.0)) as u8,
            frequency_khz: self.config.frequency_khz,
            counter: self.count(),
            lines_lost: None,
        }
    }

    fn count(&mut self) -> u16 {
        self.counter = self.counter.wrapping_add(1);
        self.counter
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use devices::Pair;
    use devices::tbr::TagProtocol;
    use units::{LatLon, LocalPoint};

    const START: UtcTime = UtcTime::from_micros(1_718_000_000_000_000);

    fn frame() -> LocalFrame {
        LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap())
    }

    fn ping(distance_m: f64, after_ms: i64, tag_id: u32) -> Ping {
        Ping {
            utc: UtcTime::from_micros(START.micros() + after_ms * 1000),
            place: frame().to_place(LocalPoint { north_m: distance_m, east_m: 0.0 }),
            depth_m: 1.0,
            protocol: TagProtocol::R64K,
            tag_id,
            data: None,
            frequency_khz: 69,
        }
    }

    fn ideal() -> HydrophoneConfig {
        HydrophoneConfig {
            jitter_s: 0.0,
            scatter_db: 0.0,
            miss_probability: 0.0,
            sensor_interval_s: 0.0,
            ..HydrophoneConfig::default()
        }
    }

    fn tags(config: &HydrophoneConfig, state: &OtterState, pings: &[Ping]) -> Vec<TagReading> {
        let mut hydrophone = Hydrophone::new(config, 8.0, 1, START).unwrap();
        let mut lines = Vec::new();
        for step in 0..1_000 {
            let now = UtcTime::from_micros(START.micros() + step * 40_000);
            for ping in pings.iter().filter(|p| (0..40_000).contains(&(now - p.utc))) {
                hydrophone.hear(*ping);
            }
            hydrophone.step(now, state, &frame(), &mut lines);
        }
        lines
            .into_iter()
            .filter_map(|(_, line)| match line {
                Reading::Tag(tag) => Some(tag),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn sound_arrives_after_its_way_and_grows_fainter() {
        // (distance, milliseconds on the way at 1485 m/s, SNR).
        for (distance_m, millis, snr_db) in [(0.0, 0, 50), (297.0, 200, 35), (594.0, 400, 20)] {
            let lines = tags(&ideal(), &OtterState::default(), &[ping(distance_m, 1000, 7)]);
            assert_eq!((lines[0].clock_s, lines[0].snr_db), (1_718_000_001, snr_db), "{distance_m}");
            assert!(lines[0].millis.abs_diff(millis) <= 1, "{lines:?}");
        }
        assert!(tags(&ideal(), &OtterState::default(), &[ping(900.0, 1000, 7)]).is_empty());
    }

    #[test]
    fn motors_at_full_speed_cost_more_than_half_of_the_range() {
        let n = shaft_max_radps();
        let noisy = OtterState { shaft_radps: Pair::new(n, n), ..OtterState::default() };
        assert_eq!(tags(&ideal(), &noisy, &[ping(370.0, 0, 7)]).len(), 1);
        assert!(tags(&ideal(), &noisy, &[ping(430.0, 0, 7)]).is_empty());
        assert_eq!(tags(&ideal(), &OtterState::default(), &[ping(870.0, 0, 7)]).len(), 1);
    }

    #[test]
    fn overlapping_trains_destroy_each_other() {
        let state = OtterState::default();
        let ids = |pings: &[Ping]| tags(&ideal(), &state, pings).iter().map(|t| t.tag_id).collect::<Vec<_>>();
        assert!(ids(&[ping(10.0, 0, 1), ping(10.0, 3000, 2)]).is_empty());
        assert_eq!(ids(&[ping(10.0, 0, 1), ping(10.0, 3600, 2)]), [1, 2]);
        assert!(ids(&[ping(10.0, 0, 1), ping(10.0, 3000, 2), ping(10.0, 6000, 3)]).is_empty());
    }

    #[test]
    fn misses_its_share() {
        let pings: Vec<Ping> = (0..9).map(|i| ping(10.0, i * 4000, 1)).collect();
        let config = HydrophoneConfig { miss_probability: 1.0, ..ideal() };
        assert!(tags(&config, &OtterState::default(), &pings).is_empty());
        assert_eq!(tags(&ideal(), &OtterState::default(), &pings).len(), 9);
        let other_channel = Ping { frequency_khz: 67, ..ping(10.0, 0, 1) };
        assert!(tags(&ideal(), &OtterState::default(), &[other_channel]).is_empty());
    }

    #[test]
    fn counts_its_lines_without_a_gap() {
        let config = HydrophoneConfig { sensor_interval_s: 10.0, ..ideal() };
        let mut hydrophone = Hydrophone::new(&config, 8.0, 1, START).unwrap();
        let mut lines = Vec::new();
        for step in 0..2_000 {
            let now = UtcTime::from_micros(START.micros() + step * 40_000);
            if step % 200 == 0 {
                hydrophone.hear(Ping { utc: now, ..ping(50.0, 0, 1) });
            }
            hydrophone.step(now, &OtterState::default(), &frame(), &mut lines);
        }
        let counters: Vec<u16> = lines
            .iter()
            .map(|(_, line)| match line {
                Reading::Tag(tag) => tag.counter,
                Reading::Water(water) => water.counter,
                other => panic!("{other:?} is not one of the hydrophone's"),
            })
            .collect();
        assert_eq!(counters, (1..=counters.len() as u16).collect::<Vec<_>>());
        assert!(
            lines.iter().any(|(_, l)| matches!(l, Reading::Water(w) if (w.temperature_c - 8.0).abs() < 1e-9))
        );
    }
}
