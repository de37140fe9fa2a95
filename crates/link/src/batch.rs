//! Many packets as one compressed block.
//!
//! Packed: for each packet the microseconds since the previous one (the first: since the block's base time) as a
//! zigzag varint, its length as a varint, its bytes. Telemetry repeats itself, so that a block of a few dozen
//! packets takes a third to a half of its raw size.

use crate::wire::{DecodeError, Reader, put_varint, unzigzag, zigzag};
use bytes::Bytes;
use units::UtcTime;

/// Most bytes that a block may unpack to.
pub const MAX_BATCH_RAW_BYTES: usize = 512 << 10;
/// The fastest of zstd's levels with a useful ratio: a Raspberry Pi 4 packs tens of MB/s at it.
const LEVEL: i32 = 1;
/// Below this zstd's own header eats the gain.
const WORTH_PACKING_BYTES: usize = 96;

/// One packet of the record lane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Number within its stream.
    pub seq: u64,
    /// When the vessel spooled it, by the vessel's clock.
    pub recorded: UtcTime,
    /// The packet's original bytes.
    pub packet: Bytes,
}

/// A block as sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Batch {
    /// Number of the first packet; the others follow without holes. 0 and without meaning in the live lane.
    pub first: u64,
    /// The time that the first packet's is counted from.
    pub base: UtcTime,
    /// Packets.
    pub count: u32,
    /// Bytes before packing.
    pub raw_bytes: u32,
    /// Whether the data is compressed by zstd.
    pub compressed: bool,
    /// The packed packets.
    pub data: Bytes,
}

/// Packs blocks; keeps zstd's working memory between them.
pub struct Packer {
    /// `None` when the peer cannot unpack, or zstd could not start.
    zstd: Option<zstd::bulk::Compressor<'static>>,
}

impl std::fmt::Debug for Packer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Packer").field("zstd", &self.zstd.is_some()).finish()
    }
}

impl Packer {
    /// A packer that compresses, or does not.
    pub fn new(compress: bool) -> Self {
        Self { zstd: compress.then(|| zstd::bulk::Compressor::new(LEVEL).ok()).flatten() }
    }

    /// Packs packets with consecutive numbers. The caller keeps their sum below [`MAX_BATCH_RAW_BYTES`], with 16
    /// bytes to spare for each.
    pub fn pack<'a>(&mut self, first: u64, packets: impl Iterator<Item = (UtcTime, &'a [u8])>) -> Batch {
        let mut raw = Vec::new();
        let (mut count, mut base, mut before) = (0, UtcTime::default(), None);
        for (recorded, packet) in packets {
            if before.is_none() {
                base = recorded;
            }
            let since = recorded.micros().wrapping_sub(before.unwrap_or(recorded).micros());
            before = Some(recorded);
            put_varint(&mut raw, zigzag(since));
            put_varint(&mut raw, packet.len() as u64);
            raw.extend_from_slice(packet);
            count += 1;
        }
        let raw_bytes = raw.len() as u32;
        let packed = self.zstd.as_mut().filter(|_| raw.len() >= WORTH_PACKING_BYTES);
        let packed =
            packed.and_then(|zstd| zstd.compress(&raw).ok()).filter(|packed| packed.len() < raw.len());
        let compressed = packed.is_some();
        Batch { first, base, count, raw_bytes, compressed, data: packed.unwrap_or(raw).into() }
    }
}

/// Packs records with consecutive numbers; see [`Packer::pack`].
pub fn pack(packer: &mut Packer, records: &[Record]) -> Batch {
    let first = records.first().map_or(0, |record| record.seq);
    packer.pack(first, records.iter().map(|record| (record.recorded, &record.packet[..])))
}

/// The records of a block. All share the memory of the unpacked block.
///
/// # Errors
/// When the block states more than is allowed, or holds something else than it states.
pub fn unpack(batch: &Batch) -> Result<Vec<Record>, DecodeError> {
    let stated = batch.raw_bytes;
    let most = MAX_BATCH_RAW_BYTES as u64;
    if u64::from(stated) > most {
        return Err(DecodeError::TooLong { what: "unpacked records", have: u64::from(stated), most });
    }
    let raw = if batch.compressed {
        let raw = zstd::bulk::decompress(&batch.data, stated as usize);
        Bytes::from(raw.map_err(|_| DecodeError::BadCompression { stated })?)
    } else {
        batch.data.clone()
    };
    if raw.len() != stated as usize {
        return Err(DecodeError::BadCompression { stated });
    }
    // Each takes two bytes at least, so that no count makes us reserve more than half a million.
    if u64::from(batch.count) * 2 > u64::from(stated) {
        return Err(DecodeError::BadValue { what: "the count of records", value: u64::from(batch.count) });
    }
    if batch.first.checked_add(u64::from(batch.count)).is_none() {
        return Err(DecodeError::BadValue { what: "the number of a record", value: batch.first });
    }
    let mut reader = Reader::new(raw);
    let mut records = Vec::with_capacity(batch.count as usize);
    let mut recorded = batch.base.micros();
    for at in 0..batch.count {
        recorded = recorded.wrapping_add(unzigzag(reader.varint("the time of a record")?));
        let length = reader.varint("the length of a record")?;
        let most = imc::MAX_PACKET_BYTES as u64;
        if length > most {
            return Err(DecodeError::TooLong { what: "a record", have: length, most });
        }
        let packet = reader.take(length as usize, "a record")?;
        let seq = batch.first + u64::from(at);
        records.push(Record { seq, recorded: UtcTime::from_micros(recorded), packet });
    }
    if !reader.is_empty() {
        return Err(DecodeError::BadCompression { stated });
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn records_return(
            first in 0..u64::MAX / 2,
            packets in proptest::collection::vec((any::<i64>(), proptest::collection::vec(any::<u8>(), 0..300)), 0..40),
            compress: bool,
        ) {
            let records: Vec<Record> = packets.into_iter().enumerate().map(|(at, (us, packet))| Record {
                seq: first + at as u64, recorded: UtcTime::from_micros(us), packet: packet.into(),
            }).collect();
            let batch = pack(&mut Packer::new(compress), &records);
            prop_assert_eq!(unpack(&batch).unwrap(), records);
        }
    }

    #[test]
    fn telemetry_shrinks() {
        let packet = |n: u8| {
            let mut packet = vec![0x54, 0xFE, 0x5E, 1, 40, 0];
            packet.extend((0..56).map(|at| if at % 9 == 0 { n.wrapping_mul(at) } else { at }));
            Bytes::from(packet)
        };
        let record = |n: u8| Record {
            seq: u64::from(n),
            recorded: UtcTime::from_micros(1_790_000_000_000_000 + i64::from(n) * 10_000),
            packet: packet(n),
        };
        let records: Vec<Record> = (0..64).map(record).collect();
        let batch = pack(&mut Packer::new(true), &records);
        assert!(batch.compressed && batch.data.len() * 2 < batch.raw_bytes as usize, "{}", batch.data.len());
    }

    #[test]
    fn a_bomb_is_refused_by_what_it_states_and_by_what_it_holds() {
        let bomb: Bytes = zstd::bulk::compress(&vec![0; 8 << 20], 1).unwrap().into();
        let base = UtcTime::default();
        for stated in [8 << 20, 1000] {
            let batch =
                Batch { first: 0, base, count: 1, raw_bytes: stated, compressed: true, data: bomb.clone() };
            assert!(unpack(&batch).is_err());
        }
    }
}
