//! Records of arrival as columns: what differs little from record to record stands side by side, so that zstd makes a few
//! bytes of each record's 32.
//!
//! A block begins with a byte. 0: the records follow as they are. 1: columns follow, each of all records before the next:
//! the flags, then as differences to the record before (zigzag, LEB128) offset, arrival, stream, number. Sums are
//! reckoned anew. What would not come back byte for byte, such as a damaged record, is kept as it is.

use super::super::ARRIVAL_BYTES;
use super::table::damaged;
use std::io;

const PLAIN: u8 = 0;
const COLUMNS: u8 = 1;
/// Bytes of a record that its sum covers.
const SUMMED_BYTES: usize = ARRIVAL_BYTES - 2;

/// The fields of a record that are numbers, as places in its bytes.
const FIELDS: [std::ops::Range<usize>; 4] = [0..6, 7..14, 22..30, 14..22];
const FLAGS_AT: usize = 6;

/// Records as a block.
pub(super) fn encode(plain: &[u8]) -> Vec<u8> {
    let columns = columns(plain);
    let mut back = Vec::with_capacity(plain.len());
    if columns.len() <= plain.len() && decode(&columns, plain.len(), &mut back).is_ok() && back == plain {
        return columns;
    }
    let mut block = Vec::with_capacity(plain.len() + 1);
    block.push(PLAIN);
    block.extend_from_slice(plain);
    block
}

fn columns(plain: &[u8]) -> Vec<u8> {
    let (records, _) = plain.as_chunks::<ARRIVAL_BYTES>();
    let mut block = Vec::with_capacity(records.len() * 8 + 1);
    block.push(COLUMNS);
    block.extend(records.iter().map(|record| record[FLAGS_AT]));
    for field in FIELDS {
        let mut before = 0_u64;
        for record in records {
            let mut le = [0; 8];
            le[..field.len()].copy_from_slice(&record[field.clone()]);
            let value = u64::from_le_bytes(le);
            let difference = value.wrapping_sub(before).cast_signed();
            write_varint(((difference << 1) ^ (difference >> 63)).cast_unsigned(), &mut block);
            before = value;
        }
    }
    block
}

/// The `plain_bytes` bytes of records that a block was made of, behind what `out` holds.
///
/// # Errors
/// The block is damaged.
pub(super) fn decode(block: &[u8], plain_bytes: usize, out: &mut Vec<u8>) -> io::Result<()> {
    let bad = || damaged("a block of records is damaged");
    let (kind, mut rest) = block.split_first().ok_or_else(bad)?;
    if *kind == PLAIN {
        if rest.len() != plain_bytes {
            return Err(bad());
        }
        out.extend_from_slice(rest);
        return Ok(());
    }
    let count = plain_bytes / ARRIVAL_BYTES;
    if *kind != COLUMNS || !plain_bytes.is_multiple_of(ARRIVAL_BYTES) || rest.len() < count {
        return Err(bad());
    }
    let start = out.len();
    out.resize(start + plain_bytes, 0);
    let (records, _) = out[start..].as_chunks_mut::<ARRIVAL_BYTES>();
    for (record, flags) in records.iter_mut().zip(rest) {
        record[FLAGS_AT] = *flags;
    }
    rest = &rest[count..];
    for field in FIELDS {
        let mut value = 0_u64;
        for record in &mut *records {
            let zigzag = read_varint(&mut rest).ok_or_else(bad)?;
            let difference = (zigzag >> 1) ^ (zigzag & 1).wrapping_neg();
            value = value.wrapping_add(difference);
            record[field.clone()].copy_from_slice(&value.to_le_bytes()[..field.len()]);
        }
    }
    if !rest.is_empty() {
        return Err(bad());
    }
    for record in records {
        let sum = !imc::crc16(&record[..SUMMED_BYTES]);
        record[SUMMED_BYTES..].copy_from_slice(&sum.to_le_bytes());
    }
    Ok(())
}

fn write_varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn read_varint(from: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (byte, rest) = from.split_first()?;
        *from = rest;
        value |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::super::arrival::{Arrival, Record};
    use super::*;
    use link::{LinkSeq, Transport};
    use proptest::prelude::*;
    use units::UtcTime;

    fn back(block: &[u8], plain_bytes: usize) -> Vec<u8> {
        let mut out = Vec::new();
        decode(block, plain_bytes, &mut out).unwrap();
        out
    }

    #[test]
    fn records_of_a_vessel_take_few_bytes() {
        let mut plain = Vec::new();
        for number in 0..1_000_u64 {
            Record::Packet(Arrival {
                offset: number * 48,
                received: UtcTime::from_micros(1_795_248_000_000_000 + number as i64 * 900),
                transport: Transport::Link,
                link: Some(LinkSeq { stream: 0xFEDC_BA98_7654_3210, seq: 5 + number }),
                first: number == 0,
            })
            .write(&mut plain);
        }
        let block = encode(&plain);
        assert!(block.len() < 7 * 1_000, "{} bytes", block.len());
        assert_eq!(back(&block, plain.len()), plain);
    }

    proptest! {
        #[test]
        fn whatever_the_bytes_are_they_come_back(plain in prop::collection::vec(any::<u8>(), 0..400), mend in any::<bool>()) {
            let mut plain = plain;
            if mend {
                let (records, _) = plain.as_chunks_mut::<ARRIVAL_BYTES>();
                for record in records {
                    let sum = !imc::crc16(&record[..SUMMED_BYTES]);
                    record[SUMMED_BYTES..].copy_from_slice(&sum.to_le_bytes());
                }
            }
            let block = encode(&plain);
            prop_assert!(block.len() <= plain.len() + 1);
            prop_assert_eq!(back(&block, plain.len()), plain);
        }

        #[test]
        fn whatever_stands_in_a_block_nothing_panics(block in prop::collection::vec(any::<u8>(), 0..200), records in 0_usize..9) {
            let mut out = Vec::new();
            decode(&block, records * ARRIVAL_BYTES, &mut out).ok();
        }
    }
}
