use super::*;
use crate::settings::Settings;
use devices::GnssFix;
use units::Now;

const START_US: i64 = 1_600_000_000_000_000;

/// A computer whose clock is off by a function of true time, a receiver with a pulse, and the clock that is judged.
struct Bench {
    bus: Bus,
    clock: Clock,
    true_us: i64,
    sequence: u32,
}

impl Bench {
    fn new() -> Self {
        let start = Now { mono: MonoTime::default(), utc: UtcTime::from_micros(START_US) };
        Self {
            bus: Bus::new(&Settings::otter("test", imc::Address(0x2810)), start),
            clock: Clock::default(),
            true_us: 0,
            sequence: 0,
        }
    }

    fn at(&mut self, true_us: i64, off_us: i64) {
        self.true_us = true_us;
        let mono = MonoTime::from_micros(true_us as u64);
        self.bus.begin(Now { mono, utc: UtcTime::from_micros(START_US + true_us + off_us) });
        self.clock.check(&mut self.bus);
    }

    /// A second: the pulse, seen by a clock that is `off_us` ahead, and 300 ms later the message of the epoch.
    fn second(&mut self, off_us: i64, pulse: bool, message: bool) {
        let whole = (self.true_us / SECOND_US + 1) * SECOND_US;
        // The kernel notes the pulse at once, and the program reads it up to a tenth of a second later.
        self.at(whole + 60_000, off_us);
        if pulse {
            self.sequence += 1;
            let utc = UtcTime::from_micros(START_US + whole + off_us);
            self.clock.pulse(self.bus.mono(), PulseReading { utc, sequence: self.sequence });
        }
        self.at(whole + 300_000, off_us);
        if message {
            let utc = Some(UtcTime::from_micros(START_US + whole));
            let reading = GnssReading { utc, fix: Some(GnssFix::default()), ..GnssReading::default() };
            self.clock.compare(&self.bus, self.bus.mono(), &reading);
        }
    }

    fn judge(&self) -> Judgement {
        self.clock.judge(self.bus.mono())
    }

    fn fault(&self, settings: &WatchSettings) -> Option<String> {
        self.clock.fault(self.bus.mono(), &self.judge(), settings)
    }
}

fn watch() -> WatchSettings {
    WatchSettings { pulse_expected: true, ..Settings::otter("test", imc::Address(0x2810)).watch }
}

#[test]
fn messages_alone_are_good_for_half_a_second() {
    let mut bench = Bench::new();
    assert_eq!(bench.judge().quality, Quality::Unknown);
    (0..20).for_each(|_| bench.second(0, false, true));
    let Judgement { quality, offset_s, bound_s, .. } = bench.judge();
    assert_eq!(quality, Quality::Coarse);
    assert!((offset_s - 0.3).abs() < 1e-6, "{offset_s}: the delay of the message");
    assert!(bound_s >= 0.5);
}

#[test]
fn the_pulse_tells_microseconds_and_the_messages_which_second() {
    for whole_s in [-3, 0, 7] {
        let mut bench = Bench::new();
        let off_us = |n: i64| whole_s * SECOND_US + 40 + (n % 3) * 10;
        (0..20).for_each(|n| bench.second(off_us(n), true, true));
        let Judgement { quality, offset_s, jitter_s, bound_s } = bench.judge();
        assert_eq!(quality, Quality::Precise, "{whole_s}");
        assert!((offset_s - (whole_s as f64 + 50e-6)).abs() < 2e-6, "{offset_s}");
        assert!((5e-6..12e-6).contains(&jitter_s), "{jitter_s}");
        assert!(bound_s >= offset_s.abs());
    }
}

#[test]
fn without_messages_nobody_knows_the_second() {
    let mut bench = Bench::new();
    (0..20).for_each(|_| bench.second(0, true, false));
    assert_eq!(bench.judge().quality, Quality::Unknown);
}

#[test]
fn a_clock_15_ms_late_raises_the_alarm_and_one_of_microseconds_does_not() {
    let mut bench = Bench::new();
    (0..20).for_each(|_| bench.second(-300, true, true));
    assert_eq!(bench.fault(&watch()), None);
    // Chrony lags behind under load: this is reported within the time that the pulses are averaged over.
    (0..PULSES).for_each(|_| bench.second(-15_000, true, true));
    let text = bench.fault(&watch()).unwrap();
    assert!(text.starts_with("-15.0 ms off the satellites by the pulse"), "{text}");
    (0..PULSES).for_each(|_| bench.second(-100, true, true));
    assert_eq!(bench.fault(&watch()), None, "and it is over when chrony has caught up");
}

#[test]
fn a_clock_that_was_set_back_begins_anew_and_is_found_again() {
    let mut bench = Bench::new();
    (0..20).for_each(|_| bench.second(0, true, true));
    bench.second(-3_600 * SECOND_US, false, false);
    assert_eq!(bench.judge().quality, Quality::Unknown);
    assert!(bench.bus.entries().any(|entry| entry.text.to_str_lossy().contains("was set by -3600.0 s")));
    (0..20).for_each(|_| bench.second(-3_600 * SECOND_US, true, true));
    let text = bench.fault(&watch()).unwrap();
    assert!(text.starts_with("-3600.0 s off"), "{text}");
}

#[test]
fn a_lost_pulse_is_held_with_a_bound_that_grows_and_is_reported() {
    let mut bench = Bench::new();
    (0..20).for_each(|_| bench.second(0, true, true));
    (0..600).for_each(|_| bench.second(0, false, true));
    let Judgement { quality, bound_s, .. } = bench.judge();
    assert_eq!(quality, Quality::Holdover);
    assert!((0.011..0.013).contains(&bound_s), "{bound_s}: ten minutes at 20 ppm");
    assert_eq!(bench.fault(&watch()).unwrap(), "no pulse from the receiver: see its wire and Pulse Device");
    let unwired = WatchSettings { pulse_expected: false, ..watch() };
    assert_eq!(bench.fault(&unwired), None);
    // After a night the messages know better.
    (0..40_000).for_each(|_| bench.second(0, false, true));
    assert_eq!(bench.judge().quality, Quality::Coarse);
}

#[test]
fn noise_on_the_wire_moves_nothing() {
    let mut bench = Bench::new();
    for n in 0..40 {
        bench.second(20, true, true);
        if n % 4 == 0 {
            // A spike between two pulses.
            let at = bench.true_us + 200_000;
            bench.at(at, 20);
            let utc = UtcTime::from_micros(START_US + at);
            bench.clock.pulse(bench.bus.mono(), PulseReading { utc, sequence: 0 });
        }
    }
    let Judgement { quality, offset_s, .. } = bench.judge();
    assert_eq!(quality, Quality::Precise);
    assert!((offset_s - 20e-6).abs() < 2e-6, "{offset_s}");
}
