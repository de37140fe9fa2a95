//! The header that every packet starts with, and a view of a packet that decodes nothing.
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 2 | sync, 0xFE54: `54 FE` means little-endian, `FE 54` big-endian |
//! | 2 | 2 | message id |
//! | 4 | 2 | payload bytes |
//! | 6 | 8 | time, seconds since 1970-01-01 UTC, a double |
//! | 14 | 2 | source address |
//! | 16 | 1 | source entity |
//! | 17 | 2 | destination address |
//! | 19 | 1 | destination entity |
//! | 20 | size | payload |
//! | 20 + size | 2 | CRC-16 of everything before |

use crate::address::Address;
use crate::catalogue::{self, MessageDesc};
use crate::crc;
use crate::wire::ByteOrder;
use units::UtcTime;

/// The number that every packet starts with: IMC 5.4. (5.2, 5.3 and 5.5 have others and are refused.)
pub const SYNC: u16 = 0xFE54;
/// Bytes before the payload.
pub const HEADER_BYTES: usize = 20;
/// Bytes after the payload.
pub const FOOTER_BYTES: usize = 2;
/// Most bytes a payload can have.
pub const MAX_PAYLOAD_BYTES: usize = 65_535;
/// Most bytes a packet can have.
pub const MAX_PACKET_BYTES: usize = HEADER_BYTES + MAX_PAYLOAD_BYTES + FOOTER_BYTES;
/// The entity that means "none in particular".
pub const ANY_ENTITY: u8 = 255;

/// Sender, receiver and time of a packet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// Seconds since 1970-01-01 UTC by the sender's clock. Not ordered between the tasks of a sender.
    pub timestamp: f64,
    /// The sender.
    pub src: Address,
    /// The part of the sender.
    pub src_ent: u8,
    /// The receiver.
    pub dst: Address,
    /// The part of the receiver.
    pub dst_ent: u8,
}

impl Default for Header {
    /// Without source, to all, in 1970.
    fn default() -> Self {
        Self {
            timestamp: 0.0,
            src: Address::NULL,
            src_ent: ANY_ENTITY,
            dst: Address::NULL,
            dst_ent: ANY_ENTITY,
        }
    }
}

impl Header {
    /// The time to the nearest microsecond; `None` when it is not a time.
    pub fn time(&self) -> Option<UtcTime> {
        UtcTime::from_seconds(self.timestamp)
    }
}

/// Why bytes are not one packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// The first two bytes are not a sync number.
    #[error("bad sync {:02x} {:02x}, expected 54 fe or fe 54", found[0], found[1])]
    BadSync {
        /// The first two bytes.
        found: [u8; 2],
    },
    /// The packet continues after the last byte.
    #[error("truncated: {have} of {need} bytes")]
    Truncated {
        /// Bytes that the packet needs, as far as known.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
    /// The checksum does not match.
    #[error("bad CRC {stated:#06x}, the bytes give {computed:#06x}")]
    BadCrc {
        /// The checksum in the packet.
        stated: u16,
        /// The checksum of its bytes.
        computed: u16,
    },
}

impl FrameError {
    /// A stable word for machines.
    pub fn class(&self) -> &'static str {
        match self {
            Self::BadSync { .. } => "bad_sync",
            Self::Truncated { .. } => "truncated",
            Self::BadCrc { .. } => "bad_crc",
        }
    }
}

/// A packet in place: its header can be read and its bytes passed on without decoding or copying.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PacketView<'a> {
    bytes: &'a [u8],
    order: ByteOrder,
}

impl<'a> PacketView<'a> {
    /// The packet that `bytes` start with, after checking sync, length and CRC. Bytes behind it are left.
    ///
    /// # Errors
    /// When there is no whole, undamaged packet at the start.
    #[inline]
    pub fn new(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let view = Self::unchecked(bytes)?;
        let (stated, computed) = (view.stated_crc(), crc::crc16(view.covered()));
        if stated == computed { Ok(view) } else { Err(FrameError::BadCrc { stated, computed }) }
    }

