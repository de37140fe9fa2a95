//! A tagged fish: where it swims and when its tag transmits.
//!
//! Swimming: a correlated random walk. Heading turns by a first-order rate of turn, speed and depth are
//! first-order processes about their means; beyond the edge of its area the fish turns back to the middle.
//! (The velocity of recorded tracks of tagged fish decorrelates over about a minute.)
//!
//! A fish depends on its own seed and on UTC alone, never on a vessel: several vessels, even in several
//! processes, that are given the same [`FishConfig`] hear the same fish.
//!
//! Tags transmit at random intervals, in whole seconds of the tag's own clock, which drifts (as recorded
//! tags do). Depth is sent as counts of 0.2 m, the default of the Otters' tag simulator.

use crate::process::GaussMarkov;
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use devices::tbr::TagProtocol;
use std::f64::consts::TAU;
use units::{LatLon, LocalFrame, LocalPoint, UtcTime, wrap_pi};

const STEP_US: i64 = 1_000_000;
const DEPTH_PER_COUNT_M: f64 = 0.2;
/// Turning: deviation (rad/s) and time constant (s) of the rate of turn.
const TURN_RADPS: f64 = 0.05;
const TURN_S: f64 = 30.0;
/// Fastest turn back from the edge (rad/s).
const RETURN_RADPS: f64 = 0.2;

/// A fish and its tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FishConfig {
    /// Seed of its movement and of its intervals.
    pub seed: u64,
    /// When its movement begins, in the middle of its area; before, it transmits nothing. A [`Vessel`] admits
    /// at most a year before its own start.
    ///
    /// [`Vessel`]: crate::Vessel
    pub since: UtcTime,
    /// Middle of its area.
    pub centre: LatLon,
    /// Radius of its area (m).
    pub radius_m: f64,
    /// Mean speed (m/s).
    pub speed_mps: f64,
    /// Mean depth (m).
    pub depth_m: f64,
    /// Standard deviation of the depth (m).
    pub depth_variation_m: f64,
    /// Coding.
    pub protocol: TagProtocol,
    /// Number of the tag.
    pub tag_id: u32,
    /// Carrier (kHz).
    pub frequency_khz: u8,
    /// Shortest interval between transmissions (s).
    pub interval_min_s: u32,
    /// Longest interval between transmissions (s).
    pub interval_max_s: u32,
    /// Drift of the tag's clock (parts per million).
    pub clock_ppm: f64,
}

impl FishConfig {
    /// A salmon-like fish about 10 m deep within 300 m of a place, with an S256 depth tag on 69 kHz that
    /// transmits every 30 to 90 s.
    pub fn near(centre: LatLon, since: UtcTime, tag_id: u32, seed: u64) -> Self {
        Self {
            seed,
            since,
            centre,
            radius_m: 300.0,
            speed_mps: 0.4,
            depth_m: 10.0,
            depth_variation_m: 3.0,
            protocol: TagProtocol::S256,
            tag_id,
            frequency_khz: 69,
            interval_min_s: 30,
            interval_max_s: 90,
            clock_ppm: 8.0,
        }
    }

    fn check(&self) -> Result<(), OutOfRange> {
        within("radius of the fish's area (m)", self.radius_m, 1.0, 1e5)?;
        within("speed of the fish (m/s)", self.speed_mps, 0.0, 5.0)?;
        within("depth of the fish (m)", self.depth_m, 0.0, 1000.0)?;
        within("depth variation of the fish (m)", self.depth_variation_m, 0.0, 500.0)?;
        within("carrier of the tag (kHz)", f64::from(self.frequency_khz), 30.0, 250.0)?;
        within("shortest tag interval (s)", f64::from(self.interval_min_s), 1.0, 86_400.0)?;
        let longest = f64::from(self.interval_max_s);
        within("longest tag interval (s)", longest, f64::from(self.interval_min_s), 86_400.0)?;
        within("drift of the tag's clock (ppm)", self.clock_ppm, -1000.0, 1000.0)?;
        Ok(())
    }
}

/// One transmission of a tag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ping {
    /// When it left the tag.
    pub utc: UtcTime,
    /// Where the tag was.
    pub place: LatLon,
    /// How deep the tag was (m).
    pub depth_m: f64,
    /// Coding.
    pub protocol: TagProtocol,
    /// Number of the tag.
    pub tag_id: u32,
    /// The value sent, where the coding has one.
    pub data: Option<u16>,
    /// Carrier (kHz).
    pub frequency_khz: u8,
}

/// The swimming fish.
#[derive(Debug, Clone)]
pub struct Fish {
    config: FishConfig,
    frame: LocalFrame,
    /// Time of the state below; a whole number of steps since the beginning.
    at_us: i64,
    position: LocalPoint,
    heading_rad: f64,
    turn: GaussMarkov,
    speed: GaussMarkov,
    depth: GaussMarkov,
    next_ping_us: i64,
    rng: Rng,
}

impl Fish {
    /// The fish at the beginning of its movement.
    ///
    /// # Errors
    /// When a setting is not a number or out of range.
    pub fn new(config: &FishConfig) -> Result<Self, OutOfRange> {
        config.check()?;
        let mut rng = Rng::new(config.seed, Stream::Fish);
        let heading_rad = rng.between(0.0, TAU);
        let mut fish = Self {
            config: *config,
            frame: LocalFrame::new(config.centre),
            at_us: config.since.micros(),
            position: LocalPoint::default(),
            heading_rad,
            turn: GaussMarkov::new(TURN_RADPS, TURN_S, 1.0, &mut rng),
            speed: GaussMarkov::new(0.25 * config.speed_mps, 60.0, 1.0, &mut rng),
            depth: GaussMarkov::new(config.depth_variation_m, 300.0, 1.0, &mut rng),
            next_ping_us: config.since.micros(),
            rng,
        };
        // The first transmission falls anywhere within an interval.
        let longest = f64::from(config.interval_max_s);
        fish.next_ping_us += (fish.rng.uniform() * longest * 1e6) as i64;
        Ok(fish)
    }

