//! Points in time as people write them.

use std::str::FromStr;
use units::{Civil, UtcTime};

/// A point in time, or one in a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Moment {
    /// Seconds since 1970-01-01 UTC.
    At(f64),
    /// Seconds after the log's first packet.
    AfterStart(f64),
}

impl Moment {
    /// Seconds since 1970-01-01 UTC, for a log that starts then.
    pub(crate) fn seconds(self, start_s: f64) -> f64 {
        match self {
            Self::At(time_s) => time_s,
            Self::AfterStart(span_s) => start_s + span_s,
        }
    }
}

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let finite = |text: &str| text.parse().ok().filter(|seconds: &f64| seconds.is_finite());
        let moment = match text.strip_prefix('+') {
            Some(span) => finite(span).map(Self::AfterStart),
            None => finite(text).or_else(|| iso(text)).map(Self::At),
        };
        moment.ok_or_else(|| {
            "expected 2026-11-21T07:43:27Z, 1795247007.5 (seconds since 1970) or +30 (after the log's start)"
                .to_owned()
        })
    }
}

/// ISO 8601 with date and, if given, time and offset; UTC without one.
fn iso(text: &str) -> Option<f64> {
    let (date, time) = text.split_once(['T', ' ']).unwrap_or((text, "00:00"));
    let mut parts = date.splitn(3, '-');
    let mut next = || digits(parts.next()?);
    let (year, month, day) = (next()?, next()?, next()?);
    let (time, offset_s) = offset(time)?;
    let (clock, fraction_s) = match time.split_once('.') {
        Some((clock, fraction)) => {
            (clock, digits(fraction).and_then(|_| format!("0.{fraction}").parse().ok())?)
        }
        None => (time, 0.0),
    };
    let mut parts = clock.splitn(3, ':');
    let hour = digits(parts.next()?)?;
    let minute = digits(parts.next()?)?;
    let second = parts.next().map_or(Some(0), digits)?;
    let small = |number: i64| u8::try_from(number).ok();
    let civil = Civil {
        year,
        month: small(month)?,
        day: small(day)?,
        hour: small(hour)?,
        minute: small(minute)?,
        second: small(second)?,
        microsecond: 0,
    };
    Some(UtcTime::from_civil(civil)?.seconds() + fraction_s - offset_s)
}

/// The time before an offset, and the offset in seconds.
fn offset(time: &str) -> Option<(&str, f64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0.0));
    }
    let Some(at) = time.find(['+', '-']) else { return Some((time, 0.0)) };
    let (time, offset) = time.split_at(at);
    let sign = if offset.starts_with('-') { -1.0 } else { 1.0 };
    let (hours, minutes) = offset[1..].split_once(':').unwrap_or((&offset[1..], "0"));
    let (hours, minutes) = (digits(hours)?, digits(minutes)?);
    (hours < 24 && minutes < 60).then_some((time, sign * (hours * 3_600 + minutes * 60) as f64))
}

fn digits(text: &str) -> Option<i64> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_people_write() {
        for (text, moment) in [
            ("1795247007.5", Moment::At(1_795_247_007.5)),
            ("2026-11-21T07:43:27Z", Moment::At(1_795_247_007.0)),
            ("2026-11-21 07:43:27.5", Moment::At(1_795_247_007.5)),
            ("2026-11-21T08:43:27+01:00", Moment::At(1_795_247_007.0)),
            ("2026-11-21T07:43", Moment::At(1_795_246_980.0)),
            ("2026-11-21", Moment::At(1_795_219_200.0)),
            ("+30", Moment::AfterStart(30.0)),
            ("+1.5", Moment::AfterStart(1.5)),
        ] {
            assert_eq!(text.parse(), Ok(moment), "{text}");
        }
    }

    #[test]
    fn refuses_what_is_no_time() {
        for text in [
            "",
            "+",
            "+x",
            "NaN",
            "inf",
            "2026-13-01",
            "2026-02-30",
            "2026-11-21T25:00",
            "2026-11",
            "2026-11-21T07",
            "2026-11-21T07:43:27+x",
            "yesterday",
            "2026-11-21T07:43:27.x",
            "2026-11-21Té",
        ] {
            assert!(text.parse::<Moment>().is_err(), "{text}");
        }
    }
}
