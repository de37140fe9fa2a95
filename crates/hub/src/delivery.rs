//! A packet for a peer, and what it carries as an order: its number, lease, end of life and urgency.

use bytes::Bytes;
use units::MonoTime;

/// An order's number; grows, also over restarts. Logs ashore and aboard, audit log and pages name the order by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CommandId(pub u64);

impl std::fmt::Display for CommandId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// How urgent an order is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// Stick positions: the next ones replace them.
    Sticks,
    /// Any order but a stop.
    Command,
    /// A stop.
    Stop,
}

/// The data of an order besides its packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tag {
    /// The command that it is; none for stick positions.
    pub id: Option<CommandId>,
    /// Whether it is given beside the order itself, so that its outcome says nothing of the order's.
    pub is_copy: bool,
    /// The lease under which it is given; 0 for what takes none.
    pub epoch: u64,
    /// It is not delivered from here on.
    pub expires: MonoTime,
    /// How urgent it is.
    pub urgency: Urgency,
}

/// A packet for a peer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delivery {
    /// The packet.
    pub packet: Bytes,
    /// Its data as an order; `None` for packets that are only passed on.
    pub tag: Option<Tag>,
}

impl From<Bytes> for Delivery {
    fn from(packet: Bytes) -> Self {
        Self { packet, tag: None }
    }
}
