//! A compass through its life by a clock that the test drives.

use super::*;
use devices::nmea::{EarthModel, Sentence};
use devices::{GnssFix, GnssReading, Quality};
use units::UtcTime;

const START_US: i64 = 1_795_000_000_000_000;

fn at(ms: u64) -> Now {
    let us = ms * 1000;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(START_US + us as i64) }
}

fn open(settings: CompassSettings) -> Compass {
    let mut compass = Compass::new(settings);
    compass.handle(at(0), Input::Opened);
    compass
}

fn outputs(compass: &mut Compass) -> Vec<Output> {
    std::iter::from_fn(|| compass.poll_output()).collect()
}

fn readings(outputs: &[Output]) -> Vec<(u64, GnssReading)> {
    let reading = |output: &Output| match output {
        Output::Reading { at, reading: Reading::Gnss(reading) } => Some((at.mono.micros() / 1000, *reading)),
        _ => None,
    };
    outputs.iter().filter_map(reading).collect()
}

fn states(outputs: &[Output]) -> Vec<State> {
    let state = |output: &Output| if let Output::State(state) = output { Some(state.clone()) } else { None };
    outputs.iter().filter_map(state).collect()
}

/// The compass's sentences at a second of its clock; the heading in degrees is the second.
fn says(second: u64, kinds: &[Sentence]) -> Vec<u8> {
    let reading = GnssReading {
        utc: Some(UtcTime::from_micros(START_US + second as i64 * 1_000_000)),
        fix: Some(GnssFix {
            lat_rad: 1.1,
            lon_rad: 0.2,
            height_m: 40.0,
            quality: Quality::RtkFixed,
            hdop: 0.9,
        }),
        satellites: 8,
        velocity: None,
        heading_rad: Some((second as f64).to_radians()),
        yaw_rate_rad_s: Some(0.0),
        ..GnssReading::default()
    };
    kinds.iter().flat_map(|kind| kind.encode(&reading, &EarthModel::default())).collect()
}

/// Hands bytes over in pieces of a port's size, a millisecond each, and what is due between.
fn feed(compass: &mut Compass, from_ms: u64, bytes: &[u8]) {
    for (index, piece) in bytes.chunks(20).enumerate() {
        run_to(compass, from_ms + index as u64);
        compass.handle(at(from_ms + index as u64), Input::Bytes(piece));
    }
}

/// Lets pass time until `ms`, with every deadline on its way.
fn run_to(compass: &mut Compass, ms: u64) {
    while let Some(due) = compass.poll_timeout().filter(|due| *due <= at(ms).mono) {
        compass.handle(at(due.micros().div_ceil(1000)), Input::Time);
    }
}

#[test]
fn settings_are_sent_and_epochs_given_as_soon_as_they_are_whole() {
    let mut compass = open(CompassSettings::default());
    let sent = outputs(&mut compass);
    let lines: Vec<String> = sent
        .iter()
        .filter_map(|output| if let Output::Send { bytes, .. } = output { Some(bytes.clone()) } else { None })
        .map(|bytes| String::from_utf8(bytes).unwrap())
        .collect();
    assert_eq!(lines.len(), 7);
    assert_eq!(lines[0], "$JASC,GPGGA,1\r\n");
    for second in 1..=6 {
        let bytes = says(second, &Sentence::EPOCH);
        feed(&mut compass, second * 1000, &bytes);
        let found = readings(&outputs(&mut compass));
        if second <= 3 {
            // Nothing is known yet of what an epoch holds: the pause ends it.
            assert_eq!(found, []);
            run_to(&mut compass, second * 1000 + 200);
            assert_eq!(readings(&outputs(&mut compass)).len(), 1);
        } else {
            assert_eq!(found.len(), 1, "second {second}");
            // The reading is of the time when its first sentence was whole.
            assert!((second * 1000..second * 1000 + 3).contains(&found[0].0), "{}", found[0].0);
            let reading = found[0].1;
            assert!((reading.heading_rad.unwrap().to_degrees() - second as f64).abs() < 1e-9);
            assert_eq!(reading.fix.unwrap().quality, Quality::RtkFixed);
            assert_eq!(reading.utc.unwrap().micros(), START_US + second as i64 * 1_000_000);
        }
    }
    assert_eq!(compass.counts().epochs, 6);
}

