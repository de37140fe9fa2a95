//! The hydrophone's clock, which commands set.
//!
//! Its commands are those of [`devices::tbr_clock`]; a pause ends one. A command counts from its first character. `(+)`, with
//! or without a time, takes effect half a second later and sets the clock to the ten seconds *and a half*: so it is right where
//! the command came on the mark, and off by as much as the command was early or late. The receiver goes by its old clock until
//! then, and acknowledges no sooner. Lauvås (2020) words that as rounding "to the nearest 10.5 s" and as "10 s segments with an
//! added 500 ms delay"; no receiver was at hand to measure it.
//!
//! Outside command mode a character that comes sooner than a millisecond after the previous one is lost.

use crate::range::{OutOfRange, within};
use devices::tbr_clock::ClockCommand;
use units::UtcTime;

const TEN_SECONDS_US: i64 = 10_000_000;
/// Silence that ends a command (µs): commands are sent at a character a millisecond.
const PAUSE_US: i64 = 20_000;
/// From the first character of `(+)` until the clock is set (µs).
const DELAY_US: i64 = 500_000;
/// The longest command kept; anything longer is noise.
const LONGEST: usize = 64;

/// A receiver's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockConfig {
    /// Whether the clock is set at the start; if not it counts from power-up, at the start.
    pub set: bool,
    /// Error of a set clock at the start (s); positive is ahead.
    pub offset_s: f64,
    /// Drift (parts per million); positive is fast.
    pub drift_ppm: f64,
    /// Characters that come closer together are lost (µs). A receiver takes one a millisecond, and a little is left for how
    /// exactly that is kept; 0 where the time of a character is not known so well.
    pub least_pace_us: i64,
}

impl Default for ClockConfig {
    /// Set, right and steady.
    fn default() -> Self {
        Self { set: true, offset_s: 0.0, drift_ppm: 0.0, least_pace_us: 900 }
    }
}

/// The clock while it runs, with the receiver's side of the commands that set it.
#[derive(Debug, Clone)]
pub struct ReceiverClock {
    drift: f64,
    /// True time and reading when the clock was last set.
    since_us: i64,
    reading_us: i64,
    text: Vec<u8>,
    first_byte_us: i64,
    last_byte_us: i64,
    least_pace_us: i64,
    command_mode: bool,
    /// A command that takes effect at a time to come (µs).
    delayed: Option<(i64, ClockCommand)>,
}

impl ReceiverClock {
    /// A receiver that is switched on at `start`.
    ///
    /// # Errors
    /// When offset or drift are out of range.
    pub fn new(config: &ClockConfig, start: UtcTime) -> Result<Self, OutOfRange> {
        let offset_s = within("offset of the receiver's clock (s)", config.offset_s, -1e6, 1e6)?;
        let ppm = within("drift of the receiver's clock (ppm)", config.drift_ppm, -1000.0, 1000.0)?;
        let since_us = start.micros();
        let reading_us = if config.set { since_us + (offset_s * 1e6) as i64 } else { 0 };
        Ok(Self {
            drift: ppm / 1e6,
            since_us,
            reading_us,
            text: Vec::new(),
            first_byte_us: since_us,
            last_byte_us: i64::MIN,
            least_pace_us: config.least_pace_us,
            command_mode: false,
            delayed: None,
        })
    }

    /// The clock's reading at a true time (µs).
    pub fn reading_us(&self, utc: UtcTime) -> i64 {
        let elapsed_us = utc.micros() - self.since_us;
        self.reading_us + elapsed_us + (elapsed_us as f64 * self.drift).round() as i64
    }

    fn set(&mut self, utc: UtcTime, reading_us: i64) {
        self.since_us = utc.micros();
        self.reading_us = reading_us;
    }

    /// Bytes sent to the receiver at `now`.
    pub fn receive(&mut self, now: UtcTime, bytes: &[u8]) {
        for &byte in bytes {
            let is_lost =
                now.micros().saturating_sub(self.last_byte_us) < self.least_pace_us && !self.command_mode;
            if is_lost || self.text.len() >= LONGEST {
                continue;
            }
            if self.text.is_empty() {
                self.first_byte_us = now.micros();
            }
            self.text.push(byte);
            self.last_byte_us = now.micros();
        }
    }

