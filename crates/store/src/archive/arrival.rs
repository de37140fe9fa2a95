//! The records of a day's `Arrivals.idx`, one for each packet of the `Data.lsf` beside it.
//!
//! | offset | bytes | field, little-endian |
//! |---|---|---|
//! | 0 | 6 | offset of the packet in `Data.lsf` |
//! | 6 | 1 | bits 0-3 transport, bit 5 has a link number, bit 6 first of its stream, bit 7 jump |
//! | 7 | 7 | arrival, microseconds since 1970-01-01 UTC |
//! | 14 | 8 | number in the stream |
//! | 22 | 8 | stream |
//! | 30 | 2 | CRC-16 of the 30 bytes before, inverted, so that zeros are not a record |
//!
//! A packet follows in its stream the one whose number is one less. Where numbers were left out, a jump record
//! with the same offset precedes it and gives the number of the packet before. So the archive itself shows
//! up to which number nothing is missing.

use link::{LinkSeq, Transport};
use units::UtcTime;

/// Bytes of a record.
pub(crate) const ARRIVAL_BYTES: usize = 32;
const CHECKED_BYTES: usize = 30;
const HAS_LINK: u8 = 1 << 5;
const FIRST: u8 = 1 << 6;
const JUMP: u8 = 1 << 7;

/// One record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Record {
    /// A packet's.
    Packet(Arrival),
    /// The predecessor in the stream of the packet that follows.
    Jump {
        /// The packet's place in `Data.lsf`.
        offset: u64,
        /// The packet before.
        after: LinkSeq,
    },
}

/// How and when a packet came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// Its first byte in `Data.lsf`.
    pub offset: u64,
    /// When it came, by the shore's clock.
    pub received: UtcTime,
    /// How it came.
    pub transport: Transport,
    /// Its place in a vessel's record lane.
    pub link: Option<LinkSeq>,
    /// Whether it is the first in its stream.
    pub(crate) first: bool,
}

impl Record {
    pub(crate) fn offset(&self) -> u64 {
        match self {
            Self::Packet(arrival) => arrival.offset,
            Self::Jump { offset, .. } => *offset,
        }
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        let start = out.len();
        let (flags, received_us, link) = match self {
            Self::Packet(arrival) => {
                let link = if arrival.link.is_some() { HAS_LINK } else { 0 };
                let first = if arrival.first { FIRST } else { 0 };
                (arrival.transport as u8 | link | first, arrival.received.micros(), arrival.link)
            }
            Self::Jump { after, .. } => (JUMP, 0, Some(*after)),
        };
        out.extend_from_slice(&self.offset().to_le_bytes()[..6]);
        out.push(flags);
        out.extend_from_slice(&received_us.to_le_bytes()[..7]);
        let link = link.unwrap_or(LinkSeq { stream: 0, seq: 0 });
        out.extend_from_slice(&link.seq.to_le_bytes());
        out.extend_from_slice(&link.stream.to_le_bytes());
        let crc = !imc::crc16(&out[start..]);
        out.extend_from_slice(&crc.to_le_bytes());
    }

    /// `None` when the bytes are not a record.
    pub(crate) fn read(bytes: &[u8; ARRIVAL_BYTES]) -> Option<Self> {
        let number = |range: std::ops::Range<usize>| {
            let mut le = [0; 8];
            le[..range.len()].copy_from_slice(&bytes[range]);
            u64::from_le_bytes(le)
        };
        if !imc::crc16(&bytes[..CHECKED_BYTES]) != number(CHECKED_BYTES..ARRIVAL_BYTES) as u16 {
            return None;
        }
        let (offset, flags) = (number(0..6), bytes[6]);
        let link = LinkSeq { stream: number(22..30), seq: number(14..22) };
        if flags & JUMP != 0 {
            return Some(Self::Jump { offset, after: link });
        }
        // The seventh byte carries the sign.
        let received_us = ((number(7..14) << 8) as i64) >> 8;
        Some(Self::Packet(Arrival {
            offset,
            received: UtcTime::from_micros(received_us),
            transport: Transport::from_code(flags & 0x0F)?,
            link: (flags & HAS_LINK != 0).then_some(link),
            first: flags & FIRST != 0,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_come_back_and_damage_does_not() {
        for record in [
            Record::Packet(Arrival {
                offset: 0x1234_5678_9ABC,
                received: UtcTime::from_micros(1_795_246_989_820_647),
                transport: Transport::Link,
                link: Some(LinkSeq { stream: u64::MAX, seq: 1 << 40 }),
                first: true,
            }),
            Record::Packet(Arrival {
                offset: 0,
                received: UtcTime::from_micros(-1),
                transport: Transport::Recovered,
                link: None,
                first: false,
            }),
            Record::Jump { offset: 7, after: LinkSeq { stream: 3, seq: 4 } },
        ] {
            let mut bytes = Vec::new();
            record.write(&mut bytes);
            let bytes: [u8; ARRIVAL_BYTES] = bytes.try_into().unwrap();
            assert_eq!(Record::read(&bytes), Some(record));
            for bit in 0..ARRIVAL_BYTES * 8 {
                let mut damaged = bytes;
                damaged[bit / 8] ^= 1 << (bit % 8);
                assert_eq!(Record::read(&damaged), None, "bit {bit}");
            }
        }
        // A record after power loss.
        assert_eq!(Record::read(&[0; ARRIVAL_BYTES]), None);
    }
}
