//! The receiver's clock: kept, lost, found again.

use super::*;

/// A clock that is kept is nearer than this (µs): it drifts half a millisecond between two marks at 50 parts per million, and
/// the simulated line hands a character over at whole milliseconds.
const KEPT_US: i64 = 1_500;

#[test]
fn an_unset_clock_is_set_at_a_mark_and_kept() {
    let mut bench = Bench::new(ReceiverSettings::default(), &unset());
    bench.run(130);
    assert!(bench.error_us().abs() < KEPT_US, "{} µs", bench.error_us());
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
    for (sent_us, text) in &bench.sent {
        assert_eq!(sent_us % 10_000_000, 0, "{text} left at {sent_us}");
        if let Some(ClockCommand::SetTens(seconds)) = ClockCommand::parse(text) {
            assert_eq!(seconds * 1_000_000, *sent_us);
        }
    }
    let lengths: Vec<usize> = bench.sent.iter().map(|(_, text)| text.len()).collect();
    assert_eq!(lengths, [13, 3, 3, 3, 3, 3, 13, 3, 3, 3, 3, 3, 13]);
    assert_eq!((bench.notes.len(), &bench.states[..]), (0, &[State::Starting, State::Working][..]));
}

#[test]
fn a_drifting_clock_is_held() {
    let clock = ClockConfig { offset_s: 0.4, drift_ppm: 50.0, ..ClockConfig::default() };
    let mut bench = Bench::new(ReceiverSettings::default(), &clock);
    bench.run(300);
    assert!(bench.error_us().abs() < KEPT_US, "{} µs", bench.error_us());
}

#[test]
fn every_vector_of_the_clock_is_sent() {
    let Some(path) = testkit::shared("data/onboard/tbr_sync_vectors.csv") else { return };
    for row in std::fs::read_to_string(path).unwrap().lines().skip(1) {
        let (unix_s, rest) = row.split_once(',').unwrap();
        let (message, _) = rest.split_once(',').unwrap();
        let mark_us: i64 = unix_s.parse::<i64>().unwrap() * 1_000_000;
        let mut driver = Receiver::new(ReceiverSettings::default());
        let before = |us: u64| Now {
            mono: MonoTime::from_micros(us),
            utc: UtcTime::from_micros(mark_us - 3_000_000 + us as i64),
        };
        driver.handle(before(0), Input::Opened);
        let due = driver.poll_timeout().unwrap();
        driver.handle(before(due.micros()), Input::Time);
        let sent = std::iter::from_fn(|| driver.poll_output()).find_map(|output| {
            if let Output::Send { bytes, at, .. } = output { Some((bytes, at)) } else { None }
        });
        assert_eq!(sent, Some((message.as_bytes().to_vec(), MonoTime::from_micros(3_000_000))));
    }
}

#[test]
fn missing_acknowledgements_are_noted_and_lose_the_clock() {
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    bench.run(30);
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
    bench.answers = false;
    bench.run(60);
    assert_eq!(bench.driver.clock(), ClockState::Lost);
    assert_eq!(bench.notes.iter().filter(|note| !note.warning).count(), 2);
    assert!(matches!(bench.warnings()[..], [one] if one.contains("missing 3 times")));
    // The full time is tried again, and the clock is good again with the first answer.
    bench.answers = true;
    let before = bench.sent.len();
    bench.run(12);
    assert!(bench.sent[before..].iter().all(|(_, text)| text.len() == 13));
    assert_eq!(bench.driver.clock(), ClockState::Set);
}

