//! A connected peer: its transport, and what it may send and receive.

use imc::Address;
use link::Transport;
use units::UtcTime;

/// A connection. Numbers are never used twice in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PeerId(pub u32);

/// The packets that a peer gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// All broadcast packets, and those for the systems behind it.
    Console,
    /// Packets for the systems behind it, and broadcasts of consoles. The telemetry of other vessels
    /// would only fill its radio link.
    Vessel,
}

/// The source addresses that a peer may use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sources {
    /// Any. For transports that are bound to loopback or the VPN.
    Any,
    /// These alone; a packet of another source is refused and counted. What a vessel recorded of others is
    /// recorded here too, but neither relayed nor shown.
    Only(Vec<Address>),
}

impl Sources {
    /// Whether the peer may use the source address `source`.
    pub fn allow(&self, source: Address) -> bool {
        match self {
            Self::Any => true,
            Self::Only(list) => list.contains(&source),
        }
    }
}

/// A peer as it introduces itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Peer {
    /// How it came in.
    pub transport: Transport,
    /// The packets that it gets.
    pub role: Role,
    /// What people call it: an address and port, or the name of a token.
    pub name: String,
    /// The source addresses that it may use.
    pub sources: Sources,
}

/// A connected peer as people see it.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerState {
    /// Its number.
    pub id: PeerId,
    /// Its announcement.
    pub peer: Peer,
    /// When it came.
    pub since: UtcTime,
    /// The sources heard there, most recent last.
    pub systems: Vec<Address>,
    /// Packets that came from it.
    pub received: u64,
    /// Packets that it may not send, or that are not valid.
    pub refused: u64,
    /// Packets handed to its queue.
    pub delivered: u64,
}
