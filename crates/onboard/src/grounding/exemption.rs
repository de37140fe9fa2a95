//! An operator steers unguarded for a while, such as to a quay: requested, confirmed, and ended automatically.

use std::time::Duration;
use units::MonoTime;

/// The confirmation must come within this time of the request.
const CONFIRM: Duration = Duration::from_secs(30);

/// The result of an operator's request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// It waits for its confirmation.
    Requested,
    /// The guard is lifted.
    Granted,
    /// A confirmation without a request, of another time, or too late.
    Refused,
    /// The guard is on again.
    Ended,
    /// Nothing was requested and the guard is not lifted.
    Nothing,
}

/// Whether the guard is lifted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Exemption {
    /// When it was asked for, and for how long (s).
    request: Option<(MonoTime, f64)>,
    until: Option<MonoTime>,
}

impl Exemption {
    /// An operator asks for so many seconds; none ends it.
    pub(crate) fn request(&mut self, now: MonoTime, seconds: f64) -> Answer {
        if seconds > 0.0 {
            self.request = Some((now, seconds));
            return Answer::Requested;
        }
        self.request = None;
        if self.until.take().is_some() { Answer::Ended } else { Answer::Nothing }
    }

    /// An operator confirms a time.
    pub(crate) fn confirm(&mut self, now: MonoTime, seconds: f64) -> Answer {
        if seconds <= 0.0 {
            return Answer::Nothing;
        }
        match self.request.take() {
            // The very same number: it was typed twice, or read back.
            Some((at, wanted)) if now.since(at) <= CONFIRM && wanted.to_bits() == seconds.to_bits() => {
                self.until = Some(now + Duration::from_secs_f64(seconds));
                Answer::Granted
            }
            _ => Answer::Refused,
        }
    }

    /// Whether the guard is lifted now; reports once that the time is over.
    pub(crate) fn check(&mut self, now: MonoTime) -> (bool, Answer) {
        match self.until {
            Some(until) if now < until => (true, Answer::Nothing),
            Some(_) => {
                self.until = None;
                (false, Answer::Ended)
            }
            None => (false, Answer::Nothing),
        }
    }

    pub(crate) fn left_s(&self, now: MonoTime) -> Option<f64> {
        self.until.filter(|until| *until > now).map(|until| until.since(now).as_secs_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    #[test]
    fn only_what_is_confirmed_in_time_lifts_the_guard_and_not_for_long() {
        let mut exemption = Exemption::default();
        assert_eq!(exemption.confirm(at(1), 60.0), Answer::Refused, "nothing was asked");
        assert_eq!(exemption.request(at(2), 60.0), Answer::Requested);
        assert!(!exemption.check(at(3)).0);
        assert_eq!(exemption.confirm(at(3), 30.0), Answer::Refused, "another time");
        assert_eq!(exemption.confirm(at(3), 60.0), Answer::Refused, "a slip asks for a new request");
        exemption.request(at(4), 60.0);
        assert_eq!(exemption.confirm(at(35), 60.0), Answer::Refused, "too late");
        exemption.request(at(40), 60.0);
        assert_eq!(exemption.confirm(at(41), 60.0), Answer::Granted);
        assert_eq!(exemption.check(at(100)), (true, Answer::Nothing));
        assert_eq!(exemption.check(at(101)), (false, Answer::Ended));
        assert_eq!(exemption.check(at(102)), (false, Answer::Nothing));
        exemption.request(at(110), 60.0);
        exemption.confirm(at(111), 60.0);
        assert_eq!(exemption.request(at(112), 0.0), Answer::Ended);
        assert_eq!(exemption.left_s(at(112)), None);
    }
}
