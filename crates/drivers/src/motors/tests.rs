//! The card's driver against a bus of which the test is the other end.

use super::*;
use devices::torqeedo::{CardCommand, CardReport};
use devices::{BatteryReading, MotorReading, Part, RailReading, Side, TroubleReading};
use proptest::prelude::*;
use std::time::Duration;
use units::UtcTime;

fn at(ms: u64) -> Now {
    Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::from_micros(ms as i64 * 1000) }
}

fn otter() -> MotorsConfig {
    let channel = |label: &str, on| {
        let (rail, channel) = ChannelTable::FiveRails.place(label).unwrap();
        ChannelConfig { name: label.to_lowercase(), rail, channel, on }
    };
    MotorsConfig {
        channels: vec![channel("H_MOT0", true), channel("H_AUX1", false)],
        ..MotorsConfig::default()
    }
}

/// A driver on an open bus, with the time in milliseconds.
struct Bench {
    motors: Motors,
    /// Throttles sent, with the time in ms.
    throttles: Vec<(u64, Pair<i16>)>,
    power: Vec<(u64, u8, u8, bool)>,
    states: Vec<State>,
    notes: Vec<Note>,
    readings: Vec<Reading>,
}

impl Bench {
    fn new(config: MotorsConfig) -> Self {
        let mut bench = Self {
            motors: Motors::new(config).unwrap(),
            throttles: Vec::new(),
            power: Vec::new(),
            states: Vec::new(),
            notes: Vec::new(),
            readings: Vec::new(),
        };
        bench.motors.opened(at(0));
        bench.poll(0);
        bench
    }

    fn poll(&mut self, ms: u64) {
        while let Some(output) = self.motors.poll_output() {
            match output {
                MotorsOutput::Throttle { frame, .. } | MotorsOutput::Frame(frame) => {
                    match CardCommand::parse(&frame).unwrap() {
                        CardCommand::MotorSet(set) => self.throttles.push((ms, set)),
                        CardCommand::OutputSet { rail, channel, on } => {
                            self.power.push((ms, rail, channel, on));
                        }
                    }
                }
                MotorsOutput::Reading { reading, .. } => self.readings.push(reading),
                MotorsOutput::State(state) => self.states.push(state),
                MotorsOutput::Note(note) => self.notes.push(note),
            }
        }
    }

    /// Lets the time pass by the driver's own deadlines.
    fn pass(&mut self, from_ms: u64, to_ms: u64) {
        let mut ms = from_ms;
        while let Some(due) = self.motors.poll_timeout() {
            // A deadline that is past may not be named again, or the loop that owns the bus would spin.
            assert!(due.micros() >= ms * 1000, "{due:?} at {ms} ms");
            let next = due.micros().div_ceil(1000);
            if next > to_ms {
                break;
            }
            ms = next;
            self.motors.tick(at(ms));
            self.poll(ms);
            assert!(self.motors.poll_timeout().unwrap() > at(ms).mono, "the deadline at {ms} ms stays");
        }
    }

    fn command(&mut self, ms: u64, port: f64, starboard: f64) {
        self.motors.command(at(ms), Pair::new(port, starboard));
        self.poll(ms);
    }

    fn frame(&mut self, ms: u64, id: u32, data: &[u8]) {
        self.motors.handle(at(ms), &CanFrame::new(id, data).unwrap());
        self.poll(ms);
    }

    fn report(&mut self, ms: u64, report: &CardReport) {
        self.motors.handle(at(ms), &report.frame());
        self.poll(ms);
    }

    fn feedback(&mut self, ms: u64) {
        for side in Side::BOTH {
            self.report(ms, &CardReport::Motor(side, MotorReading::default()));
        }
    }
}

#[test]
fn throttles_go_out_four_times_a_second_and_are_zero_when_nobody_renews_them() {
    let mut bench = Bench::new(otter());
    assert_eq!(bench.throttles, [(0, Pair::new(0, 0))], "the motors are stopped first");
    bench.command(100, 0.5, -0.25);
    bench.pass(100, 399);
    bench.command(400, 0.5, -0.25);
    bench.pass(400, 2000);
    let runs = Pair::new(500, -250);
    let zero = Pair::new(0, 0);
    let sent = [(0, zero), (250, runs), (500, runs), (750, runs), (900, zero), (1150, zero), (1400, zero)];
    assert_eq!(bench.throttles[..7], sent, "zero at the moment that the command of 400 ms ends");
    assert_eq!(bench.throttles.len(), 9, "the card goes on being commanded");
}

