//! The GNSS compass: where the vessel seems to be, how it seems to move and where it seems to head.
//!
//! Errors of a satellite compass with half a metre between its antennas, as simple processes: position =
//! truth + white noise + a slow first-order error (orbit, ionosphere); velocity and rate of turn with white
//! noise; heading with white and slow noise. Course and speed are those over ground, so that course differs
//! from heading by the crab angle, and the course of a vessel at rest is arbitrary, as a real one's is.
//! Outages come at random (exponential intervals and lengths). The sizes are assumptions to be replaced by
//! recordings; they add up to 1 m and about 1°.
//!
//! Epochs fall on whole multiples of the period in UTC. Sentences leave after a latency and need their time
//! on the serial line; an epoch that finds the line still busy is left out. Commands set which
//! sentences are sent, and how often (`compass_settings`).

use crate::compass_settings::{AtFirst, CompassSettings};
use crate::faults::Faults;
use crate::otter::OtterState;
use crate::process::GaussMarkov;
use crate::range::{OutOfRange, within};
use crate::rng::{Rng, Stream};
use devices::nmea::EarthModel;
use devices::{GnssFix, GnssReading, GroundVelocity, Quality};
use units::{LocalFrame, LocalPoint, UtcTime, wrap_pi, wrap_two_pi};

/// Bits on the line for one byte: start, eight data, stop.
const BITS_PER_BYTE: u64 = 10;

/// A GNSS compass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GnssConfig {
    /// Epochs a second; a whole number of microseconds must lie between two: 1, 2, 4, 5, 8, 10, 16, 20...
    pub rate_hz: u32,
    /// Speed of the serial line at first (bit/s); 0 sends without delay.
    pub baud: u32,
    /// The output before any command.
    pub at_first: AtFirst,
    /// Time from the epoch to the first byte (s).
    pub latency_s: f64,
    /// White noise of the position, on each axis (m).
    pub position_white_m: f64,
    /// Slow error of the position, on each axis (m).
    pub position_slow_m: f64,
    /// Time constant of the slow position error (s).
    pub position_slow_s: f64,
    /// White noise of the velocity, on each axis (m/s).
    pub velocity_white_mps: f64,
    /// White noise of the heading (rad).
    pub heading_white_rad: f64,
    /// Slow error of the heading (rad).
    pub heading_slow_rad: f64,
    /// Time constant of the slow heading error (s).
    pub heading_slow_s: f64,
    /// White noise of the rate of turn (rad/s).
    pub rate_white_radps: f64,
    /// Outages an hour, on average.
    pub outages_per_hour: f64,
    /// Mean length of an outage (s).
    pub outage_s: f64,
    /// Magnetic declination, east positive (rad).
    pub declination_rad: f64,
    /// Height of the geoid above the ellipsoid (m).
    pub separation_m: f64,
}

impl Default for GnssConfig {
    /// One epoch a second at 19200 bit/s, 1 m and about 0.9° in all, no outages, Trondheim's declination and
    /// geoid.
    fn default() -> Self {
        Self {
            rate_hz: 1,
            baud: 19_200,
            at_first: AtFirst::Usual,
            latency_s: 0.05,
            position_white_m: 0.2,
            position_slow_m: 0.67,
            position_slow_s: 300.0,
            velocity_white_mps: 0.03,
            heading_white_rad: 0.4_f64.to_radians(),
            heading_slow_rad: 0.8_f64.to_radians(),
            heading_slow_s: 120.0,
            rate_white_radps: 0.2_f64.to_radians(),
            outages_per_hour: 0.0,
            outage_s: 8.0,
            declination_rad: 4.5_f64.to_radians(),
            separation_m: 39.5,
        }
    }
}

impl GnssConfig {
    /// A compass without any error, for tests of what comes after it.
    #[must_use]
    pub fn perfect(self) -> Self {
        Self {
            position_white_m: 0.0,
            position_slow_m: 0.0,
            velocity_white_mps: 0.0,
            heading_white_rad: 0.0,
            heading_slow_rad: 0.0,
            rate_white_radps: 0.0,
            outages_per_hour: 0.0,
            ..self
        }
    }

