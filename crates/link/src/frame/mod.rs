//! The wire format of the link's messages.
//!
//! A message (one of a WebSocket) is a row of frames. All numbers are little-endian.
//!
//! | bytes | field |
//! |---|---|
//! | 1 | type |
//! | 4 | length of the body |
//! | length | body |
//!
//! A frame of an unknown type is skipped by its length, and bytes behind the fields that a version knows are
//! ignored: so later versions can add frames and fields. Bodies:
//!
//! | type | frame | from | body |
//! |---|---|---|---|
//! | 1 | Hello | vessel | `LLNK`, version u16, oldest version u16, capabilities u32, address u16, incarnation u64, attempt u64, stream u64, first u64, next u64, stamp, name, software |
//! | 2 | Welcome | shore | version u16, capabilities u32, resume u64, window u32, stamp |
//! | 3 | Records | vessel | batch |
//! | 4 | Live | vessel | batch |
//! | 5 | Gap | vessel | from u64, to u64, since i64, until i64, reason u8 |
//! | 6 | Ack | shore | received u64, durable u64, bytes u64 |
//! | 7 | Command | shore | id u64, sent u64, time to live u32 (ms), lease u64, packet |
//! | 8 | Receipt | vessel | id u64, outcome u8, text |
//! | 9 | Heartbeat | both | stamp, bytes u64, next u64, durable u64, waiting u64 (µs), kept u64 (µs) |
//! | 10 | Bye | both | code u8, text |
//! | 11 | Lease | shore | epoch u64, time to live u32 (ms), holder |
//! | 12 | Chart | shore | digest (32), bytes u64, edition |
//! | 13 | Chart ask | vessel | digest (32), offset u64, length u32 |
//! | 14 | Chart part | shore | digest (32), offset u64, raw bytes u32, method u8, data to the end of the frame |
//! | 15 | Chart report | vessel | digest held (32), edition, stage u8, bytes aboard u64, of u64, text |
//! | 16 | Ways | vessel | choice u64, way of live values u8, why u8, way of records u8, why u8, count u8, ways |
//! | 17 | Command of an order | shore | id u64, sent u64, time to live u32 (ms), lease u64, order u64, packet |
//!
//! A Command of an order is sent in place of a Command where both have [`Capabilities::ORDERS`]. A Receipt of it ends with the
//! order u64.
//!
//! Where both have [`Capabilities::WAYS`], a Hello ends with the way: place u8, flags u8 (1 metered), name; a Welcome with the
//! number of the shore's start u64; a Lease with its number u64; and Live batches are numbered by their first. A place of 255 is
//! none. Each of the ways is: flags u8 (1 metered), state u8 (0 down, 1 suspect, 2 up), thinning u8, late u16 (per mille), round
//! trip u32 (µs), rate u32 (B/s), failures u32, bytes today u64, of u64, name.
//!
//! A stamp is: steady time u64, UTC i64, echo u64, echo received u64, all in µs. A batch is: first u64, base time
//! i64, count u32, raw bytes u32, method u8 (0 plain, 1 zstd), data to the end of the frame. Texts have their
//! length in a u16.

mod chart;
mod read;
mod write;

pub use crate::batch::Batch;
pub use chart::{ChartDigest, ChartOffer, ChartPart, ChartReport, ChartRequest, ChartStage, MAX_PART_BYTES};
pub use read::{Frames, decode};
pub use write::{encode, message};

use crate::ways::{WayHello, WaysReport};
use bytes::Bytes;
use units::{MonoTime, UtcTime};

/// The version of this description.
pub const VERSION: u16 = 2;
/// The oldest version that is still accepted. Version 1 knew no leases: a vessel that cannot distinguish two holders
/// must not be commanded.
pub const OLDEST_VERSION: u16 = 2;
/// Most bytes of a message. A transport should refuse larger ones before they are in memory.
pub const MAX_MESSAGE_BYTES: usize = 1 << 20;
/// Most bytes of a text.
pub const MAX_TEXT_BYTES: usize = 200;

/// Stands for no way where a place of one is expected.
const NO_WAY: u8 = u8::MAX;

/// Optional capabilities of a peer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities(pub u32);

impl Capabilities {
    /// Unpacks zstd.
    pub const ZSTD: Self = Self(1);
    /// Knows the live lane.
    pub const LIVE: Self = Self(2);
    /// Knows commands.
    pub const COMMANDS: Self = Self(4);
    /// Knows the chart's frames: a vessel reports what it holds and requests, a shore offers and sends.
    pub const CHARTS: Self = Self(8);
    /// Keeps several connections in parallel, one for each way.
    pub const WAYS: Self = Self(16);
    /// Knows the numbers that orders have ashore.
    pub const ORDERS: Self = Self(32);
    /// All capabilities of this version.
    pub const ALL: Self = Self(63);
    /// The capabilities that a vessel with one way asks for.
    pub const OF_ONE_WAY: Self = Self(47);

