//! Finds copies of packets.
//!
//! Copies come from two sides: an IMCProxy sends one copy of each telemetry packet per console, differing in
//! destination (and so in checksum), and a system that is reached by two transports is heard twice. The window is
//! bounded in number: two halves, each a set of 64-bit digests; when the younger half is full, the older one is
//! forgotten.
//!
//! A command that is sent again is a new command, never a copy, unless the vessel echoes it. [`Repeats`]
//! distinguishes the two.

#![expect(clippy::disallowed_types, reason = "the sets are asked, never gone through")]

use crate::peer::PeerId;
use imc::PacketView;
use std::collections::{BTreeMap, HashSet};
use std::hash::{DefaultHasher, Hasher as _};
use std::time::Duration;
use units::MonoTime;

/// Packets of each half.
const HALF: usize = 1 << 15;

/// A copy by another way comes within this; the same bytes later are a repetition.
const COPY_WITHIN: Duration = Duration::from_secs(2);
/// The same bytes may be sent so often without a pause of [`COPY_WITHIN`]. Beyond that they circulate between relays.
const IN_A_ROW: u32 = 20;
/// An Abort is passed on for as long as it is sent, but not faster than this once it was sent five times.
const ABORT_EVERY: Duration = Duration::from_millis(200);
const ABORTS_AT_ONCE: u32 = 5;
/// Commands that are remembered. Beyond that the oldest is forgotten, and passes if a copy comes.
const COMMANDS: usize = 1_024;

/// Remembers the last 32 768 to 65 536 packets.
#[derive(Debug, Default)]
pub(crate) struct Window {
    young: HashSet<u64>,
    old: HashSet<u64>,
}

impl Window {
    /// Whether a digest is remembered.
    pub(crate) fn contains(&self, digest: u64) -> bool {
        self.young.contains(&digest) || self.old.contains(&digest)
    }

    /// Remembers a digest; whether it was there before.
    pub(crate) fn seen(&mut self, digest: u64) -> bool {
        if self.contains(digest) {
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

/// The commands of the last seconds, by their digests.
#[derive(Debug, Default)]
pub(crate) struct Repeats(BTreeMap<u64, PassedOn>);

/// A command that was sent.
#[derive(Debug)]
struct PassedOn {
    by: PeerId,
    last: MonoTime,
    passed: u32,
    passed_at: MonoTime,
}

impl Repeats {
    /// The peers that sent this command within the last seconds.
    pub(crate) fn speaker(&self, digest: u64) -> Option<PeerId> {
        self.0.get(&digest).map(|said| said.by)
    }

    /// Whether a command is passed on: it came for the first time, or again from its first sender. `by_another` says
    /// that it is the copy of one that another peer, which is still connected, sent.
    pub(crate) fn passes(
        &mut self,
        now: MonoTime,
        digest: u64,
        by: PeerId,
        by_another: bool,
        is_abort: bool,
    ) -> bool {
        if let Some(said) = self.0.get_mut(&digest).filter(|said| now.since(said.last) < COPY_WITHIN) {
            if by_another {
                return false;
            }
            (said.by, said.last) = (by, now);
            let passes = if is_abort {
                said.passed < ABORTS_AT_ONCE || now.since(said.passed_at) >= ABORT_EVERY
            } else {
                said.passed < IN_A_ROW
            };
            if passes {
                (said.passed, said.passed_at) = (said.passed.saturating_add(1), now);
            }
            return passes;
        }
        if self.0.len() >= COMMANDS {
            self.0.retain(|_, said| now.since(said.last) < COPY_WITHIN);
        }
        if self.0.len() >= COMMANDS {
            let oldest = self.0.iter().min_by_key(|(_, said)| said.last).map(|(digest, _)| *digest);
            oldest.map(|digest| self.0.remove(&digest));
        }
        self.0.insert(digest, PassedOn { by, last: now, passed: 1, passed_at: now });
        true
    }
}

/// What makes two packets the same sample: source, entity, message, time and payload, whatever its destination.
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
    fn commands_are_remembered_within_bounds_and_an_abort_is_held_to_a_pace_only() {
        let mut repeats = Repeats::default();
        let at = |ms: u64| MonoTime::from_micros(ms * 1_000);
        for digest in 0..5 * COMMANDS as u64 {
            assert!(repeats.passes(at(0), digest, PeerId(1), false, false));
            assert!(repeats.0.len() <= COMMANDS);
        }
        let mut repeats = Repeats::default();
        let every_50_ms =
            (0..1_200).filter(|n| repeats.passes(at(n * 50), 7, PeerId(1), false, true)).count();
        assert!((300..310).contains(&every_50_ms), "five a second for a minute: {every_50_ms}");
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