#[test]
fn one_that_only_listens_sends_no_frame_and_reads_all() {
    let mut motors = Motors::listening(otter()).unwrap();
    let (mut frames, mut readings, mut states) = (0, 0, Vec::new());
    let mut poll = |motors: &mut Motors| {
        while let Some(output) = motors.poll_output() {
            match output {
                MotorsOutput::Throttle { .. } | MotorsOutput::Frame(_) => frames += 1,
                MotorsOutput::Reading { .. } => readings += 1,
                MotorsOutput::State(state) => states.push(state),
                MotorsOutput::Note(note) => assert!(!note.warning, "{note:?}"),
            }
        }
    };
    motors.opened(at(0));
    for ms in (0..6000).step_by(100) {
        motors.command(at(ms), Pair::new(1.0, 1.0));
        motors.stop(at(ms));
        motors.switch(at(ms), "h_aux1", true).unwrap();
        for side in Side::BOTH {
            motors.handle(at(ms), &CardReport::Motor(side, MotorReading::default()).frame());
        }
        motors.handle(at(ms), &CardReport::Outputs { rail: 2, channels: 0 }.frame());
        motors.tick(at(ms));
        assert!(motors.poll_timeout().unwrap() > at(ms).mono);
        poll(&mut motors);
    }
    assert_eq!((frames, states), (0, vec![State::Working]));
    assert!(readings >= 120, "{readings}");
}

#[test]
fn a_stop_goes_out_at_once() {
    let mut bench = Bench::new(otter());
    bench.command(10, 1.0, 1.0);
    bench.pass(10, 260);
    bench.motors.stop(at(270));
    bench.poll(270);
    assert_eq!(bench.throttles.last(), Some(&(270, Pair::new(0, 0))));
    bench.command(280, 1.0, 1.0);
    bench.pass(280, 530);
    bench.command(540, 0.0, 0.0);
    assert_eq!(bench.throttles.last(), Some(&(540, Pair::new(0, 0))), "so does a command of zero");
}

#[test]
fn a_command_lives_from_when_it_was_given_and_its_frame_no_longer() {
    let mut bench = Bench::new(otter());
    let ahead = Pair::new(1.0, 1.0);
    bench.motors.command_of(at(900), at(100).mono, ahead);
    bench.poll(900);
    assert_eq!(bench.throttles.last(), Some(&(900, Pair::new(0, 0))), "what is past is not a command");
    bench.motors.command_of(at(1000), at(800).mono, ahead);
    bench.motors.tick(at(1200));
    let Some(MotorsOutput::Throttle { until, .. }) = bench.motors.poll_output() else { panic!() };
    assert_eq!(until, Some(at(1300).mono));
    bench.pass(1200, 1400);
    assert_eq!(bench.throttles.last(), Some(&(1300, Pair::new(0, 0))));
}

#[test]
fn what_is_not_a_number_stops_both_motors_and_is_noted() {
    let mut bench = Bench::new(otter());
    bench.command(10, 1.0, 1.0);
    bench.pass(10, 260);
    bench.command(270, 1.0, f64::NAN);
    assert_eq!(bench.throttles.last(), Some(&(270, Pair::new(0, 0))));
    assert!(bench.notes[0].warning && bench.notes[0].text.contains("not a number"));
    bench.command(280, 9.0, f64::NEG_INFINITY);
    bench.pass(280, 600);
    assert_eq!(bench.throttles.last().unwrap().1, Pair::new(1000, -1000), "beyond full speed is full speed");
}

#[test]
fn the_later_of_two_throttles_that_wait_is_sent_alone() {
    let mut motors = Motors::new(otter()).unwrap();
    motors.opened(at(0));
    motors.command(at(240), Pair::new(1.0, 1.0));
    motors.tick(at(250));
    motors.stop(at(260));
    let Some(MotorsOutput::Throttle { frame, until: None }) = motors.poll_output() else {
        panic!("no stop is sent")
    };
    assert_eq!(CardCommand::parse(&frame), Ok(CardCommand::MotorSet(Pair::new(0, 0))));
    let later = std::iter::from_fn(|| motors.poll_output());
    let throttles = later.filter(|output| matches!(output, MotorsOutput::Throttle { .. })).count();
    assert_eq!(throttles, 0, "the throttle before it is not sent any more");
}