#[test]
fn by_pulse_the_time_is_sent_on_a_second_and_seldom() {
    let sync = Sync::Pulse { period: Duration::from_mins(1) };
    let mut bench = Bench::new(ReceiverSettings { sync, ..ReceiverSettings::default() }, &unset());
    bench.run(125);
    assert_eq!(bench.sent.len(), 3);
    for (sent_us, text) in &bench.sent {
        assert_eq!(ClockCommand::parse(text), Some(ClockCommand::SetSecond(sent_us / 1_000_000)));
        assert_eq!(sent_us % 1_000_000, 0);
    }
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
    bench.answers = false;
    bench.run(62);
    assert_eq!(bench.driver.clock(), ClockState::Lost);
    bench.answers = true;
    bench.run(12);
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
}

#[test]
fn stamps_that_cannot_be_lose_the_clock() {
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    bench.run(20);
    let unix_s = START_US / 1_000_000 + 20;
    bench.line(&tag(unix_s - 2, 1));
    assert_eq!((bench.driver.clock(), bench.warnings().len()), (ClockState::Disciplined, 0));
    bench.line(&tag(unix_s + 60, 2));
    assert_eq!(bench.driver.clock(), ClockState::Lost);
    assert!(bench.warnings()[0].contains("wrong"), "{:?}", bench.warnings());
    let before = bench.sent.len();
    bench.run(10);
    assert_eq!(bench.sent[before].1.len(), 13);
}

#[test]
fn wrong_clocks_converge() {
    for offset_s in [-3600.0, -20.0, -12.3, -10.0, -5.6, -0.3, 0.389, 4.9, 7.0, 10.0, 20.0, 86_400.0] {
        let mut bench =
            Bench::new(ReceiverSettings::default(), &ClockConfig { offset_s, ..ClockConfig::default() });
        for _ in 0..45 {
            bench.run(1);
            bench.hear(40, 1_500_000);
            if bench.is_believed() {
                // An offset below the accepted span cannot be detected before the first command takes effect.
                let error_us = bench.error_us().abs();
                assert!(
                    error_us < 15_000 || error_us < 9_000_000 && bench.us < 7_200_000,
                    "{offset_s} s: {error_us} µs"
                );
            }
        }
        assert!(bench.error_us().abs() < KEPT_US, "{offset_s} s: {} µs", bench.error_us());
        assert_eq!(bench.driver.clock(), ClockState::Disciplined, "{offset_s} s");
    }
}

#[test]
fn a_clock_that_was_set_back_raises_the_alarm_at_the_next_line_and_is_set_again() {
    for offset_s in [-10.0, -20.0, -3600.0, 10.0] {
        let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
        bench.run(40);
        bench.hear(40, 3_600_000);
        assert_eq!((bench.driver.clock(), bench.warnings().len()), (ClockState::Disciplined, 0));
        bench.put_off(offset_s);
        bench.run(1);
        bench.hear(40, 3_600_000);
        assert_eq!(bench.driver.clock(), ClockState::Lost, "{offset_s} s");
        assert!(bench.warnings()[0].contains("it is set at the next mark"), "{:?}", bench.warnings());
        // The line is dated by a clock that is known to be lost.
        let told = bench.told.last().unwrap();
        assert!(told.clock == ClockState::Lost && told.clock_fault == bench.warnings()[0], "{told:?}");
        let before = bench.sent.len();
        bench.run(25);
        assert_eq!(bench.sent[before].1.len(), 13, "with the full time");
        assert!(bench.is_believed() && bench.error_us().abs() < KEPT_US);
        assert_eq!(bench.told.last().unwrap().clock_fault, "");
    }
}

#[test]
fn a_step_of_the_computer_s_clock_loses_the_clock_until_it_is_set_by_the_new_time() {
    for set_us in [7_000_000, -7_000_000, 300_000] {
        let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
        bench.run(33);
        assert_eq!(bench.driver.clock(), ClockState::Disciplined);
        bench.set_us = set_us;
        bench.hear(40, 3_600_000);
        assert_eq!(bench.driver.clock(), ClockState::Lost);
        assert!(matches!(bench.warnings()[..], [one] if one.contains("this computer's clock was set by")));
        let before = bench.sent.len();
        for _ in 0..60 {
            bench.run(1);
            bench.hear(40, 3_600_000);
            assert!(!bench.is_believed() || bench.error_us().abs() < KEPT_US, "{} µs", bench.error_us());
        }
        let (mark_us, first) = &bench.sent[before];
        assert_eq!((first.len(), mark_us % 10_000_000), (13, 0));
        assert_eq!((bench.driver.clock(), bench.warnings().len()), (ClockState::Disciplined, 1));
    }
}