    fn check(&self) -> Result<(), OutOfRange> {
        let rate = f64::from(self.rate_hz);
        within("GNSS rate (Hz)", rate, 1.0, 50.0)?;
        if !1_000_000_u32.is_multiple_of(self.rate_hz) {
            let what = "GNSS rate (Hz) with whole microseconds between epochs";
            return Err(OutOfRange { what, value: rate, low: 1.0, high: 50.0 });
        }
        within("GNSS latency (s)", self.latency_s, 0.0, 10.0)?;
        within("GNSS position noise (m)", self.position_white_m, 0.0, 1e3)?;
        within("GNSS slow position error (m)", self.position_slow_m, 0.0, 1e3)?;
        within("GNSS slow position time (s)", self.position_slow_s, 0.1, 1e6)?;
        within("GNSS velocity noise (m/s)", self.velocity_white_mps, 0.0, 10.0)?;
        within("GNSS heading noise (rad)", self.heading_white_rad, 0.0, 3.2)?;
        within("GNSS slow heading error (rad)", self.heading_slow_rad, 0.0, 3.2)?;
        within("GNSS slow heading time (s)", self.heading_slow_s, 0.1, 1e6)?;
        within("GNSS rate-of-turn noise (rad/s)", self.rate_white_radps, 0.0, 3.2)?;
        within("GNSS outages an hour", self.outages_per_hour, 0.0, 3600.0)?;
        within("GNSS outage length (s)", self.outage_s, 0.1, 1e5)?;
        within("magnetic declination (rad)", self.declination_rad, -3.2, 3.2)?;
        within("geoid separation (m)", self.separation_m, -120.0, 120.0)?;
        Ok(())
    }
}

/// One epoch: the reading and, where bytes are wanted, each sentence with the time its last byte arrives.
#[derive(Debug)]
pub(crate) struct Epoch {
    pub(crate) reading: GnssReading,
    /// When the reading as a whole is there.
    pub(crate) complete_utc: UtcTime,
    pub(crate) sentences: Vec<(UtcTime, Vec<u8>)>,
}

/// The compass.
#[derive(Debug, Clone)]
pub(crate) struct Gnss {
    config: GnssConfig,
    settings: CompassSettings,
    period_us: i64,
    next_us: i64,
    line_free_us: i64,
    north: GaussMarkov,
    east: GaussMarkov,
    heading: GaussMarkov,
    /// Satellites used less nine, wandering slowly.
    sky: GaussMarkov,
    outage_until_us: i64,
    next_outage_us: i64,
    rng: Rng,
}

impl Gnss {
    pub(crate) fn new(config: &GnssConfig, seed: u64, start: UtcTime) -> Result<Self, OutOfRange> {
        config.check()?;
        let period_us = i64::from(1_000_000 / config.rate_hz);
        let period_s = 1.0 / f64::from(config.rate_hz);
        let mut rng = Rng::new(seed, Stream::Gnss);
        let slow_m = config.position_slow_m;
        let mut gnss = Self {
            config: *config,
            settings: CompassSettings::new(config.at_first, period_us, config.baud),
            period_us,
            next_us: start.micros().div_euclid(period_us) * period_us,
            line_free_us: i64::MIN,
            north: GaussMarkov::new(slow_m, config.position_slow_s, period_s, &mut rng),
            east: GaussMarkov::new(slow_m, config.position_slow_s, period_s, &mut rng),
            heading: GaussMarkov::new(config.heading_slow_rad, config.heading_slow_s, period_s, &mut rng),
            sky: GaussMarkov::new(1.5, 600.0, period_s, &mut rng),
            outage_until_us: i64::MIN,
            next_outage_us: i64::MAX,
            rng,
        };
        if gnss.next_us < start.micros() {
            gnss.next_us += period_us;
        }
        gnss.plan_outage(start.micros());
        Ok(gnss)
    }

    /// The receiver's settings, for its commands.
    pub(crate) fn settings(&self) -> &CompassSettings {
        &self.settings
    }

    /// The same, to change.
    pub(crate) fn settings_mut(&mut self) -> &mut CompassSettings {
        &mut self.settings
    }

    /// The time of the next epoch.
    pub(crate) fn next_epoch(&self) -> UtcTime {
        UtcTime::from_micros(self.next_us)
    }

    /// Takes the next epoch, at which the vessel is in the given state. `None` when nothing comes out.
    pub(crate) fn epoch(
        &mut self,
        state: &OtterState,
        frame: &LocalFrame,
        faults: &Faults,
        bytes: bool,
    ) -> Option<Epoch> {
        let now_us = self.next_us;
        self.next_us += self.period_us;
        let reading = self.read(now_us, state, frame, faults);
        if faults.gnss_silent {
            return None;
        }
        let send_us = now_us + (self.config.latency_s * 1e6) as i64;
        if !bytes {
            let complete_utc = UtcTime::from_micros(send_us);
            return Some(Epoch { reading, complete_utc, sentences: Vec::new() });
        }
        if self.line_free_us > send_us {
            return None;
        }
        self.line_free_us = send_us;
        let GnssConfig { declination_rad, separation_m, .. } = self.config;
        let earth = EarthModel { declination_rad, separation_m };
        let Self { settings, line_free_us, .. } = self;
        let (baud, talker) = (u64::from(settings.baud()), settings.talker());
        let sentences: Vec<_> = settings
            .due(now_us)
            .map(|sentence| {
                let bytes = sentence.encode_from(talker, &reading, &earth);
                let bits_e6 = bytes.len() as u64 * BITS_PER_BYTE * 1_000_000;
                *line_free_us += bits_e6.checked_div(baud).unwrap_or(0) as i64;
                (UtcTime::from_micros(*line_free_us), bytes)
            })
            .collect();
        Some(Epoch { reading, complete_utc: UtcTime::from_micros(self.line_free_us), sentences })
    }