#[test]
fn starting_within_an_epoch_or_losing_a_sentence_mixes_nothing() {
    let mut compass = open(CompassSettings::default());
    let mut found = Vec::new();
    for second in 1..20 {
        let kinds: Vec<Sentence> = match second {
            1 => Sentence::EPOCH[3..].to_vec(),
            8 => Sentence::EPOCH[1..].to_vec(),
            12 => Sentence::EPOCH[..5].to_vec(),
            _ => Sentence::EPOCH.to_vec(),
        };
        feed(&mut compass, second * 1000, &says(second, &kinds));
        run_to(&mut compass, second * 1000 + 500);
        found.extend(readings(&outputs(&mut compass)));
    }
    assert_eq!(found.len(), 19);
    for (second, (_, reading)) in (1..).zip(&found) {
        let expected = (second != 1 && second != 8).then_some(f64::from(second));
        let heading = reading.heading_rad.map(|heading_rad| heading_rad.to_degrees().round());
        assert_eq!(heading, expected, "second {second}");
        assert!(reading.fix.is_some());
        if second > 1 {
            assert_eq!(reading.utc.unwrap().micros(), START_US + i64::from(second) * 1_000_000);
        }
    }
}

#[test]
fn a_remnant_behind_a_pause_is_no_reading() {
    let mut compass = open(CompassSettings::default());
    for second in 1..=4 {
        feed(&mut compass, second * 1000, &says(second, &Sentence::EPOCH));
        run_to(&mut compass, second * 1000 + 500);
    }
    outputs(&mut compass);
    feed(&mut compass, 5000, &says(5, &Sentence::EPOCH[..4]));
    run_to(&mut compass, 5300);
    feed(&mut compass, 5300, &says(5, &Sentence::EPOCH[4..]));
    run_to(&mut compass, 5900);
    assert_eq!(readings(&outputs(&mut compass)).len(), 1);
}

#[test]
fn the_mounting_of_the_antennas_turns_the_heading() {
    let mut compass =
        open(CompassSettings { heading_offset_rad: (-5.0_f64).to_radians(), ..CompassSettings::default() });
    feed(&mut compass, 10, &says(2, &Sentence::EPOCH));
    run_to(&mut compass, 500);
    let (_, reading) = readings(&outputs(&mut compass))[0];
    assert!((reading.heading_rad.unwrap().to_degrees() - 357.0).abs() < 1e-9);
}

#[test]
fn silence_fails_with_what_to_do_and_a_sentence_recovers() {
    let mut compass = open(CompassSettings::default());
    outputs(&mut compass);
    run_to(&mut compass, 4100);
    let found = outputs(&mut compass);
    let [State::Failing(why)] = &states(&found)[..] else { panic!("{found:?}") };
    assert!(why.starts_with("nothing came for 4 s"), "{why}");
    // A receiver that lost its power is set again.
    assert_eq!(found.iter().filter(|output| matches!(output, Output::Send { .. })).count(), 7);
    run_to(&mut compass, 60_000);
    assert_eq!(states(&outputs(&mut compass)), []);
    feed(&mut compass, 60_000, &says(60, &Sentence::EPOCH));
    assert_eq!(states(&outputs(&mut compass)), [State::Working]);
}

#[test]
fn a_wrong_baud_rate_is_recognised_by_its_babble() {
    let mut compass = open(CompassSettings::default());
    outputs(&mut compass);
    let mut state = 1_u32;
    for ms in 0..200 {
        let bytes: Vec<u8> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .take(10)
        .collect();
        compass.handle(at(ms), Input::Bytes(&bytes));
    }
    let found = outputs(&mut compass);
    let [State::Failing(why)] = &states(&found)[..] else { panic!("{found:?}") };
    assert!(why.contains("check the baud rate"), "{why}");
    let notes = found.iter().filter(|output| matches!(output, Output::Note(_))).count();
    assert!(notes <= 3, "{notes} notes");
}

