//! The other side's clocks compared with ours, from stamps that go back and forth.
//!
//! As in NTP (RFC 5905 section 8): of four times, sent here t1, received there t2, sent there t3, received here
//! t4, the round trip is (t4 - t1) - (t3 - t2) and the other clock is ahead by ((t2 - t1) + (t3 - t4)) / 2, wrong
//! by at most half the round trip. Of the last samples the one with the shortest round trip counts. Steady clocks
//! are compared, so that setting the time does not disturb an expiry; UTC follows from the stamps.

use crate::frame::Stamp;
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, Now};

const SAMPLES: usize = 16;
/// Two crystals drift apart by less than this share of the time (crystals of such computers: 50 ppm each).
const DRIFT_PER_MILLION: u64 = 100;

/// The offset of the other side's clocks to ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockEstimate {
    /// The other UTC minus ours (µs).
    pub utc_ahead_us: i64,
    /// The estimate is wrong by at most this (µs).
    pub uncertainty_us: u64,
    /// The shortest round trip of the last samples.
    pub round_trip: Duration,
}

/// Makes stamps and learns from those received.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clocks {
    /// The last stamp received and when.
    heard: Option<(Stamp, MonoTime)>,
    samples: VecDeque<Sample>,
    last_round_trip: Option<Duration>,
}

#[derive(Debug, Clone, Copy)]
struct Sample {
    at: MonoTime,
    round_trip_us: u64,
    /// The other steady clock minus ours.
    ahead_us: i64,
    /// The other UTC minus its steady clock.
    utc_minus_mono_us: i64,
}

impl Clocks {
    /// The stamp to send at `now`.
    pub(crate) fn stamp(&self, now: Now) -> Stamp {
        let (echo, echo_received) =
            self.heard.map_or_else(Default::default, |(stamp, received)| (stamp.mono, received));
        Stamp { mono: now.mono, utc: now.utc, echo, echo_received }
    }

    /// Learns from a stamp. One that contradicts causality teaches nothing.
    pub(crate) fn heard(&mut self, now: Now, stamp: Stamp) {
        self.heard = Some((stamp, now.mono));
        let signed = |time: MonoTime| i64::try_from(time.micros()).ok();
        let (Some(sent), Some(there), Some(back), Some(here)) =
            (signed(stamp.echo), signed(stamp.echo_received), signed(stamp.mono), signed(now.mono))
        else {
            return;
        };
        let round_trip = (here - sent).checked_sub(back - there);
        let ahead = (there - sent).checked_add(back - here);
        let (Some(round_trip), Some(twice_ahead)) = (round_trip, ahead) else { return };
        if stamp.echo == MonoTime::default() || round_trip < 0 || here < sent || back < there {
            return;
        }
        if self.samples.len() == SAMPLES {
            self.samples.pop_front();
        }
        self.last_round_trip = Some(Duration::from_micros(round_trip.unsigned_abs()));
        self.samples.push_back(Sample {
            at: now.mono,
            round_trip_us: round_trip.unsigned_abs(),
            ahead_us: twice_ahead / 2,
            utc_minus_mono_us: stamp.utc.micros().saturating_sub(back),
        });
    }

    fn best(&self, now: MonoTime) -> Option<(Sample, u64)> {
        let uncertain = |sample: &Sample| sample.round_trip_us.div_ceil(2) + drift_us(now.since(sample.at));
        self.samples.iter().map(|sample| (*sample, uncertain(sample))).min_by_key(|(_, uncertain)| *uncertain)
    }

    /// The offset of the other UTC to ours.
    pub(crate) fn estimate(&self, now: Now) -> Option<ClockEstimate> {
        let (sample, uncertainty_us) = self.best(now.mono)?;
        // The newest stamp shows the other's UTC: it may have been set since the best sample.
        let latest = self.samples.back()?.utc_minus_mono_us;
        let ours = now.utc.micros().saturating_sub(now.mono.micros() as i64);
        Some(ClockEstimate {
            utc_ahead_us: latest.saturating_add(sample.ahead_us).saturating_sub(ours),
            uncertainty_us,
            round_trip: Duration::from_micros(sample.round_trip_us),
        })
    }