    /// As [`Self::new`] without the CRC: for bytes that were checked before.
    ///
    /// # Errors
    /// When the sync is wrong or bytes are missing.
    #[inline]
    pub fn unchecked(bytes: &'a [u8]) -> Result<Self, FrameError> {
        let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
            return Err(Self::cut(bytes));
        };
        let order = order([header[0], header[1]])?;
        let need = HEADER_BYTES + usize::from(number(order, [header[4], header[5]])) + FOOTER_BYTES;
        match bytes.get(..need) {
            Some(bytes) => Ok(Self { bytes, order }),
            None => Err(FrameError::Truncated { need, have: bytes.len() }),
        }
    }

    /// A packet whose bytes were found to be one.
    #[inline]
    pub(crate) fn checked_before(bytes: &'a [u8], order: ByteOrder) -> Self {
        Self { bytes, order }
    }

    /// Less than a header: truncated, unless its start is wrong already.
    #[cold]
    fn cut(bytes: &[u8]) -> FrameError {
        if let Some(sync) = bytes.first_chunk::<2>()
            && let Err(error) = order(*sync)
        {
            return error;
        }
        FrameError::Truncated { need: HEADER_BYTES + FOOTER_BYTES, have: bytes.len() }
    }

    /// The whole packet.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The sender's byte order.
    pub fn order(&self) -> ByteOrder {
        self.order
    }

    /// Message id.
    #[inline]
    pub fn id(&self) -> u16 {
        self.u16_at(2)
    }

    /// Its message in the catalogue; `None` where that lacks it, or where the size says that by this id another message is meant
    /// (see [`catalogue::by_id_and_size`]).
    #[inline]
    pub fn desc(&self) -> Option<&'static MessageDesc> {
        catalogue::by_id_and_size(self.id(), self.payload().len())
    }

    /// Seconds since 1970-01-01 UTC by the sender's clock.
    #[inline]
    pub fn timestamp(&self) -> f64 {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&self.bytes[6..14]);
        match self.order {
            ByteOrder::Little => f64::from_le_bytes(bytes),
            ByteOrder::Big => f64::from_be_bytes(bytes),
        }
    }

    /// The sender.
    #[inline]
    pub fn src(&self) -> Address {
        Address(self.u16_at(14))
    }

    /// The part of the sender.
    #[inline]
    pub fn src_ent(&self) -> u8 {
        self.bytes[16]
    }

    /// The receiver.
    #[inline]
    pub fn dst(&self) -> Address {
        Address(self.u16_at(17))
    }

    /// The part of the receiver.
    #[inline]
    pub fn dst_ent(&self) -> u8 {
        self.bytes[19]
    }

    /// All of the above.
    pub fn header(&self) -> Header {
        Header {
            timestamp: self.timestamp(),
            src: self.src(),
            src_ent: self.src_ent(),
            dst: self.dst(),
            dst_ent: self.dst_ent(),
        }
    }

    /// The bytes between header and checksum.
    #[inline]
    pub fn payload(&self) -> &'a [u8] {
        &self.bytes[HEADER_BYTES..self.bytes.len() - FOOTER_BYTES]
    }

    /// The bytes that the checksum covers.
    fn covered(&self) -> &'a [u8] {
        &self.bytes[..self.bytes.len() - FOOTER_BYTES]
    }

    /// The checksum that the packet states.
    pub(crate) fn stated_crc(&self) -> u16 {
        self.u16_at(self.bytes.len() - FOOTER_BYTES)
    }

    #[inline]
    fn u16_at(&self, at: usize) -> u16 {
        number(self.order, [self.bytes[at], self.bytes[at + 1]])
    }
}

/// The byte order that a sync number shows.
#[inline]
pub(crate) fn order(sync: [u8; 2]) -> Result<ByteOrder, FrameError> {
    if sync == SYNC.to_le_bytes() {
        Ok(ByteOrder::Little)
    } else if sync == SYNC.to_be_bytes() {
        Ok(ByteOrder::Big)
    } else {
        Err(FrameError::BadSync { found: sync })
    }
}

#[inline]
fn number(order: ByteOrder, bytes: [u8; 2]) -> u16 {
    match order {
        ByteOrder::Little => u16::from_le_bytes(bytes),
        ByteOrder::Big => u16::from_be_bytes(bytes),
    }
}