    fn read(&mut self, now_us: i64, state: &OtterState, frame: &LocalFrame, faults: &Faults) -> GnssReading {
        let c = self.config;
        let rng = &mut self.rng;
        // All noise is drawn whether it is used or not: a fault does not change what follows it.
        let jump = faults.position_jump.unwrap_or_default();
        let point = LocalPoint {
            north_m: state.position.north_m
                + self.north.step(rng)
                + c.position_white_m * rng.normal()
                + jump.north_m,
            east_m: state.position.east_m
                + self.east.step(rng)
                + c.position_white_m * rng.normal()
                + jump.east_m,
        };
        let (north_mps, east_mps) = state.ground_velocity_mps();
        let north_mps = north_mps + c.velocity_white_mps * rng.normal();
        let east_mps = east_mps + c.velocity_white_mps * rng.normal();
        let heading_rad =
            wrap_pi(state.psi_rad + self.heading.step(rng) + c.heading_white_rad * rng.normal());
        let rate_radps = state.r_radps + c.rate_white_radps * rng.normal();
        let sky = self.sky.step(rng);
        let height_m = 1.0 + 1.5 * c.position_white_m * rng.normal();

        let visible = !(self.in_outage(now_us) || faults.gnss_no_fix);
        // The process stays within 9 ± 6 satellites.
        let satellites = (9.0 + sky).round().clamp(4.0, 15.0) as u8;
        let place = frame.to_place(point);
        let fix = GnssFix {
            lat_rad: place.lat_rad(),
            lon_rad: place.lon_rad(),
            height_m: height_m + c.separation_m,
            quality: if satellites >= 7 { Quality::Differential } else { Quality::Autonomous },
            hdop: 7.2 / f64::from(satellites),
        };
        let velocity = GroundVelocity {
            course_rad: wrap_two_pi(east_mps.atan2(north_mps)),
            speed_mps: north_mps.hypot(east_mps),
        };
        let heading_rad = if faults.heading_nan { f64::NAN } else { heading_rad };
        GnssReading {
            utc: Some(UtcTime::from_micros(now_us)),
            fix: visible.then_some(fix),
            satellites: if visible { satellites } else { satellites / 4 },
            velocity: visible.then_some(velocity),
            heading_rad: visible.then_some(heading_rad),
            yaw_rate_rad_s: visible.then_some(rate_radps),
            ..GnssReading::default()
        }
    }

    fn in_outage(&mut self, now_us: i64) -> bool {
        if now_us >= self.next_outage_us {
            let length_s = self.rng.exponential(self.config.outage_s);
            self.outage_until_us = now_us + (length_s * 1e6) as i64;
            self.plan_outage(self.outage_until_us);
        }
        now_us < self.outage_until_us
    }

