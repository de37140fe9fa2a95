//! The driver of the motor card before the simulated card, frame by frame as on a vessel's bus.

use devices::{Pair, Reading};
use drivers::motors::{ChannelConfig, ChannelTable, Motors, MotorsConfig, MotorsOutput};
use drivers::{Note, State};
use sim::{Output, OutputForm, Vessel, VesselConfig};
use std::time::Duration;
use units::{LatLon, Now, UtcTime};

const STEP: Duration = Duration::from_millis(20);

struct Bus {
    vessel: Vessel,
    motors: Motors,
    states: Vec<State>,
    notes: Vec<Note>,
    readings: Vec<Reading>,
}

impl Bus {
    fn new() -> Self {
        let place = LatLon::from_deg(63.33, 10.0833).unwrap();
        let start = UtcTime::from_seconds(1_795_248_000.0).unwrap();
        let config = VesselConfig { form: OutputForm::Bytes, ..VesselConfig::at(place, start, 7) };
        let channel = |label: &str| {
            let (rail, channel) = ChannelTable::FiveRails.place(label).unwrap();
            ChannelConfig { name: label.to_owned(), rail, channel, on: true }
        };
        // Channel 5 of rail 3 is the 5 V output of the other document, which this card does not have.
        let missing = ChannelConfig { name: "H_5V old".to_owned(), rail: 3, channel: 5, on: true };
        let channels = vec![channel("H_MOT0"), channel("H_MOT1"), channel("H_5V"), missing];
        let motors = Motors::new(MotorsConfig { channels, ..MotorsConfig::default() }).unwrap();
        let vessel = Vessel::new(&config).unwrap();
        let mut bus = Self { vessel, motors, states: Vec::new(), notes: Vec::new(), readings: Vec::new() };
        bus.motors.opened(bus.now());
        bus
    }

    fn now(&self) -> Now {
        Now { mono: self.vessel.now(), utc: self.vessel.utc() }
    }

    fn run(&mut self, time: Duration, command: Option<(f64, f64)>) {
        for _ in 0..time.as_millis() / STEP.as_millis() {
            self.vessel.step(STEP);
            while let Some(timed) = self.vessel.poll_output() {
                if let Output::Can(frame) = timed.output {
                    self.motors.handle(Now { mono: timed.at, utc: timed.utc }, &frame);
                }
            }
            let now = self.now();
            if let Some((port, starboard)) = command {
                self.motors.command(now, Pair::new(port, starboard));
            }
            self.motors.tick(now);
            while let Some(output) = self.motors.poll_output() {
                match output {
                    MotorsOutput::Throttle { frame, .. } | MotorsOutput::Frame(frame) => {
                        self.vessel.receive_can(&frame).unwrap();
                    }
                    MotorsOutput::State(state) => self.states.push(state),
                    MotorsOutput::Note(note) => self.notes.push(note),
                    MotorsOutput::Reading { reading, .. } => self.readings.push(reading),
                }
            }
        }
    }

    fn rpm(&self) -> Pair<f64> {
        let mut rpm = Pair::new(f64::NAN, f64::NAN);
        for reading in &self.readings {
            if let Reading::Motor(side, motor) = reading {
                *rpm.of_mut(*side) = motor.propeller_rpm;
            }
        }
        rpm
    }
}

#[test]
fn the_vessel_sails_by_frames_alone_and_stops_when_nobody_commands() {
    let mut bus = Bus::new();
    bus.run(Duration::from_secs(10), Some((0.6, 0.6)));
    assert_eq!(bus.states.last(), Some(&State::Working));
    let speed = bus.vessel.truth().speed_mps;
    assert!(speed > 0.9, "{speed} m/s");
    let rpm = bus.rpm();
    assert!((400.0..700.0).contains(&rpm.port) && (rpm.port - rpm.starboard).abs() < 5.0, "{rpm:?}");
    // The life of a command, the shaft's lag, and the rhythm of the reports.
    bus.run(Duration::from_millis(500) + Duration::from_millis(1300), None);
    let rpm = bus.rpm();
    assert!(rpm.port.abs() < 10.0 && rpm.starboard.abs() < 10.0, "{rpm:?}");
}

#[test]
fn batteries_rails_and_channels_report_and_a_channel_that_is_missing_is_refused() {
    let mut bus = Bus::new();
    bus.run(Duration::from_secs(8), None);
    let count = |wanted: fn(&Reading) -> bool| bus.readings.iter().filter(|r| wanted(r)).count();
    assert_eq!(count(|r| matches!(r, Reading::Battery(b) if b.number == 3 && b.voltage_v > 20.0)), 8);
    assert_eq!(
        count(|r| matches!(r, Reading::Rail(r) if r.number == 4 && (r.voltage_v - 5.0).abs() < 0.1)),
        8
    );
    assert_eq!(count(|r| matches!(r, Reading::PowerChannel(c) if c.on)), 3);
    assert_eq!(bus.notes.len(), 1, "{:?}", bus.notes);
    assert!(bus.notes[0].text.contains("`H_5V old` (rail 3, channel 5) stays off: refused"));
}

#[test]
fn a_motor_that_is_switched_off_stands_still() {
    let mut bus = Bus::new();
    bus.run(Duration::from_secs(2), Some((0.5, 0.5)));
    let now = bus.now();
    bus.motors.switch(now, "H_MOT0", false).unwrap();
    bus.run(Duration::from_secs(3), Some((0.5, 0.5)));
    let rpm = bus.rpm();
    assert!(rpm.port.abs() < 10.0 && rpm.starboard > 300.0, "{rpm:?}");
}

#[test]
fn a_silent_card_and_a_silent_motor_are_failing_and_come_back() {
    let mut bus = Bus::new();
    bus.run(Duration::from_secs(3), None);
    bus.vessel.faults_mut().motor_feedback_lost.starboard = true;
    bus.run(Duration::from_secs(3), None);
    assert!(matches!(bus.states.last(), Some(State::Failing(why)) if why.contains("starboard motor")));
    bus.vessel.faults_mut().motor_feedback_lost.starboard = false;
    bus.vessel.faults_mut().card_silent = true;
    bus.run(Duration::from_secs(3), None);
    assert!(matches!(bus.states.last(), Some(State::Failing(why)) if why.contains("motor card")));
    bus.vessel.faults_mut().card_silent = false;
    bus.run(Duration::from_secs(1), None);
    assert_eq!(bus.states.last(), Some(&State::Working));
}
