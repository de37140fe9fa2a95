//! From where a request comes.

use std::net::SocketAddr;

/// The other end of a connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    /// Its address, or that of the last proxy before us.
    pub(crate) address: SocketAddr,
    /// Whether the connection is encrypted up to this process.
    pub(crate) encrypted: bool,
}
