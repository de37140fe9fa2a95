//! Finds a time in a log, without reading all of it again.

use crate::deframe::Frame;
use std::ops::Range;

/// For each stretch of a log, the times in it.
///
/// Times in a log step back, so a stretch has a range of times and the ranges overlap. The answer of
/// [`Index::bytes_between`] holds every packet of the span asked for and some beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Index {
    stretches: Vec<Stretch>,
    stretch_bytes: u64,
    end: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    offset: u64,
    earliest_s: f64,
    latest_s: f64,
}

impl Default for Index {
    fn default() -> Self {
        Self::new(Self::STRETCH_BYTES)
    }
}

impl Index {
    /// Bytes of a stretch unless asked otherwise: about five seconds of a busy vehicle, 24 bytes of index.
    pub const STRETCH_BYTES: u64 = 1 << 16;

    /// An empty index with stretches of about `stretch_bytes`.
    pub fn new(stretch_bytes: u64) -> Self {
        Self { stretches: Vec::new(), stretch_bytes: stretch_bytes.max(1), end: 0 }
    }

    /// Takes note of the next item in the log. Damage and packets without a time only move the end.
    pub fn add(&mut self, frame: &Frame<'_>) {
        let (offset, bytes, time_s) = match frame {
            Frame::Packet { offset, view } => (*offset, view.bytes().len() as u64, view.timestamp()),
            Frame::Damage(damage) => (damage.offset, damage.bytes, f64::NAN),
        };
        self.end = offset + bytes;
        if time_s.is_nan() {
            return;
        }
        match self.stretches.last_mut() {
            Some(last) if offset - last.offset < self.stretch_bytes => {
                last.earliest_s = last.earliest_s.min(time_s);
                last.latest_s = last.latest_s.max(time_s);
            }
            _ => self.stretches.push(Stretch { offset, earliest_s: time_s, latest_s: time_s }),
        }
    }

    /// Earliest and latest time in the log, in seconds since 1970-01-01; `None` for an empty log.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        let earliest = self.stretches.iter().map(|stretch| stretch.earliest_s).reduce(f64::min)?;
        let latest = self.stretches.iter().map(|stretch| stretch.latest_s).reduce(f64::max)?;
        Some((earliest, latest))
    }

    /// Bytes of the log that hold every packet from `from_s` to `to_s` (seconds since 1970-01-01, both
    /// included). The range starts and ends between two packets and is empty when there are none.
    pub fn bytes_between(&self, from_s: f64, to_s: f64) -> Range<u64> {
        let first = self.stretches.iter().position(|stretch| stretch.latest_s >= from_s);
        let last = self.stretches.iter().rposition(|stretch| stretch.earliest_s <= to_s);
        match (first, last) {
            (Some(first), Some(last)) if first <= last => {
                let end = self.stretches.get(last + 1).map_or(self.end, |next| next.offset);
                self.stretches[first].offset..end
            }
            _ => 0..0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frames, Header, Packet, messages::Heartbeat};
    use proptest::prelude::*;

    fn log(times: &[f64]) -> Vec<u8> {
        let packet = |&timestamp| Packet::new(Header { timestamp, ..Header::default() }, Heartbeat);
        times.iter().flat_map(|time| packet(time).encode().unwrap()).collect()
    }

    proptest! {
        #[test]
        fn no_packet_of_the_span_is_outside_the_range(
            times in proptest::collection::vec(0.0..100.0_f64, 0..60),
            (a, b) in (0.0..100.0_f64, 0.0..100.0_f64),
            stretch in 1_u64..200,
        ) {
            let bytes = log(&times);
            let mut index = Index::new(stretch);
            Frames::new(&bytes).for_each(|frame| index.add(&frame));
            let (from, to) = (a.min(b), a.max(b));
            let range = index.bytes_between(from, to);
            for (at, time) in times.iter().enumerate() {
                let offset = at as u64 * 22;
                prop_assert!(!(from..=to).contains(time) || range.contains(&offset));
            }
            prop_assert!(range.start.is_multiple_of(22) && range.end.is_multiple_of(22));
        }
    }

    #[test]
    fn an_empty_log_has_no_span() {
        assert_eq!(Index::default().span_s(), None);
        assert_eq!(Index::default().bytes_between(0.0, 1e10), 0..0);
    }
}
