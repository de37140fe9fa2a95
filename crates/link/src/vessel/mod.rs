//! The vessel's end of the link.

mod chart;
mod frames;
mod lanes;
mod machine;
mod records;
mod up;
mod way;

pub use chart::ChartAboard;
pub use machine::Vessel;

use crate::clocks::ClockEstimate;
use crate::frame::{ChartDigest, ChartOffer, Gap, Lease, Receipt};
use crate::ways::{WaySettings, WaysReport};
use crate::{ConnectionId, Latency, Record};
use bytes::Bytes;
use std::time::Duration;
use units::MonoTime;

/// The settings of a vessel's end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VesselSettings {
    /// IMC address of the vessel.
    pub address: u16,
    /// The vessel's name.
    pub name: String,
    /// Program and version.
    pub software: String,
    /// Counts the starts of the program with this spool: of a stream the shore takes the connection of the latest
    /// start. (Not the time: a Raspberry Pi starts in the past.)
    pub incarnation: u64,
    /// Where chance comes from: pauses between attempts differ by it.
    pub seed: u64,
    /// Bytes a second that may be sent over time, live values before records; `None` for no bound.
    pub budget_bytes_per_s: Option<u32>,
    /// The spool when the program starts.
    pub spool: SpoolState,
    /// The ways to the shore, the first tried first; at most [`MOST_WAYS`](crate::MOST_WAYS). None stands for one without
    /// a name.
    pub ways: Vec<WaySettings>,
}

/// The contents of the spool. Its driver reports changes by [`VesselInput::Spool`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpoolState {
    /// The stream whose numbers count.
    pub stream: u64,
    /// The oldest number still there.
    pub first: u64,
    /// The number that the next packet will get.
    pub next: u64,
}

/// The spool's entry under a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Entry {
    /// A packet.
    Record(Record),
    /// Numbers without packets.
    Gap(Gap),
}

impl Entry {
    /// The number after it.
    pub fn end(&self) -> u64 {
        match self {
            Self::Record(record) => record.seq.saturating_add(1),
            Self::Gap(gap) => gap.to,
        }
    }
}

/// Why an attempt at a connection failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// No answer, or the connection broke before it was open. Tried again within a second.
    Unanswered,
    /// The server refused: wrong token, wrong address. Tried again after longer and longer pauses.
    Refused,
}

/// The outcome of a delivered command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// It was handed on.
    Received,
    /// It waited too long before it could be.
    Expired,
    /// It was refused, and why.
    Refused(String),
}

/// An input of the vessel's end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VesselInput {
    /// Only time has passed.
    Timer,
    /// The spool grew, lost or forgot something.
    Spool(SpoolState),
    /// Whether the disk refuses what is to be spooled: the live lane continues without records.
    SpoolRefused(bool),
    /// The spool's records from this number on, as requested. Empty when it cannot be read: it is asked again
    /// after a second.
    Entries(u64, Vec<Entry>),
    /// A packet for the live lane.
    Live(Bytes),
    /// The requested connection is open.
    Opened(ConnectionId),
    /// The connection asked for could not be made.
    Failed(ConnectionId, Failure),
    /// A message came.
    Message(ConnectionId, Bytes),
    /// The connection broke.
    Closed(ConnectionId),
    /// An attempt by the way of this place has carried so many bytes, whether it was made or not: its greeting and its TLS.
    Handshake(usize, usize),
    /// The outcome of a command.
    Answer(u64, Answer),
    /// The chart aboard, at the start and whenever it changes. Until the first the shore is informed that
    /// no chart is accepted.
    ChartAboard(ChartAboard),
    /// So many bytes of this chart are aboard: the next part is wanted.
    ChartGoOn(ChartDigest, u64),
    /// This chart is aboard as a whole, and is what its digest says.
    ChartKept(ChartDigest),
    /// This chart cannot be taken, and why. It is begun again after a pause, longer each time.
    ChartFailed(ChartDigest, String),
    /// The program ends: the connection is closed and no other is made.
    Shutdown,
}

/// An output of the vessel's end, to be carried out in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VesselOutput {
    /// Connect by the way of this place; answer with `Opened` or `Failed` within this time.
    Open(ConnectionId, usize, Duration),
    /// Send a message.
    Send(ConnectionId, Bytes),
    /// Close the connection, or stop the attempt, without waiting for anything. A reason for the log.
    Close(ConnectionId, String),
    /// Answer with [`VesselInput::Entries`] from this number on: consecutive entries of about so many bytes, at
    /// least one.
    Need(u64, usize),
    /// Everything below this number is durable ashore and may be forgotten.
    Acknowledged(u64),
    /// The shore knows more numbers than were given out: the spool lost its end. Begin another stream and tell
    /// by [`VesselInput::Spool`].
    Renumber,
    /// Pass a packet on before this time, then answer.
    Command {
        /// Identity.
        id: u64,
        /// Epoch of the lease under which it is given; 0 for none.
        lease: u64,
        /// The number of the order ashore; 0 for none.
        order: u64,
        /// The packet.
        packet: Bytes,
        /// Too late from here on.
        expires: MonoTime,
    },
    /// A command of an order came, for the log.
    Came {
        /// Its identity.
        id: u64,
        /// The number of the order.
        order: u64,
        /// By the way of this place.
        way: usize,
        /// Whether it came before.
        again: bool,
    },
    /// A command of an order is answered, for the log.
    Answered(Receipt),
    /// Who commands the vessel.
    Lease(Lease),
    /// The shore agreed: the link is open, or open by one more way.
    Up(ConnectionId),
    /// A lane is on another way.
    Switched(WaysReport),
    /// The shore has a chart that is not aboard. Answer with [`VesselInput::ChartGoOn`] from where what is there of
    /// it ends, or with [`VesselInput::ChartKept`] or [`VesselInput::ChartFailed`].
    ChartBegin(ChartOffer),
    /// A part of the chart that was begun. Keep it, and answer as before.
    ChartPart {
        /// Of which chart.
        digest: ChartDigest,
        /// From which byte on.
        offset: u64,
        /// The bytes.
        bytes: Bytes,
    },
}

/// How the link is by all ways together, for people and series.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VesselStatus {
    /// Whether the link is open.
    pub up: bool,
    /// Records that are not known to be durable ashore.
    pub backlog: u64,
    /// Whether the record lane lags so that the live lane is used.
    pub lagging: bool,
    /// Connections opened so far.
    pub connections: u64,
    /// Bytes of messages sent.
    pub sent_bytes: u64,
    /// Kinds of packets that found no room in the live lane.
    pub live_left_out: u64,
    /// The shore's clocks, by the way that carries live values.
    pub clocks: Option<ClockEstimate>,
    /// From sending a message to knowing that it arrived.
    pub arriving: Latency,
    /// From sending a record to knowing it durable.
    pub keeping: Latency,
}
