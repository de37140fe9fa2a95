//! How much may be sent: a byte budget, and no more under way than the link carries promptly.
//!
//! Kernels and modems buffer seconds of data on a slow link, and a live value would wait in line behind all of
//! it. So the vessel watches how long its messages take until the shore says that it has them: while that is
//! close to the shortest ever seen, more may be under way; when it exceeds that by a quarter of a second, half.
//! (The idea of RFC 6817, LEDBAT, with a coarser rule.)

use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

const FIRST_LIMIT_BYTES: u64 = 32 << 10;
const LEAST_LIMIT_BYTES: u64 = 8 << 10;
const GREATEST_LIMIT_BYTES: u64 = 2 << 20;
/// More under way after a round trip without queueing.
const STEP_BYTES: u64 = 4 << 10;
/// Longer than the shortest way by this: the messages wait in a queue.
const QUEUEING: Duration = Duration::from_millis(250);
/// The budget of this time can be spent at once.
const BURST_MS: u64 = 250;
const LEAST_BURST_BYTES: i64 = 4 << 10;

/// Bytes under way and bytes to spend.
#[derive(Debug, Clone)]
pub(crate) struct Pace {
    budget_bytes_per_s: Option<u32>,
    /// Bytes to spend, in millionths; below zero after more was spent than there was.
    budget: i64,
    filled: MonoTime,
    sent: u64,
    arrived: u64,
    limit: u64,
    /// Bytes sent when a message was, and when.
    under_way: VecDeque<(u64, MonoTime)>,
    shortest: Option<Duration>,
    cut: MonoTime,
    was_cut: bool,
}

impl Pace {
    pub(crate) fn new(now: MonoTime, budget_bytes_per_s: Option<u32>) -> Self {
        let mut pace = Self {
            budget_bytes_per_s,
            budget: 0,
            filled: now,
            sent: 0,
            arrived: 0,
            limit: FIRST_LIMIT_BYTES,
            under_way: VecDeque::new(),
            shortest: None,
            cut: now,
            was_cut: false,
        };
        pace.budget = pace.most();
        pace
    }

    fn most(&self) -> i64 {
        let burst = u64::from(self.budget_bytes_per_s.unwrap_or(0)) * BURST_MS / 1000;
        (burst as i64).max(LEAST_BURST_BYTES) * 1_000_000
    }

    fn fill(&mut self, now: MonoTime) {
        let elapsed_us = now.since(self.filled).as_micros().min(3_600_000_000) as i64;
        self.filled = now;
        let rate = i64::from(self.budget_bytes_per_s.unwrap_or(0));
        self.budget = self.budget.saturating_add(elapsed_us.saturating_mul(rate)).min(self.most());
    }

    /// A message of so many bytes is sent.
    pub(crate) fn sent(&mut self, now: MonoTime, bytes: usize) {
        self.fill(now);
        self.sent += bytes as u64;
        self.budget = self.budget.saturating_sub((bytes as i64).saturating_mul(1_000_000));
        self.under_way.push_back((self.sent, now));
    }

    /// The other side has received so many bytes; answers how long the last of them took.
    pub(crate) fn arrived(&mut self, now: MonoTime, bytes: u64) -> Option<Duration> {
        let fresh = bytes.min(self.sent).saturating_sub(self.arrived);
        let was_busy = self.under_way() * 2 >= self.limit;
        self.arrived += fresh;
        let mut took = None;
        while let Some((_, at)) = self.under_way.pop_front_if(|(sent, _)| *sent <= self.arrived) {
            took = Some(now.since(at));
        }
        let took = took?;
        let shortest = self.shortest.map_or(took, |shortest| shortest.min(took));
        self.shortest = Some(shortest);
        if took > shortest + QUEUEING {
            // Messages sent before the last cut say nothing about the limit after it.
            if now.since(self.cut) > took {
                (self.cut, self.was_cut) = (now, true);
                self.limit = (self.limit / 2).max(LEAST_LIMIT_BYTES);
            }
        } else if was_busy {
            // Fast until the link's size was met once, then a little for every round trip.
            let more = if self.was_cut { fresh * STEP_BYTES / self.limit } else { fresh / 2 };
            self.limit = (self.limit + more).min(GREATEST_LIMIT_BYTES);
        }
        Some(took)
    }

    /// When the oldest message that is under way was sent.
    pub(crate) fn oldest(&self) -> Option<MonoTime> {
        self.under_way.front().map(|(_, at)| *at)
    }

    /// Bytes that have arrived.
    pub(crate) fn arrived_bytes(&self) -> u64 {
        self.arrived
    }

    pub(crate) fn under_way(&self) -> u64 {
        self.sent - self.arrived
    }

    /// Bytes that may be sent on top of those under way.
    pub(crate) fn room(&self) -> usize {
        self.limit.saturating_sub(self.under_way()) as usize
    }

    /// When the budget allows the next record; `now` or earlier for at once.
    pub(crate) fn affordable(&mut self, now: MonoTime) -> MonoTime {
        self.fill(now);
        match self.budget_bytes_per_s {
            Some(rate) if self.budget <= 0 => {
                let wait_us = self.budget.unsigned_abs() / u64::from(rate.max(1)) + 1;
                now + Duration::from_micros(wait_us)
            }
            _ => now,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::default() + Duration::from_millis(ms)
    }

    #[test]
    fn a_budget_is_kept_over_time() {
        let mut pace = Pace::new(at(0), Some(10_000));
        let mut sent = 0;
        for ms in 0..60_000 {
            if pace.affordable(at(ms)) <= at(ms) {
                pace.sent(at(ms), 1_500);
                sent += 1_500;
            }
        }
        assert!((600_000..=606_000).contains(&sent), "{sent}");
    }

    #[test]
    fn a_budget_in_debt_says_when_it_is_not() {
        let mut pace = Pace::new(at(0), Some(1_000));
        pace.sent(at(0), 14_096);
        let due = pace.affordable(at(0));
        assert!(due >= at(10_000) && due <= at(10_010), "{due:?}");
        assert!(pace.affordable(due) <= due);
    }

    /// A link of `rate` bytes a second with 50 ms each way carries full messages; answers the longest time that
    /// one took after the first ten seconds, and the bytes carried.
    fn carry(rate: u64) -> (Duration, u64) {
        let mut pace = Pace::new(at(0), None);
        let (mut queue, mut carried, mut longest) = (VecDeque::new(), 0, Duration::ZERO);
        let mut free_at = 0;
        for ms in 0..60_000_u64 {
            while pace.room() >= 1_000 {
                pace.sent(at(ms), 1_000);
                free_at = free_at.max(ms * 1000) + 1_000_000_000 / rate;
                carried += 1_000;
                queue.push_back((free_at + 100_000, carried));
            }
            while let Some((_, bytes)) = queue.pop_front_if(|(due_us, _)| *due_us <= ms * 1000) {
                let took = pace.arrived(at(ms), bytes);
                longest = longest.max(took.filter(|_| ms > 10_000).unwrap_or_default());
            }
        }
        (longest, carried)
    }

    #[test]
    fn what_is_under_way_fits_the_link() {
        for rate in [20_000, 100_000, 1_000_000] {
            let (longest, carried) = carry(rate);
            assert!(longest < Duration::from_millis(600), "{rate}: {longest:?}");
            assert!(carried > rate * 60 * 8 / 10, "{rate}: {carried}");
        }
    }
}
