//! Accuracy of setting the hydrophone's clock: the simulated receiver measures the instant of each command.
//!
//! A receiver takes the instant of the first character as the mark that the command means: each ten seconds, or with `UT=`
//! a whole second. Characters are a millisecond apart. The measured time is when the other end of the pseudo-terminal could
//! be read, so it includes the scheduling delays of two programs.

use std::fmt;
use std::time::Duration;
use units::UtcTime;

const TEN_SECONDS_US: i64 = 10_000_000;
const SECOND_US: i64 = 1_000_000;
/// A pause ends a command (µs).
const PAUSE_US: i64 = 20_000;
/// A command has no more characters.
const LONGEST: usize = 16;

/// A command being received.
#[derive(Debug)]
struct Coming {
    text: Vec<u8>,
    first: UtcTime,
    last: UtcTime,
}

/// The measurements.
#[derive(Debug, Default)]
pub(super) struct Instants {
    coming: Option<Coming>,
    /// How late each command was (µs); negative is early.
    late_us: Vec<i64>,
    /// Time from one character to the next in each (µs); a receiver takes one a millisecond and no more.
    pace_us: Vec<i64>,
}

impl Instants {
    /// Bytes of the computer that could be read at this time.
    pub(super) fn take(&mut self, utc: UtcTime, bytes: &[u8]) {
        if self.coming.as_ref().is_some_and(|coming| utc - coming.last > PAUSE_US) {
            self.end();
        }
        if bytes.is_empty() {
            return;
        }
        let coming = self.coming.get_or_insert_with(|| Coming { text: Vec::new(), first: utc, last: utc });
        let room = LONGEST.saturating_sub(coming.text.len());
        coming.text.extend(&bytes[..bytes.len().min(room)]);
        coming.last = utc;
    }

    /// The command is complete.
    fn end(&mut self) {
        let Some(Coming { text, first, last }) = self.coming.take() else { return };
        let raster_us = match &text[..] {
            [b'(', b'+', b')', ..] => TEN_SECONDS_US,
            [b'U', b'T', b'=', ..] => SECOND_US,
            _ => return,
        };
        let since_us = first.micros().rem_euclid(raster_us);
        self.late_us.push(if since_us > raster_us / 2 { since_us - raster_us } else { since_us });
        // A command has sixteen characters at most.
        self.pace_us.push((last - first) / (text.len() as i64 - 1));
    }
}

impl fmt::Display for Instants {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.late_us.len();
        let ms = |us: i64| us as f64 / 1000.0;
        let worst_us = self.late_us.iter().copied().max_by_key(|us| us.abs()).unwrap_or(0);
        let (fastest_us, slowest_us) = (self.pace_us.iter().min(), self.pace_us.iter().max());
        // Some thousands a day.
        let mean_us = self.late_us.iter().map(|us| us.abs()).sum::<i64>() / (count.max(1) as i64);
        let within = self
            .late_us
            .iter()
            .filter(|us| us.unsigned_abs() <= Duration::from_millis(2).as_micros() as u64)
            .count();
        write!(
            f,
            "instants commands={count} within_2_ms={within} mean_ms={:.3} worst_ms={:+.3} pace_ms={:.3} to {:.3}",
            ms(mean_us),
            ms(worst_us),
            ms(fastest_us.copied().unwrap_or(0)),
            ms(slowest_us.copied().unwrap_or(0))
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(us: i64) -> UtcTime {
        UtcTime::from_micros(1_790_000_000_000_000 + us)
    }

    fn send(instants: &mut Instants, first_us: i64, gap_us: i64, text: &str) {
        for (place, byte) in (0..).zip(text.bytes()) {
            instants.take(at(first_us + place * gap_us), &[byte]);
        }
    }

    #[test]
    fn commands_are_measured_against_their_marks_and_their_pace() {
        let mut instants = Instants::default();
        send(&mut instants, 700, 1000, "(+)1790000004");
        send(&mut instants, 9_998_000, 1000, "(+)");
        send(&mut instants, 12_000_100, 500, "UT=1790000012");
        // Settings have no instant.
        send(&mut instants, 15_123_456, 1000, "LI=01");
        instants.take(at(16_000_000), &[]);
        assert_eq!(
            instants.to_string(),
            "instants commands=3 within_2_ms=3 mean_ms=0.933 worst_ms=-2.000 pace_ms=0.500 to 1.000"
        );
    }

    #[test]
    fn nothing_measured_is_said_too() {
        assert!(Instants::default().to_string().starts_with("instants commands=0 within_2_ms=0 "));
    }
}