#[test]
fn sides_and_directions_are_the_configured_ones() {
    let mut config = otter();
    config.sides.port = MotorAssignment { motor: 1, reversed: true };
    config.sides.starboard = MotorAssignment { motor: 0, reversed: false };
    let mut bench = Bench::new(config);
    bench.command(10, 0.3, 0.6);
    bench.pass(10, 250);
    assert_eq!(bench.throttles.last().unwrap().1, Pair::new(600, -300), "motor 0, motor 1");
    let ahead = MotorReading { propeller_rpm: -100.0, power_w: 50.0, temperature_c: 20.0 };
    bench.report(260, &CardReport::Motor(Side::Starboard, ahead));
    let expected = Reading::Motor(Side::Port, MotorReading { propeller_rpm: 100.0, ..ahead });
    assert_eq!(bench.readings, [expected]);
}

#[test]
fn nothing_is_sent_while_the_bus_is_away_and_no_throttle_outlives_it() {
    let mut bench = Bench::new(otter());
    bench.command(10, 1.0, 1.0);
    bench.pass(10, 250);
    let before = bench.throttles.len();
    bench.motors.lost(at(300));
    assert_eq!(bench.motors.poll_timeout(), None);
    bench.command(310, 1.0, 1.0);
    bench.motors.tick(at(900));
    bench.poll(900);
    assert_eq!(bench.throttles.len(), before);
    bench.motors.opened(at(950));
    bench.poll(950);
    assert_eq!(bench.throttles.last(), Some(&(950, Pair::new(0, 0))));
    assert_eq!(bench.power.last(), Some(&(950, 2, 1, false)), "power channels are set again");
}

#[test]
fn power_channels_are_set_at_the_start_and_on_change() {
    let mut bench = Bench::new(otter());
    assert_eq!(bench.power, [(0, 0, 0, true), (0, 2, 1, false)]);
    bench.motors.switch(at(100), "h_aux1", true).unwrap();
    bench.poll(100);
    assert_eq!(bench.power[2..], [(100, 2, 1, true)]);
    let error = bench.motors.switch(at(100), "lamp", true).unwrap_err().to_string();
    assert_eq!(error, "no power channel is called `lamp`; the configuration names h_mot0, h_aux1");
}

/// OUTPUTS of a rail.
fn outputs(bench: &mut Bench, ms: u64, rail: u8, bits: u32) {
    let bits = bits.to_le_bytes();
    bench.frame(ms, 0x0080_ABFF, &[rail, bits[0], bits[1], bits[2], bits[3]]);
}

#[test]
fn a_channel_that_does_not_follow_is_asked_three_times_and_then_noted_once() {
    let mut bench = Bench::new(otter());
    for second in 0..20 {
        outputs(&mut bench, 500 + second * 1000, 0, 0);
        outputs(&mut bench, 500 + second * 1000, 2, 0);
    }
    let asked: Vec<u64> = bench.power.iter().filter(|(_, rail, ..)| *rail == 0).map(|(ms, ..)| *ms).collect();
    assert_eq!(asked, [0, 1500, 2500]);
    assert_eq!(bench.notes.len(), 1);
    assert!(
        bench.notes[0].text.contains("`h_mot0` (rail 0, channel 0) stays off: refused"),
        "{:?}",
        bench.notes
    );
    outputs(&mut bench, 30_000, 0, 1);
    assert_eq!(bench.notes[1].text, "power channel `h_mot0` is on");
    let states = bench.readings.iter().filter_map(|reading| match reading {
        Reading::PowerChannel(state) if state.rail == 0 => Some(state.on),
        _ => None,
    });
    assert_eq!(states.collect::<Vec<_>>(), [false, false, true], "on change and every ten seconds");
    outputs(&mut bench, 32_000, 0, 0);
    assert_eq!(bench.power.last(), Some(&(32_000, 0, 0, true)), "one that falls off is asked again");
}

#[test]
fn silence_of_card_and_motors_is_told_apart() {
    let mut bench = Bench::new(otter());
    bench.feedback(100);
    assert_eq!(bench.states, [State::Starting, State::Working]);
    let rail = CardReport::Rail(RailReading::default());
    bench.report(1500, &CardReport::Motor(Side::Port, MotorReading::default()));
    bench.report(1500, &rail);
    bench.pass(1500, 2200);
    let State::Failing(why) = bench.states.last().unwrap() else { panic!("{:?}", bench.states) };
    assert!(why.contains("starboard motor (motor 1) has given no feedback for 2 s"), "{why}");
    bench.pass(2200, 3600);
    let State::Failing(why) = bench.states.last().unwrap() else { panic!("{:?}", bench.states) };
    assert!(why.contains("nothing from the motor card for 2 s"), "{why}");
    bench.feedback(4000);
    assert_eq!(bench.states[4..], [State::Starting, State::Working], "no motor is blamed for the card");
}