    /// The capabilities of both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether all of `other` is among them.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Frame {
    /// The vessel begins.
    Hello(Hello),
    /// The shore agrees.
    Welcome(Welcome),
    /// Packets of the record lane.
    Records(Batch),
    /// Packets of the live lane; numbers mean nothing here.
    Live(Batch),
    /// Numbers that will never come.
    Gap(Gap),
    /// How far the shore has come.
    Ack(Ack),
    /// A packet to deliver in time.
    Command(Command),
    /// The outcome of a command.
    Receipt(Receipt),
    /// The sender lives.
    Heartbeat(Heartbeat),
    /// The sender closes the connection.
    Bye(Bye),
    /// Who commands the vessel.
    Lease(Lease),
    /// The chart that the shore has.
    Chart(ChartOffer),
    /// The vessel wants a part of it.
    ChartRequest(ChartRequest),
    /// A part of it.
    ChartPart(ChartPart),
    /// The chart that the vessel holds.
    ChartReport(ChartReport),
    /// How the vessel's ways are, and which carries what.
    Ways(WaysReport),
}

/// Clocks for the other side to compare with its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// The sender's steady clock.
    pub mono: MonoTime,
    /// The sender's UTC at the same moment.
    pub utc: UtcTime,
    /// `mono` of the last stamp that the sender received; zero for none.
    pub echo: MonoTime,
    /// The sender's steady clock when it received that.
    pub echo_received: MonoTime,
}

/// The vessel that connects and its records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hello {
    /// The version wished for, the sender's newest.
    pub version: u16,
    /// The oldest version that the sender supports.
    pub oldest_version: u16,
    /// The sender's capabilities.
    pub capabilities: Capabilities,
    /// IMC address of the vessel.
    pub address: u16,
    /// Counts the starts of the vessel's program with this stream.
    pub incarnation: u64,
    /// Counts connections of this incarnation.
    pub attempt: u64,
    /// The stream whose numbers count; another begins when a spool is rebuilt.
    pub stream: u64,
    /// The oldest number that the spool still has.
    pub first: u64,
    /// The number that the next packet will get.
    pub next: u64,
    /// The vessel's clocks.
    pub stamp: Stamp,
    /// The vessel's name.
    pub name: String,
    /// Program and version.
    pub software: String,
    /// The way of this connection, where the vessel has several.
    pub way: Option<WayHello>,
}

/// The shore's side of the greeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Welcome {
    /// The version that is spoken from here on.
    pub version: u16,
    /// The capabilities of both.
    pub capabilities: Capabilities,
    /// The number to continue with: everything below is durable ashore.
    pub resume: u64,
    /// Bytes of records that the shore takes before they are durable.
    pub window_bytes: u32,
    /// The shore's clocks.
    pub stamp: Stamp,
    /// The shore's start, where both know ways: its commands are numbered upwards.
    pub run: Option<u64>,
}

/// Numbers of a stream behind which there is, or is no more, a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// The first.
    pub from: u64,
    /// The one after the last.
    pub to: u64,
    /// Not before this time by the vessel's clock, as far as known.
    pub since: UtcTime,
    /// Not after this time by the vessel's clock, as far as known.
    pub until: UtcTime,
    /// Why the records are missing.
    pub reason: GapReason,
}

/// Why packets are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum GapReason {
    /// The vessel could not record them: its disk or its queue was full.
    NotRecorded,
    /// The spool was full and they were the least important.
    SpoolFull,
    /// Power failed before they were on the disk. The numbers are an upper bound: most were never given out.
    PowerLost,
    /// The disk did not give them back as they were written.
    Damaged,
    /// The shore once acknowledged them; it must have them from then, or was restored from a backup.
    AcknowledgedBefore,
    /// The vessel's program was killed with packets that it had not spooled. One number stands for all of them: how
    /// many there were is not known.
    Killed,
    /// A reason of a later version.
    Other(u8),
}

