//! The fields of a sentence: each reads one kind of value, `None` where it is empty, and says which field is wrong.

use super::damage::DamagedSentence;
use units::wrap_two_pi;

const US_PER_S: u32 = 1_000_000;

/// A time of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct TimeOfDay {
    /// Since midnight UTC (µs); up to and with 24 h, as a leap second counts on.
    pub micros: u64,
}

/// The fields of one sentence, counted from its address as 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a> {
    /// The text between `$` and `*`.
    body: &'a str,
}

impl<'a> Fields<'a> {
    /// Fields of a body that has at least `least` of them, the address counted.
    pub(super) fn new(body: &'a str, least: usize) -> Result<Self, DamagedSentence> {
        let stand = body.split(',').count();
        if stand < least {
            return Err(DamagedSentence::TooFew { address: address(body), stand, least });
        }
        Ok(Self { body })
    }

    /// A field's text without blanks; empty where the sentence ends before it.
    pub(super) fn text(&self, index: usize) -> &'a str {
        self.body.split(',').nth(index).unwrap_or_default().trim()
    }

    /// The error that a field deserves.
    pub(super) fn wrong(&self, index: usize) -> DamagedSentence {
        DamagedSentence::Field { address: address(self.body), index, text: self.text(index).to_owned() }
    }

    fn value<T>(&self, index: usize, read: impl Fn(&str) -> Option<T>) -> Result<Option<T>, DamagedSentence> {
        match self.text(index) {
            "" => Ok(None),
            text => read(text).map(Some).ok_or_else(|| self.wrong(index)),
        }
    }

    /// A decimal number within a range.
    pub(super) fn number(&self, index: usize, least: f64, most: f64) -> Result<Option<f64>, DamagedSentence> {
        self.value(index, |text| decimal(text).filter(|value| (least..=most).contains(value)))
    }

    /// A whole number up to `most`.
    pub(super) fn whole(&self, index: usize, most: u32) -> Result<Option<u32>, DamagedSentence> {
        self.value(index, |text| whole(text).filter(|&value| value <= most))
    }

    /// A direction in degrees; as radians in [0, 2π).
    pub(super) fn direction_rad(&self, index: usize) -> Result<Option<f64>, DamagedSentence> {
        Ok(self.number(index, 0.0, 360.0)?.map(|degrees| wrap_two_pi(degrees.to_radians())))
    }

    /// A small angle in degrees, as pitch and roll; as radians.
    pub(super) fn tilt_rad(&self, index: usize) -> Result<Option<f64>, DamagedSentence> {
        Ok(self.number(index, -180.0, 180.0)?.map(f64::to_radians))
    }

    /// Degrees and minutes with their letter in the next field; as radians. Both are there or both are empty.
    pub(super) fn angle_rad(
        &self,
        index: usize,
        letters: [&str; 2],
        most_deg: f64,
    ) -> Result<Option<f64>, DamagedSentence> {
        let Some(degrees) = self.value(index, degrees_and_minutes)? else { return Ok(None) };
        let sign = match self.text(index + 1) {
            letter if letter == letters[0] => 1.0,
            letter if letter == letters[1] => -1.0,
            _ => return Err(self.wrong(index + 1)),
        };
        if degrees > most_deg {
            return Err(self.wrong(index));
        }
        Ok(Some((sign * degrees).to_radians()))
    }

    /// A time of day, `hhmmss` with or without a fraction.
    pub(super) fn time(&self, index: usize) -> Result<Option<TimeOfDay>, DamagedSentence> {
        self.value(index, time_of_day)
    }

    /// A letter out of some.
    pub(super) fn letter(&self, index: usize, letters: &str) -> Result<Option<char>, DamagedSentence> {
        self.value(index, |text| {
            let mut all = text.chars();
            let first = all.next().filter(|letter| letters.contains(*letter))?;
            all.next().is_none().then_some(first)
        })
    }
}

/// The address of a sentence, short enough for a message.
fn address(body: &str) -> String {
    body.split(',').next().unwrap_or_default().chars().take(8).collect()
}

/// A number of digits with an optional sign and point: no exponent, infinity or NaN, which `f64` would read.
pub(super) fn decimal(text: &str) -> Option<f64> {
    let plain = text.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+'));
    plain.then(|| text.parse().ok()).flatten()
}

/// A number of digits only, read in base ten whatever zeros lead it.
pub(super) fn whole(text: &str) -> Option<u32> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

/// `ddmm.mmmm` or `dddmm.mmmm` as degrees.
fn degrees_and_minutes(text: &str) -> Option<f64> {
    let point = text.find('.').unwrap_or(text.len());
    let (degrees, minutes) = text.split_at_checked(point.checked_sub(2)?)?;
    let minutes = decimal(minutes).filter(|minutes| (0.0..60.0).contains(minutes))?;
    // Receivers with few digits write 530.5 for 5° 30.5'.
    let degrees = if degrees.is_empty() { 0 } else { whole(degrees)? };
    Some(f64::from(degrees) + minutes / 60.0)
}

/// `hhmmss`, with or without a fraction. Second 60 is a leap second, which UTC as a count of seconds does not know: it
/// is the second that follows.
fn time_of_day(text: &str) -> Option<TimeOfDay> {
    let (clock, fraction) = text.split_once('.').unwrap_or((text, ""));
    if clock.len() != 6 || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let part = |from: usize| clock.get(from..from + 2).and_then(whole);
    let (hour, minute, second) = (part(0)?, part(2)?, part(4)?);
    if hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    // Six digits at most, so the number is below a million.
    let micros = fraction.bytes().chain(std::iter::repeat(b'0')).take(6);
    let micros = micros.fold(0, |sum, digit| sum * 10 + u32::from(digit - b'0'));
    let seconds = (hour * 60 + minute) * 60 + second;
    Some(TimeOfDay { micros: u64::from(seconds) * u64::from(US_PER_S) + u64::from(micros) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_digits_and_nothing_else() {
        for (text, expected) in [
            ("1.5", Some(1.5)),
            ("-0.25", Some(-0.25)),
            ("+0", Some(0.0)),
            ("1e5", None),
            ("inf", None),
            ("NaN", None),
        ] {
            assert_eq!(decimal(text), expected, "{text}");
        }
        assert_eq!(whole("0000002185"), Some(2185));
        assert_eq!(whole("-1"), None);
    }

    #[test]
    fn times_of_day_are_checked() {
        let micros = |text| time_of_day(text).map(|time| time.micros);
        assert_eq!(micros("000001.25"), Some(1_250_000));
        assert_eq!(micros("235959"), Some(86_399_000_000));
        assert_eq!(micros("235960.00"), Some(86_400_000_000));
        for wrong in ["240000.00", "006000", "000061", "12345", "1234567", "12a456", "123456.x", ""] {
            assert_eq!(micros(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn angles_have_minutes_below_sixty() {
        assert_eq!(degrees_and_minutes("6326.4300000"), Some(63.4405));
        assert_eq!(degrees_and_minutes("00030.0"), Some(0.5));
        for wrong in ["6360.0", "6.0", "63-1.0", "", "."] {
            assert_eq!(degrees_and_minutes(wrong), None, "{wrong}");
        }
    }
}
