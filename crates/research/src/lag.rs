//! How far the nearest other detection of the same tag by the same receiver is (`min_lag` of the format of GLATOS), found while
//! detections go by.
//!
//! A detection that nothing else confirms may be false: two trains of pulses that overlap can look like a third tag. The
//! usual rule (Pincock 2012) doubts one whose nearest neighbour is more than 30 ping intervals away. To know the next one, a
//! detection waits until that comes, or until it is known to be more than a day away, which is beyond the rule for any interval
//! up to 48 minutes. What waits is bounded.

use detections::{Detection, Maker, Protocol};
use std::collections::{BTreeMap, VecDeque};

/// A neighbour is searched for within this time (s).
pub const HORIZON_S: i64 = 86_400;
/// Detections that may wait; with more, the oldest goes without knowing.
const WAITING: usize = 50_000;
/// Tags by receivers that are remembered before those of long ago are forgotten.
const REMEMBERED: usize = 20_000;

/// How far the nearest other detection is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lag {
    /// So many seconds.
    Seconds(f64),
    /// No other detection within [`HORIZON_S`].
    Nothing,
    /// Not computed, or too many waited to know it.
    Unknown,
}

impl Lag {
    /// Seconds, where there is one.
    pub fn seconds(self) -> Option<f64> {
        if let Self::Seconds(lag_s) = self { Some(lag_s) } else { None }
    }
}

/// Receiver, protocol, number, carrier.
type Key = ((u32, Option<Maker>), Protocol, u32, Option<u8>);

/// Detections on their way. They come in order of report, by which it is known what still can come; how far two are apart is
/// given by the receiver's clock, which may be days off.
#[derive(Debug, Default)]
pub struct Lags {
    waiting: VecDeque<Waiting>,
    /// How many have gone.
    gone: u64,
    /// Of each tag by each receiver the last detection.
    last: BTreeMap<Key, Last>,
    /// When the newest was reported.
    newest_us: i64,
}

#[derive(Debug)]
struct Last {
    /// Counted from the first of all.
    place: u64,
    /// By the receiver's clock, where that was set.
    time_us: i64,
    reported_us: i64,
}

#[derive(Debug)]
struct Waiting {
    detection: Detection,
    lag_us: Option<i64>,
    /// Whether the one after it has come.
    is_settled: bool,
}

impl Lags {
    /// Takes the next detection, in order of report.
    pub fn push(&mut self, detection: Detection) {
        let time_us = detection.clock.utc().unwrap_or(detection.origin.reported).micros();
        let place = self.gone + self.waiting.len() as u64;
        let receiver = (detection.receiver, detection.maker);
        let key = (receiver, detection.protocol.clone(), detection.tag_id, detection.frequency_khz);
        let reported_us = detection.origin.reported.micros();
        let before = self.last.insert(key, Last { place, time_us, reported_us });
        let lag_us = before.as_ref().map(|before| time_us.saturating_sub(before.time_us).saturating_abs());
        if let Some(before) = before
            && let Some(one) =
                before.place.checked_sub(self.gone).and_then(|at| self.waiting.get_mut(at as usize))
        {
            one.lag_us = [one.lag_us, lag_us].into_iter().flatten().min();
            one.is_settled = true;
        }
        self.newest_us = self.newest_us.max(reported_us);
        self.waiting.push_back(Waiting { detection, lag_us, is_settled: false });
        if self.last.len() > REMEMBERED {
            let from_us = self.newest_us - HORIZON_S * 1_000_000;
            self.last.retain(|_, last| last.reported_us >= from_us);
        }
    }

    /// The oldest detection of which all is known that will be, with seconds to its nearest neighbour; `None` while it is not.
    pub fn pop(&mut self) -> Option<(Detection, Lag)> {
        let oldest = self.waiting.front()?;
        let waited_us = self.newest_us.saturating_sub(oldest.detection.origin.reported.micros());
        if oldest.is_settled || waited_us > HORIZON_S * 1_000_000 {
            self.take()
        } else if self.waiting.len() > WAITING {
            self.take().map(|(detection, _)| (detection, Lag::Unknown))
        } else {
            None
        }
    }

    /// The oldest detection, once no other comes.
    pub fn take(&mut self) -> Option<(Detection, Lag)> {
        let Waiting { detection, lag_us, .. } = self.waiting.pop_front()?;
        self.gone += 1;
        let known = lag_us.filter(|lag_us| *lag_us <= HORIZON_S * 1_000_000);
        Some((detection, known.map_or(Lag::Nothing, |lag_us| Lag::Seconds(lag_us as f64 / 1e6))))
    }
}