    /// The answer to a command that has taken effect by `now`.
    pub fn answer(&mut self, now: UtcTime) -> Option<Vec<u8>> {
        if !self.text.is_empty() && now.micros() - self.last_byte_us >= PAUSE_US {
            let text = std::mem::take(&mut self.text);
            if let Some(command) = ClockCommand::parse(String::from_utf8_lossy(&text).trim()) {
                let delay_us = match command {
                    ClockCommand::Round | ClockCommand::SetTens(_) => DELAY_US,
                    _ => 0,
                };
                self.delayed = Some((self.first_byte_us + delay_us, command));
            }
        }
        let (at_us, command) = self.delayed.take_if(|(at_us, _)| *at_us <= now.micros())?;
        self.obey(UtcTime::from_micros(at_us), &command).then(|| command.answer())
    }

    /// Carries a command out at the moment of its effect; answers whether it has any.
    fn obey(&mut self, at: UtcTime, command: &ClockCommand) -> bool {
        match command {
            ClockCommand::Round => {
                let reading_us = self.reading_us(at) - DELAY_US;
                let tens = (reading_us + TEN_SECONDS_US / 2).div_euclid(TEN_SECONDS_US);
                self.set(at, tens * TEN_SECONDS_US + DELAY_US);
            }
            ClockCommand::SetTens(seconds) => self.set(at, seconds * 1_000_000 + DELAY_US),
            ClockCommand::SetSecond(seconds) => self.set(at, seconds * 1_000_000),
            ClockCommand::EnterCommands => self.command_mode = true,
            ClockCommand::LeaveCommands => return std::mem::replace(&mut self.command_mode, false),
            ClockCommand::Version | ClockCommand::Setting(_) => return self.command_mode,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(us: i64) -> UtcTime {
        UtcTime::from_micros(us)
    }

    fn ask(clock: &mut ReceiverClock, now: UtcTime, command: &str) -> Option<String> {
        for (place, byte) in (0..).zip(command.bytes()) {
            clock.receive(at(now.micros() + 1000 * place), &[byte]);
        }
        assert_eq!(clock.answer(now), None);
        clock.answer(at(now.micros() + DELAY_US)).map(|bytes| String::from_utf8(bytes).unwrap())
    }

    #[test]
    fn counts_from_power_up_until_it_is_set() {
        let start = at(1_500_000_000_000_000 - 600_000_000);
        let mut clock =
            ReceiverClock::new(&ClockConfig { set: false, ..ClockConfig::default() }, start).unwrap();
        let now = at(1_500_000_000_000_000);
        assert_eq!(clock.reading_us(now), 600_000_000);
        assert_eq!(ask(&mut clock, now, "(+)1500000003").as_deref(), Some("ack02\r"));
        assert_eq!(clock.reading_us(at(now.micros() + 7)), now.micros() + 7);
    }

    #[test]
    fn a_wrong_luhn_digit_sets_nothing() {
        let start = at(1_500_000_000_000_000);
        let mut clock = ReceiverClock::new(&ClockConfig::default(), start).unwrap();
        for command in ["(+)1500000004", "(+)150000000", "(+)15000000xx", "UT=12", "FC=69", "noise"] {
            assert_eq!(ask(&mut clock, start, command), None, "{command}");
            assert_eq!(clock.reading_us(start), start.micros());
        }
    }

    #[test]
    fn discipline_rounds_to_ten_seconds() {
        let start = at(1_500_000_000_000_000);
        let config = ClockConfig { offset_s: 0.4, drift_ppm: 20.0, ..ClockConfig::default() };
        let mut clock = ReceiverClock::new(&config, start).unwrap();
        let now = at(start.micros() + 100_000_000);
        assert_eq!(clock.reading_us(now) - now.micros(), 402_000);
        assert_eq!(ask(&mut clock, now, "(+)").as_deref(), Some("ack01\r"));
        let then = at(now.micros() + DELAY_US);
        assert_eq!(clock.reading_us(then), then.micros());
    }

    #[test]
    fn a_command_off_its_mark_leaves_the_clock_off_by_as_much() {
        let start = at(1_500_000_000_000_000);
        for (late_us, text) in [(389_000, "(+)"), (-120_000, "(+)"), (389_000, "(+)1500000003")] {
            let mut clock =
                ReceiverClock::new(&ClockConfig::default(), at(start.micros() - 1_000_000)).unwrap();
            ask(&mut clock, at(start.micros() + late_us), text).unwrap();
            let now = at(start.micros() + 9_000_000);
            assert_eq!(clock.reading_us(now) - now.micros(), -late_us, "{text}");
        }
        // A sender that adds the half second itself has it twice.
        let mut clock = ReceiverClock::new(&ClockConfig::default(), start).unwrap();
        ask(&mut clock, at(start.micros() + 500_000), "(+)").unwrap();
        assert_eq!(clock.reading_us(start) - start.micros(), -500_000);
    }

    #[test]
    fn the_clock_is_set_and_acknowledged_half_a_second_after_the_first_character() {
        let start = at(1_500_000_000_000_000);
        let config = ClockConfig { offset_s: 0.3, ..ClockConfig::default() };
        let mut clock = ReceiverClock::new(&config, start).unwrap();
        clock.receive(start, b"(");
        clock.receive(at(start.micros() + 1000), b"+");
        clock.receive(at(start.micros() + 2000), b")");
        let before = at(start.micros() + 499_999);
        assert_eq!((clock.answer(before), clock.reading_us(before) - before.micros()), (None, 300_000));
        let then = at(start.micros() + 500_000);
        assert_eq!(clock.answer(then), Some(b"ack01\r".to_vec()));
        assert_eq!(clock.reading_us(then), then.micros());
    }

    #[test]
    fn characters_that_come_too_fast_are_lost() {
        let start = at(1_500_000_000_000_000);
        let later = at(start.micros() + 2 * DELAY_US);
        for (pace_us, answer) in [(1000, true), (950, true), (800, false), (0, false)] {
            let mut clock = ReceiverClock::new(&ClockConfig::default(), start).unwrap();
            for (place, byte) in (0..).zip(*b"(+)1500000003") {
                clock.receive(at(start.micros() + place * pace_us), &[byte]);
            }
            assert_eq!(clock.answer(later).is_some(), answer, "{pace_us} µs");
        }
        // Where the time of a character is not known it is not judged.
        let config = ClockConfig { least_pace_us: 0, ..ClockConfig::default() };
        let mut clock = ReceiverClock::new(&config, start).unwrap();
        clock.receive(start, b"(+)1500000003");
        assert!(clock.answer(later).is_some());
    }

    #[test]
    fn command_mode_echoes_settings() {
        let start = at(1_500_000_000_000_000);
        let mut clock = ReceiverClock::new(&ClockConfig::default(), start).unwrap();
        for (command, answer) in
            [("LIVECM", "LIVECM\r"), ("LI=01", "LI=01\r"), ("FV?", "FV=v1.0.6\r"), ("EX!", "EX!\r")]
        {
            assert_eq!(ask(&mut clock, start, command).as_deref(), Some(answer));
        }
        assert_eq!(ask(&mut clock, start, "LI=01"), None);
    }

    #[test]
    fn accepts_every_recorded_clock_message() {
        let Some(path) = testkit::shared("data/onboard/tbr_sync_vectors.csv") else { return };
        for line in std::fs::read_to_string(path).unwrap().lines().skip(1) {
            let mut fields = line.split(',');
            let unix_s: i64 = fields.next().unwrap().parse().unwrap();
            let now = at(unix_s * 1_000_000);
            let mut clock =
                ReceiverClock::new(&ClockConfig { set: false, ..ClockConfig::default() }, now).unwrap();
            assert_eq!(ask(&mut clock, now, fields.next().unwrap()).as_deref(), Some("ack02\r"));
            assert_eq!(clock.reading_us(now), now.micros());
        }
    }
}