    /// Swims on towards `until` and returns the next transmission up to then, if any; call until `None`.
    pub fn advance(&mut self, until: UtcTime) -> Option<Ping> {
        if self.next_ping_us > until.micros() {
            self.swim(until.micros());
            return None;
        }
        let ping_us = self.next_ping_us;
        self.swim(ping_us);
        let (position, depth_m) = self.at(ping_us);
        let spread = f64::from(self.config.interval_max_s - self.config.interval_min_s);
        let whole_s = f64::from(self.config.interval_min_s) + (self.rng.uniform() * (spread + 1.0)).floor();
        self.next_ping_us += (whole_s * (1e6 + self.config.clock_ppm)) as i64;
        // At most `data_max`, so the cast keeps the value.
        let counts = (depth_m / DEPTH_PER_COUNT_M).round();
        Some(Ping {
            utc: UtcTime::from_micros(ping_us),
            place: self.frame.to_place(position),
            depth_m,
            protocol: self.config.protocol,
            tag_id: self.config.tag_id,
            data: self.config.protocol.data_max().map(|max| counts.min(f64::from(max)) as u16),
            frequency_khz: self.config.frequency_khz,
        })
    }

    /// Where the fish is (place and depth in metres) at `utc`, which should not lie more than a second from
    /// the time it last swam to.
    pub fn truth(&self, utc: UtcTime) -> (LatLon, f64) {
        let (position, depth_m) = self.at(utc.micros());
        (self.frame.to_place(position), depth_m)
    }

    /// Straight on from the last whole step.
    fn at(&self, at_us: i64) -> (LocalPoint, f64) {
        let dt_s = (at_us - self.at_us) as f64 / 1e6;
        (self.position.displaced(self.heading_rad, self.speed_mps() * dt_s), self.depth_m())
    }

    fn speed_mps(&self) -> f64 {
        (self.config.speed_mps + self.speed.value()).max(0.0)
    }

    fn depth_m(&self) -> f64 {
        (self.config.depth_m + self.depth.value()).max(0.0)
    }

    fn swim(&mut self, until_us: i64) {
        while self.at_us + STEP_US <= until_us {
            self.position = self.position.displaced(self.heading_rad, self.speed_mps());
            self.at_us += STEP_US;
            let mut turn_radps = self.turn.step(&mut self.rng);
            let centre = LocalPoint::default();
            if self.position.distance_m(centre) > self.config.radius_m {
                let home_rad = wrap_pi(self.position.bearing_rad(centre) - self.heading_rad);
                turn_radps = home_rad.clamp(-RETURN_RADPS, RETURN_RADPS);
            }
            self.heading_rad = wrap_pi(self.heading_rad + turn_radps);
            self.speed.step(&mut self.rng);
            self.depth.step(&mut self.rng);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> FishConfig {
        let centre = LatLon::from_deg(63.44, 10.35).unwrap();
        FishConfig::near(centre, UtcTime::from_micros(1_718_000_000_000_000), 40, 3)
    }

    fn pings(config: &FishConfig, hours: i64) -> Vec<Ping> {
        let mut fish = Fish::new(config).unwrap();
        let until = UtcTime::from_micros(config.since.micros() + hours * 3_600_000_000);
        std::iter::from_fn(|| fish.advance(until)).collect()
    }

    #[test]
    fn stays_in_its_area_and_depth() {
        let config = config();
        let frame = LocalFrame::new(config.centre);
        let pings = pings(&config, 24);
        let far = |p: &Ping| frame.to_local(p.place).distance_m(LocalPoint::default());
        assert!(pings.iter().all(|p| far(p) < 320.0 && (0.0..=22.0).contains(&p.depth_m)));
        // It does swim about: a quarter of the time it is in the outer part.
        assert!(pings.iter().filter(|p| far(p) > 150.0).count() > pings.len() / 4);
        assert!(pings.iter().all(|p| p.data == Some((p.depth_m / 0.2).round() as u16)));
    }

    #[test]
    fn transmits_at_whole_seconds_of_its_drifting_clock() {
        let pings = pings(&config(), 24);
        assert!(pings.len() > 24 * 3600 / 70 && pings.len() < 24 * 3600 / 50);
        for pair in pings.windows(2) {
            let gap_us = pair[1].utc - pair[0].utc;
            assert!((30_000_000..=90_001_000).contains(&gap_us));
            // 8 ppm of 90 s are 0.72 ms.
            assert!(gap_us % 1_000_000 < 730, "{gap_us}");
        }
    }

    #[test]
    fn is_the_same_however_it_is_asked() {
        let config = config();
        let mut fish = Fish::new(&config).unwrap();
        let mut found = Vec::new();
        for ms in (0..3_600_000).step_by(40) {
            let until = UtcTime::from_micros(config.since.micros() + ms * 1000);
            while let Some(ping) = fish.advance(until) {
                found.push(ping);
            }
        }
        let whole = pings(&config, 1);
        assert_eq!(found[..], whole[..found.len()]);
        assert!(whole.len() - found.len() <= 1);
    }

    #[test]
    fn only_codings_with_data_send_some() {
        let silent = FishConfig { protocol: TagProtocol::R64K, ..config() };
        assert!(pings(&silent, 1).iter().all(|p| p.data.is_none()));
        let wrong = FishConfig { interval_min_s: 100, ..config() };
        assert!(Fish::new(&wrong).is_err());
    }
}
