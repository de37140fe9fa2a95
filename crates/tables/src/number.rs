//! Numbers and times as text, quickly.

use units::{Civil, UtcTime};

/// Appends an integer.
pub(crate) fn integer(out: &mut Vec<u8>, value: i64) {
    out.extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
}

/// Appends a double with as many digits as tell it from all others; `inf` and `-inf` for infinities.
pub(crate) fn double(out: &mut Vec<u8>, value: f64) {
    if value.is_finite() {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format_finite(value);
        // Whole numbers need no point.
        out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    } else if !value.is_nan() {
        out.extend_from_slice(if value > 0.0 { b"inf" } else { b"-inf" });
    }
}

/// Appends a single likewise.
pub(crate) fn single(out: &mut Vec<u8>, value: f32) {
    if value.is_finite() {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format_finite(value);
        out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    } else {
        double(out, value.into());
    }
}

/// Appends times as ISO 8601 in UTC with microseconds; remembers the day, which rarely changes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IsoTime {
    day: i64,
    date: [u8; 11],
}

impl IsoTime {
    pub(crate) fn new() -> Self {
        Self { day: i64::MIN, date: *b"0000-00-00T" }
    }

    /// As [`IsoTime::write`] with milliseconds, which is what receivers of tags tell.
    pub(crate) fn write_ms(&mut self, out: &mut Vec<u8>, time_us: i64) {
        self.write(out, time_us);
        out.truncate(out.len() - "000Z".len());
        out.push(b'Z');
    }

    pub(crate) fn write(&mut self, out: &mut Vec<u8>, time_us: i64) {
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
pub(crate) fn epoch(out: &mut Vec<u8>, time_us: i64) {
    if time_us < 0 {
        out.push(b'-');
    }
    let us = time_us.unsigned_abs();
    out.extend_from_slice(itoa::Buffer::new().format(us / 1_000_000).as_bytes());
    let mut decimals = *b".000000";
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

    fn text(write: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_read_back_as_they_were() {
        for value in [0.0, -0.5, 0.1, 1e300, 63.440_612_345_678_9, 5e-324, 12_345_678.0] {
            assert_eq!(text(|out| double(out, value)).parse::<f64>().unwrap().to_bits(), f64::to_bits(value));
        }
        assert_eq!(text(|out| single(out, 0.1)), "0.1");
        assert_eq!(text(|out| double(out, f64::from(0.1_f32))), "0.10000000149011612");
        assert_eq!(text(|out| double(out, 3.0)), "3");
        assert_eq!(text(|out| double(out, f64::NAN)), "");
        assert_eq!(text(|out| single(out, f32::NEG_INFINITY)), "-inf");
    }

    #[test]
    fn times_are_those_of_units() {
        let mut iso = IsoTime::new();
        for us in
            [0, -1, 1_795_246_989_820_647, 951_782_400_000_000, 1_795_246_989_820_648, i64::MAX, i64::MIN]
        {
            assert_eq!(text(|out| iso.write(out, us)), UtcTime::from_micros(us).to_string());
        }
        assert_eq!(text(|out| epoch(out, 1_795_246_989_820_647)), "1795246989.820647");
        assert_eq!(text(|out| epoch(out, -1_500_000)), "-1.500000");
    }
}