#[test]
fn sentences_of_no_use_are_named() {
    let mut compass = open(CompassSettings::default());
    outputs(&mut compass);
    for second in 0..5 {
        compass.handle(at(second * 1000), Input::Bytes(b"$GPGSV,3,1,11*7B\r\n"));
    }
    run_to(&mut compass, 5000);
    let found = outputs(&mut compass);
    let [State::Failing(why)] = &states(&found)[..] else { panic!("{found:?}") };
    assert!(why.contains("initialisation strings"), "{why}");
}

#[test]
fn a_pulled_cable_fails_until_the_port_is_back() {
    let mut compass = open(CompassSettings::default());
    feed(&mut compass, 10, &says(0, &Sentence::EPOCH[..4]));
    compass.handle(at(500), Input::Lost);
    assert_eq!(compass.poll_timeout(), None);
    let found = outputs(&mut compass);
    assert!(
        matches!(&states(&found)[..], [.., State::Working, State::Failing(why)] if why.contains("cable"))
    );
    compass.handle(at(9000), Input::Opened);
    feed(&mut compass, 9010, &says(9, &Sentence::EPOCH));
    run_to(&mut compass, 9300);
    let found = outputs(&mut compass);
    assert_eq!(states(&found), [State::Starting, State::Working]);
    assert_eq!(readings(&found).len(), 1);
}

/// How often each line was sent.
fn sent(outputs: &[Output], line: &str) -> usize {
    let is_it =
        |output: &&Output| matches!(output, Output::Send { bytes, .. } if bytes.starts_with(line.as_bytes()));
    outputs.iter().filter(is_it).count()
}

#[test]
fn settings_are_sent_again_more_and_more_seldom_and_saved_once() {
    let mut init = CompassSettings::default().init;
    init.extend(["$JPPS,WIDTH,999.996,SAVE".to_owned(), "$JSAVE".to_owned()]);
    let mut compass = open(CompassSettings { init, ..CompassSettings::default() });
    run_to(&mut compass, 3_600_000);
    let first_hour = outputs(&mut compass);
    // At 0, 4, 12, 28 and 60 s, and then once a minute.
    let times = sent(&first_hour, "$JASC,GPGGA,1");
    assert!((60..=66).contains(&times), "{times}");
    assert_eq!((sent(&first_hour, "$JSAVE"), sent(&first_hour, "$JPPS")), (1, 1));
    // A plug that is loose does not save them either.
    for minute in 0..100 {
        compass.handle(at(3_600_000 + minute * 1000), Input::Lost);
        compass.handle(at(3_600_000 + minute * 1000), Input::Opened);
    }
    assert_eq!(sent(&outputs(&mut compass), "$JSAVE"), 0);
    compass.handle(at(25 * 3_600_000), Input::Opened);
    assert_eq!(sent(&outputs(&mut compass), "$JSAVE"), 1);
}

#[test]
fn a_magnetic_heading_stands_in_with_the_variation_while_there_is_no_true_one() {
    let seconds = |variation_deg: Option<f64>, kinds: &[Sentence]| {
        let variation_rad = variation_deg.map(f64::to_radians);
        let mut compass = open(CompassSettings {
            variation_rad,
            heading_offset_rad: 2.0_f64.to_radians(),
            ..CompassSettings::default()
        });
        for second in 1..=9 {
            // For a while it has a true heading, one sentence of which is lost.
            let with_true = second <= 3 && second != 2;
            let kinds: Vec<Sentence> =
                kinds.iter().copied().filter(|kind| *kind != Sentence::Hdt || with_true).collect();
            feed(&mut compass, second * 1000, &says(second, &kinds));
            run_to(&mut compass, second * 1000 + 500);
        }
        let found = readings(&outputs(&mut compass));
        found.iter().map(|(_, one)| one.heading_rad.map(f64::to_degrees)).collect::<Vec<_>>()
    };
    let declination_deg = EarthModel::default().declination_rad.to_degrees();
    let found = seconds(Some(declination_deg), &Sentence::EPOCH);
    assert_eq!(found.len(), 9);
    // Within the hundredth of a degree that the sentence has.
    for (second, heading_deg) in
        [(1, Some(3.0)), (2, None), (3, Some(5.0)), (4, None), (8, Some(10.0)), (9, Some(11.0))]
    {
        let found: Option<f64> = found[second - 1];
        let near = found.zip(heading_deg).is_some_and(|(a, b): (f64, f64)| (a - b).abs() < 0.011);
        assert!(near || (found.is_none() && heading_deg.is_none()), "{second}: {found:?}");
    }
    assert_eq!(seconds(None, &Sentence::EPOCH)[8], None, "not without being asked to");
}

