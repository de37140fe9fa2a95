//! The vessel link: what a vessel and the shore say to each other over connections that break.
//!
//! Two lanes go up. The *record* lane carries every packet that the vessel spooled, numbered, oldest first, and
//! keeps it until the shore has it durably; it resumes after any outage and any restart. The *live* lane carries
//! the latest value of each message while the record lane lags, so that a map is current long before the
//! backlog is through. Commands come down with an identity and a time to live and are never delivered late.
//!
//! [`Vessel`] and [`Shore`] are state machines without sockets or clocks: the driver hands in messages and the
//! time, carries out what [`Vessel::poll_output`] gives and comes back at [`Vessel::poll_timeout`]. Neither
//! holds the backlog: the vessel asks its driver for it. [`frame`] says what the bytes mean.
//!
//! # Guarantees
//!
//! - A record is sent again until the shore's driver has called it durable: none is lost between the two disks.
//! - Within a stream the shore gives each number once and in order for as long as its driver answers
//!   [`ShoreInput::Resume`] with what is durable. Records that were received but not yet durable when a
//!   connection broke come again; the store drops them by their number.
//! - What cannot be delivered is declared: a [`Gap`] says which numbers, from when to when, and why.
//! - A command is delivered at most once per start of the vessel's program, and never after its time to live by
//!   the most pessimistic reading of the clocks.
//! - The holder of the [`Lease`] is sent before the first command of every connection and repeated while it is held;
//!   the vessel's driver refuses commands of all others.
//! - The shore's sea chart is offered by its digest and fetched by the vessel, part by part, with the link's spare
//!   capacity; the transfer resumes after any cut or restart of either end. The vessel's driver checks the whole
//!   against the digest.
//!
//! A vessel with several ways to the shore keeps a connection on each; what goes by which, and how nothing is lost, doubled
//! or carried out twice on a switch, is described in [`ways`].
//!
//! It knows IMC packets and time, and nothing of sockets, disks, plans or people. A chart is bytes with a digest to it.

mod arrival;
mod backoff;
mod batch;
mod clocks;
mod commands;
pub mod frame;
mod latency;
mod live;
mod pace;
mod shore;
mod vessel;
pub mod ways;
mod wire;

pub use arrival::{LinkSeq, Transport};
pub use batch::{MAX_BATCH_RAW_BYTES, Packer, Record, pack, unpack};
pub use clocks::ClockEstimate;
pub use frame::{
    ByeCode, Capabilities, ChartDigest, ChartOffer, ChartReport, ChartRequest, ChartStage, Commander, Gap,
    GapReason, Hello, Lease, MAX_MESSAGE_BYTES, Receipt, VERSION, Verdict,
};
pub use latency::Latency;
pub use shore::{Outcome, PeerBacklog, Shore, ShoreInput, ShoreOutput, ShoreSettings, ShoreStatus};
pub use vessel::{
    Answer, ChartAboard, Entry, Failure, SpoolState, Vessel, VesselInput, VesselOutput, VesselSettings,
    VesselStatus,
};
pub use ways::{
    MOST_WAY_NAME_BYTES, MOST_WAYS, Thinning, Used, WayHello, WayReport, WaySettings, WayState, WaysReport,
    Why,
};
pub use wire::DecodeError;

use std::time::Duration;

/// A heartbeat is sent this often, each way.
pub const HEARTBEAT: Duration = Duration::from_secs(1);
/// A peer that sent nothing for so long is gone: its connection is closed without waiting for TCP.
pub const DEAD_AFTER: Duration = Duration::from_secs(3);
/// A greeting that is not answered in this time is abandoned.
pub const GREETING_WITHIN: Duration = Duration::from_secs(5);

/// One attempt at a connection, by a number that its driver or session gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ConnectionId(pub u64);
