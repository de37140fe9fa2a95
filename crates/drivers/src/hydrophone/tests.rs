//! A receiver through its life: by the simulator's clock and command mode, and by lines written by hand.

use super::*;
use devices::{TagReading, WaterReading};
use sim::{ClockConfig, ReceiverClock};
use std::collections::VecDeque;
use units::UtcTime;

mod clock;

/// Not on a mark of ten seconds.
const START_US: i64 = 1_795_000_003_400_000;

fn at_us(us: u64) -> Now {
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(START_US + us as i64) }
}

/// The driver at the simulated receiver, joined by a line that carries a character a millisecond.
struct Bench {
    driver: Receiver,
    device: ReceiverClock,
    us: u64,
    /// Bytes under way to the receiver and when they arrive.
    wire: VecDeque<(u64, u8)>,
    /// What was sent: when its first byte left, and the text.
    sent: Vec<(i64, String)>,
    states: Vec<State>,
    notes: Vec<Note>,
    readings: Vec<Reading>,
    /// How it listens, as reported.
    told: Vec<ReceiverReading>,
    /// How far the computer's clock was set (µs).
    set_us: i64,
    /// How late bytes leave (µs).
    late_us: u64,
    /// Time between two bytes on the line, which the driver wants to be a millisecond (µs).
    pace_us: usize,
    /// Whether the receiver's answers reach the driver.
    answers: bool,
}

use crate::Note;

impl Bench {
    fn new(settings: ReceiverSettings, clock: &ClockConfig) -> Self {
        let device = ReceiverClock::new(clock, UtcTime::from_micros(START_US)).unwrap();
        let mut bench = Self {
            driver: Receiver::new(settings),
            device,
            us: 0,
            wire: VecDeque::new(),
            sent: Vec::new(),
            states: Vec::new(),
            notes: Vec::new(),
            readings: Vec::new(),
            told: Vec::new(),
            set_us: 0,
            late_us: 0,
            pace_us: 1000,
            answers: true,
        };
        bench.give(Input::Opened);
        bench
    }

    fn give(&mut self, input: Input<'_>) {
        self.driver.handle(self.now(), input);
        while let Some(output) = self.driver.poll_output() {
            match output {
                Output::Send { bytes, at, pace } => {
                    assert_eq!(pace, Duration::from_millis(1));
                    let first_us = at.micros().max(self.us);
                    let text = String::from_utf8(bytes.clone()).unwrap();
                    self.sent.push((START_US + self.set_us + first_us as i64, text));
                    self.wire.extend((first_us + self.late_us..).step_by(self.pace_us).zip(bytes));
                }
                Output::Newest { .. } | Output::Speed { .. } => panic!("{output:?} is not for a hydrophone"),
                Output::State(state) => self.states.push(state),
                Output::Note(note) => self.notes.push(note),
                Output::Reading { reading: Reading::Receiver(told), .. } => self.told.push(told),
                Output::Reading { reading, .. } => self.readings.push(reading),
            }
        }
    }

    /// The moment by the computer's clocks.
    fn now(&self) -> Now {
        let Now { mono, utc } = at_us(self.us);
        Now { mono, utc: UtcTime::from_micros(utc.micros() + self.set_us) }
    }

    /// Lets so many seconds pass, a millisecond at a time.
    fn run(&mut self, seconds: u64) {
        for _ in 0..seconds * 1000 {
            self.us += 1000;
            let now = at_us(self.us);
            while self.wire.front().is_some_and(|(due, _)| *due <= self.us) {
                let (due, byte) = self.wire.pop_front().unwrap();
                self.device.receive(at_us(due).utc, &[byte]);
            }
            if let Some(answer) = self.device.answer(now.utc).filter(|_| self.answers) {
                self.give(Input::Bytes(&answer));
            }
            if self.driver.poll_timeout().is_some_and(|due| due <= self.now().mono) {
                self.give(Input::Time);
            }
        }
    }

