//! Fingerprints by which the same message is recognised.

use imc::PacketView;
use siphasher::sip::SipHasher13;
use std::hash::Hasher as _;

/// Bits of a payload's fingerprint: six bytes in a database's row.
const PAYLOAD_BITS: u32 = 48;
/// Sets of the window of repeats.
const SETS: usize = 1 << 13;
/// Fingerprints that a set holds.
const WAYS: usize = 8;

/// The last part of a row's key: distinguishes messages of one entity and kind in one microsecond.
///
/// SipHash-1-3 with a zero key (Aumasson and Bernstein 2012), the low 48 bits. It is stored on disk and must not
/// change.
pub(crate) fn of_payload(payload: &[u8]) -> i64 {
    (SipHasher13::new().hash(payload) & ((1 << PAYLOAD_BITS) - 1)) as i64
}

/// The fields that copies of one message for several receivers have in common: all but the destination.
fn of_message(view: &PacketView<'_>) -> u64 {
    let mut hasher = SipHasher13::new();
    hasher.write_u16(view.id());
    hasher.write_u16(view.src().0);
    hasher.write_u8(view.src_ent());
    hasher.write_u64(view.timestamp().to_bits());
    hasher.write(view.payload());
    hasher.finish()
}

/// The last 65,536 messages or so, to know copies by.
///
/// Of constant size: a message goes into one of 8192 sets by its fingerprint and pushes out the oldest of the
/// eight there. A copy that comes later than that is archived once more; the history knows it all the same.
#[derive(Debug)]
pub(crate) struct RepeatWindow {
    prints: Vec<[u64; WAYS]>,
    next: Vec<u8>,
}

impl RepeatWindow {
    pub(crate) fn new() -> Self {
        Self { prints: vec![[0; WAYS]; SETS], next: vec![0; SETS] }
    }

    /// Remembers the message; true when it was there already.
    pub(crate) fn repeats(&mut self, view: &PacketView<'_>) -> bool {
        // Zero marks an empty place.
        let print = of_message(view) | 1;
        let set = (print >> 32) as usize % SETS;
        if self.prints[set].contains(&print) {
            return true;
        }
        let place = &mut self.next[set];
        self.prints[set][usize::from(*place)] = print;
        *place = (*place + 1) % WAYS as u8;
        false
    }
}
