//! The compass that obeys its commands, and the driver that gives them: a wrong command brings no data.

use devices::{GnssReading, Reading};
use drivers::gnss::{Compass, CompassSettings};
use drivers::{Driver as _, Input, Output as OfDriver, State};
use sim::{AtFirst, GnssConfig, Output, OutputForm, Port, Vessel, VesselConfig};
use std::time::Duration;
use units::{LatLon, MonoTime, Now, UtcTime};

const START: UtcTime = UtcTime::from_micros(1_790_000_000_000_000);
const STEP: Duration = Duration::from_millis(20);

/// A compass that has had no commands, and its driver, by one clock.
struct Bench {
    vessel: Vessel,
    driver: Compass,
    readings: Vec<GnssReading>,
    states: Vec<State>,
    warnings: Vec<String>,
}

impl Bench {
    fn new(init: &[&str]) -> Self {
        let place = LatLon::from_deg(63.44, 10.35).unwrap();
        let mut config = VesselConfig::at(place, START, 1);
        config.heading_rad = 1.0;
        config.form = OutputForm::Bytes;
        config.gnss = GnssConfig {
            rate_hz: 10,
            baud: 115_200,
            at_first: AtFirst::Nothing,
            ..GnssConfig::default().perfect()
        };
        let init = init.iter().map(|line| (*line).to_owned()).collect();
        let driver = Compass::new(CompassSettings { init, ..CompassSettings::default() });
        let vessel = Vessel::new(&config).unwrap();
        let mut bench =
            Self { vessel, driver, readings: Vec::new(), states: Vec::new(), warnings: Vec::new() };
        bench.driver.handle(bench.now(), Input::Opened);
        bench
    }

    fn now(&self) -> Now {
        Now { mono: self.vessel.now(), utc: self.vessel.utc() }
    }

    fn run(&mut self, seconds: u64) {
        let until = self.vessel.now() + Duration::from_secs(seconds);
        while self.vessel.now() < until {
            self.take();
            self.vessel.step(STEP);
            let now = self.now();
            while let Some(timed) = self.vessel.poll_output() {
                if let Output::Serial(Port::Gnss, bytes) = timed.output {
                    self.driver.handle(now, Input::Bytes(&bytes));
                }
            }
            if self.driver.poll_timeout().is_some_and(|due: MonoTime| due <= now.mono) {
                self.driver.handle(now, Input::Time);
            }
        }
        self.take();
    }

    fn take(&mut self) {
        while let Some(output) = self.driver.poll_output() {
            match output {
                OfDriver::Reading { reading: Reading::Gnss(reading), .. } => self.readings.push(reading),
                OfDriver::Send { bytes, .. } => self.vessel.receive_serial(Port::Gnss, &bytes),
                OfDriver::State(state) => self.states.push(state),
                OfDriver::Note(note) if note.warning => self.warnings.push(note.text),
                _ => {}
            }
        }
    }
}

/// The commands of the driver when nothing is configured.
fn usual() -> Vec<String> {
    CompassSettings::default().init
}

#[test]
fn the_drivers_own_commands_bring_all_that_the_vessel_needs_each_second() {
    let init = usual();
    let mut bench = Bench::new(&init.iter().map(String::as_str).collect::<Vec<_>>());
    bench.run(20);
    assert!((18..=20).contains(&bench.readings.len()), "{}", bench.readings.len());
    let last = bench.readings.last().unwrap();
    assert!(last.fix.is_some() && last.velocity.is_some() && last.utc.is_some(), "{last:?}");
    // Two decimals of a degree.
    assert!((last.heading_rad.unwrap() - 1.0).abs() < 1e-4 && last.yaw_rate_rad_s.is_some(), "{last:?}");
    assert!(last.magnetic_heading_rad.is_some(), "{last:?}");
    assert_eq!((bench.driver.counts().damaged, bench.warnings), (0, Vec::new()), "answers are no damage");
}

#[test]
fn the_boats_own_commands_bring_five_epochs_a_second() {
    let Some(path) = testkit::shared("data/onboard/ini/user/etc/basic.ini") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let section = text.split("[Sensors.GPSOtter]").nth(1).unwrap().split("\n[").next().unwrap();
    let command = |line: &str| {
        let (key, value) = line.split_once('=')?;
        let is_command = key.starts_with("Initialization String") && key.trim_end().ends_with("- Command");
        is_command.then(|| value.trim().trim_end_matches("\\r\\n").to_owned())
    };
    let init: Vec<String> = section.lines().filter_map(command).collect();
    assert_eq!(init.len(), 10, "{init:?}");
    let mut bench = Bench::new(&init.iter().map(String::as_str).collect::<Vec<_>>());
    bench.run(10);
    assert!((47..=50).contains(&bench.readings.len()), "{}", bench.readings.len());
    // They turn HDT off: the heading comes in HPR.
    let last = bench.readings.last().unwrap();
    assert!((last.heading_rad.unwrap() - 1.0).abs() < 1e-4 && last.fix.is_some(), "{last:?}");
    assert_eq!((bench.driver.counts().damaged, bench.warnings), (0, Vec::new()));
}

#[test]
fn a_driver_that_commands_wrongly_gets_no_data_and_says_what_to_look_at() {
    for (init, why) in [
        (&[][..], "nothing came for 4 s"),
        (&["$JASC,GPGGB,1", "$JASK,GPHDT,1"][..], "nothing came for 4 s"),
        (&["JASC,GPGGA,1"][..], "nothing came for 4 s"),
        // It answers, and sends nothing.
        (&["$JASC,GPGGA,0", "$JATT,NMEAHE,0"][..], "check the initialisation strings"),
    ] {
        let mut bench = Bench::new(init);
        bench.run(10);
        assert_eq!(bench.readings, [], "{init:?}");
        let failing = |state: &State| matches!(state, State::Failing(text) if text.contains(why));
        assert!(bench.states.iter().any(failing), "{init:?}: {:?}", bench.states);
    }
}

#[test]
fn a_command_that_is_left_out_leaves_its_values_out() {
    let mut init = usual();
    init.retain(|line| !line.contains("GPHDT") && !line.contains("GPHDM"));
    let mut bench = Bench::new(&init.iter().map(String::as_str).collect::<Vec<_>>());
    bench.run(10);
    assert!(bench.readings.len() >= 8);
    assert!(bench.readings.iter().all(|reading| reading.fix.is_some() && reading.heading_rad.is_none()));
}

#[test]
fn a_compass_that_lost_its_power_is_told_again() {
    let init = usual();
    let mut bench = Bench::new(&init.iter().map(String::as_str).collect::<Vec<_>>());
    bench.run(10);
    bench.vessel.restart_gnss();
    // The epoch that was under way.
    bench.run(1);
    bench.readings.clear();
    bench.run(2);
    assert_eq!(bench.readings, [], "it forgot what it did not save");
    // The driver's time-out is 4 s.
    bench.run(4);
    assert!(!bench.readings.is_empty() && bench.states.last() == Some(&State::Working), "{:?}", bench.states);
}
