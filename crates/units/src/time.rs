//! Two kinds of time that must never be mixed: a steady one for deadlines and UTC for records.

use std::ops::{Add, Sub};
use std::time::Duration;

/// A point on a clock that never steps, for deadlines and rates. Its zero means nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct MonoTime(u64);

impl MonoTime {
    /// From microseconds since the clock's own zero.
    pub const fn from_micros(us: u64) -> Self {
        Self(us)
    }

    /// Microseconds since the clock's own zero.
    pub const fn micros(self) -> u64 {
        self.0
    }

    /// The time since `earlier`; zero when `earlier` is later.
    pub const fn since(self, earlier: Self) -> Duration {
        Duration::from_micros(self.0.saturating_sub(earlier.0))
    }

    /// So long before; the clock's own zero at the earliest.
    #[must_use]
    pub fn before(self, span: Duration) -> Self {
        Self(self.0.saturating_sub(u64::try_from(span.as_micros()).unwrap_or(u64::MAX)))
    }
}

impl Add<Duration> for MonoTime {
    type Output = Self;
    fn add(self, span: Duration) -> Self {
        Self(self.0.saturating_add(u64::try_from(span.as_micros()).unwrap_or(u64::MAX)))
    }
}

/// Coordinated Universal Time: microseconds since 1970-01-01, leap seconds not counted (as POSIX has it).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct UtcTime(i64);

impl UtcTime {
    /// From microseconds since 1970-01-01.
    pub const fn from_micros(us: i64) -> Self {
        Self(us)
    }

    /// From seconds since 1970-01-01, to the nearest microsecond; `None` for NaN and for times that 64 bits
    /// of microseconds cannot hold.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        let us = (seconds * 1e6).round();
        // 2^63 is exact in a double, so the comparison admits just what the cast below keeps.
        (us.abs() < 9_223_372_036_854_775_808.0).then_some(Self(us as i64))
    }

    /// Microseconds since 1970-01-01.
    pub const fn micros(self) -> i64 {
        self.0
    }

    /// Seconds since 1970-01-01; exact to the microsecond until the year 2255.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// Year, month and day, hour, minute, second and microsecond of the proleptic Gregorian calendar.
    ///
    /// Days to civil date after H. Hinnant, "chrono-Compatible Low-Level Date Algorithms" (2013).
    pub fn civil(self) -> Civil {
        let day_number = self.0.div_euclid(86_400_000_000);
        let us_of_day = self.0.rem_euclid(86_400_000_000);
        let z = day_number + 719_468;
        let era = z.div_euclid(146_097);
        let day_of_era = z.rem_euclid(146_097);
        let year_of_era =
            (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
        Civil {
            year: year_of_era + era * 400 + i64::from(month <= 2),
            month: month as u8,
            day: (day_of_year - (153 * shifted_month + 2) / 5 + 1) as u8,
            hour: (us_of_day / 3_600_000_000) as u8,
            minute: (us_of_day / 60_000_000 % 60) as u8,
            second: (us_of_day / 1_000_000 % 60) as u8,
            microsecond: (us_of_day % 1_000_000) as u32,
        }
    }

    /// From a civil date and time; `None` when the parts are not a date or time of day, or out of range.
    pub fn from_civil(civil: Civil) -> Option<Self> {
        let Civil { year, month, day, hour, minute, second, microsecond } = civil;
        if !(1..=12).contains(&month)
            || hour > 23
            || minute > 59
            || second > 59
            || microsecond > 999_999
            || !(-290_000..=290_000).contains(&year)
        {
            return None;
        }
        let shifted_year = year - i64::from(month <= 2);
        let era = shifted_year.div_euclid(400);
        let year_of_era = shifted_year.rem_euclid(400);
        let shifted_month = (i64::from(month) + 9) % 12;
        let day_of_year = (153 * shifted_month + 2) / 5 + i64::from(day) - 1;
        let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
        let day_number = era * 146_097 + day_of_era - 719_468;
        let seconds =
            day_number * 86_400 + i64::from(hour) * 3_600 + i64::from(minute) * 60 + i64::from(second);
        let time = Self(seconds * 1_000_000 + i64::from(microsecond));
        // A day beyond the end of its month comes back as another date.
        (time.civil() == civil).then_some(time)
    }
}

