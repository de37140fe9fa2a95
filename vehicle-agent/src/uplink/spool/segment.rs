//! One file of the spool: a header, then entries, each with its length and a CRC-32 of its body.
//!
//! | bytes | header |
//! |---|---|
//! | 8 | `LUSPOOL1` |
//! | 1 | what was thinned out of it, see [`Level`] |
//! | 7 | zero |
//! | 8 | number of the first entry |
//! | 8 | number after the last entry where it was thinned out, else zero: the next file tells |
//!
//! | bytes | entry |
//! |---|---|
//! | 4 | length of the body |
//! | 4 | CRC-32 (IEEE 802.3) of the body |
//! | 1 | 1 packet, 2 gap, 3 packet that is kept longest |
//! | 8 | number |
//! | rest | packet: time recorded i64 (µs), its bytes; gap: number after it u64, times i64 i64, reason u8 |
//!
//! Numbers are little-endian.

use bytes::Bytes;
use link::{Gap, GapReason, Record};
use units::UtcTime;

pub(crate) const HEADER_BYTES: usize = 32;
/// Bytes before an entry's body.
const FRAME_BYTES: usize = 8;
const MAGIC: &[u8; 8] = b"LUSPOOL1";
const LEAST_BODY_BYTES: usize = 17;
pub(crate) const MOST_ENTRY_BYTES: usize = FRAME_BYTES + LEAST_BODY_BYTES + imc::MAX_PACKET_BYTES;

/// Whether a file begins like those of a later version: the same magic with a higher digit.
pub(crate) fn is_newer(begin: &[u8]) -> bool {
    let Some((word, digit)) =
        begin.first_chunk::<8>().and_then(|begin| begin.split_last()).map(|(d, w)| (w, *d))
    else {
        return false;
    };
    word == &MAGIC[..7] && digit.is_ascii_digit() && digit > MAGIC[7]
}

/// What a file still has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    /// Everything.
    Whole,
    /// Only the packets that are kept longest.
    Important,
    /// Only the gap.
    Nothing,
}

/// A file's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) level: Level,
    pub(crate) first: u64,
    /// Known only where the file was thinned out.
    pub(crate) end: Option<u64>,
}

impl Header {
    pub(crate) fn to_bytes(self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        bytes[..8].copy_from_slice(MAGIC);
        bytes[8] = self.level as u8;
        bytes[16..24].copy_from_slice(&self.first.to_le_bytes());
        bytes[24..].copy_from_slice(&self.end.unwrap_or(0).to_le_bytes());
        bytes
    }

    /// `None` if it is not a header.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; HEADER_BYTES] = bytes.first_chunk()?;
        let level = match (bytes.starts_with(MAGIC), bytes[8]) {
            (true, 0) => Level::Whole,
            (true, 1) => Level::Important,
            (true, 2) => Level::Nothing,
            _ => return None,
        };
        let (first, end) = (u64_at(bytes, 16), u64_at(bytes, 24));
        Some(Self { level, first, end: (end > first).then_some(end) })
    }
}

/// An entry of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Item {
    /// A packet, and whether it is kept longest.
    Record(Record, bool),
    /// Numbers without packets.
    Gap(Gap),
}

impl Item {
    pub(crate) fn end(&self) -> u64 {
        match self {
            Self::Record(record, _) => record.seq.saturating_add(1),
            Self::Gap(gap) => gap.to,
        }
    }
}

/// Appends a packet's entry.
pub(crate) fn put_record(out: &mut Vec<u8>, seq: u64, recorded: UtcTime, packet: &[u8], important: bool) {
    put(out, if important { 3 } else { 1 }, seq, |out| {
        out.extend_from_slice(&recorded.micros().to_le_bytes());
        out.extend_from_slice(packet);
    });
}

/// Appends a gap's entry.
pub(crate) fn put_gap(out: &mut Vec<u8>, gap: &Gap) {
    put(out, 2, gap.from, |out| {
        out.extend_from_slice(&gap.to.to_le_bytes());
        out.extend_from_slice(&gap.since.micros().to_le_bytes());
        out.extend_from_slice(&gap.until.micros().to_le_bytes());
        out.push(gap.reason.code());
    });
}

/// Appends an entry again.
pub(crate) fn put_item(out: &mut Vec<u8>, item: &Item) {
    match item {
        Item::Record(record, important) => {
            put_record(out, record.seq, record.recorded, &record.packet, *important);
        }
        Item::Gap(gap) => put_gap(out, gap),
    }
}

fn put(out: &mut Vec<u8>, kind: u8, seq: u64, rest: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&[0; FRAME_BYTES]);
    out.push(kind);
    out.extend_from_slice(&seq.to_le_bytes());
    rest(out);
    let body = &out[start + FRAME_BYTES..];
    // A packet has at most 65 557 bytes.
    let (length, crc) = (body.len() as u32, crc32fast::hash(body));
    out[start..start + 4].copy_from_slice(&length.to_le_bytes());
    out[start + 4..start + 8].copy_from_slice(&crc.to_le_bytes());
}

/// The entry that the bytes begin with, and its length. `None` when it is cut or damaged.
pub(crate) fn take(bytes: &Bytes) -> Option<(Item, usize)> {
    let frame: &[u8; FRAME_BYTES] = bytes.first_chunk()?;
    let length = u32::from_le_bytes([frame[0], frame[1], frame[2], frame[3]]) as usize;
    let crc = u32::from_le_bytes([frame[4], frame[5], frame[6], frame[7]]);
    if !(LEAST_BODY_BYTES..=MOST_ENTRY_BYTES - FRAME_BYTES).contains(&length) {
        return None;
    }
    let end = FRAME_BYTES + length;
    let body = bytes.get(FRAME_BYTES..end)?;
    if crc32fast::hash(body) != crc {
        return None;
    }
    let seq = u64_at(body, 1);
    let item = match body[0] {
        kind @ (1 | 3) => {
            let recorded = UtcTime::from_micros(u64_at(body, 9) as i64);
            let packet = bytes.slice(FRAME_BYTES + LEAST_BODY_BYTES..end);
            Item::Record(Record { seq, recorded, packet }, kind == 3)
        }
        2 if length == 34 => Item::Gap(Gap {
            from: seq,
            to: u64_at(body, 9),
            since: UtcTime::from_micros(u64_at(body, 17) as i64),
            until: UtcTime::from_micros(u64_at(body, 25) as i64),
            reason: GapReason::from_code(body[33]),
        }),
        _ => return None,
    };
    (item.end() > seq).then_some((item, end))
}

/// The eight bytes from `at` on, which the caller knows to be there.
fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let mut number = [0; 8];
    number.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_return_and_any_damage_is_seen() {
        let time = UtcTime::from_micros(1_790_000_000_000_000);
        let gap = Gap { from: 8, to: 11, since: time, until: time, reason: GapReason::SpoolFull };
        let record = Record { seq: 7, recorded: time, packet: Bytes::from_static(b"a packet") };
        for item in [Item::Record(record.clone(), true), Item::Record(record, false), Item::Gap(gap)] {
            let mut out = Vec::new();
            put_item(&mut out, &item);
            let bytes = Bytes::from(out);
            assert_eq!(take(&bytes), Some((item, bytes.len())));
            for at in 0..bytes.len() {
                assert_eq!(take(&bytes.slice(..at)), None);
                let mut damaged = bytes.to_vec();
                damaged[at] ^= 0x10;
                assert_eq!(take(&damaged.into()), None);
            }
        }
    }
}
