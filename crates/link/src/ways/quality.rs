//! The quality of a way, measured by the acknowledgements of its messages.
//!
//! TCP hides loss: a packet that is lost comes later, after a time-out of 200 ms at least (RFC 6298 with Linux' bound). So loss
//! shows as messages that took longer than that beyond the shortest.

use std::time::Duration;

/// A lost packet is sent again after this at the earliest.
const SENT_AGAIN_AFTER: Duration = Duration::from_millis(200);
/// Messages that the share of late ones is of, about: an average that forgets.
const LATE_OVER: f64 = 50.0;
/// Before anything is known.
const FIRST_ALLOWANCE: Duration = Duration::from_millis(1200);
const LEAST_ALLOWANCE: Duration = Duration::from_millis(600);
/// The assumed rate of a way until it has carried more.
const FIRST_RATE_BYTES_PER_S: f64 = 20_000.0;
/// Smaller messages say nothing of the rate.
const TELLS_RATE_BYTES: u64 = 2048;
/// The highest rate seen decays by this share with each message that measures the rate.
const RATE_FORGET: f64 = 0.05;

/// The measured quality of a way; it outlives its connections.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Quality {
    usual: Option<Duration>,
    shortest: Option<Duration>,
    late: f64,
    rate_bytes_per_s: f64,
}

impl Quality {
    /// So many bytes were acknowledged, the last of them after `took`.
    pub(crate) fn arrived(&mut self, bytes: u64, took: Duration) {
        let shortest = self.shortest.map_or(took, |shortest| shortest.min(took));
        // A way whose delay has grown for good is accepted in the end.
        self.shortest = Some(shortest + took.saturating_sub(shortest) / 256);
        let is_late = took > shortest * 2 + SENT_AGAIN_AFTER;
        self.late += (f64::from(u8::from(is_late)) - self.late) / LATE_OVER;
        self.usual = Some(self.usual.map_or(took, |usual| (usual * 7 + took) / 8));
        if bytes >= TELLS_RATE_BYTES {
            let rate = bytes as f64 / took.as_secs_f64().max(1e-3);
            self.rate_bytes_per_s = rate.max(self.rate_bytes_per_s * (1.0 - RATE_FORGET));
        }
    }

    /// How long the answer to what is under way may take before the way is suspect.
    pub(crate) fn allowance(&self, under_way_bytes: u64) -> Duration {
        let Some(usual) = self.usual else { return FIRST_ALLOWANCE };
        let rate = self.rate_bytes_per_s.max(FIRST_RATE_BYTES_PER_S);
        let carrying = Duration::from_secs_f64(under_way_bytes as f64 / rate);
        LEAST_ALLOWANCE.max(usual * 3) + carrying
    }

    pub(crate) fn usual(&self) -> Option<Duration> {
        self.usual
    }

    pub(crate) fn late_per_mille(&self) -> u16 {
        (self.late * 1000.0).round().clamp(0.0, 1000.0) as u16
    }

    pub(crate) fn rate_bytes_per_s(&self) -> u32 {
        self.rate_bytes_per_s.min(f64::from(u32::MAX)) as u32
    }

    /// What the way costs in time (ms): each message that is late costs a second.
    pub(crate) fn cost_ms(&self) -> u32 {
        let usual = self.usual.unwrap_or(FIRST_ALLOWANCE).as_millis().min(60_000) as u32;
        usual + u32::from(self.late_per_mille())
    }

    /// Whether records may go by it: it is not lossy, and what is under way is not long under way.
    pub(crate) fn is_good(&self) -> bool {
        self.cost_ms() < 1000
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_messages_count_until_they_are_long_ago() {
        let mut quality = Quality::default();
        let ms = Duration::from_millis;
        (0..100).for_each(|_| quality.arrived(100, ms(40)));
        assert_eq!((quality.late_per_mille(), quality.is_good()), (0, true));
        (0..30).for_each(|at| quality.arrived(100, ms(if at % 3 == 0 { 400 } else { 40 })));
        assert!((100..300).contains(&quality.late_per_mille()), "{quality:?}");
        (0..300).for_each(|_| quality.arrived(100, ms(40)));
        assert_eq!(quality.late_per_mille(), 0);
        assert_eq!(quality.usual().unwrap().as_millis(), 40);
    }

    #[test]
    fn what_is_under_way_has_its_time() {
        let mut quality = Quality::default();
        assert_eq!(quality.allowance(0), FIRST_ALLOWANCE);
        quality.arrived(20_000, Duration::from_millis(100));
        assert_eq!(quality.rate_bytes_per_s(), 200_000);
        assert_eq!(quality.allowance(0), Duration::from_millis(600));
        assert_eq!(quality.allowance(100_000), Duration::from_millis(1100));
    }
}
