//! Finds packets that were here before.
//!
//! Copies come from two sides: an IMCProxy sends one copy of each telemetry packet per console, differing in
//! destination (and so in checksum), and a system that is reached by two doors is heard twice. The window is
//! bounded in number: two halves, each a set of 64-bit digests; when the younger half is full, the older one is
//! forgotten.

#![expect(clippy::disallowed_types, reason = "the sets are asked, never gone through")]

use imc::PacketView;
use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher as _};

/// Packets of each half.
const HALF: usize = 1 << 15;

/// Remembers the last 32 768 to 65 536 packets.
#[derive(Debug, Default)]
pub(crate) struct Window {
    young: HashSet<u64>,
    old: HashSet<u64>,
}

impl Window {
    /// Remembers a digest; whether it was there before.
    pub(crate) fn seen(&mut self, digest: u64) -> bool {
        if self.young.contains(&digest) || self.old.contains(&digest) {
            return true;
        }
        if self.young.len() >= HALF {
            std::mem::swap(&mut self.young, &mut self.old);
            self.young.clear();
        }
        self.young.insert(digest);
        false
    }
}

/// What makes two packets the same sample: source, entity, message, time and payload, whoever it is sent to.
/// `None` for a packet without a time, of which two may look alike and yet be two.
pub(crate) fn sample(view: &PacketView<'_>) -> Option<u64> {
    let timestamp = view.timestamp();
    if timestamp == 0.0 {
        return None;
    }
    let mut hasher = DefaultHasher::new();
    hasher.write_u64(timestamp.to_bits());
    let (source, entity) = (u64::from(view.src().0), u64::from(view.src_ent()));
    hasher.write_u64(source << 32 | entity << 16 | u64::from(view.id()));
    hasher.write(view.payload());
    Some(hasher.finish())
}

/// The digest of a sample that is sent to one destination.
pub(crate) fn delivery(sample: u64, view: &PacketView<'_>) -> u64 {
    let to = u64::from(view.dst().0) << 8 | u64::from(view.dst_ent());
    sample.rotate_left(17) ^ (to + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

#[cfg(test)]
mod tests {

    use super::*;
    use imc::{Address, Header, Packet, messages};

    fn digests(timestamp: f64, dst: u16, value: f32) -> (Option<u64>, Option<u64>) {
        let header = Header { timestamp, src: Address(0x801), dst: Address(dst), ..Header::default() };
        let bytes = Packet::new(header, messages::Voltage { value }).encode().unwrap();
        let view = PacketView::new(&bytes).unwrap();
        let sample = sample(&view);
        (sample, sample.map(|sample| delivery(sample, &view)))
    }

    #[test]
    fn a_copy_for_another_console_is_the_same_sample() {
        let (first, to_first) = digests(1.0, 0x4001, 12.0);
        let (second, to_second) = digests(1.0, 0x4002, 12.0);
        assert_eq!(first, second);
        assert_ne!(to_first, to_second);
        assert_ne!(first, digests(1.5, 0x4001, 12.0).0);
        assert_ne!(first, digests(1.0, 0x4001, 12.5).0);
        assert_eq!(digests(0.0, 0x4001, 12.0).0, None);
    }

    #[test]
    fn the_window_is_bounded() {
        let mut window = Window::default();
        for digest in 0..HALF as u64 * 5 {
            assert!(!window.seen(digest));
            assert!(window.seen(digest));
        }
        assert!(window.young.len() + window.old.len() <= 2 * HALF);
        assert!(!window.seen(0), "the oldest are forgotten");
    }
}
