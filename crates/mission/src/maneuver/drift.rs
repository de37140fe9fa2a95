//! How a vessel drifts while its motors are off, learnt from its own positions.
//!
//! Mean velocity between two positions of one rest, at least [`LEAST`] apart and not of its first
//! [`SETTLING`], in which the vessel loses its way. Of a long rest only its latest [`WINDOW`] to twice that
//! counts, so that a change of the wind is learnt.

use std::time::Duration;
use units::{LocalPoint, MonoTime};

/// The vessel still runs on for so long.
const SETTLING: Duration = Duration::from_secs(8);
/// Less time lets the noise of positions count as drift.
const LEAST: Duration = Duration::from_secs(20);
/// A window after which another begins.
const WINDOW: Duration = Duration::from_mins(1);
/// Slower is not drift but the slow error of the receiver (m/s).
const LEAST_MPS: f64 = 0.01;

type Mark = (MonoTime, LocalPoint);

/// The drift of a vessel; stays known while the motors are on.
#[derive(Debug, Clone, Default)]
pub(super) struct Drift {
    rest_since: Option<MonoTime>,
    /// Beginning of the window, and of the previous one.
    marks: [Option<Mark>; 2],
    velocity_mps: Option<(f64, f64)>,
}

impl Drift {
    /// The motors were stopped.
    pub(super) fn begin(&mut self, now: MonoTime) {
        self.rest_since = Some(now);
        self.marks = [None; 2];
    }

    /// Where the vessel is, in any frame that stays, while the motors are off.
    pub(super) fn at(&mut self, now: MonoTime, here: LocalPoint) {
        if self.rest_since.is_none_or(|since| now.since(since) < SETTLING) {
            return;
        }
        let [window, before] = &mut self.marks;
        let (began, _) = *window.get_or_insert((now, here));
        if now.since(began) >= WINDOW {
            *before = window.replace((now, here));
        }
        if let Some((then, there)) = before.or(*window)
            && now.since(then) >= LEAST
        {
            let elapsed_s = now.since(then).as_secs_f64();
            self.velocity_mps =
                Some(((here.north_m - there.north_m) / elapsed_s, (here.east_m - there.east_m) / elapsed_s));
        }
    }

    /// North and east (m/s), where known and no mere error of positions.
    pub(super) fn velocity(&self) -> Option<(f64, f64)> {
        self.velocity_mps.filter(|(north_mps, east_mps)| north_mps.hypot(*east_mps) >= LEAST_MPS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sail(drift: &mut Drift, from_s: u64, to_s: u64, north_m: impl Fn(f64) -> f64) {
        for second in from_s..=to_s {
            let here = LocalPoint { north_m: north_m(second as f64), east_m: 0.0 };
            drift.at(MonoTime::from_micros(second * 1_000_000), here);
        }
    }

    fn north_mps(drift: &Drift) -> Option<f64> {
        drift.velocity().map(|(north_mps, _)| (north_mps * 1e6).round() / 1e6)
    }

    #[test]
    fn is_known_after_a_while_and_stays_known_under_way() {
        let mut drift = Drift::default();
        drift.begin(MonoTime::from_micros(0));
        // It runs on at 1 m/s while it settles.
        sail(&mut drift, 0, 27, |s| if s < 8.0 { s } else { 8.0 + 0.1 * (s - 8.0) });
        assert_eq!(north_mps(&drift), None);
        sail(&mut drift, 28, 28, |s| 8.0 + 0.1 * (s - 8.0));
        assert_eq!(north_mps(&drift), Some(0.1));
        drift.begin(MonoTime::from_micros(60_000_000));
        sail(&mut drift, 61, 70, |s| s);
        assert_eq!(north_mps(&drift), Some(0.1));
    }

    #[test]
    fn forgets_what_was_long_ago() {
        let mut drift = Drift::default();
        drift.begin(MonoTime::from_micros(0));
        sail(&mut drift, 0, 300, |s| 0.1 * s);
        sail(&mut drift, 301, 450, |s| 30.0 - 0.1 * (s - 300.0));
        assert_eq!(north_mps(&drift), Some(-0.1));
    }

    #[test]
    fn what_is_as_slow_as_a_receivers_error_is_none() {
        let mut drift = Drift::default();
        drift.begin(MonoTime::from_micros(0));
        sail(&mut drift, 0, 100, |s| 0.005 * s);
        assert_eq!(north_mps(&drift), None);
    }
}