impl GapReason {
    const NAMED: [(Self, u8, &'static str); 6] = [
        (Self::NotRecorded, 1, "not recorded"),
        (Self::SpoolFull, 2, "spool full"),
        (Self::PowerLost, 3, "power lost"),
        (Self::Damaged, 4, "damaged on disk"),
        (Self::AcknowledgedBefore, 5, "acknowledged before"),
        (Self::Killed, 6, "killed"),
    ];

    /// The number that stands for it, here and on disks.
    pub fn code(self) -> u8 {
        if let Self::Other(code) = self {
            return code;
        }
        Self::NAMED.iter().find(|(reason, ..)| *reason == self).map_or(0, |(_, code, _)| *code)
    }

    /// The reason that a number stands for.
    pub fn from_code(code: u8) -> Self {
        Self::NAMED.iter().find(|named| named.1 == code).map_or(Self::Other(code), |named| named.0)
    }
}

impl std::fmt::Display for GapReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match Self::NAMED.iter().find(|(reason, ..)| reason == self) {
            Some((.., text)) => f.write_str(text),
            None => write!(f, "reason {}", self.code()),
        }
    }
}

/// How far the shore has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ack {
    /// The number after the last that was received without holes.
    pub received: u64,
    /// The number after the last that is durable without holes.
    pub durable: u64,
    /// Bytes of messages received over this connection.
    pub bytes: u64,
}

/// A packet to deliver in time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// Identity, for the receipt and against delivering twice.
    pub id: u64,
    /// The shore's steady clock when this frame was made.
    pub sent: MonoTime,
    /// Time left then (ms).
    pub ttl_ms: u32,
    /// Epoch of the lease under which it is given; 0 for none.
    pub lease: u64,
    /// The number of the order ashore, by which the logs of both ends name it; 0 where it has none or the vessel does not know
    /// of these. An order that is given again has the same number under another identity.
    pub order: u64,
    /// The packet.
    pub packet: Bytes,
}

/// Who commands a vessel, as the shore has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Commander {
    /// Grows with every grant.
    pub epoch: u64,
    /// The holder's name; `None` when the lease has ended.
    pub holder: Option<String>,
}

/// [`Commander`] as the vessel gets it, with its life. Sent again and again while it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    /// Grows with every grant.
    pub epoch: u64,
    /// How long it is valid from its receipt unless it is repeated (ms); 0 ends it.
    pub ttl_ms: u32,
    /// Its holder, for people.
    pub holder: String,
    /// Rises with each that the shore sends, where both know ways; 0 where not.
    pub number: u64,
}

/// The outcome of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Receipt {
    /// The command.
    pub id: u64,
    /// The outcome.
    pub verdict: Verdict,
    /// Why, where it was refused.
    pub text: String,
    /// The number of the order ashore, as it came; 0 for none.
    pub order: u64,
}

/// A vessel's outcome of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It was handed on.
    Received,
    /// It came too late.
    Expired,
    /// It was refused.
    Refused,
}

impl Verdict {
    /// The word for logs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Received => "received",
            Self::Expired => "expired",
            Self::Refused => "refused",
        }
    }
}

/// The sender lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heartbeat {
    /// The sender's clocks.
    pub stamp: Stamp,
    /// From the shore: bytes of messages received over this connection.
    pub bytes: u64,
    /// From the vessel: the number that the next packet will get.
    pub next: u64,
    /// From the vessel: everything below is known to be durable ashore.
    pub durable: u64,
    /// From the vessel: age of the oldest record that was not sent yet (µs).
    pub waiting_us: u64,
    /// From the vessel: the last time from sending a record to knowing it durable (µs).
    pub kept_us: u64,
}

/// Why a connection is closed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bye {
    /// For programs.
    pub code: ByeCode,
    /// For people.
    pub text: String,
}

/// Why a connection is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByeCode {
    /// The program ends.
    Ending,
    /// No common version.
    Version,
    /// This vessel may not, with this token.
    Refused,
    /// A newer connection of the same vessel took over.
    Replaced,
    /// Bytes that mean nothing, or something at the wrong time.
    Protocol,
    /// Nothing was heard for too long.
    Silent,
    /// A reason of a later version.
    Other(u8),
}

impl ByeCode {
    const NAMED: [(Self, u8); 6] = [
        (Self::Ending, 1),
        (Self::Version, 2),
        (Self::Refused, 3),
        (Self::Replaced, 4),
        (Self::Protocol, 5),
        (Self::Silent, 6),
    ];

    fn code(self) -> u8 {
        if let Self::Other(code) = self {
            return code;
        }
        Self::NAMED.iter().find(|(named, _)| *named == self).map_or(0, |(_, code)| *code)
    }

    fn from_code(code: u8) -> Self {
        Self::NAMED.iter().find(|named| named.1 == code).map_or(Self::Other(code), |named| named.0)
    }
}
