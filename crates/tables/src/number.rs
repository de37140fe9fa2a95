//! Numbers and times as text, quickly.

use crate::dialect::Dialect;
use units::{Civil, UtcTime};

/// Appends an integer.
pub fn integer(out: &mut Vec<u8>, value: i64) {
    out.extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
}

/// Appends a double with as many digits as tell it from all others; `8.0` for a whole one, `NaN`, `inf` and `-inf`. Zero has no
/// sign: SQLite keeps none.
pub fn double(out: &mut Vec<u8>, value: f64, dialect: Dialect) {
    if value.is_finite() {
        real(out, zmij::Buffer::new().format_finite(value + 0.0), dialect);
    } else if value.is_nan() {
        out.extend_from_slice(b"NaN");
    } else {
        out.extend_from_slice(if value > 0.0 { b"inf" } else { b"-inf" });
    }
}

/// Appends a single likewise.
pub fn single(out: &mut Vec<u8>, value: f32, dialect: Dialect) {
    if value.is_finite() {
        real(out, zmij::Buffer::new().format_finite(value + 0.0), dialect);
    } else {
        double(out, value.into(), dialect);
    }
}

/// Appends a number that is written with a decimal point in the dialect's way.
#[inline]
pub fn real(out: &mut Vec<u8>, text: &str, dialect: Dialect) {
    let start = out.len();
    out.extend_from_slice(text.as_bytes());
    let decimal = dialect.decimal();
    if decimal != b'.'
        && let Some(point) = out[start..].iter_mut().find(|byte| **byte == b'.')
    {
        *point = decimal;
    }
}

/// Appends the two cells of a time, ISO 8601 and seconds; both empty for what is not a time.
pub fn stamp(out: &mut Vec<u8>, iso: &mut IsoTime, time_us: Option<i64>, dialect: Dialect) {
    if let Some(time_us) = time_us {
        iso.write(out, time_us);
    }
    out.push(dialect.separator());
    if let Some(time_us) = time_us {
        epoch(out, time_us, dialect);
    }
}

/// Appends times as ISO 8601 in UTC with microseconds; remembers the day, which rarely changes.
#[derive(Debug, Clone, Copy)]
pub struct IsoTime {
    day: i64,
    date: [u8; 11],
}

impl Default for IsoTime {
    fn default() -> Self {
        Self::new()
    }
}

impl IsoTime {
    /// At the beginning of a table.
    pub fn new() -> Self {
        Self { day: i64::MIN, date: *b"0000-00-00T" }
    }

    /// As [`IsoTime::write`] with milliseconds, which is the resolution of tag receivers.
    pub fn write_ms(&mut self, out: &mut Vec<u8>, time_us: i64) {
        self.write(out, time_us);
        out.truncate(out.len() - "000Z".len());
        out.push(b'Z');
    }

    /// Appends a time (µs since 1970-01-01 UTC).
    pub fn write(&mut self, out: &mut Vec<u8>, time_us: i64) {
        const DAY_US: i64 = 86_400_000_000;
        let (day, us) = (time_us.div_euclid(DAY_US), time_us.rem_euclid(DAY_US));
        if day != self.day {
            let Civil { year, month, day: date, .. } = UtcTime::from_micros(time_us).civil();
            if !(0..=9_999).contains(&year) {
                out.extend_from_slice(UtcTime::from_micros(time_us).to_string().as_bytes());
                return;
            }
            self.day = day;
            digits(&mut self.date[0..4], year);
            digits(&mut self.date[5..7], month.into());
            digits(&mut self.date[8..10], date.into());
        }
        out.extend_from_slice(&self.date);
        let mut clock = *b"00:00:00.000000Z";
        digits(&mut clock[0..2], us / 3_600_000_000);
        digits(&mut clock[3..5], us / 60_000_000 % 60);
        digits(&mut clock[6..8], us / 1_000_000 % 60);
        digits(&mut clock[9..15], us % 1_000_000);
        out.extend_from_slice(&clock);
    }
}

/// Appends a time as seconds since 1970-01-01 UTC with six decimals.
pub fn epoch(out: &mut Vec<u8>, time_us: i64, dialect: Dialect) {
    if time_us < 0 {
        out.push(b'-');
    }
    let us = time_us.unsigned_abs();
    out.extend_from_slice(itoa::Buffer::new().format(us / 1_000_000).as_bytes());
    let mut decimals = [dialect.decimal(), 0, 0, 0, 0, 0, 0];
    digits(&mut decimals[1..], (us % 1_000_000) as i64);
    out.extend_from_slice(&decimals);
}

/// Fills a place with the last digits of a number that is not negative.
fn digits(place: &mut [u8], mut value: i64) {
    for digit in place.iter_mut().rev() {
        *digit = b'0' + (value % 10) as u8;
        value /= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLAIN: Dialect = Dialect::Plain;

    fn text(write: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn whole_numbers_stay_reals_and_what_is_no_number_says_so() {
        assert_eq!(text(|out| single(out, 0.1, PLAIN)), "0.1");
        assert_eq!(text(|out| double(out, f64::from(0.1_f32), PLAIN)), "0.10000000149011612");
        assert_eq!(text(|out| double(out, 3.0, PLAIN)), "3.0");
        assert_eq!(text(|out| double(out, -0.0, PLAIN)), "0.0");
        assert_eq!(text(|out| single(out, 0.0, PLAIN)), "0.0");
        assert_eq!(text(|out| double(out, f64::NAN, PLAIN)), "NaN");
        assert_eq!(text(|out| single(out, f32::NEG_INFINITY, PLAIN)), "-inf");
        assert_eq!(text(|out| double(out, -1234.5, Dialect::SpreadsheetComma)), "-1234,5");
        assert_eq!(text(|out| double(out, 1.5e300, Dialect::SpreadsheetComma)), "1,5e+300");
    }

    proptest! {
        #[test]
        fn doubles_read_back_as_they_were(bits: u64) {
            let value = f64::from_bits(bits);
            let read: f64 = text(|out| double(out, value, PLAIN)).parse().unwrap();
            prop_assert!(read.to_bits() == bits || read == 0.0 && value == 0.0 || value.is_nan() && read.is_nan());
        }

        #[test]
        fn singles_read_back_as_they_were(bits: u32) {
            let value = f32::from_bits(bits);
            let written = text(|out| single(out, value, PLAIN));
            let read: f32 = written.parse().unwrap();
            prop_assert!(read.to_bits() == bits || read == 0.0 && value == 0.0 || value.is_nan() && read.is_nan());
            // A reader that guesses types must not take it for an integer.
            prop_assert!(written.parse::<i64>().is_err());
        }
    }

    #[test]
    fn times_are_those_of_units() {
        let mut iso = IsoTime::new();
        for us in
            [0, -1, 1_795_246_989_820_647, 951_782_400_000_000, 1_795_246_989_820_648, i64::MAX, i64::MIN]
        {
            assert_eq!(text(|out| iso.write(out, us)), UtcTime::from_micros(us).to_string());
        }
        assert_eq!(text(|out| epoch(out, 1_795_246_989_820_647, PLAIN)), "1795246989.820647");
        assert_eq!(text(|out| epoch(out, -1_500_000, PLAIN)), "-1.500000");
        assert_eq!(text(|out| stamp(out, &mut iso, None, PLAIN)), ",", "what is not a time is not 1970");
        let comma = text(|out| stamp(out, &mut iso, Some(1_500_000), Dialect::SpreadsheetComma));
        assert_eq!(comma, "1970-01-01T00:00:01.500000Z;1,500000");
    }
}