    fn error_us(&self) -> i64 {
        self.device.reading_us(at_us(self.us).utc) - self.now().utc.micros()
    }

    /// A tag is heard: its line comes when its train of pulses is over, stamped with the train's beginning.
    fn hear(&mut self, tag_id: u32, train_us: i64) {
        let began = UtcTime::from_micros(at_us(self.us).utc.micros() - train_us);
        let stamp_us = self.device.reading_us(began);
        let counter = self.readings.len() as u16 + 1;
        let millis = (stamp_us.rem_euclid(1_000_000) / 1000) as u16;
        self.line(&TagReading { tag_id, millis, ..tag(stamp_us.div_euclid(1_000_000), counter) });
    }

    fn is_believed(&self) -> bool {
        matches!(self.driver.clock(), ClockState::Set | ClockState::Disciplined)
    }

    /// From now on the receiver's clock is off by so much (s).
    fn put_off(&mut self, offset_s: f64) {
        let clock = ClockConfig { offset_s, ..ClockConfig::default() };
        self.device = ReceiverClock::new(&clock, at_us(self.us).utc).unwrap();
    }

    fn warnings(&self) -> Vec<&str> {
        self.notes.iter().filter(|note| note.warning).map(|note| note.text.as_str()).collect()
    }

    fn line(&mut self, reading: &TagReading) {
        self.give(Input::Bytes(&reading.encode()));
    }
}

fn tag(clock_s: i64, counter: u16) -> TagReading {
    TagReading {
        serial: 25,
        clock_s: u32::try_from(clock_s).unwrap(),
        millis: 0,
        protocol: "S256".to_owned(),
        tag_id: 40,
        data: Some(7),
        snr_db: 20,
        frequency_khz: 69,
        counter,
        raw: None,
        lines_lost: None,
    }
}

fn unset() -> ClockConfig {
    ClockConfig { set: false, ..ClockConfig::default() }
}

fn quiet() -> ReceiverSettings {
    ReceiverSettings { sync: Sync::Off, ..ReceiverSettings::default() }
}

fn settings(texts: &[&str]) -> Vec<Setting> {
    texts.iter().map(|text| Setting::parse(text).unwrap()).collect()
}

#[test]
fn settings_go_one_after_another_and_their_answers_are_compared() {
    let wanted = settings(&["LI=01", "FC=69", "LM=08", "FV?v1.0.6"]);
    let mut bench = Bench::new(ReceiverSettings { settings: wanted, ..quiet() }, &ClockConfig::default());
    bench.run(3);
    let sent: Vec<&str> = bench.sent.iter().map(|(_, text)| text.as_str()).collect();
    assert_eq!(sent, ["LIVECM", "LI=01", "FC=69", "LM=08", "FV?", "EX!"]);
    assert_eq!(bench.states, [State::Starting, State::Working]);
    assert!(bench.notes.iter().any(|note| note.text.ends_with("FV=v1.0.6")));
}

#[test]
fn no_clock_command_goes_into_command_mode() {
    let wanted = settings(&["FC=69"]);
    let mut bench =
        Bench::new(ReceiverSettings { settings: wanted, ..ReceiverSettings::default() }, &unset());
    bench.answers = false;
    bench.run(25);
    assert!(bench.sent.iter().all(|(_, text)| !text.starts_with("(+)")), "{:?}", bench.sent);
    bench.answers = true;
    bench.run(30);
    assert!(bench.sent.iter().any(|(_, text)| text.starts_with("(+)")));
}

#[test]
fn a_wrong_answer_fails_the_start_and_is_tried_three_times() {
    let wanted = settings(&["FV?v2.0.0"]);
    let mut bench = Bench::new(ReceiverSettings { settings: wanted, ..quiet() }, &ClockConfig::default());
    bench.run(2);
    let [State::Starting, State::Failing(why)] = &bench.states[..] else { panic!("{:?}", bench.states) };
    assert!(why.contains("'FV=v1.0.6' to FV? where FV=v2.0.0 was due"), "{why}");
    assert_eq!(bench.sent.last().map(|(_, text)| text.as_str()), Some("EX!"));
    bench.line(&tag(START_US / 1_000_000, 1));
    assert_eq!((bench.readings.len(), bench.states.len()), (1, 2));
    bench.run(6);
    assert_eq!(bench.sent.iter().filter(|(_, text)| text == "LIVECM").count(), 2);
    assert!(bench.told.iter().all(|told| !told.listening), "in command mode it does not listen");
}