#[test]
fn a_command_that_was_under_way_when_the_clock_was_set_is_not_believed() {
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    // To just behind the handing over of a command.
    while bench.driver.poll_timeout().is_some_and(|due| due.micros() < 26_000_000) {
        bench.run(1);
    }
    bench.us = 26_450_000;
    bench.give(Input::Time);
    assert_eq!(bench.sent.last().map(|(sent_us, _)| *sent_us), Some(START_US + 26_600_000));
    bench.set_us = 7_000_000;
    bench.run(2);
    assert_eq!(bench.driver.clock(), ClockState::Lost);
    bench.run(20);
    assert!(bench.is_believed() && bench.error_us().abs() < KEPT_US, "{} µs", bench.error_us());
}

#[test]
fn slewing_is_no_step() {
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    for _ in 0..60 {
        bench.run(1);
        bench.set_us += 500;
    }
    assert_eq!((bench.driver.clock(), bench.warnings().len()), (ClockState::Disciplined, 0));
}

#[test]
fn a_clock_that_becomes_15_ms_late_raises_the_alarm() {
    // By its lines: two tags of different length, and nothing that sets it.
    let mut bench = Bench::new(quiet(), &ClockConfig::default());
    let hear = |bench: &mut Bench, times: usize| {
        for _ in 0..times {
            bench.run(5);
            bench.hear(40, 3_600_000);
            bench.hear(41, 3_210_000);
        }
    };
    hear(&mut bench, 10);
    assert_eq!((bench.driver.clock(), bench.warnings().len()), (ClockState::Set, 0));
    bench.put_off(-0.015);
    hear(&mut bench, 2);
    assert_eq!(bench.warnings().len(), 0, "one late line raises no warning");
    hear(&mut bench, 1);
    assert!(
        matches!(bench.warnings()[..], [one] if one.contains("S256-40=7 come 15 ms later")),
        "{:?}",
        bench.warnings()
    );
    // By its acknowledgements: commands that leave late set it late.
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    bench.run(100);
    bench.late_us = 15_000;
    bench.run(50);
    let warnings = bench.warnings();
    assert!(matches!(warnings[..], [one] if one.contains("acknowledges ack01 15 ms later")), "{warnings:?}");
}

#[test]
fn marks_that_are_missed_leave_the_clock_off_by_as_much_and_cannot_be_seen_by_the_driver_alone() {
    // As the first version of the thesis had it: commands at 389 ms past the mark. Each is acknowledged, and the clock is off.
    let mut bench = Bench::new(ReceiverSettings::default(), &ClockConfig::default());
    bench.late_us = 389_000;
    bench.run(100);
    assert!((bench.error_us() + 389_000).abs() < KEPT_US, "{} µs", bench.error_us());
    assert_eq!(bench.driver.clock(), ClockState::Disciplined);
}

#[test]
fn a_line_that_keeps_no_pace_loses_the_commands_and_the_clock() {
    let mut bench = Bench::new(ReceiverSettings::default(), &unset());
    bench.pace_us = 500;
    bench.run(60);
    assert!(!bench.is_believed());
    assert!(
        matches!(bench.warnings()[..], [one] if one.contains("missing 3 times")),
        "{:?}",
        bench.warnings()
    );
    bench.pace_us = 1000;
    bench.run(25);
    assert!(bench.is_believed() && bench.error_us().abs() < KEPT_US, "{} µs", bench.error_us());
}
