//! The peers that packets come from and go to.

use std::net::SocketAddrV4;

/// The peer that a packet came from or goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Peer {
    /// A UDP socket.
    Udp(SocketAddrV4),
    /// A TCP connection, by a number the shell gave it ([`Peer::number`]).
    Tcp(u32),
}

/// Servers of streams that a system can have.
pub const SERVERS: u8 = 8;
/// The upper bits of a connection's number are its server.
const SERVER_SHIFT: u32 = 29;

impl Peer {
    /// The number of the `count`th connection to the `server`th server of the configuration, both from 0. Counts
    /// start again after 2²⁹, servers after [`SERVERS`].
    pub fn number(server: u8, count: u32) -> u32 {
        (u32::from(server % SERVERS) << SERVER_SHIFT) | (count & ((1 << SERVER_SHIFT) - 1))
    }

    /// The server that a connection came to.
    pub fn server(self) -> Option<usize> {
        match self {
            Self::Udp(_) => None,
            Self::Tcp(number) => Some((number >> SERVER_SHIFT) as usize),
        }
    }
}