impl Sub for UtcTime {
    /// Signed microseconds.
    type Output = i64;
    fn sub(self, earlier: Self) -> i64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// The text is not a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoTime;

impl std::fmt::Display for NoTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("no time in ISO 8601, like 2026-11-21T07:43:27Z or 2026-11-21T09:43:27+02:00")
    }
}

impl std::error::Error for NoTime {}

impl std::str::FromStr for UtcTime {
    type Err = NoTime;

    /// ISO 8601: a date (`2026-11-21`, its beginning), or a date and time to the minute, second or fraction of one
    /// (`2026-11-21T07:43`, `2026-11-21 07:43:27.5Z`). Without an offset it is UTC; with one (`+02:00`, `-0330`, `+02`) it is
    /// turned into UTC. A blank before an offset counts as its `+`, which addresses of pages turn into one.
    fn from_str(text: &str) -> Result<Self, NoTime> {
        let (date, time) = text.split_once(['T', 't', ' ']).unwrap_or((text, "00:00"));
        let mut date = date.strip_suffix(['Z', 'z']).unwrap_or(date).splitn(3, '-').map(digits);
        let (year, month, day) = (part(&mut date)?, part(&mut date)?, part(&mut date)?);
        let (time, offset_us) = offset(time)?;
        let (time, fraction) = time.split_once('.').unwrap_or((time, "0"));
        let mut time = time.split(':').map(digits);
        let (hour, minute) = (part(&mut time)?, part(&mut time)?);
        let second = time.next().unwrap_or(Some(0)).ok_or(NoTime)?;
        // Finer than a microsecond is cut.
        let written = fraction.bytes().all(|byte| byte.is_ascii_digit()).then_some(fraction);
        let fraction = written.and_then(|digits| digits.get(..digits.len().clamp(1, 6))).ok_or(NoTime)?;
        let scale = 10_u32.pow(6 - fraction.len() as u32);
        let microsecond = digits(fraction).ok_or(NoTime)? * scale;
        let small = |number: u32| u8::try_from(number).map_err(|_| NoTime);
        let (month, day) = (small(month)?, small(day)?);
        let (hour, minute, second) = (small(hour)?, small(minute)?, small(second)?);
        let civil = Civil { year: year.into(), month, day, hour, minute, second, microsecond };
        let local = if time.next().is_some() { Err(NoTime) } else { Self::from_civil(civil).ok_or(NoTime) }?;
        Ok(Self(local.0 - offset_us))
    }
}

/// A time of day without its offset from UTC, and the offset (µs).
fn offset(time: &str) -> Result<(&str, i64), NoTime> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Ok((time, 0));
    }
    let Some(at) = time.find(['+', '-', ' ']) else { return Ok((time, 0)) };
    let (time, offset) = time.split_at(at);
    let sign = if offset.starts_with('-') { -1 } else { 1 };
    let offset = &offset[1..];
    let (hours, minutes) = match offset.len() {
        2 => (offset, "00"),
        4 => offset.split_at_checked(2).ok_or(NoTime)?,
        _ => offset
            .split_once(':')
            .filter(|(hours, minutes)| hours.len() == 2 && minutes.len() == 2)
            .ok_or(NoTime)?,
    };
    let (hours, minutes) = (digits(hours).ok_or(NoTime)?, digits(minutes).ok_or(NoTime)?);
    let minutes_east = i64::from(hours * 60 + minutes);
    if hours < 24 && minutes < 60 { Ok((time, sign * minutes_east * 60_000_000)) } else { Err(NoTime) }
}

/// A number of digits only, without a sign.
fn digits(text: &str) -> Option<u32> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

fn part(parts: &mut impl Iterator<Item = Option<u32>>) -> Result<u32, NoTime> {
    parts.next().flatten().ok_or(NoTime)
}

impl std::fmt::Display for UtcTime {
    /// ISO 8601 with microseconds: `2026-11-21T07:43:27.123456Z`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let c = self.civil();
        write!(
            f,
            "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z",
            c.year, c.month, c.day, c.hour, c.minute, c.second, c.microsecond
        )
    }
}