#[test]
fn a_receiver_that_refuses_a_setting_is_listened_to_in_the_end_and_its_clock_is_kept() {
    let wanted = settings(&["FC=71", "FV?v2.0.0"]);
    let mut bench =
        Bench::new(ReceiverSettings { settings: wanted, ..ReceiverSettings::default() }, &unset());
    bench.run(60);
    assert_eq!(bench.sent.iter().filter(|(_, text)| text == "LIVECM").count(), 3);
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
    bench.hear(40, 3_000_000);
    assert!(matches!(bench.states.last(), Some(State::Failing(why)) if why.contains("FV=v2.0.0 was due")));
    assert_eq!(bench.states.len(), 2, "{:?}", bench.states);
    let told = bench.told.last().unwrap();
    assert!(told.listening && told.clock == ClockState::Disciplined, "{told:?}");
    // The frequency that it uses is known from its lines only.
    assert_eq!(told.frequency_khz, Some(69));
    // The port opened again is another beginning.
    bench.give(Input::Lost);
    assert!(!bench.told.last().unwrap().listening);
    bench.give(Input::Opened);
    bench.run(1);
    assert_eq!(bench.sent.iter().filter(|(_, text)| text == "LIVECM").count(), 4);
}

#[test]
fn a_receiver_that_had_no_power_is_asked_once_more_when_it_is_heard() {
    let wanted = settings(&["FC=69", "LM=08"]);
    let mut bench = Bench::new(ReceiverSettings { settings: wanted, ..quiet() }, &ClockConfig::default());
    bench.answers = false;
    bench.run(120);
    let tries = |bench: &Bench| bench.sent.iter().filter(|(_, text)| text == "LIVECM").count();
    assert_eq!(tries(&bench), 3);
    bench.answers = true;
    bench.hear(40, 3_000_000);
    bench.run(10);
    assert_eq!((tries(&bench), bench.states.last()), (4, Some(&State::Working)));
    let told = bench.told.last().unwrap();
    assert_eq!((told.listening, told.frequency_khz, told.protocols), (true, Some(69), Some(8)));
    // One that hears and never answers is asked no more.
    bench.answers = false;
    bench.give(Input::Opened);
    bench.run(60);
    for _ in 0..3 {
        bench.hear(40, 3_000_000);
        bench.run(30);
    }
    assert_eq!(tries(&bench), 8);
    assert!(matches!(bench.states.last(), Some(State::Failing(why)) if why.contains("did not answer")));
}

#[test]
fn a_missing_answer_fails_the_start_and_command_mode_may_be_on_already() {
    let wanted = settings(&["FC=69"]);
    let mut bench = Bench::new(ReceiverSettings { settings: wanted, ..quiet() }, &ClockConfig::default());
    bench.answers = false;
    bench.run(5);
    // LIVECM has no answer where command mode is on: the setting goes all the same.
    assert_eq!(bench.sent.iter().map(|(_, text)| text.as_str()).collect::<Vec<_>>(), ["LIVECM", "FC=69"]);
    assert_eq!(bench.states, [State::Starting]);
    bench.run(4);
    assert!(
        matches!(&bench.states[..], [_, State::Failing(why)] if why.contains("did not answer FC=69 within 4 s"))
    );
    bench.answers = true;
    bench.run(10);
    assert_eq!(bench.states.last(), Some(&State::Working));
}