#[test]
fn a_card_that_never_speaks_fails_after_the_silence() {
    let mut bench = Bench::new(otter());
    bench.pass(0, 1999);
    assert_eq!(bench.states, [State::Starting]);
    bench.pass(1999, 2000);
    assert!(matches!(&bench.states[1], State::Failing(why) if why.contains("check its power")));
}

#[test]
fn readings_are_those_of_the_card_and_no_other_sender_s_rails() {
    let mut bench = Bench::new(otter());
    let battery = BatteryReading { number: 2, voltage_v: 29.0, charge_percent: 80.0, ..Default::default() };
    bench.report(10, &CardReport::Battery(battery));
    let rail = RailReading { number: 4, voltage_v: 5.0, current_a: -0.003, fuse_a: 17.5, flags: 1 };
    bench.report(20, &CardReport::Rail(rail));
    bench.frame(30, 0x0030_AAFF, CardReport::Rail(rail).frame().data());
    assert_eq!(bench.readings, [Reading::Battery(battery), Reading::Rail(rail)]);
}

#[test]
fn errors_and_texts_of_the_card_are_noted_once() {
    let mut bench = Bench::new(otter());
    for ms in [10, 20] {
        bench.frame(ms, 0x00E0_ABFF, &[1, 20, 0, 0, 0, 0, 50, 7]);
        bench.frame(ms, 0x0100_ABFF, &[0, 0x34, 0x12, 0]);
    }
    bench.frame(30, 0x00E0_ABFF, &[1, 20, 0, 0, 0, 0, 50, 0]);
    bench.frame(40, 0x0000_ABFF, b"bootload");
    bench.frame(50, 0x0000_ABFF, b"er 3\nup");
    bench.frame(60, 0x0030_ABFF, &[1, 2]);
    bench.frame(70, 0x00C0_ABFF, &[9; 8]);
    let texts: Vec<&str> = bench.notes.iter().map(|note| &note.text[..]).collect();
    let expected = [
        "battery 1 reports error 7: come back on the other batteries, switch this one off and on, and look the number up in its \
         manual",
        "the port motor reports the error bits 1234, status 00: look for weed or a line in its propeller, let it cool, and \
         switch it off and on by its power channel; its manual explains the bits",
        "battery 1 reports no error any more",
        "the card says: bootloader 3",
        "the card says: up",
        "a frame of the motor card is not used: RAIL (3) has 2 bytes and needs 8",
    ];
    assert_eq!(texts, expected);
    let troubles = bench.readings.iter().filter_map(|reading| match reading {
        Reading::Trouble(TroubleReading { part, text }) => Some((*part, !text.is_empty())),
        _ => None,
    });
    let port = (Part::Motor(Side::Port), true);
    assert_eq!(troubles.collect::<Vec<_>>(), [(Part::Battery(1), true), port, (Part::Battery(1), false)]);
    bench.frame(70_000, 0x00C0_ABFF, &[9; 8]);
    assert!(
        bench.notes[6].text.starts_with("2 frames of the motor card are not used"),
        "{:?}",
        bench.notes[6]
    );
}

#[test]
fn an_error_that_stays_is_told_again_for_who_missed_it() {
    let mut bench = Bench::new(otter());
    for second in 0..25 {
        bench.frame(second * 1000, 0x0100_ABFF, &[1, 0x34, 0x12, 0]);
    }
    let told = bench.readings.iter().filter(|reading| matches!(reading, Reading::Trouble(_))).count();
    let warned = bench.notes.iter().filter(|note| note.text.contains("starboard motor")).count();
    assert_eq!((told, warned), (3, 1));
}

#[test]
fn values_that_cannot_be_are_no_readings_and_no_feedback() {
    let mut bench = Bench::new(otter());
    for ms in (0..4000).step_by(100) {
        for number in [0, 1] {
            bench.frame(ms, 0x00C0_ABFF, &[number, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80]);
            bench.frame(ms, 0x00E0_ABFF, &[number, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80]);
            bench.frame(ms, 0x0030_ABFF, &[number, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0, 0]);
        }
    }
    assert_eq!(bench.readings, []);
    assert!(
        bench.notes[0].warning && bench.notes[0].text.contains("values that cannot be"),
        "{:?}",
        bench.notes
    );
    let last = bench.states.last().unwrap();
    assert!(
        matches!(last, State::Failing(why) if why.contains("the port motor (motor 0) has given no")),
        "{last:?}"
    );
}