/// A line and the receiver at its end, which hears what is sent at its own speed.
struct Line {
    baud: u32,
    receiver: u32,
    heard: Vec<String>,
    changes: usize,
}

impl Line {
    /// Outputs up to `ms`, in their order, none before its time.
    fn carry(&mut self, outputs: Vec<Output>) {
        let mut last = MonoTime::default();
        for output in outputs {
            match output {
                Output::Speed { baud, at } => {
                    assert!(at >= last);
                    (self.baud, last) = (baud, at);
                    self.changes += 1;
                }
                Output::Send { bytes, at, .. } => {
                    let text = String::from_utf8(bytes).unwrap();
                    if self.baud == self.receiver {
                        if let Some(speed) = text.strip_prefix("$JBAUD,") {
                            self.receiver = speed.trim().parse().unwrap();
                        }
                        self.heard.push(text.clone());
                    }
                    // The next may not come before this has left at the speed of the line.
                    let bits = text.len() as u64 * 10;
                    last = at + Duration::from_micros(bits * 1_000_000 / u64::from(self.baud));
                    if !text.starts_with("$JBAUD") {
                        last = at;
                    }
                }
                Output::Reading { .. } | Output::Newest { .. } | Output::State(_) | Output::Note(_) => {}
            }
        }
    }
}

#[test]
fn a_receiver_of_another_speed_is_told_that_of_the_line_and_then_its_settings() {
    for receiver in SPEEDS {
        let mut compass = open(CompassSettings { baud: Some(19_200), ..CompassSettings::default() });
        let mut line = Line { baud: 19_200, receiver, heard: Vec::new(), changes: 0 };
        line.carry(outputs(&mut compass));
        assert_eq!(line.changes, 0, "a receiver that works is left alone");
        // Whether noise comes of it or nothing: at another speed it is one or the other.
        if receiver % 9_600 == 0 {
            for ms in 0..100 {
                compass.handle(at(ms), Input::Bytes(&[0x80, 0xF8, 0x00, 0x1E, 0x66, 0x78]));
            }
        }
        run_to(&mut compass, 4500);
        line.carry(outputs(&mut compass));
        assert_eq!((line.baud, line.receiver, line.changes), (19_200, 19_200, 6));
        let asc = line.heard.iter().rposition(|text| text.starts_with("$JASC")).unwrap();
        let baud = line.heard.iter().position(|text| text.starts_with("$JBAUD"));
        assert!(baud.is_none_or(|baud| baud < asc), "{:?}", line.heard);
        assert_eq!(baud.is_some(), receiver != 19_200);
    }
}

#[test]
fn what_is_no_hemisphere_or_says_something_is_not_told_a_speed() {
    let changes = |settings: CompassSettings, bytes: &[u8]| {
        let mut compass = open(settings);
        for second in 0..60 {
            compass.handle(at(second * 1000), Input::Bytes(bytes));
            run_to(&mut compass, second * 1000 + 999);
        }
        outputs(&mut compass).iter().filter(|output| matches!(output, Output::Speed { .. })).count()
    };
    let with = |init: &[&str], baud| CompassSettings {
        init: init.iter().map(|line| (*line).to_owned()).collect(),
        baud,
        ..CompassSettings::default()
    };
    let useless = b"$GPGSV,3,1,11*7B\r\n";
    assert_eq!(changes(with(&["$JASC,GPGGA,1"], Some(19_200)), useless), 0, "NMEA comes at this speed");
    assert_eq!(changes(with(&["$PMTK220,200"], Some(19_200)), b""), 0, "another maker's");
    assert_eq!(changes(with(&["$JASC,GPGGA,1"], None), b""), 0, "no serial port");
    assert_eq!(changes(with(&["$JASC,GPGGA,1"], Some(250_000)), b""), 0, "no speed of a Hemisphere");
    assert!(changes(with(&["$JASC,GPGGA,1"], Some(19_200)), b"") > 0);
}
