//! The latency of one stage of the way.

use std::time::Duration;

/// Times through one stage since they were last asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Latency {
    /// Samples.
    pub count: u64,
    /// The last.
    pub last: Duration,
    /// The longest.
    pub longest: Duration,
    /// The sum, for the mean.
    pub sum: Duration,
}

impl Latency {
    pub(crate) fn add(&mut self, sample: Duration) {
        self.count += 1;
        self.last = sample;
        self.longest = self.longest.max(sample);
        self.sum = self.sum.saturating_add(sample);
    }

    /// The mean; `None` without samples.
    pub fn mean(&self) -> Option<Duration> {
        (self.count > 0)
            .then(|| Duration::from_micros((self.sum.as_micros() / u128::from(self.count)) as u64))
    }
}