    fn plan_outage(&mut self, from_us: i64) {
        if self.config.outages_per_hour > 0.0 {
            let wait_s = self.rng.exponential(3600.0 / self.config.outages_per_hour);
            self.next_outage_us = from_us + (wait_s * 1e6) as i64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::LatLon;

    const START: UtcTime = UtcTime::from_micros(1_718_000_000_300_000);

    fn frame() -> LocalFrame {
        LocalFrame::new(LatLon::from_deg(63.44, 10.35).unwrap())
    }

    fn point(fix: GnssFix) -> LocalPoint {
        frame().to_local(LatLon::from_rad(fix.lat_rad, fix.lon_rad).unwrap())
    }

    fn readings(config: &GnssConfig, state: &OtterState, faults: &Faults, count: usize) -> Vec<GnssReading> {
        let mut gnss = Gnss::new(config, 1, START).unwrap();
        (0..count)
            .filter_map(|_| gnss.epoch(state, &frame(), faults, false))
            .map(|epoch| epoch.reading)
            .collect()
    }

    #[test]
    fn course_differs_from_heading_by_the_crab_angle() {
        // North by heading, set to the east by half of the speed: the course is atan(0.5) = 26.57°.
        let state = OtterState { u_mps: 1.0, v_mps: 0.5, ..OtterState::default() };
        let reading = readings(&GnssConfig::default().perfect(), &state, &Faults::default(), 1)[0];
        let velocity = reading.velocity.unwrap();
        assert!((velocity.course_rad.to_degrees() - 26.565).abs() < 1e-3);
        assert!((velocity.speed_mps - 1.25_f64.sqrt()).abs() < 1e-12);
        assert!(reading.heading_rad.unwrap().abs() < 1e-12);
    }

    #[test]
    fn epochs_fall_on_whole_periods_of_utc() {
        let config = GnssConfig { rate_hz: 5, ..GnssConfig::default() };
        let readings = readings(&config, &OtterState::default(), &Faults::default(), 10);
        assert_eq!(readings[0].utc.unwrap().micros(), 1_718_000_000_400_000);
        assert!(readings.windows(2).all(|w| w[1].utc.unwrap() - w[0].utc.unwrap() == 200_000));
    }

    #[test]
    fn position_error_has_its_size() {
        let readings = readings(&GnssConfig::default(), &OtterState::default(), &Faults::default(), 200_000);
        let squares: f64 =
            readings.iter().map(|r| point(r.fix.unwrap()).distance_m(LocalPoint::default()).powi(2)).sum();
        // Both axes: sqrt(2 (0.2² + 0.67²)) = 0.99 m; some 700 time constants give it to about 4 %.
        let rms_m = (squares / 2e5).sqrt();
        assert!((rms_m - 0.99).abs() < 0.1, "{rms_m}");
    }

    #[test]
    fn faults_show_as_they_are_named() {
        let config = GnssConfig::default().perfect();
        let read = |faults: Faults| readings(&config, &OtterState::default(), &faults, 1);
        assert!(read(Faults { gnss_silent: true, ..Faults::default() }).is_empty());
        let blind = read(Faults { gnss_no_fix: true, ..Faults::default() })[0];
        assert!(blind.fix.is_none() && blind.velocity.is_none() && blind.heading_rad.is_none());
        assert!(read(Faults { heading_nan: true, ..Faults::default() })[0].heading_rad.unwrap().is_nan());
        let jump = LocalPoint { north_m: 30.0, east_m: -40.0 };
        let jumped = read(Faults { position_jump: Some(jump), ..Faults::default() })[0].fix.unwrap();
        assert!(point(jumped).distance_m(jump) < 1e-6);
    }

    #[test]
    fn a_fault_does_not_change_the_noise_after_it() {
        let config = GnssConfig::default();
        let mut clean = Gnss::new(&config, 1, START).unwrap();
        let mut broken = clean.clone();
        let state = OtterState::default();
        let silent = Faults { gnss_silent: true, ..Faults::default() };
        for _ in 0..10 {
            clean.epoch(&state, &frame(), &Faults::default(), true);
            broken.epoch(&state, &frame(), &silent, true);
        }
        let last = |gnss: &mut Gnss| gnss.epoch(&state, &frame(), &Faults::default(), true).unwrap().reading;
        assert_eq!(last(&mut clean), last(&mut broken));
    }

    #[test]
    fn outages_come_as_often_and_last_as_long_as_set() {
        let config = GnssConfig { outages_per_hour: 20.0, outage_s: 10.0, ..GnssConfig::default() };
        let readings = readings(&config, &OtterState::default(), &Faults::default(), 360_000);
        let blind = readings.iter().filter(|r| r.fix.is_none()).count();
        // One outage of 10 s (10.5 epochs with the part of one) after 180 s: 5.5 %, 2000 outages.
        let share = blind as f64 / readings.len() as f64;
        assert!((0.045..0.065).contains(&share), "{share}");
    }

    #[test]
    fn sentences_take_their_time_on_the_line() {
        let mut gnss = Gnss::new(&GnssConfig::default(), 1, START).unwrap();
        let epoch = gnss.epoch(&OtterState::default(), &frame(), &Faults::default(), true).unwrap();
        let bytes: usize = epoch.sentences.iter().map(|(_, bytes)| bytes.len()).sum();
        let line_us = bytes as i64 * 10_000_000 / 19_200;
        assert!((epoch.complete_utc - epoch.reading.utc.unwrap() - 50_000 - line_us).abs() < 10);
        // 20 epochs a second do not fit through 19200 bit/s: most are left out, none is late.
        let config = GnssConfig { rate_hz: 20, ..GnssConfig::default() };
        let mut gnss = Gnss::new(&config, 1, START).unwrap();
        let epochs: Vec<Epoch> = (0..200)
            .filter_map(|_| gnss.epoch(&OtterState::default(), &frame(), &Faults::default(), true))
            .collect();
        assert!((40..=70).contains(&epochs.len()), "{}", epochs.len());
        assert!(epochs.iter().all(|e| e.complete_utc - e.reading.utc.unwrap() < 250_000));
    }

    #[test]
    fn refuses_rates_that_no_clock_keeps() {
        for rate_hz in [0, 3, 51, 1_000_000] {
            assert!(Gnss::new(&GnssConfig { rate_hz, ..GnssConfig::default() }, 1, START).is_err());
        }
    }
}
