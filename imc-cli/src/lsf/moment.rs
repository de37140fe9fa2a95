//! Points in time as people write them.

use std::str::FromStr;
use units::UtcTime;

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
            None => finite(text).or_else(|| Some(text.parse::<UtcTime>().ok()?.seconds())).map(Self::At),
        };
        moment.ok_or_else(|| {
            "expected 2026-11-21T07:43:27Z (or with an offset, +02:00), 1795247007.5 (seconds since 1970) or +30 (after the \
             log's start)"
                .to_owned()
        })
    }
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