    /// The last round trip.
    pub(crate) fn round_trip(&self) -> Option<Duration> {
        self.last_round_trip
    }

    /// The shortest of the last round trips.
    pub(crate) fn shortest_round_trip(&self) -> Option<Duration> {
        self.samples.iter().map(|sample| sample.round_trip_us).min().map(Duration::from_micros)
    }

    /// The greatest age that something can have which the other side sent when its steady clock showed `sent`.
    /// `None` while nothing is known of that clock.
    pub(crate) fn greatest_age(&self, now: MonoTime, sent: MonoTime) -> Option<Duration> {
        let (sample, uncertainty_us) = self.best(now)?;
        let sent_here = i128::from(sent.micros()) - i128::from(sample.ahead_us) - i128::from(uncertainty_us);
        let age_us = i128::from(now.micros()) - sent_here;
        Some(Duration::from_micros(u64::try_from(age_us.max(0)).unwrap_or(u64::MAX)))
    }
}

fn drift_us(span: Duration) -> u64 {
    (span.as_micros() as u64).saturating_mul(DRIFT_PER_MILLION) / 1_000_000
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::UtcTime;

    const START_US: u64 = 1_000_000_000;

    fn now(us: u64) -> Now {
        Now {
            mono: MonoTime::from_micros(START_US + us),
            utc: UtcTime::from_micros(1_790_000_000_000_000 + us as i64),
        }
    }

    /// The other side's clocks: steady ahead by 5 s, UTC ahead by 2 s.
    fn there(us: u64) -> Now {
        let here = now(us);
        Now {
            mono: here.mono + Duration::from_secs(5),
            utc: UtcTime::from_micros(here.utc.micros() + 2_000_000),
        }
    }

    proptest! {
        #[test]
        fn offset_and_ages_are_within_their_bounds(
            trips in proptest::collection::vec((1_u64..3_000_000, 1_u64..3_000_000), 1..30),
            flight in 0_u64..5_000_000,
        ) {
            let (mut ours, mut theirs) = (Clocks::default(), Clocks::default());
            let mut at = 0;
            let shortest = trips.iter().rev().take(16).map(|(out, back)| out + back).min().unwrap();
            for (out, back) in trips {
                let stamp = ours.stamp(now(at));
                theirs.heard(there(at + out), stamp);
                let stamp = theirs.stamp(there(at + out + 700));
                at += out + 700 + back;
                ours.heard(now(at), stamp);
                at += 1_000_000;
            }
            let estimate = ours.estimate(now(at)).unwrap();
            prop_assert!(estimate.utc_ahead_us.abs_diff(2_000_000) <= estimate.uncertainty_us);
            prop_assert!(estimate.uncertainty_us < shortest / 2 + 10_000);
            let age = ours.greatest_age(now(at + flight).mono, there(at).mono).unwrap();
            prop_assert!(age >= Duration::from_micros(flight));
            prop_assert!(age <= Duration::from_micros(flight + 2 * estimate.uncertainty_us + 1_000));
        }
    }

    #[test]
    fn nonsense_teaches_nothing() {
        let mut clocks = Clocks::default();
        for stamp in [
            Stamp {
                mono: MonoTime::from_micros(u64::MAX),
                echo: MonoTime::from_micros(7),
                ..Stamp::default()
            },
            Stamp { mono: MonoTime::from_micros(1), echo: now(9_999_999).mono, ..Stamp::default() },
            Stamp::default(),
        ] {
            clocks.heard(now(1), stamp);
            assert_eq!(clocks.estimate(now(1)), None);
            assert_eq!(clocks.greatest_age(now(1).mono, MonoTime::default()), None);
        }
    }
}
