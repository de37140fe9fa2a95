//! What comes into a store and what it answers.

use units::UtcTime;

/// How a packet came ashore.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Door {
    /// Found in the archive without a record of its arrival, after a crash or the loss of the sidecar.
    Recovered = 0,
    /// The vessel link's record lane.
    Link = 1,
    /// The IMCProxy protocol.
    Proxy = 2,
    /// UDP of an IMC node.
    Udp = 3,
    /// TCP of an IMC node.
    Tcp = 4,
    /// A log that was imported.
    Import = 5,
    /// The shore itself: commands and other packets made here.
    Local = 6,
}

impl Door {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Recovered, Self::Link, Self::Proxy, Self::Udp, Self::Tcp, Self::Import, Self::Local];

    /// A stable word for machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Recovered => "recovered",
            Self::Link => "link",
            Self::Proxy => "proxy",
            Self::Udp => "udp",
            Self::Tcp => "tcp",
            Self::Import => "import",
            Self::Local => "local",
        }
    }

    pub(crate) fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Whether the same telemetry comes in copies through this door, one for each receiver, that differ in
    /// nothing but their destination.
    pub(crate) fn brings_copies(self) -> bool {
        matches!(self, Self::Proxy | Self::Udp)
    }
}

/// The place of a packet in a vessel's record lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinkSeq {
    /// The run of numbers; a vessel starts another one when it lost its spool.
    pub stream: u64,
    /// The number, rising within a stream. Numbers may be left out (what was declared lost), never go back.
    pub seq: u64,
}

/// One packet for the store.
#[derive(Debug, Clone, Copy)]
pub struct Accepted<'a> {
    /// Its bytes, from sync to checksum.
    pub packet: &'a [u8],
    /// When it came, by the shore's clock.
    pub received: UtcTime,
    /// How it came.
    pub door: Door,
    /// Its place in the record lane, when it came by that.
    pub link: Option<LinkSeq>,
}

/// What became of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It will be on disk after the next commit.
    Recorded,
    /// It is there already, and nothing was added.
    Duplicate,
}

/// What a commit put on disk.
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

/// What opening a store found and mended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Each thing in words.
    pub notes: Vec<String>,
    /// Packets that were in the archive and not yet surely in the history.
    pub replayed: u64,
}