/// The parts of a UTC date and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Civil {
    /// Year of the proleptic Gregorian calendar.
    pub year: i64,
    /// Month, 1 to 12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
    /// Second, 0 to 59.
    pub second: u8,
    /// Microsecond, 0 to 999 999.
    pub microsecond: u32,
}

/// The present by both clocks of a program: deadlines run on the one, records carry the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Now {
    /// The clock that never steps.
    pub mono: MonoTime,
    /// The program's UTC, which may step.
    pub utc: UtcTime,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_iso_8601() {
        assert_eq!(
            UtcTime::from_seconds(1_590_400_000.125).unwrap().to_string(),
            "2020-05-25T09:46:40.125000Z"
        );
        assert_eq!(UtcTime::from_micros(-1).to_string(), "1969-12-31T23:59:59.999999Z");
        assert_eq!(UtcTime::from_micros(951_782_400_000_000).to_string(), "2000-02-29T00:00:00.000000Z");
    }

    #[test]
    fn reads_iso_8601() {
        let day = UtcTime::from_micros(1_795_219_200_000_000);
        assert_eq!(day.to_string(), "2026-11-21T00:00:00.000000Z");
        for (text, us) in [
            ("2026-11-21", 0),
            ("2026-11-21T00:00Z", 0),
            ("2026-11-21 01:02", 3_720_000_000),
            ("2026-11-21T01:02:03", 3_723_000_000),
            ("2026-11-21t01:02:03.5z", 3_723_500_000),
            ("2026-11-21T00:00:00.1234569Z", 123_456),
            ("2026-11-21T01:02:03.5+01:00", 123_500_000),
            ("2026-11-20T20:32-0330", 120_000_000),
            ("2026-11-21T02:00+02", 0),
            ("2026-11-21T02:00:00 02:00", 0),
        ] {
            assert_eq!(text.parse(), Ok(UtcTime::from_micros(day.micros() + us)), "{text}");
        }
        assert_eq!(day.to_string().parse(), Ok(day));
        for bad in [
            "",
            "yesterday",
            "2026",
            "2026-11",
            "2026-02-30",
            "2026-11-21T24:00",
            "2026-11-21T01",
            "-1-11-21",
            "2026-11-21T01:02:03.",
            "2026-11-21T01:02:03.5x",
            "2026-11-21T01:02:03+1:00",
            "2026-11-21T01:02:03+24:00",
            "2026-11-21T01:02:03+01:60",
            "2026-11-21T01:02:03+",
            "2026-11-21T01:02:03+010",
            "2026-11-21T01:02:03+æ1",
            "2026-11-21+01:00",
            "2026-11-21T1:2:3:4",
            "2026-11-21T01:02:+3",
            "２026-11-21",
        ] {
            assert_eq!(bad.parse::<UtcTime>(), Err(NoTime), "{bad}");
        }
    }

    #[test]
    fn civil_dates_return() {
        for us in (-4_000_000_000_000_000..4_000_000_000_000_000).step_by(86_399_999_999_999) {
            let time = UtcTime::from_micros(us);
            assert_eq!(UtcTime::from_civil(time.civil()), Some(time));
        }
    }

    #[test]
    fn refuses_what_is_no_date() {
        let base = UtcTime::from_micros(0).civil();
        assert_eq!(UtcTime::from_civil(Civil { month: 2, day: 30, ..base }), None);
        assert_eq!(UtcTime::from_civil(Civil { month: 13, ..base }), None);
        assert_eq!(UtcTime::from_civil(Civil { day: 0, ..base }), None);
        assert_eq!(UtcTime::from_seconds(f64::NAN), None);
        assert_eq!(UtcTime::from_seconds(1e300), None);
    }

    #[test]
    fn steady_time_never_goes_below_zero() {
        let t = MonoTime::from_micros(5);
        assert_eq!(t.since(t + Duration::from_micros(1)), Duration::ZERO);
        assert_eq!((t + Duration::from_millis(1)).micros(), 1_005);
    }
}