#[test]
fn lines_are_readings_and_gaps_in_their_numbers_are_told() {
    let mut bench = Bench::new(quiet(), &ClockConfig::default());
    let unix_s = START_US / 1_000_000;
    for (second, counter) in [(0, 65_534), (1, 65_535), (2, 0), (3, 3), (4, 3)] {
        bench.line(&tag(unix_s + second, counter));
        bench.run(1);
    }
    let water = WaterReading {
        serial: 25,
        clock_s: u32::try_from(unix_s + 5).unwrap(),
        temperature_c: 7.5,
        noise_average: 4,
        noise_peak: 9,
        frequency_khz: 69,
        counter: 4,
        lines_lost: None,
    };
    bench.give(Input::Bytes(&water.encode()));
    assert_eq!(bench.readings.last(), Some(&Reading::Water(WaterReading { lines_lost: Some(0), ..water })));
    let lost = |reading: &Reading| match reading {
        Reading::Tag(tag) => tag.lines_lost,
        _ => None,
    };
    // What came before the first is unknown; two were lost before the fourth, which came again.
    let lost: Vec<Option<u16>> = bench.readings.iter().take(5).map(lost).collect();
    assert_eq!(lost, [None, Some(0), Some(0), Some(2), Some(0)]);
    assert!(matches!(&bench.readings[0], Reading::Tag(tag) if tag.raw.is_some() && tag.counter == 65_534));
    assert_eq!(bench.warnings(), ["2 lines of the hydrophone lost, by their running numbers"]);
    let Counts { detections, sensor_lines, lost, damaged } = bench.driver.counts();
    assert_eq!((detections, sensor_lines, lost, damaged), (5, 1, 2, 0));
    assert_eq!(bench.driver.clock(), ClockState::Set);
    assert!((bench.driver.clock_offset_s().unwrap() - 0.4).abs() < 0.1);
    // The receiver was off: it counts from the beginning, and so does its clock.
    bench.line(&tag(12, 40_000));
    assert!(bench.warnings()[1].contains("restarted"));
    assert_eq!(bench.driver.clock(), ClockState::Lost);
}

#[test]
fn silence_beyond_the_sensor_interval_fails_and_a_line_recovers() {
    let settings = ReceiverSettings {
        sensor_interval: Some(Duration::from_mins(5)),
        sync: Sync::Marks { full_every: 6 },
        ..ReceiverSettings::default()
    };
    let mut bench = Bench::new(settings, &ClockConfig::default());
    bench.run(440);
    assert_eq!(bench.states, [State::Starting, State::Working]);
    bench.run(60);
    // Acknowledgements continue, sensor lines do not.
    assert!(matches!(&bench.states[2..], [State::Failing(why)] if why.contains("sensor interval")));
    bench.line(&tag(START_US / 1_000_000 + 498, 9));
    assert_eq!(bench.states.last(), Some(&State::Working));
}

#[test]
fn babble_and_endless_lines_fail_and_what_follows_is_read() {
    let mut bench = Bench::new(quiet(), &ClockConfig::default());
    for _ in 0..200 {
        bench.give(Input::Bytes(&[b'9'; 1000]));
        assert!(bench.driver.framer.kept() <= devices::tbr::LONGEST);
    }
    assert!(matches!(&bench.states[..], [_, State::Failing(why)] if why.contains("baud rate")));
    assert_eq!(bench.notes.len(), 1);
    bench.line(&tag(START_US / 1_000_000, 1));
    assert_eq!((bench.readings.len(), bench.states.last()), (1, Some(&State::Working)));
}

#[test]
fn a_pulled_cable_stops_all_commands() {
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    bench.run(15);
    bench.give(Input::Lost);
    assert_eq!(bench.driver.poll_timeout(), None);
    assert!(matches!(bench.states.last(), Some(State::Failing(why)) if why.contains("cable")));
    bench.give(Input::Opened);
    let before = bench.sent.len();
    bench.run(10);
    // Its clock may have stopped meanwhile: the first command carries the full time.
    assert_eq!(bench.sent[before].1.len(), 13);
}
