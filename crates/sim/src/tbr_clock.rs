//! The hydrophone's clock, which commands set.
//!
//! Its commands are those of [`devices::tbr_clock`]; a pause ends one. The receiver's 500 ms convention and its
//! limit of one character a millisecond are left out.

use crate::range::{OutOfRange, within};
use devices::tbr_clock::ClockCommand;
use units::UtcTime;

const TEN_SECONDS_US: i64 = 10_000_000;
/// Silence that ends a command (µs): commands are sent at a character a millisecond.
const PAUSE_US: i64 = 20_000;
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
}

impl Default for ClockConfig {
    /// Set, right and steady.
    fn default() -> Self {
        Self { set: true, offset_s: 0.0, drift_ppm: 0.0 }
    }
}

/// The clock while it runs.
#[derive(Debug, Clone)]
pub(crate) struct ReceiverClock {
    drift: f64,
    /// True time and reading when the clock was last set.
    since_us: i64,
    reading_us: i64,
    text: Vec<u8>,
    last_byte_us: i64,
    command_mode: bool,
}

impl ReceiverClock {
    pub(crate) fn new(config: &ClockConfig, start: UtcTime) -> Result<Self, OutOfRange> {
        let offset_s = within("offset of the receiver's clock (s)", config.offset_s, -1e6, 1e6)?;
        let ppm = within("drift of the receiver's clock (ppm)", config.drift_ppm, -1000.0, 1000.0)?;
        let since_us = start.micros();
        let reading_us = if config.set { since_us + (offset_s * 1e6) as i64 } else { 0 };
        Ok(Self {
            drift: ppm / 1e6,
            since_us,
            reading_us,
            text: Vec::new(),
            last_byte_us: since_us,
            command_mode: false,
        })
    }

    /// What the clock shows at a true time (µs).
    pub(crate) fn reading_us(&self, utc: UtcTime) -> i64 {
        let elapsed_us = utc.micros() - self.since_us;
        self.reading_us + elapsed_us + (elapsed_us as f64 * self.drift).round() as i64
    }

    fn set(&mut self, utc: UtcTime, reading_us: i64) {
        self.since_us = utc.micros();
        self.reading_us = reading_us;
    }

    /// Bytes sent to the receiver at `now`.
    pub(crate) fn receive(&mut self, now: UtcTime, bytes: &[u8]) {
        let room = LONGEST.saturating_sub(self.text.len());
        self.text.extend_from_slice(&bytes[..bytes.len().min(room)]);
        self.last_byte_us = now.micros();
    }

    /// The answer to a command that a pause has ended by `now`.
    pub(crate) fn answer(&mut self, now: UtcTime) -> Option<Vec<u8>> {
        if self.text.is_empty() || now.micros() - self.last_byte_us < PAUSE_US {
            return None;
        }
        let text = std::mem::take(&mut self.text);
        let command = ClockCommand::parse(String::from_utf8_lossy(&text).trim())?;
        self.obey(UtcTime::from_micros(self.last_byte_us), &command).then(|| command.answer())
    }

    /// Carries a command out; answers whether it has effect.
    fn obey(&mut self, at: UtcTime, command: &ClockCommand) -> bool {
        match command {
            ClockCommand::Round => {
                let reading_us = self.reading_us(at);
                let tens = (reading_us + TEN_SECONDS_US / 2).div_euclid(TEN_SECONDS_US);
                self.set(at, tens * TEN_SECONDS_US);
            }
            ClockCommand::SetTens(seconds) | ClockCommand::SetSecond(seconds) => {
                self.set(at, seconds * 1_000_000);
            }
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
        clock.receive(now, command.as_bytes());
        assert_eq!(clock.answer(now), None);
        clock.answer(at(now.micros() + PAUSE_US)).map(|bytes| String::from_utf8(bytes).unwrap())
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
        assert_eq!(clock.reading_us(now), now.micros());
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
