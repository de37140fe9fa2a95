//! The frames by which a vessel comes to the shore's sea chart, and the packing of their parts.

use crate::wire::DecodeError;
use bytes::Bytes;

/// Most bytes of a chart in one part.
pub const MAX_PART_BYTES: usize = 32 << 10;
/// Level of zstd: parts are small and few.
const LEVEL: i32 = 3;

/// SHA-256 of a chart's file.
pub type ChartDigest = [u8; 32];

/// The chart that the shore has for its vessels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChartOffer {
    /// Digest of the file.
    pub digest: ChartDigest,
    /// Bytes of the file; 0 where the shore has no chart.
    pub bytes: u64,
    /// Its contents, for people.
    pub edition: String,
}

impl ChartOffer {
    /// The frame of a shore without a chart.
    pub fn none() -> Self {
        Self { digest: [0; 32], bytes: 0, edition: String::new() }
    }
}

/// The vessel asks for a part of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChartRequest {
    /// Of which chart.
    pub digest: ChartDigest,
    /// From which byte on.
    pub offset: u64,
    /// So many bytes; the shore may send fewer.
    pub length: u32,
}

/// A part of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChartPart {
    /// Of which chart.
    pub digest: ChartDigest,
    /// From which byte on.
    pub offset: u64,
    /// Bytes before packing; 0 says that the shore does not have this chart any more.
    pub raw_bytes: u32,
    /// Whether the data is compressed by zstd.
    pub compressed: bool,
    /// The bytes.
    pub data: Bytes,
}

impl ChartPart {
    /// Packs a part, by zstd where the vessel unpacks it and that is shorter.
    pub fn pack(ask: &ChartRequest, raw: Bytes, zstd: bool) -> Self {
        let packed = zstd.then(|| zstd::bulk::compress(&raw, LEVEL).ok()).flatten();
        let packed = packed.filter(|packed| packed.len() < raw.len());
        let (raw_bytes, compressed) = (raw.len() as u32, packed.is_some());
        let data = packed.map_or(raw, Bytes::from);
        Self { digest: ask.digest, offset: ask.offset, raw_bytes, compressed, data }
    }

    /// The frame for a chart that no longer exists ashore.
    pub fn gone(ask: &ChartRequest) -> Self {
        Self::pack(ask, Bytes::new(), false)
    }

    /// The chart's bytes.
    ///
    /// # Errors
    /// When the part states more than is allowed, or holds something else than it states.
    pub fn unpack(&self) -> Result<Bytes, DecodeError> {
        let stated = self.raw_bytes;
        let (have, most) = (u64::from(stated), MAX_PART_BYTES as u64);
        if have > most {
            return Err(DecodeError::TooLong { what: "a part of a chart", have, most });
        }
        let raw = if self.compressed {
            let raw = zstd::bulk::decompress(&self.data, stated as usize);
            Bytes::from(raw.map_err(|_| DecodeError::BadCompression { stated })?)
        } else {
            self.data.clone()
        };
        if raw.len() == stated as usize { Ok(raw) } else { Err(DecodeError::BadCompression { stated }) }
    }
}

/// The stage of the chart's transfer to a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChartStage {
    /// Nothing: it holds the shore's, or the shore offers none.
    #[default]
    Settled,
    /// It fetches it.
    Fetching,
    /// It has all of it, which is in force as soon as that is safe.
    Waiting,
    /// It could not take it, and tries again later.
    Failed,
    /// It is set up to take none from ashore.
    Declined,
    /// Something of a later version.
    Other(u8),
}

impl ChartStage {
    const NAMED: [(Self, u8); 5] =
        [(Self::Settled, 0), (Self::Fetching, 1), (Self::Waiting, 2), (Self::Failed, 3), (Self::Declined, 4)];

    /// The number that stands for it.
    pub(super) fn code(self) -> u8 {
        if let Self::Other(code) = self {
            return code;
        }
        Self::NAMED.iter().find(|(named, _)| *named == self).map_or(0, |(_, code)| *code)
    }

    /// From its number.
    pub(super) fn from_code(code: u8) -> Self {
        Self::NAMED.iter().find(|named| named.1 == code).map_or(Self::Other(code), |named| named.0)
    }
}

/// The vessel's report of its chart.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ChartReport {
    /// Digest of the file that is in force aboard; zeros for none.
    pub held: ChartDigest,
    /// Its contents, for people.
    pub edition: String,
    /// The stage of the transfer of the shore's.
    pub stage: ChartStage,
    /// Bytes of the shore's chart that are aboard.
    pub have: u64,
    /// All its bytes.
    pub of: u64,
    /// Why it could not be taken, or is not in force yet.
    pub text: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask() -> ChartRequest {
        ChartRequest { digest: [7; 32], offset: 9, length: 100 }
    }

    #[test]
    fn parts_are_packed_where_that_is_shorter() {
        for (raw, shorter) in [(vec![5; 4_000], true), ((0..=255).collect(), false)] {
            let raw = Bytes::from(raw);
            let part = ChartPart::pack(&ask(), raw.clone(), true);
            assert_eq!((part.compressed, part.data.len() < raw.len()), (shorter, shorter));
            assert_eq!(part.unpack(), Ok(raw.clone()));
            assert!(!ChartPart::pack(&ask(), raw, false).compressed);
        }
    }

    #[test]
    fn parts_that_state_something_else_are_refused() {
        let part = ChartPart::pack(&ask(), vec![5; 4_000].into(), true);
        for raw_bytes in [3_999, 4_001, MAX_PART_BYTES as u32 + 1, u32::MAX] {
            assert!(ChartPart { raw_bytes, ..part.clone() }.unpack().is_err(), "{raw_bytes}");
        }
        assert!(ChartPart { compressed: false, ..part }.unpack().is_err());
    }
}