#[test]
fn configurations_that_the_card_cannot_have_are_refused() {
    let refused = |change: fn(&mut MotorsConfig)| {
        let mut config = otter();
        change(&mut config);
        Motors::new(config).unwrap_err()
    };
    let second = Duration::from_secs(1);
    assert_eq!(refused(|c| c.write_period = Duration::from_secs(1)), ConfigError::WritePeriod(second));
    assert!(matches!(refused(|c| c.write_period = Duration::ZERO), ConfigError::WritePeriod(_)));
    assert!(matches!(refused(|c| c.command_timeout = Duration::ZERO), ConfigError::CommandTimeout(_)));
    assert_eq!(refused(|c| c.sides.port.motor = 1), ConfigError::Sides { port: 1, starboard: 1 });
    assert_eq!(refused(|c| c.channels[1].rail = 5), ConfigError::Channel("h_aux1".into(), 5, 1));
    assert!(matches!(refused(|c| c.channels[1].name = "h_mot0".into()), ConfigError::Twice(..)));
    assert!(matches!(
        refused(|c| (c.channels[1].rail, c.channels[1].channel) = (0, 0)),
        ConfigError::Twice(..)
    ));
    assert_eq!(write_period(40.0, 10), Some(Duration::from_millis(250)));
    assert_eq!((write_period(0.0, 10), write_period(f64::NAN, 1), write_period(40.0, 0)), (None, None, None));
}

#[test]
fn both_documents_place_their_labels() {
    for table in [ChannelTable::FiveRails, ChannelTable::FourRails] {
        let mut places: Vec<_> = LABELS.iter().filter_map(|label| table.place(label)).collect();
        assert_eq!(places.len(), 10);
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 10, "{table:?} places no two labels alike");
    }
    assert_eq!(ChannelTable::FiveRails.place("H_5V"), Some((4, 0)));
    assert_eq!(ChannelTable::FourRails.place("H_5V"), Some((3, 5)));
    assert_eq!(ChannelTable::FiveRails.place("H_12V0"), None);
}

#[test]
fn what_nobody_polls_stays_within_its_bounds() {
    let mut motors = Motors::new(otter()).unwrap();
    motors.opened(at(0));
    for ms in 0..20_000 {
        motors.handle(at(ms), &CardReport::Rail(RailReading::default()).frame());
        motors.command(at(ms), Pair::new(f64::NAN, 0.0));
        motors.switch(at(ms), "h_aux1", ms % 2 == 0).unwrap();
        motors.handle(at(ms), &CanFrame::new(0x0000_ABFF, b"\nAAAA\nB\n").unwrap());
    }
    let waiting = std::iter::from_fn(|| motors.poll_output()).count();
    assert_eq!(waiting, 1 + 96 + 1 + 32 + 256);
}

proptest! {
    /// Whatever happens on the bus and is commanded, a throttle is never older than its life, and never missing for a second
    /// while the bus is open.
    #[test]
    fn no_throttle_outlives_its_command(
        steps in proptest::collection::vec((0_u64..400, proptest::option::of(-2.0..2.0_f64),
            proptest::option::of((0_u32..1 << 29, proptest::collection::vec(any::<u8>(), 0..=8)))), 1..80),
    ) {
        let mut bench = Bench::new(otter());
        let mut given = None;
        let mut ms = 0;
        for (dt, command, frame) in steps {
            let sent = bench.throttles.len();
            bench.pass(ms, ms + dt);
            for (when, throttle) in &bench.throttles[sent..] {
                let alive = given.is_some_and(|at| *when < at + 500);
                prop_assert!(*throttle == Pair::new(0, 0) || alive, "{throttle:?} at {when} ms");
            }
            ms += dt;
            if let Some(throttle) = command {
                given = Some(ms);
                bench.command(ms, throttle, -throttle);
            }
            if let Some((id, data)) = frame {
                bench.frame(ms, id, &data);
            }
        }
        prop_assert!(bench.throttles.windows(2).all(|two| two[1].0 - two[0].0 <= 250));
    }
}
