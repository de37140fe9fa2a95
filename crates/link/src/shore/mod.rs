//! The shore's end of the link to one vessel.

mod connected;
mod down;
mod machine;

pub use machine::Shore;

use crate::clocks::ClockEstimate;
use crate::frame::{ByeCode, ChartOffer, ChartReport, ChartRequest, Commander, Gap, Hello, Receipt};
use crate::ways::WaysReport;
use crate::{ConnectionId, Latency, Record};
use bytes::Bytes;
use std::time::Duration;

/// The settings of a shore's end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShoreSettings {
    /// Bytes of records that the vessel may send before they are durable.
    pub window_bytes: u32,
    /// Another number at each start of the program, so that a vessel with several ways can distinguish its commands.
    pub run: u64,
}

impl Default for ShoreSettings {
    fn default() -> Self {
        Self { window_bytes: 4 << 20, run: 0 }
    }
}

/// An input of the shore's end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ShoreInput {
    /// Only time has passed.
    Timer,
    /// A connection was made, by a peer with this vessel's token. The number is the driver's, used once.
    Opened(ConnectionId),
    /// A message came.
    Message(ConnectionId, Bytes),
    /// The connection broke.
    Closed(ConnectionId),
    /// The answer to [`ShoreOutput::Hello`]: the highest number of the stream below which, itself included,
    /// everything is durable; `None` for nothing.
    Resume(ConnectionId, Option<u64>),
    /// The other answer: this vessel may not.
    Refuse(ConnectionId, String),
    /// Everything of this stream up to this number, itself included, is durable. A gap counts as durable when
    /// what is kept of it is.
    Durable {
        /// The stream.
        stream: u64,
        /// The number.
        seq: u64,
    },
    /// A packet to deliver to the vessel.
    Command {
        /// Identity, never used before for this vessel, not even by an earlier start of the program.
        id: u64,
        /// Delivered within this time or not at all. More than a day is cut to a day.
        ttl: Duration,
        /// Epoch of the lease under which it is given; 0 for none.
        lease: u64,
        /// The number of the order ashore, by which logs name it; 0 for none. An order that is given again has the same under
        /// another identity.
        order: u64,
        /// Whether it is a stop: what was given before it and has no answer yet is not sent any more, as it would be
        /// carried out after the stop that was meant to end it.
        overtakes: bool,
        /// The packet.
        packet: Bytes,
    },
    /// Who commands the vessel from now on. Sent to the vessel now and on every connection, and repeated while the
    /// lease is held.
    Lease(Commander),
    /// The chart that vessels are to have; `None` for none. Offered to the vessel now and on every connection.
    Chart(Option<ChartOffer>),
    /// The answer to [`ShoreOutput::ChartPart`]: the bytes; `None` where the chart is not there any more.
    ChartPart(ConnectionId, ChartRequest, Option<Bytes>),
    /// The program ends.
    Shutdown,
}

/// An output of the shore's end, to be carried out in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ShoreOutput {
    /// Send a message.
    Send(ConnectionId, Bytes),
    /// Close the connection after what was sent before. A reason for the log.
    Close(ConnectionId, ByeCode, String),
    /// A vessel greets: look up what is durable and answer by [`ShoreInput::Resume`] or
    /// [`ShoreInput::Refuse`].
    Hello(ConnectionId, Box<Hello>),
    /// The link is open over this connection; it may be open over others already.
    Up(ConnectionId),
    /// The link is closed: no connection is open any more.
    Down,
    /// Packets to keep, with consecutive numbers that follow the previous ones; report when they are durable.
    Records {
        /// Their stream.
        stream: u64,
        /// The packets.
        records: Vec<Record>,
    },
    /// Numbers that will never come, following the previous ones; report when that is durable.
    Gap {
        /// Their stream.
        stream: u64,
        /// Which, and why.
        gap: Gap,
    },
    /// Packets that are the latest of their kind. They come as records too; they are not to be kept.
    Live(Vec<Record>),
    /// The outcome of a command; given once for each.
    Outcome(u64, Outcome),
    /// A command of an order went over a connection, for the log.
    Sent {
        /// Its identity.
        id: u64,
        /// The number of the order.
        order: u64,
        /// Over which connection.
        over: ConnectionId,
        /// How often it was sent by now, over all connections.
        times: u32,
    },
    /// A receipt of a command of an order that nothing waits for, for the log: one that came by several ways, or of an earlier
    /// start of this program.
    Stray(Receipt),
    /// The vessel wants a part of the chart that was offered: answer by [`ShoreInput::ChartPart`]. One at a time.
    ChartPart(ConnectionId, ChartRequest),
    /// The vessel's report of its chart.
    ChartReport(ChartReport),
    /// The vessel's report of its ways.
    Ways(WaysReport),
}

/// The outcome of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The vessel's program has it.
    Received,
    /// It was not delivered in time and never will be.
    Expired,
    /// It was refused, and why: by the vessel, or here because too many wait or its identity is taken.
    Refused(String),
    /// It was sent and the vessel did not report its outcome.
    Unanswered,
}

/// The vessel's report of its own side, and of what is not delivered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PeerBacklog {
    /// Records that are spooled aboard and were not received yet.
    pub records: u64,
    /// Age of the oldest of them.
    pub waiting: Duration,
    /// From sending a record to the vessel knowing it durable, the last time.
    pub keeping: Duration,
}

/// How the link is, for people and series.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ShoreStatus {
    /// Whether the link is open.
    pub up: bool,
    /// The vessel's clocks against ours.
    pub clocks: Option<ClockEstimate>,
    /// The last round trip.
    pub round_trip: Option<Duration>,
    /// From recording aboard to receiving here, of the records received, by the clocks compared.
    pub transit: Latency,
    /// The vessel's side.
    pub backlog: PeerBacklog,
    /// Bytes of messages received over all connections.
    pub received_bytes: u64,
    /// Records that came again after they were received.
    pub repeated: u64,
    /// Connections opened so far.
    pub connections: u64,
    /// Open connections.
    pub standing: u32,
}
