//! When to try again: soon after no answer, at growing intervals after a refusal.
//!
//! A link that comes back must be noticed within a second, and an unanswered attempt costs a hundred bytes, so
//! those pauses end at 1 s. A refusal will not heal in a second: those pauses end at 15 s. Every pause is between
//! half of its length and all of it, by chance, so that a fleet does not come back as one.

use std::time::Duration;

const UNANSWERED: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(1));
const REFUSED: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(15));
const DOUBLINGS: u32 = 6;

/// Pauses between attempts.
#[derive(Debug, Clone)]
pub(crate) struct Backoff {
    chance: u64,
    unanswered: u32,
    refused: u32,
}

impl Backoff {
    pub(crate) fn new(seed: u64) -> Self {
        Self { chance: seed | 1, unanswered: 0, refused: 0 }
    }

    /// The connection is open.
    pub(crate) fn succeeded(&mut self) {
        (self.unanswered, self.refused) = (0, 0);
    }

    /// The pause after an attempt without an answer, or after a connection broke.
    pub(crate) fn unanswered(&mut self) -> Duration {
        self.unanswered = (self.unanswered + 1).min(DOUBLINGS);
        self.pause(UNANSWERED, self.unanswered)
    }

    /// The pause after a refusal.
    pub(crate) fn refused(&mut self) -> Duration {
        self.refused = (self.refused + 1).min(DOUBLINGS);
        self.pause(REFUSED, self.refused)
    }

    fn pause(&mut self, (first, longest): (Duration, Duration), times: u32) -> Duration {
        // xorshift64 (Marsaglia 2003): enough to spread a fleet.
        self.chance ^= self.chance << 13;
        self.chance ^= self.chance >> 7;
        self.chance ^= self.chance << 17;
        let whole = (first * (1 << (times - 1))).min(longest);
        whole / 2 + (whole / 2).mul_f64((self.chance >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_to_their_bound_and_differ() {
        let (mut a, mut b) = (Backoff::new(1), Backoff::new(77));
        let refused: Vec<Duration> = (0..40).map(|_| a.refused()).collect();
        assert!(refused[0] >= Duration::from_millis(500) && refused[0] <= Duration::from_secs(1));
        assert!(refused[10..].iter().all(|d| *d >= REFUSED.1 / 2 && *d <= REFUSED.1));
        assert!(refused.iter().any(|pause| *pause != b.refused()));
        assert!((0..40).all(|_| a.unanswered() <= UNANSWERED.1));
        a.succeeded();
        assert!(a.refused() <= REFUSED.0);
    }
}
