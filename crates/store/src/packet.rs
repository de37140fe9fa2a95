//! Input of a store, and its results.

use imc::PacketView;
use link::{LinkSeq, Transport};
use units::UtcTime;

/// One packet for the store.
#[derive(Debug, Clone, Copy)]
pub struct Accepted<'a> {
    /// Its bytes, from sync to checksum.
    pub packet: &'a [u8],
    /// When it came, by the shore's clock.
    pub received: UtcTime,
    /// How it came.
    pub transport: Transport,
    /// Its place in the record lane, when it came by that.
    pub link: Option<LinkSeq>,
}

/// A packet on its way into the history.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrived<'a> {
    pub(crate) view: PacketView<'a>,
    pub(crate) received_us: i64,
}

/// The result of accepting a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It will be on disk after the next commit.
    Recorded,
    /// It is there already, and nothing was added.
    Duplicate,
}

/// The result of a commit.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Committed {
    /// Packets that the archive gained.
    pub packets: u64,
    /// Bytes that the archive gained.
    pub bytes: u64,
    /// Rows that the history gained.
    pub rows: u64,
    /// The highest durable number of each stream that gained packets: what may be acknowledged.
    pub durable: Vec<LinkSeq>,
    /// Why the history does not hold all of the archive, if so: the next commits try again, and nothing is
    /// lost meanwhile.
    pub history_behind: Option<String>,
}

/// Findings and repairs when a store is opened.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Each finding in words.
    pub notes: Vec<String>,
    /// Packets that were in the archive and not yet surely in the history.
    pub replayed: u64,
}
